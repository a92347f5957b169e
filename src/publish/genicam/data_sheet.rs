//! What a head is, before a client sets anything.

use std::net::Ipv4Addr;

use crate::publish::gvsp::StreamFormat;

/// The data sheet of a head: its limits and its defaults.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DataSheet {
    /// Columns of the sensor.
    pub columns: u32,
    /// Rows of the sensor.
    pub rows: u32,
    /// Format that loses nothing of the sensor's grey values.
    pub format: StreamFormat,
    /// Model, at most 31 bytes.
    pub model: String,
    /// Serial number, at most 15 bytes.
    pub serial: String,
    /// Exposure time of the config, µs.
    pub exposure_us: f64,
    /// Longest exposure time, µs.
    pub longest_exposure_us: f64,
    /// Frames a second of the config.
    pub frame_rate_hz: f64,
    /// Black level, counts of the sensor's format.
    pub black_level_counts: f64,
    /// Diameter that the head draws, mm.
    pub diameter_mm: f64,
    /// Whether a contour gives the diameters, which are then not set one by one.
    pub diameter_is_drawn: bool,
    /// Densities of contamination at the start, relative to the config's: 0 of a clean one.
    pub contamination: f64,
    /// Height of the field, mm: no diameter is larger.
    pub field_mm: f64,
    /// Length of the part, mm.
    pub length_mm: f64,
    /// Spindle speed of the config, rev/min.
    pub spindle_rpm: f64,
    /// Number of master pins.
    pub masters: u32,
    /// Nominal diameters of the passes, mm.
    pub pass_nominal_mm: Vec<f64>,
    /// Middles of the stations, mm.
    pub station_z_mm: Vec<f64>,
    /// Address of the head.
    pub address: Ipv4Addr,
    /// Bits of its subnet.
    pub prefix: u8,
    /// Largest packet that its network carries, bytes with all headers.
    pub mtu: u32,
}

impl DataSheet {
    /// Mask of the subnet.
    pub(crate) fn mask(&self) -> u32 {
        u32::MAX.checked_shl(32 - u32::from(self.prefix.min(32))).unwrap_or(0)
    }

    /// A MAC address of its own, locally administered, from the IP address: 02:53 and the address.
    pub(crate) fn mac(&self) -> (u32, u32) {
        (0x0253, u32::from(self.address))
    }
}

#[cfg(test)]
#[path = "../../../fuzz/sheet.rs"]
mod sheet;
