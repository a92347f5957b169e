//! Levels of one side, pooled along the shaft.

use super::scan::ScanWindows;
use crate::gauge::edge::estimation::levels::{LevelCurve, LevelPool};
use crate::gauge::edge::estimation::noise::NoiseModel;
use crate::gauge::edge::image::window_layout::half;
use crate::gauge::edge::model::edge_spread::EdgeSpreadFunction;
use crate::gauge::settings::Levels;

/// The levels of shadow and light along a side.
#[derive(Clone, Debug, Default)]
pub(crate) struct SideLevels {
    pub(crate) dark: LevelCurve,
    pub(crate) light: LevelCurve,
}

/// What levels are pooled by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pooling<'a> {
    pub(crate) shape: &'a EdgeSpreadFunction,
    pub(crate) noise: &'a NoiseModel,
    /// Mean levels of shadow and light of the frame, counts.
    pub(crate) means: (f64, f64),
    pub(crate) levels: Levels,
}

impl SideLevels {
    /// Pools the levels along the shaft; false without a column.
    pub(crate) fn pool(&mut self, scan: &ScanWindows, by: &Pooling<'_>, pool: &mut LevelPool) -> bool {
        let knots = match by.levels {
            Levels::Pooled { max_knots } => max_knots,
            Levels::PerColumn {} => 33,
        };
        let windows = &scan.windows;
        let sd = |level: f64| (by.noise.variance(level) / windows.flat as f64).sqrt() as f32;
        let pooled = pool.pool(&windows.dark, sd(by.means.0), knots, &mut self.dark)
            && pool.pool(&windows.light, sd(by.means.1), knots, &mut self.light);
        if pooled && *by.shape != EdgeSpreadFunction::Gaussian {
            self.take_tails_off(scan, by.shape);
        }
        pooled
    }

    /// The flat ends of the windows still see a little of a long-tailed edge.
    fn take_tails_off(&mut self, scan: &ScanWindows, shape: &EdgeSpreadFunction) {
        let windows = &scan.windows;
        let (e_dark, e_light) =
            shape.flat_ends(scan.laid_out, windows.width, windows.flat, half(windows.width));
        let span = (e_light - e_dark) as f32;
        for (dark, light) in self.dark.level.iter_mut().zip(&mut self.light.level) {
            let contrast = (*light - *dark) / span;
            *dark -= contrast * e_dark as f32;
            *light = *dark + contrast;
        }
        let contrast = (self.light.mean - self.dark.mean) / f64::from(span);
        self.dark.mean -= contrast * e_dark;
        self.light.mean = self.dark.mean + contrast;
    }
}
