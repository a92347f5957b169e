//! What is stored.

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use super::utc::Utc;
use crate::source::hexadecimal;

/// What a document that is stored by its name is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum EntryKind {
    /// A part: its drawing.
    Part,
    /// A tool: its geometry.
    Tool,
    /// A calibration; its key is the digest of its document.
    Calibration,
    /// What a page makes programs for: an outline, or a model with its card.
    Product,
    /// An insert in its holder, with what was measured of it.
    Insert,
    /// A machine: control and limits.
    Machine,
    /// A program that was made, with what it was made from.
    Program,
}

impl EntryKind {
    pub(super) fn as_str(self) -> &'static str {
        match self {
            Self::Part => "part",
            Self::Tool => "tool",
            Self::Calibration => "calibration",
            Self::Product => "product",
            Self::Insert => "insert",
            Self::Machine => "machine",
            Self::Program => "program",
        }
    }
}

/// A document under a name; a new one of the same name takes its place, the old one stays in the
/// audit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Entry {
    /// What it is of.
    pub kind: EntryKind,
    /// Its name, unique in its kind.
    pub key: String,
    /// JSON.
    pub document: String,
}

/// A run: a job that is cut and measured, or one call of `measure`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct RunToStore {
    /// What identifies it: the hash of its resolved config with the seed, or of a call.
    pub key: String,
    /// `run` or `measure`.
    pub origin: String,
    /// Its name.
    pub name: String,
    /// Key of its part.
    pub part: Option<String>,
    /// Key of its tool.
    pub tool: Option<String>,
    /// Key of its calibration.
    pub calibration: Option<String>,
    /// Its resolved config, or the settings of the call.
    pub config: String,
}

/// A station after a pass, or the diameter of a frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct StationToStore {
    /// Place along the part, mm.
    pub z_mm: Option<f64>,
    /// Nominal diameter, mm.
    pub nominal_mm: Option<f64>,
    /// Diameter, mm; none of a gap.
    pub d_mm: Option<f64>,
    /// Its standard uncertainty, mm.
    pub u_mm: Option<f64>,
    /// Reason of a gap.
    pub flag: Option<String>,
}

/// A finished pass.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PassToStore {
    /// Its number in the run, from 1.
    pub pass: u32,
    /// Name of its frame, of a measurement.
    pub name: Option<String>,
    /// Its stations, along the part.
    pub stations: Vec<StationToStore>,
    /// Largest |measured - nominal|, mm.
    pub max_abs_error_mm: Option<f64>,
    /// What was decided after it: the word, why, and the offsets that it was cut with, mm of
    /// diameter, as JSON.
    pub decision: Option<[String; 3]>,
    /// An alarm.
    pub alarm: Option<String>,
}

impl PassToStore {
    /// Digest of what was measured and decided, without the time: the same for the same pass.
    pub(super) fn digest(&self) -> String {
        let mut hash = PassDigest(Sha256::new());
        hash.0.update(self.pass.to_le_bytes());
        hash.text(self.name.as_deref());
        for s in &self.stations {
            [s.z_mm, s.nominal_mm, s.d_mm, s.u_mm].into_iter().for_each(|value| hash.number(value));
            hash.text(s.flag.as_deref());
        }
        hash.number(self.max_abs_error_mm);
        for k in 0..3 {
            hash.text(self.decision.as_ref().map(|decision| decision[k].as_str()));
        }
        hash.text(self.alarm.as_deref());
        hexadecimal(&hash.0.finalize())
    }
}

/// SHA-256 over a pass: numbers as their bits, texts with their length.
struct PassDigest(Sha256);

impl PassDigest {
    fn text(&mut self, text: Option<&str>) {
        // a text that is absent has a length that none has
        self.0.update(text.map_or(u64::MAX, |t| t.len() as u64).to_le_bytes());
        self.0.update(text.unwrap_or_default());
    }

    fn number(&mut self, value: Option<f64>) {
        self.0.update([u8::from(value.is_some())]);
        self.0.update(value.unwrap_or_default().to_bits().to_le_bytes());
    }
}

/// A change, before it is a link of the chain.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Change<'a> {
    pub utc: Utc,
    pub who: &'a str,
    pub what: &'a str,
    pub key: &'a str,
    pub old: Option<&'a str>,
    pub new: Option<&'a str>,
}
