//! Temporal noise from a counter hash: the same pixel of the same frame always gets the same noise.
//!
//! One 32-bit hash a pixel, keyed by (seed, frame, row) and column, is turned into a standard normal deviate by a
//! piecewise linear quantile table, and that into a sample whose first four moments are those of Gaussian read noise
//! plus Poisson electrons by the Cornish-Fisher expansion
//!
//! ```text
//! w = z + γ/6 (z² - 1) + κ/24 (z³ - 3z) - γ²/36 (2z³ - 5z),   γ = μ/v^{3/2},  κ = μ/v²,  v = σ_d² + μ  (electrons)
//! counts = mean + K √v w = k0 + k1 z + k2 z² + k3 z³
//! ```
//!
//! (E. A. Cornish, R. A. Fisher, Rev. Inst. Int. Stat. 5 (1938) 307). No transcendental function is left for the
//! shader, so that every driver that does not fuse multiply-adds gives the twin's bits.

use std::sync::OnceLock;

/// log2 of the segments an octave of probability: chords between them err by 2e-5 in z.
const OCTAVE_BITS: u32 = 6;

/// Octaves of probability, 2^-33 to 1/2: the largest deviate is 6.3.
const OCTAVES: usize = 32;

/// Segments of the quantile table and one entry for p = 1/2 itself; 16 KiB, half of a first-level cache.
pub const SEGMENTS: usize = (OCTAVES << OCTAVE_BITS) + 1;

/// Place of the first segment among the leading bits of an f32: probabilities are counted in units of 2^-32, from 1/2 unit.
pub const FIRST_SEGMENT: u32 = 126 << OCTAVE_BITS;

/// One segment of the quantile table: |z| = base + slope·(probability in units of 2^-32).
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Quantile {
    /// |z| extrapolated to probability 0.
    pub base: f32,
    /// Change a unit of probability, negative.
    pub slope: f32,
}

/// The table: |z| over the tail's probability, knots equally spaced within each octave, so that the far tail is as
/// well resolved as the middle. The knots are bent by s·(z + c·(z³ - 3z)) until variance 1 and kurtosis 3 are exact.
pub fn normal_table() -> &'static [Quantile; SEGMENTS] {
    static TABLE: OnceLock<Box<[Quantile; SEGMENTS]>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let knots = normal_knots();
        let mut table = Box::new([Quantile { base: 0.0, slope: 0.0 }; SEGMENTS]);
        for (q, pair) in table.iter_mut().zip(knots.windows(2)) {
            let slope = (pair[1].z - pair[0].z) / (pair[1].units - pair[0].units);
            *q = Quantile { base: (pair[0].z - slope * pair[0].units) as f32, slope: slope as f32 };
        }
        table
    })
}

/// A knot of the table in f64.
#[derive(Clone, Copy)]
struct Knot {
    /// Tail probability in units of 2^-32.
    units: f64,
    z: f64,
}

fn normal_knots() -> Vec<Knot> {
    let per_octave = 1 << OCTAVE_BITS;
    let plain: Vec<Knot> = (0..SEGMENTS)
        .map(|i| {
            let place = 1.0 + (i % per_octave) as f64 / per_octave as f64;
            let units = place * 2f64.powi((i / per_octave) as i32 - 1);
            Knot { units, z: standard_normal_quantile(units * 2f64.powi(-32)) }
        })
        .collect();
    let bent = |c: f64| -> Vec<Knot> {
        plain.iter().map(|k| Knot { z: k.z + c * (k.z.powi(3) - 3.0 * k.z), ..*k }).collect()
    };
    let (mut low, mut high) = (-0.01, 0.01);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        let (m2, m4) = even_moments(&bent(middle));
        if m4 < 3.0 * m2 * m2 { low = middle } else { high = middle }
    }
    let knots = bent(0.5 * (low + high));
    let scale = even_moments(&knots).0.sqrt();
    knots.iter().map(|k| Knot { z: k.z / scale, ..*k }).collect()
}

/// Second and fourth moment of a uniform variate sent through the knots; beyond the last octave |z| stays.
fn even_moments(knots: &[Knot]) -> (f64, f64) {
    let first = knots[0];
    let share = first.units * 2f64.powi(-31);
    let mut sums = (share * first.z.powi(2), share * first.z.powi(4));
    for pair in knots.windows(2) {
        let (a, b) = (pair[0].z, pair[1].z);
        let share = (pair[1].units - pair[0].units) * 2f64.powi(-31);
        sums.0 += share * (a * a + a * b + b * b) / 3.0;
        sums.1 += share * (a.powi(4) + a.powi(3) * b + a * a * b * b + a * b.powi(3) + b.powi(4)) / 5.0;
    }
    sums
}

/// The deviate that is exceeded with probability p.
fn standard_normal_quantile(p: f64) -> f64 {
    std::f64::consts::SQRT_2 * statrs::function::erf::erfc_inv(2.0 * p)
}

/// Keys of a sensor row in a frame; 64 bits, so that no two rows share their noise.
pub fn row_key(seed: u64, frame_id: u64, row: u32) -> [u32; 2] {
    let stream = splitmix(splitmix(seed) ^ frame_id);
    let key = splitmix(stream ^ (u64::from(row) << 1 | 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    [key as u32, (key >> 32) as u32]
}

/// The finaliser of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014), with the constants of its reference code.
fn splitmix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
