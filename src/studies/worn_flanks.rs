//! Worn edges about the limits of ISO 3685, judged: how many that are blunt pass as sharp.
//!
//! In: a plan of flanks, limits. Out: a [`FlankRow`] a tool and [`BluntBin`]s by the stated
//! uncertainty. A verdict of 95 % lets at most 5 % of truly blunt edges pass in every bin if u is
//! true.

use rayon::prelude::*;
use serde::Serialize;

use super::flanks::{FlankPlan, FlankRow};
use crate::render::RenderError;
use crate::render::flank::{FlankScene, flank_truth};
use crate::tool::wear::{Land, WearLimits, WearVerdict};

/// Bins of the stated uncertainty: quarters of the tools.
const BINS: usize = 4;
/// Widths are drawn to this share on both sides of their limit: several u.
const ABOUT: f64 = 0.12;

/// Truly blunt tools of a bin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct BluntBin {
    /// Largest u of VBB in the bin, µm.
    pub to_u_um: f64,
    /// Tools measured.
    pub measured: usize,
    /// Truly blunt ones.
    pub blunt: usize,
    /// Truly blunt ones that passed as sharp.
    pub passed: usize,
    /// Of these, those with a true width beyond its limit by more than 2 U.
    pub beyond: usize,
}

/// A scene whose VBB (even seeds) or VBBmax (odd seeds) lies about its limit.
pub(crate) fn scene(plan: &FlankPlan<'_>, seed: u64, limits: &WearLimits) -> FlankScene {
    let mut scene = FlankScene::drawn(seed, plan.size, plan.um_per_px);
    // even over the interval: an additive recurrence with the golden ratio
    let at = 1.0 + ABOUT * (2.0 * (0.618_033_988_749_894_9 * (seed % 1_000_003) as f64).fract() - 1.0);
    let wear = &mut scene.wear;
    let by_mean = seed.is_multiple_of(2);
    if !by_mean {
        // a notch of the depth of VB and more, so that VBBmax reaches its limit first
        wear.notch_um = wear.notch_um.max(1.5 * wear.vb_um);
        wear.taper = 0.0;
    }
    let truth = flank_truth(&scene, seed);
    let (is_um, limit_um) =
        if by_mean { (truth.vb_um, limits.vbb_um) } else { (truth.vb_max_um, limits.vbb_max_um) };
    // widths are linear in these
    let by = at * limit_um / is_um.max(1.0);
    let wear = &mut scene.wear;
    for um in [&mut wear.vb_um, &mut wear.notch_um, &mut wear.corner_um] {
        *um *= by;
    }
    scene.edge.depth_um = scene.edge.depth_um.max(1.3 * limits.vbb_max_um);
    scene
}

fn judged(
    scene: &FlankScene,
    seed: u64,
    (plan, limits): (&FlankPlan<'_>, &WearLimits),
) -> Result<FlankRow, RenderError> {
    let row = FlankRow::of(scene, seed, plan)?;
    let blunt = row.true_vbb_um > limits.vbb_um || row.true_vbb_max_um > limits.vbb_max_um;
    let land = row.vbb().zip(row.vbb_max()).map(|(mean, most)| Land {
        vbb_um: (row.true_vbb_um + mean.0, mean.1),
        vbb_max_um: (row.true_vbb_max_um + most.0, most.1),
    });
    Ok(FlankRow { verdict: land.map(|l| l.verdict(limits)), blunt: Some(blunt), ..row })
}

/// Draws, measures and judges so many tools; `done` is called after each.
///
/// # Errors
/// A size out of range.
pub(crate) fn run(
    plan: &FlankPlan<'_>,
    limits: &WearLimits,
    (count, done): (usize, &(dyn Fn() + Sync)),
) -> Result<Vec<FlankRow>, RenderError> {
    let one = |k: usize| {
        let seed = plan.seed.wrapping_add(k as u64);
        let tool = judged(&scene(plan, seed, limits), seed, (plan, limits));
        done();
        tool
    };
    (0..count).into_par_iter().map(one).collect()
}

/// Bins of equal numbers by the stated u of VBB.
pub(crate) fn bins(tools: &[FlankRow], limits: &WearLimits) -> Vec<BluntBin> {
    let mut measured: Vec<(&FlankRow, f64)> =
        tools.iter().filter_map(|t| t.u_vbb_um.map(|u| (t, u))).collect();
    measured.sort_by(|a, b| a.1.total_cmp(&b.1));
    let size = measured.len().div_ceil(BINS).max(1);
    measured.chunks(size).map(|bin| blunt_bin(bin, limits)).collect()
}

fn blunt_bin(bin: &[(&FlankRow, f64)], limits: &WearLimits) -> BluntBin {
    let passed = |t: &FlankRow| t.blunt == Some(true) && t.verdict == Some(WearVerdict::Sharp);
    let beyond = |t: &FlankRow| {
        let over =
            |true_um: f64, limit_um: f64, u_um: Option<f64>| true_um > limit_um + 4.0 * u_um.unwrap_or(0.0);
        over(t.true_vbb_um, limits.vbb_um, t.u_vbb_um)
            || over(t.true_vbb_max_um, limits.vbb_max_um, t.u_vbb_max_um)
    };
    BluntBin {
        to_u_um: bin.last().map_or(0.0, |b| b.1),
        measured: bin.len(),
        blunt: bin.iter().filter(|b| b.0.blunt == Some(true)).count(),
        passed: bin.iter().filter(|b| passed(b.0)).count(),
        beyond: bin.iter().filter(|b| passed(b.0) && beyond(b.0)).count(),
    }
}
