//! The decision rule: conformity is proven where its probability, given the reading, is at least
//! the one stated.
//!
//! A reading d with standard uncertainty u of ν effective degrees of freedom leaves the true value
//! distributed as d + u·t_ν (GUM G.3; JCGM 106:2012, 6 and 7, without knowledge of the process).
//! The probability of conformity to both limits at once is therefore p_c = F_ν((upper − d)/u) −
//! F_ν((lower − d)/u). ISO 14253-1:2017 requires 95 %. Where the zone is wide compared with u, the
//! resulting guard band is t_ν(p)·u, 1.645 u for many degrees of freedom; in a narrow zone both
//! limits count and the band is wider; below 2·t_ν((1 + p)/2)·u, about U on either side, nothing
//! can be proven to conform. A guard band of one limit held against both would still accept there
//! with less than the stated probability: 90 % at its narrowest zone where 95 % are stated.
//!
//! Non-conformity is proven beyond one limit, with its probability F_ν((lower − d)/u) or 1 −
//! F_ν((upper − d)/u): the limit that is violated matters for rework.

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use crate::conformity::error::JudgementError;
use crate::profile::Diameter;

/// Degrees of freedom of an uncertainty that is not estimated from scatter (type B), or from that
/// of very many values.
pub(crate) const MANY: f64 = f64::INFINITY;
/// Probability of conformity where none is stated (ISO 14253-1:2017).
pub(crate) const PROBABILITY: f64 = 0.95;
/// Student's t is the normal distribution from here on to 1e-5 of u.
const NORMAL_FROM: f64 = 1e5;

/// A reading with the distribution of the true value about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Estimate {
    /// The reading, mm.
    pub value_mm: f64,
    /// Combined standard uncertainty, mm.
    pub u_mm: f64,
    /// Effective degrees of freedom of u; [`MANY`] where u is exact.
    pub freedom: f64,
}

impl Estimate {
    /// Of a diameter whose u has so many effective degrees of freedom.
    pub(crate) fn of(diameter: &Diameter, freedom: f64) -> Self {
        Self { value_mm: diameter.d_mm, u_mm: diameter.u_mm(), freedom }
    }

    fn is_known(&self) -> bool {
        self.value_mm.is_finite() && self.u_mm.is_finite() && self.u_mm >= 0.0
    }

    /// Probability that the true value lies below a limit.
    pub(crate) fn below(&self, limit_mm: f64) -> f64 {
        let away = limit_mm - self.value_mm;
        if self.u_mm == 0.0 {
            return if away >= 0.0 { 1.0 } else { 0.0 };
        }
        cumulative(away / self.u_mm, self.freedom)
    }

    /// Probability that the true value lies between two limits, one of which may be infinite; 0 for
    /// NaN.
    pub(crate) fn within(&self, lower_mm: f64, upper_mm: f64) -> f64 {
        if !self.is_known() {
            return 0.0;
        }
        if self.u_mm == 0.0 {
            return if (lower_mm..=upper_mm).contains(&self.value_mm) { 1.0 } else { 0.0 };
        }
        (self.below(upper_mm) - self.below(lower_mm)).max(0.0)
    }
}

fn cumulative(t: f64, freedom: f64) -> f64 {
    if t.is_infinite() {
        return if t > 0.0 { 1.0 } else { 0.0 };
    }
    match StudentsT::new(0.0, 1.0, freedom.max(1.0)) {
        Ok(student) if freedom < NORMAL_FROM => student.cdf(t),
        _ => Normal::standard().cdf(t),
    }
}

/// Quantile of Student's t.
fn quantile(probability: f64, freedom: f64) -> f64 {
    match StudentsT::new(0.0, 1.0, freedom.max(1.0)) {
        Ok(student) if freedom < NORMAL_FROM => student.inverse_cdf(probability),
        _ => Normal::standard().inverse_cdf(probability),
    }
}

/// The outcome of the decision rule for a reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Decision {
    /// The true value lies within both limits.
    Conforms,
    /// It lies below the lower limit.
    TooSmall,
    /// It lies above the upper limit.
    TooLarge,
    /// None of these.
    NotProven,
}

/// Accepts and rejects with a stated probability, 0.5 or more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DecisionRule {
    probability: f64,
}

impl Default for DecisionRule {
    fn default() -> Self {
        Self { probability: PROBABILITY }
    }
}

impl DecisionRule {
    /// A rule with this probability of conformity.
    ///
    /// # Errors
    /// A probability below 0.5, or not below 1.
    pub(crate) fn new(probability: f64) -> Result<Self, JudgementError> {
        if (0.5..1.0).contains(&probability) {
            Ok(Self { probability })
        } else {
            Err(JudgementError::Probability { value: probability })
        }
    }

    /// Decides on an estimate against two limits, one of which may be infinite.
    pub(crate) fn decide(self, estimate: &Estimate, lower_mm: f64, upper_mm: f64) -> Decision {
        if estimate.within(lower_mm, upper_mm) >= self.probability {
            Decision::Conforms
        } else if !estimate.is_known() {
            Decision::NotProven
        } else if estimate.below(lower_mm) >= self.probability {
            Decision::TooSmall
        } else if 1.0 - estimate.below(upper_mm) >= self.probability {
            Decision::TooLarge
        } else {
            Decision::NotProven
        }
    }

    /// Guard band on either side of a zone of this width, mm: readings farther inside are accepted.
    /// `None` where the zone accepts none.
    pub(crate) fn guard_mm(self, u_mm: f64, freedom: f64, width_mm: f64) -> Option<f64> {
        let accepted = |guard_mm: f64| {
            // Far from the other limit the rounding of the quantile is larger than its effect.
            Estimate { value_mm: guard_mm, u_mm, freedom }.within(0.0, width_mm) >= self.probability - 1e-12
        };
        // The guard band of one limit alone is a lower bound.
        let (mut less, mut more) = (quantile(self.probability, freedom).max(0.0) * u_mm, 0.5 * width_mm);
        if width_mm == f64::INFINITY {
            return Some(less);
        }
        if !(less <= more && accepted(more)) {
            return None;
        }
        if accepted(less) {
            return Some(less);
        }
        while more - less > 1e-9 * u_mm {
            let half = 0.5 * (less + more);
            if accepted(half) {
                more = half;
            } else {
                less = half;
            }
            if half == less && half == more {
                break;
            }
        }
        Some(more)
    }

    /// Least width of a zone that accepts anything, mm: 2·t_ν((1 + p)/2)·u.
    pub(crate) fn least_width_mm(self, u_mm: f64, freedom: f64) -> f64 {
        2.0 * quantile(0.5 + 0.5 * self.probability, freedom) * u_mm
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate(value_mm: f64, u_mm: f64, freedom: f64) -> Estimate {
        Estimate { value_mm, u_mm, freedom }
    }

    /// JCGM 106:2012, 7.4 and table 1 for one limit: p_c = 0.95 at 1.64 u inside; two limits: Φ(2)
    /// − Φ(−2) in the middle of 4 u.
    #[test]
    fn probabilities_are_those_of_the_distributions() {
        let one = estimate(-1.644_853_6, 1.0, MANY).within(f64::NEG_INFINITY, 0.0);
        assert!((one - 0.95).abs() < 1e-7, "{one}");
        let two = estimate(2.0, 1.0, MANY).within(0.0, 4.0);
        assert!((two - 0.954_499_736).abs() < 1e-8, "{two}");
        // Table of Student's t: t(0.95, 4) = 2.1318, t(0.975, 10) = 2.2281.
        assert!((estimate(2.131_847, 1.0, 4.0).within(0.0, f64::INFINITY) - 0.95).abs() < 1e-6);
        assert!((DecisionRule::default().least_width_mm(1.0, 10.0) - 2.0 * 2.228_139).abs() < 1e-5);
    }

    #[test]
    fn guard_bands_hold_both_limits() {
        let rule = DecisionRule::default();
        let guard = |freedom, width| rule.guard_mm(1.0, freedom, width);
        assert!((guard(MANY, 20.0).unwrap() - 1.644_853_6).abs() < 1e-6);
        assert!((guard(4.0, f64::INFINITY).unwrap() - 2.131_847).abs() < 1e-5);
        // 2·Φ(1.96) − 1 = 0.95: below 3.92 u nothing is accepted, just above it the middle alone.
        assert_eq!(guard(MANY, 3.919), None);
        assert!((guard(MANY, 3.920).unwrap() - 1.96).abs() < 0.02);
        for (freedom, width) in [(MANY, 4.0), (MANY, 4.5), (3.0, 6.5), (10.0, 5.0), (30.0, 4.2)] {
            let g = guard(freedom, width).unwrap();
            let p = estimate(g, 1.0, freedom).within(0.0, width);
            assert!((p - 0.95).abs() < 1e-6 || g > quantile(0.95, freedom), "{freedom} {width}: {g} {p}");
            assert!(p >= 0.95 - 1e-9);
        }
    }

    #[test]
    fn what_is_no_number_proves_nothing() {
        let rule = DecisionRule::default();
        for (value, u) in [(f64::NAN, 1.0), (0.5, f64::NAN), (0.5, f64::INFINITY), (f64::INFINITY, 1.0)] {
            assert_eq!(rule.decide(&estimate(value, u, MANY), 0.0, 1.0), Decision::NotProven, "{value} {u}");
        }
        assert_eq!(rule.decide(&estimate(0.5, 0.0, MANY), 0.0, 1.0), Decision::Conforms);
        assert_eq!(rule.decide(&estimate(1.5, 0.0, MANY), 0.0, 1.0), Decision::TooLarge);
        // However large u is compared with the zone, a reading in its middle violates neither
        // limit.
        assert_eq!(rule.decide(&estimate(0.5, 100.0, MANY), 0.0, 1.0), Decision::NotProven);
        assert!(DecisionRule::new(0.49).is_err() && DecisionRule::new(1.0).is_err());
    }

    /// Parts at either limit are accepted no more often than stated, and of what is accepted at the
    /// edge of the acceptance zone at least the stated share conforms, for zones from 2 U up and
    /// few degrees of freedom; with the guard band of one limit at its narrowest zone it would be
    /// 90 %.
    #[test]
    fn the_stated_probability_holds_for_zones_from_two_expanded_uncertainties_up() {
        use rand::{RngExt, SeedableRng};
        use rand_distr::{ChiSquared, StandardNormal, StudentT};
        let mut random = rand_pcg::Pcg64::seed_from_u64(11);
        let rule = DecisionRule::default();
        let runs = 20_000;
        for freedom in [3.0, 8.0, 30.0, MANY] {
            let k = quantile(0.5 + 0.5 * 0.954_499_736, freedom);
            for width in [2.0 * k, 2.2 * k, 3.0 * k, 10.0 * k] {
                let scatter = |random: &mut rand_pcg::Pcg64| match freedom {
                    f if f.is_infinite() => 1.0,
                    f => (random.sample(ChiSquared::new(f).unwrap()) / f).sqrt(),
                };
                let mut accepted = 0;
                for _ in 0..runs {
                    let z: f64 = random.sample(StandardNormal);
                    let e = estimate(z, scatter(&mut random), freedom);
                    accepted += u32::from(rule.decide(&e, 0.0, width) == Decision::Conforms);
                }
                // Of 20 000 at 5 %, three standard deviations are 0.46 %.
                assert!(
                    f64::from(accepted) <= (0.05 + 0.005) * f64::from(runs),
                    "{freedom} {width}: {accepted}"
                );
                let edge = rule.guard_mm(1.0, freedom, width).unwrap();
                let inside = (0..runs)
                    .filter(|_| {
                        let t: f64 = match freedom {
                            f if f.is_infinite() => random.sample(StandardNormal),
                            f => random.sample(StudentT::new(f).unwrap()),
                        };
                        (0.0..=width).contains(&(edge + t))
                    })
                    .count();
                assert!(inside as f64 >= (0.95 - 0.005) * f64::from(runs), "{freedom} {width}: {inside}");
            }
        }
        // The probability with the guard band of one limit alone.
        let one_limit = estimate(1.645, 1.0, MANY).within(0.0, 2.0 * 1.66);
        assert!((0.89..0.91).contains(&one_limit), "{one_limit}");
    }
}
