//! The smallest variance with which an edge can be placed (Cramér and Rao), from contrast, photons,
//! read noise, rounding and blur.
//!
//! Pixels μ_i = dark + (light − dark)·E(i − x) have independent normal noise of variance v_i. With
//! the parameters x and θ = (dark, light, blur) the information of a column is
//!
//! ```text
//! I = Σ ∂μ/∂p ∂μ/∂pᵀ / v_i = | a  bᵀ |        v = (electrons + read² + pattern²)/g² + 1/12 counts²
//!                            | b  C  |
//! ```
//!
//! g electrons a count; pattern is what the pixels' gain and offset differ by (PRNU, DSNU), which
//! scatters over columns and is the same in every frame. Where θ is given, the variance of x is g²
//! = 1/a. The columns of a frame have a place each and share θ: elimination of the places gives θ
//! the information Σ(C − b·bᵀ/a), and the mean place of n columns the variance f²/n,
//!
//! ```text
//! f² = ⟨1/a⟩ + ⟨b/a⟩ᵀ ⟨C − b·bᵀ/a⟩⁻¹ ⟨b/a⟩
//! ```
//!
//! with means over the places of an edge within a pixel, which an inclined part or a turn brings.
//! Blur moves an edge one way at one place and the other way at another, so that ⟨b/a⟩ has little
//! of it.
//!
//! Check: a Gaussian edge of σ with noise of one variance has 1/a = 2·√π·σ_n²·b/A², A the contrast,
//! b² = σ² + 1/12.

use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};

use super::edge::{OpticalEdge, PER_PX, PixelEdge};
use crate::frame::PixelFormat;
use crate::render::settings::SetupSettings;

/// Places of an edge within a pixel.
const PHASES: usize = 16;

/// Relative step of the blur's derivative: an error of 1e-6 of it.
const BLUR_STEP: f64 = 1e-3;

/// Levels and noise of a head by its data sheet, counts.
#[derive(Clone, Copy, Debug)]
pub(super) struct GreyLevels {
    pub(super) dark: f64,
    pub(super) light: f64,
    black: f64,
    electrons_per_count: f64,
    read_noise_e: f64,
    /// Variance of rounding to whole counts.
    rounding: f64,
    /// The pixels' own pattern: standard deviation of their gain (relative) and offset (electrons).
    pattern: [f64; 2],
}

impl GreyLevels {
    /// Of nominal settings.
    pub(super) fn of(setup: &SetupSettings) -> Self {
        let sensor = &setup.sensor;
        let gathered = sensor.dark_signal(setup.camera.exposure_us);
        let counts = gathered.mean_e / sensor.electrons_per_count;
        Self {
            dark: setup.light.shadow_counts + counts,
            light: setup.light.bright_in(sensor, sensor.electrons_per_count) + counts,
            black: sensor.black_level_counts + counts,
            electrons_per_count: sensor.electrons_per_count,
            read_noise_e: gathered.noise_e(sensor.read_noise_e),
            rounding: if sensor.format == PixelFormat::F32 { 0.0 } else { 1.0 / 12.0 },
            pattern: [sensor.prnu_rel, gathered.dsnu_e(sensor.dsnu_e)],
        }
    }

    /// The same without the pixels' own pattern, which is the same in every frame.
    pub(super) fn temporal(self) -> Self {
        Self { pattern: [0.0; 2], ..self }
    }

    /// The same with a share of the light.
    pub(super) fn with_light(self, share: f64) -> Self {
        let of = |level: f64| self.black + share * (level - self.black);
        Self { dark: of(self.dark), light: of(self.light), ..self }
    }

    /// Contrast, counts.
    pub(super) fn contrast(&self) -> f64 {
        self.light - self.dark
    }

    /// Variance of a pixel of this level, counts².
    pub(super) fn variance(&self, level: f64) -> f64 {
        let electrons = ((level - self.black) * self.electrons_per_count).max(0.0);
        let [gain, offset_e] = self.pattern;
        let pattern = (gain * electrons).powi(2) + offset_e * offset_e;
        (electrons + self.read_noise_e.powi(2) + pattern) / self.electrons_per_count.powi(2) + self.rounding
    }

    /// Contrast over the noise at mid-edge, as `gauge.min_snr` compares it.
    pub(super) fn snr(&self) -> f64 {
        let mid = 0.5 * (self.variance(self.dark) + self.variance(self.light));
        self.contrast() / mid.sqrt()
    }
}

/// Standard uncertainties of one edge in one column, px.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct EdgeBound {
    /// Levels and blur given.
    pub(super) given_px: f64,
    /// Levels and blur found from the frame.
    pub(super) found_px: f64,
}

/// The bound of an edge over `half_px` pixels either side, smeared by `smear_px`.
pub(super) fn edge_bound(
    edge: &OpticalEdge,
    half_px: usize,
    smear_px: f64,
    levels: &GreyLevels,
) -> Option<EdgeBound> {
    let pixels = edge.over_pixels(half_px, 1.0, smear_px);
    let wider = edge.over_pixels(half_px, 1.0 + BLUR_STEP, smear_px);
    of_pixels(&pixels, &wider, levels)
}

/// The bound from an edge and the same with a wider blur.
fn of_pixels(pixels: &PixelEdge, wider: &PixelEdge, levels: &GreyLevels) -> Option<EdgeBound> {
    let of_phase = |phase: usize| information(pixels, wider, levels, phase * PER_PX / PHASES);
    pooled((0..PHASES).map(of_phase))
}

/// The bound of columns with these informations.
fn pooled(columns: impl ExactSizeIterator<Item = Matrix4<f64>>) -> Option<EdgeBound> {
    let count = columns.len() as f64;
    let (mut given, mut lever, mut shared) = (0.0, Vector3::zeros(), Matrix3::zeros());
    for information in columns {
        let (a, b) = (information[(0, 0)], information.fixed_view::<3, 1>(1, 0).into_owned());
        given += a.recip() / count;
        lever += b / (a * count);
        shared += (information.fixed_view::<3, 3>(1, 1) - b * b.transpose() / a) / count;
    }
    let found = given + lever.dot(&(shared.try_inverse()? * lever));
    Some(EdgeBound { given_px: given.sqrt(), found_px: found.sqrt() })
}

/// Information on place, dark, light and blur of pixels that begin at a sample.
fn information(pixels: &PixelEdge, wider: &PixelEdge, levels: &GreyLevels, first: usize) -> Matrix4<f64> {
    let contrast = levels.contrast();
    (first..pixels.samples()).step_by(PER_PX).fold(Matrix4::zeros(), |sum, i| {
        let light = pixels.value(i);
        let by_blur = (wider.value(i) - light) / BLUR_STEP;
        let by = Vector4::new(-contrast * pixels.slope(i), 1.0 - light, light, contrast * by_blur);
        sum + by * by.transpose() / levels.variance(levels.dark + contrast * light)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::distributions::phi_cdf;

    /// Noise of 4 counts everywhere, contrast 1000.
    fn level() -> GreyLevels {
        GreyLevels {
            dark: 100.0,
            light: 1100.0,
            black: 0.0,
            electrons_per_count: 1e12,
            read_noise_e: 4e12,
            rounding: 0.0,
            pattern: [0.0; 2],
        }
    }

    fn bound(sigma: f64, levels: &GreyLevels) -> EdgeBound {
        let at = |scale: f64| PixelEdge::of(20, 0.0, |d| phi_cdf(d / (scale * sigma)));
        of_pixels(&at(1.0), &at(1.0 + BLUR_STEP), levels).unwrap()
    }

    /// 2·√π·σ_n²·b/A², and with levels found no less.
    #[test]
    fn a_gaussian_edge_has_the_closed_form() {
        for sigma in [1.0_f64, 2.0, 3.0] {
            let b = (sigma * sigma + 1.0 / 12.0).sqrt();
            let wanted = (2.0 * std::f64::consts::PI.sqrt() * 16.0 * b / 1e6).sqrt();
            let found = bound(sigma, &level());
            assert!((found.given_px / wanted - 1.0).abs() < 2e-3, "{sigma}: {} {wanted}", found.given_px);
            assert!(found.found_px >= found.given_px);
        }
    }

    /// The mean place of n columns at several places with common levels and blur has the variance
    /// f²/n: by the whole matrix of n places and three common parameters.
    #[test]
    fn columns_with_common_levels_average_as_stated() {
        let at = |scale: f64| PixelEdge::of(12, 0.0, |d| phi_cdf(d / (0.4 * scale)));
        let (edge, wider, n) = (at(1.0), at(1.0 + BLUR_STEP), 5);
        let columns: Vec<Matrix4<f64>> =
            (0..n).map(|column| information(&edge, &wider, &level(), 11 * column)).collect();
        let mut all = nalgebra::DMatrix::<f64>::zeros(n + 3, n + 3);
        for (column, one) in columns.iter().enumerate() {
            let place = |k: usize| if k == 0 { column } else { n + k - 1 };
            for i in 0..4 {
                for j in 0..4 {
                    all[(place(i), place(j))] += one[(i, j)];
                }
            }
        }
        let inverse = all.try_inverse().unwrap();
        let mean: f64 = (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).map(|at| inverse[at]).sum();
        let mean = mean / (n * n) as f64;
        let wanted = pooled(columns.into_iter()).unwrap().found_px.powi(2) / n as f64;
        assert!((mean / wanted - 1.0).abs() < 1e-9, "{mean} {wanted}");
    }

    /// A hundred times the photons: ten times less, where photons are the noise.
    #[test]
    fn photons_decide_where_they_are_the_noise() {
        let of = |electrons_per_count: f64| GreyLevels { electrons_per_count, read_noise_e: 0.0, ..level() };
        let ratio = bound(1.2, &of(1.0)).given_px / bound(1.2, &of(100.0)).given_px;
        assert!((ratio - 10.0).abs() < 1e-6, "{ratio}");
    }
}
