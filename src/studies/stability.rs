//! Stability of every controller with every plant: poles, limits of the plant gain, margin,
//! transients.

use serde::Serialize;

use crate::control::stability::{
    IterationReport, Plant, StabilityReport, integral_transfer, iteration, stable_gains, whittaker,
};
use crate::control::{ControlSettings, ControllerName, OffsetForm, assess, describe, transfer};

/// Error-transfer plant of paper 003, Fig. 11: e(k+1) = 1.3566 e(k) − g u(k).
pub(crate) const ERROR_TRANSFER: Plant = Plant::Transfer { alpha: 1.3566 };
/// Gains at which the spectral radius is plotted, in units of 0.01.
const DRAWN: std::ops::RangeInclusive<u32> = 1..=240;
const DRAWN_STEP: f64 = 0.01;

/// A run-to-run limit under delay.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct DelayLimit {
    /// Passes between a cut and its measurement's effect, beyond the next.
    pub delay: usize,
    /// Largest stable λ·b/b̂.
    pub limit: f64,
    /// 2 sin(π/(2(2d + 1))).
    pub closed_form: f64,
}

/// Spectral radius over the plant gain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Locus {
    /// Controller.
    pub controller: String,
    /// (g, spectral radius) with error copying.
    pub points: Vec<(f64, f64)>,
    /// (real, imaginary) of every pole at these gains.
    pub poles: Vec<(f64, f64)>,
}

/// The study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct StabilityStudy {
    /// Every controller with every plant at the configured gain.
    pub loops: Vec<StabilityReport>,
    /// Run-to-run limits under delay.
    pub delays: Vec<DelayLimit>,
    /// Iterative learning over all stations at once, with a plant that is a pure gain.
    pub learning: IterationReport,
    /// Spectral radius over the plant gain, error copying.
    #[serde(skip)]
    pub loci: Vec<Locus>,
}

/// Runs the study for the gains in `settings`, every controller in turn, PID in both forms.
pub(crate) fn run(settings: &ControlSettings, station_z_mm: &[f64]) -> StabilityStudy {
    let variants = variants(settings);
    let plants = [Plant::Constant, Plant::Copying, ERROR_TRANSFER];
    let loops =
        variants.iter().flat_map(|v| plants.into_iter().filter_map(move |plant| assess(v, plant))).collect();
    StabilityStudy {
        loops,
        delays: (0..3).map(delay_limit).collect(),
        learning: learning(settings, station_z_mm),
        loci: variants.iter().filter_map(locus).collect(),
    }
}

fn variants(settings: &ControlSettings) -> Vec<ControlSettings> {
    let mut variants = Vec::new();
    for controller in ControllerName::ALL {
        let mut one = ControlSettings { controller, ..settings.clone() };
        if controller == ControllerName::Pid {
            for form in [OffsetForm::Absolute, OffsetForm::Accumulated] {
                one.pid.form = form;
                variants.push(one.clone());
            }
        } else if controller != ControllerName::None {
            variants.push(one);
        }
    }
    variants
}

fn delay_limit(delay: usize) -> DelayLimit {
    let gains = stable_gains(&integral_transfer(1.0).delayed(delay), Plant::Constant);
    DelayLimit {
        delay,
        limit: gains.last().map_or(0.0, |range| range.1),
        closed_form: 2.0 * (std::f64::consts::PI / (2.0 * (2.0 * delay as f64 + 1.0))).sin(),
    }
}

fn learning(settings: &ControlSettings, station_z_mm: &[f64]) -> IterationReport {
    let n = station_z_mm.len();
    let plant = nalgebra::DMatrix::identity(n, n) * settings.plant_gain;
    iteration(&whittaker(settings.ilc.q_cutoff_mm, station_z_mm), settings.ilc.learning_gain, &plant)
}

fn locus(settings: &ControlSettings) -> Option<Locus> {
    let transfer = transfer(settings)?;
    let (mut points, mut poles) = (Vec::new(), Vec::new());
    for g in DRAWN.map(|i| f64::from(i) * DRAWN_STEP) {
        let roots = transfer.closed_loop(Plant::Copying, g).roots();
        points.push((g, roots.first().map_or(0.0, |p| p.0.hypot(p.1))));
        poles.extend(roots);
    }
    Some(Locus { controller: describe(settings), points, poles })
}
