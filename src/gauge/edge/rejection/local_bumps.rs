//! Local bumps: protrusions on one side of the part relative to their own neighbourhood, whatever
//! the course of the axis.
//!
//! Where the centreline itself is wavy, or contamination covers half of the remaining field,
//! departures from one axis for the whole field are no criterion. But contamination has ends. The
//! middle of a block is compared with the line through two others some blocks away (on both sides;
//! near the border of the field on one). Contamination on one side displaces it by half of the
//! widening of the shadow, form changes the width alone, a wavy centreline the middle alone. The
//! scatter of such a comparison without contamination is estimated from the same comparison
//! elsewhere in the frame.

use nalgebra::Vector3;

use super::centreline::CentrelineLimits;
use super::departures::{
    AxisScratch, Block, DepartureLimits, LocalBump, MEDIAN_OF_BLOCK, basis, own_noise, robust_sd,
};
use crate::gauge::edges::Edge;
use crate::gauge::limit::limits;
use crate::numerics::median_network::BLOCK;

limits! {
    /// When a block protrudes from its neighbourhood.
    LocalBumpLimits = "local_bumps";
    /// Distance, blocks, at which the neighbourhood of a block is read first, for the shortest
    /// films: half their length. A block has 16 columns.
    short_reach: usize = 2;
    /// The next distance, blocks: films of six.
    middle_reach: usize = 3;
    /// The longest distance, blocks: films of ten. Over twice as many the axis is no line.
    long_reach: usize = 5;
    /// Departure from the neighbourhood that is contamination, in robust standard deviations of the
    /// same comparison at n places elsewhere: noise gives it in 6·10⁻⁵ of the blocks.
    limit: f64 = 4.0;
    /// A standard deviation from n places is uncertain, so that the limit is 1 + few/n times
    /// higher: as Student's t is wider than the normal distribution at one false-alarm probability,
    /// by (z² + 1)/(4n) to first order (Cornish-Fisher), 4.25/n at z = 4.
    few: f64 = 4.0;
    /// Factor of the limit in a field known to be contaminated, whose prior probability is higher.
    /// Tuned: see study limits.
    among_contamination: f64 = 0.85;
    /// Departure below which none is contamination, px: little more than what is tested of an axis
    /// (`departures.floor_px`), as the neighbourhood is known less well.
    floor_px: f64 = 0.05;
    /// Fewest places elsewhere from which that standard deviation is estimated: of two the median
    /// is the larger one.
    least_places: usize = 3;
    /// Share of a departure down to which the neighbouring blocks belong to it: as for the extent
    /// of a bump (`bump_extent.base`).
    flank: f64 = 0.2;
    /// Every how many columns are read for the noise of a block: it hardly varies along the field.
    every: usize = 4;
}

/// Standard deviation of a comparison over that of one block, between two others at equal distances
/// and beyond them: √1.5 and √6.
const BETWEEN: f64 = 1.2247;
const BEYOND: f64 = 2.4495;

/// Standard deviation of the middle of a block by the noise of its edges alone, px: the lower bound
/// of the scatter, as that of a few places may be smaller by chance.
fn noise_of_block(top: &[Edge], bottom: &[Edge]) -> f64 {
    let limits = LocalBumpLimits::get();
    let own = |edge: &Edge| f64::from(edge.u_own_px).powi(2);
    let pairs = top.iter().zip(bottom).step_by(limits.every).filter(|(t, b)| t.is_usable() && b.is_usable());
    let (sum, count) = pairs.fold((0.0, 0.0_f64), |(sum, n), (t, b)| (sum + own(t) + own(b), n + 1.0));
    MEDIAN_OF_BLOCK * (0.25 * sum / count.max(1.0)).sqrt()
}

impl LocalBumpLimits {
    fn reaches(&self) -> [usize; 3] {
        [self.short_reach, self.middle_reach, self.long_reach]
    }
}

impl AxisScratch {
    /// Marks protrusions from the neighbourhood on one side, which a wavy centreline would
    /// otherwise hide.
    pub(crate) fn mark_local(
        &mut self,
        axis: &Vector3<f64>,
        (column_sd, contaminated): (f64, bool),
        edges: (&[Edge], &[Edge]),
    ) -> bool {
        let departure_limits = DepartureLimits::get();
        let limits = LocalBumpLimits::get();
        let block_noise = noise_of_block(edges.0, edges.1);
        let mut any = false;
        for reach in limits.reaches() {
            for (border, gain) in [(false, BETWEEN), (true, BEYOND)] {
                any |=
                    self.mark_bumps(axis, (reach, border), (gain, gain * block_noise, contaminated), edges);
            }
        }
        if any {
            self.grow((departure_limits.grow * column_sd).max(0.5 * departure_limits.floor_px) as f32);
        }
        any
    }

    /// Finds the local bumps at one reach, the largest first, and marks those that exceed what the
    /// same comparison gives where they have no part in it; without the largest, the two largest, …
    /// of them, as one local bump may hide the others.
    fn mark_bumps(
        &mut self,
        axis: &Vector3<f64>,
        (reach, border): (usize, bool),
        (gain, noise, contaminated): (f64, f64, bool),
        edges: (&[Edge], &[Edge]),
    ) -> bool {
        let departure_limits = DepartureLimits::get();
        let limits = LocalBumpLimits::get();
        self.suspects.clear();
        let mut any = false;
        while self.suspects.len() < departure_limits.bumps {
            let Some(bump) = self.bump(axis, reach, border) else { break };
            self.suspects.push(bump);
            let (places, sd) = self.elsewhere(axis, reach, bump.step);
            if places < limits.least_places {
                continue;
            }
            let few =
                if contaminated { limits.among_contamination } else { 1.0 + limits.few / places as f64 };
            let limit = limits.limit * few * (0.75 + 0.25 * self.suspects.len() as f64);
            for suspect in 0..self.suspects.len() {
                let bump = self.suspects[suspect];
                let from = self.blocks[bump.first].index * BLOCK;
                let to = ((self.blocks[bump.last].index + 1) * BLOCK).min(self.departures.len());
                // In the dim part of uneven light edges scatter by more than the field's do.
                let own = gain * MEDIAN_OF_BLOCK * own_noise(edges, from..to);
                if bump.peak.abs() > limit * sd.max(noise).max(own) {
                    self.refused[from..to].fill(true);
                    any = true;
                }
            }
        }
        any
    }

    /// Whether a block is neither refused nor part of a suspected bump.
    fn is_open(&self, k: usize) -> bool {
        !self.refused[self.blocks[k].index * BLOCK]
            && !self.suspects.iter().any(|bump| bump.first <= k && k <= bump.last)
    }

    /// The next open block at least `reach` blocks away from one, towards a side.
    fn neighbour(&self, k: usize, reach: usize, step: isize) -> Option<usize> {
        let index = self.blocks[k].index;
        let mut at = k;
        loop {
            at = at.checked_add_signed(step).filter(|at| *at < self.blocks.len())?;
            let apart = self.blocks[at].index.abs_diff(index);
            if apart > 3 * reach {
                return None;
            }
            if apart >= reach && self.is_open(at) {
                return Some(at);
            }
        }
    }

    /// The two blocks between which, or beyond which (`step`: on which side they lie), a block's
    /// neighbourhood is drawn.
    fn neighbours(&self, k: usize, reach: usize, step: isize) -> Option<(usize, usize)> {
        let near = self.neighbour(k, reach, if step == 0 { -1 } else { step })?;
        let far = if step == 0 { self.neighbour(k, reach, 1)? } else { self.neighbour(near, reach, step)? };
        Some((near, far))
    }

    /// By how much a block's middle and width stand out of the line through two others.
    fn protrusion(&self, axis: &Vector3<f64>, k: usize, (one, two): (usize, usize)) -> (f64, f64) {
        let (a, b, c) = (&self.blocks[one], &self.blocks[k], &self.blocks[two]);
        let share = (b.x - a.x) / (c.x - a.x);
        let departure = |block: &Block| block.middle - axis.dot(&basis(block.x));
        let over = |one: f64, here: f64, two: f64| here - one - share * (two - one);
        (over(departure(a), departure(b), departure(c)), over(a.width, b.width, c.width))
    }

    /// The block that protrudes most as contamination does, within the field or near its border,
    /// with those of its neighbours that protrude too.
    fn bump(&self, axis: &Vector3<f64>, reach: usize, border: bool) -> Option<LocalBump> {
        let departure_limits = DepartureLimits::get();
        let limits = LocalBumpLimits::get();
        let centreline_limits = CentrelineLimits::get();
        let n = self.blocks.len();
        let mut most: Option<LocalBump> = None;
        let steps: &[isize] = if border { &[-1, 1] } else { &[0] };
        for step in steps {
            for k in (0..n).filter(|k| self.is_open(*k)) {
                if border && self.neighbour(k, reach, -step).is_some() {
                    continue;
                }
                let Some(ends) = self.neighbours(k, reach, *step) else { continue };
                let (peak, widening) = self.protrusion(axis, k, ends);
                let moved = 2.0 * peak.abs();
                let contamination = widening > centreline_limits.least_widening * moved
                    && widening < centreline_limits.most_widening * moved;
                if contamination && peak.abs() > most.map_or(limits.floor_px, |m| m.peak.abs()) {
                    most = Some(LocalBump { peak, first: k, last: k, step: *step });
                }
            }
        }
        let mut bump = most?;
        let ends = self.neighbours(bump.first, reach, bump.step)?;
        let least = (limits.flank * bump.peak.abs()).max(0.5 * departure_limits.floor_px);
        let belongs = |at: &usize| {
            *at != ends.0 && *at != ends.1 && self.protrusion(axis, *at, ends).0 * bump.peak.signum() > least
        };
        bump.first = (0..bump.first).rev().take_while(belongs).last().unwrap_or(bump.first);
        bump.last = (bump.last + 1..n).take_while(belongs).last().unwrap_or(bump.last);
        Some(bump)
    }

    /// Number and robust standard deviation of the same comparison over blocks outside all bumps.
    fn elsewhere(&mut self, axis: &Vector3<f64>, reach: usize, step: isize) -> (usize, f64) {
        let mut sizes = std::mem::take(&mut self.sizes);
        sizes.clear();
        let places = (0..self.blocks.len()).filter(|at| self.is_open(*at));
        let ends = places.filter_map(|at| self.neighbours(at, reach, step).map(|ends| (at, ends)));
        sizes.extend(ends.map(|(at, ends)| self.protrusion(axis, at, ends).0.abs()));
        self.sizes = sizes;
        let places = self.sizes.len();
        (places, if places == 0 { 0.0 } else { robust_sd(&mut self.sizes) })
    }
}
