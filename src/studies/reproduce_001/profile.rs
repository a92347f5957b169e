//! Profiles of the paper's size, which prints none: sums of four waves of 25 to 200 mm, scaled to a
//! peak to valley, drawn by seed.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// A profile: frequency, amplitude and phase of its waves.
pub(super) struct Profile {
    waves: Vec<[f64; 3]>,
    middle: f64,
    scale: f64,
}

impl Profile {
    /// A profile of a peak to valley, µm, over a length, mm.
    pub(super) fn drawn(seed: u64, range_um: f64, length_mm: f64) -> Self {
        let mut random = Pcg64::seed_from_u64(seed);
        let mut between = |from: f64, to: f64| random.random_range(from..to);
        let wave = |k: usize| {
            let (length, size) = (between(25.0, 200.0), between(0.3, 1.0) / (1.0 + k as f64));
            [TAU / length, size, between(0.0, TAU)]
        };
        let mut profile = Self { waves: (0..4).map(wave).collect(), middle: 0.0, scale: 1.0 };
        let fold = |(low, high): (f64, f64), v: f64| (low.min(v), high.max(v));
        let places = (0..=500).map(|k| length_mm * f64::from(k) / 500.0);
        let (low, high) = places.map(|x| profile.um(x)).fold((f64::INFINITY, f64::NEG_INFINITY), fold);
        (profile.middle, profile.scale) = (0.5 * (low + high), range_um / (high - low));
        profile
    }

    /// The value at a place, µm.
    pub(super) fn um(&self, x: f64) -> f64 {
        let sum: f64 = self.waves.iter().map(|[f, size, phase]| size * (f * x + phase).cos()).sum();
        self.scale * (sum - self.middle)
    }
}
