//! The head that tests and the fuzz target `gvcp` publish.

use std::net::Ipv4Addr;

use crate::publish::genicam::DataSheet;
use crate::publish::gvsp::StreamFormat;

impl DataSheet {
    /// A data sheet for tests: 64 × 48 pixels of 12 bits, 400 frames a second.
    pub(crate) fn of_tests() -> Self {
        Self {
            columns: 64,
            rows: 48,
            format: StreamFormat::Mono12,
            model: "head of tests".into(),
            serial: "SG-1".into(),
            exposure_us: 50.0,
            longest_exposure_us: 1e6,
            frame_rate_hz: 400.0,
            black_level_counts: 64.0,
            diameter_mm: 10.0,
            diameter_is_drawn: false,
            contamination: 0.0,
            field_mm: 16.0,
            length_mm: 60.0,
            spindle_rpm: 0.0,
            masters: 2,
            pass_nominal_mm: vec![11.5, 11.0],
            station_z_mm: vec![2.5, 7.5, 12.5],
            address: Ipv4Addr::LOCALHOST,
            prefix: 8,
            mtu: 65_535,
        }
    }
}
