//! Frames of one camera, whichever it is: an area camera's by themselves, a line camera's readings
//! among those before them.

use super::acceptance::check;
use super::estimation::model_bias::ResidualAccumulator;
use super::model::systematic_residual::SystematicResidual;
use super::narrow::Narrow;
use super::stream::{AreaStream, StreamLimits};
use crate::frame::FrameView;
use crate::gauge::edges::{FrameEdges, FrameRefused};
use crate::gauge::settings::GaugeSettings;

/// Finds edges in the frames of one stream; keeps tables and buffers between them.
#[derive(Clone, Debug)]
pub struct EdgeStream {
    area: AreaStream,
    /// Readings of a line camera.
    pub(super) narrow: Option<Narrow>,
}

impl EdgeStream {
    /// A stream without any frame.
    pub fn new(settings: GaugeSettings) -> Self {
        Self { area: AreaStream::new(settings), narrow: None }
    }

    /// Takes residuals relative to the systematic residual that the masters left of the edge model.
    #[must_use]
    pub(crate) fn with_systematic_residual(self, reduced_chi2: Option<&SystematicResidual>) -> Self {
        Self { area: self.area.with_systematic_residual(reduced_chi2), ..self }
    }

    /// Leaves a frame to the thread that it is given to: where whole frames are shared out,
    /// splitting them only costs.
    #[must_use]
    pub(crate) fn unsplit(self) -> Self {
        Self { area: self.area.unsplit(), ..self }
    }

    /// The settings it measures by.
    pub fn settings(&self) -> &GaugeSettings {
        self.area.settings()
    }

    /// Adds what the edges of the frame just measured leave of the edge model.
    pub(crate) fn accumulate(&mut self, residuals: &mut ResidualAccumulator, measured: &FrameEdges) {
        match &mut self.narrow {
            Some(narrow) => narrow.accumulate(residuals),
            None => self.area.accumulate(residuals, measured),
        }
    }

    /// Discards the state kept from earlier frames.
    pub fn restart(&mut self) {
        self.narrow = None;
        self.area.restart();
    }

    /// Measures a frame into `out`.
    ///
    /// # Errors
    /// Refuses frames that show no part with two edges: black, white, noise, too small, not finite.
    pub fn measure(&mut self, view: &FrameView<'_>, out: &mut FrameEdges) -> Result<(), FrameRefused> {
        if view.columns() >= StreamLimits::get().least_columns {
            return self.area.measure(view, out);
        }
        check(view)?;
        self.measure_readings(view, out)
    }

    /// Measures a frame of a few columns among the readings before it.
    fn measure_readings(&mut self, view: &FrameView<'_>, out: &mut FrameEdges) -> Result<(), FrameRefused> {
        let kept = self.narrow.take().filter(|narrow| narrow.fits(view));
        let mut narrow = kept.unwrap_or_else(|| Narrow::new(&self.area, view));
        let measured = narrow.measure(view, out);
        self.narrow = Some(narrow);
        measured
    }
}
