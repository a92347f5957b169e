//! Lattice noise: a hash at the corners of cells, smooth between them; mean 0, within ±1.

use std::cell::Cell;

/// SplitMix64's mixing of a counter (Steele, Lea, Flood 2014).
fn mixed(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A number of a lattice corner, −1 to 1.
pub(super) fn corner(i: i64, j: i64, seed: u64) -> f64 {
    let key = (i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (j as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
    let bits = mixed(mixed(key ^ seed).wrapping_add(seed)) >> 11;
    bits as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Cells that a thread keeps: scenes have some thirty streams, each keeps its own but for a few.
const KEPT: usize = 64;

/// The corners of a cell of a stream: (0, 0), (1, 0), (0, 1), (1, 1).
#[derive(Clone, Copy)]
struct Kept {
    cell: (i64, i64),
    seed: u64,
    corners: [f64; 4],
}

thread_local! {
    /// Neighbouring samples lie in the same cell: a hash of its corners is computed once.
    static CELLS: [Cell<Option<Kept>>; KEPT] = const { [const { Cell::new(None) }; KEPT] };
}

fn corners(i: i64, j: i64, seed: u64) -> [f64; 4] {
    CELLS.with(|cells| {
        // profiles of one stream in several rows keep a cell each
        let place = &cells[(seed as usize).wrapping_add((j as usize).wrapping_mul(17)) % KEPT];
        match place.get() {
            Some(kept) if kept.cell == (i, j) && kept.seed == seed => kept.corners,
            _ => {
                let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(di, dj)| corner(i + di, j + dj, seed));
                place.set(Some(Kept { cell: (i, j), seed, corners }));
                corners
            }
        }
    })
}

/// Noise of cells of size 1.
pub(super) fn noise(x: f64, y: f64, seed: u64) -> f64 {
    let (i, j) = (x.floor(), y.floor());
    let ease = |t: f64| t * t * (3.0 - 2.0 * t);
    let (t, u) = (ease(x - i), ease(y - j));
    let [a, b, c, d] = corners(i as i64, j as i64, seed);
    let (upper, lower) = (a + t * (b - a), c + t * (d - c));
    upper + u * (lower - upper)
}

/// Three octaves of it.
pub(super) fn rough(x: f64, y: f64, seed: u64) -> f64 {
    (noise(x, y, seed) + 0.5 * noise(2.0 * x, 2.0 * y, seed ^ 1) + 0.25 * noise(4.0 * x, 4.0 * y, seed ^ 2))
        / 1.75
}
