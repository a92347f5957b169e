//! Probing moves of a replay: what the probe meets, and what the control keeps of it.

use super::interpreter::{Deed, Interpreter, Next, Point, Words};
use crate::nc::dialect::Dialect;

impl Interpreter<'_> {
    /// `G31`, `G38.2`: X alone, down to the touch or, where there is none, to the end of the move.
    pub(super) fn probing_move(&mut self, line: usize, words: &Words) -> Result<Next, String> {
        let Some(probe) = self.control.settings.probe else {
            return Err("a probing move without a probe (nc.probe)".into());
        };
        if !self.with_probe {
            return Err("a probing move without the probe in the carrier".into());
        }
        if self.modal.spindle.is_some() {
            return Err("a probing move while the spindle turns".into());
        }
        let feed = self.modal.feed.is_some_and(|f| f > 0.0 && f.is_finite());
        if self.modal.feed_per_revolution || !feed {
            return Err("a probing move needs F above 0, per minute".into());
        }
        let target = match (words.get('X'), words.get('Z')) {
            (Some(x), None) => Point { x: x * self.x_unit()? + self.shift, ..self.at },
            _ => return Err("a probing move must move X alone".into()),
        };
        if target.x >= self.at.x {
            return Err("a probing move must go down to the part".into());
        }
        // where no surface is given nothing is touched
        let surface = self.control.surface.as_ref();
        let diameter = surface.map_or(f64::NEG_INFINITY, |s| {
            if self.has_cut { s.after_at(self.at.z) } else { s.before_at(self.at.z) }
        });
        let touch = diameter + probe.correction_mm;
        if touch >= self.at.x {
            return Err("a probing move begins in the part".into());
        }
        let from = self.at;
        self.at.x = touch.max(target.x);
        self.happens(line, Deed::Probe { from, to: self.at, target });
        // a position without G00 or G01 after it would move on in LinuxCNC, and depend on the control elsewhere
        self.modal.motion = None;
        let linuxcnc = self.control.dialect == Dialect::Linuxcnc;
        if touch < target.x && linuxcnc {
            self.happens(line, Deed::Alarm("G38.2 ended without a touch".into()));
            return Ok(Next::End);
        }
        let read = (self.at.x - self.shift) / if linuxcnc { 2.0 } else { 1.0 };
        self.variables.insert(probe.variable(self.control.dialect), read);
        Ok(Next::Line)
    }
}
