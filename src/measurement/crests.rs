//! Threads and knurls: a frame whose columns are refused because they depart from their neighbours
//! or are steep is measured again as an outline of crests and roots, and the result is kept where
//! it is one.

use crate::frame::FrameView;
use crate::gauge::{Edge, EdgeStream, FrameEdges, FrameRefused, Gauge, GaugeSettings, crest_pitch_px};
use crate::profile::Reason;

/// Share of the columns with both edges below which a frame is measured again.
const FEW: f64 = 0.5;

/// Measures outlines of crests and roots.
pub(super) struct CrestStream {
    settings: GaugeSettings,
    stream: Option<EdgeStream>,
    edges: FrameEdges,
}

impl CrestStream {
    /// As `settings`, without rejection.
    pub(super) fn new(settings: &GaugeSettings) -> Self {
        Self { settings: settings.clone().for_crests(), stream: None, edges: FrameEdges::default() }
    }

    /// Exchanges the frame's edges for those of its crests, and gives their pitch, px, where few
    /// columns of the first measurement have edges and the outline is periodic.
    pub(super) fn measure(
        &mut self,
        first: Result<(), &FrameRefused>,
        edges: &mut FrameEdges,
        view: &FrameView<'_>,
    ) -> Option<f64> {
        let poor = match first {
            Ok(()) => (edges.valid() as f64) < FEW * edges.columns() as f64 && is_crested(edges),
            Err(refused) => matches!(
                refused.reason,
                Reason::NoEdge | Reason::Outlier | Reason::Steep | Reason::Residual | Reason::Contaminated
            ),
        };
        if !poor {
            return None;
        }
        if self.stream.is_none() {
            self.stream = Gauge::new(self.settings.clone()).ok().map(|gauge| gauge.stream());
        }
        self.stream.as_mut()?.measure(view, &mut self.edges).ok()?;
        let pitch_px = crest_pitch_px(&self.edges)?;
        std::mem::swap(edges, &mut self.edges);
        Some(pitch_px)
    }
}

/// Whether most refusals are for steepness or departure from the neighbours (flanks and roots), not
/// for the residual (contamination).
fn is_crested(edges: &FrameEdges) -> bool {
    let reasons =
        || edges.top.iter().chain(&edges.bottom).filter(|e| !e.is_usable()).filter_map(Edge::reason);
    let by_form = reasons().filter(|r| matches!(r, Reason::Steep | Reason::Outlier)).count();
    2 * by_form > reasons().count()
}
