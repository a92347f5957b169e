//! The differences between controls.

use serde::{Deserialize, Serialize};

use super::error::NcError;
use super::machine::{ChangePosition, Spindle, SpindleOrientation};
use super::sinumerik;

/// The control that a program is written for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Dialect {
    /// Fanuc 0i-T and alike: G-code system A, custom macro B.
    Fanuc,
    /// LinuxCNC 2.9.
    Linuxcnc,
    /// GSK 980TDi.
    Gsk,
    /// Siemens SINUMERIK 840D and alike, in its own language.
    Sinumerik,
}

/// Longest alarm text that a Fanuc screen shows.
const LONGEST_ALARM: usize = 26;

/// Time limit of an orientation on LinuxCNC, s: a lathe spindle takes one or two seconds.
const ORIENT_LIMIT_S: f64 = 10.0;

impl Dialect {
    /// All dialects.
    pub(crate) const ALL: [Self; 4] = [Self::Fanuc, Self::Linuxcnc, Self::Gsk, Self::Sinumerik];

    /// Dialects with macro variables, in which programs compute and probe.
    pub(crate) const WITH_MACROS: [Self; 3] = [Self::Fanuc, Self::Linuxcnc, Self::Gsk];

    /// The word used on the command line.
    pub(crate) fn as_str(self) -> &'static str {
        match self {
            Self::Fanuc => "fanuc",
            Self::Linuxcnc => "linuxcnc",
            Self::Gsk => "gsk",
            Self::Sinumerik => "sinumerik",
        }
    }

    /// Whether programs with macro variables are written for it: those that compute a line, and
    /// those that probe.
    pub(super) fn check_macros(self) -> Result<(), NcError> {
        if Self::WITH_MACROS.contains(&self) {
            return Ok(());
        }
        Err(NcError::Plan(format!(
            "{} has the offsets of the run alone (--form knots): programs that compute a line or probe (nc.probe) are written for fanuc, \
             linuxcnc and gsk",
            self.as_str()
        )))
    }

    /// Least increment of X as a diameter, mm, and its decimals: what a number is rounded to.
    pub(crate) fn x_decimals(self) -> usize {
        match self {
            // IS-B, the usual increment system; 980TDi in its .001 mm setting
            Self::Fanuc | Self::Gsk => 3,
            // MD10200, 1000 increments a millimetre by default
            Self::Sinumerik => 3,
            Self::Linuxcnc => 5,
        }
    }

    /// Least and largest nose radius of an offset, mm: seven digits in the usual increments of a
    /// Fanuc, taken for all of them.
    pub(crate) fn nose_register_mm(self) -> (f64, f64) {
        (0.001, 999.999)
    }

    /// Whether a program can write the wear register.
    pub(crate) fn has_wear_register(self) -> bool {
        self == Self::Fanuc
    }

    pub(super) fn comment(self, text: &str) -> String {
        match self {
            Self::Sinumerik => format!("; {}", plain(text)),
            _ => format!("({})", plain(text)),
        }
    }

    /// A position of an axis; `text` is a number or a variable.
    pub(super) fn axis(self, letter: char, text: &str) -> String {
        match self {
            Self::Sinumerik => format!("{letter}={}", sinumerik::value(text)),
            _ => format!("{letter}{text}"),
        }
    }

    fn axis_at(self, letter: char, value: f64) -> String {
        self.axis(letter, &number(value, 3))
    }

    /// A value into a variable.
    pub(super) fn assign(self, variable: u32, value: &str) -> Vec<String> {
        match self {
            Self::Sinumerik => vec![
                "STOPRE".to_owned(),
                format!("{}={}", sinumerik::variable(variable), sinumerik::value(value)),
            ],
            _ => vec![format!("#{variable}={value}")],
        }
    }

    /// First lines: program number and preparatory codes.
    pub(super) fn start(self, program: u32, title: &str) -> Vec<String> {
        let title = self.comment(title);
        match self {
            // system A: G99 is feed per revolution, diameters by parameter
            Self::Fanuc | Self::Gsk => {
                vec!["%".into(), format!("O{program:04} {title}"), "G18 G21 G40 G99".into()]
            }
            Self::Linuxcnc => {
                // no G49: the tool that is in use keeps its offset until the change position is
                // reached
                vec!["%".into(), title, "G7 G18 G21 G40 G80 G90 G95".into()]
            }
            Self::Sinumerik => {
                let name = self.comment(&format!("SG{program:04}.MPF"));
                vec![name, title, "G18 G40 G54 G710 G90 G95 DIAMON".into()]
            }
        }
    }

    /// Constant cutting speed under a speed limit, spindle on.
    pub(super) fn spindle(self, speed_m_per_min: f64, limit: u32, sense: Spindle) -> Vec<String> {
        let speed = speed_m_per_min.round();
        let code = match sense {
            Spindle::M03 => 3,
            Spindle::M04 => 4,
        };
        match self {
            Self::Fanuc | Self::Gsk => vec![format!("G50 S{limit}"), format!("G96 S{speed:.0} M{code:02}")],
            Self::Linuxcnc => vec![format!("G96 D{limit}. S{speed_m_per_min:.1} M{code}")],
            Self::Sinumerik => vec![format!("G96 S{speed:.0} LIMS={limit} M{code}")],
        }
    }

    /// A constant spindle speed, 1/min, spindle on.
    pub(super) fn constant_speed(self, speed_per_min: f64, sense: Spindle) -> String {
        let speed = speed_per_min.round();
        let code = match sense {
            Spindle::M03 => 3,
            Spindle::M04 => 4,
        };
        match self {
            Self::Fanuc | Self::Gsk => format!("G97 S{speed:.0} M{code:02}"),
            Self::Linuxcnc | Self::Sinumerik => format!("G97 S{speed:.0} M{code}"),
        }
    }

    /// A pause, rounded up to a millisecond.
    pub(super) fn dwell(self, seconds: f64) -> String {
        // a pause of 0.2 s is 200 ms, not 201 for the sake of its last binary digit
        let ms = (seconds * 1e3 - 1e-6).ceil().max(0.0);
        match self {
            // P is in milliseconds
            Self::Fanuc | Self::Gsk => format!("G04 P{ms:.0}"),
            Self::Linuxcnc => format!("G04 P{}", number(ms * 1e-3, 3)),
            Self::Sinumerik => format!("G4 F{}", sinumerik::value(&number(ms * 1e-3, 3))),
        }
    }

    /// One more in a variable that counts.
    pub(super) fn count(self, variable: u32) -> Vec<String> {
        match self {
            Self::Sinumerik => {
                let r = sinumerik::variable(variable);
                vec!["STOPRE".to_owned(), format!("{r}={r}+1")]
            }
            _ => vec![format!("#{variable}=[#{variable}+1.]")],
        }
    }

    /// Tool call, which also activates offset `offset` where the control has offset numbers.
    pub(super) fn tool(self, tool: u32, offset: u32) -> Vec<String> {
        match self {
            Self::Fanuc | Self::Gsk => vec![format!("T{tool:02}{offset:02}")],
            Self::Linuxcnc => vec![format!("T{tool} M6"), "G43".into()],
            Self::Sinumerik => vec![format!("T{tool} D1")],
        }
    }

    /// Whether the change position is the machine's reference point (G28), which no offset moves.
    pub(super) fn changes_at_reference(self) -> bool {
        self != Self::Linuxcnc
    }

    /// What the reference point is called in a program's head.
    pub(super) fn reference_words(self) -> &'static str {
        match self {
            Self::Sinumerik => "fixed point 1 of G75",
            _ => "reference point G28",
        }
    }

    /// To the change position, X alone and then Z.
    pub(super) fn to_change(self, change: ChangePosition) -> Vec<String> {
        match self {
            Self::Fanuc | Self::Gsk => vec!["G28 U0.".into(), "G28 W0.".into()],
            Self::Sinumerik => vec!["G75 FP=1 X1=0".into(), "G75 FP=1 Z1=0".into()],
            Self::Linuxcnc => {
                vec![format!("G00 X{}", number(change.x_mm, 3)), format!("Z{}", number(change.z_mm, 3))]
            }
        }
    }

    /// To the change position out of a bore, Z alone and then X.
    pub(super) fn to_change_out_of_bore(self, change: ChangePosition) -> Vec<String> {
        match self {
            Self::Fanuc | Self::Gsk => vec!["G28 W0.".into(), "G28 U0.".into()],
            Self::Sinumerik => vec!["G75 FP=1 Z1=0".into(), "G75 FP=1 X1=0".into()],
            Self::Linuxcnc => {
                vec![format!("G00 Z{}", number(change.z_mm, 3)), format!("X{}", number(change.x_mm, 3))]
            }
        }
    }

    /// From the change position before a bore to the clear diameter, and along the axis to `z`.
    pub(super) fn approach_into_bore(self, change: ChangePosition, z: f64, clear_mm: f64) -> Vec<String> {
        let mut lines = Vec::new();
        if !self.changes_at_reference() {
            // the offset of the tool just called acts from here on
            lines.push(format!("G00 Z{}", number(change.z_mm, 3)));
        }
        lines.push(format!("G00 {}", self.axis_at('X', clear_mm)));
        lines.push(self.axis_at('Z', z));
        lines
    }

    /// From the change position, where the tool was called, to the clear diameter above `z`.
    pub(super) fn approach(self, change: ChangePosition, z: f64, clear_mm: f64) -> Vec<String> {
        let mut lines = Vec::new();
        if !self.changes_at_reference() {
            // the offset of the tool just called acts from here on
            lines.push(format!("G00 X{}", number(change.x_mm, 3)));
        }
        lines.push(format!("G00 {}", self.axis_at('Z', z)));
        lines.push(self.axis_at('X', clear_mm));
        lines
    }

    /// Where to look up `wear_x`. Numbers of Fanuc's parameters as in its parameter manuals for
    /// lathes.
    pub(super) fn look_up_wear_x(self) -> &'static str {
        match self {
            Self::Gsk => {
                "wear_x = \"diameter\" or \"radius\" (how X of a tool offset is taken: bit ORC of the state parameters; its \
                 number differs between versions, see the control's manual)"
            }
            _ => {
                "wear_x = \"diameter\" or \"radius\" (how X of a tool offset is taken: parameter 5004 bit 1, ORC; 0 is \
                 diameter, 1 radius)"
            }
        }
    }

    /// Where to look up `geometry_offset`.
    pub(super) fn look_up_geometry_offset(self) -> &'static str {
        match self {
            Self::Gsk => {
                "geometry_offset = \"by_tool\" or \"by_offset\" (which digits of T0101 choose the tool's offset: chapter on \
                 the tool function in the control's manual)"
            }
            _ => {
                "geometry_offset = \"by_tool\" or \"by_offset\" (which digits of T0116 choose the geometry offset: \
                 parameter 5002 bit 1, LGN; 0 is by_offset, 1 by_tool)"
            }
        }
    }

    /// Where to look up `spindle`.
    pub(super) fn look_up_spindle(self) -> &'static str {
        "spindle = \"M03\" or \"M04\" (the sense in which the part meets the tool's edge: given by where the turret \
         stands, in the machine builder's manual)"
    }

    /// Spindle off.
    pub(super) fn spindle_off(self) -> &'static str {
        match self {
            Self::Fanuc | Self::Gsk => "M05",
            Self::Linuxcnc | Self::Sinumerik => "M5",
        }
    }

    /// The spindle turns to an angle and is held there; LinuxCNC waits for it, at most the seconds
    /// of Q.
    pub(super) fn orient(self, orientation: SpindleOrientation, opposite: bool) -> String {
        self.orient_to(orientation, orientation.angle(opposite))
    }

    /// The same to any angle, degrees.
    pub(super) fn orient_to(self, orientation: SpindleOrientation, angle_deg: f64) -> String {
        let angle = number(angle_deg, 3);
        match self {
            Self::Fanuc | Self::Gsk => format!("M{:02} R{angle}", orientation.m_code),
            Self::Linuxcnc => format!("M19 R{angle} Q{ORIENT_LIMIT_S:.0}."),
            Self::Sinumerik => format!("SPOS={}", sinumerik::value(&angle)),
        }
    }

    /// Feeds are mm/min from here on.
    pub(super) fn feed_per_minute(self) -> &'static str {
        match self {
            Self::Fanuc | Self::Gsk => "G98",
            Self::Linuxcnc | Self::Sinumerik => "G94",
        }
    }

    /// Feeds are mm per revolution from here on.
    pub(super) fn feed_per_revolution(self) -> &'static str {
        match self {
            Self::Fanuc | Self::Gsk => "G99",
            Self::Linuxcnc | Self::Sinumerik => "G95",
        }
    }

    /// The code of a move that ends when the probe touches.
    pub(super) fn probing_move(self) -> &'static str {
        match self {
            Self::Fanuc | Self::Gsk => "G31",
            Self::Linuxcnc => "G38.2",
            // refused by `check_macros` before a program gets here
            Self::Sinumerik => "MEAS=1 G1",
        }
    }

    /// Where to look up `probe.skip_variable`.
    pub(super) fn look_up_skip_variable(self) -> &'static str {
        "probe.skip_variable = the # variable in which G31 leaves X of the touch (table of system variables in the \
         control's manual)"
    }

    /// Stops with an alarm where `left op right` holds; `label` is unique in the program.
    pub(super) fn alarm_if(self, label: u32, condition: (&str, &str, &str), text: &str) -> Vec<String> {
        let (left, op, right) = condition;
        let text: String = plain(text).chars().take(LONGEST_ALARM).collect();
        match self {
            Self::Fanuc => vec![format!("IF[{left} {op} {right}]THEN #3000={}({text})", label % 200)],
            // a #3000 would be a plain variable here
            Self::Linuxcnc => vec![
                format!("o{label} if [{left} {op} {right}]"),
                format!("(ABORT,{text})"),
                format!("o{label} endif"),
            ],
            Self::Gsk => vec![
                format!("IF [{left} {} {right}] GOTO {label}", negated(op)),
                format!("G65 H99 P{} ({text})", label % 100),
                format!("N{label}"),
            ],
            Self::Sinumerik => sinumerik::alarm_if(label, (left, negated(op), right), &text),
        }
    }

    /// Last lines.
    pub(super) fn end(self) -> Vec<String> {
        let stop = match self {
            Self::Fanuc | Self::Gsk => ["M05", "M30", "%"],
            Self::Linuxcnc => ["M5", "M2", "%"],
            Self::Sinumerik => return vec!["M5".to_owned(), "M30".to_owned()],
        };
        stop.map(str::to_owned).to_vec()
    }
}

impl std::str::FromStr for Dialect {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|d| d.as_str() == word).ok_or_else(|| {
            format!("no dialect is called {word:?}; there are fanuc, linuxcnc, gsk, sinumerik")
        })
    }
}

fn negated(op: &str) -> &'static str {
    match op {
        "EQ" => "NE",
        "NE" => "EQ",
        "GT" => "LE",
        "LT" => "GE",
        "GE" => "LT",
        _ => "GT",
    }
}

/// Upper-case ASCII without characters that would end a comment.
fn plain(text: &str) -> String {
    let keep = |c: char| if c.is_ascii_alphanumeric() || " .,:-+=/".contains(c) { c } else { ' ' };
    text.chars().map(keep).collect::<String>().to_ascii_uppercase()
}

/// A number with a decimal point, rounded to `decimals`: `25.`, `-0.04`, never `-0.`.
pub(super) fn number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').to_owned() } else { text + "." };
    if text == "-0." { "0.".into() } else { text }
}
