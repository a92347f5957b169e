//! Model-based control: predict the next pass, and command the diameter whose predicted result is
//! the nominal one.
//!
//! ```text
//! observed    y = (D − b)/2                     deflection of the shaft, mm of radius
//! estimated   y = s·w(z; k_c, k_t)·F(a) + l₀ + l₁ξ + j (t₀ + t₁ξ) + n(j) + c(z, j)
//! depth cut   a = (D_before − D)/2, F(a) = C·a^x·f^y·v^z
//! commanded   b = r − 2ŷ with a = (D − r)/2, the depth if the pass leaves r; o = r − b = 2ŷ
//! ```
//!
//! z from the chuck, ξ ∈ [−1, 1] along the stations, j the passes since the first. w: beam clamped
//! in a yielding chuck, held by a yielding tailstock; of a stepped shaft, or one in steady rests,
//! by the force method ([`super::stepped_beam`]). The scale s, both stiffnesses, the stock's mean
//! diameter, a constant and a taper of the machine and their growth per pass are estimated from all
//! measured passes by penalised least squares (a Gaussian prior from the settings' uncertainties,
//! Gauss-Newton), together with n, the part that is common to all stations of one pass and not
//! repeated in the next. The remainder at a station is modelled by its own level and trend c: a
//! Kalman filter of two states, because a model of eight parameters never explains a machine
//! completely. The plant gain g = 1/(1 + s·w·F′) follows from the same parameters.
//!
//! Valid while F is steep enough to be observable and the depth is above the minimum chip. The
//! half-cut shaft is approximated by one diameter and by Euler-Bernoulli theory; s and c absorb
//! both errors.

use super::proposal::{Feedforward, Law, Observation, Proposal};
use super::stepped_beam::{self, SteppedBeam};
use crate::control::readings::StationError;
use crate::control::settings::{ModelSettings, Workpiece};
use crate::plan::{CuttingData, Piece, StationLayout};
use nalgebra::{DMatrix, DVector};

/// ln s, ln chuck, ln tailstock, stock, l₀, l₁, t₀, t₁; one n per pass follows them.
const SHARED: usize = 8;
/// Gauss-Newton converges quadratically here; the third step is below 1e-6 of the prior.
const ITERATIONS: usize = 8;
/// Step of the numerical derivative, in prior standard deviations.
const DERIVATIVE_STEP: f64 = 1e-4;
/// Depth below which the force law is not evaluated, because its slope grows without limit towards
/// zero, mm.
const LEAST_DEPTH_MM: f64 = 1e-3;

type Theta = DVector<f64>;

/// The observation of one pass.
#[derive(Clone, Debug)]
struct Pass {
    stations: Vec<PassStation>,
    cutting: CuttingData,
    /// Whether the stations' `before_mm` were measured.
    before: Before,
    /// Number of the pass, from 0.
    index: usize,
}

/// A station of a pass.
#[derive(Clone, Copy, Debug)]
struct PassStation {
    /// y, mm of radius.
    pushed_mm: f64,
    /// Standard uncertainty of y, mm of radius.
    u_mm: f64,
    before_mm: f64,
    after_mm: f64,
}

/// Where the diameters before a pass come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Before {
    Measured,
    /// The stock's nominal diameter.
    Stock,
    /// The nominal diameter of the pass before, which was not measured or not accepted.
    Nominal,
}

/// Model-based law.
#[derive(Clone, Debug)]
pub(crate) struct ModelLaw {
    settings: ModelSettings,
    shaft: AssumedShaft,
    stock_mm: Option<Vec<f64>>,
    passes: Vec<Pass>,
}

/// The shaft as the controller assumes it.
#[derive(Clone, Debug)]
struct AssumedShaft {
    workpiece: Workpiece,
    z_mm: Vec<f64>,
    /// Nominal diameter of every station less that of the pass, mm.
    relative_mm: Vec<f64>,
    /// Pieces of a stepped shaft, or of one in steady rests; none of a plain one.
    pieces: Vec<Piece>,
    steady_z_mm: Vec<f64>,
}

impl AssumedShaft {
    fn new(workpiece: Workpiece, stations: &StationLayout) -> Self {
        let is_plain = stations.contour.is_none() && stations.steady_z_mm.is_empty();
        let pieces = || stepped_beam::pieces(stations.contour.as_ref(), workpiece.length_mm);
        Self {
            workpiece,
            z_mm: stations.z_mm.clone(),
            relative_mm: stations.relative_mm(),
            pieces: if is_plain { Vec::new() } else { pieces() },
            steady_z_mm: stations.steady_z_mm.clone(),
        }
    }

    /// Deflection at station i under a unit load there, mm/N, where its diameter is `diameter_mm`;
    /// stiffness of chuck and tailstock in N/mm.
    fn compliance(&self, i: usize, diameter_mm: f64, (chuck, tailstock): (f64, f64)) -> f64 {
        let (length_mm, e_n_per_mm2) = (self.workpiece.length_mm, self.workpiece.youngs_modulus_n_per_mm2);
        if self.pieces.is_empty() {
            let beam = Beam { length_mm, e_n_per_mm2, diameter_mm };
            return beam.compliance(self.z_mm[i], chuck, tailstock);
        }
        let beam = SteppedBeam {
            pieces: &self.pieces,
            length_mm,
            e_n_per_mm2,
            diameter_mm: diameter_mm - self.relative_mm[i],
            steady_z_mm: &self.steady_z_mm,
            chuck,
            tailstock,
        };
        beam.compliance(self.z_mm[i])
    }
}

impl ModelLaw {
    pub(crate) fn new(settings: &ModelSettings, stations: &StationLayout) -> Self {
        let shaft = AssumedShaft::new(settings.workpiece(), stations);
        Self { settings: settings.clone(), shaft, stock_mm: None, passes: Vec::new() }
    }

    /// Diameters of the stations where that of the largest section is `nominal_mm`.
    fn at_stations(&self, nominal_mm: f64) -> Vec<f64> {
        self.shaft.relative_mm.iter().map(|r| nominal_mm + r).collect()
    }

    fn remember(&mut self, seen: &Observation<'_>) {
        let index = (seen.plan.pass as usize).saturating_sub(1);
        let last = self.passes.last().filter(|p| p.index + 1 == index);
        let last = last.map(|p| p.stations.iter().map(|s| s.after_mm).collect());
        let (before, before_mm) = match (index, last, &self.stock_mm) {
            (_, Some(last), _) => (Before::Measured, last),
            (0, None, Some(stock)) => (Before::Measured, stock.clone()),
            (0, None, None) => (Before::Stock, self.at_stations(self.shaft.workpiece.stock_diameter_mm)),
            (_, None, _) => (Before::Nominal, self.at_stations(self.one_more(seen))),
        };
        let repeatability = self.settings.repeatability_mm;
        let planned = seen.plan.commanded_mm().zip(seen.plan.station_nominal_mm());
        let stations = seen.errors.stations.iter().zip(planned).zip(before_mm);
        let station = |((s, (commanded, nominal)), before_mm): ((&StationError, (f64, f64)), f64)| {
            let after_mm = s.e_mm + nominal;
            PassStation {
                pushed_mm: 0.5 * (after_mm - commanded),
                u_mm: repeatability.hypot(0.5 * s.u_random_mm),
                before_mm,
                after_mm,
            }
        };
        let pass =
            Pass { stations: stations.map(station).collect(), before, index, cutting: seen.plan.cutting };
        self.passes.push(pass);
    }
}

impl Law for ModelLaw {
    fn begin(&mut self, stock_mm: Option<Vec<f64>>) {
        self.stock_mm = stock_mm;
        self.passes.clear();
    }

    fn propose(&mut self, seen: &Observation<'_>) -> Proposal {
        self.remember(seen);
        let model = Model { settings: &self.settings, shaft: &self.shaft };
        let rough = model.estimate(&self.passes, 0.0);
        let misfit = model.misfit(&rough, &self.passes);
        let theta = model.estimate(&self.passes, misfit);
        let carried = model.carried(&theta, &self.passes, misfit);
        let (nominal, cutting) = match seen.next {
            Some(next) => (next.nominal_mm, next.cutting),
            None => (self.same_again(seen), seen.plan.cutting),
        };
        let j = seen.plan.pass as usize;
        let mut gains = (f64::INFINITY, 0.0_f64);
        let after = seen.errors.stations.iter().zip(seen.plan.station_nominal_mm()).map(|(s, r)| s.e_mm + r);
        let targets = self.at_stations(nominal);
        let o_mm = after
            .zip(&carried)
            .enumerate()
            .map(|(i, (before, c))| {
                let cut = Cut { before_mm: before, after_mm: targets[i], cutting: &cutting };
                let gain = model.gain(&theta, i, &cut);
                gains = (gains.0.min(gain), gains.1.max(gain));
                2.0 * (model.pushed(&theta, i, j, &cut) + c)
            })
            .collect();
        Proposal::with_notes(o_mm, vec![note(&theta, gains)])
    }

    fn feedforward(&self) -> Feedforward {
        Feedforward::Nothing
    }
}

impl ModelLaw {
    /// Diameter before a pass whose predecessor was not accepted, mm: this pass removed as much as
    /// the next one will.
    fn one_more(&self, seen: &Observation<'_>) -> f64 {
        match seen.next {
            Some(next) => 2.0 * seen.plan.nominal_mm - next.nominal_mm,
            None => self.same_before(seen),
        }
    }

    fn same_before(&self, seen: &Observation<'_>) -> f64 {
        let passes = f64::from(seen.plan.pass.max(1));
        seen.plan.nominal_mm + (self.shaft.workpiece.stock_diameter_mm - seen.plan.nominal_mm) / passes
    }

    /// Target of a next pass that is not given, mm: it removes as much as this one was planned to.
    fn same_again(&self, seen: &Observation<'_>) -> f64 {
        2.0 * seen.plan.nominal_mm - self.same_before(seen)
    }
}

fn note(theta: &Theta, gains: (f64, f64)) -> String {
    format!(
        "estimated: plant gain {:.3}-{:.3}, force × {:.3}, chuck stiffness × {:.2}, tailstock stiffness × {:.2}, \
         machine {:+.2} {:+.2}ξ µm, growing {:+.2} {:+.2}ξ µm a pass",
        gains.0,
        gains.1,
        theta[0].exp(),
        theta[1].exp(),
        theta[2].exp(),
        theta[4] * 1e3,
        theta[5] * 1e3,
        theta[6] * 1e3,
        theta[7] * 1e3,
    )
}

/// A station's diameters before and after a pass.
struct Cut<'a> {
    before_mm: f64,
    after_mm: f64,
    cutting: &'a CuttingData,
}

struct Model<'a> {
    settings: &'a ModelSettings,
    shaft: &'a AssumedShaft,
}

impl Model<'_> {
    /// Prior standard deviations of θ; its means are zero.
    fn prior(&self, passes: usize) -> Theta {
        let s = self.settings;
        let mut prior = vec![
            self.shaft.workpiece.u_ln_coefficient,
            s.u_ln_stiffness,
            s.u_ln_stiffness,
            s.u_stock_mean_mm,
            s.u_machine_mm,
            s.u_machine_mm,
            s.u_trend_mm,
            s.u_trend_mm,
        ];
        prior.resize(SHARED + passes, s.u_pass_mm);
        Theta::from_vec(prior)
    }

    /// Deflection per newton of force law at station i, the scale included, mm/N.
    fn yields(&self, theta: &Theta, i: usize, cut: &Cut<'_>) -> f64 {
        let w = &self.shaft.workpiece;
        let supports = (w.chuck_n_per_um * 1e3 * theta[1].exp(), w.tailstock_n_per_um * 1e3 * theta[2].exp());
        let diameter = 0.5 * (cut.before_mm + cut.after_mm);
        theta[0].exp() * self.shaft.compliance(i, diameter, supports)
    }

    fn force_n(&self, depth_mm: f64, cutting: &CuttingData) -> f64 {
        let w = &self.shaft.workpiece;
        w.coefficient_n
            * depth_mm.max(LEAST_DEPTH_MM).powf(w.depth_exponent)
            * cutting.feed_mm_per_rev.powf(w.feed_exponent)
            * cutting.speed_m_per_min.powf(w.speed_exponent)
    }

    /// ŷ without c, mm of radius.
    fn pushed(&self, theta: &Theta, i: usize, j: usize, cut: &Cut<'_>) -> f64 {
        let depth = 0.5 * (cut.before_mm - cut.after_mm);
        let xi = self.xi(i);
        self.yields(theta, i, cut) * self.force_n(depth, cut.cutting)
            + theta[4]
            + theta[5] * xi
            + j as f64 * (theta[6] + theta[7] * xi)
            + theta.get(SHARED + j).copied().unwrap_or(0.0)
    }

    /// g = 1/(1 + s·w·F′).
    fn gain(&self, theta: &Theta, i: usize, cut: &Cut<'_>) -> f64 {
        let depth = (0.5 * (cut.before_mm - cut.after_mm)).max(LEAST_DEPTH_MM);
        let slope = self.shaft.workpiece.depth_exponent * self.force_n(depth, cut.cutting) / depth;
        1.0 / (1.0 + self.yields(theta, i, cut) * slope)
    }

    fn xi(&self, i: usize) -> f64 {
        let z_mm = &self.shaft.z_mm;
        let (first, last) = (z_mm[0], z_mm[z_mm.len() - 1]);
        if last > first { 2.0 * (z_mm[i] - first) / (last - first) - 1.0 } else { 0.0 }
    }

    fn cut<'p>(theta: &Theta, pass: &'p Pass, i: usize) -> Cut<'p> {
        let (at, shift) = (&pass.stations[i], if pass.before == Before::Stock { theta[3] } else { 0.0 });
        Cut { before_mm: at.before_mm + shift, after_mm: at.after_mm, cutting: &pass.cutting }
    }

    fn residual(&self, theta: &Theta, passes: &[Pass], i: usize, j: usize) -> f64 {
        passes[j].stations[i].pushed_mm
            - self.pushed(theta, i, passes[j].index, &Self::cut(theta, &passes[j], i))
    }

    /// Variance of a residual: repeatability, reading and, where the stock was not measured, the
    /// copied share of its form.
    fn variance(&self, theta: &Theta, pass: &Pass, i: usize) -> f64 {
        let copied = if pass.before == Before::Measured {
            0.0
        } else {
            let gain = self.gain(theta, i, &Self::cut(theta, pass, i));
            0.5 * self.settings.stock_form_mm * (1.0 / gain - 1.0)
        };
        pass.stations[i].u_mm.powi(2) + copied.powi(2)
    }

    /// Root mean square of the residuals beyond noise in the passes whose stock was measured, mm of
    /// radius: where it is large the shared parameters have less weight and the stations' own
    /// levels more.
    fn misfit(&self, theta: &Theta, passes: &[Pass]) -> f64 {
        let known = passes.iter().enumerate().filter(|(_, p)| p.before == Before::Measured);
        let (mut sum, mut count) = (0.0, 0);
        for (j, pass) in known {
            for i in 0..self.shaft.z_mm.len() {
                sum += self.residual(theta, passes, i, j).powi(2) - self.variance(theta, pass, i);
                count += 1;
            }
        }
        if count > 0 { (sum / f64::from(count)).max(0.0).sqrt() } else { 0.0 }
    }

    /// Penalised least squares over all passes.
    fn estimate(&self, passes: &[Pass], misfit: f64) -> Theta {
        let prior = self.prior(passes.last().map_or(0, |p| p.index + 1));
        let mut theta = Theta::zeros(prior.len());
        for _ in 0..ITERATIONS {
            let mut normal = DMatrix::from_diagonal(&prior.map(|p| p.powi(-2)));
            let mut right = theta.component_div(&prior).component_div(&prior) * -1.0;
            for (j, pass) in passes.iter().enumerate() {
                for i in 0..self.shaft.z_mm.len() {
                    let slope = Self::slope(&theta, &prior, |t| self.residual(t, passes, i, j));
                    let weight = (self.variance(&theta, pass, i) + misfit.powi(2)).recip();
                    normal.ger(weight, &slope, &slope, 1.0);
                    right += slope * (self.residual(&theta, passes, i, j) * weight);
                }
            }
            let Some(cholesky) = normal.cholesky() else {
                return theta;
            };
            // a step beyond three prior standard deviations would leave the model's range
            let step = cholesky.solve(&right);
            let reach = step.component_div(&prior).amax().max(3.0) / 3.0;
            theta += step / reach;
        }
        theta
    }

    /// ∂ŷ/∂θ by central differences of a residual y − ŷ(θ).
    fn slope(theta: &Theta, prior: &Theta, residual: impl Fn(&Theta) -> f64) -> Theta {
        Theta::from_fn(theta.len(), |p, _| {
            let step = DERIVATIVE_STEP * prior[p];
            let moved = |sign: f64| {
                let mut t = theta.clone();
                t[p] += sign * step;
                residual(&t)
            };
            (moved(-1.0) - moved(1.0)) / (2.0 * step)
        })
    }

    /// c(z, j) of the coming pass: level and trend of every station's residuals, by a Kalman
    /// filter.
    fn carried(&self, theta: &Theta, passes: &[Pass], misfit: f64) -> Vec<f64> {
        let s = self.settings;
        (0..self.shaft.z_mm.len())
            .map(|i| {
                let mut station = LevelAndTrend::new(s.u_station_mm.max(misfit), s.u_station_trend_mm);
                for (j, pass) in passes.iter().enumerate() {
                    station.update(self.residual(theta, passes, i, j), self.variance(theta, pass, i));
                }
                station.level
            })
            .collect()
    }
}

/// A level that grows by a trend every pass; both are uncertain, the level is observed.
struct LevelAndTrend {
    level: f64,
    trend: f64,
    /// Covariance: level, level-trend, trend.
    p: (f64, f64, f64),
    /// Variance added to the trend per pass.
    q: f64,
}

impl LevelAndTrend {
    fn new(u_level: f64, u_trend: f64) -> Self {
        Self { level: 0.0, trend: 0.0, p: (u_level.powi(2), 0.0, u_trend.powi(2)), q: 0.25 * u_trend.powi(2) }
    }

    /// Updates the state by an observation and predicts the next pass.
    fn update(&mut self, seen: f64, variance: f64) {
        let (p00, p01, p11) = self.p;
        let (k0, k1) = (p00 / (p00 + variance), p01 / (p00 + variance));
        let innovation = seen - self.level;
        self.level += k0 * innovation;
        self.trend += k1 * innovation;
        let (p00, p01, p11) = ((1.0 - k0) * p00, (1.0 - k0) * p01, p11 - k1 * p01);
        self.level += self.trend;
        self.p = (p00 + 2.0 * p01 + p11, p01 + p11, p11 + self.q);
    }
}

/// A shaft of one diameter.
struct Beam {
    length_mm: f64,
    e_n_per_mm2: f64,
    diameter_mm: f64,
}

impl Beam {
    /// Deflection under a unit radial load at a: clamped in a chuck that yields sideways by 1/k_c,
    /// supported at L by a tailstock of stiffness k_t, which the reaction R deflects by R/k_t
    /// (Euler-Bernoulli, superposition).
    fn compliance(&self, a: f64, chuck: f64, tailstock: f64) -> f64 {
        let ei = self.e_n_per_mm2 * std::f64::consts::PI * self.diameter_mm.powi(4) / 64.0;
        let l = self.length_mm;
        let coupling = a * a * (3.0 * l - a) / (6.0 * ei) + 1.0 / chuck;
        let reaction = coupling / (l.powi(3) / (3.0 * ei) + 1.0 / chuck + 1.0 / tailstock);
        a.powi(3) / (3.0 * ei) + 1.0 / chuck - reaction * coupling
    }
}

/// Smallest plant gain of the model as configured, for a depth of cut and cutting data.
pub(crate) fn nominal_gain(settings: &ModelSettings, depth_mm: f64, cutting: &CuttingData) -> f64 {
    let workpiece = settings.workpiece();
    let z_mm: Vec<f64> = (0..=100).map(|i| workpiece.length_mm * f64::from(i) / 100.0).collect();
    let shaft = AssumedShaft::new(workpiece, &StationLayout::from(&z_mm));
    let model = Model { settings, shaft: &shaft };
    let d = workpiece.stock_diameter_mm;
    let cut = Cut { before_mm: d, after_mm: d - 2.0 * depth_mm, cutting };
    (0..z_mm.len()).map(|i| model.gain(&Theta::zeros(SHARED), i, &cut)).fold(1.0, f64::min)
}
