//! How long a measurement of a nose takes.

use crate::numerics::robust::central_median;

/// Times of measurements of images in memory.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub(super) struct Bench {
    /// Measurements.
    pub(super) measurements: usize,
    /// The fastest, ms.
    pub(super) ms_per_image_min: f64,
    /// Their median, ms.
    pub(super) ms_per_image_median: f64,
}

impl Bench {
    /// Of times in ms; none of none.
    pub(super) fn of(mut times: Vec<f64>) -> Option<Self> {
        let ms_per_image_median = central_median(&mut times)?;
        Some(Self { measurements: times.len(), ms_per_image_min: *times.first()?, ms_per_image_median })
    }
}
