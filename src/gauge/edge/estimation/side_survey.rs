//! Levels, noise and grey-scale ends of one side, before the other one is known.

use crate::gauge::edge::estimation::censored::Ends;
use crate::gauge::edge::estimation::noise::{NoiseLimits, NoiseModel, Spread};
use crate::gauge::edge::image::scan_windows::LevelSums;
use crate::gauge::limit::limits;

limits! {
    /// When one side's end of the grey scale is the other's, too.
    SideSurveyLimits = "side_survey";
    /// Distance of a mean level from an end that the other side shows, in standard deviations of
    /// the light's noise, within which the level stands at that end: noise then reaches it in 2.3 %
    /// of the pixels or more.
    at_the_end: f64 = 2.0;
}

/// Properties of the sensor known before a frame is evaluated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GreyScaleLimits {
    /// Variance of quantisation, counts²; 0 for frames that are not quantised.
    pub(crate) floor: f64,
}

impl GreyScaleLimits {
    /// Smallest variance of a pixel that is taken into account, counts².
    pub(crate) fn floor(self, contrast: f64) -> f64 {
        self.floor.max((1e-4 * contrast).powi(2)).max(1e-20)
    }

    /// That of grey values that come in steps, counts.
    pub(crate) fn of_step(step: f64) -> Self {
        Self { floor: step * step / 12.0 }
    }

    /// Smallest scale of differences, counts.
    pub(crate) fn least(self, contrast: f64) -> f32 {
        self.floor(contrast).sqrt().max(self.step() * NoiseLimits::get().least_of_counts) as f32
    }

    /// Step of the grey scale, counts; 0 where there is none.
    pub(crate) fn step(self) -> f64 {
        (12.0 * self.floor).sqrt()
    }
}

/// Levels, noise and grey-scale ends of one side, before the other one is known.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SideSurvey {
    pub(crate) levels: LevelSums,
    /// Where the side's grey values are clipped, in the dark and in the light; none where they are
    /// not.
    pub(crate) ends: Option<Ends>,
    /// Noise in the shadow and in the light.
    pub(crate) spread: [Spread; 2],
}

impl SideSurvey {
    /// Takes over an end that the other side shows, where this side's level stands at it: both
    /// edges are one camera's, and a side alone may be too short to show it.
    pub(crate) fn share_ends(&mut self, other: Option<Ends>) {
        let (Some(other), count) = (other, self.levels.count) else { return };
        if count == 0.0 {
            return;
        }
        let own = self.ends.unwrap_or(Ends { step: other.step, ..Ends::NONE });
        let LevelSums { dark, light, .. } = self.levels;
        let scatter = self.spread[1].variance().unwrap_or(0.0).sqrt();
        let near = SideSurveyLimits::get().at_the_end * scatter;
        let low = if own.low.is_infinite() && dark / count <= other.low + near { other.low } else { own.low };
        let high =
            if own.high.is_infinite() && light / count >= other.high - near { other.high } else { own.high };
        if (low, high) != (own.low, own.high) {
            self.ends = Some(Ends { low, high, ..own });
            for (end, spread) in [low, high].into_iter().zip(&mut self.spread) {
                if end.is_finite() {
                    *spread = Spread::default();
                }
            }
        }
    }

    /// The noise of both sides together, from the mean levels of shadow and light and the least
    /// variance, counts²; `None` of too few pixels.
    pub(crate) fn noise_with(
        &self,
        other: &Self,
        (dark, light): (f64, f64),
        floor: f64,
    ) -> Option<NoiseModel> {
        let [top, bottom] = [&self.spread, &other.spread];
        // Crushed shadow states no noise of its own.
        let in_dark = top[0].with(bottom[0]).variance().or_else(|| top[1].with(bottom[1]).variance())?;
        let in_light = top[1].with(bottom[1]).variance().unwrap_or(in_dark);
        Some(NoiseModel::through((dark, in_dark.max(floor)), (light, in_light.max(floor)), floor))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A level whose mean lies a standard deviation and a half below the end that the other side
    /// shows reaches it in 7 % of its pixels; one of three standard deviations stands by itself.
    #[test]
    fn a_level_within_two_deviations_of_the_other_sides_end_stands_at_it() {
        let differences: Vec<f32> = (0..400).map(|k| [-4.0, 2.0, 4.0, -2.0][k % 4]).collect();
        let spread = Spread::of(&differences, 1.0);
        let sd = spread.variance().unwrap().sqrt();
        let other = Ends { high: 250.0, step: 1.0, ..Ends::NONE };
        let ends = |below: f64| {
            let levels = LevelSums { dark: 2000.0, light: 100.0 * (250.0 - below * sd), count: 100.0 };
            let mut side = SideSurvey { levels, ends: None, spread: [spread; 2] };
            side.share_ends(Some(other));
            side.ends
        };
        assert_eq!(ends(1.5), Some(other));
        assert_eq!(ends(3.0), None);
    }
}
