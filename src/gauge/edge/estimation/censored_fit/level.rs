//! A level along the shaft as the censored fit varies it: a known curve with an offset, or knots of
//! its own.

/// A level: `base` plus hats on equidistant knots (a constant where there is one).
#[derive(Clone, Debug)]
pub(crate) struct Level {
    base: Vec<f32>,
    /// First and last column between which the knots lie; constant beyond.
    range: (usize, usize),
    /// Values at the knots, counts.
    pub(crate) knots: Vec<f64>,
    /// Standard uncertainty of a known curve's offset, counts; none where the level is free.
    pub(crate) prior: Option<f64>,
}

impl Level {
    /// A curve that is known but for a common offset of standard uncertainty `u`, counts.
    pub(crate) fn known(curve: &[f32], u: f64) -> Self {
        let range = (0, curve.len() - 1);
        Self { base: curve.to_vec(), range, knots: vec![0.0], prior: Some(u.max(1e-9)) }
    }

    /// Knots between two columns that the fit is to find, from a curve to start with.
    pub(crate) fn free(curve: &[f32], range: (usize, usize), knots: usize) -> Self {
        let at = |k: usize| f64::from(curve[range.0 + k * (range.1 - range.0) / (knots - 1).max(1)]);
        Self { base: vec![0.0; curve.len()], range, knots: (0..knots).map(at).collect(), prior: None }
    }

    /// The same level held at a value.
    pub(crate) fn held(&self, value: f64) -> Self {
        Self::known(&vec![value as f32; self.base.len()], 1e-6)
    }

    /// The two knots around a column and the weight of the second.
    pub(crate) fn around(&self, column: usize) -> (usize, usize, f64) {
        let spaces = self.knots.len() - 1;
        if spaces == 0 {
            return (0, 0, 0.0);
        }
        let (first, last) = self.range;
        let along = column.clamp(first, last) - first;
        let at = (along * spaces) as f64 / (last - first).max(1) as f64;
        let left = (at as usize).min(spaces - 1);
        (left, left + 1, at - left as f64)
    }

    /// Level of a column, counts.
    pub(crate) fn at(&self, column: usize) -> f64 {
        let (left, right, t) = self.around(column);
        f64::from(self.base[column]) + (1.0 - t) * self.knots[left] + t * self.knots[right]
    }

    /// The same level with more knots.
    pub(super) fn with_knots(&self, knots: usize) -> Self {
        let curve: Vec<f32> = (0..self.base.len()).map(|c| self.at(c) as f32).collect();
        Self::free(&curve, self.range, knots)
    }
}
