//! The line of paper 000: ε = b·x + a by least squares (eqs 4-6), x the share of the length.

use crate::numerics::line::Line;

/// A fitted line.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub(crate) struct LineFit {
    /// Slope b (eq. 5), in the unit of ε.
    pub b: f64,
    /// Intercept a (eq. 6), in the unit of ε.
    pub a: f64,
    /// Largest |ε − b·x − a|.
    pub largest_residual: f64,
}

/// b = Σ(x − x̄)(ε − ε̄)/Σ(x − x̄)², a = ε̄ − b·x̄; `None` for fewer than two different x or
/// lengths that differ.
pub(crate) fn fit_line(x: &[f64], error: &[f64]) -> Option<LineFit> {
    if x.len() != error.len() || x.len() < 2 {
        return None;
    }
    let line = Line::through(x.iter().copied().zip(error.iter().copied()));
    if line.square == 0.0 || !line.square.is_finite() {
        return None;
    }
    let b = line.slope();
    let a = line.mean_y - b * line.mean_x;
    let off = x.iter().zip(error).map(|(x, e)| (e - b * x - a).abs());
    Some(LineFit { b, a, largest_residual: off.fold(0.0, f64::max) })
}
