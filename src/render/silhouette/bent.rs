//! The axis of a bent body: offset and slope.
//!
//! A beam's sections remain perpendicular to its axis (Bernoulli; the shear angle of a slender
//! shaft is a thousandth of its slope). Where the axis slopes by τ in the image plane, an upright
//! slice of the body is therefore 1/cos τ higher than the section: edges at c_x ± h/cos τ, the
//! parallel curves of the outline, to a relative error κR of the correction. A slope towards the
//! camera does not change a telecentric outline.

use glam::DVec2;

use crate::numerics::neighbours::neighbours;
use crate::shaft::AxisKnot;

/// Offset of the axis at z: linear between knots, constant beyond the ends.
pub(super) fn offset(knots: &[AxisKnot], z_mm: f64) -> DVec2 {
    match neighbours(knots, |k| k.z_mm <= z_mm) {
        (Some(a), Some(b)) => point(a).lerp(point(b), (z_mm - a.z_mm) / (b.z_mm - a.z_mm)),
        (Some(only), None) | (None, Some(only)) => point(only),
        (None, None) => DVec2::ZERO,
    }
}

/// Slope of the axis at z, mm/mm: linear between the middles of the knots' intervals, so that it is
/// continuous at a knot; zero beyond the ends.
pub(super) fn slope(knots: &[AxisKnot], z_mm: f64) -> DVec2 {
    let after = knots.partition_point(|k| k.z_mm <= z_mm);
    if after == 0 || after == knots.len() {
        return DVec2::ZERO;
    }
    let (a, b) = (&knots[after - 1], &knots[after]);
    let here = of_interval(knots, after);
    let share = (z_mm - a.z_mm) / (b.z_mm - a.z_mm) - 0.5;
    let beside = if share < 0.0 { after - 1 } else { after + 1 };
    if beside == 0 || beside >= knots.len() {
        return here;
    }
    let other = of_interval(knots, beside);
    let own = b.z_mm - a.z_mm;
    let next = knots[beside].z_mm - knots[beside - 1].z_mm;
    if !(next > 0.0) {
        return here;
    }
    here.lerp(other, share.abs() * own / (0.5 * (own + next)))
}

/// 1/cos τ of a slope along x.
pub(super) fn secant(slope: f64) -> f64 {
    slope.hypot(1.0)
}

/// Slope between the knots before and at `index`; zero where they are at the same z.
fn of_interval(knots: &[AxisKnot], index: usize) -> DVec2 {
    let (a, b) = (&knots[index - 1], &knots[index]);
    let length = b.z_mm - a.z_mm;
    if length > 0.0 { (point(b) - point(a)) / length } else { DVec2::ZERO }
}

fn point(knot: &AxisKnot) -> DVec2 {
    DVec2::new(knot.x_mm, knot.y_mm)
}
