//! Edges beside light or shadow that is clipped at an end of the grey scale: censored maximum
//! likelihood.
//!
//! Levels along the shaft, blur and two shape terms of the edge-spread function are estimated once
//! a side from many columns, together with the position of each column (`score`, `joint`). A level
//! may lie on either side of the end: where noise reaches the end it is estimated from the pixels
//! between the ends, where all of it is clipped from the flank. The uncertainty left by the flank
//! enters the shared uncertainty with the joint covariance. The part by the shape of the edge has
//! one cause at both edges, the lens, and adds up linearly in a width: each side states √2 of its
//! own.

use super::joint::{FittedColumn, Joint, Settled};
use super::level::Level;
use super::score::{Column, Likelihood, Noise, Score};
use crate::gauge::edge::estimation::censored::Ends;
use crate::gauge::edge::estimation::levels::{LevelCurve, LevelLimits};
use crate::gauge::edge::estimation::soft_knee;
use crate::gauge::edge::image::scan_windows::Windows;
use crate::gauge::edge::model::edge_spread::EdgeSpreadFunction;
use crate::gauge::edges::{Edge, EdgeState};
use crate::gauge::limit::limits;
use crate::profile::Reason;

limits! {
    /// From which columns clipped levels are estimated, and when the flank determines them.
    SideFitLimits = "censored_side";
    /// Most columns that levels, blur and shape are estimated from. Tuned: see study limits.
    sample_columns: usize = 512;
    /// Most columns that the number of knots is chosen from. Tuned: see study limits.
    scouts: usize = 128;
    /// Most knots of a clipped level; from the two of a straight line on, each further try halves
    /// their distance. Tuned: see study limits.
    most_knots: usize = 9;
    /// Steepest edges that take part in the estimate, rows per column: the blur along the column is
    /// 2 % more than that across the edge there, √(1 + 0.2²).
    most_slope: f32 = 0.2;
    /// Reduced χ² above which a systematic residual has moved the levels. Tuned: see study limits.
    explained: f64 = 1.2;
    /// Reduced χ² beyond which no edge-spread function of the family fits. Tuned: see study limits.
    excess_chi2: f64 = 2.0;
    /// Where a level is held then beyond the end, in units of the contrast seen. Tuned: see study
    /// limits.
    held_near: f64 = 0.05;
    /// How far beyond the end it may be, in units of the contrast seen: light of 1.5 times the end.
    held_far: f64 = 0.5;
    /// Amplitude of the shape terms over their assumed standard uncertainty above which the whole
    /// flank is not used: Gaussian edges under clipped light stay below 1, knees of video cameras
    /// reach 2 to 4.
    bent: f64 = 1.5;
    /// Relative standard uncertainty of a blur that is given: as good as none beside what a frame
    /// shows.
    given_to: f64 = 1e-3;
    /// Farthest from a window's central pixel that the edge of the column before is started from,
    /// px. Tuned: see study limits.
    neighbour_px: f64 = 3.0;
    /// Most stray pixels of a column that is fitted: a sensor's hot pixels, of which three in one
    /// window are contamination. Tuned: see study limits.
    most_stray: usize = 2;
}

/// One side of a frame before the fit.
#[derive(Clone, Debug)]
pub(crate) struct ClippedStart<'a> {
    /// The edge-spread function.
    pub(crate) shape: &'a EdgeSpreadFunction,
    /// Levels as the flat pixels show them, clipped or not.
    pub(crate) levels: [&'a LevelCurve; 2],
    /// Blur, px, and whether it is given.
    pub(crate) sigma: f64,
    pub(crate) sigma_is_given: bool,
    /// Noise variance in the dark and in the light, counts², that of what is clipped unknown; and
    /// the least variance used.
    pub(crate) variance: [f64; 2],
    pub(crate) floor: f64,
    /// Ends of the grey scale.
    pub(crate) ends: Ends,
}

/// Result of the fit of a side beside its edges.
#[derive(Clone, Debug)]
pub(crate) struct ClippedSide {
    /// Degrees of freedom to test the columns' residuals with.
    pub(crate) freedom: f64,
    /// Blur, px.
    pub(crate) sigma: f64,
    /// Levels of dark and light, counts.
    pub(crate) levels: [Vec<f32>; 2],
    /// Standard uncertainty of an edge by the shape of what is clipped, √2 for both edges included,
    /// px.
    pub(crate) u_px: f64,
}

/// Fits all columns of a side; `None`, all of them gaps, where the flank does not determine the
/// levels beyond the ends.
pub(crate) fn fit_side(
    windows: &Windows,
    slope: &[f32],
    start: &ClippedStart<'_>,
    line: &mut Vec<Edge>,
) -> Option<ClippedSide> {
    let limits = SideFitLimits::get();
    let columns = windows.centre.len();
    let mut fitted = fit_joint(windows, slope, start);
    if let Some(lower) = fitted.as_ref().and_then(|fitted| lower_ends(start, fitted)) {
        fitted = fit_joint(windows, slope, &ClippedStart { ends: lower, ..start.clone() });
    }
    let Some((joint, settled, held)) = fitted else {
        let gap = |column: usize| windows.centre[column].err().unwrap_or(Reason::Saturated);
        line.extend((0..columns).map(|column| Edge::gap(gap(column))));
        return None;
    };
    // What a systematic residual beyond the noise has moved the levels by does not average: as much
    // as in one column.
    let excess = (settled.reduced_chi2 - limits.explained).max(0.0);
    let hidden = if held > 0.0 { 0.0 } else { excess / settled.reduced_chi2 };
    let (mut variance, mut usable, mut last_row) = (0.0, 0.0, None);
    for (column, slope) in slope.iter().enumerate().take(columns) {
        let (edge, model) = match windows.centre[column] {
            Ok(_) => {
                fit_column(windows, &joint, &settled, (column, *slope, last_row), (hidden, held, limits))
            }
            Err(reason) => (Edge::gap(reason), 0.0),
        };
        last_row = edge.is_usable().then_some(edge.row_px);
        if edge.is_usable() {
            (variance, usable) = (variance + model, usable + 1.0);
        }
        line.push(edge);
    }
    let curve = |level: &Level| (0..columns).map(|column| level.at(column) as f32).collect();
    Some(ClippedSide {
        freedom: (settled.informative - 1.0).max(1.0),
        sigma: joint.sigma,
        levels: [curve(&joint.dark), curve(&joint.light)],
        u_px: (variance / f64::max(usable, 1.0)).sqrt(),
    })
}

/// Lower ends where the whole flank would need an edge-spread function beyond the assumed family:
/// the response bends before it ends, or the edge-spread function departs. The lower part of the
/// flank, which is free of the bend, is then used alone.
fn lower_ends(start: &ClippedStart<'_>, (joint, _, held): &(Joint<'_>, Settled, f64)) -> Option<Ends> {
    let ends = start.ends;
    if !ends.high.is_finite() || *held > 0.0 || joint.beyond_presumed() < SideFitLimits::get().bent {
        return None;
    }
    let dark = joint.dark.at(joint.middle());
    Some(Ends { high: soft_knee::trusted([dark, ends.high], ends.step), ..ends })
}

/// Columns with the places that their windows show first.
fn first_placed(windows: &Windows, columns: &[usize]) -> Vec<FittedColumn> {
    columns.iter().map(|&index| FittedColumn { index, place: windows.first_place(index) }).collect()
}

/// The fit to few columns (`scouts`) with the number of knots that they ask for, and the contrast
/// seen; `able`: all that may be fitted.
fn with_best_knots<'a>(
    windows: &Windows,
    slope: &[f32],
    start: &ClippedStart<'a>,
    able: &[usize],
    scouts: &[usize],
) -> Option<(Joint<'a>, f64)> {
    let (given_to, line) = (SideFitLimits::get().given_to, 2);
    let ends = start.ends;
    let [dark, light] = start.levels;
    let low = if ends.low.is_finite() { ends.low } else { dark.mean };
    let high = if ends.high.is_finite() { ends.high } else { light.mean };
    let seen = high - low;
    // Where a followed edge has moved away, its windows lie in the shadow or in the light alone:
    // the mean of what should be light is then no more than the end of the dark, and no flank is
    // seen.
    if !(seen > 0.0) {
        return None;
    }
    let known = |curve: &LevelCurve, clipped: bool, knots: usize, beyond: f64| match clipped {
        true => {
            let from: Vec<f32> = curve.level.iter().map(|l| l + beyond as f32).collect();
            Level::free(&from, (able[0], able[able.len() - 1]), knots)
        }
        false => Level::known(&curve.level, f64::from(mean(&curve.uncertainty))),
    };
    // The noise line passes through the level that is not clipped, with the slope from the flank.
    let (level, variance) = match ends.low.is_finite() && ends.high.is_infinite() {
        true => (light.mean, start.variance[1]),
        false => (dark.mean.max(low), start.variance[0]),
    };
    let noise = Noise { level, variance, gain: 0.0, floor: start.floor, unexplained: 0.0 };
    let mut best = Joint {
        likelihood: Likelihood::new(start.shape, ends, noise),
        dark: known(dark, ends.low.is_finite(), line, -0.02 * seen),
        light: known(light, ends.high.is_finite(), line, 0.02 * seen),
        sigma: start.sigma,
        sigma_prior: start.sigma_is_given.then_some((start.sigma, given_to * start.sigma)),
        columns: first_placed(windows, scouts),
    };
    let mut least = penalised(&best.settle(windows, slope, seen)?, line);
    let mut last = best.clone();
    for knots in finer_knots(able.len()) {
        let mut finer = last.clone();
        for level in [&mut finer.dark, &mut finer.light] {
            if level.prior.is_none() {
                *level = level.with_knots(knots);
            }
        }
        let Some(settled) = finer.settle(windows, slope, seen) else { break };
        last = finer.clone();
        let dearer = penalised(&settled, knots);
        if dearer < least {
            (least, best) = (dearer, finer);
        }
    }
    Some((best, seen))
}

/// Numbers of knots to try after the two of a straight line: each halves their distance.
fn finer_knots(columns: usize) -> impl Iterator<Item = usize> {
    let most = SideFitLimits::get().most_knots;
    std::iter::successors(Some(3), |knots| Some(2 * knots - 1))
        .take_while(move |knots| *knots <= most && 8 * knots <= columns)
}

fn fit_joint<'a>(
    windows: &Windows,
    slope: &[f32],
    start: &ClippedStart<'a>,
) -> Option<(Joint<'a>, Settled, f64)> {
    let limits = SideFitLimits::get();
    let able: Vec<usize> = (0..windows.centre.len())
        .filter(|c| windows.centre[*c].is_ok() && slope[*c].abs() < limits.most_slope)
        .collect();
    let some = |most: usize| -> Vec<usize> {
        able.iter().copied().step_by(able.len().div_ceil(most).max(1)).collect()
    };
    if able.len() < 8 {
        return None;
    }
    let (mut best, seen) = with_best_knots(windows, slope, start, &able, &some(limits.scouts))?;
    let sample_columns = some(limits.sample_columns);
    best.columns = first_placed(windows, &sample_columns);
    for FittedColumn { index, place } in &mut best.columns {
        let at = best.likelihood.place(
            windows.of(*index),
            *place,
            Column::of(&best.dark, &best.light, *index, best.sigma),
        );
        *place = at.unwrap_or(*place);
    }
    best.leave_out_strays(windows, slope);
    let settled = best.settle(windows, slope, seen)?;
    if settled.reduced_chi2 > limits.excess_chi2 {
        return hold(&best, windows, slope, seen);
    }
    // Where the fit has stopped at the bound, the flank does not determine the level.
    (!best.is_at_bound(seen)).then_some((best, settled, 0.0))
}

/// Where no edge-spread function of the family fits, the flank does not determine the light: it is
/// held a little beyond the end, and the shift of the edges by a light farther beyond is their
/// common uncertainty, px (the value held stands at one end of a rectangular distribution; √2 for
/// both edges).
fn hold<'a>(
    joint: &Joint<'a>,
    windows: &Windows,
    slope: &[f32],
    seen: f64,
) -> Option<(Joint<'a>, Settled, f64)> {
    let (ends, limits) = (joint.likelihood.ends, SideFitLimits::get());
    let at = |beyond: f64| -> Option<(Joint<'a>, Settled)> {
        let mut held = joint.clone();
        held.likelihood.terms = Default::default();
        for (level, end, sign) in [(&mut held.dark, ends.low, -1.0), (&mut held.light, ends.high, 1.0)] {
            if level.prior.is_none() {
                *level = level.held(end + sign * beyond * seen);
            }
        }
        let settled = held.settle(windows, slope, seen)?;
        Some((held, settled))
    };
    let (near, settled) = at(limits.held_near)?;
    let (far, _) = at(limits.held_far)?;
    let mean =
        |columns: &[FittedColumn]| columns.iter().map(|c| c.place).sum::<f64>() / columns.len().max(1) as f64;
    let moved = (mean(&far.columns) - mean(&near.columns)).abs();
    Some((near, settled, moved * (2.0_f64 / 3.0).sqrt()))
}

fn penalised(settled: &Settled, knots: usize) -> f64 {
    LevelLimits::get().knot_penalty * knots as f64 - 2.0 * settled.log_likelihood
}

fn mean(values: &[f32]) -> f32 {
    values.iter().sum::<f32>() / values.len().max(1) as f32
}

impl Column {
    fn of(dark: &Level, light: &Level, column: usize, sigma: f64) -> Self {
        Self { dark: dark.at(column), light: light.at(column), sigma }
    }
}

/// A column's edge, and the variance of it by the shape of what is clipped, px².
fn fit_column(
    windows: &Windows,
    joint: &Joint<'_>,
    settled: &Settled,
    (column, slope, last_row): (usize, f32, Option<f64>),
    (hidden, held, limits): (f64, f64, &SideFitLimits),
) -> (Edge, f64) {
    let at = joint.column(column, slope);
    // The edge of the column before is a better start than the windows' own first estimate, which
    // noise and clipped light have moved.
    let start = last_row.map(|row| windows.place(column, row)).filter(|x| x.abs() < limits.neighbour_px);
    let start = start.unwrap_or_else(|| windows.first_place(column));
    let Some(x) = joint.likelihood.place(windows.of(column), start, at) else {
        return (Edge::gap(Reason::Residual), 0.0);
    };
    let score = joint.likelihood.score(windows.of(column), x, at);
    let Score { chi2, informative, stray, .. } = score;
    // Fewer than two pixels that state a grey value: nothing but the ends is seen.
    let own = score.information[(0, 0)];
    if !(own > 0.0) || informative < 2.0 {
        return (Edge::gap(Reason::Saturated), 0.0);
    }
    if stray > limits.most_stray {
        return (Edge::gap(Reason::Residual), 0.0);
    }
    let (all, known_shape) = joint.shared(settled, column, &score);
    let model = 2.0 * (all - known_shape).max(0.0) * joint.beyond_presumed().powi(2);
    let shown = known_shape * settled.columns as f64 * hidden;
    let model = if held > 0.0 { held * held } else { model };
    // Where no model fits, columns are judged by what the model leaves of all of them, which is in
    // their own u.
    let expected = if held > 0.0 { settled.reduced_chi2.max(1.0) } else { 1.0 };
    let edge = Edge {
        row_px: windows.row(column, x as f32),
        u_own_px: (1.0 / own).sqrt() as f32,
        u_shared_px: (known_shape + model + 2.0 * shown).sqrt() as f32,
        chi2: (chi2 / ((informative - 1.0).max(1.0) * expected)) as f32,
        state: EdgeState::Impaired(Reason::Clipped),
    };
    (edge, model + 2.0 * shown)
}

#[cfg(test)]
mod tests;
