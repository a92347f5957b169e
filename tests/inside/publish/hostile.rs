//! The body of the fuzz target `gvcp` over its seeds and damaged copies of them.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::session::session;

/// Flips, cuts, copies and inserts bytes.
fn damaged(seed: &[u8], rng: &mut Pcg64) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..rng.random_range(1..8) {
        let at = rng.random_range(0..bytes.len().max(1));
        match rng.random_range(0..4) {
            _ if bytes.is_empty() => return bytes,
            0 => bytes[at] ^= 1 << rng.random_range(0..8),
            1 => bytes.truncate(at),
            2 => bytes.insert(at, rng.random()),
            _ => {
                let end = (at + rng.random_range(0..64)).min(bytes.len());
                bytes.extend_from_within(at..end);
            }
        }
    }
    bytes
}

#[test]
fn any_session_is_answered_within_the_protocols_bounds() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds/gvcp");
    let mut seeds: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    seeds.sort();
    let mut rng = Pcg64::seed_from_u64(17);
    let (mut succeeded, mut refused) = (0, 0);
    for path in seeds {
        let seed = std::fs::read(&path).unwrap();
        assert!(session(&seed), "{}: no command of the seed succeeds", path.display());
        for _ in 0..300 {
            let count = if session(&damaged(&seed, &mut rng)) { &mut succeeded } else { &mut refused };
            *count += 1;
        }
    }
    assert!(succeeded > 100 && refused > 10, "{succeeded} succeeded, {refused} refused");
}
