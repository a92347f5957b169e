//! The paper's way of measuring a nose, as numeric functions: threshold and false alarms of its
//! line detector (equations 5 to 7), and the centre of a circle that touches both lines (equation
//! 10).
//!
//! The line detector is that of Grompone von Gioi, Jakubowicz, Morel and Randall (LSD, Image
//! Processing On Line 2, 2012): a gradient below ρ = q/sin τ may have turned by more than τ where
//! grey values are off by q; (NM)^(5/2)·γ rectangles can be drawn in an image, since either end may
//! be any of its NM pixels and the width any up to √(NM).

use glam::DVec2;

/// Least gradient whose direction is within `tau_rad` where grey values are off by `q`.
pub(super) fn gradient_threshold(q: f64, tau_rad: f64) -> f64 {
    q / tau_rad.sin()
}

/// Number of tests γ·(NM)^x of an image.
pub(super) fn tests((columns, rows): (u32, u32), exponent: f64, gamma: f64) -> f64 {
    gamma * (f64::from(columns) * f64::from(rows)).powf(exponent)
}

/// Equation 6: probability of `k` or more of `n` pixels within the tolerance, each with `p`.
pub(super) fn binomial_tail(n: u32, k: u32, p: f64) -> f64 {
    let ln_factorial = |m: u32| libm::lgamma(f64::from(m) + 1.0);
    let term = |j: u32| {
        let chosen = ln_factorial(n) - ln_factorial(j) - ln_factorial(n - j);
        (chosen + f64::from(j) * p.ln() + f64::from(n - j) * (-p).ln_1p()).exp()
    };
    // the smallest first
    (k..=n).rev().map(term).sum()
}

/// Least number of `n` pixels that must lie within the tolerance for at most one false alarm in
/// `tests` (equation 7); none where all of them are too few.
pub(super) fn aligned_needed(n: u32, p: f64, tests: f64) -> Option<u32> {
    (0..=n).find(|&k| tests * binomial_tail(n, k, p) <= 1.0)
}

/// A line k·x + b·y + c = 0 (equations 8 and 9).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Line {
    /// k and b.
    pub normal: DVec2,
    /// c.
    pub constant: f64,
}

impl Line {
    /// Signed distance of a point.
    pub(super) fn distance(&self, at: DVec2) -> f64 {
        (self.normal.dot(at) + self.constant) / self.normal.length()
    }
}

/// Equation 10: the four points at the distance `r` from both lines; none of parallel lines.
pub(super) fn centres([one, other]: [Line; 2], r: f64) -> Option<[DVec2; 4]> {
    let determinant = one.normal.perp_dot(other.normal);
    let at = |first: f64, second: f64| {
        let (f, g) =
            (first * one.normal.length() - one.constant, second * other.normal.length() - other.constant);
        DVec2::new(f * other.normal.y - g * one.normal.y, g * one.normal.x - f * other.normal.x) / determinant
    };
    let four = [at(r, r), at(r, -r), at(-r, r), at(-r, -r)];
    four.iter().all(|p| p.is_finite()).then_some(four)
}

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
    fn the_threshold_is_where_an_error_of_q_turns_a_gradient_by_tau() {
        // a gradient of length g turns most, by asin(q/g), under an error of q at right angles to
        // the result
        let tau = 22.5f64.to_radians();
        let g = gradient_threshold(2.0, tau);
        let turned = (0..20_000).map(|k| {
            let error = 2.0 * DVec2::from_angle(f64::from(k) * 1e-3);
            DVec2::X.angle_to(DVec2::new(g, 0.0) + error).abs()
        });
        let most = turned.fold(0.0, f64::max);
        assert!((most - tau).abs() < 1e-6 && (g - 5.2263).abs() < 5e-5, "{most} {g}");
    }

    #[test]
    fn the_tail_is_pascals_triangle() {
        // all outcomes of 10 pixels by enumeration
        let p = 0.125f64;
        for k in 0..=10 {
            let sum: f64 = (0u32..1024)
                .filter(|outcome| outcome.count_ones() >= k)
                .map(|outcome| {
                    p.powi(outcome.count_ones() as i32) * (1.0 - p).powi(10 - outcome.count_ones() as i32)
                })
                .sum();
            assert!((binomial_tail(10, k, p) / sum - 1.0).abs() < 1e-12, "{k}");
        }
        assert_eq!(aligned_needed(10, p, 0.5), Some(0));
        assert_eq!(aligned_needed(10, p, 1e10), None);
    }

    #[test]
    fn the_four_centres_lie_at_the_distance_r() {
        let lines = [
            Line { normal: DVec2::new(0.3, -2.0), constant: 1.7 },
            Line { normal: DVec2::new(1.1, 0.4), constant: -0.2 },
        ];
        let four = centres(lines, 0.4).unwrap();
        for (k, at) in four.iter().enumerate() {
            assert!(lines.iter().all(|l| (l.distance(*at).abs() - 0.4).abs() < 1e-12), "{at}");
            assert!(four[..k].iter().all(|other| other.distance(*at) > 0.5));
        }
        assert_eq!(centres([lines[0], Line { constant: 3.0, ..lines[0] }], 0.4), None);
    }

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
