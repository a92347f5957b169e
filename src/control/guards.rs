//! What an offset must pass before it is released. A refusal says which limit, where, and what was seen.

use super::GuardSettings;
use super::readings::Errors;
use crate::plan::{HeldReason, PassPlan};

/// Guards on what was measured, before any law sees it.
///
/// # Errors
/// The reason to hold.
pub(crate) fn check_measured(
    limits: &GuardSettings,
    plan: &PassPlan,
    errors: &Errors,
) -> Result<(), HeldReason> {
    let z = &plan.station_z_mm;
    if let Some((i, e)) = first_above(&errors.e_mm, limits.plausible_error_mm) {
        return Err(HeldReason::Guard(format!(
            "plausible reading: the diameter at z = {} mm is {e:.4} mm off the nominal {} mm, limit {} mm",
            z[i], plan.nominal_mm, limits.plausible_error_mm
        )));
    }
    if let Some((i, u)) = first_above(&errors.u_mm, limits.uncertainty_limit_mm) {
        return Err(HeldReason::Guard(format!(
            "uncertainty: the reading at z = {} mm has a standard uncertainty of {u:.5} mm, limit {} mm",
            z[i], limits.uncertainty_limit_mm
        )));
    }
    Ok(())
}

/// Guards on what a law proposes.
///
/// # Errors
/// The reason to hold.
pub(crate) fn check_proposed(
    limits: &GuardSettings,
    plan: &PassPlan,
    proposed_mm: &[f64],
) -> Result<(), HeldReason> {
    let step = largest(plan.offset.o_mm.iter().zip(proposed_mm).map(|(old, new)| new - old));
    if !within(step, limits.step_limit_mm) {
        return Err(HeldReason::StepLimit { step_mm: step, limit_mm: limits.step_limit_mm });
    }
    if let Some((i, o)) = first_above(proposed_mm, limits.cumulative_limit_mm) {
        return Err(HeldReason::Guard(format!(
            "cumulative limit: the offset at z = {} mm would be {o:.4} mm, limit {} mm",
            plan.station_z_mm[i], limits.cumulative_limit_mm
        )));
    }
    Ok(())
}

/// Index and value of the first element whose magnitude is not within the limit.
fn first_above(values: &[f64], limit: f64) -> Option<(usize, f64)> {
    values.iter().copied().enumerate().find(|(_, v)| !within(*v, limit))
}

/// |value| ≤ limit; no number is never within.
fn within(value: f64, limit: f64) -> bool {
    value.abs() <= limit
}

/// Largest magnitude; NaN if any is.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.map(f64::abs).fold(0.0, |most, v| if v > most || v.is_nan() { v } else { most })
}
