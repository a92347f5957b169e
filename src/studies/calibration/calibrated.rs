//! A finished calibration, with its example budget.

use crate::gauge::Calibration;
use crate::gauge::budget::{Budget, WidthReading};
use crate::gauge::calibration::Adjustment;

/// A finished calibration.
#[derive(Clone, Debug)]
pub(crate) struct Calibrated {
    /// The calibration; its check decides whether it may be used.
    pub calibration: Calibration,
    /// The adjustment behind it, for propagation of distributions.
    pub adjustment: Adjustment,
    /// One of the masters' mean shadows.
    pub reading: Option<WidthReading>,
    /// Its budget, for reports.
    pub example: Option<Budget>,
    /// Frames left out because no edge-spread function could be estimated from them, where that was
    /// requested.
    pub unlearnt_frames: usize,
}
