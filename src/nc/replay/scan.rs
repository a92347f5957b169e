//! The scan in a replay: what is switched, whether all is at rest at a trigger, and whether the
//! triggers are those of the plan.

use super::event::{Deed, Event, Point, SpindleState, Trigger};
use super::interpreter::{Interpreter, Words};
use crate::nc::dialect::Dialect;
use crate::nc::scan_settings::{MCode, NcScan};
use crate::nc::sinumerik::STOP;

/// Distance below which positions are the same, mm, and angles, degrees: the increment of both.
const SAME: f64 = 1e-3;
/// A pause is written in whole milliseconds, s.
const SAME_S: f64 = 1e-6;

/// What a program has switched, and how long everything has been at rest.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ScanState {
    coolant_is_off: bool,
    blows: bool,
    has_blown_s: f64,
    shutter_is_open: bool,
    /// Pauses since the coolant or the air was switched off last, s.
    dried_s: f64,
    /// Pauses since anything moved, s.
    rest_s: f64,
    /// Pauses since the last trigger; none before the first, s.
    since_trigger_s: Option<f64>,
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
    fn refuses_frame(&self, scan: &NcScan) -> Option<&'static str> {
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
            self.frame_is_taken(&scan)?;
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

    /// Whether the frames of the last trigger have had their time.
    fn frame_is_taken(&self, scan: &NcScan) -> Result<(), String> {
        match self.modal.scan.since_trigger_s {
            Some(s) if s + SAME_S < frames_s(scan) => {
                Err("the frames of the last trigger are not waited for (frame_s, turns)".to_owned())
            }
            _ => Ok(()),
        }
    }

    fn trigger(&mut self, line: usize, scan: &NcScan) -> Result<(), String> {
        self.frame_is_taken(scan)?;
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
            Some(scan) => self.frame_is_taken(&scan),
            None => Ok(()),
        }
    }
}

/// A stop of the plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CommandedStop {
    /// Z of the programmed point, mm.
    pub z_mm: f64,
    /// What the spindle does there.
    pub spindle: SpindleState,
}

/// The stops of a scan in order, at one X, mm of diameter.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct CommandedScan {
    /// Where the tool stands retracted.
    pub x_mm: f64,
    /// The stops, numbered from 1.
    pub stops: Vec<CommandedStop>,
}

impl CommandedScan {
    /// Whether the triggers are those of the plan: each stop once, in order, counted.
    pub(super) fn covered(&self, events: &[Event]) -> Result<(), (usize, String)> {
        let mut due = self.stops.iter().zip(1..);
        let mut last = 0;
        for event in events {
            let Deed::Trigger(found) = &event.deed else { continue };
            last = event.block;
            let Some((stop, number)) = due.next() else {
                return Err((last, format!("a trigger after all {} stops", self.stops.len())));
            };
            self.is_stop(found, stop, number).map_err(|why| (last, why))?;
        }
        match due.next() {
            None => Ok(()),
            Some((stop, number)) => {
                Err((last, format!("stop {number} at Z {:.3} is not triggered", stop.z_mm)))
            }
        }
    }

    fn is_stop(&self, found: &Trigger, stop: &CommandedStop, number: u32) -> Result<(), String> {
        if found.stop != number {
            return Err(format!("stop {number} is triggered as number {}", found.stop));
        }
        let Point { x, z } = found.at;
        if (x - self.x_mm).abs() > SAME {
            return Err(format!("stop {number} is triggered with the tool at X {x:.3}, not retracted"));
        }
        if (z - stop.z_mm).abs() > SAME {
            return Err(format!("stop {number} is triggered at Z {z:.3}, due is Z {:.3}", stop.z_mm));
        }
        let same = match (found.spindle, stop.spindle) {
            (SpindleState::Held(a), SpindleState::Held(b)) => (a - b).abs() <= SAME,
            // S is a whole number
            (SpindleState::Turning(a), SpindleState::Turning(b)) => (a - b).abs() <= 0.5,
            _ => false,
        };
        if !same {
            return Err(format!(
                "stop {number}: the spindle is {:?}, due is {:?}",
                found.spindle, stop.spindle
            ));
        }
        Ok(())
    }
}
