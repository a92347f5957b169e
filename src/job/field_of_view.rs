//! The camera as the loop plans with it: its data sheet.

use crate::setting::{SettingError, positive};

/// What the camera's and the lens' data sheets give, for the plans of a scan. Diameters do not
/// follow from it: the scale comes from the masters.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldOfView {
    /// Pixels along the spindle axis.
    pub columns: u32,
    /// Pixels across it.
    pub rows: u32,
    /// Nominal size of a pixel on the object, mm.
    pub mm_per_px: f64,
    /// Rows of a frame that has the optical axis in its middle: all rows, or for two windows twice
    /// the place of the axis between them.
    pub rows_about_axis: f64,
    /// Whether it is a line camera: a frame shows a single z, and all of a scan are one stream.
    pub is_line: bool,
    /// Time from one frame to the next, ms.
    pub frame_period_ms: f64,
    /// Limit of the lens' telecentricity error at the corner of the field, mrad.
    pub telecentricity_mrad: f64,
}

impl Default for FieldOfView {
    /// A 2/3" sensor of 2448 × 2048 pixels of 3.45 µm behind a lens of 0.226.
    fn default() -> Self {
        Self {
            columns: 2448,
            rows: 2048,
            mm_per_px: 3.45 * 1e-3 / 0.226,
            rows_about_axis: 2048.0,
            is_line: false,
            frame_period_ms: 28.0,
            telecentricity_mrad: 0.0,
        }
    }
}

impl FieldOfView {
    /// Length along z of the whole field, mm.
    pub(crate) fn length_mm(&self) -> f64 {
        f64::from(self.columns) * self.mm_per_px
    }

    /// Height of the field, mm.
    pub(crate) fn height_mm(&self) -> f64 {
        f64::from(self.rows) * self.mm_per_px
    }

    /// Limit of the telecentricity error by the lens' data sheet (`optics.telecentricity_mrad`),
    /// 1/mm: masters in one plane do not show it.
    pub(crate) fn limit_telecentricity_per_mm(&self) -> f64 {
        let (rows, columns) = (f64::from(self.rows), f64::from(self.columns));
        let half_mm = 0.5 * rows.hypot(columns) * self.mm_per_px;
        (1e-3 * self.telecentricity_mrad).tan().abs() / half_mm
    }

    /// Checks that the field is one; `camera` and `optics` are the tables its values come from.
    ///
    /// # Errors
    /// Names the key and what would be right.
    pub(super) fn check(&self) -> Result<(), SettingError> {
        positive("camera.columns", f64::from(self.columns))?;
        positive("camera.rows", f64::from(self.rows))?;
        positive("camera.frame_period_ms", self.frame_period_ms)?;
        positive("camera.pixel_um", self.mm_per_px)
    }
}
