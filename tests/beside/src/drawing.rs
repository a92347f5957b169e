//! Frames in closed form: the shadow of a straight shaft behind a Gaussian edge, with noise.

use std::error::Error;

use shadowgauge::frame::{Buffer, Frame, FrameMeta, PixelFormat};

pub const COLUMNS: usize = 128;
pub const ROWS: usize = 256;
/// Size of a pixel on the object, mm: a shaft of 12 mm fills 200 of 256 rows.
pub const MM_PER_PX: f64 = 0.06;
/// Standard deviation of the edge, px.
const BLUR_PX: f64 = 1.2;
/// Counts of 12 bits in the shadow and in the light.
const LEVELS: (f64, f64) = (400.0, 3300.0);
/// Standard deviation of the noise, counts: an SNR of 290.
const NOISE: f64 = 10.0;

/// Integral of the normal distribution (Abramowitz and Stegun 26.2.17, within 7.5e-8).
fn normal_cdf(x: f64) -> f64 {
    let t = (1.0 + 0.231_641_9 * x.abs()).recip();
    let series = [1.330_274_429, -1.821_255_978, 1.781_477_937, -0.356_563_782, 0.319_381_530];
    let tail = series.iter().fold(0.0, |sum, a| t * (sum + a)) * (-0.5 * x * x).exp()
        / (2.0 * std::f64::consts::PI).sqrt();
    if x > 0.0 { 1.0 - tail } else { tail }
}

/// Uniform in 0 to 1 from a counter (splitmix64).
fn uniform(counter: u64) -> f64 {
    let mut z = counter.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z ^ (z >> 31)) as f64 / u64::MAX as f64
}

/// Standard normal to a good approximation: the sum of four uniforms, scaled.
fn normal(counter: u64) -> f64 {
    ((0..4).map(|i| uniform(4 * counter + i)).sum::<f64>() - 2.0) * 3.0_f64.sqrt()
}

/// The frame of a shaft of `diameter_mm(column)` whose axis lies `axis_px` below the middle row;
/// `meta.frame_id` seeds the noise.
pub fn draw(
    diameter_mm: impl Fn(usize) -> f64,
    axis_px: f64,
    meta: FrameMeta,
) -> Result<Frame, Box<dyn Error + Send + Sync>> {
    let middle = 0.5 * (ROWS - 1) as f64 + axis_px;
    let edges: Vec<f64> = (0..COLUMNS).map(|column| 0.5 * diameter_mm(column) / MM_PER_PX).collect();
    let mut counts = Vec::with_capacity(ROWS * COLUMNS);
    for row in 0..ROWS {
        for (column, half_px) in edges.iter().enumerate() {
            let outside_px = (row as f64 - middle).abs() - half_px;
            let light = normal_cdf(outside_px / BLUR_PX);
            let pixel = (row * COLUMNS + column) as u64;
            let noise = NOISE * normal(meta.frame_id * (ROWS * COLUMNS) as u64 + pixel);
            counts.push((LEVELS.0 + (LEVELS.1 - LEVELS.0) * light + noise).round().clamp(0.0, 4095.0) as u16);
        }
    }
    Ok(Frame::new(Buffer::U16(counts), PixelFormat::Mono12, ROWS, COLUMNS, meta)?)
}
