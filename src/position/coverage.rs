//! Which angles the frames of a scan leave out.

/// Steps of the half turn over which a diameter repeats: 0.1°, a tenth of the step of a scan in
/// whole degrees.
const STEPS: usize = 1800;
const STEP_DEG: f64 = 180.0 / STEPS as f64;
/// A gap is larger than this many usual steps: between one frame missing (2) and none (1).
const GAP_STEPS: f64 = 1.5;

/// Angles at which diameters were seen, modulo half a turn, in memory that does not grow.
#[derive(Clone, Debug, PartialEq)]
pub struct AngleCover {
    seen: Vec<bool>,
}

/// What is not covered.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Uncovered {
    /// Angles seen, modulo half a turn.
    pub angles: usize,
    /// Gaps larger than this are listed, degrees.
    pub larger_than_deg: f64,
    /// Gaps, from and to, degrees of the half turn; one that runs over its end has `to` above 180.
    pub uncovered_deg: Vec<(f64, f64)>,
}

impl Default for AngleCover {
    fn default() -> Self {
        Self { seen: vec![false; STEPS] }
    }
}

impl AngleCover {
    /// A frame at an angle, degrees.
    pub fn add(&mut self, angle_deg: f64) {
        let step = (angle_deg.rem_euclid(180.0) / STEP_DEG).round();
        if step.is_finite() {
            self.seen[step as usize % STEPS] = true;
        }
    }

    /// Takes in the angles of another one.
    pub fn join(&mut self, other: &Self) {
        self.seen.iter_mut().zip(&other.seen).for_each(|(own, other)| *own |= other);
    }

    /// The gaps larger than one and a half times the usual step, which is the median.
    pub fn uncovered(&self) -> Uncovered {
        let seen: Vec<usize> = (0..STEPS).filter(|step| self.seen[*step]).collect();
        let Some(&first) = seen.first() else {
            return Uncovered { uncovered_deg: vec![(0.0, 180.0)], ..Uncovered::default() };
        };
        let next = seen[1..].iter().copied().chain([first + STEPS]);
        let gaps: Vec<(usize, usize)> = seen.iter().copied().zip(next).collect();
        let mut lengths: Vec<usize> = gaps.iter().map(|(a, b)| b - a).collect();
        lengths.sort_unstable();
        // a step more, because angles are rounded to whole ones
        let limit = GAP_STEPS * lengths[(lengths.len() - 1) / 2] as f64 + 1.0;
        let deg = |step: usize| step as f64 * STEP_DEG;
        let large = gaps.iter().filter(|(a, b)| gaps.len() == 1 || (b - a) as f64 > limit);
        Uncovered {
            angles: seen.len(),
            larger_than_deg: limit * STEP_DEG,
            uncovered_deg: large.map(|(a, b)| (deg(*a), deg(*b))).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(angles: impl IntoIterator<Item = f64>) -> Uncovered {
        let mut cover = AngleCover::default();
        angles.into_iter().for_each(|a| cover.add(a));
        cover.uncovered()
    }

    #[test]
    fn gaps_are_those_that_were_left_out() {
        let whole = || (0..16).map(|i| 11.25 * f64::from(i));
        assert_eq!(of(whole()).uncovered_deg, []);
        // the other half turn shows the same diameters
        assert_eq!(of(whole().map(|a| if a > 80.0 { a + 180.0 } else { a })).uncovered_deg, []);
        let missing = of(whole().filter(|a| *a != 45.0));
        assert_eq!(missing.angles, 15);
        let (from, to) = missing.uncovered_deg[0];
        assert!((from - 33.75).abs() < 0.06 && (to - 56.25).abs() < 0.06, "{missing:?}");
        // over the end of the half turn
        let (from, to) = of(whole().filter(|a| *a > 20.0)).uncovered_deg[0];
        assert!((from - 168.75).abs() < 0.06 && (to - 202.5).abs() < 0.06, "{from} {to}");
        assert_eq!(of([]).uncovered_deg, [(0.0, 180.0)]);
        assert_eq!(of([30.0]).uncovered_deg, [(30.0, 210.0)]);
        let cluster = of([0.0, 1.0, 2.0, 3.0]);
        assert_eq!(cluster.uncovered_deg, [(3.0, 180.0)]);
    }

    #[test]
    fn covers_are_joined() {
        let mut a = AngleCover::default();
        a.add(-30.0);
        let mut b = AngleCover::default();
        b.add(60.0);
        a.join(&b);
        assert_eq!(a.uncovered().angles, 2);
        a.add(f64::NAN);
        assert_eq!(a.uncovered().angles, 2);
    }
}
