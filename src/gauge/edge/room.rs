//! What an edge needs of a frame, from settings and blur alone: for the choice of optics, before a
//! frame is taken.

use crate::gauge::edge::image::window_layout::window_width;
use crate::gauge::edge::refusals::other_views::OtherViewLimits;
use crate::gauge::edge::stream_settings::StreamSettings;
use crate::gauge::edge::wire::frame::WireFrameLimits;
use crate::gauge::settings::GaugeSettings;

/// The room of an edge, px.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EdgeRoom {
    /// Pixels either side of the edge that its window holds: light that is needed beside a part.
    pub(crate) beside_px: f64,
    /// The same of the longest window, which the widest blur takes.
    pub(crate) most_beside_px: f64,
    /// Blur of the edge model, σ: the one given, or a table's own.
    pub(crate) blur_px: f64,
    /// Blurs that are accepted, σ from and to.
    pub(crate) blur_range_px: [f64; 2],
    /// Thinnest wire that is measured where `gauge.min_diameter_px` allows it.
    pub(crate) least_wire_px: f64,
}

impl EdgeRoom {
    /// The room of an edge of the settings' model, with this blur where the model is the Gaussian.
    pub(crate) fn of(settings: &GaugeSettings, blur_px: f64) -> Self {
        let shape = StreamSettings::new(settings.clone()).shape;
        let sigma = shape.own_sigma().unwrap_or(blur_px);
        let in_blurs = WireFrameLimits::get().least_in_blurs;
        Self {
            beside_px: (window_width(&shape, sigma) / 2) as f64,
            most_beside_px: (window_width(&shape, shape.most_sigma()) / 2) as f64,
            blur_px: sigma,
            blur_range_px: [shape.least_sigma(), shape.most_sigma()],
            least_wire_px: OtherViewLimits::get().smallest_px.max(in_blurs * sigma),
        }
    }
}
