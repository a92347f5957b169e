//! The lathe's scatter by the repeatability of the paper's Table 3.

use glam::DVec2;
use rand::SeedableRng as _;
use rand_distr::{Distribution as _, StandardNormal};

/// Repeatability over standard deviation: R = 4·s of positions approached from one side
/// (ISO 230-2:2014, 3.18).
const SPREADS: f64 = 4.0;

/// Slides that stop off their places.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scatter {
    /// Standard deviations along X (radial) and Z, mm.
    spread_mm: DVec2,
    seed: u64,
}

impl Scatter {
    pub(super) fn new(repeatability_mm: [f64; 2], seed: u64) -> Self {
        Self { spread_mm: DVec2::from(repeatability_mm) / SPREADS, seed }
    }

    pub(super) fn slides_um(&self) -> [f64; 2] {
        (1e3 * self.spread_mm).to_array()
    }

    /// How far the slides stand off while they follow an element of the outline, mm: every element
    /// (kind of workpiece, program, workpiece, piece of the outline) is a position of its own.
    pub(super) fn slides_mm(&self, element: [usize; 4]) -> DVec2 {
        let number = element.into_iter().fold(0_u64, |number, next| (number << 16) | next as u64);
        let mut random =
            rand_pcg::Pcg64::seed_from_u64(self.seed ^ number.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        self.spread_mm * DVec2::new(draw(), draw())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_scatter_apart_by_a_quarter_of_the_repeatability() {
        let scatter = Scatter::new([0.004, 0.005], 3);
        let draws: Vec<DVec2> = (0..4000).map(|k| scatter.slides_mm([1 + k % 4, k % 6, k, k % 5])).collect();
        let n = draws.len() as f64;
        let mean = draws.iter().sum::<DVec2>() / n;
        let square = draws.iter().map(|d| *d * *d).sum::<DVec2>() / n;
        // the standard deviation of a mean of 4000 is 1/63, of a mean square √2/63
        assert!((mean.x / 0.001).abs() < 0.06 && (mean.y / 0.00125).abs() < 0.06, "{mean}");
        assert!(
            (square.x / 1e-6 - 1.0).abs() < 0.09 && (square.y / 1.5625e-6 - 1.0).abs() < 0.09,
            "{square}"
        );
        assert_eq!(scatter.slides_mm([1, 2, 3, 4]), scatter.slides_mm([1, 2, 3, 4]));
        assert_ne!(scatter.slides_mm([1, 2, 3, 4]), scatter.slides_mm([1, 2, 4, 3]));
    }
}
