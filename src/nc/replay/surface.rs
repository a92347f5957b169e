//! The surface that a probe touches.

use crate::numerics::neighbours::{linear_between, neighbours};

/// The surface that the probe touches: diameters over Z, linear between points, constant beyond.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Surface {
    /// (Z, mm) before the first feed of the program, Z ascending.
    pub before: Vec<(f64, f64)>,
    /// (Z, mm) after it.
    pub after: Vec<(f64, f64)>,
    /// Indicated run-out e, mm of diameter: a touch at the spindle angle φ lies e·cos φ further
    /// out.
    pub run_out_mm: f64,
    /// Deviations of successive touches, repeated from the first, mm of diameter; zero where empty.
    pub scatter_mm: Vec<f64>,
}

impl Surface {
    /// Diameter before the cut, mm.
    pub(crate) fn before_at(&self, z_mm: f64) -> f64 {
        at(&self.before, z_mm)
    }

    /// Diameter after the cut, mm.
    pub(crate) fn after_at(&self, z_mm: f64) -> f64 {
        at(&self.after, z_mm)
    }
}

fn at(points: &[(f64, f64)], z: f64) -> f64 {
    linear_between(neighbours(points, |p| p.0 < z), z, |p| *p).unwrap_or(f64::NEG_INFINITY)
}
