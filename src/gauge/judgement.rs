//! Judgement HH / HI / GO / LO / LL with guard bands after ISO 14253-1.
//!
//! A diameter d with combined standard uncertainty u conforms to a limit, with probability p, if it keeps the guard
//! band g = Φ⁻¹(p)·u away from it on the good side (ISO 14253-1: p = 95 %, g = 1.65·u), and violates it if it lies g beyond.
//! In between neither is proven.
//!
//! | limits | HH | HI | GO | LO | LL |
//! |---|---|---|---|---|---|
//! | a tolerance | violation proven | not proven either way, above | conformity proven | not proven, below | violation proven |
//! | four limits | not proven below hh | below hh, not proven below hi | proven between lo and hi | above ll, not proven above lo | not proven above ll |

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};
use thiserror::Error;

use crate::profile::{Diameter, Reading, Reason};

/// What a reading is judged to be.
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
    /// Four limits of a comparator: GO between lo and hi, LO and HI out to ll and hh (to be reworked, or a warning).
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

/// Why limits cannot judge.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum JudgementError {
    /// Limits not in ascending order.
    #[error("the limits {limits_mm:?} mm are not finite and in ascending order")]
    Order {
        /// The limits, lowest first.
        limits_mm: Vec<f64>,
    },
    /// A probability of conformance that is none.
    #[error("conformance_probability = {value}: must be at least 0.5 and below 1 (ISO 14253-1: 0.95)")]
    Probability {
        /// What stands there.
        value: f64,
    },
    /// The guard bands leave nothing to accept.
    #[error(
        "an uncertainty of u = {u_mm} mm leaves no acceptance zone in a tolerance of {tolerance_mm} mm: two guard \
         bands take {guards_mm} mm"
    )]
    NoAcceptanceZone {
        /// Combined standard uncertainty, mm.
        u_mm: f64,
        /// Width of the zone, mm.
        tolerance_mm: f64,
        /// Width of both guard bands, mm.
        guards_mm: f64,
    },
}

/// Limits with a guard factor, checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judge {
    limits: Limits,
    guard_factor: f64,
}

impl Judge {
    /// Limits judged at a probability of conformance (.5: no guard band, .95: 1.645·u).
    ///
    /// # Errors
    /// Limits out of order; a probability out of range.
    pub fn new(limits: Limits, conformance_probability: f64) -> Result<Self, JudgementError> {
        let limits_mm = match limits {
            Limits::Tolerance { lower_mm, upper_mm } => vec![lower_mm, upper_mm],
            Limits::Four { ll_mm, lo_mm, hi_mm, hh_mm } => vec![ll_mm, lo_mm, hi_mm, hh_mm],
        };
        let inner = limits_mm.len() / 2;
        let ascending = limits_mm.is_sorted() && limits_mm[inner - 1] < limits_mm[inner];
        if !ascending || limits_mm.iter().any(|l| !l.is_finite()) {
            return Err(JudgementError::Order { limits_mm });
        }
        if !(0.5..1.0).contains(&conformance_probability) {
            return Err(JudgementError::Probability { value: conformance_probability });
        }
        Ok(Self { limits, guard_factor: Normal::standard().inverse_cdf(conformance_probability) })
    }

    /// Guard band of a reading, mm.
    pub fn guard_mm(&self, diameter: &Diameter) -> f64 {
        self.guard_factor * diameter.u_mm()
    }

    /// Judges a diameter by its combined standard uncertainty.
    pub fn judge(&self, diameter: &Diameter) -> Judgement {
        let (d, g) = (diameter.d_mm, self.guard_mm(diameter));
        let [ll, lo, hi, hh] = match self.limits {
            Limits::Tolerance { lower_mm, upper_mm } => {
                [lower_mm - g, lower_mm + g, upper_mm - g, upper_mm + g]
            }
            Limits::Four { ll_mm, lo_mm, hi_mm, hh_mm } => [ll_mm + g, lo_mm + g, hi_mm - g, hh_mm - g],
        };
        // The worse class first, and above before below: a zone eaten up by its guard bands accepts nothing.
        if d > hh {
            Judgement::HH
        } else if d < ll {
            Judgement::LL
        } else if d > hi {
            Judgement::HI
        } else if d >= lo {
            Judgement::GO
        } else {
            // What is no number is not proven good either.
            Judgement::LO
        }
    }

    /// Judges a reading; a gap stays a gap: what was not measured is neither good nor bad.
    ///
    /// # Errors
    /// The gap's reason.
    pub fn judge_reading(&self, reading: &Reading) -> Result<Judgement, Reason> {
        match reading {
            Reading::Value(diameter) => Ok(self.judge(diameter)),
            Reading::Gap(reason) => Err(*reason),
        }
    }

    /// Whether an uncertainty leaves room for GO at all.
    ///
    /// # Errors
    /// Says how much of the zone the guard bands take.
    pub fn check_uncertainty(&self, u_mm: f64) -> Result<(), JudgementError> {
        let (low, high) = match self.limits {
            Limits::Tolerance { lower_mm, upper_mm } => (lower_mm, upper_mm),
            Limits::Four { lo_mm, hi_mm, .. } => (lo_mm, hi_mm),
        };
        let guards_mm = 2.0 * self.guard_factor * u_mm;
        if guards_mm < high - low {
            return Ok(());
        }
        Err(JudgementError::NoAcceptanceZone { u_mm, tolerance_mm: high - low, guards_mm })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reading(d_mm: f64) -> Diameter {
        Diameter { d_mm, u_random_mm: 0.003, u_common_mm: 0.004 }
    }

    #[test]
    fn a_tolerance_has_the_five_zones_of_iso_14253() {
        let limits = Limits::Tolerance { lower_mm: 49.9, upper_mm: 50.1 };
        let judge = Judge::new(limits, 0.95).unwrap();
        // u = 5 µm, g = 8.224 µm.
        assert!((judge.guard_mm(&reading(50.0)) - 0.008_224).abs() < 1e-6);
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
            assert_eq!(judge.judge(&reading(d)), expected, "{d}");
        }
        assert_eq!(judge.judge_reading(&Reading::Gap(Reason::NoEdge)), Err(Reason::NoEdge));
        let nan = f64::NAN;
        for d in [reading(nan), Diameter { u_common_mm: nan, ..reading(50.0) }] {
            assert_eq!(judge.judge(&d), Judgement::LO, "{d:?}");
        }
    }

    #[test]
    fn four_limits_give_the_better_class_only_when_it_is_proven() {
        let limits = Limits::Four { ll_mm: 49.8, lo_mm: 49.9, hi_mm: 50.1, hh_mm: 50.2 };
        let judge = Judge::new(limits, 0.95).unwrap();
        for (d, expected) in
            [(50.195, Judgement::HH), (50.15, Judgement::HI), (50.0, Judgement::GO), (49.85, Judgement::LO)]
        {
            assert_eq!(judge.judge(&reading(d)), expected);
        }
        let plain = Judge::new(limits, 0.5).unwrap();
        assert_eq!(plain.judge(&reading(50.199)), Judgement::HI);
    }

    #[test]
    fn too_large_an_uncertainty_accepts_nothing() {
        let judge = Judge::new(Limits::Tolerance { lower_mm: 49.999, upper_mm: 50.001 }, 0.95).unwrap();
        assert!(matches!(judge.check_uncertainty(0.005), Err(JudgementError::NoAcceptanceZone { .. })));
        assert_ne!(judge.judge(&reading(50.0)), Judgement::GO);
        assert!(Judge::new(Limits::Tolerance { lower_mm: 2.0, upper_mm: 1.0 }, 0.95).is_err());
        assert!(Judge::new(Limits::Tolerance { lower_mm: 1.0, upper_mm: 2.0 }, 1.0).is_err());
    }

    #[test]
    fn a_part_at_its_limit_is_accepted_as_seldom_as_promised() {
        use rand::{RngExt, SeedableRng};
        let judge = Judge::new(Limits::Tolerance { lower_mm: 49.9, upper_mm: 50.1 }, 0.95).unwrap();
        let mut random = rand_pcg::Pcg64::seed_from_u64(1);
        let normal = rand_distr::Normal::new(50.1, 0.005).unwrap();
        let accepted =
            (0..100_000).filter(|_| judge.judge(&reading(random.sample(normal))) == Judgement::GO).count();
        assert!((4800..5200).contains(&accepted), "{accepted}");
    }
}
