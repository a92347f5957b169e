//! Judgement HH / HI / GO / LO / LL by the [`DecisionRule`].
//!
//! | limits | HH | HI | GO | LO | LL |
//! |---|---|---|---|---|---|
//! | a tolerance | violation proven | not proven either way, above its middle | conformity proven |
//! not proven, below | violation proven |
//! | four limits | not proven within ll and hh, above | within them, not proven within lo and hi,
//! above | proven between lo and hi | below | below |

use super::decision::{Decision, DecisionRule, Estimate};
use super::error::JudgementError;
use crate::profile::{Diameter, Reading, Reason};
use serde::{Deserialize, Serialize};

/// The classes of a reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Judgement {
    /// Far too small.
    LL,
    /// Small, or not proven large enough.
    LO,
    /// Good, proven.
    GO,
    /// Large, or not proven small enough.
    HI,
    /// Far too large.
    HH,
}

impl Judgement {
    /// The word that stands for it in tables and files.
    pub(crate) fn as_str(self) -> &'static str {
        match self {
            Self::LL => "LL",
            Self::LO => "LO",
            Self::GO => "GO",
            Self::HI => "HI",
            Self::HH => "HH",
        }
    }

    /// What it means where the limits are a tolerance's.
    pub(crate) fn meaning(self) -> &'static str {
        match self {
            Self::LL => "proven to lie below the lower limit",
            Self::LO => "proven neither good nor bad, below the middle of the tolerance",
            Self::GO => "proven to lie within both limits",
            Self::HI => "proven neither good nor bad, above the middle of the tolerance",
            Self::HH => "proven to lie above the upper limit",
        }
    }

    /// All of them, from the largest sizes to the smallest.
    pub(crate) const ALL: [Self; 5] = [Self::HH, Self::HI, Self::GO, Self::LO, Self::LL];

    /// How far from good: 0 good, 1 not proven, 2 proven bad.
    pub(crate) fn severity(self) -> u8 {
        match self {
            Self::GO => 0,
            Self::LO | Self::HI => 1,
            Self::LL | Self::HH => 2,
        }
    }
}

/// Limits of size, mm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Limits {
    /// A tolerance: HI and LO are the uncertainty zones of ISO 14253-1.
    Tolerance {
        /// Lower limit of size, mm.
        lower_mm: f64,
        /// Upper limit of size, mm.
        upper_mm: f64,
    },
    /// Four limits of a comparator: GO between lo and hi, LO and HI out to ll and hh (to be
    /// reworked, or a warning).
    Four {
        /// Below: LL, mm.
        ll_mm: f64,
        /// Below: LO, mm.
        lo_mm: f64,
        /// Above: HI, mm.
        hi_mm: f64,
        /// Above: HH, mm.
        hh_mm: f64,
    },
}

/// Limits with a decision rule, checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Judge {
    limits: Limits,
    rule: DecisionRule,
}

impl Judge {
    /// Limits judged at a probability of conformity.
    ///
    /// # Errors
    /// Limits out of order; a probability out of range.
    pub(crate) fn new(limits: Limits, conformance_probability: f64) -> Result<Self, JudgementError> {
        let limits_mm = match limits {
            Limits::Tolerance { lower_mm, upper_mm } => vec![lower_mm, upper_mm],
            Limits::Four { ll_mm, lo_mm, hi_mm, hh_mm } => vec![ll_mm, lo_mm, hi_mm, hh_mm],
        };
        let inner = limits_mm.len() / 2;
        let ascending = limits_mm.is_sorted() && limits_mm[inner - 1] < limits_mm[inner];
        if !ascending || limits_mm.iter().any(|l| !l.is_finite()) {
            return Err(JudgementError::Order { limits_mm });
        }
        Ok(Self { limits, rule: DecisionRule::new(conformance_probability)? })
    }

    /// The rule.
    pub(crate) fn rule(&self) -> DecisionRule {
        self.rule
    }

    /// Limits between which a diameter is good, mm.
    pub(crate) fn good_mm(&self) -> (f64, f64) {
        match self.limits {
            Limits::Tolerance { lower_mm, upper_mm } => (lower_mm, upper_mm),
            Limits::Four { lo_mm, hi_mm, .. } => (lo_mm, hi_mm),
        }
    }

    /// Guard band of a reading whose u has so many effective degrees of freedom, mm; `None` where
    /// it leaves no acceptance zone.
    pub(crate) fn guard_mm(&self, diameter: &Diameter, freedom: f64) -> Option<f64> {
        let (lower, upper) = self.good_mm();
        self.rule.guard_mm(diameter.u_mm(), freedom, upper - lower)
    }

    /// Judges a diameter by its combined standard uncertainty and its effective degrees of freedom.
    pub(crate) fn judge(&self, diameter: &Diameter, freedom: f64) -> Judgement {
        let estimate = Estimate::of(diameter, freedom);
        let (lower, upper) = self.good_mm();
        // NaN is neither proven good nor above the middle.
        let above = diameter.d_mm >= 0.5 * (lower + upper) && estimate.u_mm.is_finite();
        match (self.rule.decide(&estimate, lower, upper), self.limits) {
            (Decision::Conforms, _) => Judgement::GO,
            (Decision::TooLarge, Limits::Tolerance { .. }) => Judgement::HH,
            (Decision::TooSmall, Limits::Tolerance { .. }) => Judgement::LL,
            (_, Limits::Four { ll_mm, hh_mm, .. })
                if self.rule.decide(&estimate, ll_mm, hh_mm) != Decision::Conforms =>
            {
                if above {
                    Judgement::HH
                } else {
                    Judgement::LL
                }
            }
            _ if above => Judgement::HI,
            _ => Judgement::LO,
        }
    }

    /// Judges a reading; a gap stays a gap: a station without a reading is neither good nor bad.
    ///
    /// # Errors
    /// The gap's reason.
    pub(crate) fn judge_reading(&self, reading: &Reading, freedom: f64) -> Result<Judgement, Reason> {
        match reading {
            Reading::Value(diameter) => Ok(self.judge(diameter, freedom)),
            Reading::Gap(reason) => Err(*reason),
        }
    }

    /// Whether an uncertainty leaves room for GO at all.
    ///
    /// # Errors
    /// The width of the zone that would be needed.
    pub(crate) fn check_uncertainty(&self, u_mm: f64, freedom: f64) -> Result<(), JudgementError> {
        let (low, high) = self.good_mm();
        let least_mm = self.rule.least_width_mm(u_mm, freedom);
        if least_mm <= high - low {
            return Ok(());
        }
        Err(JudgementError::NoAcceptanceZone { u_mm, tolerance_mm: high - low, least_mm })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conformity::decision::MANY;

    fn reading(d_mm: f64) -> Diameter {
        Diameter { d_mm, u_random_mm: 0.003, u_common_mm: 0.004 }
    }

    #[test]
    fn a_tolerance_has_the_five_zones_of_iso_14253() {
        let limits = Limits::Tolerance { lower_mm: 49.9, upper_mm: 50.1 };
        let judge = Judge::new(limits, 0.95).unwrap();
        // u = 5 µm, g = 8.224 µm.
        assert!((judge.guard_mm(&reading(50.0), MANY).unwrap() - 0.008_224).abs() < 1e-6);
        for (d, expected) in [
            (50.1083, Judgement::HH),
            (50.1082, Judgement::HI),
            (50.0918, Judgement::HI),
            (50.0917, Judgement::GO),
            (49.9083, Judgement::GO),
            (49.9082, Judgement::LO),
            (49.8918, Judgement::LO),
            (49.8917, Judgement::LL),
        ] {
            assert_eq!(judge.judge(&reading(d), MANY), expected, "{d}");
        }
        assert_eq!(judge.judge_reading(&Reading::Gap(Reason::NoEdge), MANY), Err(Reason::NoEdge));
        let nan = f64::NAN;
        for d in [reading(nan), Diameter { u_common_mm: nan, ..reading(50.0) }] {
            assert_eq!(judge.judge(&d, MANY), Judgement::LO, "{d:?}");
        }
    }

    #[test]
    fn the_words_are_those_of_json() {
        for judgement in Judgement::ALL {
            assert_eq!(serde_json::json!(judgement), judgement.as_str());
        }
        let meanings: std::collections::BTreeSet<&str> = Judgement::ALL.map(Judgement::meaning).into();
        assert_eq!(meanings.len(), 5);
    }

    #[test]
    fn four_limits_give_the_better_class_only_when_it_is_proven() {
        let limits = Limits::Four { ll_mm: 49.8, lo_mm: 49.9, hi_mm: 50.1, hh_mm: 50.2 };
        let judge = Judge::new(limits, 0.95).unwrap();
        for (d, expected) in
            [(50.195, Judgement::HH), (50.15, Judgement::HI), (50.0, Judgement::GO), (49.85, Judgement::LO)]
        {
            assert_eq!(judge.judge(&reading(d), MANY), expected);
        }
        let plain = Judge::new(limits, 0.5).unwrap();
        assert_eq!(plain.judge(&reading(50.199), MANY), Judgement::HI);
    }

    #[test]
    fn too_large_an_uncertainty_accepts_nothing() {
        let judge = Judge::new(Limits::Tolerance { lower_mm: 49.999, upper_mm: 50.001 }, 0.95).unwrap();
        assert!(matches!(judge.check_uncertainty(0.005, MANY), Err(JudgementError::NoAcceptanceZone { .. })));
        assert_ne!(judge.judge(&reading(50.0), MANY), Judgement::GO);
        assert!(Judge::new(Limits::Tolerance { lower_mm: 2.0, upper_mm: 1.0 }, 0.95).is_err());
        assert!(Judge::new(Limits::Tolerance { lower_mm: 1.0, upper_mm: 2.0 }, 1.0).is_err());
    }
}
