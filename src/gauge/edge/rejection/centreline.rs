//! The axis on which most blocks of a frame lie: a parabola over the field, fitted robustly where
//! blocks disagree.

use nalgebra::Vector3;

use super::departures::{AxisScratch, Block, DepartureLimits, basis};
use crate::gauge::limit::limits;
use crate::numerics::normal_equations::NormalEquations;
use crate::numerics::robust::MEDIAN_TO_SD;

limits! {
    /// Which axis a frame has where its blocks disagree.
    CentrelineLimits = "centreline";
    /// Number of trial axes of the robust fit. Of the 80 parabolas among them 3 in 10 pass through
    /// blocks that are far enough apart ((2/3)³), and 8/27 of these through none of a covered third
    /// of the field: none does once in 4600 frames, (19/27)²⁴.
    trials: usize = 160;
    /// Bend over half a field, px, up to which it is the part's own: a shaft bent by 0.1 mm on 500
    /// mm bends by 0.4 µm on 30 mm, 0.03 px.
    own_bend_px: f64 = 0.03;
    /// Departures from the plain parabola up to which no other axis is looked for, px: little more
    /// than what is tested (`departures.floor_px`).
    calm_px: f64 = 0.05;
    /// Scatter of another axis over that about the least-squares parabola, up to which it replaces
    /// the parabola. Half of any field's blocks scatter less than all. Tuned: see study limits.
    better: f64 = 0.35;
    /// Bend up to which the parabola may be the axis of a part that is wavy, px: ten times
    /// `own_bend_px`.
    part_bend_px: f64 = 0.3;
    /// Widening over twice the departure of the middle, from which on a stretch is contamination:
    /// half-way between that of contamination on one side, 1, and that of an axis that is wavy, 0.
    least_widening: f64 = 0.5;
    /// The same ratio above which a stretch is form: where both edges move outwards the width grows
    /// and the middle does not. Tuned: see study limits.
    most_widening: f64 = 1.6;
    /// Departure of a stretch's peak over what separates the stretch from the axis, from which on
    /// it protrudes: a stretch just beyond that is one by chance. Tuned: see study limits.
    prominent: f64 = 1.5;
    /// Share of what leaves the axis that must protrude: contamination does all of it but for
    /// chance, texture half. The middle of the two.
    protruding: f64 = 0.75;
    /// Usual bend of the axis over half a field, px; see `own_bend_px`. A film as long as the field
    /// looks like a bend; a larger one than usual costs a trial its spread times √(1 +
    /// (bend/this)²).
    usual_bend_px: f64 = 0.05;
}

impl AxisScratch {
    /// The parabola by unweighted least squares.
    pub(super) fn plain(&self) -> Option<Vector3<f64>> {
        fit(self.blocks.iter().map(Block::point), true)
    }

    /// Whether all blocks lie on a parabola with negligible bend.
    pub(super) fn is_calm(&self, plain: &Vector3<f64>) -> bool {
        let limits = CentrelineLimits::get();
        plain[2].abs() < limits.own_bend_px && !self.blocks.iter().any(|b| far(plain, limits.calm_px, b))
    }

    /// The axis of a frame that is not calm: the one about which half of the blocks scatter least.
    /// `noise`: standard deviation of the median of a block, px.
    pub(super) fn axis(&mut self, plain: Vector3<f64>, noise: f64) -> Option<Vector3<f64>> {
        let limits = CentrelineLimits::get();
        let mut found = self.candidates(&plain)?;
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Contamination protrudes from the axis, or half of the field agrees with a straighter axis
        // far better; where neither is so, or the rest would be recesses, the axis itself is wavy.
        let shares = found.map(|(_, axis)| self.protrusions(&axis));
        for ((cost, axis), (protruding, _)) in found.iter().zip(shares) {
            if cost.is_finite() && protruding > limits.protruding {
                return Some(*axis);
            }
        }
        // Of few blocks half lie near some parabola by chance, closer than their noise.
        let spread = found[0].0.max(noise);
        let wanders = spread > limits.better * self.spread(&plain) && plain[2].abs() < limits.part_bend_px;
        Some(if wanders || shares[0].1 > limits.protruding { plain } else { found[0].1 })
    }

    /// The best line and the best parabola with their costs, each refined over all blocks that
    /// agree with it, since a trial passes exactly through two or three.
    fn candidates(&mut self, plain: &Vector3<f64>) -> Option<[(f64, Vector3<f64>); 2]> {
        let limits = CentrelineLimits::get();
        let mut best = [(f64::INFINITY, *plain), (self.cost(plain), *plain)];
        let n = self.blocks.len();
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        let mut draw = |from: usize, to: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            from + ((state >> 33) as usize) % (to - from).max(1)
        };
        for trial in 0..limits.trials {
            // An axis through neighbouring blocks is not determined elsewhere in the field.
            let mut three = [draw(0, n), draw(0, n), draw(0, n)];
            three.sort_unstable();
            let bent = trial % 2 == 0;
            let apart =
                if bent { (three[1] - three[0]).min(three[2] - three[1]) } else { three[2] - three[0] };
            if apart < n / 6 {
                continue;
            }
            let axis = through(three.map(|k| self.blocks[k].point()), bent);
            let (cost, kept) = &mut best[usize::from(bent)];
            if self.is_cheaper(&axis, *cost) {
                (*cost, *kept) = (self.cost(&axis), axis);
            }
        }
        for (cost, axis) in best.iter_mut().filter(|(cost, _)| cost.is_finite()) {
            *axis = self.refined(*axis)?;
            *cost = cost.min(self.cost(axis));
        }
        Some(best)
    }

    /// Refines an axis by least squares over the blocks that agree with it.
    fn refined(&mut self, mut axis: Vector3<f64>) -> Option<Vector3<f64>> {
        let departure_limits = DepartureLimits::get();
        let limits = CentrelineLimits::get();
        for _ in 0..3 {
            let limit = (3.0 * self.spread(&axis)).max(0.5 * departure_limits.floor_px);
            let kept = || self.blocks.iter().filter(|b| !far(&axis, limit, b)).map(Block::point);
            let bent = fit(kept(), true)?;
            axis = if bent[2].abs() < limits.usual_bend_px.max(1.5 * axis[2].abs()) {
                bent
            } else {
                fit(kept(), false)?
            };
        }
        Some(axis)
    }

    /// Which share of what leaves an axis protrudes, and which recedes: contamination on one side
    /// widens the shadow by twice what it moves the middle by; an axis that is wavy moves both
    /// edges alike, texture has as many recesses as protrusions; a chip taken for the part leaves
    /// the part a recess.
    fn protrusions(&mut self, axis: &Vector3<f64>) -> (f64, f64) {
        let limits = CentrelineLimits::get();
        let limit = (3.0 * self.spread(axis)).max(DepartureLimits::get().floor_px);
        let leaves = |b: &Block| far(axis, limit, b);
        let within = self.blocks.iter().filter(|b| !leaves(b));
        let Some(line) = fit(within.map(|b| (b.x, b.width)), false) else { return (0.0, 0.0) };
        let (mut protruding, mut receding, mut all) = (0.0, 0.0, 0.0);
        let (mut from, n) = (0, self.blocks.len());
        while from < n {
            if !leaves(&self.blocks[from]) {
                from += 1;
                continue;
            }
            let to = (from..n).find(|k| !leaves(&self.blocks[*k])).unwrap_or(n);
            let (widening, square) = self.widening(axis, &line, from..to);
            let peak = self.blocks[from..to].iter().any(|b| far(axis, limits.prominent * limit, b));
            all += square;
            if peak && widening > limits.least_widening * square && widening < limits.most_widening * square {
                protruding += square;
            }
            if widening < -limits.least_widening * square {
                receding += square;
            }
            from = to;
        }
        if all > 0.0 { (protruding / all, receding / all) } else { (0.0, 0.0) }
    }

    /// Over a run of blocks: Σ a·b and Σ a², with a twice the departure of the middle and b the
    /// width, both relative to the neighbours of the run.
    fn widening(&self, axis: &Vector3<f64>, line: &Vector3<f64>, run: std::ops::Range<usize>) -> (f64, f64) {
        let over = |b: &Block| (2.0 * (b.middle - axis.dot(&basis(b.x))), b.width - line.dot(&basis(b.x)));
        let before = run.start.checked_sub(1).map(|k| over(&self.blocks[k]));
        let after = self.blocks.get(run.end).map(over);
        let (mut widening, mut square) = (0.0, 0.0);
        for (k, b) in self.blocks[run.clone()].iter().enumerate() {
            let share = (k as f64 + 1.0) / (run.len() as f64 + 1.0);
            let level = match (before, after) {
                (Some(one), Some(two)) => (one.0 + share * (two.0 - one.0), one.1 + share * (two.1 - one.1)),
                (Some(one), None) | (None, Some(one)) => one,
                (None, None) => (0.0, 0.0),
            };
            let (moved, width) = over(b);
            let moved = moved - level.0;
            widening += moved.abs() * (width - level.1);
            square += moved * moved;
        }
        (widening, square)
    }

    /// Scatter about an axis, multiplied by its bend penalty.
    fn cost(&mut self, axis: &Vector3<f64>) -> f64 {
        self.spread(axis) * bend_penalty(axis)
    }

    /// Whether an axis costs less than `cost`. Counted, not sorted: the quantile is below the limit
    /// exactly if that many departures are.
    fn is_cheaper(&self, axis: &Vector3<f64>, cost: f64) -> bool {
        let departure_limits = DepartureLimits::get();
        let limit = cost / (MEDIAN_TO_SD * bend_penalty(axis));
        let (a, b, c) = (axis[0], axis[1], axis[2]);
        let near = |block: &Block| {
            let (x, m) = block.point();
            u32::from((m - (a + x * (b + x * c))).abs() < limit)
        };
        let agreeing: u32 = self.blocks.iter().map(near).sum();
        agreeing as usize > (departure_limits.agreeing * self.blocks.len() as f64) as usize
    }
}

/// Whether a block lies further than `limit` px from an axis.
fn far(axis: &Vector3<f64>, limit: f64, block: &Block) -> bool {
    (block.middle - axis.dot(&basis(block.x))).abs() > limit
}

/// What an axis costs for its bend.
fn bend_penalty(axis: &Vector3<f64>) -> f64 {
    (1.0 + (axis[2] / CentrelineLimits::get().usual_bend_px).powi(2)).sqrt()
}

/// The parabola through three points, or the line through the first and the last.
fn through(points: [(f64, f64); 3], bent: bool) -> Vector3<f64> {
    let [(x0, y0), (x1, y1), (x2, y2)] = points;
    let whole = (y2 - y0) / (x2 - x0);
    let bend = if bent { ((y1 - y0) / (x1 - x0) - whole) / (x1 - x2) } else { 0.0 };
    let slope = whole - bend * (x0 + x2);
    Vector3::new(y0 - x0 * (slope + bend * x0), slope, bend)
}

/// Parabola or line by least squares; `None` where the points do not determine it.
pub(super) fn fit(points: impl Iterator<Item = (f64, f64)>, bent: bool) -> Option<Vector3<f64>> {
    let mut fit = NormalEquations::new();
    for (x, y) in points {
        fit.add(if bent { basis(x) } else { Vector3::new(1.0, x, 0.0) }, y, 1.0);
    }
    if !bent {
        fit.normal[(2, 2)] = 1.0;
    }
    fit.by_cholesky()
}

#[cfg(test)]
mod tests;
