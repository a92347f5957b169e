//! Probing moves of a replay: where the probe touches, and the position that the control stores.

use super::event::{Deed, Point};
use super::interpreter::{Interpreter, Next, Words};
use crate::nc::dialect::Dialect;

impl Interpreter<'_> {
    /// `M19 R`: the spindle is held at an angle until it starts or stops.
    pub(super) fn orient(&mut self, words: &Words) -> Result<(), String> {
        if self.modal.spindle.is_some() {
            return Err("the spindle is turned to an angle while it runs".into());
        }
        self.may_leave()?;
        self.modal.scan.moves();
        let angle = words.get('R').filter(|r| (0.0..360.0).contains(r));
        let waits = self.control.dialect != Dialect::Linuxcnc || words.get('Q').is_some_and(|q| q > 0.0);
        match angle {
            Some(angle) if waits => self.modal.oriented_deg = Some(angle),
            Some(_) => return Err("LinuxCNC goes on before the spindle has turned where Q is missing".into()),
            None => return Err("an angle R of 0 to below 360 degrees is missing".into()),
        }
        Ok(())
    }

    /// Applies M code `m` to a spindle that may be held at an angle; `false` where `m` is no such
    /// code.
    pub(super) fn holds_spindle(&mut self, m: u32, words: &Words) -> Result<bool, String> {
        let Some(orientation) = self.control.settings.spindle_orientation else { return Ok(false) };
        if m == orientation.m_code {
            self.orient(words)?;
            return Ok(true);
        }
        if [3, 4, 5, 6].contains(&m) || orientation.release_m_code == Some(m) {
            self.modal.oriented_deg = None;
        }
        Ok(orientation.release_m_code == Some(m))
    }

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
        if self.control.settings.spindle_orientation.is_some() && self.modal.oriented_deg.is_none() {
            return Err("a probing move while the spindle is not held at its angle".into());
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
        let angle_deg = self.modal.oriented_deg;
        let run_out = surface.map_or(0.0, |s| s.run_out_mm * angle_deg.unwrap_or(0.0).to_radians().cos());
        let scatter = surface.and_then(|s| s.scatter_mm.get(self.touches % s.scatter_mm.len().max(1)));
        let touch = diameter + run_out + scatter.copied().unwrap_or(0.0) + probe.correction_mm;
        self.touches += 1;
        if touch >= self.at.x {
            return Err("a probing move begins in the part".into());
        }
        let from = self.at;
        self.at.x = touch.max(target.x);
        self.happens(line, Deed::Probe { from, to: self.at, target, angle_deg });
        // a position without G00 or G01 after it would continue the motion in LinuxCNC; elsewhere
        // it depends on the control
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
