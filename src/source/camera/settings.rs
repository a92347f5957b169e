//! What a camera is opened with.

/// What becomes of a camera that is gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WhenGone {
    /// It ends the source with the reason: a series of measurements is cut short.
    Ends,
    /// It is looked for until it is back.
    Returns,
}

/// What a camera is opened with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CameraSettings {
    /// Exposure time to set, µs; `None` leaves the camera's.
    pub exposure_us: Option<f64>,
    /// Gain to set, dB; `None` leaves the camera's.
    pub gain_db: Option<f64>,
    /// Whether a shutter that exposes row after row is taken as it is: of a part at rest.
    pub accepts_rolling_shutter: bool,
    /// What becomes of a camera that is gone.
    pub when_gone: WhenGone,
}
