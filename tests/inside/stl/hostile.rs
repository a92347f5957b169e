//! The body of the fuzz target `model` over its seeds and damaged copies of them.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::model::model;

/// Flips, cuts, copies and inserts bytes.
fn damaged(seed: &[u8], rng: &mut Pcg64) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..rng.random_range(1..6) {
        let at = rng.random_range(0..bytes.len().max(1));
        match rng.random_range(0..8) {
            _ if bytes.is_empty() => return bytes,
            0 => bytes.truncate(at),
            1 => bytes.insert(at, rng.random()),
            2 => {
                let end = (at + rng.random_range(0..64)).min(bytes.len());
                bytes.extend_from_within(at..end);
            }
            _ => bytes[at] ^= 1 << rng.random_range(0..8),
        }
    }
    bytes
}

/// Turns of a small model moved to places of single precision: bodies that are nearly parts.
fn bent(seed: &[u8], rng: &mut Pcg64) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..rng.random_range(1..20) {
        let facets = (bytes.len() - 84) / 50;
        let (from, to) = (rng.random_range(0..facets), rng.random_range(0..facets));
        let corner = |facet: usize, k: usize| 84 + 50 * facet + 12 + 12 * (k % 3);
        let (a, b) = (corner(from, rng.random_range(0..3)), corner(to, rng.random_range(0..3)));
        bytes.copy_within(a..a + 12, b);
    }
    bytes
}

#[test]
fn any_bytes_are_a_part_or_an_error_that_says_something() {
    let octets = include_bytes!("../../../fuzz/seeds/model/cone.stl");
    let text = include_bytes!("../../../fuzz/seeds/model/fillet_ascii.stl");
    let mut rng = Pcg64::seed_from_u64(21);
    let (mut parts, mut refused) = (0, 0);
    for seed in [&octets[..], &text[..]] {
        assert!(model(seed));
        for _ in 0..300 {
            let count = if model(&damaged(seed, &mut rng)) { &mut parts } else { &mut refused };
            *count += 1;
        }
    }
    // a corner that is copied onto itself changes nothing
    let whole = (0..200).filter(|_| model(&bent(octets, &mut rng))).count();
    assert!(whole < 20, "{whole} of 200 with corners of other facets are turned parts");
    println!("{parts} parts, {refused} refused");
    assert!(parts > 5 && refused > 100, "{parts} parts, {refused} refused");
}
