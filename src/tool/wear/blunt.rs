//! Whether a cutting edge is blunt: ISO 3685:1993, 7.1, decided by ISO 14253-1.
//!
//! Criteria are VBB = 0.3 mm where the land is uniform and VBBmax = 0.6 mm where it is not. Whether
//! it is uniform is itself uncertain near the border, so that an edge is sharp only where both are
//! proven to lie below their limits, and blunt where one is proven to lie above.

use crate::conformity::{Decision, DecisionRule, Estimate, MANY};

/// Mean width of the land below which wear is slight, µm: of the tools of paper 004 the slightly
/// worn one has 48 and the uniformly worn one 156.
const SLIGHT_UM: f64 = 100.0;
/// Ratio VBBmax/VBB from which the land is not uniform: paper 004 has 1.65 and 1.54 for uniform
/// wear, 2.26 for the other.
const NON_UNIFORM: f64 = 2.0;

/// Limits of the widths, µm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WearLimits {
    /// Of the mean over zone B.
    pub vbb_um: f64,
    /// Of the largest in zone B.
    pub vbb_max_um: f64,
    /// Probability with which a verdict is proven.
    pub probability: f64,
}

impl Default for WearLimits {
    /// ISO 3685:1993, 7.1.1, at the 95 % of ISO 14253-1.
    fn default() -> Self {
        Self { vbb_um: 300.0, vbb_max_um: 600.0, probability: crate::conformity::PROBABILITY }
    }
}

/// Widths of a land with their standard uncertainties, µm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Land {
    /// Mean over zone B, and u.
    pub vbb_um: (f64, f64),
    /// Largest in zone B, and u.
    pub vbb_max_um: (f64, f64),
}

/// How an edge is worn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum WearClass {
    /// No land is seen.
    New,
    /// VBB below 0.1 mm.
    Slight,
    /// A land of even width.
    Uniform,
    /// VBBmax at least twice VBB.
    NonUniform,
}

/// Whether it still cuts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum WearVerdict {
    /// Both widths are proven to lie below their limits.
    Sharp,
    /// Neither is proven.
    Doubtful,
    /// A width is proven to lie above its limit.
    Blunt,
}

impl Land {
    /// Its class.
    pub(crate) fn class(&self) -> WearClass {
        match (self.vbb_um.0, self.vbb_max_um.0) {
            (vbb, _) if !(vbb > 0.0) => WearClass::New,
            (vbb, most) if most >= NON_UNIFORM * vbb && most >= SLIGHT_UM => WearClass::NonUniform,
            (vbb, _) if vbb < SLIGHT_UM => WearClass::Slight,
            _ => WearClass::Uniform,
        }
    }

    /// The verdict; a width that is not a number proves nothing.
    pub(crate) fn verdict(&self, limits: &WearLimits) -> WearVerdict {
        let rule = DecisionRule::new(limits.probability).unwrap_or_default();
        let decide = |(um, u_um): (f64, f64), limit_um: f64| {
            let estimate = Estimate { value_mm: 1e-3 * um, u_mm: 1e-3 * u_um, freedom: MANY };
            rule.decide(&estimate, f64::NEG_INFINITY, 1e-3 * limit_um)
        };
        let both = [decide(self.vbb_um, limits.vbb_um), decide(self.vbb_max_um, limits.vbb_max_um)];
        if both.contains(&Decision::TooLarge) {
            WearVerdict::Blunt
        } else if both.iter().all(|d| *d == Decision::Conforms) {
            WearVerdict::Sharp
        } else {
            WearVerdict::Doubtful
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn land(vbb: f64, most: f64, u: f64) -> Land {
        Land { vbb_um: (vbb, u), vbb_max_um: (most, u) }
    }

    /// The lands of paper 004, table 1.
    #[test]
    fn the_papers_lands_have_its_classes() {
        assert_eq!(land(48.0, 79.0, 2.0).class(), WearClass::Slight);
        assert_eq!(land(156.0, 241.0, 2.0).class(), WearClass::Uniform);
        assert_eq!(land(190.0, 429.0, 2.0).class(), WearClass::NonUniform);
        assert_eq!(land(0.0, 0.0, 2.0).class(), WearClass::New);
    }

    /// 1.645 u is the guard band of 95 % with a limit on one side.
    #[test]
    fn sharp_and_blunt_are_proven_by_a_guard_band() {
        let verdict = |vbb: f64, most: f64| land(vbb, most, 10.0).verdict(&WearLimits::default());
        assert_eq!(verdict(283.0, 400.0), WearVerdict::Sharp);
        assert_eq!(verdict(284.0, 400.0), WearVerdict::Doubtful);
        assert_eq!(verdict(316.0, 400.0), WearVerdict::Doubtful);
        assert_eq!(verdict(317.0, 400.0), WearVerdict::Blunt);
        assert_eq!(verdict(200.0, 584.0), WearVerdict::Doubtful);
        assert_eq!(verdict(200.0, 617.0), WearVerdict::Blunt);
        assert_eq!(verdict(f64::NAN, 617.0), WearVerdict::Blunt);
        assert_eq!(verdict(f64::NAN, 300.0), WearVerdict::Doubtful);
    }
}
