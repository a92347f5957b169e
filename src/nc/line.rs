//! The line of paper 000: ε = b·x + a by least squares (eqs 4-6), x the share of the length.

/// A fitted line.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct LineFit {
    /// Slope b (eq. 5), in the unit of ε.
    pub b: f64,
    /// Intercept a (eq. 6), in the unit of ε.
    pub a: f64,
    /// Largest |ε − b·x − a|.
    pub largest_residual: f64,
}

/// b = Σ(x − x̄)(ε − ε̄)/Σ(x − x̄)², a = ε̄ − b·x̄; `None` for fewer than two different x or lengths that differ.
pub fn fit_line(x: &[f64], error: &[f64]) -> Option<LineFit> {
    if x.len() != error.len() || x.len() < 2 {
        return None;
    }
    let n = x.len() as f64;
    let (mean_x, mean_e) = (x.iter().sum::<f64>() / n, error.iter().sum::<f64>() / n);
    let spread: f64 = x.iter().map(|x| (x - mean_x).powi(2)).sum();
    if spread == 0.0 || !spread.is_finite() {
        return None;
    }
    let b = x.iter().zip(error).map(|(x, e)| (x - mean_x) * (e - mean_e)).sum::<f64>() / spread;
    let a = mean_e - b * mean_x;
    let off = x.iter().zip(error).map(|(x, e)| (e - b * x - a).abs());
    Some(LineFit { b, a, largest_residual: off.fold(0.0, f64::max) })
}
