//! The nominal optical setup: camera, optics, light and sensor.
//!
//! The true optical setup differs from it by seeded amounts ([`SetupDeviations`]) that only `truth`
//! may access; the gauge is calibrated on frames. Levels are grey values in counts; electrons
//! follow from them by the sensor's gain.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::contamination::Contamination;
use super::error::{RenderError, within};
use super::motion::Motion;
#[cfg(test)]
pub(crate) use super::sensor::{DarkCurrent, Readout, SpatialShares};
pub(crate) use super::sensor::{EmvaResults, Sensor, SensorFile};
use crate::frame::Roi;
use crate::render::optics::lens::FieldLight;
#[cfg(test)]
pub(crate) use crate::render::optics::settings::Entocentric;
pub(crate) use crate::render::optics::settings::{Esf, GaussianEsf, Optics};

/// Largest change of a vibration's phase from one row to the next, rad: an edge is followed through
/// the rows of its blur.
const MOST_RAD_A_ROW: f64 = 0.5;

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// The pixel matrix and its timing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Camera {
    /// Pixels along the spindle axis.
    pub columns: u32,
    /// Pixels across it.
    pub rows: u32,
    /// Pixel pitch on the sensor, µm.
    pub pixel_um: f64,
    /// Exposure time, µs.
    pub exposure_us: f64,
    /// Time from one frame to the next, ms.
    pub frame_period_ms: f64,
    /// Rolling shutter: time from the start of exposure of one row to that of the next, µs, in the
    /// order of readout; 0 for a global shutter.
    #[serde(skip_serializing_if = "is_zero")]
    pub line_time_us: f64,
    /// Read only two windows of rows; none reads the whole field.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub windows: Option<EdgeWindows>,
    /// A line camera: one column, one reading a line; none for an area camera.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<LineCamera>,
}

/// A camera of one line of pixels across the part. Spindle and carriage are its other axes: every
/// reading has an angle and a z of its own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LineCamera {
    /// Readings a millisecond.
    pub rate_khz: f64,
}

impl Default for LineCamera {
    fn default() -> Self {
        Self { rate_khz: 16.0 }
    }
}

/// Two windows of rows, one an edge: the regions of one camera, or two heads mounted a known
/// distance apart, seen as one tall field of which only their rows exist. A frame holds the upper
/// window's rows, the lower one's beneath them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EdgeWindows {
    /// First row of the upper window in the field.
    pub upper_row: u32,
    /// First row of the lower window in the field.
    pub lower_row: u32,
    /// Rows of either window.
    pub rows: u32,
}

impl EdgeWindows {
    /// Both windows over `columns` columns, the upper one first.
    pub(crate) fn rois(&self, columns: u32) -> [Roi; 2] {
        [self.upper_row, self.lower_row].map(|row| Roi { row, column: 0, rows: self.rows, columns })
    }
}

impl Default for Camera {
    /// A 2/3" sensor of 2448 × 2048 pixels of 3.45 µm.
    fn default() -> Self {
        Self {
            columns: 2448,
            rows: 2048,
            pixel_um: 3.45,
            exposure_us: 50.0,
            frame_period_ms: 28.0,
            line_time_us: 0.0,
            windows: None,
            line: None,
        }
    }
}

impl Camera {
    /// Rows of a frame that has the optical axis in its middle: all rows, or for two windows twice
    /// the place of the axis between them.
    pub(crate) fn rows_about_axis(&self) -> f64 {
        let between = |w: EdgeWindows| f64::from(w.upper_row + w.lower_row) - f64::from(w.rows);
        f64::from(self.rows) - self.windows.map_or(0.0, between)
    }

    /// Time from one frame, or one reading of a line camera, to the next, ms.
    pub(crate) fn period_ms(&self) -> f64 {
        self.line.map_or(self.frame_period_ms, |line| line.rate_khz.recip())
    }

    /// Refuses line times that no motion can be followed through, and a flash that not all rows are
    /// exposed to.
    fn check_rolling(&self, motion: &Motion) -> Result<(), RenderError> {
        let line_us = self.line_time_us;
        within("camera.line_time_us", line_us, 0.0, 1e4)?;
        if line_us == 0.0 {
            return Ok(());
        }
        if self.line.is_some() {
            let right = "is for an area camera: a line of pixels is exposed at once";
            return Err(RenderError::setting("camera.line_time_us", &line_us, right));
        }
        let frame_us = f64::from(self.windows.map_or(self.rows, |w| 2 * w.rows)) * line_us;
        if let Some(flash) = motion.strobe
            && flash.delay_us < frame_us
        {
            let right = format!(
                "must fall into the exposure of every row of a rolling shutter: at least {frame_us} µs after \
                 the start of exposure"
            );
            return Err(RenderError::setting("motion.strobe.delay_us", &flash.delay_us, right));
        }
        for v in &motion.vibration {
            let a_row = std::f64::consts::TAU * v.frequency_hz * line_us * 1e-6;
            if a_row > MOST_RAD_A_ROW {
                let right = "changes from one row of a rolling shutter to the next by more than 0.5 rad: it is \
                             drawn with a shorter camera.line_time_us";
                return Err(RenderError::setting("motion.vibration.frequency_hz", &v.frequency_hz, right));
            }
        }
        Ok(())
    }

    fn check_line(&self) -> Result<(), RenderError> {
        let Some(line) = self.line else { return Ok(()) };
        within("camera.line.rate_khz", line.rate_khz, 1e-3, 1e3)?;
        if self.columns != 1 {
            let right = "must be 1 with [camera.line]: one line of camera.rows pixels a reading";
            return Err(RenderError::setting("camera.columns", &self.columns, right));
        }
        if self.windows.is_some() {
            let right = "are for an area camera: leave them out beside [camera.line]";
            return Err(RenderError::setting("camera.windows", &"windows", right));
        }
        within("camera.exposure_us", self.exposure_us, 0.001, 1e3 / line.rate_khz)
    }

    /// Checks every value against its range.
    ///
    /// # Errors
    /// Names the key that is wrong and what would be right.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        within("camera.columns", f64::from(self.columns), 1.0, 16384.0)?;
        within("camera.rows", f64::from(self.rows), 1.0, 16384.0)?;
        within("camera.pixel_um", self.pixel_um, 0.1, 100.0)?;
        within("camera.exposure_us", self.exposure_us, 0.001, 1e7)?;
        within("camera.frame_period_ms", self.frame_period_ms, 0.001, 1e6)?;
        self.check_line()
    }
}

/// Mean grey values of field and shadow.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Light {
    /// Mean grey value of the bright field, counts.
    pub bright_counts: f64,
    /// Mean photons a pixel gets in the bright field during the exposure; replaces `bright_counts`,
    /// which then follows from quantum efficiency, gain and black level.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bright_photons: Option<f64>,
    /// Mean grey value in the shadow (black level + stray light), counts.
    pub shadow_counts: f64,
    /// Brightness over the field; `bright_counts` is what its centre has.
    pub field: FieldLight,
}

impl Default for Light {
    /// Three quarters of a 12-bit scale, stray light of 1.5 %.
    fn default() -> Self {
        Self {
            bright_counts: 3100.0,
            bright_photons: None,
            shadow_counts: 110.0,
            field: FieldLight::default(),
        }
    }
}

impl Light {
    /// Grey value of the bright field with a sensor whose true gain is `electrons_per_count`: the
    /// configured one, or black level + η·photons/(electrons per count).
    pub(crate) fn bright_in(&self, sensor: &Sensor, electrons_per_count: f64) -> f64 {
        self.bright_photons.map_or(self.bright_counts, |photons| {
            sensor.black_level_counts + sensor.quantum_efficiency * photons / electrons_per_count
        })
    }

    /// Checks every value against its range and the sensor's scale.
    ///
    /// # Errors
    /// Names the key that is wrong and what would be right.
    pub(crate) fn check(&self, sensor: &Sensor) -> Result<(), RenderError> {
        within("light.shadow_counts", self.shadow_counts, sensor.black_level_counts, 65535.0)?;
        let full = f64::from(sensor.format.full_scale().unwrap_or(u16::MAX));
        if let Some(photons) = self.bright_photons {
            within("light.bright_photons", photons, 0.0, 1e9)?;
            let counts = self.bright_in(sensor, sensor.electrons_per_count);
            within("light.bright_photons (as counts)", counts, self.shadow_counts, 16.0 * full)?;
        } else {
            within("light.bright_counts", self.bright_counts, self.shadow_counts, 16.0 * full)?;
        }
        self.field.check()
    }
}

/// How far the true bench may lie from the nominal one: standard deviations of the seeded draws.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename = "Departures", deny_unknown_fields, default)]
pub struct SetupDeviations {
    /// Relative standard deviation of the magnification.
    pub magnification_rel: f64,
    /// Relative standard deviation of the blur.
    pub blur_rel: f64,
    /// Relative standard deviation of the electrons per count.
    pub gain_rel: f64,
}

impl Default for SetupDeviations {
    fn default() -> Self {
        Self { magnification_rel: 1e-3, blur_rel: 0.05, gain_rel: 0.05 }
    }
}

impl SetupDeviations {
    /// An optical setup without deviations from its nominal values.
    pub fn none() -> Self {
        Self { magnification_rel: 0.0, blur_rel: 0.0, gain_rel: 0.0 }
    }

    /// Checks every value against its range.
    ///
    /// # Errors
    /// Names the key that is wrong and what would be right.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        within("departures.magnification_rel", self.magnification_rel, 0.0, 0.1)?;
        within("departures.blur_rel", self.blur_rel, 0.0, 0.2)?;
        within("departures.gain_rel", self.gain_rel, 0.0, 0.2)
    }
}

/// Everything a user sets about the bench.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename = "BenchSettings", deny_unknown_fields, default)]
pub struct SetupSettings {
    /// The pixel matrix.
    pub camera: Camera,
    /// Lens and edge spread.
    pub optics: Optics,
    /// Levels.
    pub light: Light,
    /// Photons to counts.
    pub sensor: Sensor,
    /// What moves during an exposure.
    pub motion: Motion,
    /// What soils the view.
    pub contamination: Contamination,
    /// Distance of the true bench from the nominal one.
    pub departures: SetupDeviations,
}

impl SetupSettings {
    /// Checks every part.
    ///
    /// # Errors
    /// Names the key that is wrong and what would be right.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        self.camera.check()?;
        self.optics.check()?;
        self.motion.check(self.camera.exposure_us)?;
        self.camera.check_rolling(&self.motion)?;
        self.sensor.check()?;
        self.light.check(&self.sensor)?;
        self.contamination.check()?;
        self.departures.check()
    }

    /// Refuses a bright field beyond the sensor's scale, as a user may write it: every pixel of it
    /// would have the same value. Light that clips is set by its photons.
    ///
    /// # Errors
    /// Names the key and the scale.
    pub(crate) fn check_counts(&self) -> Result<(), RenderError> {
        let full = f64::from(self.sensor.format.full_scale().unwrap_or(u16::MAX));
        if self.light.bright_photons.is_some() || self.light.bright_counts <= full {
            return Ok(());
        }
        let right = format!(
            "counts are more than the {full} of {} bits (sensor.format): at most {full}; light that clips is set by \
             light.bright_photons",
            self.sensor.format.bit_depth()
        );
        Err(RenderError::setting("light.bright_counts", &self.light.bright_counts, right))
    }

    /// Nominal size of a pixel on the object, mm.
    pub(crate) fn nominal_pixel_mm(&self) -> f64 {
        self.camera.pixel_um * 1e-3 / self.optics.magnification
    }
}
