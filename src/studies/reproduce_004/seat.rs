//! What the seat of a holder makes of an insert's included angle, as seen.

use glam::DVec2;

/// Angle between the edges of an insert seen along the normal of the reference plane, rad: the
/// insert's own angle is `epsilon_rad`, its plane rises by `slopes` along X and Z, and its leading
/// edge is seen at `leading_rad`.
pub(super) fn projected_angle(epsilon_rad: f64, leading_rad: f64, slopes: DVec2) -> f64 {
    let edge = |seen: f64| {
        let along = DVec2::from_angle(seen);
        along.extend(slopes.dot(along))
    };
    let leading = edge(leading_rad);
    // the angle in the insert's plane rises with the one that is seen: halving of an interval of
    // 0.2 rad, 50 times, reaches the rounding of a number
    let (mut low, mut high) = (epsilon_rad - 0.1, epsilon_rad + 0.1);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if leading.angle_between(edge(leading_rad + middle)) < epsilon_rad {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_insert_is_seen_as_it_is_and_a_tilted_one_as_turned() {
        let (epsilon, leading) = (60f64.to_radians(), 3f64.to_radians());
        let level = projected_angle(epsilon, leading, DVec2::ZERO);
        assert!((level - epsilon).abs() < 1e-12);
        // a right angle about the line of steepest rise s: what lies along that line is seen
        // shorter by 1/√(1 + s²), what lies across it is not
        let half = (1.0 + 0.2f64 * 0.2).sqrt().atan();
        let seen = projected_angle(90f64.to_radians(), -half, DVec2::new(0.2, 0.0));
        assert!((seen - 2.0 * half).abs() < 1e-12, "{seen}");
    }
}
