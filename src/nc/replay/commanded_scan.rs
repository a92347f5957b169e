//! The scan that is commanded: whether the triggers of a program are those of the plan.

use super::event::{Deed, Event, Point, SpindleState, Trigger};

/// Distance below which positions are the same, mm, and angles, degrees: the increment of both.
const SAME: f64 = 1e-3;

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
