//! A window of a sensor.

/// The window of the sensor that a frame was read out from.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(deny_unknown_fields)]
pub struct Roi {
    /// Sensor row of the frame's row 0.
    pub row: u32,
    /// Sensor column of the frame's column 0.
    pub column: u32,
    /// Rows read out.
    pub rows: u32,
    /// Columns read out.
    pub columns: u32,
}
