//! The lathe's scatter by the repeatability of the paper's Table 3.

use glam::DVec2;
use rand::SeedableRng as _;
use rand_distr::{Distribution as _, StandardNormal};

use super::cut::Cut;

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
    /// of every workpiece and program is a position of its own.
    pub(super) fn slides_mm(&self, cut: &Cut<'_>, piece: u32, element: usize) -> DVec2 {
        let number = [cut.workpiece.number(), cut.program as usize, piece as usize, element]
            .into_iter()
            .fold(0_u64, |number, next| (number << 16) | next as u64);
        let mut random =
            rand_pcg::Pcg64::seed_from_u64(self.seed ^ number.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        self.spread_mm * DVec2::new(draw(), draw())
    }
}
