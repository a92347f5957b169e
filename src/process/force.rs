//! Radial cutting force against what is really cut.

use super::settings::{ForceLaw, PowerLaw};
use crate::plan::CuttingData;

/// The force law at fixed feed and speed: a function of the depth alone, F = K·a^x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthLaw {
    /// K, N at a depth of 1 mm.
    pub at_one_mm_n: f64,
    /// x.
    pub exponent: f64,
}

impl DepthLaw {
    /// Force in N at a depth in mm; none without contact.
    pub fn force_n(&self, depth_mm: f64) -> f64 {
        if depth_mm > 0.0 { self.at_one_mm_n * depth_mm.powf(self.exponent) } else { 0.0 }
    }

    /// dF/da in N/mm at a depth above zero.
    pub fn slope_n_per_mm(&self, depth_mm: f64) -> f64 {
        self.exponent * self.force_n(depth_mm) / depth_mm
    }

    /// The depth really cut, mm, where the tool is set `set_mm` deep and the shaft yields `compliance_mm_per_n`:
    /// the root of a + w·F(a) = a₀. Newton's method kept inside its bracket, to 1e-13 mm or a double's end.
    pub fn depth_mm(&self, set_mm: f64, compliance_mm_per_n: f64) -> f64 {
        if set_mm <= 0.0 {
            return 0.0;
        }
        let (mut low, mut high, mut depth) = (0.0, set_mm, set_mm);
        for _ in 0..100 {
            let excess = depth - set_mm + compliance_mm_per_n * self.force_n(depth);
            (low, high) = if excess > 0.0 { (low, depth) } else { (depth, high) };
            let step = excess / (1.0 + compliance_mm_per_n * self.slope_n_per_mm(depth));
            let next = depth - step;
            let inside = next > low && next < high;
            let next = if inside { next } else { 0.5 * (low + high) };
            if (next - depth).abs() <= 1e-13 * (1.0 + depth) {
                return next;
            }
            depth = next;
        }
        depth
    }
}

impl PowerLaw {
    /// Radial force, N, at a depth in mm.
    pub fn force_n(&self, depth_mm: f64, cutting: &CuttingData) -> f64 {
        self.at(cutting).force_n(depth_mm)
    }

    /// The law at the cutting data given.
    pub fn at(&self, cutting: &CuttingData) -> DepthLaw {
        let factor = cutting.feed_mm_per_rev.powf(self.feed_exponent)
            * cutting.speed_m_per_min.powf(self.speed_exponent);
        DepthLaw { at_one_mm_n: self.coefficient_n * factor, exponent: self.depth_exponent }
    }
}

impl ForceLaw {
    /// The law at the cutting data given.
    pub fn at(&self, cutting: &CuttingData) -> DepthLaw {
        match self {
            Self::Power(law) => law.at(cutting),
        }
    }
}
