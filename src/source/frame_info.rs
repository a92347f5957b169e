//! A row of `frames.csv`.

/// One row of `frames.csv`; an empty field is 0 or `None`.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct FrameInfo {
    /// Name of the frame: the file's stem.
    pub frame: String,
    /// Start of exposure, ns.
    pub t_ns: Option<u64>,
    /// Machine z of the central column, mm.
    pub z_mm: f64,
    /// Spindle angle, degrees.
    pub angle_deg: f64,
    /// Exposure, µs.
    pub exposure_us: f64,
    /// Bits of a grey value.
    pub bit_depth: Option<u8>,
    /// Nominal scale, µm/px.
    pub um_per_px: Option<f64>,
    /// Count of the spindle's encoder, and that at its last index pulse.
    pub encoder: Option<(i64, Option<i64>)>,
    /// Number of the stop of a scan program, from 1.
    pub stop: Option<u32>,
    /// Angle that the spindle turned during the exposure, degrees, by the encoder.
    pub sweep_deg: f64,
    /// Why the frame has no angle.
    pub void: Option<String>,
    /// Its row, from 2.
    pub row: usize,
}
