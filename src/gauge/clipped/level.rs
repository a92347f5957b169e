//! A level along the shaft as the censored fit varies it: a known curve with an offset, or knots of its own.

/// A level: `base` plus hats on equidistant knots (a constant where there is one).
#[derive(Clone, Debug)]
pub(super) struct Level {
    base: Vec<f32>,
    /// Values at the knots, counts.
    pub(super) knots: Vec<f64>,
    /// Standard uncertainty of a known curve's offset, counts; none where the level is free.
    pub(super) prior: Option<f64>,
}

impl Level {
    /// A curve that is known but for a common offset of standard uncertainty `u`, counts.
    pub(super) fn known(curve: &[f32], u: f64) -> Self {
        Self { base: curve.to_vec(), knots: vec![0.0], prior: Some(u.max(1e-9)) }
    }

    /// Knots that the fit is to find, from a curve to start with.
    pub(super) fn free(curve: &[f32], knots: usize) -> Self {
        let last = curve.len() - 1;
        let at = |k: usize| f64::from(curve[(k * last) / (knots - 1).max(1)]);
        Self { base: vec![0.0; curve.len()], knots: (0..knots).map(at).collect(), prior: None }
    }

    /// The two knots around a column and the weight of the second.
    pub(super) fn around(&self, column: usize) -> (usize, usize, f64) {
        let spaces = self.knots.len() - 1;
        if spaces == 0 {
            return (0, 0, 0.0);
        }
        let at = column as f64 * spaces as f64 / (self.base.len() - 1).max(1) as f64;
        let left = (at as usize).min(spaces - 1);
        (left, left + 1, at - left as f64)
    }

    /// Level of a column, counts.
    pub(super) fn at(&self, column: usize) -> f64 {
        let (left, right, t) = self.around(column);
        f64::from(self.base[column]) + (1.0 - t) * self.knots[left] + t * self.knots[right]
    }

    /// The same level with more knots.
    pub(super) fn with_knots(&self, knots: usize) -> Self {
        let curve: Vec<f32> = (0..self.base.len()).map(|c| self.at(c) as f32).collect();
        Self::free(&curve, knots)
    }
}
