//! Where the cutting edge lies: the straight line on one side of which the image has detail
//! (the flank, in focus) and on the other none (the air and what stands behind it).
//!
//! Detail is |I − G·I|; of the sums over strips on both sides of every line (directions of a
//! degree, then of a quarter) the largest difference wins. A light background out of focus has no
//! detail however bright it is.

use glam::DVec2;

use super::error::FlankError;
use super::limits::FlankLimits;
use super::raster::Raster;

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

struct Cells {
    side: usize,
    detail: Raster,
}

/// Finds the line.
///
/// # Errors
/// Nothing in focus; nothing long enough.
pub(crate) fn edge_line(image: &Raster) -> Result<EdgeLine, FlankError> {
    let limits = FlankLimits::get();
    let cells = Cells::of(image)?;
    let coarse = (0..360).map(|k| cells.best_of(f64::from(k)));
    let best = coarse.max_by(|a, b| a.score.total_cmp(&b.score));
    let best = best.ok_or_else(|| FlankError::NoFlank { why: "no line".to_owned() })?;
    let fine = (-6..=6).map(|k| cells.best_of(best.deg + 0.25 * f64::from(k)));
    let best = fine.max_by(|a, b| a.score.total_cmp(&b.score)).unwrap_or(best);
    let (from, to) = cells.extent(&best);
    if to - from < limits.least_cells {
        let why = format!(
            "the longest border of what is in focus is {:.0} px long, {:.0} are needed",
            (to - from) * cells.side as f64,
            limits.least_cells * cells.side as f64
        );
        return Err(FlankError::NoFlank { why });
    }
    let normal = DVec2::from_angle(best.deg.to_radians());
    let along = -normal.perp();
    let place =
        |s: f64| (normal * best.offset + along * s) * cells.side as f64 + 0.5 * (cells.side as f64 - 1.0);
    Ok(EdgeLine { from: place(from), along, normal, length_px: (to - from) * cells.side as f64 })
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
        let (middle, full) = (detail.quantile(0.5, 1), detail.quantile(limits.full_detail, 1));
        if !(f64::from(full) > limits.least_detail * f64::from(middle)) {
            let why = format!(
                "detail of the sharpest places is {:.2} times that of the middle ones, {:.1} are needed",
                full / middle,
                limits.least_detail
            );
            return Err(FlankError::NoFlank { why });
        }
        let share = |v: f32| ((v - 1.3 * middle) / (full - middle)).clamp(0.0, 1.0);
        Ok(Self { side, detail: detail.map(share) })
    }

    /// The best offset of a direction: sums by offset, then differences of strips.
    fn best_of(&self, deg: f64) -> Candidate {
        let limits = FlankLimits::get();
        let normal = DVec2::from_angle(deg.to_radians());
        let reach = self.detail.rows.hypot_of(self.detail.columns);
        let mut sums = vec![0.0_f64; 2 * reach + 1];
        for (row, line) in self.detail.values.chunks(self.detail.columns).enumerate() {
            let base = normal.y * row as f64 + reach as f64;
            for (column, value) in line.iter().enumerate().filter(|(_, v)| **v > 0.0) {
                sums[(base + normal.x * column as f64).round() as usize] += f64::from(*value);
            }
        }
        let total: Vec<f64> = std::iter::once(0.0)
            .chain(sums.iter().scan(0.0, |sum, v| {
                *sum += v;
                Some(*sum)
            }))
            .collect();
        let w = limits.side_cells;
        let score =
            |k: usize| (total[k + w] - total[k]) - limits.beyond_weight * (total[k - 1] - total[k - 1 - w]);
        let best = (w + 1..sums.len() - w).map(|k| (k, score(k))).max_by(|a, b| a.1.total_cmp(&b.1));
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
        let beside = |s: i64| {
            let inside = |k: usize| normal * (line.offset + 0.5 + k as f64) + along * s as f64;
            let values = (0..limits.side_cells).map(inside).filter_map(|p| self.detail.between(p.y, p.x));
            f64::from(values.sum::<f32>()) / limits.side_cells as f64
        };
        let profile: Vec<f64> = (-reach..=reach).map(beside).collect();
        longest_run(&profile, 0.08, 24)
            .map_or((0.0, 0.0), |(a, b)| (a as f64 - reach as f64, b as f64 - reach as f64))
    }
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
