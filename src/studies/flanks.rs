//! Rendered flanks, measured: errors of VBB and VBBmax beside their stated uncertainties.
//!
//! In: a model of the land, the size of the images, a seed. Out: a [`FlankRow`] a flank;
//! [`summary`] joins them. `worn_flanks` draws flanks about the limits of a worn edge.

use rayon::prelude::*;
use serde::Serialize;

use crate::gauge::flank::{FlankMeasurement, FlankSettings, FlankSide, LandModel, measure_flank};
use crate::render::RenderError;
use crate::render::flank::{FlankScene, FlankTruth, below_edge_um, render_flank};
use crate::tool::wear::WearVerdict;

/// 97.5 % of the normal distribution, for intervals of 95 %.
const K95: f64 = 1.96;

/// What flanks are drawn, and by what they are measured.
#[derive(Clone, Copy)]
pub(crate) struct FlankPlan<'a> {
    /// The model.
    pub model: &'a dyn LandModel,
    /// Columns and rows of an image.
    pub size: (u32, u32),
    /// Scale, µm per px.
    pub um_per_px: f64,
    /// Seed of the first scene; the others follow.
    pub seed: u64,
    /// At which side of the edge the flank lies, as far as that is stated.
    pub side: FlankSide,
}

/// One flank.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct FlankRow {
    /// Its seed.
    pub seed: u64,
    /// True mean width, µm.
    pub true_vbb_um: f64,
    /// True largest width, µm.
    pub true_vbb_max_um: f64,
    /// Measured mean width, µm; none of a flank that is refused.
    pub vbb_um: Option<f64>,
    /// Its standard uncertainty, µm.
    pub u_vbb_um: Option<f64>,
    /// Measured largest width, µm.
    pub vbb_max_um: Option<f64>,
    /// Its standard uncertainty, µm.
    pub u_vbb_max_um: Option<f64>,
    /// Mean depth of the reference below the new edge over the worn length, µm.
    pub reference_um: Option<f64>,
    /// True worn length, µm.
    pub true_length_um: f64,
    /// Measured worn length, µm.
    pub worn_length_um: Option<f64>,
    /// Flags, joined by spaces.
    pub flags: String,
    /// Why it is refused.
    pub refused: Option<String>,
    /// Whether it is truly blunt, of a tool that is judged.
    pub blunt: Option<bool>,
    /// The verdict, of a tool that is judged and measured.
    pub verdict: Option<WearVerdict>,
}

impl FlankRow {
    /// Measures one scene.
    pub(crate) fn of(scene: &FlankScene, seed: u64, plan: &FlankPlan<'_>) -> Result<Self, RenderError> {
        let (frame, _, truth) = render_flank(scene, seed)?;
        let full_scale = frame.view().full_scale().unwrap_or(f32::INFINITY);
        let at_scale = FlankSettings::at_scale(scene.um_per_px);
        let settings = FlankSettings { full_scale, side: plan.side, ..at_scale };
        let row = Self::true_of(&truth, seed);
        Ok(match measure_flank(&frame.view(), &settings, plan.model) {
            Ok(found) => row.with(&found, scene),
            Err(error) => Self { refused: Some(error.to_string()), ..row },
        })
    }

    fn true_of(truth: &FlankTruth, seed: u64) -> Self {
        Self {
            seed,
            true_vbb_um: truth.vb_um,
            true_vbb_max_um: truth.vb_max_um,
            true_length_um: truth.worn_length_um,
            ..Self::default()
        }
    }

    fn with(self, found: &FlankMeasurement, scene: &FlankScene) -> Self {
        let over = found.worn.0..=found.worn.1.min(found.places.len().saturating_sub(1));
        let depths: Vec<f64> =
            found.places[over].iter().map(|[edge, _]| below_edge_um(scene, *edge)).collect();
        Self {
            vbb_um: Some(found.vbb.um),
            u_vbb_um: Some(found.vbb.u_um),
            vbb_max_um: Some(found.vbb_max.um),
            u_vbb_max_um: Some(found.vbb_max.u_um),
            reference_um: Some(depths.iter().sum::<f64>() / depths.len().max(1) as f64),
            worn_length_um: Some(found.worn_length_um),
            flags: found.flags.join(" "),
            ..self
        }
    }

    /// Error and u of VBB, µm.
    pub(crate) fn vbb(&self) -> Option<(f64, f64)> {
        Some((self.vbb_um? - self.true_vbb_um, self.u_vbb_um?))
    }

    /// Error and u of VBBmax, µm.
    pub(crate) fn vbb_max(&self) -> Option<(f64, f64)> {
        Some((self.vbb_max_um? - self.true_vbb_max_um, self.u_vbb_max_um?))
    }
}

/// Draws and measures so many flanks; `done` is called after each.
///
/// # Errors
/// A size out of range.
pub(crate) fn run(
    plan: &FlankPlan<'_>,
    count: usize,
    done: &(dyn Fn() + Sync),
) -> Result<Vec<FlankRow>, RenderError> {
    let one = |k: usize| {
        let seed = plan.seed.wrapping_add(k as u64);
        let row = FlankRow::of(&FlankScene::drawn(seed, plan.size, plan.um_per_px), seed, plan);
        done();
        row
    };
    (0..count).into_par_iter().map(one).collect()
}

/// Errors of one width.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct WidthErrors {
    /// Root mean square, px.
    pub rms_px: f64,
    /// Median of their sizes, px.
    pub median_px: f64,
    /// Nine tenths of them are smaller, px.
    pub ninety_percent_px: f64,
    /// The largest, px.
    pub largest_px: f64,
    /// Share within 1.96 u.
    pub within: f64,
    /// Root mean square of the stated u, px.
    pub u_px: f64,
}

impl WidthErrors {
    fn of(errors: impl Iterator<Item = (f64, f64)>, um_per_px: f64) -> Self {
        let errors: Vec<(f64, f64)> = errors.collect();
        let mut sizes: Vec<f64> = errors.iter().map(|e| e.0.abs() / um_per_px).collect();
        sizes.sort_by(f64::total_cmp);
        let n = sizes.len().max(1) as f64;
        let at = |share: f64| sizes.get(((sizes.len().max(1) - 1) as f64 * share).round() as usize);
        let square = |of: &dyn Fn(&(f64, f64)) -> f64| errors.iter().map(|e| of(e).powi(2)).sum::<f64>();
        Self {
            rms_px: (square(&|e| e.0) / n).sqrt() / um_per_px,
            median_px: at(0.5).copied().unwrap_or_default(),
            ninety_percent_px: at(0.9).copied().unwrap_or_default(),
            largest_px: sizes.last().copied().unwrap_or_default(),
            within: errors.iter().filter(|e| e.0.abs() <= K95 * e.1).count() as f64 / n,
            u_px: (square(&|e| e.1) / n).sqrt() / um_per_px,
        }
    }
}

/// What flanks gave together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct FlankSummary {
    /// Flanks measured.
    pub measured: usize,
    /// Flanks refused.
    pub refused: usize,
    /// Errors of VBB.
    pub vbb: WidthErrors,
    /// Errors of VBBmax.
    pub vbb_max: WidthErrors,
}

/// Joins flanks.
pub(crate) fn summary(rows: &[FlankRow], um_per_px: f64) -> FlankSummary {
    let refused = rows.iter().filter(|r| r.refused.is_some()).count();
    FlankSummary {
        measured: rows.len() - refused,
        refused,
        vbb: WidthErrors::of(rows.iter().filter_map(FlankRow::vbb), um_per_px),
        vbb_max: WidthErrors::of(rows.iter().filter_map(FlankRow::vbb_max), um_per_px),
    }
}
