//! The codes of a scan in a replay: what they switch, and whether a trigger finds all at rest.

use super::event::{Deed, SpindleState, Trigger};
use super::interpreter::{Interpreter, Words};
use crate::nc::dialect::Dialect;
use crate::nc::scan_settings::{MCode, NcScan};
use crate::nc::sinumerik::STOP;

impl Interpreter<'_> {
    /// G04: seconds in P on LinuxCNC, milliseconds elsewhere.
    pub(super) fn pause(&mut self, words: &Words) -> Result<(), String> {
        let p = words.get('P').filter(|p| *p >= 0.0 && words.other.len() == 1);
        let p = p.ok_or("G04 is understood with P alone")?;
        let unit = if self.control.dialect == Dialect::Linuxcnc { 1.0 } else { 1e-3 };
        self.modal.scan.pauses(p * unit);
        Ok(())
    }

    /// Applies a code of a scan; `false` where it is none.
    pub(super) fn switches(&mut self, line: usize, code: MCode) -> Result<bool, String> {
        let Some(scan) = self.control.settings.scan else { return Ok(false) };
        if code == scan.trigger {
            return self.trigger(line, &scan).map(|()| true);
        }
        if Some(code) == scan.shutter_close || Some(code) == scan.air_on {
            self.modal.scan.frame_is_taken(&scan)?;
        }
        let state = &mut self.modal.scan;
        let is = |other: Option<MCode>| other == Some(code);
        let mut known = is(scan.trigger_off);
        if code == scan.coolant_off || is(scan.air_off) {
            (state.blows, state.dried_s, known) = (false, 0.0, true);
            state.coolant_is_off |= code == scan.coolant_off;
        }
        if is(scan.air_on) {
            (state.blows, known) = (true, true);
        }
        if is(scan.shutter_open) || is(scan.shutter_close) {
            (state.shutter_is_open, known) = (is(scan.shutter_open), true);
        }
        Ok(known)
    }

    fn trigger(&mut self, line: usize, scan: &NcScan) -> Result<(), String> {
        self.modal.scan.frame_is_taken(scan)?;
        if let Some(why) = self.modal.scan.refuses_frame(scan) {
            return Err(format!("a frame is triggered {why}"));
        }
        let turning = self.modal.spindle.and(self.modal.scan.speed_per_min);
        let spindle = match (turning, self.modal.oriented_deg) {
            (Some(speed), _) => SpindleState::Turning(speed),
            (None, Some(angle)) if self.modal.spindle.is_none() => SpindleState::Held(angle),
            _ => {
                return Err(
                    "a frame is triggered while the spindle is neither held nor at a constant speed".into()
                );
            }
        };
        let counted = self.variables.get(&STOP).copied().unwrap_or(0.0);
        let trigger = Trigger { at: self.at, stop: counted.max(0.0) as u32, spindle };
        self.modal.scan.since_trigger_s = Some(0.0);
        self.happens(line, Deed::Trigger(trigger));
        Ok(())
    }

    /// Whether the carriage may move: the frames of the last trigger have been taken.
    pub(super) fn may_leave(&self) -> Result<(), String> {
        match self.control.settings.scan {
            Some(scan) => self.modal.scan.frame_is_taken(&scan),
            None => Ok(()),
        }
    }
}
