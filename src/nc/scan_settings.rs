//! Data of the machine that a scan program needs: the `[nc.machine.scan]` table.
//!
//! Codes that switch something are M codes of the machine builder (`"M81"`) or, on LinuxCNC,
//! digital outputs (`"M64 P0"` on, `"M65 P0"` off).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::dialect::Dialect;
use super::error::NcError;
use crate::setting::{SettingError, require};

/// An M code, with a P word on LinuxCNC alone: `"M81"`, `"M64 P0"`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "String", into = "String")]
#[schemars(with = "String")]
pub struct MCode {
    /// Number of the code, 0 to 999.
    pub m: u32,
    /// Its P word.
    pub p: Option<u32>,
}

/// M codes that have another meaning in every program.
const TAKEN: [u32; 11] = [0, 1, 2, 3, 4, 5, 6, 19, 30, 98, 99];

impl std::str::FromStr for MCode {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("{text:?} is no M code; \"M81\" or, on linuxcnc, \"M64 P0\" is right");
        let digits = |word: &str, letter: char| {
            let digits = word.strip_prefix(letter).filter(|d| d.bytes().all(|b| b.is_ascii_digit()))?;
            digits.parse::<u32>().ok().filter(|number| *number <= 999)
        };
        let upper = text.trim().to_ascii_uppercase();
        let mut words = upper.split_whitespace();
        let m = words.next().and_then(|w| digits(w, 'M')).ok_or_else(wrong)?;
        let p = words.next().map(|w| digits(w, 'P').ok_or_else(wrong)).transpose()?;
        match words.next() {
            None => Ok(Self { m, p }),
            Some(_) => Err(wrong()),
        }
    }
}

impl TryFrom<String> for MCode {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<MCode> for String {
    fn from(code: MCode) -> Self {
        code.to_string()
    }
}

impl std::fmt::Display for MCode {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "M{:02}", self.m)?;
        self.p.map_or(Ok(()), |p| write!(f, " P{p}"))
    }
}

/// The gauge head on the carriage, as a box about the middle of its field that leaves an opening
/// for the part.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScanHead {
    /// How far it reaches from the middle of the field towards the chuck, mm.
    pub towards_chuck_mm: f64,
    /// How far it reaches towards the tailstock, mm.
    pub towards_tailstock_mm: f64,
    /// Diameter about the axis of the spindle that it leaves free, mm.
    pub opening_mm: f64,
}

/// How the carriage takes the gauge head along the part, and what is switched on the way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NcScan {
    /// Z of the middle of the field less Z of the programmed point, the turning tool's offset in
    /// force, mm.
    pub head_z_mm: f64,
    /// The head, which must pass over the part and keep clear of all that stands around it.
    pub head: ScanHead,
    /// Takes a frame or, while the spindle turns, starts the frames of a field; the code must end
    /// after the frame, or `frame_s` covers it.
    pub trigger: MCode,
    /// Resets the trigger, where it is an output that stays on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trigger_off: Option<MCode>,
    /// Opens the shutter of the head's windows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shutter_open: Option<MCode>,
    /// Closes it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shutter_close: Option<MCode>,
    /// Switches the coolant off; M09 by default.
    #[serde(default = "nine")]
    pub coolant_off: MCode,
    /// Starts the air blast; none where it is not stated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub air_on: Option<MCode>,
    /// Ends the air blast.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub air_off: Option<MCode>,
    /// Length of the air blast, s.
    #[serde(default = "three_seconds")]
    pub air_s: f64,
    /// Pause before the first frame in which what is left of the coolant runs off, s.
    #[serde(default = "three_seconds")]
    pub dwell_s: f64,
    /// Pause before a trigger in which carriage and spindle come to rest, s.
    #[serde(default = "settles")]
    pub settle_s: f64,
    /// Time of a frame after its trigger, s; with `speed_per_min` besides the turns.
    #[serde(default = "settles")]
    pub frame_s: f64,
    /// Speed at which the part turns while its frames are taken, 1/min; where it is not stated
    /// the spindle is held at every angle of the scan by `spindle_orientation`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_per_min: Option<f64>,
    /// Turns for which the frames of a field are waited for, with `speed_per_min`.
    #[serde(default = "two_turns")]
    pub turns: f64,
}

fn nine() -> MCode {
    MCode { m: 9, p: None }
}

fn three_seconds() -> f64 {
    3.0
}

fn settles() -> f64 {
    0.2
}

fn two_turns() -> f64 {
    2.0
}

impl NcScan {
    /// The codes that are stated, by their keys.
    fn codes(&self) -> Vec<(&'static str, MCode)> {
        let stated = [
            ("nc.scan.coolant_off", Some(self.coolant_off)),
            ("nc.scan.trigger", Some(self.trigger)),
            ("nc.scan.trigger_off", self.trigger_off),
            ("nc.scan.shutter_open", self.shutter_open),
            ("nc.scan.shutter_close", self.shutter_close),
            ("nc.scan.air_on", self.air_on),
            ("nc.scan.air_off", self.air_off),
        ];
        stated.into_iter().filter_map(|(key, code)| Some((key, code?))).collect()
    }

    /// Checks the table; `most_per_min` is the speed limit of the spindle.
    ///
    /// # Errors
    /// [`SettingError`] names the key.
    pub(super) fn validate(&self, most_per_min: u32) -> Result<(), SettingError> {
        let z = self.head_z_mm;
        require(z.is_finite(), "nc.scan.head_z_mm", z, "a length in mm")?;
        self.head.validate()?;
        let codes = self.codes();
        for (i, (key, code)) in codes.iter().enumerate() {
            let right = "an M code that is not M00 to M06, M19, M30, M98 or M99";
            require(!TAKEN.contains(&code.m), key, f64::from(code.m), right)?;
            if let Some((other, _)) = codes[..i].iter().find(|(k, c)| c == code && !ends_both(k, key)) {
                return Err(SettingError::at(*key, format!("{code}: {other} has this code, too")));
            }
        }
        self.pairs()?;
        // longer than a minute is a program that stands, not one that waits
        let pauses = [
            ("nc.scan.air_s", self.air_s),
            ("nc.scan.dwell_s", self.dwell_s),
            ("nc.scan.settle_s", self.settle_s),
            ("nc.scan.frame_s", self.frame_s),
        ];
        for (key, pause) in pauses {
            require((0.0..=60.0).contains(&pause), key, pause, "a time of 0 to 60 s")?;
        }
        let turns = self.turns;
        require((0.5..=1000.0).contains(&turns), "nc.scan.turns", turns, "0.5 to 1000 turns")?;
        let Some(speed) = self.speed_per_min else { return Ok(()) };
        let most = f64::from(most_per_min);
        let right = "a speed of 1 1/min to nc.speed_limit_per_min";
        require((1.0..=most).contains(&speed), "nc.scan.speed_per_min", speed, right)
    }

    /// What is switched on is switched off.
    fn pairs(&self) -> Result<(), SettingError> {
        let pairs = [
            ("nc.scan.air_off", "air_on", self.air_on, self.air_off),
            ("nc.scan.shutter_close", "shutter_open", self.shutter_open, self.shutter_close),
        ];
        for (key, other, on, off) in pairs {
            if on.is_some() != off.is_some() {
                return Err(SettingError::at(key, format!("belongs to {other}: state both or neither")));
            }
        }
        Ok(())
    }

    /// Whether the control has these codes.
    ///
    /// # Errors
    /// Names the key.
    pub(super) fn check_codes(&self, dialect: Dialect) -> Result<(), NcError> {
        for (key, code) in self.codes() {
            let (right, good) = match dialect {
                // M7 to M9 coolant, M62 to M68 outputs, M100 to M199 programs of the user
                Dialect::Linuxcnc => ("M7 to M9, M62 P… to M65 P…, or M100 to M199", linuxcnc_has(code)),
                _ => ("an M code without P", code.p.is_none()),
            };
            if !good {
                let why = format!("{code}: on {} {right} is right", dialect.as_str());
                return Err(SettingError::at(key, why).into());
            }
        }
        Ok(())
    }
}

/// Whether both keys end something: on LinuxCNC M9 ends coolant and a blast by M7 alike.
fn ends_both(a: &str, b: &str) -> bool {
    a.ends_with("_off") && b.ends_with("_off")
}

fn linuxcnc_has(code: MCode) -> bool {
    match code.m {
        7..=9 => code.p.is_none(),
        62..=65 => code.p.is_some(),
        100..=199 => true,
        _ => false,
    }
}

impl ScanHead {
    fn validate(&self) -> Result<(), SettingError> {
        let lengths = [
            ("nc.scan.head.towards_chuck_mm", self.towards_chuck_mm),
            ("nc.scan.head.towards_tailstock_mm", self.towards_tailstock_mm),
            ("nc.scan.head.opening_mm", self.opening_mm),
        ];
        for (key, value) in lengths {
            require(value > 0.0 && value.is_finite(), key, value, "a positive length in mm")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_read_as_they_are_written() {
        for (text, m, p) in [("M81", 81, None), (" m64  p0 ", 64, Some(0)), ("M09", 9, None)] {
            let code: MCode = text.parse().expect(text);
            assert_eq!((code.m, code.p), (m, p));
            assert_eq!(code.to_string().parse::<MCode>(), Ok(code));
        }
        for wrong in ["", "M", "81", "M8.1", "M81 Q1", "M81 P", "M64 P0 P1", "M1000", "G04"] {
            assert!(wrong.parse::<MCode>().is_err(), "{wrong:?}");
        }
    }
}
