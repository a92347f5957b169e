//! Centres of circles that touch both edges (equations 8 to 10 of the paper).

use glam::DVec2;

/// A line k·x + b·y + c = 0 (equations 8 and 9).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Line {
    /// k and b.
    pub normal: DVec2,
    /// c.
    pub constant: f64,
}

impl Line {
    /// Signed distance of a point.
    pub(crate) fn distance(&self, at: DVec2) -> f64 {
        (self.normal.dot(at) + self.constant) / self.normal.length()
    }
}

/// Equation 10: the four points at the distance `r` from both lines; none of parallel lines.
pub(crate) fn centres([one, other]: [Line; 2], r: f64) -> Option<[DVec2; 4]> {
    let determinant = one.normal.perp_dot(other.normal);
    let at = |first: f64, second: f64| {
        let (f, g) =
            (first * one.normal.length() - one.constant, second * other.normal.length() - other.constant);
        DVec2::new(f * other.normal.y - g * one.normal.y, g * one.normal.x - f * other.normal.x) / determinant
    };
    let four = [at(r, r), at(r, -r), at(-r, r), at(-r, -r)];
    four.iter().all(|p| p.is_finite()).then_some(four)
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
