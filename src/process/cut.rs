//! The cut itself: from commanded diameters to diameters that remain, node by node along the feed.

use super::beam::{Part, SteadyRest, Supports, compliance_at_joint, left_parts};
use super::force::DepthLaw;
use super::force_components::Components;
use super::geometry::tangential_error_mm;
use super::material::Material;
use super::section::Section;
use crate::plan::CutSummary;

/// Inputs of a pass, borrowed, so that an error leaves the workpiece unchanged.
pub(super) struct Cut<'a> {
    pub before: &'a [f64],
    pub commanded: &'a [f64],
    pub law: DepthLaw,
    pub step_mm: f64,
    pub supports: Supports,
    pub material: &'a Material,
    /// Tangential displacement of the axis at every node without the force, mm, where the diameter
    /// carries the tangential error.
    pub tangential_mm: Option<&'a [f64]>,
}

/// The result of a cut, node by node.
#[derive(Clone, Debug)]
pub(super) struct Passed {
    /// Diameter, mm.
    pub after: Vec<f64>,
    /// Depth that was cut, mm.
    pub depth_mm: Vec<f64>,
    /// Extremes over the pass.
    pub summary: CutSummary,
}

impl Cut<'_> {
    /// Diameters after the pass, the tool travelling from the last node to the first, and the
    /// extremes on the way.
    pub(super) fn towards_first(&self) -> Passed {
        let lefts = self.uncut_left_parts();
        let mut right = self.supports.tailstock;
        let mut after = self.before.to_vec();
        let mut depth_mm = vec![0.0; after.len()];
        let mut softest = 0.0;
        let mut summary = CutSummary { min_depth_mm: f64::INFINITY, ..CutSummary::default() };
        for node in (0..after.len()).rev() {
            let behind = after.get(node + 1).copied();
            // The element behind the tool: the diameter of its near end results from the cut at
            // this node.
            let probe = behind.map_or(right, |d| self.extended(right, d));
            let compliance = compliance_at_joint(&lefts[node], &probe);
            let depth = self.law.depth_mm(0.5 * (self.before[node] - self.commanded[node]), compliance);
            let force = self.law.components(depth);
            after[node] = self.before[node] - 2.0 * depth;
            depth_mm[node] = depth;
            if let Some(still) = self.tangential_mm {
                let aside = still[node] + compliance * force.cutting_n;
                after[node] += tangential_error_mm(after[node], aside);
            }
            include(&mut summary, depth, &force, compliance);
            softest = f64::max(softest, compliance);
            if let Some(behind) = behind {
                right = self.extended(right, 0.5 * (behind + after[node]));
            }
            self.supports.rests_at(node, self.step_mm).for_each(|rest| right.support(rest));
        }
        // The product of both maxima is an upper bound of the largest product.
        let tangential = softest * self.law.components(summary.max_depth_mm).cutting_n;
        let thinnest = after.iter().copied().fold(f64::INFINITY, f64::min);
        summary.tangential_error_um = 1e3 * tangential_error_mm(thinnest, tangential);
        Passed { after, depth_mm, summary }
    }

    /// The same with the tool travelling from the first node to the last: the mirror image.
    pub(super) fn towards_last(&self) -> Passed {
        let mirrored = |values: &[f64]| values.iter().rev().copied().collect::<Vec<f64>>();
        let length = self.step_mm * (self.before.len() - 1) as f64;
        let rest = |rest: &SteadyRest| SteadyRest { z_mm: length - rest.z_mm, ..*rest };
        let (before, commanded) = (mirrored(self.before), mirrored(self.commanded));
        let tangential = self.tangential_mm.map(mirrored);
        let image = Cut {
            before: &before,
            commanded: &commanded,
            tangential_mm: tangential.as_deref(),
            supports: Supports {
                chuck: self.supports.tailstock,
                tailstock: self.supports.chuck,
                steady_rests: self.supports.steady_rests.iter().map(rest).collect(),
            },
            ..*self
        };
        let passed = image.towards_first();
        Passed { after: mirrored(&passed.after), depth_mm: mirrored(&passed.depth_mm), ..passed }
    }

    fn extended(&self, mut part: Part, diameter_mm: f64) -> Part {
        part.extend(self.step_mm, &Section::circular(diameter_mm, self.material));
        part
    }

    fn uncut_left_parts(&self) -> Vec<Part> {
        let element = |pair: &[f64]| Section::circular(0.5 * (pair[0] + pair[1]), self.material);
        let sections: Vec<Section> = self.before.windows(2).map(element).collect();
        left_parts(self.step_mm, &sections, &self.supports)
    }
}

/// Adds a node to the extremes of the pass.
fn include(summary: &mut CutSummary, depth_mm: f64, force: &Components, compliance_mm_per_n: f64) {
    summary.min_depth_mm = summary.min_depth_mm.min(depth_mm);
    summary.max_depth_mm = summary.max_depth_mm.max(depth_mm);
    summary.max_force_n = summary.max_force_n.max(force.passive_n);
    summary.max_cutting_n = summary.max_cutting_n.max(force.cutting_n);
    summary.max_feed_n = summary.max_feed_n.max(force.feed_n);
    summary.max_deflection_mm = summary.max_deflection_mm.max(force.passive_n * compliance_mm_per_n);
}
