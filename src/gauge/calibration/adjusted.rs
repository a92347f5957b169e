//! Results of the adjustment: parameters, their covariance by source, residuals.

use serde::{Deserialize, Serialize};

use super::imaging_model::{LensModel, PARAMETERS};

/// A solved adjustment.
#[derive(Clone, Debug)]
pub(crate) struct Adjusted {
    /// s, o, a, q, g, t.
    pub parameters: [f64; PARAMETERS],
    /// The lens part of them.
    pub lens: LensModel,
    /// Covariance by source.
    pub parts: Vec<CovariancePart>,
    /// Residuals.
    pub residuals: Vec<Residual>,
    /// √(χ²/ν), by which the edges' uncertainties were multiplied where above 1.
    pub birge_ratio: f64,
}

/// A source's share of the parameters' covariance, in the order s, o, a, q, g, t (mm/px, mm, 1, 1,
/// 1, 1/mm).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CovariancePart {
    /// The source.
    pub source: String,
    /// The share.
    pub matrix: [[f64; PARAMETERS]; PARAMETERS],
}

impl CovariancePart {
    /// Variance that this source gives to a quantity with these derivatives by the parameters.
    pub(crate) fn variance(&self, by: &[f64; PARAMETERS]) -> f64 {
        let row = |i: usize| (0..PARAMETERS).map(|j| self.matrix[i][j] * by[j]).sum::<f64>();
        (0..PARAMETERS).map(|i| by[i] * row(i)).sum::<f64>().max(0.0)
    }
}

/// Residual of an observation after the fit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Residual {
    /// Index of the master.
    pub master: usize,
    /// Index of the frame over all masters.
    pub frame: usize,
    /// Middle of the block of columns, px from the frame's centre.
    pub column_px: f64,
    /// Middle of the shadow, rows from the frame's centre.
    pub middle_px: f64,
    /// Axis from the masters' plane, mm.
    pub axis_y_mm: f64,
    /// Calibrated minus certified diameter, mm.
    pub residual_mm: f64,
    /// Its standard uncertainty by the edges, mm.
    pub u_mm: f64,
}
