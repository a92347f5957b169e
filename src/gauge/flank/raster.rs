//! Grey values of an image or a rectified strip, and the Gaussians over them.

use rayon::prelude::*;

use super::error::FlankError;
use crate::frame::FrameView;
use crate::numerics::gaussian::blurred;

/// Grey values, row after row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Raster {
    /// Rows.
    pub rows: usize,
    /// Columns.
    pub columns: usize,
    /// Values, `rows * columns`.
    pub values: Vec<f32>,
}

impl Raster {
    /// Of one value.
    pub(crate) fn new(rows: usize, columns: usize) -> Self {
        Self { rows, columns, values: vec![0.0; rows * columns] }
    }

    /// Of a frame's pixels.
    ///
    /// # Errors
    /// A pixel that is not a number.
    pub(crate) fn of(view: &FrameView<'_>) -> Result<Self, FlankError> {
        let (rows, columns) = (view.rows(), view.columns());
        let value = |k: usize| view.get(k / columns, k % columns).unwrap_or(f32::NAN);
        let values: Vec<f32> = (0..rows * columns).into_par_iter().map(value).collect();
        match values.iter().position(|v| !v.is_finite()) {
            Some(k) => Err(FlankError::NotFinite { row: k / columns, column: k % columns }),
            None => Ok(Self { rows, columns, values }),
        }
    }

    /// The value of a pixel.
    pub(crate) fn at(&self, row: usize, column: usize) -> f32 {
        self.values[row * self.columns + column]
    }

    /// A row.
    pub(crate) fn row(&self, row: usize) -> &[f32] {
        &self.values[row * self.columns..(row + 1) * self.columns]
    }

    /// Linear between pixels; `None` outside of their centres.
    pub(crate) fn between(&self, row: f64, column: f64) -> Option<f32> {
        let (last_row, last_column) = ((self.rows - 1) as f64, (self.columns - 1) as f64);
        if !((0.0..=last_row).contains(&row) && (0.0..=last_column).contains(&column)) {
            return None;
        }
        let (i, j) = ((row as usize).min(self.rows - 2), (column as usize).min(self.columns - 2));
        let (t, u) = ((row - i as f64) as f32, (column - j as f64) as f32);
        let upper = (1.0 - u) * self.at(i, j) + u * self.at(i, j + 1);
        let lower = (1.0 - u) * self.at(i + 1, j) + u * self.at(i + 1, j + 1);
        Some((1.0 - t) * upper + t * lower)
    }

    /// Every value through a function.
    pub(crate) fn map(&self, f: impl Fn(f32) -> f32 + Sync) -> Self {
        Self { values: self.values.par_iter().map(|v| f(*v)).collect(), ..*self }
    }

    /// A Gaussian of standard deviations along columns (rows down) and along rows, px; the border's
    /// values go on outside.
    pub(crate) fn blurred(&self, sigma_down: f64, sigma_along: f64) -> Self {
        let values = blurred(&self.values, (self.rows, self.columns), (sigma_down, sigma_along));
        Self { values, ..*self }
    }

    /// A quantile of every `step`-th value.
    pub(crate) fn quantile(&self, share: f64, step: usize) -> f32 {
        quantile(self.values.iter().copied().step_by(step.max(1)).collect(), share)
    }
}

/// The value below which a share of values lies; 0 of none.
pub(crate) fn quantile(mut values: Vec<f32>, share: f64) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let k = ((values.len() - 1) as f64 * share.clamp(0.0, 1.0)).round() as usize;
    *values.select_nth_unstable_by(k, f32::total_cmp).1
}
