//! The smallest and the largest diameter that a head can have in its field.
//!
//! Each edge needs the pixels of its window either side of it, within the frame or within its own
//! window of rows; a part that turns off its axis by e moves by ±e. Between two windows a diameter
//! is also bounded from below.

use serde::Serialize;

use crate::gauge::EdgeRoom;
use crate::job::Job;
use crate::setting::SettingError;

/// Share of the field's height that a part may take at the nominal magnification: the true one may
/// be larger. A run refuses what is larger, too.
const FIELD: f64 = 0.97;

/// Diameters that a head can measure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct DiameterRange {
    /// Smallest shaft by `gauge.min_diameter_px`, or by the windows, mm.
    pub smallest_mm: f64,
    /// Smallest wire where `gauge.min_diameter_px` is lowered, mm; none between two windows.
    pub smallest_wire_mm: Option<f64>,
    /// Largest diameter, mm.
    pub largest_mm: f64,
    /// Largest over smallest.
    pub ratio: f64,
}

impl DiameterRange {
    /// Of a head whose part turns off its axis by `eccentricity_mm`.
    pub(super) fn of(job: &Job, room: &EdgeRoom, eccentricity_mm: f64) -> Self {
        let pixel_mm = job.setup_settings().nominal_pixel_mm();
        // A pixel more, since an edge does not stand in the middle of one.
        let beside = room.beside_px + 1.0;
        let runs = 2.0 * eccentricity_mm;
        let rows = f64::from(job.camera.rows);
        let (smallest_mm, wire, largest_mm) = match job.camera.windows {
            Some(w) => {
                let apart = f64::from(w.lower_row) - f64::from(w.upper_row);
                let free = f64::from(w.rows) - 2.0 * beside;
                ((apart - free) * pixel_mm + runs, None, (apart + free) * pixel_mm - runs)
            }
            None => {
                let wire = room.least_wire_px.min(job.gauge.min_diameter_px) * pixel_mm;
                let field = (FIELD * rows).min(rows - 2.0 * beside);
                (job.gauge.min_diameter_px * pixel_mm, Some(wire), field * pixel_mm - runs)
            }
        };
        let ratio = largest_mm / smallest_mm;
        Self { smallest_mm, smallest_wire_mm: wire, largest_mm, ratio }
    }

    /// Refuses a diameter outside the range.
    ///
    /// # Errors
    /// Names the limit, and what would be right.
    pub(super) fn check(&self, job: &Job, diameter_mm: f64) -> Result<(), SettingError> {
        let least_mm = self.smallest_wire_mm.unwrap_or(self.smallest_mm);
        let field_mm = f64::from(job.camera.rows) * job.setup_settings().nominal_pixel_mm();
        if diameter_mm > self.largest_mm {
            let what = format!(
                "a part of {diameter_mm} mm is larger than this head can have in its field of {field_mm:.3} mm: at most {:.3} mm, with \
                 the light that its edges need beside them and its run-out; lower optics.magnification, take more rows, or ask for \
                 another --diameter-mm",
                self.largest_mm
            );
            return Err(SettingError::at("part.nominal_diameter_mm", what));
        }
        if diameter_mm < least_mm {
            let what = format!(
                "a part of {diameter_mm} mm is smaller than this head can measure: at least {least_mm:.4} mm; raise \
                 optics.magnification, or ask for another --diameter-mm"
            );
            return Err(SettingError::at("part.nominal_diameter_mm", what));
        }
        Ok(())
    }
}
