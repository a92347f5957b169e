//! Re-measurement after the finishing pass and the alarm (paper 000): is the part within its
//! limits?
//!
//! Every station is judged by the rule of [`crate::conformity`]: it conforms, or lies beyond a
//! limit, with the stated probability; otherwise it is undecided.

use super::decision::{Decision, DecisionRule, Estimate, MANY};
use crate::profile::{DiameterProfile, Station};

/// Limits of size and the decision rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Limits {
    /// Lower limit of the diameter, mm.
    pub lower_mm: f64,
    /// Upper limit of the diameter, mm.
    pub upper_mm: f64,
    /// The rule, with its probability.
    pub rule: DecisionRule,
}

/// Verdict on a station.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Conformity {
    /// Proven within the limits.
    Conforms,
    /// Proven below the lower limit: scrap.
    Undersize,
    /// Proven above the upper limit: another pass can correct it.
    Oversize,
    /// Too close to a limit for its uncertainty.
    Undecided,
    /// No reading.
    Unmeasured,
    /// Not judged: its section has no tolerance.
    NoTolerance,
}

/// Verdict on a part.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub(crate) struct Verdict {
    /// Every station, in the profile's order.
    pub stations: Vec<Conformity>,
    /// Stations conforming.
    pub conforming: usize,
    /// Text of the alarm; `None` where every station conforms.
    pub alarm: Option<String>,
}

/// Verdict on a whole part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum PartConformity {
    /// Proven within the limits at every station.
    Conforms,
    /// Nowhere proven outside, but not proven inside everywhere: too close to a limit, or not
    /// measured.
    NotProven,
    /// Proven outside at a station.
    Violates,
}

impl Verdict {
    /// The verdict as one value.
    pub(crate) fn part(&self) -> PartConformity {
        let any = |what: Conformity| self.stations.contains(&what);
        if any(Conformity::Undersize) || any(Conformity::Oversize) {
            PartConformity::Violates
        } else if self.alarm.is_some() || self.judged() == 0 {
            PartConformity::NotProven
        } else {
            PartConformity::Conforms
        }
    }

    /// Stations that were judged.
    pub(crate) fn judged(&self) -> usize {
        self.stations.iter().filter(|s| **s != Conformity::NoTolerance).count()
    }

    /// The verdict in words.
    pub(crate) fn words(&self) -> String {
        let why = self.alarm.as_deref().unwrap_or("there is no station");
        match self.part() {
            PartConformity::Conforms => {
                "in tolerance at every station, proven with its uncertainty".to_owned()
            }
            PartConformity::NotProven => format!("NOT PROVEN IN TOLERANCE: {why}"),
            PartConformity::Violates => format!("OUT OF TOLERANCE: {why}"),
        }
    }
}

/// Judges a re-measured part.
pub(crate) fn judge(measured: &DiameterProfile, limits: &Limits) -> Verdict {
    judge_sections(measured, &|_| Some(*limits))
}

/// Judges a re-measured part whose limits depend on z (mm); stations without limits are not judged.
pub(crate) fn judge_sections(
    measured: &DiameterProfile,
    limits_at: &dyn Fn(f64) -> Option<Limits>,
) -> Verdict {
    let judged =
        |s: &Station| limits_at(s.z_mm).map_or(Conformity::NoTolerance, |limits| judge_station(s, &limits));
    let stations: Vec<Conformity> = measured.stations.iter().map(judged).collect();
    let of = stations.iter().filter(|s| **s != Conformity::NoTolerance).count();
    let count = |what: Conformity| stations.iter().filter(|s| **s == what).count();
    let conforming = count(Conformity::Conforms);
    let worst = [
        (Conformity::Undersize, "undersize"),
        (Conformity::Oversize, "oversize"),
        (Conformity::Unmeasured, "not measured"),
        (Conformity::Undecided, "too close to a limit for its uncertainty"),
    ];
    let parts: Vec<String> = worst
        .iter()
        .filter(|(what, _)| count(*what) > 0)
        .map(|(what, text)| {
            let first =
                stations.iter().position(|s| s == what).map_or(f64::NAN, |i| measured.stations[i].z_mm);
            format!("{} of {of} stations {text} (first at z = {first} mm)", count(*what))
        })
        .collect();
    Verdict { conforming, alarm: (!parts.is_empty()).then(|| parts.join("; ")), stations }
}

fn judge_station(station: &Station, limits: &Limits) -> Conformity {
    let Some(d) = station.reading.value() else {
        return Conformity::Unmeasured;
    };
    let estimate = Estimate::of(&d, station.freedom.unwrap_or(MANY));
    match limits.rule.decide(&estimate, limits.lower_mm, limits.upper_mm) {
        Decision::Conforms => Conformity::Conforms,
        Decision::TooSmall => Conformity::Undersize,
        Decision::TooLarge => Conformity::Oversize,
        Decision::NotProven => Conformity::Undecided,
    }
}
