//! Least squares over the masters' observations and all uncertain quantities of the masters
//! themselves.
//!
//! Unknowns are the optical setup's parameters θ = (s, o, a, q, g, t) of [`LensModel`] and
//! nuisances ν: the error δ_p of each certificate by itself, an error γ_g that the certificates of
//! one laboratory share (GUM F.1.2.3: a common standard makes them correlated, cov(D_p, D_q) =
//! c_p·c_q), the thermometer's error δT, the error δα of the masters' expansion, an error ε_f that
//! the columns of a frame share, and an error w_y that all frames out of the masters' plane by the
//! same distance y share.
//! The residual of an observation is
//!
//! ```text
//! r = s·(1 + t·y)·[f(u, v_bottom) − f(u, v_top) + ε_f + w_y]·χ + o
//!     − (D_p + δ_p + c_p·γ_g)·(1 + (α + δα)(T + δT − 20 °C))
//! ```
//!
//! Minimised is Σ r²/σ_r² + Σ ν²/u_ν² + Σ (a, q, g, t)²/u². With rows J/σ of both kinds and N =
//! ΣJᵀJ/σ², a group G of rows contributes N⁻¹(Σ_G JᵀJ/σ²)N⁻¹ to the covariance: the parts add up to
//! N⁻¹ exactly, and a budget can name each source.
//!
//! An edge model that differs from the true edge-spread function displaces edges by an amount that
//! changes with focus. In the masters' plane it is part of the offset o; elsewhere it is w_y, with
//! a standard uncertainty from the edges' residuals (the model uncertainty) or, where that is more,
//! the root mean square of the w_y fitted freely, if these reduce χ² by more than chance would
//! (`adjustment.false_alarm`). The lens' parameters and their rows are then free of it: t is
//! determined by masters of different diameter at one y. Where the residuals still scatter more
//! than the edges' uncertainties imply, the latter are multiplied (Birge's ratio).

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::adjusted::{Adjusted, CovariancePart, Residual};
use super::error::{CalibrationError, CalibrationLimits};
use super::imaging_model::{LensLimits, LensModel, PARAMETERS};
use super::masters::{MasterPrior, laboratories, shared_source};
use super::observation::Observation;
use super::thermometer::Thermometer;
use crate::gauge::limit::limits;

limits! {
    /// How the adjustment is solved and tested.
    AdjustmentLimits = "adjustment";
    /// Gauss-Newton steps: the problem is linear to parts in 1e3, so that each gains three digits
    /// and five all there are.
    steps: usize = 5;
    /// False-alarm probability of the F test for a systematic residual that changes with focus.
    false_alarm: f64 = 1e-3;
    /// Standard uncertainty of a w_y that is practically free, px: an edge's blur, which no
    /// residual of its model exceeds.
    free_px: f64 = 2.0;
    /// Steps of [`Solver`], each of which gains the three digits of `steps`: 1e-9 of the deviation
    /// is left.
    chord_steps: usize = 3;
}

/// Sources of the adjustment in budgets.
const EDGES: &str = "masters' edges (noise, levels, repeatability)";
const DISTORTION: &str = "distortion and keystone of the lens";
const TELECENTRICITY: &str = "telecentricity of the lens";
const MISFIT: &str = "misfit of the edge model out of the masters' plane";

/// The adjustment, ready to be solved for its own data and for deviated data.
#[derive(Clone, Debug)]
pub(crate) struct Adjustment {
    masters: Vec<CertifiedMaster>,
    /// Laboratories whose certificates share an error.
    laboratories: Vec<String>,
    observations: Vec<WeightedObservation>,
    thermometer: Thermometer,
    perfect: LensModel,
    u_lens: [f64; 4],
    frames: usize,
    /// Distances from the masters' plane that share an error w_y, mm.
    focus_mm: Vec<f64>,
    /// Step of each unknown that makes the normal equations dimensionless.
    unit: Vec<f64>,
    start: DVector<f64>,
}

/// A master, and its laboratory.
#[derive(Clone, Debug)]
struct CertifiedMaster {
    prior: MasterPrior,
    /// Index among the laboratories whose certificates share an error.
    laboratory: Option<usize>,
}

/// An observation, and how much it counts.
#[derive(Clone, Debug)]
struct WeightedObservation {
    seen: Observation,
    /// Own standard deviation of its residual, mm.
    sigma_mm: f64,
}

impl WeightedObservation {
    fn weight(&self) -> f64 {
        self.sigma_mm.powi(-2)
    }
}

/// Root of the mean of squares; 0 of none.
fn root_mean(squares: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = squares.fold((0.0, 0.0), |(sum, n), v| (sum + v, n + 1.0_f64));
    (sum / n.max(1.0)).sqrt()
}

/// Distances from the masters' plane at which masters were seen, but for the least: there w_y is
/// part of the offset.
fn out_of_plane(observations: &[Observation]) -> Vec<f64> {
    let mut all: Vec<f64> = observations.iter().map(|o| o.axis_y_mm).collect();
    all.sort_by(|a, b| a.abs().total_cmp(&b.abs()).then(a.total_cmp(b)));
    all.dedup();
    all.split_off(all.len().min(1))
}

/// Solves an adjustment again and again for data that deviate a little: the normal equations stay
/// those of its own data (chord method; a step leaves the problem's non-linearity, 1e-3, of the
/// error before it).
#[derive(Clone, Debug)]
pub(crate) struct Solver<'a> {
    adjustment: &'a Adjustment,
    start: DVector<f64>,
    inverse: DMatrix<f64>,
}

impl Solver<'_> {
    /// Parameters (s, o, a, q, g, t) from deviated data, as [`Adjustment::parameters_with`].
    pub(crate) fn parameters(&self, deviations: &[f64]) -> [f64; PARAMETERS] {
        let limits = AdjustmentLimits::get();
        let mut z = self.start.clone();
        for _ in 0..limits.chord_steps {
            let gradient = self.adjustment.gradient(&z, Some(deviations));
            z += &self.inverse * gradient;
        }
        std::array::from_fn(|k| z[k] * self.adjustment.unit[k])
    }
}

impl Adjustment {
    /// Sets the problem up.
    ///
    /// # Errors
    /// Refuses fewer than two masters, masters not seen or of one size, certificates without
    /// information.
    pub(crate) fn new(
        masters: Vec<MasterPrior>,
        observations: Vec<Observation>,
        thermometer: Thermometer,
        limits: &LensLimits,
        size: (usize, usize),
    ) -> Result<Self, CalibrationError> {
        let calibration_limits = CalibrationLimits::get();
        if masters.len() < 2 {
            return Err(CalibrationError::TooFew { found: masters.len() });
        }
        let mut means = Vec::new();
        for (index, master) in masters.iter().enumerate() {
            master.certificate.check(index)?;
            let widths: Vec<f64> = observations
                .iter()
                .filter(|o| o.master == index)
                .map(|o| (o.bottom_px - o.top_px) * o.chord)
                .collect();
            if widths.is_empty() {
                return Err(CalibrationError::Unseen { diameter_mm: master.certificate.diameter_mm });
            }
            means.push(widths.iter().sum::<f64>() / widths.len() as f64);
        }
        let spread_px = means.iter().fold(f64::NEG_INFINITY, |m, w| m.max(*w))
            - means.iter().fold(f64::INFINITY, |m, w| m.min(*w));
        if !(spread_px >= calibration_limits.least_spread_px) {
            return Err(CalibrationError::SameSize { spread_px });
        }
        let scale = masters[0].certificate.diameter_mm / means[0];
        let perfect = LensModel::perfect(size.0, size.1);
        let frames = observations.iter().map(|o| o.frame + 1).max().unwrap_or(0);
        let (laboratories, laboratory_of) = laboratories(&masters);
        let focus_mm = out_of_plane(&observations);
        let certified = |(prior, laboratory)| CertifiedMaster { prior, laboratory };
        let weighted = |seen: Observation| {
            let sigma_mm = (scale * seen.chord * seen.u_width_px).max(1e-9);
            WeightedObservation { seen, sigma_mm }
        };
        let mut adjustment = Self {
            laboratories,
            u_lens: limits.u_parameters(scale * perfect.half_diagonal_px),
            unit: Vec::new(),
            start: DVector::zeros(0),
            masters: masters.into_iter().zip(laboratory_of).map(certified).collect(),
            observations: observations.into_iter().map(weighted).collect(),
            thermometer,
            perfect,
            frames,
            focus_mm,
        };
        adjustment.unit = adjustment.units(scale);
        adjustment.start = DVector::zeros(adjustment.unit.len());
        adjustment.start[0] = scale / adjustment.unit[0];
        Ok(adjustment)
    }

    /// Steps that make every unknown about 1: prior uncertainties, and 1e-4 of the scale, 1 µm for
    /// the offset.
    fn units(&self, scale: f64) -> Vec<f64> {
        let some = |u: f64| u.max(1e-15);
        let [u_t, u_alpha] = self.thermometer.u();
        let mut unit = vec![1e-4 * scale, 1e-3];
        unit.extend(self.u_lens.map(some));
        unit.extend(self.masters.iter().map(|m| some(m.prior.u_own_mm())));
        // γ counts in standard uncertainties; c_p stands in the rows.
        unit.extend(self.laboratories.iter().map(|_| 1.0));
        unit.extend([some(u_t), some(u_alpha)]);
        unit.extend((0..self.frames).map(|f| some(self.u_frame(f))));
        unit.extend(self.focus_mm.iter().map(|y| some(self.u_focus(*y))));
        unit
    }

    /// Uncertainty that the columns of one frame share (levels), px: root mean square over its
    /// blocks. Levels are pooled over fewer columns than a frame has, and one clean block does not
    /// represent the others.
    fn u_frame(&self, frame: usize) -> f64 {
        let of_frame = self.observations().filter(|o| o.frame == frame);
        root_mean(of_frame.map(|o| (o.u_shared_px.powi(2) - o.u_misfit_px.powi(2)).max(0.0)))
    }

    /// Model uncertainty of the frames at a distance from the plane, px: root mean square over
    /// their blocks.
    fn u_focus(&self, y_mm: f64) -> f64 {
        root_mean(self.observations().filter(|o| o.axis_y_mm == y_mm).map(|o| o.u_misfit_px.powi(2)))
    }

    fn first_master(&self) -> usize {
        PARAMETERS
    }

    fn first_laboratory(&self) -> usize {
        PARAMETERS + self.masters.len()
    }

    fn thermal(&self) -> usize {
        self.first_laboratory() + self.laboratories.len()
    }

    /// Index of the unknown that a master's certificate shares, and c_p, mm.
    fn shared(&self, master: usize) -> Option<(usize, f64)> {
        let CertifiedMaster { prior, laboratory } = &self.masters[master];
        Some((self.first_laboratory() + (*laboratory)?, prior.u_common_mm()))
    }

    /// Diameter of a master at 20 °C with the errors of its certificate, mm.
    fn true_diameter_mm(&self, z: &DVector<f64>, master: usize) -> f64 {
        let v = |k: usize| z[k] * self.unit[k];
        let shared = self.shared(master).map_or(0.0, |(k, c)| c * v(k));
        self.masters[master].prior.certificate.diameter_mm + v(self.first_master() + master) + shared
    }

    fn first_frame(&self) -> usize {
        self.thermal() + 2
    }

    fn first_focus(&self) -> usize {
        self.first_frame() + self.frames
    }

    /// Which w_y an observation has; none in the masters' plane.
    fn focus_of(&self, o: &Observation) -> Option<usize> {
        self.focus_mm.iter().position(|y| *y == o.axis_y_mm).map(|k| self.first_focus() + k)
    }

    /// Number of deviations that [`Self::parameters_with`] takes: one for each observation's width
    /// (px), then one for each prior: a, q, g, t, the masters' δ_p, the laboratories' γ_g, δT, δα,
    /// the frames' ε_f, the w_y, in units of their standard uncertainties.
    pub(crate) fn inputs(&self) -> usize {
        self.observations.len() + self.unit.len() - 2
    }

    /// The masters.
    pub(crate) fn masters(&self) -> impl ExactSizeIterator<Item = &MasterPrior> {
        self.masters.iter().map(|master| &master.prior)
    }

    /// The observations.
    pub(crate) fn observations(&self) -> impl ExactSizeIterator<Item = &Observation> {
        self.observations.iter().map(|observation| &observation.seen)
    }

    /// Standard deviation of each observation's residual, mm, Birge's ratio included once it is
    /// solved.
    pub(crate) fn sigma_mm(&self) -> impl ExactSizeIterator<Item = f64> {
        self.observations.iter().map(|observation| observation.sigma_mm)
    }

    fn lens_of(&self, z: &DVector<f64>) -> LensModel {
        LensModel {
            radial: z[2] * self.unit[2],
            keystone_across: z[3] * self.unit[3],
            keystone_along: z[4] * self.unit[4],
            telecentricity_per_mm: z[5] * self.unit[5],
            ..self.perfect
        }
    }

    /// Residual of an observation whose width is `deviation_px` larger, mm.
    fn residual(&self, z: &DVector<f64>, lens: &LensModel, index: usize, deviation_px: f64) -> f64 {
        let o = &self.observations[index].seen;
        let v = |k: usize| z[k] * self.unit[k];
        let thermal = self.thermal();
        let alpha = self.thermometer.alpha() + v(thermal + 1);
        let warm = 1.0 + alpha * (self.thermometer.temperature_c + v(thermal) - 20.0);
        let width = lens.ideal_mean(o.along(), o.bottom_px) - lens.ideal_mean(o.along(), o.top_px);
        let focus = self.focus_of(o).map_or(0.0, v);
        let seen = width + deviation_px + v(self.first_frame() + o.frame) + focus;
        v(0) * (1.0 + v(5) * o.axis_y_mm) * seen * o.chord + v(1) - self.true_diameter_mm(z, o.master) * warm
    }

    /// Derivatives of the residual by the unknowns in their units, as (index, value).
    fn row(&self, z: &DVector<f64>, lens: &LensModel, index: usize) -> [(usize, f64); 12] {
        let o = &self.observations[index].seen;
        let v = |k: usize| z[k] * self.unit[k];
        let thermal = self.thermal();
        let lag = self.thermometer.temperature_c + v(thermal) - 20.0;
        let alpha = self.thermometer.alpha() + v(thermal + 1);
        let diameter = self.true_diameter_mm(z, o.master);
        // Without a laboratory the last entry adds nothing to the offset's.
        let (laboratory, c) = self.shared(o.master).unwrap_or((1, 0.0));
        let width = lens.ideal_mean(o.along(), o.bottom_px) - lens.ideal_mean(o.along(), o.top_px);
        let near = (1.0 + v(5) * o.axis_y_mm) * o.chord;
        let by = lens.width_by(o.along(), o.top_px, o.bottom_px);
        let scale = v(0);
        let rows = [
            (0, near * width),
            (1, 1.0),
            (2, scale * near * by[0]),
            (3, scale * near * by[1]),
            (4, scale * near * by[2]),
            (5, scale * o.axis_y_mm * width * o.chord),
            (self.first_master() + o.master, -(1.0 + alpha * lag)),
            (thermal, -diameter * alpha),
            (thermal + 1, -diameter * lag),
            (self.first_frame() + o.frame, scale * near),
            (laboratory, -c * (1.0 + alpha * lag)),
            self.focus_of(o).map_or((0, 0.0), |k| (k, scale * near)),
        ];
        rows.map(|(k, value)| (k, value * self.unit[k]))
    }

    /// Normal matrix of the observations alone.
    fn normal(&self, z: &DVector<f64>) -> DMatrix<f64> {
        let lens = self.lens_of(z);
        let mut normal = DMatrix::zeros(self.unit.len(), self.unit.len());
        for index in 0..self.observations.len() {
            let row = self.row(z, &lens, index);
            let weight = self.observations[index].weight();
            for (i, a) in row {
                for (j, b) in row {
                    normal[(i, j)] += weight * a * b;
                }
            }
        }
        normal
    }

    /// Solves for data that deviate: see [`Self::inputs`]. `None` where the masters do not
    /// determine the optical setup.
    fn solve(&self, deviations: Option<&[f64]>) -> Option<(DVector<f64>, DMatrix<f64>, DMatrix<f64>)> {
        let limits = AdjustmentLimits::get();
        let mut z = self.start.clone();
        let mut last = None;
        for _ in 0..limits.steps {
            let seen = self.normal(&z);
            let mut normal = seen.clone();
            for k in 2..self.unit.len() {
                normal[(k, k)] += 1.0;
            }
            let inverse = normal.cholesky()?.inverse();
            z += &inverse * self.gradient(&z, deviations);
            last = Some((inverse, seen));
        }
        last.map(|(inverse, seen)| (z, inverse, seen))
    }

    /// Right-hand side of the normal equations.
    fn gradient(&self, z: &DVector<f64>, deviations: Option<&[f64]>) -> DVector<f64> {
        let lens = self.lens_of(z);
        let mut right = DVector::zeros(self.unit.len());
        for index in 0..self.observations.len() {
            let moved = deviations.map_or(0.0, |d| d[index]);
            let weighted = self.residual(z, &lens, index, moved) * self.observations[index].weight();
            for (k, value) in self.row(z, &lens, index) {
                right[k] -= value * weighted;
            }
        }
        let first = self.observations.len();
        for k in 2..self.unit.len() {
            right[k] -= z[k] - deviations.map_or(0.0, |d| d[first + k - 2]);
        }
        right
    }

    /// Fits the optical setup. The Birge ratio, where above 1, goes into the weights, so that a
    /// second call changes nothing.
    ///
    /// # Errors
    /// Where the masters do not determine the optical setup.
    pub(crate) fn fit(&mut self) -> Result<Adjusted, CalibrationError> {
        let undetermined = || CalibrationError::SameSize { spread_px: 0.0 };
        self.look_for_misfit().ok_or_else(undetermined)?;
        let (z, _, _) = self.solve(None).ok_or_else(undetermined)?;
        let birge_ratio = self.birge_ratio(&z);
        if birge_ratio > 1.0 {
            self.observations.iter_mut().for_each(|o| o.sigma_mm *= birge_ratio);
        }
        let (z, inverse, seen) = self.solve(None).ok_or_else(undetermined)?;
        let lens = self.lens_of(&z);
        let residuals = (0..self.observations.len())
            .map(|index| {
                let WeightedObservation { seen: o, sigma_mm } = &self.observations[index];
                Residual {
                    master: o.master,
                    frame: o.frame,
                    column_px: o.column_px,
                    middle_px: 0.5 * (o.top_px + o.bottom_px),
                    axis_y_mm: o.axis_y_mm,
                    // The nuisances belong to the masters and the frames: shown is the residual of
                    // the optical setup.
                    residual_mm: self.residual(&self.without_nuisances(&z), &lens, index, 0.0),
                    u_mm: *sigma_mm,
                }
            })
            .collect();
        Ok(Adjusted {
            parameters: std::array::from_fn(|k| z[k] * self.unit[k]),
            lens,
            parts: self.parts(&inverse, &seen),
            residuals,
            birge_ratio,
        })
    }

    /// Sets the standard uncertainty of w_y from the residuals.
    fn look_for_misfit(&mut self) -> Option<()> {
        let limits = AdjustmentLimits::get();
        let groups = self.focus_mm.len();
        let (first, end) = (self.first_focus(), self.unit.len());
        let stated = self.unit[first..end].to_vec();
        let freedom = self.observations.len() as f64 - 2.0 - groups as f64;
        if groups == 0 || freedom < 1.0 {
            return Some(());
        }
        let (z, _, _) = self.solve(None)?;
        let held = self.chi2(&z);
        self.unit[first..end].fill(limits.free_px);
        let (z, _, _) = self.solve(None)?;
        let free = self.chi2(&z);
        let f = (held - free) / groups as f64 / (free / freedom).max(1.0);
        let limit = FisherSnedecor::new(groups as f64, freedom).ok()?.inverse_cdf(1.0 - limits.false_alarm);
        let square: f64 = (first..end).map(|k| (limits.free_px * z[k]).powi(2)).sum();
        let u_px = if f > limit { (square / groups as f64).sqrt() } else { 0.0 };
        for (unit, stated) in self.unit[first..end].iter_mut().zip(stated) {
            *unit = stated.max(u_px);
        }
        Some(())
    }

    fn without_nuisances(&self, z: &DVector<f64>) -> DVector<f64> {
        let mut bare = z.clone();
        bare.rows_mut(PARAMETERS, z.len() - PARAMETERS).fill(0.0);
        bare
    }

    /// √(χ²/ν) of the residuals and priors; χ² of all rows, freedom = rows − unknowns.
    fn birge_ratio(&self, z: &DVector<f64>) -> f64 {
        let freedom = self.observations.len() as f64 - 2.0;
        if freedom >= 1.0 { (self.chi2(z) / freedom).sqrt() } else { 1.0 }
    }

    /// χ² of all rows, observations and priors.
    fn chi2(&self, z: &DVector<f64>) -> f64 {
        let lens = self.lens_of(z);
        let seen: f64 = (0..self.observations.len())
            .map(|i| (self.residual(z, &lens, i, 0.0) / self.observations[i].sigma_mm).powi(2))
            .sum();
        seen + z.iter().skip(2).map(|v| v * v).sum::<f64>()
    }

    /// Parameters (s, o, a, q, g, t) from deviated data; `None` where they determine no optical
    /// setup.
    #[cfg(test)]
    pub(crate) fn parameters_with(&self, deviations: &[f64]) -> Option<[f64; PARAMETERS]> {
        let (z, _, _) = self.solve(Some(deviations))?;
        Some(std::array::from_fn(|k| z[k] * self.unit[k]))
    }

    /// A solver for many sets of deviated data; `None` where the masters determine no optical
    /// setup.
    pub(crate) fn solver(&self) -> Option<Solver<'_>> {
        let (start, inverse, _) = self.solve(None)?;
        Some(Solver { adjustment: self, start, inverse })
    }

    fn parts(&self, inverse: &DMatrix<f64>, seen: &DMatrix<f64>) -> Vec<CovariancePart> {
        let share = |source: &str, matrix: &DMatrix<f64>| CovariancePart {
            source: source.to_owned(),
            matrix: std::array::from_fn(|i| {
                std::array::from_fn(|j| matrix[(i, j)] * self.unit[i] * self.unit[j])
            }),
        };
        let of_priors = |range: std::ops::Range<usize>| {
            range.fold(DMatrix::zeros(self.unit.len(), self.unit.len()), |sum, k| {
                let column = inverse.column(k);
                sum + column * column.transpose()
            })
        };
        let frames = self.first_frame();
        let edges = inverse * seen * inverse + of_priors(frames..self.first_focus());
        let mut parts = vec![share(EDGES, &edges)];
        for (index, master) in self.masters.iter().enumerate() {
            let k = self.first_master() + index;
            parts.push(share(&format!("certificate of {}", master.prior.name), &of_priors(k..k + 1)));
        }
        for (index, name) in self.laboratories.iter().enumerate() {
            let k = self.first_laboratory() + index;
            parts.push(share(&shared_source(name), &of_priors(k..k + 1)));
        }
        let [temperature, expansion] = self.thermometer.sources();
        parts.push(share(temperature, &of_priors(self.thermal()..self.thermal() + 1)));
        parts.push(share(expansion, &of_priors(self.thermal() + 1..frames)));
        parts.push(share(DISTORTION, &of_priors(2..5)));
        parts.push(share(TELECENTRICITY, &of_priors(5..6)));
        if self.unit[self.first_focus()..].iter().any(|u| *u > 1e-12) {
            parts.push(share(MISFIT, &of_priors(self.first_focus()..self.unit.len())));
        }
        parts
    }

    /// The source of each of the [`Self::inputs`], by the name that it has in budgets.
    pub(crate) fn input_sources(&self) -> Vec<String> {
        let [temperature, expansion] = self.thermometer.sources();
        let mut all = vec![EDGES.to_owned(); self.observations.len()];
        all.extend([DISTORTION, DISTORTION, DISTORTION, TELECENTRICITY].map(str::to_owned));
        all.extend(self.masters().map(|m| format!("certificate of {}", m.name)));
        all.extend(self.laboratories.iter().map(|name| shared_source(name)));
        all.extend([temperature, expansion].map(str::to_owned));
        all.resize(self.inputs() - self.focus_mm.len(), EDGES.to_owned());
        all.resize(self.inputs(), MISFIT.to_owned());
        all
    }
}
