//! What of a frame was judged, and how.

use serde::ser::SerializeMap as _;
use serde::{Serialize, Serializer};

use crate::conformity::Judgement;
use crate::profile::{Diameter, Reading, Reason};

/// The word of a frame that has no judgement although a tolerance is given.
const NOT_PROVEN: &str = "not_proven";

/// The judgement of a frame. Its JSON is the judgement's word, or null where nothing is proven.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing was to be judged.
    #[default]
    NotJudged,
    /// A size was not measured, or may be another part's: it is not proven good.
    NotProven,
    /// The judgement of the worst value.
    Is(Judgement),
}

impl Verdict {
    /// The judgement, where a value has one.
    pub fn judgement(self) -> Option<Judgement> {
        match self {
            Self::Is(judgement) => Some(judgement),
            Self::NotJudged | Self::NotProven => None,
        }
    }

    /// Its word in tables and files: empty where nothing was to be judged.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::NotJudged => "",
            Self::NotProven => NOT_PROVEN,
            Self::Is(judgement) => judgement.as_str(),
        }
    }

    /// How far from good: 0 good or not judged, 1 not proven, 2 proven bad.
    pub(crate) fn severity(self) -> u8 {
        match self {
            Self::NotJudged => 0,
            Self::NotProven => 1,
            Self::Is(judgement) => judgement.severity(),
        }
    }

    /// Whether nothing was to be judged.
    pub(crate) fn is_absent(&self) -> bool {
        *self == Self::NotJudged
    }
}

impl Serialize for Verdict {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.judgement().serialize(serializer)
    }
}

/// The value that decided the judgement of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judged {
    /// `largest`, `station`, `local`, `mean`, `average`, or `frame` for the whole.
    pub what: &'static str,
    /// Its z, mm; none for the whole frame.
    pub z_mm: Option<f64>,
    /// Value or gap.
    pub by: Deciding,
}

/// A value, or the gap in its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Deciding {
    /// A value.
    Value {
        /// The diameter, mm.
        diameter: Diameter,
        /// Effective degrees of freedom of its u, infinite for many.
        freedom: f64,
        /// Guard band, mm; `None` where it leaves no acceptance zone.
        guard_mm: Option<f64>,
    },
    /// No value.
    Gap(Reason),
}

impl Serialize for Judged {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("what", self.what)?;
        if let Some(z_mm) = self.z_mm {
            map.serialize_entry("z_mm", &z_mm)?;
        }
        match self.by {
            Deciding::Gap(reason) => map.serialize_entry("flag", reason.as_str())?,
            Deciding::Value { diameter, freedom, guard_mm } => {
                map.serialize_entry("d_mm", &diameter.d_mm)?;
                map.serialize_entry("u_mm", &diameter.u_mm())?;
                map.serialize_entry("effective_freedom", &freedom.is_finite().then_some(freedom))?;
                map.serialize_entry("guard_mm", &guard_mm)?;
            }
        }
        map.end()
    }
}

/// One station of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StationResult {
    /// Its middle, mm.
    pub z_mm: f64,
    /// Its mean diameter, or a gap.
    pub reading: Reading,
    /// Its judgement, where single sizes are judged.
    pub judged: Option<StationJudgement>,
}

/// Judgement of a station.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StationJudgement {
    /// `None` for a gap.
    pub judgement: Option<Judgement>,
    /// Guard band, mm; `None` for a gap, or where it leaves no acceptance zone.
    pub guard_mm: Option<f64>,
}

impl Serialize for StationResult {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("z_mm", &self.z_mm)?;
        match &self.reading {
            Reading::Value(d) => {
                map.serialize_entry("d_mm", &d.d_mm)?;
                map.serialize_entry("u_random_mm", &d.u_random_mm)?;
                map.serialize_entry("u_common_mm", &d.u_common_mm)?;
            }
            Reading::Gap(reason) => map.serialize_entry("flag", reason.as_str())?,
        }
        if let Some(StationJudgement { judgement, guard_mm }) = &self.judged {
            map.serialize_entry("judgement", judgement)?;
            map.serialize_entry("guard_mm", guard_mm)?;
        }
        map.end()
    }
}
