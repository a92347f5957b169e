//! Spindle angles by chunk, moved to mid-exposure; the first one that cannot be moved is a warning.

use crate::position::{MidExposure, Moved};
use crate::source::live::Known;

/// A chunk's angle with what it is moved by.
#[derive(Clone, Copy, Debug)]
pub(super) struct Latched {
    /// The angle at the start of exposure, degrees.
    pub angle_deg: Known<f64>,
    /// Start of exposure on the camera's clock, ns.
    pub device_ns: Option<u64>,
    /// Exposure time, µs.
    pub exposure_us: Option<f64>,
    /// Speed that the head states, degrees a second.
    pub stated_deg_per_s: Option<f64>,
}

/// Angles of the frames so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LatchedAngles {
    spindle: MidExposure,
    is_warned: bool,
}

impl LatchedAngles {
    /// The angle of the next frame at mid-exposure, and of the first one that stays unmoved why.
    pub(super) fn moved(&mut self, of: &Latched) -> (Moved, Option<&'static str>) {
        let moved = self.spindle.push(of.angle_deg.value, of.device_ns, of.exposure_us, of.stated_deg_per_s);
        let why = (moved.sweep_deg.is_none() && !self.is_warned).then(|| lacks(of));
        self.is_warned |= why.is_some();
        (moved, why)
    }
}

/// What an angle that was not moved lacked.
fn lacks(of: &Latched) -> &'static str {
    match (of.exposure_us, of.device_ns) {
        (None, _) => "the exposure time is unknown",
        (_, None) => "speed unknown (no SpindleSpeed, and no time of the camera's clock)",
        _ => "speed unknown (no SpindleSpeed, and no frame less than a second before)",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unmoved_angle_is_warned_once_with_what_it_lacks() {
        let of = |ms: Option<u64>, exposure_us, stated_deg_per_s| Latched {
            angle_deg: Known::stated(10.0),
            device_ns: ms.map(|ms| 1_000_000 * ms),
            exposure_us,
            stated_deg_per_s,
        };
        let warned = |all: [Latched; 2]| {
            let mut angles = LatchedAngles::default();
            all.map(|of| angles.moved(&of).1)
        };
        let [first, later] = warned([of(Some(0), Some(100.0), None), of(Some(5000), Some(100.0), None)]);
        assert!(first.unwrap().contains("no frame less than a second before") && later.is_none());
        let [first, second] = warned([of(Some(0), Some(100.0), Some(60.0)), of(Some(9), None, Some(60.0))]);
        assert!(first.is_none() && second.unwrap().contains("exposure time"));
        let [first, _] = warned([of(None, Some(100.0), None); 2]);
        assert!(first.unwrap().contains("camera's clock"));
    }
}
