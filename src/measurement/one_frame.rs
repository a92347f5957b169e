//! One frame by itself.

use super::error::MeasureError;
use super::result::Measurement;
use super::settings::MeasureSettings;
use super::stream::Stream;
use crate::frame::{FrameMeta, FrameView};
use crate::gauge::calibration::Conditions;
use crate::gauge::{Calibration, Gauge};

impl Gauge {
    /// Measures one frame: its largest diameter and its mean diameter in mm, each with u.
    ///
    /// # Errors
    /// A frame without a diameter.
    pub fn measure(
        &self,
        view: &FrameView<'_>,
        calibration: &Calibration,
        conditions: &Conditions,
    ) -> Result<Measurement, MeasureError> {
        self.measure_by(view, calibration, conditions, MeasureSettings::default())
    }

    /// As [`Self::measure`], with what else is asked for: budget, tolerance, stations.
    ///
    /// # Errors
    /// A frame without a diameter; settings out of range.
    pub fn measure_by(
        &self,
        view: &FrameView<'_>,
        calibration: &Calibration,
        conditions: &Conditions,
        settings: MeasureSettings,
    ) -> Result<Measurement, MeasureError> {
        let mut stream = Stream::new(self, calibration, conditions, settings)?;
        stream.push(&FrameMeta::default(), view).cloned()
    }
}
