//! Rounding that repeats in the edges of both sides of a frame.

use super::side::levels::SideLevels;
use super::side::model::EdgeModel;
use crate::gauge::edge::estimation::levels::LevelCurve;
use crate::gauge::edge::estimation::noise::NoiseModel;
use crate::gauge::edge::estimation::rounding::{RoundedSide, noise_in_steps};
use crate::gauge::edge::estimation::side_survey::SideSurvey;
use crate::gauge::edge::image::scan_windows::Side;
use crate::gauge::edges::FrameEdges;

/// Step of a frame's grey scale and the noise behind its rounded grey values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rounding {
    /// Step, counts; 0 where there is none.
    pub(crate) step: f64,
    /// Standard deviation of the noise in shadow and light, counts.
    behind: [f64; 2],
}

/// A side after its fit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FittedSide<'a> {
    pub(crate) side: Side,
    pub(crate) levels: &'a SideLevels,
    pub(crate) model: &'a EdgeModel,
    /// Whether its light is clipped, so that its fit contains its own rounding.
    pub(crate) clipped: bool,
}

impl Rounding {
    /// From the photon transfer given, else from the scatter of the grey values of both sides;
    /// `levels` are those of shadow and light.
    pub(crate) fn of(
        sides: &[SideSurvey; 2],
        given: Option<NoiseModel>,
        levels: (f64, f64),
        step: f64,
    ) -> Self {
        if step <= 0.0 {
            return Self { step: 0.0, behind: [f64::INFINITY; 2] };
        }
        if let Some(given) = given {
            let sd = |level| given.variance(level).max(0.0).sqrt();
            return Self { step, behind: [sd(levels.0), sd(levels.1)] };
        }
        let [top, bottom] = [&sides[0].spread, &sides[1].spread];
        let behind = [0, 1].map(|k| {
            // Clipped light shows no noise of its own; rounding is not what limits it.
            step * noise_in_steps(top[k].with(bottom[k]), step)
        });
        // A crushed shadow shows no noise of its own: that of the light is its upper bound.
        let in_dark = top[0].with(bottom[0]).variance().map_or(behind[1], |_| behind[0]);
        Self { step, behind: [in_dark, behind[1]] }
    }

    /// Adds it to the uncertainty of either edge, except where the light is clipped.
    pub(crate) fn state(&self, sides: &[FittedSide<'_>; 2], out: &mut FrameEdges) {
        if self.step <= 0.0 || !RoundedSide::repeats(self.behind.map(|sd| sd / self.step)) {
            return;
        }
        let [top, bottom] = [sides[0].levels, sides[1].levels];
        let near = |a: f64, b: f64| (a - b).abs() < 0.5 * self.step;
        let alike = near(top.dark.mean, bottom.dark.mean) && near(top.light.mean, bottom.light.mean);
        let lines = [&mut out.top, &mut out.bottom].into_iter().zip(&mut out.figures.rounding_px);
        for (side, (line, stated)) in sides.iter().zip(lines) {
            if !side.clipped {
                *stated = self.of_side(side, alike).state(line);
            }
        }
    }

    fn of_side<'a>(&self, fitted: &FittedSide<'a>, alike: bool) -> RoundedSide<'a> {
        let FittedSide { side, levels, model, .. } = *fitted;
        let run = |curve: &LevelCurve| {
            let start = (f32::INFINITY, f32::NEG_INFINITY);
            let ends = curve.level.iter().fold(start, |(l, h), v| (l.min(*v), h.max(*v)));
            let share = f64::from(curve.length) / curve.level.len().max(1) as f64;
            f64::from(ends.1 - ends.0) * share.min(1.0) / self.step
        };
        RoundedSide {
            shape: &model.shape,
            sigma: model.blur.mean(),
            sign: f64::from(side.sign()),
            contrast: (levels.light.mean - levels.dark.mean) / self.step,
            noise: self.behind.map(|sd| sd / self.step),
            level_runs: [run(&levels.dark), run(&levels.light)],
            alike,
        }
    }
}
