//! Frames computed without the crate's renderer or gauge: pixel-integrated edges by the textbook
//! formula with another library's erf, noise from rand_distr. This reference shares no function
//! with the gauge.

use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;
use shadowgauge::frame::{Buffer, Frame, FrameMeta, PixelFormat};
use statrs::function::erf::erf;

/// A shadow with two level edges and a noisy sensor.
#[derive(Clone, Debug)]
pub struct Synth {
    pub rows: usize,
    pub columns: usize,
    pub dark: f64,
    pub light: f64,
    pub sigma: f64,
    /// Variance at level m is `read² + gain·(m − black)`.
    pub read: f64,
    pub gain: f64,
    pub black: f64,
    pub format: PixelFormat,
}

impl Synth {
    /// A 12-bit frame with the given contrast-to-noise ratio at mid-edge; `shot`: photon noise,
    /// otherwise additive.
    pub fn with_snr(sigma: f64, snr: f64, shot: bool) -> Self {
        let (dark, light) = (700.0, 3300.0);
        let variance = ((light - dark) / snr).powi(2);
        // Photon noise: an eighth of the mid-edge variance is read noise.
        let (read, gain) = if shot {
            ((variance / 8.0).sqrt(), variance * 0.875 / (0.5 * (light + dark) - 100.0))
        } else {
            (variance.sqrt(), 0.0)
        };
        Self {
            rows: 112,
            columns: 2048,
            dark,
            light,
            sigma,
            read,
            gain,
            black: 100.0,
            format: PixelFormat::Mono12,
        }
    }

    /// Mean of a pixel between the true edges, counts.
    pub fn mean(&self, row: f64, top: f64, bottom: f64) -> f64 {
        self.dark
            + (self.light - self.dark) * (1.0 - step(row, top, self.sigma) + step(row, bottom, self.sigma))
    }

    pub fn variance(&self, level: f64) -> f64 {
        self.read * self.read + self.gain * (level - self.black)
    }

    /// Draws a frame; `edges` returns (top, bottom) of a column in px.
    pub fn frame(&self, edges: impl Fn(usize) -> (f64, f64), seed: Option<u64>) -> Frame {
        self.frame_with(edges, |_, _, m| m, seed)
    }

    /// As [`Self::frame`], with a light field that changes the mean at (row, column).
    pub fn frame_with(
        &self,
        edges: impl Fn(usize) -> (f64, f64),
        field: impl Fn(usize, usize, f64) -> f64,
        seed: Option<u64>,
    ) -> Frame {
        let mut rng = seed.map(|s| Pcg64::new(u128::from(s), 0x0a02_bdbf_7bb3_c0a7_ac28_fa16_a64a_bf96));
        let normal = Normal::new(0.0, 1.0).unwrap();
        let mut counts = vec![0.0_f32; self.rows * self.columns];
        for column in 0..self.columns {
            let (top, bottom) = edges(column);
            for row in 0..self.rows {
                let mean = field(row, column, self.mean(row as f64, top, bottom));
                let noise =
                    rng.as_mut().map_or(0.0, |rng| normal.sample(rng) * self.variance(mean).max(0.0).sqrt());
                counts[row * self.columns + column] = (mean + noise) as f32;
            }
        }
        self.digitise(&counts)
    }

    /// As [`Self::frame`], with another edge: `step` is the light on a pixel over the distance of
    /// its centre (px) on the light side.
    #[allow(dead_code, reason = "not every test binary needs it")]
    pub fn frame_of(
        &self,
        edges: impl Fn(usize) -> (f64, f64),
        step: impl Fn(f64) -> f64,
        seed: Option<u64>,
    ) -> Frame {
        let gaussless = |row: usize, column: usize, _: f64| {
            let (top, bottom) = edges(column);
            let light = step(top - row as f64) + step(row as f64 - bottom);
            self.dark + (self.light - self.dark) * light
        };
        self.frame_with(&edges, gaussless, seed)
    }

    fn digitise(&self, counts: &[f32]) -> Frame {
        let top = self.format.full_scale().map_or(f32::INFINITY, f32::from);
        let digital = counts.iter().map(|m| m.round().clamp(0.0, top));
        let buffer = match self.format {
            PixelFormat::F32 => Buffer::F32(counts.to_vec()),
            PixelFormat::Mono8 => Buffer::U8(digital.map(|m| m as u8).collect()),
            _ => Buffer::U16(digital.map(|m| m as u16).collect()),
        };
        Frame::new(buffer, self.format, self.rows, self.columns, FrameMeta::default()).unwrap()
    }

    /// Cramér-Rao bound on the standard deviation of an upper edge at `x`, with given levels and
    /// blur, by numerical derivatives; quantisation counts as 1/12 count².
    #[allow(dead_code, reason = "not every test binary needs it")]
    pub fn bound(&self, x: f64) -> f64 {
        let h = 1e-4;
        let information: f64 = (-20..=20)
            .map(|k| {
                let row = x.round() + f64::from(k);
                let mean = |x: f64| self.mean(row, x, x + 1000.0);
                let derivative = (mean(x + h) - mean(x - h)) / (2.0 * h);
                let quantisation = if self.format == PixelFormat::F32 { 0.0 } else { 1.0 / 12.0 };
                derivative * derivative / (self.variance(mean(x)) + quantisation)
            })
            .sum();
        information.recip().sqrt()
    }
}

/// Light fraction of the pixel at `row` for an edge at `x` with light on the far side: ∫Φ over the
/// pixel.
fn step(row: f64, x: f64, sigma: f64) -> f64 {
    let cdf = |t: f64| 0.5 * (1.0 + erf(t / std::f64::consts::SQRT_2));
    let pdf = |t: f64| (-0.5 * t * t).exp() / (2.0 * std::f64::consts::PI).sqrt();
    let g = |u: f64| u * cdf(u / sigma) + sigma * pdf(u / sigma);
    g(row + 0.5 - x) - g(row - 0.5 - x)
}

/// A straight shaft whose edges drift through all sub-pixel phases.
pub fn drifting(column: usize) -> (f64, f64) {
    let c = column as f64;
    (22.3 + 0.0041 * c + 0.2 * (c / 300.0).sin(), 89.7 - 0.0037 * c + 0.2 * (c / 250.0).cos())
}
