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

/// log2 of the table's segments: 2048 pairs of f32 are 16 KiB, half of a first-level cache.
pub const TABLE_BITS: u32 = 11;

/// Segments of the quantile table.
pub const SEGMENTS: usize = 1 << TABLE_BITS;

/// One segment of the quantile table: z = base + slope·fraction.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Quantile {
    /// z at the segment's start.
    pub base: f32,
    /// Rise over the segment.
    pub slope: f32,
}

/// The table: interior knots at Φ⁻¹(i/N)·scale; scale and end knots make variance 1 and kurtosis 3 exactly.
pub fn normal_table() -> &'static [Quantile; SEGMENTS] {
    static TABLE: OnceLock<Box<[Quantile; SEGMENTS]>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let knots = normal_knots();
        let mut table = Box::new([Quantile { base: 0.0, slope: 0.0 }; SEGMENTS]);
        for (i, q) in table.iter_mut().enumerate() {
            *q = Quantile { base: knots[i] as f32, slope: (knots[i + 1] - knots[i]) as f32 };
        }
        table
    })
}

/// Knots of the table in f64.
fn normal_knots() -> Vec<f64> {
    let interior: Vec<f64> =
        (1..SEGMENTS).map(|i| standard_normal_quantile(i as f64 / SEGMENTS as f64)).collect();
    let with_end = |end: f64| {
        let mut knots = Vec::with_capacity(SEGMENTS + 1);
        knots.push(-end);
        knots.extend_from_slice(&interior);
        knots.push(end);
        knots
    };
    let kurtosis = |end: f64| {
        let (m2, m4) = even_moments(&with_end(end));
        m4 / (m2 * m2)
    };
    let (mut low, mut high) = (interior[SEGMENTS - 2], 8.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if kurtosis(middle) < 3.0 { low = middle } else { high = middle }
    }
    let knots = with_end(0.5 * (low + high));
    let scale = even_moments(&knots).0.sqrt();
    knots.iter().map(|k| k / scale).collect()
}

/// Second and fourth moment of a uniform variate sent through the knots.
fn even_moments(knots: &[f64]) -> (f64, f64) {
    let n = (knots.len() - 1) as f64;
    let mut sums = (0.0, 0.0);
    for pair in knots.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        sums.0 += (a * a + a * b + b * b) / 3.0;
        sums.1 += (a.powi(4) + a.powi(3) * b + a * a * b * b + a * b.powi(3) + b.powi(4)) / 5.0;
    }
    (sums.0 / n, sums.1 / n)
}

fn standard_normal_quantile(p: f64) -> f64 {
    -std::f64::consts::SQRT_2 * statrs::function::erf::erfc_inv(2.0 * p)
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
