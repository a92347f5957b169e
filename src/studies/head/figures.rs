//! All figures of one head.

use serde::Serialize;

use super::budget::{Budgets, HeadBudget, HeadLimit};
use super::depth::DepthOfField;
use super::error::HeadError;
use super::exposure::{ExposureAtSpeed, exposures};
use super::frames::{FrameCheck, check};
use super::motion::MotionEffect;
use super::optics::OpticsFigures;
use super::range::DiameterRange;
use super::repeatability::Repeatability;
use super::settings::HeadSettings;
use super::setup::HeadSetup;
use crate::render::Renderer;

/// Share of U by which a diameter may move in the depth of field.
const DEPTH_SHARE: f64 = 0.25;

/// The figures of a head.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct HeadFigures {
    /// Its name.
    pub name: String,
    /// Its config.
    pub config: String,
    /// Diameter of the part, mm.
    pub diameter_mm: f64,
    /// Masters' diameters, mm.
    pub masters_mm: Vec<f64>,
    /// What its config does not state and was assumed.
    pub notes: Vec<String>,
    /// Optics, field and light.
    pub optics: OpticsFigures,
    /// Repeatability with the part at rest, predicted.
    pub repeatability: Repeatability,
    /// Repeatability with the part in use, predicted.
    pub repeatability_in_use: Repeatability,
    /// Frames of the part in use, rendered and measured; none where the gauge measures nothing
    /// then.
    pub frames: Option<FrameCheck>,
    /// Depth of field.
    pub depth: DepthOfField,
    /// Longest exposures over speeds.
    pub exposures: Vec<ExposureAtSpeed>,
    /// Diameters that it can measure.
    pub range: DiameterRange,
    /// Uncertainty with the part at rest.
    pub at_rest: HeadBudget,
    /// What motion does in use.
    pub motion: MotionEffect,
    /// Uncertainty with the part in use; none where the gauge measures nothing then.
    pub in_use: Option<HeadBudget>,
    /// The largest row of it, and what would halve that.
    pub limit: Option<HeadLimit>,
}

/// Computes them.
///
/// # Errors
/// Optics, masters or frames that fail.
pub(super) fn figures(
    head: &HeadSetup,
    settings: &HeadSettings,
    speeds: &[f64],
    (renderer, done): (&Renderer, &dyn Fn(u64)),
) -> Result<HeadFigures, HeadError> {
    let repeatability = Repeatability::of(head, 0.0)?;
    let mut motion = MotionEffect::of(head, &repeatability)?;
    let budgets = Budgets::of(head, renderer, settings.date, done)?;
    let (mut repeatability_in_use, mut frames) = (repeatability, None);
    if motion.refused.is_none() {
        repeatability_in_use = Repeatability::of(head, motion.path_um / head.um_per_px())?;
        let asked = (settings.frames, settings.seed);
        let found = check(head, asked, &repeatability_in_use, renderer, done)?;
        motion.refused = found.refused();
        frames = Some(found);
    }
    let (at_rest, in_use) = (budgets.at_rest(), budgets.in_use(&motion));
    let limit_um = settings.depth_limit_um.unwrap_or(DEPTH_SHARE * at_rest.expanded_u_um);
    Ok(HeadFigures {
        name: head.config.name.clone(),
        config: head.config.file.clone(),
        diameter_mm: head.diameter_mm,
        masters_mm: head.job.masters.pins.iter().map(|pin| pin.diameter_mm).collect(),
        notes: head.notes.clone(),
        optics: OpticsFigures::of(head),
        repeatability,
        repeatability_in_use,
        frames,
        depth: DepthOfField::of(head, limit_um)?,
        exposures: exposures(head, at_rest.u_um, &settings.exposure, speeds),
        range: head.range,
        limit: in_use.as_ref().and_then(HeadBudget::limit),
        at_rest,
        motion,
        in_use,
    })
}
