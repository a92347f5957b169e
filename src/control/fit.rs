//! Linear least squares, weighted and robust, with covariance.
//!
//! Minimises Σ w_i ((y_i − Σ_j X_ij c_j)/u_i)², w_i = 1 or Huber's weight, by a singular value
//! decomposition of the weighted design. Covariance (Xᵀ W X)⁻¹ from the stated u (not rescaled by
//! the residuals). Valid for columns of full rank and positive u. Huber: P. J. Huber, Robust
//! Statistics, ch. 7, with the tuning constant 1.345 (95 % efficiency for normal errors) and the
//! scale from the median absolute residual.

use crate::numerics::robust::{MAD_TO_SIGMA, central_median};
use nalgebra::{DMatrix, DVector};

/// Huber's tuning constant in units of the scale.
pub(crate) const HUBER_K: f64 = 1.345;
/// Rounds of reweighting; each shrinks the change by more than half.
const HUBER_ROUNDS: usize = 50;
/// Reweighting ends when no coefficient moves by more than this share of its standard uncertainty.
const HUBER_CONVERGED: f64 = 1e-9;
/// Singular values below this share of the largest count as zero.
const RANK_TOLERANCE: f64 = 1e-12;

/// A fitted linear model.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Fit {
    /// Coefficients, one per column of the design.
    pub coefficients: DVector<f64>,
    /// Their covariance, from the stated uncertainties.
    pub covariance: DMatrix<f64>,
    /// y minus the fit.
    pub residuals: DVector<f64>,
    /// Weight of every observation, 0-1 (1 where not reweighted).
    pub weights: DVector<f64>,
    /// Σ (residual/u)².
    pub chi_squared: f64,
    /// Observations minus coefficients.
    pub degrees_of_freedom: usize,
}

/// Weighted least squares; `None` where the columns are not independent or there are too few rows.
pub(crate) fn weighted(design: &DMatrix<f64>, y: &DVector<f64>, u: &DVector<f64>) -> Option<Fit> {
    solve(design, y, u, &DVector::from_element(y.len(), 1.0))
}

/// Huber's robust fit; `None` as for [`weighted`].
pub(crate) fn huber(design: &DMatrix<f64>, y: &DVector<f64>, u: &DVector<f64>) -> Option<Fit> {
    let mut fit = weighted(design, y, u)?;
    for _ in 0..HUBER_ROUNDS {
        let weights = huber_weights(&fit.residuals.component_div(u));
        let next = solve(design, y, u, &weights)?;
        let sigma = next.covariance.diagonal().map(f64::sqrt);
        let moved = (&next.coefficients - &fit.coefficients).component_div(&sigma).amax();
        fit = next;
        if moved < HUBER_CONVERGED {
            break;
        }
    }
    Some(fit)
}

/// min(1, k·s/|t|) of the standardised residuals t, s their robust scale but at least 1 (the stated
/// u).
fn huber_weights(standardised: &DVector<f64>) -> DVector<f64> {
    let mut magnitude: Vec<f64> = standardised.iter().map(|t| t.abs()).collect();
    let scale = (MAD_TO_SIGMA * central_median(&mut magnitude).unwrap_or(0.0)).max(1.0);
    standardised.map(|t| (HUBER_K * scale / t.abs()).min(1.0))
}

fn solve(design: &DMatrix<f64>, y: &DVector<f64>, u: &DVector<f64>, weights: &DVector<f64>) -> Option<Fit> {
    let (rows, columns) = design.shape();
    if rows < columns || columns == 0 {
        return None;
    }
    let root = weights.zip_map(u, |w, u| w.sqrt() / u);
    let scaled = DMatrix::from_fn(rows, columns, |i, j| design[(i, j)] * root[i]);
    let svd = scaled.svd(true, true);
    let largest = svd.singular_values.max();
    if !(largest > 0.0 && svd.singular_values.min() > RANK_TOLERANCE * largest) {
        return None;
    }
    let coefficients = svd.solve(&y.component_mul(&root), 0.0).ok()?;
    let v_over_s =
        svd.v_t.as_ref()?.transpose() * DMatrix::from_diagonal(&svd.singular_values.map(f64::recip));
    let residuals = y - design * &coefficients;
    Some(Fit {
        chi_squared: residuals.component_div(u).norm_squared(),
        covariance: &v_over_s * v_over_s.transpose(),
        coefficients,
        residuals,
        weights: weights.clone(),
        degrees_of_freedom: rows - columns,
    })
}
