//! The cut itself: from commanded diameters to diameters that remain, node by node along the feed.

use super::beam::{Part, SteadyRest, Supports, compliance_at_joint};
use super::force::DepthLaw;
use super::force_components::Components;
use super::geometry::tangential_error_mm;
use super::grid::Grid;
use super::material::Material;
use super::section::Section;
use crate::plan::CutSummary;

/// A node of the workpiece before the tool reaches it, mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct UncutNode {
    /// Diameter.
    pub before: f64,
    /// Diameter that is commanded.
    pub commanded: f64,
    /// Tangential displacement of the axis without the force.
    pub aside: f64,
}

/// A node of the workpiece behind the tool, mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct CutNode {
    /// Diameter.
    pub after: f64,
    /// Depth that was cut.
    pub depth: f64,
}

/// Inputs of a pass, borrowed, so that an error leaves the workpiece unchanged.
pub(super) struct Cut<'a> {
    pub nodes: &'a [UncutNode],
    pub law: DepthLaw,
    pub grid: &'a Grid,
    pub supports: Supports,
    pub material: &'a Material,
    /// Whether the diameter carries the tangential error.
    pub tangential_error: bool,
}

/// The result of a cut.
#[derive(Clone, Debug)]
pub(super) struct Passed {
    pub nodes: Vec<CutNode>,
    /// Extremes over the pass.
    pub summary: CutSummary,
}

impl Cut<'_> {
    /// Diameters after the pass, the tool travelling from the last node to the first, and the
    /// extremes on the way.
    pub(super) fn towards_first(&self) -> Passed {
        let lefts = self.uncut_left_parts();
        let mut right = self.supports.tailstock;
        let mut cut: Vec<CutNode> =
            self.nodes.iter().map(|n| CutNode { after: n.before, depth: 0.0 }).collect();
        let mut softest = 0.0;
        let mut summary = CutSummary { min_depth_mm: f64::INFINITY, ..CutSummary::default() };
        for (node, uncut) in self.nodes.iter().enumerate().rev() {
            let behind = cut.get(node + 1).map(|n| n.after);
            // The element behind the tool: the diameter of its near end results from the cut at
            // this node.
            let probe = behind.map_or(right, |d| self.extended((right, node), d));
            let compliance = compliance_at_joint(&lefts[node], &probe);
            let depth = self.law.depth_mm(0.5 * (uncut.before - uncut.commanded), compliance);
            let force = self.law.components(depth);
            let mut after = uncut.before - 2.0 * depth;
            if self.tangential_error {
                after += tangential_error_mm(after, uncut.aside + compliance * force.cutting_n);
            }
            cut[node] = CutNode { after, depth };
            include(&mut summary, depth, &force, compliance);
            softest = f64::max(softest, compliance);
            if let Some(behind) = behind {
                right = self.extended((right, node), 0.5 * (behind + after));
            }
            self.rests_at(node).for_each(|rest| right.support(rest));
        }
        // The product of both maxima is an upper bound of the largest product.
        let tangential = softest * self.law.components(summary.max_depth_mm).cutting_n;
        let thinnest = cut.iter().map(|n| n.after).fold(f64::INFINITY, f64::min);
        summary.tangential_error_um = 1e3 * tangential_error_mm(thinnest, tangential);
        Passed { nodes: cut, summary }
    }

    /// The same with the tool travelling from the first node to the last: the mirror image.
    pub(super) fn towards_last(&self) -> Passed {
        let mirrored: Vec<UncutNode> = self.nodes.iter().rev().copied().collect();
        let (grid, length) = (self.grid.mirrored(), self.grid.length_mm());
        let rest = |rest: &SteadyRest| SteadyRest { z_mm: length - rest.z_mm, ..*rest };
        let image = Cut {
            nodes: &mirrored,
            grid: &grid,
            supports: Supports {
                chuck: self.supports.tailstock,
                tailstock: self.supports.chuck,
                steady_rests: self.supports.steady_rests.iter().map(rest).collect(),
            },
            ..*self
        };
        let mut passed = image.towards_first();
        passed.nodes.reverse();
        passed
    }

    /// A part lengthened by the element after `node`.
    fn extended(&self, (mut part, node): (Part, usize), diameter_mm: f64) -> Part {
        part.extend(self.grid.element_mm()[node], &Section::circular(diameter_mm, self.material));
        part
    }

    /// Compliance of the steady rests that belong to a node.
    fn rests_at(&self, node: usize) -> impl Iterator<Item = f64> + '_ {
        let mine = move |rest: &&SteadyRest| self.grid.nearest(rest.z_mm) == node;
        self.supports.steady_rests.iter().filter(mine).map(|rest| rest.compliance_mm_per_n)
    }

    /// The uncut left part up to every node, its own steady rest included.
    fn uncut_left_parts(&self) -> Vec<Part> {
        let mut part = self.supports.chuck;
        let mut parts = Vec::with_capacity(self.nodes.len());
        for (node, at) in self.nodes.iter().enumerate() {
            self.rests_at(node).for_each(|rest| part.support(rest));
            parts.push(part);
            if let Some(next) = self.nodes.get(node + 1) {
                part = self.extended((part, node), 0.5 * (at.before + next.before));
            }
        }
        parts
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
