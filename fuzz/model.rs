//! Bytes of an STL file to a turned part. The body of the fuzz target `model`, which a plain test runs as well over its seed and
//! damaged copies of it (tests/inside/stl/hostile.rs). A panic is a finding.

use crate::stl::{ReadSettings, TOLERANCE_MM, Unit, read_part};

/// A part of finite lines and arcs that hang together, or an error that says something. Whether it is a part.
pub(crate) fn model(bytes: &[u8]) -> bool {
    let settings = ReadSettings {
        unit: Unit::Millimetre,
        stock_mm: 32.0,
        tolerance_mm: TOLERANCE_MM,
        turn_round: bytes.len() % 2 == 1,
    };
    match read_part(bytes, &settings) {
        Ok(part) => {
            assert!(part.length_mm.is_finite() && part.length_mm > 0.0 && !part.outline.pieces.is_empty());
            for piece in &part.outline.pieces {
                assert!(piece.from.is_finite() && piece.to.is_finite());
            }
            for pair in part.outline.pieces.windows(2) {
                assert!(pair[0].to.distance(pair[1].from) < 1e-6);
            }
            true
        }
        Err(fault) => {
            assert!(!fault.to_string().is_empty() && fault.at.is_none_or(glam::DVec3::is_finite));
            false
        }
    }
}
