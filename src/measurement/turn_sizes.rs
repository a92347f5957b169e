//! Sizes over a revolution for the modifiers of a tolerance: the envelope (E), the least
//! circumscribed cylinder (GN) and circles (GN) ACS.

use serde::ser::SerializeMap as _;
use serde::{Serialize, Serializer};

use crate::conformity::{Decision, DecisionRule, Estimate, Judgement, MANY, SizeCriterion, Tolerance};
use crate::gauge::diameter::sections::{Envelope, PartForm};

/// The judgement of a size over a revolution.
#[derive(Clone, Debug, PartialEq)]
pub struct TurnJudged {
    /// The size that the tolerance applies to.
    pub what: &'static str,
    /// Middle of the section that decided, mm; `None` for a size over the length.
    pub z_mm: Option<f64>,
    /// Sections of a size over the length.
    pub sections: Option<usize>,
    /// The size, or why there is none.
    pub size: Result<JudgedSize, String>,
}

/// A size with its judgement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JudgedSize {
    /// The size, mm.
    pub d_mm: f64,
    /// Its combined standard uncertainty, mm.
    pub u_mm: f64,
    /// Guard band, mm; `None` where it leaves no acceptance zone.
    pub guard_mm: Option<f64>,
    /// Its judgement.
    pub judgement: Judgement,
}

impl TurnJudged {
    /// The judgement; a size that was not measured is not proven small enough.
    pub(crate) fn judgement(&self) -> Judgement {
        self.size.as_ref().map_or(Judgement::HI, |size| size.judgement)
    }
}

impl Serialize for TurnJudged {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("what", self.what)?;
        if let Some(z_mm) = self.z_mm {
            map.serialize_entry("z_mm", &z_mm)?;
        }
        match &self.size {
            Err(why) => {
                map.serialize_entry("judgement", &None::<Judgement>)?;
                map.serialize_entry("why", why)?;
            }
            Ok(size) => {
                map.serialize_entry("d_mm", &size.d_mm)?;
                map.serialize_entry("u_mm", &size.u_mm)?;
                if let Some(sections) = self.sections {
                    map.serialize_entry("sections", &sections)?;
                }
                map.serialize_entry("judgement", &size.judgement)?;
                map.serialize_entry("guard_mm", &size.guard_mm)?;
            }
        }
        map.end()
    }
}

/// Whether a tolerance applies to the envelope of the part.
pub(super) fn needs_envelope(tolerance: &Tolerance) -> bool {
    matches!(tolerance.criterion, SizeCriterion::Envelope | SizeCriterion::CircumscribedCylinder)
}

/// Judges the sizes over a revolution that `tolerance` applies to; `None` where there are none.
/// `common_mm` is the common standard uncertainty of sizes at z, mm, `envelope` the envelope or why
/// there is none.
pub(super) fn judge_turn(
    tolerance: &Tolerance,
    rule: DecisionRule,
    form: &PartForm,
    envelope: &Result<Envelope, String>,
    common_mm: &dyn Fn(f64) -> Option<f64>,
) -> Option<TurnJudged> {
    let (lower, upper) = tolerance.limits_mm();
    let what = tolerance.criterion.as_str();
    let common = |z_mm: f64| common_mm(z_mm).unwrap_or(0.0);
    let largest_common = form.sections.iter().map(|s| common(s.z_mm)).fold(0.0, f64::max);
    let over_length = |lower: f64| TurnJudged {
        what,
        z_mm: None,
        sections: envelope.as_ref().ok().map(|e| e.sections),
        size: envelope.as_ref().map_err(Clone::clone).map(|envelope| {
            let u_mm = envelope.u_random_mm.hypot(largest_common);
            judged(rule, &Estimate { value_mm: envelope.diameter_mm, u_mm, freedom: MANY }, (lower, upper))
        }),
    };
    match tolerance.criterion {
        SizeCriterion::TwoPoint => None,
        // The lower limit applies to the two-point sizes, which are judged by frame.
        SizeCriterion::Envelope => Some(over_length(f64::NEG_INFINITY)),
        SizeCriterion::CircumscribedCylinder => Some(over_length(lower)),
        SizeCriterion::CircumscribedCircle => {
            let sections = form.sections.iter().map(|s| {
                let u_mm = (std::f64::consts::SQRT_2 * s.u_edge_mm).hypot(common(s.z_mm));
                let estimate = Estimate { value_mm: s.gn_mm, u_mm, freedom: MANY };
                let size = Ok(judged(rule, &estimate, (lower, upper)));
                TurnJudged { what, z_mm: Some(s.z_mm), sections: None, size }
            });
            let worst = sections.max_by_key(|s| s.judgement().severity());
            let refused = form.refused.first().map(|(z_mm, why)| TurnJudged {
                what,
                z_mm: Some(*z_mm),
                sections: None,
                size: Err(why.clone()),
            });
            // A section without a full turn is not proven good.
            match (worst, refused) {
                (Some(worst), Some(refused)) if worst.judgement() == Judgement::GO => Some(refused),
                (Some(worst), _) => Some(worst),
                (None, refused) => refused,
            }
        }
    }
}

fn judged(rule: DecisionRule, estimate: &Estimate, (lower, upper): (f64, f64)) -> JudgedSize {
    let above = !lower.is_finite() || estimate.value_mm >= 0.5 * (lower + upper);
    let judgement = match rule.decide(estimate, lower, upper) {
        Decision::Conforms => Judgement::GO,
        Decision::TooLarge => Judgement::HH,
        Decision::TooSmall => Judgement::LL,
        Decision::NotProven if above => Judgement::HI,
        Decision::NotProven => Judgement::LO,
    };
    let guard_mm = rule.guard_mm(estimate.u_mm, estimate.freedom, upper - lower);
    JudgedSize { d_mm: estimate.value_mm, u_mm: estimate.u_mm, guard_mm, judgement }
}
