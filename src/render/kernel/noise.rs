//! Temporal noise from a counter hash: the same pixel of the same frame always has the same noise.
//!
//! One 32-bit hash per pixel, keyed by (seed, frame), row and column, yields two 16-bit numbers.
//! Their sum v is triangular, so that the tail beyond |v| has the probability u²/2 with u =
//! 1 - |v|/2¹⁶, and a standard normal deviate is a function of u without a logarithm or a square
//! root:
//!
//! ```text
//! z = v/2¹⁶ · P(u)/Q(u)     P of fourth, Q of third degree
//! ```
//!
//! P/Q is a minimax fit to Φ⁻¹(1 - u²/2)/(1 - u) over u ≥ 0.004 (|z| ≤ 4.3, error 0.0011; |z|
//! ≤ 5.05 overall), adjusted in two coefficients until variance and kurtosis over all 2³² hashes
//! are 1 and 3 to 1e-7. Its distribution function errs by 3.6e-4 at most. Read noise and electrons
//! together then follow from z by Cornish-Fisher:
//!
//! ```text
//! w = z + γ/6 (z² - 1) + κ/24 (z³ - 3z) - γ²/36 (2z³ - 5z)
//! γ = μ/v^{3/2},  κ = μ/v²,  v = σ_d² + μ  (electrons)
//! counts = mean + K √v w = k0 + k1 z + k2 z² + k3 z³
//! ```
//!
//! (E. A. Cornish, R. A. Fisher, Rev. Inst. Int. Stat. 5 (1938) 307). There is no table and no
//! transcendental function: every step vectorises, and every driver that does not fuse
//! multiply-adds produces the twin's bits.

/// P, ascending powers of u.
pub(crate) const NUMERATOR: [f32; 5] = [5.054_005_6, 917.006_8, 9_288.955, -1_999.658_2, 4_506.544];

/// Q, ascending powers of u from the first; its constant is 1.
pub(crate) const DENOMINATOR: [f32; 3] = [246.368_5, 3_911.391, 986.766_36];

/// Keys of a frame, 64 bits from seed and number; the keys of every row are derived from them
/// (`row_key` of the kernel).
pub(crate) fn frame_key(seed: u64, frame_id: u64) -> [u32; 2] {
    let key = splitmix(splitmix(seed) ^ frame_id);
    [key as u32, (key >> 32) as u32]
}

/// The finaliser of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014), with the constants of its
/// reference code.
fn splitmix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
