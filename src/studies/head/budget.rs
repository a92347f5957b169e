//! The budget of a diameter behind a head: its masters rendered, the optical setup adjusted, as
//! `study uncertainty` does, and what would halve the largest row of it.

use serde::Serialize;

use super::error::HeadError;
use super::motion::{MOTION, MotionEffect};
use super::setup::HeadSetup;
use crate::frame::Frame;
use crate::gauge::budget::{Budget, Contribution, Shape, Share};
use crate::gauge::calibration::{Date, LensLimits};
use crate::render::Renderer;
use crate::studies::calibration::{
    CalibrateError, CalibrationPlan, PinPlan, Position, Recordings, SimulatedRecordings, calibrate,
};
use crate::studies::uncertainty::PartView;

/// Rows below this share of u are left out: they change it by 5e-9 of it.
const LEAST_ROW: f64 = 1e-4;

/// A row of the budget.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct BudgetRow {
    /// The source, by its name in `measure --budget`.
    pub source: String,
    /// Whether it averages.
    pub share: Share,
    /// Standard uncertainty it gives the diameter, µm.
    pub u_um: f64,
}

/// The uncertainty of a diameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct HeadBudget {
    /// Random standard uncertainty, µm.
    pub u_random_um: f64,
    /// Common standard uncertainty, µm.
    pub u_common_um: f64,
    /// Combined standard uncertainty, µm.
    pub u_um: f64,
    /// Coverage factor k of 95.45 %.
    pub coverage_factor: f64,
    /// Expanded uncertainty U = k·u, µm.
    pub expanded_u_um: f64,
    /// Its rows, largest first.
    pub rows: Vec<BudgetRow>,
}

impl HeadBudget {
    /// Of a budget.
    fn of(budget: &Budget) -> Self {
        let coverage_factor = budget.factor_or(None);
        let um =
            |c: &Contribution| BudgetRow { source: c.source.clone(), share: c.share, u_um: 1e3 * c.u_mm };
        let counts = |c: &&Contribution| !(c.u_mm < LEAST_ROW * budget.u_mm());
        let mut rows: Vec<BudgetRow> = budget.contributions.iter().filter(counts).map(um).collect();
        rows.sort_by(|a, b| b.u_um.total_cmp(&a.u_um));
        Self {
            u_random_um: 1e3 * budget.u_random_mm(),
            u_common_um: 1e3 * budget.u_common_mm(),
            u_um: 1e3 * budget.u_mm(),
            coverage_factor,
            expanded_u_um: 1e3 * coverage_factor * budget.u_mm(),
            rows,
        }
    }

    /// What limits it, and what would halve that.
    pub(super) fn limit(&self) -> Option<HeadLimit> {
        let largest = self.rows.first()?;
        let left = self.u_um * self.u_um - 0.75 * largest.u_um * largest.u_um;
        Some(HeadLimit {
            source: largest.source.clone(),
            u_um: largest.u_um,
            remedy: remedy(&largest.source),
            expanded_u_after_um: self.coverage_factor * left.max(0.0).sqrt(),
        })
    }
}

/// The largest row of a budget.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct HeadLimit {
    /// The source.
    pub source: String,
    /// Its standard uncertainty, µm.
    pub u_um: f64,
    /// What would halve it.
    pub remedy: &'static str,
    /// U with half of it, µm.
    pub expanded_u_after_um: f64,
}

/// Beginnings of a row's source, and what would halve the row. Random rows fall with the root of
/// the light, columns or frames.
const REMEDIES: [(&str, &str); 14] = [
    ("noise of the edges", MORE_LIGHT),
    ("levels of light", MORE_LIGHT),
    ("blur", MORE_LIGHT),
    ("quantisation", "one bit more a pixel"),
    ("form, texture", "four times the columns or frames that are averaged"),
    (MOTION, "half the exposure with twice the light (a strobe), half the speed, or half the run-out"),
    ("temperature", "half the limits of the thermometer"),
    ("expansion", "half the limits of the coefficient, or measure at half the distance from 20 °C"),
    ("focus", "half the limits of the part's distance, or half the telecentricity error"),
    ("telecentricity", "half the telecentricity error, or masters at two distances"),
    ("distortion", "masters at more heights of the field, or a lens of half the distortion"),
    ("edges unlike", "masters of the part's own finish"),
    ("drift", "half the time between looks at a master"),
    ("certificate", "certificates of half the U, or masters nearer to the part's diameter"),
];

/// What halves noise.
const MORE_LIGHT: &str = "four times the light or columns, or four frames a reading";

fn remedy(source: &str) -> &'static str {
    let known = REMEDIES.iter().find(|(begins, _)| source.starts_with(begins));
    known.map_or("four times the frames of the masters", |(_, remedy)| remedy)
}

/// The budget at rest and in use; `recorded` is called for every frame of a master.
pub(super) struct Budgets {
    at_rest: Budget,
}

impl Budgets {
    /// Calibrates the head on its masters.
    ///
    /// # Errors
    /// Masters that cannot be drawn or measured, or whose field does not hold the diameter.
    pub(super) fn of(
        head: &HeadSetup,
        renderer: &Renderer,
        date: Date,
        recorded: &dyn Fn(u64),
    ) -> Result<Self, HeadError> {
        let plan = plan(head, date);
        plan.validate()?;
        let mut recordings = Counted { inner: SimulatedRecordings::new(&plan, renderer)?, recorded };
        let calibrated = calibrate(&plan, &mut recordings)?;
        let part = calibrated.reading.as_ref().and_then(|like| {
            PartView::of_diameter(head.diameter_mm, like, &calibrated.calibration, &head.conditions)
        });
        let part = part.ok_or(HeadError::NoBudget(head.diameter_mm))?;
        Ok(Self { at_rest: part.budget().clone() })
    }

    /// With the part at rest.
    pub(super) fn at_rest(&self) -> HeadBudget {
        HeadBudget::of(&self.at_rest)
    }

    /// With the part turning; none where nothing is measured then.
    pub(super) fn in_use(&self, motion: &MotionEffect) -> Option<HeadBudget> {
        if motion.refused.is_some() {
            return None;
        }
        let mut budget = self.at_rest.clone();
        budget.push(Contribution {
            source: MOTION.to_owned(),
            input: format!("path of {:.3} µm", motion.path_um),
            shape: Shape::Normal,
            share: Share::Random,
            freedom: None,
            u_mm: 1e-3 * motion.u_um,
        });
        Some(HeadBudget::of(&budget))
    }
}

/// The plan of the head's calibration.
fn plan(head: &HeadSetup, date: Date) -> CalibrationPlan {
    let mut plan = CalibrationPlan::of_job(&head.job, date);
    plan.gauge = head.gauge.clone();
    plan.conditions = head.conditions;
    let stated = head.job.optics.telecentricity_mrad.abs();
    if stated > 0.0 {
        plan.lens = LensLimits { telecentricity_deg: (1e-3 * stated).to_degrees(), ..plan.lens };
    }
    plan
}

/// Frames that the calibration of a head records.
pub(super) fn frames_of_masters(head: &HeadSetup) -> u64 {
    (HEIGHTS * head.job.masters.pins.len() * head.job.masters.frames_each) as u64
}

/// Heights of the field at which [`CalibrationPlan::of_job`] lays every pin.
const HEIGHTS: usize = 3;

/// Recordings that are counted.
struct Counted<'a> {
    inner: SimulatedRecordings<'a>,
    recorded: &'a dyn Fn(u64),
}

impl Recordings for Counted<'_> {
    fn pin(
        &mut self,
        index: usize,
        pin: &PinPlan,
        position: &Position,
    ) -> Result<Vec<Frame>, CalibrateError> {
        self.inner.pin(index, pin, position).inspect(|frames| (self.recorded)(frames.len() as u64))
    }

    fn dark(&mut self, plan: &CalibrationPlan) -> Result<Vec<Frame>, CalibrateError> {
        self.inner.dark(plan)
    }

    fn flat(&mut self, plan: &CalibrationPlan, index: usize) -> Result<Vec<Frame>, CalibrateError> {
        self.inner.flat(plan, index)
    }
}
