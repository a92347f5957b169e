//! The request for a frame of a scene.

use crate::frame::{PixelFormat, Roi};

/// A request for a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameRequest {
    /// Sequence number; keys the noise together with `seed`.
    pub frame_id: u64,
    /// Start of exposure, ns.
    pub t_ns: u64,
    /// Machine z of the sensor's central column, mm.
    pub z_mm: f64,
    /// Spindle angle φ, degrees.
    pub angle_deg: f64,
    /// Whether the sensor adds temporal noise.
    pub noise: bool,
    /// Window of the sensor; `None` reads all of it.
    pub roi: Option<Roi>,
    /// A second window of the same columns below the first, as from cameras with several regions:
    /// its rows follow those of the first in the frame. Each window then contains one edge.
    pub second_roi: Option<Roi>,
    /// Seed of the noise.
    pub seed: u64,
    /// Pixel format, when it is not the sensor's own; levels are scaled to it.
    pub format: Option<PixelFormat>,
}
