//! Whether an edge lies on the line of its neighbours, and whether both lines are contours of one
//! part.

use crate::gauge::edges::{Edge, EdgeState};
use crate::gauge::limit::limits;
use crate::numerics::robust::upper_median;
use crate::profile::Reason;

limits! {
    /// When edges lie on one line with their neighbours.
    NeighbourLimits = "neighbour_test";
    /// Columns whose median represents a neighbourhood: it is known to 0.22 of one column's u,
    /// 1.25/√32, and up to fifteen outliers leave it.
    neighbours: usize = 32;
    /// Shortest run of columns that counts as a contour: blobs of noise are shorter.
    contour: usize = 32;
    /// Gap, columns, that does not end a contour. Tuned: see study limits.
    bridge: usize = 16;
    /// Share of a contour's columns that must have both edges: two hot pixels in a hundred leave
    /// half of them, where a window of a dozen pixels at either edge has none.
    present: f64 = 1.0 / 3.0;
}

/// Medians of the usable edges in groups of neighbours, as (column, row).
fn medians(line: &[Edge], pool: &mut Vec<f64>, out: &mut Vec<(f64, f64)>) {
    let limits = NeighbourLimits::get();
    out.clear();
    for (index, chunk) in line.chunks(limits.neighbours).enumerate() {
        pool.clear();
        let mut column = 0.0;
        for (offset, edge) in chunk.iter().enumerate().filter(|(_, e)| e.is_usable()) {
            pool.push(edge.row_px);
            column += offset as f64;
        }
        if pool.len() >= 4 {
            let column = column / pool.len() as f64 + (index * limits.neighbours) as f64;
            out.extend(upper_median(pool, f64::total_cmp).map(|median| (column, median)));
        }
    }
}

/// Buffers of [`refuse_outliers`], reused from frame to frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct OutlierScratch {
    pool: Vec<f64>,
    medians: Vec<(f64, f64)>,
}

impl OutlierScratch {
    /// Reserves buffers for lines of so many columns.
    pub(crate) fn reserve(&mut self, columns: usize) {
        let limits = NeighbourLimits::get();
        self.pool.reserve(limits.neighbours.saturating_sub(self.pool.len()));
        self.medians.reserve((columns / limits.neighbours + 1).saturating_sub(self.medians.len()));
    }
}

/// Refuses edges further than `limit_px` (and six standard uncertainties) from the line through the
/// medians of their neighbourhood. Where the medians themselves bend, the bend is allowed on top.
pub(crate) fn refuse_outliers(line: &mut [Edge], limit_px: f64, scratch: &mut OutlierScratch) {
    if is_quiet(line, limit_px) {
        return;
    }
    medians(line, &mut scratch.pool, &mut scratch.medians);
    let knots = &scratch.medians;
    if knots.len() < 2 {
        return;
    }
    let mut left = 0;
    for (column, edge) in line.iter_mut().enumerate() {
        let at = column as f64;
        while left + 2 < knots.len() && knots[left + 1].0 <= at {
            left += 1;
        }
        if !edge.is_usable() {
            continue;
        }
        let (a, b) = (knots[left], knots[left + 1]);
        let slope = (b.1 - a.1) / (b.0 - a.0);
        let expected = a.1 + slope * (at - a.0);
        let departure = (edge.row_px - expected).abs();
        if !(departure <= limit_px) && !(departure <= limit_px.max(6.0 * edge.u_px()) + bend(knots, left)) {
            edge.state = EdgeState::Gap(Reason::Outlier);
        }
    }
}

/// Whether no edge of a line can be an outlier: every three neighbouring groups are complete and,
/// about the line through the ends, span so little that nothing between their medians (nor beyond
/// them, at the ends) lies `limit_px` away.
fn is_quiet(line: &[Edge], limit_px: f64) -> bool {
    let limits = NeighbourLimits::get();
    let (Some(first), Some(last)) = (line.first(), line.last()) else { return true };
    let slope = (last.row_px - first.row_px) / line.len() as f64;
    let mut before = [(f64::INFINITY, f64::NEG_INFINITY); 2];
    for (index, group) in line.chunks(limits.neighbours).enumerate() {
        let (mut low, mut high, mut usable) = (f64::INFINITY, f64::NEG_INFINITY, true);
        for (offset, edge) in group.iter().enumerate() {
            let row = edge.row_px - slope * (index * limits.neighbours + offset) as f64;
            low = if row < low { row } else { low };
            high = if row > high { row } else { high };
            usable &= edge.is_usable() & row.is_finite();
        }
        let lowest = before.iter().fold(low, |l, b| l.min(b.0));
        let highest = before.iter().fold(high, |h, b| h.max(b.1));
        // An extrapolation reaches half as far again, beyond a short last group a little farther.
        if !(usable && 1.75 * (highest - lowest) <= limit_px) {
            return false;
        }
        before = [before[1], (low, high)];
    }
    true
}

/// Half the largest second difference of the medians around an interval, px: the departure of an
/// arc from its chord, at the ends too.
fn bend(knots: &[(f64, f64)], left: usize) -> f64 {
    let second = |k: usize| (knots[k + 1].1 - 2.0 * knots[k].1 + knots[k - 1].1).abs();
    let before = if left >= 1 { second(left) } else { 0.0 };
    let after = if left + 2 < knots.len() { second(left + 1) } else { 0.0 };
    0.5 * before.max(after)
}

/// The largest step from one column to the next of a line without gaps, px; infinite where there is
/// one.
pub(crate) fn largest_jump(line: &[Edge]) -> f64 {
    let (mut most, mut whole) = (0.0_f64, true);
    let mut last = line.first().map_or(f64::NAN, |edge| edge.row_px);
    for edge in line {
        let jump = (edge.row_px - last).abs();
        most = if jump > most { jump } else { most };
        whole &= edge.is_usable() & jump.is_finite();
        last = edge.row_px;
    }
    if whole { most } else { f64::INFINITY }
}

/// Fraction of the usable columns that lie in runs over at least 32 columns (half the frame, in
/// narrower ones) along which neither edge jumps: near 1 for a part, small for blobs of noise that
/// happen to have edges.
pub(crate) fn coherence(top: &[Edge], bottom: &[Edge], jump_px: f64) -> f64 {
    let limits = NeighbourLimits::get();
    let contour = limits.contour.min(top.len() / 2).max(1);
    let (mut all, mut coherent, mut run, mut first) = (0_usize, 0_usize, 0_usize, 0_usize);
    let mut last: Option<(usize, f64, f64)> = None;
    let is_contour = |run: usize, span: usize| span >= contour && run as f64 >= limits.present * span as f64;
    for (column, (t, b)) in top.iter().zip(bottom).enumerate() {
        if !(t.is_usable() && b.is_usable()) {
            continue;
        }
        all += 1;
        let goes_on = last.is_some_and(|(c, top, bottom)| {
            let gap = column - c;
            let limit = jump_px * gap.min(limits.bridge / 2) as f64;
            gap <= limits.bridge && (t.row_px - top).abs() <= limit && (b.row_px - bottom).abs() <= limit
        });
        if !goes_on {
            let span = last.map_or(0, |(c, ..)| c + 1 - first);
            coherent += if is_contour(run, span) { run } else { 0 };
            (run, first) = (0, column);
        }
        run += 1;
        last = Some((column, t.row_px, b.row_px));
    }
    let span = last.map_or(0, |(c, ..)| c + 1 - first);
    coherent += if is_contour(run, span) { run } else { 0 };
    coherent as f64 / all.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_contour_of_half_the_columns_is_one_and_scattered_edges_are_none() {
        let line = |rows: &dyn Fn(usize) -> Option<f64>| -> Vec<Edge> {
            let edge =
                |row_px| Edge { row_px, u_own_px: 0.01, u_shared_px: 0.0, chi2: 1.0, state: EdgeState::Good };
            (0..160).map(|c| rows(c).map_or(Edge::gap(Reason::Residual), edge)).collect()
        };
        // 0x9e37…: a fixed draw of half of the columns, gaps of up to eleven among them.
        let draw = |c: usize| (c as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(23) >> 40;
        let half = line(&|c| (draw(c) % 100 < 50 && c % 40 > 11).then_some(30.0));
        assert!(half.iter().filter(|e| e.is_usable()).count() < 90);
        assert_eq!(coherence(&half, &half, 2.5), 1.0);
        let noise = line(&|c| Some((draw(c) % 120) as f64));
        assert!(coherence(&noise, &noise, 2.5) < 0.1);
        let sparse = line(&|c| (c % 7 == 0).then_some((draw(c) % 120) as f64));
        assert!(coherence(&sparse, &sparse, 2.5) < 0.1);
    }

    #[test]
    fn one_stray_edge_is_refused_on_a_slope_and_on_an_arc() {
        let edge =
            |row_px| Edge { row_px, u_own_px: 0.01, u_shared_px: 0.0, chi2: 1.0, state: EdgeState::Good };
        for bent in [0.0, 1.0 / 1000.0] {
            let mut line: Vec<Edge> =
                (0..300).map(|c| edge(0.1 * f64::from(c) + bent * f64::from(c * c))).collect();
            line[77].row_px += 4.0;
            refuse_outliers(&mut line, 1.5, &mut OutlierScratch::default());
            let refused: Vec<usize> = (0..300).filter(|c| !line[*c].is_usable()).collect();
            assert_eq!(refused, [77]);
        }
    }
}
