//! Rings and discs seen end-on.

use serde::{Serialize, Serializer};

use super::error::MeasureError;
use crate::frame::FrameView;
use crate::gauge::Calibration;
use crate::gauge::calibration::Conditions;
use crate::gauge::ring::{RingMeasurement, RingSettings, measure_ring};

/// A ring with the name of its frame, or why there is none. Its JSON is an element of `frames` of
/// `shadowgauge measure --shape ring --json`: the flat keys of [`RingMeasurement::to_json`], or an
/// `error`.
#[derive(Debug)]
pub struct NamedRing {
    /// Name of the frame: a file's without its ending.
    pub frame: String,
    /// The ring.
    pub ring: Result<RingMeasurement, MeasureError>,
}

impl NamedRing {
    /// Measures a frame; with a calibration also in mm.
    pub fn measure(
        frame: String,
        view: &FrameView<'_>,
        settings: &RingSettings,
        calibration: Option<(&Calibration, &Conditions)>,
    ) -> Self {
        let ring = measure(view, settings, calibration);
        Self { frame, ring }
    }
}

impl Serialize for NamedRing {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut row = match &self.ring {
            Ok(ring) => ring.to_json(),
            Err(error) => serde_json::json!({ "error": error.to_string() }),
        };
        row["frame"] = self.frame.as_str().into();
        row.serialize(serializer)
    }
}

/// Measures a ring or disc; with a calibration and the conditions of the part also in mm.
///
/// # Errors
/// A frame without a ring; a calibration that holds for none.
pub fn measure(
    view: &FrameView<'_>,
    settings: &RingSettings,
    calibration: Option<(&Calibration, &Conditions)>,
) -> Result<RingMeasurement, MeasureError> {
    let mut ring = measure_ring(view, settings)?;
    if let Some((calibration, conditions)) = calibration {
        ring.calibrate(calibration, conditions, settings.roundness_cutoff_upr)?;
    }
    Ok(ring)
}
