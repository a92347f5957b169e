//! The straight line through points by least squares, about their means, so that no digits are lost
//! where the abscissae are far from 0.

/// y = mean_y + slope·(x − mean_x), with the sums that it comes from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    /// Mean abscissa.
    pub(crate) mean_x: f64,
    /// Mean ordinate.
    pub(crate) mean_y: f64,
    /// Σ(x − x̄)²: 0 where all x are equal.
    pub(crate) square: f64,
    /// Σ(x − x̄)(y − ȳ).
    cross: f64,
}

impl Line {
    /// The line through points; NaN without points.
    pub(crate) fn through(points: impl Iterator<Item = (f64, f64)> + Clone) -> Self {
        let n = points.clone().count() as f64;
        let mean_x = points.clone().map(|p| p.0).sum::<f64>() / n;
        let mean_y = points.clone().map(|p| p.1).sum::<f64>() / n;
        let square = points.clone().map(|p| (p.0 - mean_x).powi(2)).sum();
        let cross = points.map(|p| (p.0 - mean_x) * (p.1 - mean_y)).sum();
        Self { mean_x, mean_y, square, cross }
    }

    /// dy/dx.
    pub(crate) fn slope(&self) -> f64 {
        self.cross / self.square
    }

    /// Ordinate at an abscissa.
    pub(crate) fn at(&self, x: f64) -> f64 {
        self.mean_y + self.slope() * (x - self.mean_x)
    }
}
