//! The axis of a bent body: where it stands and how it slopes.
//!
//! A beam's sections stay square to its axis (Bernoulli; a slender shaft's shear angle is a per mille of its slope). Where the axis
//! slopes by τ in the image plane, an upright slice of the body is therefore 1/cos τ higher than the section: edges at c_x ± h/cos τ, the
//! outline's parallel curves to κR of the correction itself. A slope towards the camera leaves a telecentric outline as it is.

use glam::DVec2;

use crate::shaft::AxisKnot;

/// Offset of the axis at z: linear between knots, constant beyond the ends.
pub(super) fn offset(knots: &[AxisKnot], z_mm: f64) -> DVec2 {
    let after = knots.partition_point(|k| k.z_mm <= z_mm);
    match (after.checked_sub(1).and_then(|i| knots.get(i)), knots.get(after)) {
        (Some(a), Some(b)) => point(a).lerp(point(b), (z_mm - a.z_mm) / (b.z_mm - a.z_mm)),
        (Some(only), None) | (None, Some(only)) => point(only),
        (None, None) => DVec2::ZERO,
    }
}

/// Slope of the axis at z, mm/mm: linear between the middles of the knots' intervals, so that it does not jump at a knot; level beyond
/// the ends.
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

/// Slope between the knots before and at `index`; none where they stand at one z.
fn of_interval(knots: &[AxisKnot], index: usize) -> DVec2 {
    let (a, b) = (&knots[index - 1], &knots[index]);
    let length = b.z_mm - a.z_mm;
    if length > 0.0 { (point(b) - point(a)) / length } else { DVec2::ZERO }
}

fn point(knot: &AxisKnot) -> DVec2 {
    DVec2::new(knot.x_mm, knot.y_mm)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::silhouette::Outline;
    use crate::shaft::Shaft;

    /// The upper and lower envelope of discs of radius R whose middles lie on the axis: the outline of a bent, round bar by its definition.
    #[test]
    fn edges_of_a_bent_bar_are_the_parallel_curves_of_its_axis() {
        let (length, sagitta, radius) = (150.0_f64, 0.5_f64, 4.0_f64);
        let axis = |z: f64| sagitta * (std::f64::consts::PI * z / length).sin();
        let knots = (0..=1500).map(|i| f64::from(i) * length / 1500.0);
        let deflection: Vec<AxisKnot> =
            knots.map(|z_mm| AxisKnot { z_mm, x_mm: axis(z_mm), y_mm: 0.3 * axis(z_mm) }).collect();
        let shaft = Shaft { deflection, ..Shaft::cylinder(2.0 * radius) };
        let outline = Outline::new(shaft).unwrap();
        let turned = outline.turned(30.0);
        for z in [3.0, 20.0, 40.0, 75.0, 120.0] {
            let disc = |side: f64| {
                let height = |s: f64| axis(s) * side + (radius * radius - (z - s) * (z - s)).max(0.0).sqrt();
                (-20_000..=20_000).map(|i| height(z + f64::from(i) * 1e-5)).fold(f64::MIN, f64::max)
            };
            let edges = turned.edges(z);
            // At the worst place the bar is 0.22 µm wider across z than across its axis; a hundredth of that is left out.
            assert!((edges.top_mm - disc(1.0)).abs() < 3e-6, "{z}: {} {}", edges.top_mm, disc(1.0));
            assert!((-edges.bottom_mm - disc(-1.0)).abs() < 3e-6, "{z}");
            let wider = edges.top_mm - edges.bottom_mm - 2.0 * radius;
            let slope = sagitta * std::f64::consts::PI / length * (std::f64::consts::PI * z / length).cos();
            assert!((wider - radius * slope * slope).abs() < 2e-8, "{z}: {wider}");
            assert!((turned.caliper_mm(z) - 2.0 * radius).abs() < 1e-12);
        }
    }
}
