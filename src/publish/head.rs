//! What a camera asks of the head behind it: frames of a scene, and passes to be cut.

use crate::frame::{Frame, PixelFormat, Roi};

/// What stands before the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Object {
    /// The shaft of the config, of the ordered diameter.
    Drawn,
    /// The part as the passes left it.
    Part,
    /// A master pin; `clamped` counts how often a pin was put in.
    Master {
        /// Its number in the config, from 0.
        index: u32,
        /// Number of its clamping.
        clamped: u64,
    },
    /// The light without a part.
    Flat,
    /// No light: the lens is covered.
    Dark,
}

/// The scene of a frame: what is drawn anew only where it changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SceneOrder {
    /// What stands before the camera.
    pub object: Object,
    /// Diameter of the drawn shaft, mm.
    pub diameter_mm: f64,
    /// Speed of the spindle, rev/min.
    pub spindle_rpm: f64,
    /// Exposure time, µs.
    pub exposure_us: f64,
    /// Gain, dB.
    pub gain_db: f64,
    /// Densities of contamination, relative to the config's.
    pub contamination: f64,
}

/// A frame to take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FrameOrder {
    /// Number of the frame since the start of the acquisition, from 0.
    pub number: u64,
    /// Number of the frame of the part since its pass, or of the pin, from 0, by which its noise is
    /// drawn; `None` for the one after the last.
    pub of_object: Option<u64>,
    /// Start of exposure on the head's clock, ns.
    pub t_ns: u64,
    /// Spindle angle then, degrees.
    pub angle_deg: f64,
    /// Machine z of the sensor's middle, mm.
    pub z_mm: f64,
    /// Window of the sensor.
    pub window: Roi,
    /// Format of the grey values.
    pub format: PixelFormat,
    /// The scene.
    pub scene: SceneOrder,
}

/// A pass to cut.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PassOrder {
    /// Its number, from 1; 0: nothing is cut, a new blank is clamped.
    pub pass: u32,
    /// Offset of every station, mm of diameter.
    pub offset_mm: Vec<f64>,
}

/// Makes the frames of a head.
pub(crate) trait FrameMaker {
    /// Takes a frame, with the allocation of `reuse` where it fits.
    ///
    /// # Errors
    /// Why the scene cannot be taken, in one sentence; the next order is independent of it.
    fn frame(&mut self, order: &FrameOrder, reuse: Option<Frame>) -> Result<Frame, String>;

    /// Cuts a pass, or clamps a blank.
    ///
    /// # Errors
    /// Why it cannot be cut; the part is then as before.
    fn cut(&mut self, order: &PassOrder) -> Result<(), String>;
}
