//! Where the cutting edge lies: the straight line on one side of which the image has detail
//! (the flank, in focus) and on the other none (the air and what stands behind it).
//!
//! Detail is |I − G·I|; of the sums over strips on both sides of every line (directions of a
//! degree, then of a quarter) the largest difference wins. A light background out of focus has no
//! detail however bright it is.

use glam::DVec2;
use rayon::prelude::*;

use super::error::FlankError;
use super::limits::FlankLimits;
use super::raster::{Raster, quantile};
use super::settings::{FlankSide, between_deg};

/// A directed line: the flank lies on the side of `normal`. Places are (column, row), px.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EdgeLine {
    /// Its first place with flank beside it.
    pub from: DVec2,
    /// Unit vector along it.
    pub along: DVec2,
    /// Unit vector into the flank.
    pub normal: DVec2,
    /// Length over which a flank lies beside it, px.
    pub length_px: f64,
}

impl EdgeLine {
    /// Its middle.
    pub(crate) fn middle(&self) -> DVec2 {
        self.from + 0.5 * self.length_px * self.along
    }
}

/// The edge and, where there is one, another border that it could be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FoundEdge {
    /// The likeliest line.
    pub line: EdgeLine,
    /// Another line of nearly the same weight.
    pub rival: Option<EdgeLine>,
    /// A line of more weight at another side than the one that is stated.
    pub clearer: Option<EdgeLine>,
}

struct Cells {
    side: usize,
    detail: Raster,
}

/// Finds the line; of a flank whose side is known among the directions that it allows.
///
/// # Errors
/// Nothing in focus; nothing long enough; a side at which hardly a border lies while another stands
/// out.
pub(crate) fn edge_line(image: &Raster, side: FlankSide) -> Result<FoundEdge, FlankError> {
    let limits = FlankLimits::get();
    let cells = Cells::of(image)?;
    let coarse: Vec<Candidate> =
        (0..360_u16).into_par_iter().map(|deg| cells.best_of(f64::from(deg))).collect();
    let stated: Vec<Candidate> = coarse.iter().copied().filter(|c| side.may_be(c.deg)).collect();
    let borders = cells.borders(&stated);
    let line = |border: &Border| border.edge_line(cells.side as f64);
    let clearest = (side != FlankSide::Any).then(|| cells.borders(&coarse).first().copied()).flatten();
    let Some(best) = borders.first().copied() else {
        let none = || FlankError::NoFlank { why: "no line".to_owned() };
        return Err(clearest.map_or_else(none, |clearest| other_side(side, &line(&clearest))));
    };
    let clearer = clearest.filter(|b| b.apart(&best) && b.weight() > best.weight());
    if let Some(clearer) = clearer.filter(|b| best.weight() < limits.side_share * b.weight()) {
        return Err(other_side(side, &line(&clearer)));
    }
    let (from, to) = best.extent;
    if to - from < limits.least_cells {
        let why = format!(
            "the longest border of what is in focus is {:.0} px long, {:.0} are needed",
            (to - from) * cells.side as f64,
            limits.least_cells * cells.side as f64
        );
        return Err(FlankError::NoFlank { why });
    }
    let rival = borders.iter().find(|b| b.apart(&best));
    let rival = rival.filter(|b| b.weight() >= limits.rival_share * best.weight());
    Ok(FoundEdge { line: line(&best), rival: rival.map(line), clearer: clearer.as_ref().map(line) })
}

/// A line stands out, and no edge of a flank at the stated side of it does.
pub(super) fn other_side(side: FlankSide, line: &EdgeLine) -> FlankError {
    let middle = line.middle();
    FlankError::OtherSide { side: side.word(), row: middle.y, column: middle.x }
}

/// A line with the part of it beside which a flank lies, cells.
#[derive(Clone, Copy, Debug)]
struct Border {
    line: Candidate,
    extent: (f64, f64),
}

impl Border {
    /// Whether it is another border, rather than another direction of the same one.
    fn apart(&self, other: &Self) -> bool {
        between_deg(self.line.deg, other.line.deg) > FlankLimits::get().apart_deg
    }

    /// Score is a mean along the whole chord of the image; a side of the body is a short edge.
    fn weight(&self) -> f64 {
        self.line.score * (self.extent.1 - self.extent.0).max(0.0).sqrt()
    }

    /// In pixels, of cells of so many.
    fn edge_line(&self, side: f64) -> EdgeLine {
        let normal = DVec2::from_angle(self.line.deg.to_radians());
        let along = -normal.perp();
        let from = (normal * self.line.offset + along * self.extent.0) * side + 0.5 * (side - 1.0);
        EdgeLine { from, along, normal, length_px: (self.extent.1 - self.extent.0) * side }
    }
}

#[derive(Clone, Copy, Debug)]
struct Candidate {
    /// Direction of the normal into the flank, degrees.
    deg: f64,
    /// Offset along it, cells.
    offset: f64,
    score: f64,
}

impl Cells {
    fn of(image: &Raster) -> Result<Self, FlankError> {
        let limits = FlankLimits::get();
        let side = image.rows.max(image.columns).div_ceil(limits.cells.max(1)).max(1);
        let smooth = image.blurred(limits.detail_px, limits.detail_px);
        let (rows, columns) = (image.rows / side, image.columns / side);
        let mut detail = Raster::new(rows, columns);
        let area = (side * side) as f32;
        for (k, value) in detail.values.iter_mut().enumerate() {
            let (r, c) = (k / columns * side, k % columns * side);
            let inside = (0..side * side).map(|i| (r + i / side, c + i % side));
            *value = inside.map(|(i, j)| (image.at(i, j) - smooth.at(i, j)).abs()).sum::<f32>() / area;
        }
        // single pixels that are 1 px cells scatter: the median stands for noise only when smoothed
        let detail = detail.blurred(1.0, 1.0);
        // cells without any detail are saturated, or behind the black level: they show no noise
        let seen: Vec<f32> = detail.values.iter().copied().filter(|v| *v > 0.0).collect();
        let floor = quantile(seen, limits.noise_detail);
        let full = detail.quantile(limits.full_detail, 1);
        if !(f64::from(full) > limits.least_detail * f64::from(floor)) {
            let why = format!(
                "detail of the sharpest places is {:.2} times that of the smoothest, {:.1} are needed",
                full / floor,
                limits.least_detail
            );
            return Err(FlankError::NoFlank { why });
        }
        let least = (limits.noise_share as f32 * floor).max(limits.least_share as f32 * full);
        let most = (1.5 * least).max(limits.enough_share as f32 * full);
        let share = |v: f32| ((v - least) / (most - least)).clamp(0.0, 1.0);
        Ok(Self { side, detail: detail.map(share) })
    }

    /// The likeliest borders among lines of neighbouring directions, the heaviest first.
    fn borders(&self, coarse: &[Candidate]) -> Vec<Border> {
        let limits = FlankLimits::get();
        let best = |of: &[Candidate]| of.iter().copied().max_by(|a, b| a.score.total_cmp(&b.score));
        let top = best(coarse).map_or(0.0, |c| c.score);
        // the border of a large flank at its side may have more texture beside it than an edge
        // above a smooth land: the longest wins
        let sectors = coarse.chunks(limits.sector_deg.max(1)).filter_map(best);
        let likely: Vec<Candidate> = sectors.filter(|c| c.score > limits.likely_score * top).collect();
        let refined = likely.into_par_iter().filter_map(|c| {
            let fine: Vec<Candidate> = (-6..=6).map(|k| self.best_of(c.deg + 0.25 * f64::from(k))).collect();
            let line = best(&fine)?;
            Some(Border { line, extent: self.extent(&line) })
        });
        let mut borders: Vec<Border> = refined.collect();
        borders.sort_by(|a, b| b.weight().total_cmp(&a.weight()));
        borders
    }

    /// The best offset of a direction: sums by offset, then differences of strips.
    fn best_of(&self, deg: f64) -> Candidate {
        let limits = FlankLimits::get();
        let normal = DVec2::from_angle(deg.to_radians());
        let reach = self.detail.rows.hypot_of(self.detail.columns);
        let (mut sums, mut counts) = (vec![0.0_f64; 2 * reach + 1], vec![0.0_f64; 2 * reach + 1]);
        for (row, line) in self.detail.values.chunks(self.detail.columns).enumerate() {
            let base = normal.y * row as f64 + reach as f64;
            for (column, value) in line.iter().enumerate() {
                let at = (base + normal.x * column as f64 + 0.5) as usize;
                sums[at] += f64::from(*value);
                counts[at] += 1.0;
            }
        }
        let (sums, counts) = (totals(&sums), totals(&counts));
        let (w, v) = (limits.side_cells, limits.beyond_cells);
        let mean = |of: &[f64], from: usize, to: usize| (of[to] - of[from]) / (to - from) as f64;
        let score = |k: usize| {
            // what the image does not show beyond a line is not known to be air
            let unseen = mean(&counts, k, k + w) - mean(&counts, k - 1 - v, k - 1);
            let beyond = mean(&sums, k - 1 - v, k - 1) + unseen.max(0.0);
            mean(&sums, k, k + w) - limits.beyond_weight * beyond
        };
        let best = (v + 1..sums.len() - 1 - w).map(|k| (k, score(k))).max_by(|a, b| a.1.total_cmp(&b.1));
        let (k, score) = best.unwrap_or((0, 0.0));
        Candidate { deg, offset: k as f64 - reach as f64 - 0.5, score }
    }

    /// Where along the line a flank lies beside it, cells: from the first to the last place beside
    /// which a run of texture stands.
    fn extent(&self, line: &Candidate) -> (f64, f64) {
        let limits = FlankLimits::get();
        let normal = DVec2::from_angle(line.deg.to_radians());
        let along = -normal.perp();
        let reach = self.detail.rows.hypot_of(self.detail.columns) as i64;
        let mean = |s: i64, from: i64, to: i64| {
            let place = |k: i64| normal * (line.offset + 0.5 + k as f64) + along * s as f64;
            let values = (from..to).map(place).filter_map(|p| self.detail.between(p.y, p.x));
            f64::from(values.sum::<f32>()) / (to - from) as f64
        };
        // where texture stands beyond, another border of the body goes on
        let beyond = |s: i64| mean(s, -(limits.beyond_cells as i64), -2);
        let near = |s: i64| mean(s, 0, limits.near_cells as i64);
        let beside = |s: i64| near(s).max(mean(s, 0, limits.extent_cells as i64) - beyond(s));
        let profile: Vec<f64> = (-reach..=reach).map(beside).collect();
        longest_run(&profile, limits.extent_share, 24)
            .map_or((0.0, 0.0), |(a, b)| (a as f64 - reach as f64, b as f64 - reach as f64))
    }
}

/// Sums of all values before each place.
fn totals(values: &[f64]) -> Vec<f64> {
    let add = |sum: &mut f64, v: &f64| {
        *sum += v;
        Some(*sum)
    };
    std::iter::once(0.0).chain(values.iter().scan(0.0, add)).collect()
}

/// The longest run of values above a level that bridges gaps of so many places: first and last.
fn longest_run(values: &[f64], level: f64, bridge: usize) -> Option<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for k in (0..values.len()).filter(|k| values[*k] > level) {
        match runs.last_mut() {
            Some(run) if k - run.1 <= bridge => run.1 = k,
            _ => runs.push((k, k)),
        }
    }
    runs.into_iter().max_by_key(|run| run.1 - run.0)
}

/// The diagonal of a field.
trait Diagonal {
    fn hypot_of(self, other: usize) -> usize;
}

impl Diagonal for usize {
    fn hypot_of(self, other: usize) -> usize {
        (self as f64).hypot(other as f64).ceil() as usize + 1
    }
}
