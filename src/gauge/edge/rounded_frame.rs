//! Rounding that repeats in the edges of both sides of a frame.

use super::side::SideState;
use crate::gauge::edge::estimation::levels::LevelCurve;
use crate::gauge::edge::estimation::noise::NoiseModel;
use crate::gauge::edge::estimation::rounding::{RoundedSide, noise_in_steps};
use crate::gauge::edges::FrameEdges;

/// Step of a frame's grey scale and the noise behind its rounded grey values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rounding {
    /// Step, counts; 0 where there is none.
    pub(crate) step: f64,
    /// Standard deviation of the noise in shadow and light, counts.
    behind: [f64; 2],
}

impl Rounding {
    /// From the photon transfer given, else from the scatter of the grey values of both sides;
    /// `levels` are those of shadow and light.
    pub(crate) fn of(
        sides: &[SideState; 2],
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
        let [top, bottom] = [&sides[0].figures.survey.spread, &sides[1].figures.survey.spread];
        let behind = [0, 1].map(|k| {
            // Clipped light shows no noise of its own; rounding is not what limits it.
            step * noise_in_steps(top[k].with(bottom[k]), step)
        });
        // A crushed shadow shows no noise of its own: that of the light is its upper bound.
        let in_dark = top[0].with(bottom[0]).variance().map_or(behind[1], |_| behind[0]);
        Self { step, behind: [in_dark, behind[1]] }
    }

    /// Adds it to the uncertainty of either edge, except where the light is clipped, whose fit
    /// contains its own.
    pub(crate) fn state(&self, sides: &[SideState; 2], clipped: [bool; 2], out: &mut FrameEdges) {
        if self.step <= 0.0 || !RoundedSide::repeats(self.behind.map(|sd| sd / self.step)) {
            return;
        }
        let [top, bottom] = sides;
        let near = |a: f64, b: f64| (a - b).abs() < 0.5 * self.step;
        let alike = near(top.dark.mean, bottom.dark.mean) && near(top.light.mean, bottom.light.mean);
        let lines = [&mut out.top, &mut out.bottom].into_iter().zip(&mut out.figures.rounding_px);
        for ((side, (line, stated)), clipped) in sides.iter().zip(lines).zip(clipped) {
            if !clipped {
                *stated = self.of_side(side, alike).state(line);
            }
        }
    }

    fn of_side<'a>(&self, side: &'a SideState, alike: bool) -> RoundedSide<'a> {
        let run = |curve: &LevelCurve| {
            let start = (f32::INFINITY, f32::NEG_INFINITY);
            let ends = curve.level.iter().fold(start, |(l, h), v| (l.min(*v), h.max(*v)));
            let share = f64::from(curve.length) / curve.level.len().max(1) as f64;
            f64::from(ends.1 - ends.0) * share.min(1.0) / self.step
        };
        RoundedSide {
            shape: &side.shape,
            sigma: side.blur.mean(),
            sign: f64::from(side.windows.side.sign()),
            contrast: (side.light.mean - side.dark.mean) / self.step,
            noise: self.behind.map(|sd| sd / self.step),
            level_runs: [run(&side.dark), run(&side.light)],
            alike,
        }
    }
}
