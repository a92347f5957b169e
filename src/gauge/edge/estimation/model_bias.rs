//! Systematic residual of the edge model at the masters' edges, and its part in the uncertainty of
//! a part's edges.
//!
//! An edge model that differs from the true edge-spread function displaces every edge by b. Where
//! calibration and use share model, optics and light, b is the same in both and part of the
//! masters' offset (GUM 5.2: a systematic effect common to both cancels in their difference). The
//! displacement that a residual r may hide, u = ‖r‖/√J with the edge's information J, is then not
//! stated in full, but only its possible changes:
//!
//! 1. the *difference* of the residuals: with r_c(d) the mean residual of the masters' edges over
//!    the distance d from the edge, χ² is computed of r − r_c. A part with the residual of the
//!    masters has χ² = 1; one with any other residual, or none, has not;
//! 2. other *weights*: another exposure or blur weighs the same residual otherwise and moves the
//!    edge by δ(p) = Σ_k w_k(p)·r_c(k − p), to first order; zero where the weights are those of the
//!    masters;
//! 3. the *phase*: b(p) = Σ_k w(k − p)·r(k − p) repeats every pixel; its first harmonic B₁ = ∫
//!    w·r·e^{2πiu} du is not to be seen in r_c, which is taken over distances from the edges as
//!    they were fitted (see `slanted_edge`). Of the edge's own derivatives E⁽ⁿ⁾ (a skew, a
//!    kurtosis, …) it takes the share a(σ) = √2·|B₁|·√J/‖r‖ ≤ [`aliased`]: a third at σ = 0.4 px, 3
//!    % at 0.8 px, nothing from 1.2 px.

use super::blur::BlurLimits;
use super::column_fit::ColumnJob;
use super::levels::LevelCurve;
use super::scoring::normalise;
use super::scoring_table::ScoringTableLimits;
use super::slanted_edge::SlantedEdgeLimits;
use crate::gauge::edge::image::scan_windows::Windows;
use crate::gauge::edge::image::window_layout::half;
use crate::gauge::edge::model::edge_spread::EdgeSpreadFunction;
use crate::gauge::edge::model::gaussian::EdgeSample;
use crate::gauge::edge::model::systematic_residual::SystematicResidual;
use crate::gauge::edges::Edge;
use crate::gauge::limit::limits;
use crate::numerics::smoothing_spline::SplineFit;

limits! {
    /// How the residual of the masters' edges is estimated, and from which on it is one.
    ModelBiasLimits = "model_bias";
    /// Distance of the spline's knots in blurs, where that is more than
    /// [`SlantedEdgeLimits::knot_px`]: Gaussian optics pass exp(−2π²·1.25²) = 4e-14 of the finest
    /// wave that such knots follow, 1.25 per blur.
    knot_in_blurs: f64 = 0.4;
    /// Weight of a second difference of the spline's coefficients, in units of a knot's mean
    /// weight: bridges the phases that no master stood at, and takes 1 % of a ring as wide as two
    /// and a half blurs, (2 − 2 cos(2π/6.25))²/100.
    smoothing: f64 = 1e-2;
    /// Distance of the values kept, px: half the least distance of the knots, so that a line
    /// between two values follows the spline.
    step_px: f64 = 0.125;
    /// Mean excess of χ² over its expectation above which the masters' edges have a systematic
    /// residual: two and a half relative standard uncertainties of the noise of a few frames, 2 %
    /// (false alarms in 0.6 % of the calibrations).
    least_excess: f64 = 0.05;
}

/// Gathers residuals from the masters' frames.
#[derive(Debug, Default)]
pub(crate) struct ResidualAccumulator {
    sides: [Option<SideResiduals>; 2],
    chi2: f64,
    edges: f64,
}

#[derive(Debug)]
struct SideResiduals {
    reach: f64,
    fit: SplineFit,
    edges: usize,
}

/// One side of a frame: what its residuals are computed from.
pub(crate) struct SideView<'a> {
    pub(crate) windows: &'a Windows,
    pub(crate) shape: &'a EdgeSpreadFunction,
    pub(crate) dark: &'a LevelCurve,
    pub(crate) light: &'a LevelCurve,
    pub(crate) slope: &'a [f32],
}

impl ResidualAccumulator {
    /// Adds the residuals of a side's edges; `sigma` is the blur at a column.
    pub(crate) fn add(
        &mut self,
        side: usize,
        view: &SideView<'_>,
        line: &[Edge],
        sigma: impl Fn(usize) -> f64,
    ) {
        let steepest = BlurLimits::get().steepest as f32;
        let windows = view.windows;
        let reach = half(windows.width) as f64 - 1.0;
        let in_blurs = ModelBiasLimits::get().knot_in_blurs * sigma(line.len() / 2);
        let knot = in_blurs.max(SlantedEdgeLimits::get().knot_px);
        let segments = (2.0 * reach / knot).ceil() as usize;
        let residuals = self.sides[side].get_or_insert_with(|| SideResiduals {
            reach,
            fit: SplineFit::new(-reach, reach, segments),
            edges: 0,
        });
        let sign = f64::from(windows.side.sign());
        let first = -(half(windows.width) as f64);
        let mut samples = vec![EdgeSample::default(); windows.width - 1];
        for (column, edge) in line.iter().enumerate().filter(|(_, e)| e.is_usable()) {
            let (Ok(centre), true) = (windows.centre[column], view.slope[column].abs() < steepest) else {
                continue;
            };
            let x = sign * (edge.row_px - f64::from(centre));
            view.shape.samples(first, x, sigma(column), &mut samples);
            let dark = f64::from(view.dark.level[column]);
            let contrast = f64::from(view.light.level[column]) - dark;
            for (k, (m, sample)) in windows.of(column).iter().zip(&samples).enumerate() {
                residuals.fit.add(first + k as f64 - x, (f64::from(*m) - dark) / contrast - sample.value);
            }
            residuals.edges += 1;
            self.chi2 += f64::from(edge.chi2);
            self.edges += 1.0;
        }
    }

    /// What the edges leave; `None` where the model fits them as well as their noise lets it be
    /// determined.
    pub(crate) fn finish(self) -> Option<SystematicResidual> {
        let ModelBiasLimits { least_excess, step_px, .. } = *ModelBiasLimits::get();
        let chi2 = self.chi2 / self.edges.max(1.0);
        if !(chi2 > 1.0 + least_excess) {
            return None;
        }
        let [top, bottom] = self.sides.map(|side| side.and_then(SideResiduals::finish));
        Some(SystematicResidual { step_px, residual: [top?, bottom?], chi2 })
    }
}

impl SideResiduals {
    fn finish(self) -> Option<Vec<f64>> {
        if self.edges < SlantedEdgeLimits::get().least_columns {
            return None;
        }
        let ModelBiasLimits { smoothing, step_px, .. } = *ModelBiasLimits::get();
        let half = (self.reach / step_px).ceil() as i32;
        let spline = self.fit.solve(smoothing, false)?;
        Some((-half..=half).map(|k| spline.at(f64::from(k) * step_px).0).collect())
    }
}

/// Largest fraction of the norm of a residual that the position of an edge takes from its phase:
/// the envelope of a(σ) over the edge's derivatives of
/// orders 3 to 5 (module's heading).
fn aliased(sigma: f64) -> f64 {
    (3.5 * (-7.5 * sigma * sigma).exp()).min(0.4)
}

/// A side's expected residual, ready for use.
#[derive(Clone, Debug)]
pub(crate) struct Expected {
    /// Values at [`ScoringTableLimits::fine`] places per px; the middle one at the edge.
    values: Vec<f32>,
    /// Their number per px.
    per_px: u32,
}

/// What the edges of one frame leave of an expected residual.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ExpectedTest<'a> {
    expected: &'a Expected,
    /// Sums over the edges tested so far: squares of the shifts by weights and phase, px², and
    /// number of edges.
    left: (f64, f64),
}

impl Expected {
    pub(crate) fn new(expected_residual: &SystematicResidual, side: usize) -> Self {
        let kept = &expected_residual.residual[side];
        let middle = (kept.len() / 2) as f64;
        let per_px = ScoringTableLimits::get().fine;
        let fine = f64::from(per_px);
        let reach = (middle * expected_residual.step_px * fine) as i32;
        let at = |k: i32| {
            let place = middle + f64::from(k) / fine / expected_residual.step_px;
            let (low, share) = (place as usize, place.fract());
            let value = |k: usize| kept.get(k).copied().unwrap_or(0.0);
            (value(low) + share * (value(low + 1) - value(low))) as f32
        };
        Self { values: (-reach..=reach).map(at).collect(), per_px }
    }

    /// Begins the test of a frame's edges.
    pub(crate) fn test(&self) -> ExpectedTest<'_> {
        ExpectedTest { expected: self, left: (0.0, 0.0) }
    }

    /// Value at a pixel from the central one, for an edge at a phase.
    fn at(&self, pixel: i32, phase: f32) -> f32 {
        let middle = (self.values.len() / 2) as i32;
        let index = middle + pixel * self.per_px as i32 - (phase * self.per_px as f32).round() as i32;
        usize::try_from(index).ok().and_then(|k| self.values.get(k)).copied().unwrap_or(0.0)
    }
}

impl ExpectedTest<'_> {
    /// Standard uncertainty of an edge by other weights and phases than the masters', px.
    pub(crate) fn left_px(&self) -> f64 {
        (self.left.0 / f64::max(self.left.1, 1.0)).sqrt()
    }

    /// Takes χ² of the usable edges of `columns` against the expected residual instead of none.
    pub(crate) fn judge(
        &mut self,
        job: &ColumnJob<'_>,
        columns: std::ops::Range<usize>,
        normalised: &mut [f32],
        line: &mut [Edge],
    ) {
        let sign = f64::from(job.windows.side.sign());
        for column in columns {
            let edge = &mut line[column];
            let (true, Ok(centre)) = (edge.is_usable(), job.windows.centre[column]) else { continue };
            let x = (sign * (edge.row_px - f64::from(centre))) as f32;
            let phase = job.table.phase(x);
            let step = x - phase.scalars.phase;
            // An edge beyond the tabulated phases keeps its χ².
            if !(step.abs() < 0.25) {
                continue;
            }
            let (dark, contrast) = (job.dark.level[column], job.light.level[column] - job.dark.level[column]);
            normalise(job.windows.of(column), dark, contrast, normalised);
            let mut sums = Sums::default();
            for (k, n) in normalised.iter().enumerate() {
                let expected =
                    self.expected.at(k as i32 - half(job.windows.width) as i32, phase.scalars.phase);
                sums.add(n - phase.values[k], expected, phase.inverse_variances[k], phase.weights[k]);
            }
            let information = phase.scalars.information;
            let square = sums.square
                - step * step * information
                - 2.0 * (sums.product - step * sums.moved * information)
                + sums.expected;
            let variance = job.noise.variance(f64::from(dark + 0.5 * contrast)) as f32;
            edge.chi2 = square.max(0.0) / (variance / (contrast * contrast) * phase.scalars.freedom);
            let by_phase = aliased(job.table.sigma).powi(2) * f64::from(sums.expected / information);
            self.left.0 += f64::from(sums.moved).powi(2) + by_phase;
            self.left.1 += 1.0;
        }
    }
}

/// Sums over the pixels of one edge: of the residual r and the expected one e, with the weights
/// v_mid/v.
#[derive(Default)]
struct Sums {
    /// Σ r²·v_mid/v.
    square: f32,
    /// Σ r·e·v_mid/v.
    product: f32,
    /// Σ e²·v_mid/v.
    expected: f32,
    /// Σ w·e, px.
    moved: f32,
}

impl Sums {
    fn add(&mut self, residual: f32, expected: f32, inverse_variance: f32, weight: f32) {
        self.square += residual * residual * inverse_variance;
        self.product += residual * expected * inverse_variance;
        self.expected += expected * expected * inverse_variance;
        self.moved += weight * expected;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauge::edge::model::gaussian::edge_samples;
    use crate::numerics::distributions::phi_pdf;

    /// |B₁| of the residual E⁽³⁾ … E⁽⁵⁾, freed of ∂E/∂x and ∂E/∂σ, by sums over a fine grid.
    fn aliased_by_sums(sigma: f64, order: usize) -> f64 {
        const PER_PX: i32 = 64;
        let hermite = |n: usize, t: f64| match n {
            1 => t,
            2 => t * t - 1.0,
            _ => t * t * t - 3.0 * t,
        };
        // E⁽ⁿ⁾ is the difference of the (n − 2)th derivative of the Gaussian density over a pixel.
        let n = order - 2;
        let density =
            |u: f64| (-1.0 / sigma).powi(n as i32) * hermite(n, u / sigma) * phi_pdf(u / sigma) / sigma;
        let grid: Vec<f64> = (-12 * PER_PX..=12 * PER_PX).map(|k| f64::from(k) / f64::from(PER_PX)).collect();
        let mut sample = [EdgeSample::default()];
        let (mut by_x, mut by_sigma, mut g) = (Vec::new(), Vec::new(), Vec::new());
        for u in &grid {
            edge_samples(*u, 0.0, sigma, &mut sample);
            by_x.push(sample[0].by_position);
            by_sigma.push(sample[0].by_sigma);
            g.push(density(u + 0.5) - density(u - 0.5));
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / f64::from(PER_PX);
        // ∂E/∂x is even and ∂E/∂σ odd about the edge: they are orthogonal.
        for by in [&by_x, &by_sigma] {
            let share = dot(&g, by) / dot(by, by);
            g.iter_mut().zip(by).for_each(|(g, b)| *g -= share * b);
        }
        let wave = |f: fn(f64) -> f64| -> Vec<f64> {
            grid.iter().zip(&by_x).map(|(u, e)| e * f(2.0 * std::f64::consts::PI * u)).collect()
        };
        let harmonic = dot(&wave(f64::cos), &g).hypot(dot(&wave(f64::sin), &g));
        2.0_f64.sqrt() * harmonic / (dot(&by_x, &by_x) * dot(&g, &g)).sqrt()
    }

    #[test]
    fn what_the_phase_takes_of_a_misfit_is_not_more_than_said() {
        for sigma in [0.3, 0.36, 0.4, 0.5, 0.6, 0.7, 0.8, 1.0, 1.2] {
            let most = (3..=5).map(|order| aliased_by_sums(sigma, order)).fold(0.0, f64::max);
            let said = aliased(sigma);
            assert!(most <= 1.05 * said && said < 2.0 * most + 1e-4, "sigma {sigma}: {most} {said}");
        }
    }

    #[test]
    fn impossible_files_are_named() {
        let good = SystematicResidual { step_px: 0.125, residual: [vec![0.0; 9], vec![0.01; 9]], chi2: 2.0 };
        assert!(good.impossible().is_none());
        assert!((good.norm(1) - 0.01 * (9.0_f64 * 0.125).sqrt()).abs() < 1e-12);
        let step = SystematicResidual { step_px: f64::NAN, ..good.clone() };
        assert_eq!(step.impossible().unwrap().0, "misfit.step_px");
        let even = SystematicResidual { residual: [vec![0.0; 8], vec![0.0; 9]], ..good.clone() };
        assert_eq!(even.impossible().unwrap().0, "misfit.residual");
        let loud = SystematicResidual { residual: [vec![0.0; 9], vec![f64::INFINITY; 9]], ..good };
        assert_eq!(loud.impossible().unwrap().1, f64::INFINITY);
    }
}
