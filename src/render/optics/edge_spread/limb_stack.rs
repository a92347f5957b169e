//! Limbs of cylinders of several radii, in and out of focus: tables over R^(1/3) and the signed
//! distance of the axis.
//!
//! The image of a limb follows R^(1/3). Between radii whose ratio is at most 1.25 a linear blend in
//! it errs by less than 1e-4 of full light. Where all axes lie at one distance from the plane of
//! focus, the kernel blends over the radius itself; where they do not, it blends over the distance,
//! and every radius takes the nearest of closely spaced ones, which are blends of the computed
//! tables.

use rayon::prelude::*;

use super::cylinder::CylinderEdge;
use super::focus_stack::FocusStack;
use super::table::EdgeSpread;
use crate::render::error::RenderError;

/// Largest ratio of the radii of two computed tables.
const NODE_RATIO: f64 = 1.25;

/// Largest ratio of radii that share a table where the distance is blended. The edge moves by .25
/// µm per ln R (NA .02, S .5), so that half a step moves it by .0025 µm.
const SHARED_RATIO: f64 = 1.02;

/// Tables of one cylinder family.
#[derive(Clone, Debug)]
pub(crate) struct LimbStack {
    /// Of every distance in turn, radius by radius.
    pub tables: Vec<EdgeSpread>,
    pub layout: LimbLayout,
}

/// What the tables stand for, and what lies between two of them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum LimbLayout {
    /// Equal steps of R^(1/3) (mm^(1/3)), linear between two; a single table has the step 0.
    Radii { first: f64, step: f64 },
    /// Equal steps of the axis' distance, linear between two, for every one of these radii (mm,
    /// ascending).
    Distances { first_mm: f64, step_mm: f64, per_radius: u32, radii_mm: Vec<f64> },
}

impl LimbStack {
    /// Tables for radii between two and axes up to `depth_mm` nearer and farther than the family's
    /// own defocus.
    ///
    /// # Errors
    /// As [`CylinderEdge::edge_spread`] and [`FocusStack::between`].
    pub(crate) fn new(
        edge: &CylinderEdge,
        (least_mm, most_mm): (f64, f64),
        depth_mm: f64,
        tolerance: f64,
    ) -> Result<Self, RenderError> {
        // Both ends are refused by name before anything is computed.
        edge.edge_spread(least_mm, 0.0)?;
        edge.edge_spread(most_mm, 0.0)?;
        let nodes = Nodes::between(least_mm, most_mm);
        if depth_mm == 0.0 {
            let tables = (0..nodes.count)
                .into_par_iter()
                .map(|i| edge.edge_spread(nodes.radius_mm(i), 0.0))
                .collect::<Result<_, _>>()?;
            return Ok(Self { tables, layout: LimbLayout::Radii { first: nodes.first, step: nodes.step } });
        }
        // The finer of the steps that the thinnest and the thickest need.
        let along = |radius_mm: f64| {
            FocusStack::between((-depth_mm, depth_mm), tolerance, |y| edge.edge_spread(radius_mm, y))
        };
        let (thin, thick) = (along(least_mm)?, along(most_mm)?);
        let per_radius = thin.tables().len().max(thick.tables().len());
        let step_mm = 2.0 * depth_mm / (per_radius - 1) as f64;
        let computed = (0..nodes.count * per_radius)
            .into_par_iter()
            .map(|i| {
                let y_mm = (i % per_radius) as f64 * step_mm - depth_mm;
                edge.edge_spread(nodes.radius_mm(i / per_radius), y_mm)
            })
            .collect::<Result<Vec<_>, _>>()?;
        let radii_mm = shared_radii(least_mm, most_mm);
        let tables = radii_mm
            .iter()
            .flat_map(|radius_mm| {
                let (node, share) = nodes.place(*radius_mm);
                let next = (node + 1).min(nodes.count - 1);
                let at = move |node: usize, i: usize| node * per_radius + i;
                let computed = &computed;
                (0..per_radius).map(move |i| computed[at(node, i)].blended(&computed[at(next, i)], share))
            })
            .collect();
        let layout =
            LimbLayout::Distances { first_mm: -depth_mm, step_mm, per_radius: per_radius as u32, radii_mm };
        Ok(Self { tables, layout })
    }
}

/// Radii of computed tables, even in R^(1/3).
struct Nodes {
    first: f64,
    step: f64,
    count: usize,
}

impl Nodes {
    fn between(least_mm: f64, most_mm: f64) -> Self {
        let (first, last) = (least_mm.cbrt(), most_mm.cbrt());
        // The smallest pair has the largest ratio.
        let steps = ((last / first - 1.0) / (NODE_RATIO.cbrt() - 1.0)).ceil().max(0.0);
        let step = if steps == 0.0 { 0.0 } else { (last - first) / steps };
        Self { first, step, count: steps as usize + 1 }
    }

    fn radius_mm(&self, node: usize) -> f64 {
        (self.first + node as f64 * self.step).powi(3)
    }

    /// The node below a radius, and the share of the next one.
    fn place(&self, radius_mm: f64) -> (usize, f64) {
        if self.count == 1 {
            return (0, 0.0);
        }
        let last = (self.count - 2) as f64;
        let at = ((radius_mm.cbrt() - self.first) / self.step).clamp(0.0, last + 1.0);
        let below = at.floor().min(last);
        (below as usize, at - below)
    }
}

fn shared_radii(least_mm: f64, most_mm: f64) -> Vec<f64> {
    let steps = ((most_mm / least_mm).ln() / SHARED_RATIO.ln()).ceil().max(0.0);
    let radius = |i: usize| least_mm * (most_mm / least_mm).powf(i as f64 / steps.max(1.0));
    (0..=steps as usize).map(radius).collect()
}
