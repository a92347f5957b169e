//! Comparison of a pass with the one before: stations that did not change as commanded.

use crate::gauge::GaugeSettings;
use crate::gauge::plausibility::against_pass;
use crate::plan::PassPlan;
use crate::profile::DiameterProfile;

/// Turns stations into gaps whose change since the pass before is not the commanded one, and
/// reports the reason of each. Where a whole part did not change as commanded no station is
/// refused, because the controller's guards decide on that; it is reported as well.
pub(super) fn compare(
    before: Option<&(PassPlan, DiameterProfile)>,
    plan: &PassPlan,
    measured: &mut DiameterProfile,
    gauge: &GaugeSettings,
) -> Vec<String> {
    let Some((last, before)) = before.filter(|(last, _)| last.pass + 1 == plan.pass) else {
        return Vec::new();
    };
    let fall: Vec<f64> = last.commanded_mm().zip(plan.commanded_mm()).map(|(was, is)| was - is).collect();
    let (jumps, theirs) = against_pass(&gauge.plausibility, before, &fall, measured);
    match (jumps.first(), theirs) {
        (None, _) => Vec::new(),
        (Some(_), true) => jumps.iter().map(|j| format!("implausible after the last pass: {j}")).collect(),
        (Some(first), false) => {
            vec![format!("{} stations did not change as commanded since the last pass: {first}", jumps.len())]
        }
    }
}
