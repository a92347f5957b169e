//! Figures of a class of scenes.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::Serialize;

use super::class::Class;
use super::outcome::Outcome;
use super::scene;
use crate::render::Renderer;
use crate::studies::calibration::CalibrateError;

/// Figures of a class.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct ClassFigures {
    /// The class; none where several are pooled.
    pub class: Option<Class>,
    /// Scenes run.
    pub scenes: usize,
    /// Scenes accepted: measured without a warning.
    pub accepted: usize,
    /// Share of the accepted whose interval covers the truth.
    pub covered: f64,
    /// Share of all scenes that were refused or warned of.
    pub flagged: f64,
    /// Mean half width of the 95 % intervals of the accepted, µm.
    pub mean_half_um: f64,
    /// 95th percentile of their |error|, µm.
    pub p95_error_um: f64,
    /// rms of error over u of the accepted.
    pub rms_error_over_u: f64,
    /// Largest |error| over half width of the accepted.
    pub worst_error_over_half: f64,
    /// Scenes refused or warned of, by reason.
    pub flags: BTreeMap<String, usize>,
}

impl ClassFigures {
    /// Name of the class.
    pub(crate) fn name(&self) -> String {
        self.class.map_or("all of them".to_owned(), |class| format!("{class:?}"))
    }

    /// Share of the scenes outside the limits that are handled, i.e. flagged. A light unlike the
    /// masters' widens U by its residual, so that there an interval that covers the truth counts as
    /// well.
    pub(crate) fn handled(&self) -> f64 {
        let covered =
            if self.class == Some(Class::OtherLight) && self.accepted > 0 { self.covered } else { 0.0 };
        self.flagged + (1.0 - self.flagged) * covered
    }

    /// Mean half width over the 95th percentile of the error.
    pub(crate) fn half_over_p95(&self) -> f64 {
        self.mean_half_um / self.p95_error_um
    }
}

/// Scenes of one class; `done` is called after each.
///
/// # Errors
/// The first scene whose masters cannot be drawn or measured.
pub(crate) fn class_figures(
    class: Class,
    scenes: usize,
    seed: u64,
    renderer: &Renderer,
    done: &(dyn Fn() + Sync),
) -> Result<ClassFigures, CalibrateError> {
    let outcome = |i: u64| scene::run(class, scene_seed(class, seed, i), renderer).inspect(|_| done());
    let outcomes: Vec<Outcome> =
        (0..scenes as u64).into_par_iter().map(outcome).collect::<Result<_, CalibrateError>>()?;
    Ok(figures(Some(class), &outcomes))
}

/// Seed of scene `index` of a class.
pub(super) fn scene_seed(class: Class, seed: u64, index: u64) -> u64 {
    seed.wrapping_mul(1_000_003).wrapping_add((class as u64) << 32).wrapping_add(index)
}

/// Figures of outcomes, in the order of their scenes: of one class, or of several together.
pub(super) fn figures(class: Option<Class>, outcomes: &[Outcome]) -> ClassFigures {
    let accepted: Vec<(f64, f64, f64)> = outcomes
        .iter()
        .filter(|o| o.flag.is_empty())
        .filter_map(|o| o.error_mm.map(|e| (e.abs(), o.u_mm, o.half_mm)))
        .collect();
    let n = accepted.len().max(1) as f64;
    let mean = |f: &dyn Fn(&(f64, f64, f64)) -> f64| accepted.iter().map(f).sum::<f64>() / n;
    let mut errors: Vec<f64> = accepted.iter().map(|a| a.0).collect();
    errors.sort_by(f64::total_cmp);
    let mut flags = BTreeMap::new();
    for outcome in outcomes.iter().filter(|o| !o.flag.is_empty()) {
        *flags.entry(outcome.flag.clone()).or_insert(0) += 1;
    }
    let at = ((0.95 * errors.len() as f64) as usize).min(errors.len().saturating_sub(1));
    ClassFigures {
        class,
        scenes: outcomes.len(),
        accepted: accepted.len(),
        covered: mean(&|a| f64::from(u8::from(a.0 <= a.2))),
        flagged: 1.0 - accepted.len() as f64 / outcomes.len().max(1) as f64,
        mean_half_um: 1e3 * mean(&|a| a.2),
        p95_error_um: 1e3 * errors.get(at).copied().unwrap_or(f64::NAN),
        rms_error_over_u: mean(&|a| (a.0 / a.1).powi(2)).sqrt(),
        worst_error_over_half: accepted.iter().map(|a| a.0 / a.2).fold(0.0, f64::max),
        flags,
    }
}
