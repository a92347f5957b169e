//! Re-measurement after the finishing pass and the alarm (paper 000): is the part within its limits?
//!
//! Decision rule of ISO 14253-1: with the expanded uncertainty U = k·u a station conforms where D ± U lies within the
//! limits, does not conform where D ± U lies outside, and is undecided in between.

use crate::profile::{DiameterProfile, Reading};

/// Limits of size and the coverage factor of the decision.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Limits {
    /// Lower limit of the diameter, mm.
    pub lower_mm: f64,
    /// Upper limit of the diameter, mm.
    pub upper_mm: f64,
    /// k of U = k·u; 2 for about 95 %.
    pub coverage: f64,
}

/// What is known of a station.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Conformity {
    /// Proven within the limits.
    Conforms,
    /// Proven below the lower limit: scrap.
    Undersize,
    /// Proven above the upper limit: another pass can mend it.
    Oversize,
    /// Within U of a limit.
    Undecided,
    /// No reading.
    Unmeasured,
}

/// Verdict on a part.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Verdict {
    /// Every station, in the profile's order.
    pub stations: Vec<Conformity>,
    /// Stations conforming.
    pub conforming: usize,
    /// Text of the alarm; `None` where every station conforms.
    pub alarm: Option<String>,
}

/// What is known of a whole part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PartConformity {
    /// Proven within the limits at every station.
    Conforms,
    /// Nowhere proven outside, but not proven inside everywhere: within U of a limit, or not measured.
    NotProven,
    /// Proven outside at a station.
    Violates,
}

impl Verdict {
    /// The verdict in one word.
    pub fn part(&self) -> PartConformity {
        let any = |what: Conformity| self.stations.contains(&what);
        if any(Conformity::Undersize) || any(Conformity::Oversize) {
            PartConformity::Violates
        } else if self.alarm.is_some() || self.stations.is_empty() {
            PartConformity::NotProven
        } else {
            PartConformity::Conforms
        }
    }

    /// The verdict for people.
    pub fn words(&self) -> String {
        let why = self.alarm.as_deref().unwrap_or("there is no station");
        match self.part() {
            PartConformity::Conforms => {
                "in tolerance at every station, proven with the expanded uncertainty".to_owned()
            }
            PartConformity::NotProven => format!("NOT PROVEN IN TOLERANCE: {why}"),
            PartConformity::Violates => format!("OUT OF TOLERANCE: {why}"),
        }
    }
}

/// Judges a re-measured part.
pub fn judge(measured: &DiameterProfile, limits: &Limits) -> Verdict {
    let stations: Vec<Conformity> =
        measured.stations.iter().map(|s| judge_station(&s.reading, limits)).collect();
    let count = |what: Conformity| stations.iter().filter(|s| **s == what).count();
    let conforming = count(Conformity::Conforms);
    let worst = [
        (Conformity::Undersize, "undersize"),
        (Conformity::Oversize, "oversize"),
        (Conformity::Unmeasured, "not measured"),
        (Conformity::Undecided, "within the expanded uncertainty of a limit"),
    ];
    let parts: Vec<String> = worst
        .iter()
        .filter(|(what, _)| count(*what) > 0)
        .map(|(what, text)| {
            let first =
                stations.iter().position(|s| s == what).map_or(f64::NAN, |i| measured.stations[i].z_mm);
            format!("{} of {} stations {text} (first at z = {first} mm)", count(*what), stations.len())
        })
        .collect();
    Verdict { conforming, alarm: (!parts.is_empty()).then(|| parts.join("; ")), stations }
}

fn judge_station(reading: &Reading, limits: &Limits) -> Conformity {
    let Some(d) = reading.value() else {
        return Conformity::Unmeasured;
    };
    let expanded = limits.coverage * d.u_mm();
    let (low, high) = (d.d_mm - expanded, d.d_mm + expanded);
    if low >= limits.lower_mm && high <= limits.upper_mm {
        Conformity::Conforms
    } else if high < limits.lower_mm {
        Conformity::Undersize
    } else if low > limits.upper_mm {
        Conformity::Oversize
    } else {
        Conformity::Undecided
    }
}
