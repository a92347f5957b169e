//! Edges out of focus, column by column: tables over a range of defocus, blended between
//! neighbours.
//!
//! On a bent shaft or with a wobbling axis the edge is out of focus by y(z, φ). The image of a thin
//! screen depends on |y| only, that of a thick body on y ([`FocusStack::between`]); between tables
//! F is linear in it, and their number is increased until the error of the blend is within the
//! tolerance in the middle of every interval.

use rayon::prelude::*;

#[cfg(test)]
use super::partial::PartiallyCoherentEdge;
use super::table::EdgeSpread;
use crate::render::error::{RenderError, within};

/// Most tables of a stack.
const MOST_TABLES: usize = 257;

/// Number of distances at which the blend is checked, over the table's reach.
const PROBES: usize = 801;

const KEY: &str = "optics.esf.partially_coherent.depth_mm";

/// Tables at equal steps of defocus, from 0 or the smallest to the largest.
#[derive(Clone, Debug)]
pub(crate) struct FocusStack {
    step_mm: f64,
    tables: Vec<EdgeSpread>,
    #[cfg_attr(not(test), allow(dead_code, reason = "read by tests"))]
    blend_error: f64,
}

impl FocusStack {
    /// Tables of `edge` (whose own defocus is ignored) for up to `largest_mm` to either side of the
    /// plane of focus.
    ///
    /// # Errors
    /// Refuses values outside their ranges, and a tolerance that would need more than 257 tables.
    #[cfg(test)]
    pub(crate) fn new(
        edge: &PartiallyCoherentEdge,
        largest_mm: f64,
        tolerance: f64,
    ) -> Result<Self, RenderError> {
        Self::of(largest_mm, tolerance, |defocus_mm| {
            PartiallyCoherentEdge { defocus_mm, ..edge.clone() }.edge_spread()
        })
    }

    /// Tables of any family that depends on the magnitude of the distance from the plane of focus
    /// alone.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(crate) fn of(
        largest_mm: f64,
        tolerance: f64,
        table: impl Fn(f64) -> Result<EdgeSpread, RenderError> + Sync,
    ) -> Result<Self, RenderError> {
        within(KEY, largest_mm, 1e-6, 1e3)?;
        Self::between((0.0, largest_mm), tolerance, table)
    }

    /// Tables of a family between two signed distances from the plane of focus.
    ///
    /// # Errors
    /// A tolerance that would need more than 257 tables, and what `table` refuses.
    pub(crate) fn between(
        (from_mm, to_mm): (f64, f64),
        tolerance: f64,
        table: impl Fn(f64) -> Result<EdgeSpread, RenderError> + Sync,
    ) -> Result<Self, RenderError> {
        let mut tables = vec![table(from_mm)?, table(to_mm)?];
        loop {
            let intervals = tables.len() - 1;
            let step_mm = (to_mm - from_mm) / intervals as f64;
            let middles = (0..intervals)
                .into_par_iter()
                .map(|i| table(from_mm + (i as f64 + 0.5) * step_mm))
                .collect::<Result<Vec<_>, _>>()?;
            let error = |i: usize| blend_error(&tables[i], &middles[i], &tables[i + 1]);
            let blend_error = (0..intervals).map(error).fold(0.0, f64::max);
            if blend_error <= tolerance {
                return Ok(Self { step_mm, tables, blend_error });
            }
            if 2 * intervals + 1 > MOST_TABLES {
                let right = format!("{MOST_TABLES} tables still err by {blend_error:.1e}: lower the depth");
                return Err(RenderError::setting(KEY, &to_mm, right));
            }
            tables = interleave(tables, middles);
        }
    }

    /// The tables, the smallest distance (in focus) first.
    pub(crate) fn tables(&self) -> &[EdgeSpread] {
        &self.tables
    }

    /// Difference of focus between two tables, mm.
    pub(crate) fn step_mm(&self) -> f64 {
        self.step_mm
    }

    /// Largest error of the blend, share of full intensity.
    #[cfg(test)]
    pub(crate) fn blend_error(&self) -> f64 {
        self.blend_error
    }

    /// Table and share of the next one for an edge `defocus_mm` out of focus; the last table beyond
    /// the largest.
    #[cfg(test)]
    pub(crate) fn place(&self, defocus_mm: f64) -> (usize, f64) {
        let last = self.tables.len() - 2;
        let at = (defocus_mm.abs() / self.step_mm).min((last + 1) as f64);
        let i = (at as usize).min(last);
        (i, at - i as f64)
    }

    /// F at `d_um` into the light of an edge `defocus_mm` out of focus.
    #[cfg(test)]
    pub(crate) fn value(&self, d_um: f64, defocus_mm: f64) -> f64 {
        let (i, share) = self.place(defocus_mm);
        (1.0 - share) * self.tables[i].value(d_um) + share * self.tables[i + 1].value(d_um)
    }
}

fn blend_error(a: &EdgeSpread, middle: &EdgeSpread, b: &EdgeSpread) -> f64 {
    let (low, high) = middle.range_um();
    (0..PROBES)
        // Denser towards the edge, where focus matters.
        .map(|i| 2.0 * i as f64 / (PROBES - 1) as f64 - 1.0)
        .map(|t| t * t.abs() * if t < 0.0 { -low } else { high })
        .map(|d| (0.5 * (a.value(d) + b.value(d)) - middle.value(d)).abs())
        .fold(0.0, f64::max)
}

fn interleave(tables: Vec<EdgeSpread>, middles: Vec<EdgeSpread>) -> Vec<EdgeSpread> {
    let mut middles = middles.into_iter();
    tables.into_iter().flat_map(|t| [Some(t), middles.next()]).flatten().collect()
}
