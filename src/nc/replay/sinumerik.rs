//! Blocks of SINUMERIK programs, as far as this crate emits them: G00 to G4 G18 G40 to G42 G54 G75
//! G90 G94 G95 G96 G97 G451 G710, DIAMON, NORM, `X=` and `Z=`, `CR=` or `I=` and `K=`, F, S,
//! `LIMS=`, `SPOS=`, T with D, `$TC_DP2`, `$TC_DP6` and `$TC_DP15` of a tool's first edge, M02-M05
//! M30, one M code that measures and those of a scan, R parameters and their sums, MSG, STOPRE, M0,
//! `IF … GOTOF`, GOTOB and labels. Everything else is refused.
//!
//! `M0` after a message is an alarm: the programs loop about it. An R parameter may be read or
//! written only in a block after `STOPRE`: blocks are prepared ahead of the motion, so that without
//! it the mark of a finished pass would be set before the pass is cut.

use super::event::{Deed, Point};
use super::interpreter::{Interpreter, Motion, Next, Words};
use crate::nc::scan_settings::MCode;
use crate::nc::sinumerik::{RAN_LAST, RAN_LAST_R, STOP, STOP_R};

/// A comparison and its sign.
type Comparison = (&'static str, fn(f64, f64) -> bool);

/// Two-letter signs first: `<` begins `<>` and `<=`.
const COMPARISONS: [Comparison; 6] = [
    ("==", |a, b| a == b),
    ("<>", |a, b| a != b),
    (">=", |a, b| a >= b),
    ("<=", |a, b| a <= b),
    (">", |a, b| a > b),
    ("<", |a, b| a < b),
];

/// The words of a block that the ISO dialects do not have.
#[derive(Default)]
struct Others {
    fixed_point: Option<f64>,
    machine_axes: (bool, bool),
    speed_limit: Option<f64>,
    edge: Option<f64>,
    tool: Option<f64>,
    g75: bool,
    pauses: bool,
    constant_speed: bool,
    spindle_deg: Option<f64>,
    /// G40, G41 or G42 times ten, as the ISO dialects count.
    compensation: Option<u32>,
}

pub(super) fn parsed(text: &str) -> Result<f64, String> {
    let value: Option<f64> = text.parse().ok().filter(|v: &f64| v.is_finite());
    value.ok_or_else(|| format!("{text:?} is no number"))
}

impl Interpreter<'_> {
    /// A block without its comment, upper case.
    pub(super) fn sinumerik_block(&mut self, line: usize, text: &str) -> Result<Next, String> {
        if text.ends_with(':') {
            return Ok(Next::Line);
        }
        if text == "STOPRE" {
            return Ok(Next::Line);
        }
        if let Some(message) = text.strip_prefix("MSG(\"").and_then(|rest| rest.strip_suffix("\")")) {
            self.modal.message = Some(message.to_owned());
            return Ok(Next::Line);
        }
        if text == "M0" {
            let message = self.modal.message.clone().ok_or("a stop without a message before it")?;
            self.happens(line, Deed::Alarm(message));
            return Ok(Next::End);
        }
        if let Some(rest) = text.strip_prefix("IF ") {
            let (condition, label) = rest.split_once(" GOTOF ").ok_or("GOTOF is missing after IF")?;
            let holds = self.compares(line, condition)?;
            return if holds { self.to_label(line, label, false) } else { Ok(Next::Line) };
        }
        if let Some(label) = text.strip_prefix("GOTOB ") {
            return self.to_label(line, label, true);
        }
        if let Some(rest) = text.strip_prefix("$TC_DP") {
            return self.write_edge(rest).map(|()| Next::Line);
        }
        if let Some((number, value)) = parameter(text) {
            self.is_synchronous(line)?;
            let value = self.r_value(value)?;
            self.variables.insert(number, value);
            return Ok(Next::Line);
        }
        self.sinumerik_words(line, text)
    }

    fn to_label(&self, line: usize, label: &str, backwards: bool) -> Result<Next, String> {
        let found = self.program.line_with(line, &format!("{}:", label.trim()), backwards);
        found.map(Next::Jump).ok_or_else(|| format!("there is no label {label}"))
    }

    /// Whether the last block was STOPRE.
    fn is_synchronous(&self, line: usize) -> Result<(), String> {
        let before = self.program.lines[..line].iter().rev().find(|l| !l.text.is_empty());
        match before {
            Some(before) if before.text == "STOPRE" => Ok(()),
            _ => Err("an R parameter is read or written without STOPRE in the block before".into()),
        }
    }

    fn compares(&self, line: usize, condition: &str) -> Result<bool, String> {
        self.is_synchronous(line)?;
        for (sign, holds) in COMPARISONS {
            if let Some((left, right)) = condition.split_once(sign) {
                return Ok(holds(self.r_value(left)?, self.r_value(right)?));
            }
        }
        Err(format!("{condition:?} compares nothing"))
    }

    /// A number or an R parameter.
    fn r_value(&self, text: &str) -> Result<f64, String> {
        let text = text.trim();
        if let Some((left, right)) = text.split_once('+').filter(|_| text.starts_with('R')) {
            return Ok(self.r_value(left)? + self.r_value(right)?);
        }
        let Some(digits) = text.strip_prefix('R') else { return parsed(text) };
        let number: u32 = digits.parse().map_err(|_| format!("{text:?} is no R parameter"))?;
        let value = self.variables.get(&of_r(number)).copied();
        value.ok_or_else(|| format!("R{number} is read before it is set"))
    }

    fn sinumerik_words(&mut self, line: usize, text: &str) -> Result<Next, String> {
        let (mut words, mut others) = (Words::default(), Others::default());
        for word in text.split_whitespace() {
            self.sinumerik_word(word, &mut words, &mut others)?;
        }
        if others.g75 {
            return self.fixed_point(line, text, &others).map(|()| Next::Line);
        }
        if others.fixed_point.is_some() || others.machine_axes != (false, false) {
            return Err("FP=, X1= and Z1= are understood with G75 alone".into());
        }
        if others.pauses {
            let seconds = words.get('F').filter(|f| *f >= 0.0 && text.split_whitespace().count() == 2);
            self.modal.scan.pauses(seconds.ok_or("G4 is understood with F (seconds) alone")?);
            return Ok(Next::Line);
        }
        self.spindle_position(&others)?;
        self.called(line, &others)?;
        if let Some(feed) = words.get('F') {
            self.modal.feed = Some(feed);
        }
        if let Some(speed) = words.get('S') {
            let limited = others.constant_speed || others.speed_limit.is_some_and(|limit| limit > 0.0);
            self.modal.speed |= speed > 0.0 && limited;
            self.modal.scan.speed_per_min = others.constant_speed.then_some(speed);
        }
        let mut end = false;
        for m in std::mem::take(&mut words.m) {
            if [3, 4, 5].contains(&m) {
                self.modal.oriented_deg = None;
            }
            end |= !self.switches(line, MCode { m, p: None })? && self.miscellaneous(line, m)?;
        }
        if let Some(code) = others.compensation {
            self.set_compensation(code, &words)?;
        }
        self.travel(line, &words)?;
        Ok(if end { Next::End } else { Next::Line })
    }

    fn sinumerik_word(&mut self, word: &str, words: &mut Words, others: &mut Others) -> Result<(), String> {
        if word == "DIAMON" {
            self.modal.positions.x_unit = Some(1.0);
            return Ok(());
        }
        if word == "NORM" {
            self.nose.at_right_angles = true;
            return Ok(());
        }
        if let Some((name, value)) = word.split_once('=') {
            let value = parsed(value)?;
            match name {
                "X" | "Z" | "I" | "K" | "CR" => {
                    let letter = if name == "CR" { 'R' } else { name.chars().next().unwrap_or('X') };
                    if words.get(letter).is_some() {
                        return Err(format!("{name} stands twice"));
                    }
                    words.other.push((letter, value));
                }
                "FP" => others.fixed_point = Some(value),
                "LIMS" => others.speed_limit = Some(value),
                "SPOS" => others.spindle_deg = Some(value),
                "X1" => others.machine_axes.0 = true,
                "Z1" => others.machine_axes.1 = true,
                _ => return Err(format!("{word} is not understood")),
            }
            return Ok(());
        }
        let unknown = || format!("{word} is not understood");
        let (letter, digits) = word.split_at_checked(1).ok_or_else(unknown)?;
        let value = parsed(digits).map_err(|_| unknown())?;
        match letter {
            "G" => self.sinumerik_g(value, others)?,
            "M" if value.fract() == 0.0 && value >= 0.0 => words.m.push(value as u32),
            "F" => words.other.push(('F', value)),
            "S" => words.other.push(('S', value)),
            "T" => others.tool = Some(value),
            "D" => others.edge = Some(value),
            _ => return Err(unknown()),
        }
        Ok(())
    }

    fn sinumerik_g(&mut self, code: f64, others: &mut Others) -> Result<(), String> {
        let positions = &mut self.modal.positions;
        match code as u32 {
            _ if code.fract() != 0.0 => return Err(format!("G{code} is not understood")),
            0 => self.modal.motion = Some(Motion::Rapid),
            1 => self.modal.motion = Some(Motion::Feed),
            2 | 3 => self.modal.motion = Some(Motion::Arc { clockwise: code == 2.0 }),
            18 => positions.plane = true,
            40 => {
                positions.no_nose_compensation = true;
                others.compensation = Some(400);
            }
            41 | 42 => others.compensation = Some(10 * code as u32),
            451 => self.nose.extends_corners = true,
            4 => others.pauses = true,
            54 | 96 => {}
            97 => others.constant_speed = true,
            75 => others.g75 = true,
            90 => positions.absolute = true,
            94 => self.feed_mode(false),
            95 => self.feed_mode(true),
            710 => positions.millimetres = true,
            _ => return Err(format!("G{code} is not understood")),
        }
        Ok(())
    }

    /// `SPOS=30`: the spindle turns to an angle and is held there.
    fn spindle_position(&mut self, others: &Others) -> Result<(), String> {
        let Some(angle) = others.spindle_deg else { return Ok(()) };
        if self.modal.spindle.is_some() {
            return Err("the spindle is turned to an angle while it runs".into());
        }
        if !(0.0..360.0).contains(&angle) {
            return Err("SPOS needs an angle of 0 to below 360 degrees".into());
        }
        self.may_leave()?;
        self.modal.scan.moves();
        self.modal.oriented_deg = Some(angle);
        Ok(())
    }

    /// `G75 FP=1 X1=0`: one machine axis to its fixed point, in rapid and without any offset.
    fn fixed_point(&mut self, line: usize, text: &str, others: &Others) -> Result<(), String> {
        let alone = text.split_whitespace().count() == 3;
        let to = match (others.fixed_point, others.machine_axes) {
            (Some(point), (true, false)) if point == 1.0 && alone => {
                Point { x: self.control.reference.x, ..self.at }
            }
            (Some(point), (false, true)) if point == 1.0 && alone => {
                Point { z: self.control.reference.z, ..self.at }
            }
            _ => return Err("G75 is understood with FP=1 and one of X1=0 and Z1=0 alone".into()),
        };
        self.may_leave()?;
        self.go(line, to, true);
        Ok(())
    }

    /// `T1 D1`: the tool and its first edge.
    fn called(&mut self, line: usize, others: &Others) -> Result<(), String> {
        match (others.tool, others.edge) {
            (None, None) => Ok(()),
            (Some(tool), Some(edge)) if tool.fract() == 0.0 && edge == 1.0 => {
                let Some(with_probe) = self.is_probe(tool as u32) else {
                    return Err(format!("T{tool} is not tool {}", self.control.settings.tool));
                };
                (self.with_probe, self.modal.tool_called) = (with_probe, true);
                self.nose.offset = tool as u32;
                self.happens(line, Deed::ToolChange(self.at));
                Ok(())
            }
            _ => Err("a tool is called with its number and D1 (T1 D1)".into()),
        }
    }
}

/// Number of the variable that an R parameter stands for.
fn of_r(number: u32) -> u32 {
    match number {
        RAN_LAST_R => RAN_LAST,
        STOP_R => STOP,
        other => other,
    }
}

/// Number and value of `R98=201`.
fn parameter(text: &str) -> Option<(u32, &str)> {
    let (name, value) = text.split_once('=')?;
    let number: u32 = name.trim().strip_prefix('R')?.parse().ok()?;
    Some((of_r(number), value))
}
