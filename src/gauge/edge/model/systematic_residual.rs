//! The mean residual that the edge model leaves at the masters' edges, as a calibration file keeps
//! it.

use serde::{Deserialize, Serialize};

use crate::gauge::limit::limits;

limits! {
    /// What a calibration file may hold of a residual.
    SystematicResidualLimits = "systematic_residual";
    /// Most values of a side in a file: ± 128 px, half the longest window, in steps of 1/8 px.
    most_values: usize = 2049;
}

/// The mean residual that the masters' edges leave, over the distance from the edge.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SystematicResidual {
    /// Distance of neighbouring values, px.
    pub step_px: f64,
    /// Residual at the upper and lower edge as shares of the contrast, from shadow to light; the
    /// middle value stands at the edge. An odd number each.
    pub residual: [Vec<f64>; 2],
    /// χ² of these edges over its expectation.
    pub chi2: f64,
}

impl SystematicResidual {
    /// Names what cannot be, if anything: (key, value, what would be right).
    pub(crate) fn impossible(&self) -> Option<(&'static str, f64, &'static str)> {
        if !(self.step_px > 0.0 && self.step_px <= 1.0) {
            return Some(("misfit.step_px", self.step_px, "above 0, at most 1 px"));
        }
        if !(self.chi2 >= 0.0 && self.chi2.is_finite()) {
            return Some(("misfit.chi2", self.chi2, "a finite number of 0 or more"));
        }
        for side in &self.residual {
            if side.len() % 2 == 0 || side.len() > SystematicResidualLimits::get().most_values {
                return Some(("misfit.residual", side.len() as f64, "an odd number of values, at most 2049"));
            }
            if let Some(value) = side.iter().find(|v| !(v.abs() <= 1.0)) {
                return Some(("misfit.residual", *value, "shares of the contrast, -1 to 1"));
            }
        }
        None
    }

    /// Root sum square of a side's residual over the pixels of an edge, as a share of the contrast.
    pub(crate) fn norm(&self, side: usize) -> f64 {
        self.residual[side].iter().map(|r| r * r * self.step_px).sum::<f64>().sqrt()
    }
}
