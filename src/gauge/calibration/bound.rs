//! A calibration and the camera that it was made with.
//!
//! Scale, lens, flat field and gain of grey values are those of one sensor as it was set (see
//! [`CameraBinding`]). Frames of another one are refused. A window inside the calibrated one is
//! exact: the lens counts from a centre that moves with the window, ρ stays that of the whole
//! frame, and the light is the same surface in other coordinates.

use super::error::CalibrationError;
use super::gauge_calibration::Calibration;
use super::optical_setup::SetupCalibration;
use crate::frame::{BoundSource, CameraBinding, Roi};

impl Calibration {
    /// Keeps the camera that its frames were taken with.
    #[must_use]
    pub(crate) fn with_camera(self, camera: Option<CameraBinding>) -> Self {
        Self { camera: camera.map(Box::new), ..self }
    }

    /// The calibration for frames of this camera: itself, or its part under a window inside. One
    /// that states no camera holds for any.
    ///
    /// # Errors
    /// Another camera, or one that is set otherwise: the setting with both values, and what would
    /// be right.
    pub(crate) fn for_camera(
        &self,
        found: &CameraBinding,
        of: BoundSource,
    ) -> Result<Self, CalibrationError> {
        let Some(own) = &self.camera else { return Ok(self.clone()) };
        own.check(found, of)?;
        if own.window == found.window {
            return Ok(self.clone());
        }
        match (&self.setup, own.place_of(found)) {
            (Some(setup), Some(place)) => {
                let camera = CameraBinding { window: found.window, ..own.as_ref().clone() };
                let setup = Some(Box::new(setup.within(place)));
                Ok(Self { setup, ..self.clone() }.with_camera(Some(camera)))
            }
            _ => Err(own.refuse_window(found, of).into()),
        }
    }
}

impl SetupCalibration {
    /// The optical setup as it is seen through a window of its frames, in their rows and columns.
    #[must_use]
    pub(crate) fn within(&self, window: Roi) -> Self {
        let mut part = Self {
            rows: window.rows as usize,
            columns: window.columns as usize,
            flat_field: self.flat_field.as_ref().map(|field| field.within(window)),
            ..self.clone()
        };
        part.lens.centre_row_px -= f64::from(window.row);
        part.lens.centre_column_px -= f64::from(window.column);
        part
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauge::calibration::adjusted::Adjusted;
    use crate::gauge::calibration::imaging_model::{ColumnSpread, LensModel};
    use crate::gauge::calibration::optical_setup::{ReadWidth, Validity};

    fn camera() -> CameraBinding {
        CameraBinding {
            serial_number: "40001".to_owned(),
            pixel_format: "Mono12".to_owned(),
            window: Roi { row: 8, column: 16, rows: 400, columns: 512 },
            gain_db: Some(0.0),
            ..CameraBinding::default()
        }
    }

    fn setup() -> SetupCalibration {
        let lens = LensModel {
            radial: 4e-4,
            keystone_across: 2e-4,
            keystone_along: -1e-4,
            ..LensModel::perfect(400, 512)
        };
        let adjusted = Adjusted {
            parameters: [0.01, 0.0, 4e-4, 2e-4, -1e-4, 0.0],
            lens,
            parts: Vec::new(),
            birge_ratio: 1.0,
            residuals: Vec::new(),
        };
        let date = "2026-11-22".parse().unwrap();
        SetupCalibration::new(&adjusted, (400, 512), Validity { date, valid_days: 365 }, 0.8)
    }

    fn calibration() -> Calibration {
        Calibration { setup: Some(Box::new(setup())), ..Calibration::from_scale(10.0) }
            .with_camera(Some(camera()))
    }

    #[test]
    fn a_width_in_a_window_is_the_width_of_the_whole_frame() {
        let found =
            CameraBinding { window: Roi { row: 58, column: 116, rows: 300, columns: 200 }, ..camera() };
        let part = calibration().for_camera(&found, BoundSource::Camera).unwrap();
        let part = part.setup.as_deref().unwrap();
        let read = |row: f64, column: f64| ReadWidth {
            columns: ColumnSpread { mean_px: column, variance_px2: 100.0 },
            rows_px: (row + 20.25, row + 210.5),
            chord: 1.0,
            axis_y_mm: 0.0,
        };
        // the same edges, 50 rows and 100 columns further up and left in the window
        let whole = setup().diameter_by(0.01, &read(70.0, 150.0));
        let in_window = part.diameter_by(0.01, &read(20.0, 50.0));
        assert_eq!(whole, in_window);
        assert_eq!((part.rows, part.columns), (300, 200));
        assert!(part.check_size(300, 200).is_ok() && part.check_size(400, 512).is_err());
    }

    #[test]
    fn another_camera_and_a_window_without_a_place_are_refused() {
        let other = CameraBinding { serial_number: "40002".to_owned(), ..camera() };
        let why = calibration().for_camera(&other, BoundSource::Camera).unwrap_err().to_string();
        assert!(why.contains("40001") && why.contains("40002"), "{why}");
        let bare = Calibration { setup: None, ..calibration() };
        assert_eq!(bare.for_camera(&camera(), BoundSource::Camera).unwrap(), bare);
        let smaller = CameraBinding { window: Roi { rows: 300, ..camera().window }, ..camera() };
        let why = bare.for_camera(&smaller, BoundSource::Camera).unwrap_err().to_string();
        assert!(why.contains("512 x 400") && why.contains("512 x 300"), "{why}");
    }

    #[test]
    fn one_without_a_camera_holds_for_any_and_is_read_as_before() {
        let free = calibration().with_camera(None);
        assert_eq!(free.for_camera(&camera(), BoundSource::Recording).unwrap(), free);
        let free = Calibration::from_scale(10.0);
        let text = serde_json::to_string(&free).unwrap();
        assert!(!text.contains("\"camera\""), "{text}");
        assert_eq!(Calibration::read(text.as_bytes()).unwrap().camera, None);
        let text = serde_json::to_string(&free.with_camera(Some(camera()))).unwrap();
        assert_eq!(Calibration::read(text.as_bytes()).unwrap().camera.as_deref(), Some(&camera()));
    }
}
