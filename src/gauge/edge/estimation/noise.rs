//! The noise of a frame, from the frame: variance in the light and in the shadow, linear in
//! between.
//!
//! Differences of horizontally neighbouring flat pixels carry twice the variance of one pixel,
//! temporal noise and pixel-to-pixel response alike, and none of the light's slow variation.

use crate::gauge::limit::limits;
use crate::gauge::settings::Noise;
use crate::numerics::robust::{MEDIAN_TO_SD, upper_median};

limits! {
    /// What the scatter of whole counts shows of their noise.
    NoiseLimits = "noise";
    /// Scale of whole counts whose differences are 0 in the median, in steps of the grey scale: the
    /// median of what they round may be up to half a step.
    least_of_counts: f64 = MEDIAN_TO_SD * 0.5;
}

/// Noise variance as a function of the grey level: `offset + gain·level`, at least `floor`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NoiseModel {
    offset: f64,
    gain: f64,
    floor: f64,
}

impl NoiseModel {
    /// The line through the variances at two levels.
    pub(crate) fn through(dark: (f64, f64), light: (f64, f64), floor: f64) -> Self {
        let gain = (light.1 - dark.1) / (light.0 - dark.0).max(1e-9);
        Self { offset: dark.1 - gain * dark.0, gain, floor }
    }

    /// Photon transfer as given, or `None` where the noise is estimated from the frame.
    pub(crate) fn given(noise: Noise, sign: f32, floor: f64) -> Option<Self> {
        match noise {
            Noise::Estimated {} => None,
            Noise::PhotonTransfer { gain_counts_per_electron: k, read_noise_counts: read, black_counts } => {
                Some(Self { offset: read * read - k * black_counts, gain: f64::from(sign) * k, floor })
            }
        }
    }

    /// Variance at a grey level, counts².
    pub(crate) fn variance(&self, level: f64) -> f64 {
        (self.offset + self.gain * level).max(self.floor)
    }

    /// Smallest variance used, counts².
    pub(crate) fn floor(&self) -> f64 {
        self.floor
    }

    /// κ of the scoring tables: (v_light − v_dark)/v_mid, kept where weights stay finite.
    pub(crate) fn kappa(&self, dark: f64, light: f64) -> f64 {
        let (low, high) = (self.variance(dark), self.variance(light));
        (2.0 * (high - low) / (high + low)).clamp(-1.9, 1.9)
    }
}

/// Differences from which the cut is estimated.
const MEDIAN_OF: usize = 512;

/// Squares of the differences of two pixels, without outliers.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Spread {
    squares: f64,
    count: f64,
    seen: usize,
    /// Differences of more than two of the least scales: of whole counts, of two counts and more.
    wide: usize,
}

impl Spread {
    /// Of some differences; `least` is the smallest scale used, counts.
    pub(crate) fn of(differences: &[f32], least: f32) -> Self {
        // The median only sets the cut, far out: a sample of the differences gives it well enough.
        let mut sample = [0.0_f32; MEDIAN_OF];
        let step = differences.len().div_ceil(MEDIAN_OF).max(1);
        let mut taken = 0;
        for (place, difference) in sample.iter_mut().zip(differences.iter().step_by(step)) {
            *place = difference.abs();
            taken += 1;
        }
        let Some(median) = upper_median(&mut sample[..taken], f32::total_cmp) else {
            return Self::default();
        };
        let cut = 6.0 * (MEDIAN_TO_SD as f32 * median).max(least);
        let (mut squares, mut count) = ([0.0_f64; 4], [0.0_f64; 4]);
        let (fours, rest) = differences.as_chunks::<4>();
        for four in fours {
            for lane in 0..4 {
                let inside = if four[lane].abs() < cut { 1.0 } else { 0.0 };
                let difference = f64::from(four[lane]);
                squares[lane] += inside * difference * difference;
                count[lane] += inside;
            }
        }
        for difference in rest.iter().filter(|d| d.abs() < cut) {
            squares[0] += f64::from(*difference).powi(2);
            count[0] += 1.0;
        }
        // Half-way between one and two steps of whole counts.
        let far = 1.5 / NoiseLimits::get().least_of_counts as f32 * least;
        let wide = differences.iter().filter(|d| d.abs() > far).count();
        Self { squares: squares.iter().sum(), count: count.iter().sum(), seen: differences.len(), wide }
    }

    /// Both together.
    pub(crate) fn with(self, other: Self) -> Self {
        Self {
            squares: self.squares + other.squares,
            count: self.count + other.count,
            seen: self.seen + other.seen,
            wide: self.wide + other.wide,
        }
    }

    /// Share of the differences that lie more than a step of the grey scale apart; 0 without any.
    pub(crate) fn wide_share(self) -> f64 {
        self.wide as f64 / self.seen.max(1) as f64
    }

    /// Variance of one pixel; `None` from fewer than 16 differences.
    pub(crate) fn variance(self) -> Option<f64> {
        (self.seen >= 16 && self.count > 0.0).then_some(0.5 * self.squares / self.count)
    }
}
