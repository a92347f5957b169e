//! One edge departs from the contour while the other one does not: contamination on the part, not
//! its form.
//!
//! Steps, tapers and bends of a turned part move both edges of a column alike, so that the middle
//! (top + bottom)/2 follows the axis: over one field a parabola, whatever the profile.
//! Contamination that adheres to one side, or a chip that touches it, moves the middle by half of
//! what it adds to the diameter. A shaft that bends more than a parabola leaves its widths
//! unchanged ([`bent`]). The parabola is fitted to medians of sixteen columns, robustly where they
//! disagree. Departures are tested against the scatter about it (noise, texture, vibration), so
//! that a part with a wavy centreline is not refused.

use super::bent;
use super::departures::AxisScratch;
use crate::gauge::edges::{Edge, EdgeState};
use crate::gauge::limit::limits;
use crate::numerics::median_network::BLOCK;
use crate::profile::Reason;

limits! {
    /// When one edge alone departs from the contour.
    OneSidedLimits = "one_sided";
    /// Fewest blocks from which the axis can be separated from a local departure: a parabola leaves
    /// five of eight free, and a departure in two leaves most of these.
    least_blocks: usize = 8;
    /// Times that the axis is fitted again to the columns not yet refused: what one pass refuses no
    /// longer pulls the next. Tuned: see study limits.
    passes: usize = 3;
    /// Share of the columns that contamination hides, above which a field counts as contaminated:
    /// more than noise and hot pixels refuse. Tuned: see study limits.
    contaminated: f64 = 0.05;
    /// Spread about the axis, px, above which nothing confirms what is left of a contaminated
    /// field: among much contamination a middle that is wavy is contamination too, sooner than
    /// form. Twice what is tested (`departures.floor_px`).
    confirmed_px: f64 = 0.08;
}

/// Refuses the edge of each column that leaves the axis to its side; gives the share of the columns
/// refused.
pub(crate) fn refuse_one_sided(top: &mut [Edge], bottom: &mut [Edge], scratch: &mut AxisScratch) -> f64 {
    let limits = OneSidedLimits::get();
    let (mut refused, mut contaminated) = (0.0, None);
    for _ in 0..limits.passes {
        let share = refuse_once(top, bottom, &mut contaminated, scratch);
        refused += share * (1.0 - refused);
        if share == 0.0 {
            break;
        }
    }
    refused
}

/// Whether contamination hides much of a field.
fn is_contaminated(top: &[Edge], bottom: &[Edge]) -> bool {
    let limits = OneSidedLimits::get();
    let by_contamination =
        |e: &Edge| matches!(e.reason(), Some(Reason::Residual | Reason::Contaminated | Reason::Outlier));
    let hidden = top.iter().zip(bottom).filter(|(t, b)| by_contamination(t) || by_contamination(b)).count();
    hidden as f64 > limits.contaminated * top.len() as f64
}

/// One pass; `contaminated` is found out in the first.
fn refuse_once(
    top: &mut [Edge],
    bottom: &mut [Edge],
    contaminated: &mut Option<bool>,
    scratch: &mut AxisScratch,
) -> f64 {
    let limits = OneSidedLimits::get();
    let usable = scratch.middles(top, bottom);
    if scratch.blocks.len() < limits.least_blocks {
        if usable == 0 || top.len() < 2 * limits.least_blocks * BLOCK {
            return 0.0;
        }
        // Too few columns of a wide field are left to fit an axis: none of them can be confirmed.
        return refuse_all(top);
    }
    let Some(plain) = scratch.plain() else { return 0.0 };
    let calm = scratch.is_calm(&plain);
    let contaminated = *contaminated.get_or_insert_with(|| !calm && is_contaminated(top, bottom));
    if !calm || usable < top.len() {
        scratch.measure_widths(top, bottom);
    }
    if !calm && bent::is_bent(&scratch.blocks) {
        return 0.0;
    }
    let noise = if calm { 0.0 } else { scratch.block_noise((&*top, &*bottom), usable) };
    let Some(axis) = (if calm { Some(plain) } else { scratch.axis(plain, noise) }) else { return 0.0 };
    let (column_sd, block_sd) = scratch.depart(&axis, top.len());
    let mut any = scratch.mark((column_sd, block_sd), (&*top, &*bottom));
    if !calm {
        any |= scratch.mark_local(&axis, (column_sd, contaminated), (&*top, &*bottom));
    }
    if !any && usable == top.len() {
        return 0.0;
    }
    if !any && contaminated && block_sd > limits.confirmed_px {
        return refuse_all(top);
    }
    scratch.measure_widths(top, bottom);
    scratch.extend_to_base();
    let refused = scratch.refused_columns();
    for (column, refuse) in scratch.refused.iter().enumerate() {
        if *refuse && top[column].is_usable() && bottom[column].is_usable() {
            let outwards_above = scratch.departures[column] < 0.0;
            let edge = if outwards_above { &mut top[column] } else { &mut bottom[column] };
            edge.state = EdgeState::Gap(Reason::Contaminated);
        }
    }
    refused as f64 / usable.max(1) as f64
}

fn refuse_all(line: &mut [Edge]) -> f64 {
    for edge in line.iter_mut().filter(|e| e.is_usable()) {
        edge.state = EdgeState::Gap(Reason::Contaminated);
    }
    1.0
}

#[cfg(test)]
mod tests;
