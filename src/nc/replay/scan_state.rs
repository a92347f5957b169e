//! What a scan program has switched, and how long everything has been at rest.

use crate::nc::scan_settings::NcScan;

/// A pause is written in whole milliseconds, s.
const SAME_S: f64 = 1e-6;

/// What a program has switched, and how long everything has been at rest.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ScanState {
    pub(super) coolant_is_off: bool,
    pub(super) blows: bool,
    has_blown_s: f64,
    pub(super) shutter_is_open: bool,
    /// Pauses since the coolant or the air was switched off last, s.
    pub(super) dried_s: f64,
    /// Pauses since anything moved, s.
    rest_s: f64,
    /// Pauses since the last trigger; none before the first, s.
    pub(super) since_trigger_s: Option<f64>,
    /// Constant speed of the spindle, 1/min.
    pub(super) speed_per_min: Option<f64>,
}

impl ScanState {
    /// The carriage or the spindle moves.
    pub(super) fn moves(&mut self) {
        self.rest_s = 0.0;
    }

    pub(super) fn pauses(&mut self, seconds: f64) {
        self.rest_s += seconds;
        self.dried_s += seconds;
        if self.blows {
            self.has_blown_s += seconds;
        }
        self.since_trigger_s = self.since_trigger_s.map(|s| s + seconds);
    }

    /// Why a frame cannot be taken now.
    pub(super) fn refuses_frame(&self, scan: &NcScan) -> Option<&'static str> {
        let reasons = [
            (!self.coolant_is_off, "before the coolant is off"),
            (self.blows, "in the air blast"),
            (
                scan.air_on.is_some() && self.has_blown_s + SAME_S < scan.air_s,
                "before the air blast of air_s",
            ),
            (self.dried_s + SAME_S < scan.dwell_s, "before the coolant has run off (dwell_s)"),
            (scan.shutter_open.is_some() && !self.shutter_is_open, "behind the closed shutter"),
            (self.rest_s + SAME_S < scan.settle_s, "before carriage and spindle are at rest (settle_s)"),
        ];
        reasons.into_iter().find(|(is, _)| *is).map(|(_, why)| why)
    }
}

/// Time that the frames of a stop take after their trigger, s.
pub(in crate::nc) fn frames_s(scan: &NcScan) -> f64 {
    scan.frame_s + scan.speed_per_min.map_or(0.0, |speed| 60.0 * scan.turns / speed)
}

impl ScanState {
    /// Whether the frames of the last trigger have had their time.
    pub(super) fn frame_is_taken(&self, scan: &NcScan) -> Result<(), String> {
        match self.since_trigger_s {
            Some(s) if s + SAME_S < frames_s(scan) => {
                Err("the frames of the last trigger are not waited for (frame_s, turns)".to_owned())
            }
            _ => Ok(()),
        }
    }
}
