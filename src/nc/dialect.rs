//! What differs from control to control.

use serde::{Deserialize, Serialize};

/// The control a program is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Dialect {
    /// Fanuc 0i-T and alike: G-code system A, custom macro B.
    Fanuc,
    /// LinuxCNC 2.9.
    Linuxcnc,
    /// GSK 980TDi.
    Gsk,
}

/// Longest alarm text that a Fanuc screen shows.
const LONGEST_ALARM: usize = 26;

impl Dialect {
    /// All dialects.
    pub const ALL: [Self; 3] = [Self::Fanuc, Self::Linuxcnc, Self::Gsk];

    /// The word used on the command line.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Fanuc => "fanuc",
            Self::Linuxcnc => "linuxcnc",
            Self::Gsk => "gsk",
        }
    }

    /// Least increment of X as a diameter, mm, and its decimals: what a number is rounded to.
    pub fn x_decimals(self) -> usize {
        match self {
            // IS-B, the usual increment system; 980TDi in its .001 mm setting
            Self::Fanuc | Self::Gsk => 3,
            Self::Linuxcnc => 5,
        }
    }

    /// Whether the mean of a correction goes into the wear register.
    pub fn has_wear_register(self) -> bool {
        self == Self::Fanuc
    }

    /// Suffix of the file.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Linuxcnc => "ngc",
            Self::Fanuc | Self::Gsk => "nc",
        }
    }

    pub(super) fn comment(self, text: &str) -> String {
        format!("({})", plain(text))
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
                vec!["%".into(), title, "G7 G18 G21 G40 G49 G80 G90 G95".into()]
            }
        }
    }

    /// Constant cutting speed under a speed limit, spindle on.
    pub(super) fn spindle(self, speed_m_per_min: f64, limit: u32) -> Vec<String> {
        let speed = speed_m_per_min.round();
        match self {
            Self::Fanuc | Self::Gsk => vec![format!("G50 S{limit}"), format!("G96 S{speed:.0} M03")],
            Self::Linuxcnc => vec![format!("G96 D{limit}. S{speed_m_per_min:.1} M3")],
        }
    }

    /// Tool call; on a Fanuc it makes the wear offset act.
    pub(super) fn tool(self, tool: u32, wear: u32) -> Vec<String> {
        match self {
            Self::Fanuc => vec![format!("T{tool:02}{wear:02}")],
            Self::Gsk => vec![format!("T{tool:02}{tool:02}")],
            Self::Linuxcnc => vec![format!("T{tool} M6"), "G43".into()],
        }
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
        }
    }

    /// Last lines.
    pub(super) fn end(self) -> Vec<String> {
        let stop = match self {
            Self::Fanuc | Self::Gsk => ["M05", "M30", "%"],
            Self::Linuxcnc => ["M5", "M2", "%"],
        };
        stop.map(str::to_owned).to_vec()
    }
}

impl std::str::FromStr for Dialect {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|d| d.as_str() == word)
            .ok_or_else(|| format!("no dialect is called {word:?}; there are fanuc, linuxcnc, gsk"))
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

/// Upper-case ASCII without what would end a comment.
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
