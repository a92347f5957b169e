//! Levels, noise and rounding of a frame before its edges are fitted.

use super::rounded_frame::Rounding;
use crate::gauge::edge::estimation::censored::Ends;
use crate::gauge::edge::estimation::noise::NoiseModel;
use crate::gauge::limit::limits;

limits! {
    /// When the area of its light centres a window no longer.
    SurveyLimits = "frame_survey";
    /// Standard deviation of an edge by the area of its window's light, px, from which on windows
    /// are centred by their edges instead. Windows are centred within 0.65 px, 0.15 px more than
    /// half a pixel: three standard deviations.
    noisy_area_px: f64 = 0.05;
}

/// What the frame states about itself.
pub(crate) struct FrameSurvey {
    pub(crate) noise: NoiseModel,
    /// Mean levels of both sides, counts.
    pub(crate) dark: f64,
    pub(crate) light: f64,
    pub(crate) ends: [Option<Ends>; 2],
    pub(crate) rounding: Rounding,
}

impl FrameSurvey {
    /// Whether noise moves the windows that the area of their light is to centre; not under clipped
    /// light, whose fit begins where they were centred.
    pub(crate) fn is_noisy(&self, width: usize) -> bool {
        let noise = self.noise.variance(0.5 * (self.dark + self.light)).sqrt() / (self.light - self.dark);
        self.ends == [None; 2] && noise * (width as f64).sqrt() > SurveyLimits::get().noisy_area_px
    }
}

/// State kept from a stream's last frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Last {
    /// Rows and columns.
    pub(crate) size: (usize, usize),
    /// Columns with both edges.
    pub(crate) valid: usize,
    /// Median residual.
    pub(crate) reduced_chi2: f64,
    /// Frames followed since the part was searched.
    pub(crate) frames: u32,
}
