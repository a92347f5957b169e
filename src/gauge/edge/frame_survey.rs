//! Levels, noise and rounding of a frame before its edges are fitted.

use super::refusals::explain::{self, no_levels};
use super::rounded_frame::Rounding;
use super::side::levels::Pooling;
use super::stream_settings::StreamSettings;
use crate::gauge::edge::estimation::censored::Ends;
use crate::gauge::edge::estimation::noise::NoiseModel;
use crate::gauge::edge::estimation::side_survey::{GreyScaleLimits, SideSurvey};
use crate::gauge::edge::model::edge_spread::EdgeSpreadFunction;
use crate::gauge::edges::FrameRefused;
use crate::gauge::limit::limits;
use crate::gauge::settings::Levels;

limits! {
    /// When the area of its light centres a window no longer.
    SurveyLimits = "frame_survey";
    /// Standard deviation of an edge by the area of its window's light, px, from which on windows
    /// are centred by their edges instead. Windows are centred within 0.65 px, 0.15 px more than
    /// half a pixel: three standard deviations.
    noisy_area_px: f64 = 0.05;
}

/// What the frame states about itself.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameSurvey {
    pub(crate) noise: NoiseModel,
    /// Mean levels of both sides, counts.
    pub(crate) dark: f64,
    pub(crate) light: f64,
    /// Both sides by themselves, after either has taken over the ends that the other one shows.
    pub(crate) sides: [SideSurvey; 2],
    pub(crate) rounding: Rounding,
}

impl FrameSurvey {
    /// From the surveys of both sides.
    ///
    /// # Errors
    /// Refuses frames without levels, and too faint ones.
    pub(crate) fn of(
        mut sides: [SideSurvey; 2],
        settings: &StreamSettings,
        scale: GreyScaleLimits,
    ) -> Result<Self, FrameRefused> {
        let ends = sides.map(|side| side.ends);
        sides[0].share_ends(ends[1]);
        sides[1].share_ends(ends[0]);
        let [top, bottom] = &sides;
        let count = top.levels.count + bottom.levels.count;
        if count == 0.0 {
            return Err(no_levels());
        }
        let dark = (top.levels.dark + bottom.levels.dark) / count;
        let light = (top.levels.light + bottom.levels.light) / count;
        let floor = scale.floor(light - dark);
        let given = |floor| NoiseModel::given(settings.gauge.noise, settings.sign(), floor);
        let noise = given(floor).or_else(|| top.noise_with(bottom, (dark, light), floor));
        let noise = noise.ok_or_else(no_levels)?;
        let snr = (light - dark) / noise.variance(0.5 * (dark + light)).sqrt();
        if !(snr >= settings.gauge.min_snr) {
            return Err(explain::too_faint((dark, light), snr, settings.gauge.min_snr));
        }
        let rounding = Rounding::of(&sides, given(0.0), (dark, light), scale.step());
        Ok(Self { noise, dark, light, sides, rounding })
    }

    /// What the levels of a side are pooled by.
    pub(crate) fn pooling<'a>(&'a self, shape: &'a EdgeSpreadFunction, levels: Levels) -> Pooling<'a> {
        Pooling { shape, noise: &self.noise, means: (self.dark, self.light), levels }
    }

    /// Where the grey values of either side are clipped.
    pub(crate) fn ends(&self) -> [Option<Ends>; 2] {
        self.sides.map(|side| side.ends)
    }

    /// Whether noise moves the windows that the area of their light is to centre; not under clipped
    /// light, whose fit begins where they were centred.
    pub(crate) fn is_noisy(&self, width: usize) -> bool {
        let noise = self.noise.variance(0.5 * (self.dark + self.light)).sqrt() / (self.light - self.dark);
        self.ends() == [None; 2] && noise * (width as f64).sqrt() > SurveyLimits::get().noisy_area_px
    }
}
