//! Runs a program block by block, as its control would, and lists the events.
//!
//! The subset of G code that this crate emits, in the ISO dialects (`sinumerik` reads the other):
//! G00 to G04 G07 G08 (LinuxCNC) G10 G18 G21 G28 G40 to G43 G49 G50 G65 H99 G80 G90 G95 G96 G97
//! G99, probing by G31 or G38.2 with G94 or G98, M02-M06 M30, one M code that measures and those of
//! a scan, T, `#` variables, IF THEN, IF GOTO, WHILE DO END, and LinuxCNC's `o` words. Everything
//! else is refused: a code without an implementation here cannot be shown to be safe. Positions are
//! those of the programmed point of the nose, with the wear offset in force (X a diameter).

use super::event::{Deed, Event, Fault, Point};
use super::expression::{Reader, Variables};
use super::flow::{Program, leading, o_word};
use super::nose::Nose;
use super::scan_state::ScanState;
use super::surface::Surface;
use crate::nc::dialect::Dialect;
use crate::nc::machine::{GeometryOffset, WearX};
use crate::nc::nose_words::NoseRegister;
use crate::nc::scan_settings::MCode;
use crate::nc::settings::NcSettings;

/// Most blocks of a run; a longer one is refused as an endless loop.
const MOST_BLOCKS: usize = 1_000_000;

/// State of the control before the program starts.
pub(crate) struct Control<'a> {
    /// The control.
    pub dialect: Dialect,
    /// How it reads offsets.
    pub settings: &'a NcSettings,
    /// Where the tip is.
    pub start: Point,
    /// The reference point of G28.
    pub reference: Point,
    /// Variables that are set already.
    pub variables: Vec<(u32, f64)>,
    /// Whether the probe is in the carrier.
    pub with_probe: bool,
    /// The surface that a probe touches; none where it is not given.
    pub surface: Option<Surface>,
    /// Radius and tip direction that stand on the page of the tool's offset, where a program only
    /// states them.
    pub tool_page: Option<NoseRegister>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Motion {
    Rapid,
    Feed,
    Arc { clockwise: bool },
}

/// Modal state; `None` is what the program has not set yet.
#[derive(Clone, Debug, Default)]
pub(super) struct Modal {
    pub(super) motion: Option<Motion>,
    pub(super) positions: Positions,
    pub(super) feed_per_revolution: bool,
    pub(super) feed: Option<f64>,
    pub(super) speed: bool,
    pub(super) spindle: Option<u32>,
    /// Angle at which the spindle is held.
    pub(super) oriented_deg: Option<f64>,
    tool_selected: Option<u32>,
    pub(super) tool_called: bool,
    /// Text of the last message of a SINUMERIK program.
    pub(super) message: Option<String>,
    /// What a scan has switched.
    pub(super) scan: ScanState,
}

/// How positions are interpreted, as far as the program has set it.
#[derive(Clone, Debug, Default)]
pub(super) struct Positions {
    /// Diameter of one unit of X.
    pub(super) x_unit: Option<f64>,
    pub(super) plane: bool,
    pub(super) millimetres: bool,
    pub(super) no_nose_compensation: bool,
    pub(super) absolute: bool,
}

/// A program being run.
pub(super) struct Interpreter<'a> {
    pub(super) control: &'a Control<'a>,
    pub(super) program: &'a Program,
    pub(super) variables: Variables,
    wear: std::collections::HashMap<u32, f64>,
    pub(super) nose: Nose,
    /// Diameter that the wear offset in force adds to X.
    pub(super) shift: f64,
    pub(super) at: Point,
    pub(super) modal: Modal,
    /// Whether the probe is in the carrier.
    pub(super) with_probe: bool,
    /// Whether a feed has moved the tool.
    pub(super) has_cut: bool,
    /// Number of probing moves so far.
    pub(super) touches: usize,
    events: Vec<Event>,
}

/// How the program continues after a block.
pub(super) enum Next {
    Line,
    Jump(usize),
    End,
}

/// The numbers of a block by letter.
#[derive(Default)]
pub(super) struct Words {
    g: Vec<f64>,
    pub(super) m: Vec<u32>,
    pub(super) other: Vec<(char, f64)>,
}

impl Words {
    pub(super) fn get(&self, letter: char) -> Option<f64> {
        self.other.iter().find(|w| w.0 == letter).map(|w| w.1)
    }
}

impl<'a> Interpreter<'a> {
    pub(super) fn new(program: &'a Program, control: &'a Control<'a>) -> Self {
        let is_lathe_control = matches!(control.dialect, Dialect::Fanuc | Dialect::Gsk);
        Self {
            control,
            program,
            variables: control.variables.iter().copied().collect(),
            wear: std::collections::HashMap::new(),
            nose: Nose::of_page(control.settings.tool, control.tool_page),
            shift: 0.0,
            at: control.start,
            with_probe: control.with_probe,
            has_cut: false,
            touches: 0,
            modal: Modal {
                // system A: X and Z are absolute, X a diameter by parameter
                positions: Positions {
                    x_unit: is_lathe_control.then_some(1.0),
                    absolute: is_lathe_control,
                    ..Positions::default()
                },
                ..Modal::default()
            },
            events: Vec::new(),
        }
    }

    /// Runs to the end: the events, and the final values of the variables.
    pub(super) fn run(mut self) -> Result<(Vec<Event>, Variables), Fault> {
        let mut line = 0;
        for _ in 0..MOST_BLOCKS {
            if line >= self.program.lines.len() {
                return Err((self.program.lines.len(), "the program ends without M02 or M30".into()));
            }
            match self.block(line).map_err(|why| (line + 1, why))? {
                Next::Line => line += 1,
                Next::Jump(to) => line = to,
                Next::End => return Ok((self.events, self.variables)),
            }
        }
        Err((line + 1, format!("the program goes on after {MOST_BLOCKS} blocks")))
    }

    pub(super) fn happens(&mut self, line: usize, deed: Deed) {
        self.events.push(Event { block: line + 1, deed, with_probe: self.with_probe });
    }

    fn block(&mut self, line: usize) -> Result<Next, String> {
        let program = self.program;
        let Some(read) = program.lines.get(line) else { return Ok(Next::End) };
        if let Some(text) = &read.abort {
            self.happens(line, Deed::Alarm(text.clone()));
            return Ok(Next::End);
        }
        let text = read.text.as_str();
        if text.is_empty() || text == "%" {
            return Ok(Next::Line);
        }
        if self.control.dialect == Dialect::Sinumerik {
            return self.sinumerik_block(line, text);
        }
        if let Some((label, rest)) = o_word(text) {
            return self.o_block(line, label, rest);
        }
        if leading(text, 'O').is_some() {
            return Ok(Next::Line);
        }
        let text = match leading(text, 'N') {
            Some(_) => text[1..].trim_start_matches(|c: char| c.is_ascii_digit()).trim_start(),
            None => text,
        };
        self.statement(line, text)
    }

    fn holds(&self, condition: &str) -> Result<(bool, String), String> {
        let mut reader = Reader::new(condition, &self.variables);
        let (value, _) = reader.value()?;
        Ok((value != 0.0, reader.rest().to_owned()))
    }

    /// LinuxCNC's `if`, `else`, `endif`, `while`, `endwhile`.
    fn o_block(&mut self, line: usize, label: u32, rest: &str) -> Result<Next, String> {
        let lost = |what: &str| format!("o{label} has no {what}");
        if self.control.dialect != Dialect::Linuxcnc {
            return Err("o words are LinuxCNC's".into());
        }
        if let Some(condition) = rest.strip_prefix("IF") {
            if self.holds(condition)?.0 {
                return Ok(Next::Line);
            }
            let to = self.program.after(line, label, &["ELSE", "ENDIF"]).ok_or_else(|| lost("endif"))?;
            return Ok(Next::Jump(to + 1));
        }
        if let Some(condition) = rest.strip_prefix("WHILE") {
            let end = self.program.after(line, label, &["ENDWHILE"]).ok_or_else(|| lost("endwhile"))?;
            return Ok(if self.holds(condition)?.0 { Next::Line } else { Next::Jump(end + 1) });
        }
        match rest {
            "ELSE" => {
                let end = self.program.after(line, label, &["ENDIF"]).ok_or_else(|| lost("endif"))?;
                Ok(Next::Jump(end + 1))
            }
            "ENDIF" => Ok(Next::Line),
            "ENDWHILE" => {
                let start = self.program.before(line, label, &["WHILE"]).ok_or_else(|| lost("while"))?;
                Ok(Next::Jump(start))
            }
            _ => Err(format!("{rest:?} is not understood")),
        }
    }

    fn goto(&self, target: &str) -> Result<Next, String> {
        let (number, _) = Reader::new(target, &self.variables).value()?;
        let line = self.program.labels.get(&(number as u32)).copied();
        line.map(Next::Jump).ok_or_else(|| format!("GOTO {number}: there is no N{number}"))
    }

    fn statement(&mut self, line: usize, text: &str) -> Result<Next, String> {
        let is_macro_b = self.control.dialect != Dialect::Linuxcnc;
        if let Some(assignment) = text.strip_prefix('#') {
            return self.assign(line, assignment);
        }
        if is_macro_b && let Some(rest) = text.strip_prefix("IF") {
            let (holds, rest) = self.holds(rest)?;
            if let Some(target) = rest.strip_prefix("GOTO") {
                return if holds { self.goto(target) } else { Ok(Next::Line) };
            }
            let then = rest.strip_prefix("THEN").ok_or("neither THEN nor GOTO follows the condition")?;
            return if holds { self.statement(line, then.trim_start()) } else { Ok(Next::Line) };
        }
        if is_macro_b && let Some(target) = text.strip_prefix("GOTO") {
            return self.goto(target);
        }
        if is_macro_b && let Some(rest) = text.strip_prefix("WHILE") {
            let (holds, rest) = self.holds(rest)?;
            let label = rest.strip_prefix("DO").ok_or("DO is missing after WHILE")?.trim();
            let end = self.program.line_with(line, &format!("END{label}"), false);
            let end = end.ok_or_else(|| format!("DO{label} has no END{label}"))?;
            return Ok(if holds { Next::Line } else { Next::Jump(end + 1) });
        }
        if is_macro_b && let Some(label) = text.strip_prefix("END") {
            let start = self.program.line_with(line, &format!("DO{}", label.trim()), true);
            return start.map(Next::Jump).ok_or_else(|| format!("END{label} has no WHILE"));
        }
        let words = self.words(text)?;
        self.obey(line, &words)
    }

    fn assign(&mut self, line: usize, text: &str) -> Result<Next, String> {
        let mut reader = Reader::new(text, &self.variables);
        let number = reader.index()?;
        if !reader.takes("=") {
            return Err("= is missing".into());
        }
        let value = reader.comparison()?;
        if !reader.is_empty() {
            return Err(format!("{:?} is left over", reader.rest()));
        }
        match (number, self.control.dialect) {
            (3000, Dialect::Linuxcnc) => return Err("#3000 raises no alarm in LinuxCNC".into()),
            (3000, _) => {
                self.happens(line, Deed::Alarm(format!("{value}")));
                return Ok(Next::End);
            }
            (1000.., _) => return Err(format!("#{number} is a system variable")),
            _ => {}
        }
        self.variables.insert(number, value);
        Ok(Next::Line)
    }

    fn words(&self, text: &str) -> Result<Words, String> {
        let mut reader = Reader::new(text, &self.variables);
        let mut words = Words::default();
        while !reader.is_empty() {
            let letter = reader.letter().ok_or_else(|| format!("{:?} is not understood", reader.rest()))?;
            let (value, whole) = reader.value()?;
            match letter {
                'G' => words.g.push(value),
                'M' if value.fract() == 0.0 && value >= 0.0 => words.m.push(value as u32),
                'X' | 'Z' | 'U' | 'W' | 'F' if whole => {
                    return Err(format!(
                        "{letter}{value} has no decimal point: a control may take it in increments"
                    ));
                }
                'X' | 'Z' | 'U' | 'W' | 'F' | 'S' | 'T' | 'P' | 'H' | 'D' | 'L' | 'R' | 'Q' => {
                    if words.get(letter).is_some() {
                        return Err(format!("{letter} stands twice"));
                    }
                    words.other.push((letter, value));
                }
                _ => return Err(format!("{letter}{value} is not understood")),
            }
        }
        Ok(words)
    }

    /// A block of words, in the order in which controls take them: settings, tool, spindle, motion,
    /// stop.
    fn obey(&mut self, line: usize, words: &Words) -> Result<Next, String> {
        let mut motion_only = true;
        for &g in &words.g {
            match self.prepare(line, g, words)? {
                Some(next) => return Ok(next),
                None => motion_only &= matches!(g as u32, 0 | 1),
            }
        }
        if let Some(feed) = words.get('F') {
            self.modal.feed = Some(feed);
        }
        self.tool(line, words)?;
        if let Some(speed) = words.get('S') {
            self.modal.speed |= speed > 0.0 && !words.g.contains(&50.0);
            self.modal.scan.speed_per_min = words.g.contains(&97.0).then_some(speed);
        }
        let orients = |m: &u32| self.control.settings.spindle_orientation.is_some_and(|o| o.m_code == *m);
        let is_radius = matches!(self.modal.motion, Some(Motion::Arc { .. })) || words.g.contains(&10.0);
        if words.get('R').or(words.get('Q')).is_some() && !is_radius && !words.m.iter().any(orients) {
            return Err("R and Q are understood with arcs, registers of a nose and a spindle's angle".into());
        }
        let mut end = false;
        for &m in &words.m {
            let code = MCode { m, p: words.get('P').map(|p| p as u32) };
            end |= !self.holds_spindle(m, words)?
                && !self.switches(line, code)?
                && self.miscellaneous(line, m)?;
        }
        if words.g.iter().any(|g| [31.0, 38.2].contains(g)) {
            return self.probing_move(line, words);
        }
        let takes_axes = motion_only || !words.g.iter().any(|g| [10.0, 28.0, 50.0].contains(g));
        if takes_axes {
            self.travel(line, words)?;
        }
        Ok(if end { Next::End } else { Next::Line })
    }

    fn prepare(&mut self, line: usize, g: f64, words: &Words) -> Result<Option<Next>, String> {
        let linuxcnc = self.control.dialect == Dialect::Linuxcnc;
        let code = (g * 10.0).round() as u32;
        match (code, linuxcnc) {
            (0, _) => self.modal.motion = Some(Motion::Rapid),
            (10, _) => self.modal.motion = Some(Motion::Feed),
            (20 | 30, _) => self.modal.motion = Some(Motion::Arc { clockwise: code == 20 }),
            (40, _) => self.pause(words)?,
            (70, true) => self.modal.positions.x_unit = Some(1.0),
            (80, true) => self.modal.positions.x_unit = Some(2.0),
            (100, false) if words.get('R').is_some() => self.write_nose(words)?,
            (100, false) => self.write_offset(words)?,
            (310, false) | (382, true) => {}
            (180, _) => self.modal.positions.plane = true,
            (210, _) => self.modal.positions.millimetres = true,
            (280, false) => {
                self.may_leave()?;
                self.go_to_reference(line, words)?;
            }
            (400, _) => {
                self.modal.positions.no_nose_compensation = true;
                self.set_compensation(code, words)?;
            }
            (410 | 420, false) | (411 | 421, true) => self.set_compensation(code, words)?,
            (430 | 490, true) => self.shift = 0.0,
            (500, false) => {
                if words.get('S').is_none_or(|s| s <= 0.0) || words.get('X').or(words.get('Z')).is_some() {
                    return Err("G50 must limit the speed and nothing else".into());
                }
            }
            (650, false) => return self.alarm(line, words).map(Some),
            (800, true) => self.modal.motion = None,
            (900, true) => self.modal.positions.absolute = true,
            (950, true) | (990, false) => self.feed_mode(true),
            (940, true) | (980, false) => self.feed_mode(false),
            (960 | 970, _) => {}
            _ => return Err(format!("G{g} is not understood")),
        }
        Ok(None)
    }

    /// Sets the feed mode; a feed value of the other mode is discarded.
    pub(super) fn feed_mode(&mut self, per_revolution: bool) {
        self.modal.feed_per_revolution = per_revolution;
        self.modal.feed = None;
    }

    /// Diameter of one unit of X, where absolute positions can be taken.
    pub(super) fn x_unit(&self) -> Result<f64, String> {
        let m = &self.modal.positions;
        let unit = m
            .x_unit
            .filter(|_| m.absolute)
            .ok_or("how X is taken (G7 or G8, DIAMON), and G90, must come before the first move")?;
        if !(m.plane && m.millimetres && m.no_nose_compensation) {
            return Err(
                "the plane, millimetres and G40 (G18 G21 G40, G18 G40 G710) must come before the first move"
                    .into(),
            );
        }
        Ok(unit)
    }

    /// Whether `tool` is the probe; `None` for a number that is neither the probe's nor the turning
    /// tool's.
    pub(super) fn is_probe(&self, tool: u32) -> Option<bool> {
        let settings = self.control.settings;
        match settings.probe {
            _ if tool == settings.tool => Some(false),
            Some(probe) if tool == probe.tool => Some(true),
            _ => None,
        }
    }

    fn alarm(&mut self, line: usize, words: &Words) -> Result<Next, String> {
        if words.get('H') != Some(99.0) {
            return Err("G65 is understood with H99 (alarm) alone".into());
        }
        self.happens(line, Deed::Alarm(format!("{}", words.get('P').unwrap_or_default())));
        Ok(Next::End)
    }

    /// G10 P X: a wear offset, absolute.
    fn write_offset(&mut self, words: &Words) -> Result<(), String> {
        let number = words.get('P').filter(|p| (1.0..=99.0).contains(p)).ok_or("G10 needs P of 1 to 99")?;
        let value = words.get('X').ok_or("G10 needs X")?;
        if words.other.len() != 2 {
            return Err("G10 is understood with P and X alone".into());
        }
        self.wear.insert(number as u32, value);
        Ok(())
    }

    /// G28 U0. or W0.: the axes named go to the reference point in rapid.
    fn go_to_reference(&mut self, line: usize, words: &Words) -> Result<(), String> {
        if words.other.is_empty() || words.other.iter().any(|w| !(matches!(w.0, 'U' | 'W') && w.1 == 0.0)) {
            return Err("G28 is understood with U0. or W0. alone: other words name a point on the way".into());
        }
        let reference = self.control.reference;
        let to = Point {
            x: if words.get('U').is_some() { reference.x } else { self.at.x },
            z: if words.get('W').is_some() { reference.z } else { self.at.z },
        };
        self.go(line, to, true);
        Ok(())
    }

    pub(super) fn go(&mut self, line: usize, to: Point, rapid: bool) {
        let from = std::mem::replace(&mut self.at, to);
        if from != to {
            self.modal.scan.moves();
            self.happens(line, Deed::Move { from, to, rapid });
        }
    }

    fn tool(&mut self, line: usize, words: &Words) -> Result<(), String> {
        let Some(word) = words.get('T') else { return Ok(()) };
        let settings = self.control.settings;
        if self.control.dialect == Dialect::Linuxcnc {
            self.modal.tool_selected = Some(word as u32);
            return Ok(());
        }
        let (tool, offset) = (word as u32 / 100, word as u32 % 100);
        let Some(with_probe) = self.is_probe(tool) else {
            return Err(format!("T{word:04} calls tool {tool}, not tool {}", settings.tool));
        };
        self.with_probe = with_probe;
        if offset != 0 && offset != tool && settings.geometry_offset != Some(GeometryOffset::ByTool) {
            return Err(format!("T{word:04} takes the geometry of offset {offset}, which is not the tool's"));
        }
        let unit = settings.wear_x.unwrap_or(WearX::Diameter).diameter_per_unit();
        self.shift = self.wear.get(&offset).copied().unwrap_or(0.0) * unit;
        self.nose.offset = offset;
        self.modal.tool_called |= offset != 0;
        self.happens(line, Deed::ToolChange(self.at));
        Ok(())
    }

    /// Whether the program ends.
    pub(super) fn miscellaneous(&mut self, line: usize, m: u32) -> Result<bool, String> {
        match m {
            2 | 30 if self.nose.compensation.is_some() => {
                return Err("the program ends while the nose is compensated".into());
            }
            2 | 30 => return Ok(true),
            3 | 4 => {
                if !self.modal.speed {
                    return Err("the spindle starts without a speed".into());
                }
                self.modal.spindle = Some(m);
                self.modal.scan.moves();
            }
            5 => self.modal.spindle = None,
            6 if self.control.dialect == Dialect::Linuxcnc => {
                let Some(with_probe) = self.modal.tool_selected.and_then(|tool| self.is_probe(tool)) else {
                    return Err(format!("M6 does not change to tool {}", self.control.settings.tool));
                };
                self.with_probe = with_probe;
                // LinuxCNC stops the spindle at a tool change
                (self.modal.spindle, self.modal.tool_called) = (None, true);
                self.happens(line, Deed::ToolChange(self.at));
            }
            _ if self.control.settings.remeasure.is_some_and(|r| r.m_code == m) => {
                self.happens(line, Deed::Measure(self.at));
            }
            _ => return Err(format!("M{m:02} is not understood")),
        }
        Ok(false)
    }

    pub(super) fn travel(&mut self, line: usize, words: &Words) -> Result<(), String> {
        if words.get('U').or(words.get('W')).is_some() {
            return Err("U and W are understood with G28 alone".into());
        }
        if words.get('X').or(words.get('Z')).is_none() {
            return Ok(());
        }
        self.may_leave()?;
        let unit = self.x_unit()?;
        let motion = self.modal.motion.ok_or("a position without G00 to G03")?;
        if motion != Motion::Rapid {
            self.may_feed()?;
        }
        let to = Point {
            x: words.get('X').map_or(self.at.x, |x| x * unit + self.shift),
            z: words.get('Z').unwrap_or(self.at.z),
        };
        self.has_cut |= motion != Motion::Rapid;
        self.drive(line, to, words)
    }

    fn may_feed(&self) -> Result<(), String> {
        let m = &self.modal;
        if !m.tool_called {
            return Err("a feed before the tool is called".into());
        }
        if self.with_probe {
            return Err("a feed with the probe in the carrier".into());
        }
        if !(m.feed_per_revolution && m.feed.is_some_and(|f| f > 0.0 && f.is_finite())) {
            return Err("a feed needs F above 0, per revolution".into());
        }
        let sense = match self.control.settings.spindle {
            Some(crate::nc::machine::Spindle::M04) => 4,
            _ => 3,
        };
        if m.spindle != Some(sense) {
            return Err(format!("a feed without the spindle turning (M{sense:02})"));
        }
        Ok(())
    }
}
