//! What a camera is and is set to while frames are taken, as far as a calibration depends on it.
//!
//! A calibration turns pixels of one sensor, one window and one scale of grey values into
//! millimetres. Serial number, window, binning, reversal, gain, black level and pixel format are
//! therefore compared before frames are measured by it; the exposure time is information: light may
//! be brighter or darker within the grey scale. Names of features are those of the SFNC 2.7.

use std::fmt;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::roi::Roi;

/// Largest difference of a gain in dB, or of a black level, that is none: a register reads back
/// what it holds, and the finest steps in use are 0.01 dB.
const SAME: f64 = 1e-3;

/// A camera with the settings that frames were taken with; `None` where it does not state one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CameraBinding {
    /// Serial number.
    pub serial_number: String,
    /// Model; information.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub model: String,
    /// `PixelFormat`.
    pub pixel_format: String,
    /// Window on the sensor: `OffsetY`, `OffsetX`, `Height`, `Width`.
    pub window: Roi,
    /// `BinningHorizontal`, pixels that are joined.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub binning_horizontal: Option<u32>,
    /// `BinningVertical`, pixels that are joined.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub binning_vertical: Option<u32>,
    /// `ReverseX`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reverse_x: Option<bool>,
    /// `ReverseY`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reverse_y: Option<bool>,
    /// `Gain`, dB.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gain_db: Option<f64>,
    /// `BlackLevel`, in the camera's own unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub black_level: Option<f64>,
    /// `ExposureTime`, µs; information.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exposure_us: Option<f64>,
}

/// Where the frames to be measured come from: it decides what is to be done about a difference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoundSource {
    /// A camera, which can be set.
    Camera,
    /// A recording, which stays as it is.
    Recording,
}

/// Frames taken otherwise than those of the calibration.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("calibrated with {what} {calibrated}, {source_has} {found}: {right}")]
pub struct BindingError {
    what: &'static str,
    calibrated: String,
    source_has: &'static str,
    found: String,
    right: String,
}

/// A window as text: size and place.
struct Window(Roi);

impl fmt::Display for Window {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Roi { row, column, rows, columns } = self.0;
        write!(f, "{columns} x {rows} at OffsetX {column}, OffsetY {row}")
    }
}

/// A setting that both sides must have alike: name, both values as text where they differ, and how
/// the camera is set to the calibrated one.
type Compared = (&'static str, Option<(String, String)>, String);

/// Both values as text where the calibrated one is known and the other is not the same.
fn other<T: fmt::Display>(
    calibrated: Option<T>,
    found: Option<T>,
    is_same: impl Fn(&T, &T) -> bool,
    unit: &str,
) -> Option<(String, String)> {
    let calibrated = calibrated?;
    match found {
        Some(found) if is_same(&calibrated, &found) => None,
        Some(found) => Some((format!("{calibrated}{unit}"), format!("{found}{unit}"))),
        None => Some((format!("{calibrated}{unit}"), "none that it states".to_owned())),
    }
}

impl CameraBinding {
    /// The settings of which any difference is refused, in the order in which they are named. The
    /// window is not among them.
    fn compared(&self, found: &Self) -> [Compared; 8] {
        let near = |a: &f64, b: &f64| (a - b).abs() <= SAME;
        let text = |of: &str| Some(of.to_owned()).filter(|text| !text.is_empty());
        let set = |feature: &str, to: Option<String>| match to {
            Some(to) => format!("set {feature} to {to}"),
            None => String::new(),
        };
        let shown = |number: Option<f64>| number.map(|n| n.to_string());
        let joined = |number: Option<u32>| number.map(|n| n.to_string());
        let flag = |is_on: Option<bool>| is_on.map(|is_on| is_on.to_string());
        let (a, b) = (self, found);
        let gain = a.gain_db.map_or_else(String::new, |db| format!("set --gain-db {db}"));
        [
            (
                "the camera of serial number",
                other(text(&a.serial_number), text(&b.serial_number), String::eq, ""),
                "take the calibration of this camera".to_owned(),
            ),
            (
                "pixel format",
                other(text(&a.pixel_format), text(&b.pixel_format), String::eq, ""),
                set("PixelFormat", text(&a.pixel_format)),
            ),
            (
                "horizontal binning",
                other(a.binning_horizontal, b.binning_horizontal, u32::eq, ""),
                set("BinningHorizontal", joined(a.binning_horizontal)),
            ),
            (
                "vertical binning",
                other(a.binning_vertical, b.binning_vertical, u32::eq, ""),
                set("BinningVertical", joined(a.binning_vertical)),
            ),
            ("ReverseX", other(a.reverse_x, b.reverse_x, bool::eq, ""), set("ReverseX", flag(a.reverse_x))),
            ("ReverseY", other(a.reverse_y, b.reverse_y, bool::eq, ""), set("ReverseY", flag(a.reverse_y))),
            ("gain", other(a.gain_db, b.gain_db, near, " dB"), gain),
            (
                "black level",
                other(a.black_level, b.black_level, near, ""),
                set("BlackLevel", shown(a.black_level)),
            ),
        ]
    }

    fn refused(
        &self,
        of: BoundSource,
        what: &'static str,
        (calibrated, found): (String, String),
        right: &str,
    ) -> BindingError {
        let (source_has, right) = match of {
            BoundSource::Camera => ("camera has", format!("{right} or calibrate again")),
            BoundSource::Recording => {
                ("recording has", "take the calibration of the camera as it was recorded".to_owned())
            }
        };
        BindingError { what, calibrated, source_has, found, right }
    }

    /// Refuses a camera or a recording of another camera, or of one that was set otherwise. What
    /// the calibration does not state is not compared. The window may lie inside the calibrated
    /// one.
    ///
    /// # Errors
    /// The first setting that differs, with both values.
    pub fn check(&self, found: &Self, of: BoundSource) -> Result<(), BindingError> {
        for (what, differs, right) in self.compared(found) {
            if let Some(values) = differs {
                return Err(self.refused(of, what, values, &right));
            }
        }
        match self.place_of(found) {
            Some(_) => Ok(()),
            None => {
                let values = (Window(self.window).to_string(), Window(found.window).to_string());
                Err(self.refused(of, "the window", values, "set a window inside it"))
            }
        }
    }

    /// What a calibration states that holds for its whole window alone.
    pub(crate) fn refuse_window(&self, found: &Self, of: BoundSource) -> BindingError {
        let values = (Window(self.window).to_string(), Window(found.window).to_string());
        let right =
            "this calibration has no lens that a part of it could be placed under: set the same window";
        self.refused(of, "the window", values, right)
    }

    /// The window of a camera in rows and columns of the calibrated one; `None` where it is not all
    /// inside.
    pub fn place_of(&self, found: &Self) -> Option<Roi> {
        let (whole, part) = (self.window, found.window);
        let inside = |from: u32, length: u32, all_from: u32, all: u32| {
            let at = from.checked_sub(all_from)?;
            (length > 0 && at.checked_add(length)? <= all).then_some(at)
        };
        let row = inside(part.row, part.rows, whole.row, whole.rows)?;
        let column = inside(part.column, part.columns, whole.column, whole.columns)?;
        Some(Roi { row, column, ..part })
    }

    /// Refuses a camera that came back otherwise than it was: every setting but the exposure time,
    /// and the window to the pixel.
    ///
    /// # Errors
    /// What differs, as text: what it was, and what it is.
    #[cfg_attr(not(feature = "camera"), allow(dead_code, reason = "cameras alone come back"))]
    pub(crate) fn check_unchanged(&self, found: &Self) -> Result<(), (&'static str, String, String)> {
        for (what, differs, _) in self.compared(found) {
            if let Some((was, is)) = differs {
                return Err((what, was, is));
            }
        }
        match self.window == found.window {
            true => Ok(()),
            false => Err(("the window", Window(self.window).to_string(), Window(found.window).to_string())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> CameraBinding {
        CameraBinding {
            serial_number: "40001".to_owned(),
            model: "M".to_owned(),
            pixel_format: "Mono12".to_owned(),
            window: Roi { row: 100, column: 8, rows: 400, columns: 512 },
            binning_horizontal: Some(1),
            binning_vertical: Some(1),
            reverse_x: Some(false),
            reverse_y: Some(false),
            gain_db: Some(0.0),
            black_level: Some(64.0),
            exposure_us: Some(50.0),
        }
    }

    /// What is set otherwise.
    type Change = fn(&mut CameraBinding);

    #[test]
    fn every_setting_that_differs_is_refused_by_its_name_with_both_values() {
        let of = BoundSource::Camera;
        let cases: [(Change, &str); 8] = [
            (
                |c| c.serial_number = "40002".to_owned(),
                "calibrated with the camera of serial number 40001, camera has 40002: take the calibration of this \
                 camera or calibrate again",
            ),
            (
                |c| c.pixel_format = "Mono8".to_owned(),
                "calibrated with pixel format Mono12, camera has Mono8: set PixelFormat to Mono12 or calibrate again",
            ),
            (
                |c| c.binning_vertical = Some(2),
                "calibrated with vertical binning 1, camera has 2: set BinningVertical to 1 or calibrate again",
            ),
            (
                |c| c.reverse_x = Some(true),
                "calibrated with ReverseX false, camera has true: set ReverseX to false or calibrate again",
            ),
            (
                |c| c.gain_db = Some(6.0),
                "calibrated with gain 0 dB, camera has 6 dB: set --gain-db 0 or calibrate again",
            ),
            (
                |c| c.black_level = None,
                "calibrated with black level 64, camera has none that it states: set BlackLevel to 64 or calibrate again",
            ),
            (
                |c| c.window.row = 99,
                "calibrated with the window 512 x 400 at OffsetX 8, OffsetY 100, camera has 512 x 400 at OffsetX 8, \
                 OffsetY 99: set a window inside it or calibrate again",
            ),
            (
                |c| (c.window.column, c.window.columns) = (9, 512),
                "calibrated with the window 512 x 400 at OffsetX 8, OffsetY 100, camera has 512 x 400 at OffsetX 9, \
                 OffsetY 100: set a window inside it or calibrate again",
            ),
        ];
        for (change, words) in cases {
            let mut found = camera();
            change(&mut found);
            assert_eq!(camera().check(&found, of).unwrap_err().to_string(), words);
            assert!(camera().check_unchanged(&found).is_err(), "{words}");
        }
        let found = CameraBinding { gain_db: Some(6.0), ..camera() };
        let words = camera().check(&found, BoundSource::Recording).unwrap_err().to_string();
        assert!(words.starts_with("calibrated with gain 0 dB, recording has 6 dB: take"), "{words}");
    }

    #[test]
    fn exposure_and_model_are_information_and_what_is_not_stated_is_not_compared() {
        let found = CameraBinding { exposure_us: Some(20.0), model: String::new(), ..camera() };
        assert_eq!(camera().check(&found, BoundSource::Camera), Ok(()));
        assert_eq!(camera().check_unchanged(&found), Ok(()));
        let found = CameraBinding { gain_db: Some(0.0004), ..camera() };
        assert_eq!(camera().check(&found, BoundSource::Camera), Ok(()));
        let bare = CameraBinding { window: camera().window, ..CameraBinding::default() };
        assert_eq!(bare.check(&camera(), BoundSource::Camera), Ok(()));
    }

    #[test]
    fn a_window_inside_has_its_place_and_another_none() {
        let at = |row, column, rows, columns| {
            let found = CameraBinding { window: Roi { row, column, rows, columns }, ..camera() };
            (camera().check(&found, BoundSource::Camera).is_ok(), camera().place_of(&found))
        };
        let place = Roi { row: 20, column: 2, rows: 380, columns: 510 };
        assert_eq!(at(120, 10, 380, 510), (true, Some(place)));
        assert_eq!(at(100, 8, 400, 512).1, Some(Roi { row: 0, column: 0, rows: 400, columns: 512 }));
        for (row, column, rows, columns) in
            [(99, 8, 10, 10), (100, 7, 10, 10), (101, 8, 400, 512), (100, 8, 0, 10), (u32::MAX, 8, 2, 2)]
        {
            assert_eq!(at(row, column, rows, columns), (false, None), "{row} {column}");
        }
    }

    #[test]
    fn it_is_the_same_after_a_file() {
        let text = serde_json::to_string(&camera()).unwrap();
        assert_eq!(serde_json::from_str::<CameraBinding>(&text).unwrap(), camera());
        let bare = CameraBinding { serial_number: "1".to_owned(), ..CameraBinding::default() };
        let text = serde_json::to_string(&bare).unwrap();
        assert!(!text.contains("gain_db"), "{text}");
        assert_eq!(serde_json::from_str::<CameraBinding>(&text).unwrap(), bare);
    }
}
