//! The gauge by itself: checked settings, and streams that measure by them.

use std::num::NonZeroUsize;

use crate::frame::FrameView;
use crate::gauge::edge::edge_stream::EdgeStream;
use crate::gauge::edge::model::systematic_residual::SystematicResidual;
use crate::gauge::edge::parallel::Lanes;
use crate::gauge::edges::{FrameEdges, FrameRefused};
use crate::gauge::settings::{EsfModel, GaugeSettings};
use crate::setting::SettingError;

/// The gauge: settings, checked once.
///
/// ```
/// use shadowgauge::frame::{FrameView, PixelFormat, Pixels};
/// use shadowgauge::gauge::{Gauge, GaugeSettings};
///
/// // A sharp-edged shadow from row 40.5 to row 99.5 in a clean 8-bit frame of 140 x 64 pixels.
/// let (rows, columns) = (140, 64);
/// let grey = |row: usize| if (41..100).contains(&row) { 12 } else { 210 };
/// let pixels: Vec<u8> = (0..rows * columns).map(|i| grey(i / columns)).collect();
/// let view = FrameView::new(Pixels::U8(&pixels), PixelFormat::Mono8, rows, columns, columns)?;
/// let edges = Gauge::new(GaugeSettings::default())?.edges(&view)?;
/// let width = edges.width_px(32).ok_or("column 32 is a gap")?;
/// assert!((width - 59.0).abs() < 0.05, "{width}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Gauge {
    settings: GaugeSettings,
    systematic_residual: Option<SystematicResidual>,
}

impl Gauge {
    /// A gauge with checked settings.
    ///
    /// # Errors
    /// Names the first setting out of its range.
    pub fn new(settings: GaugeSettings) -> Result<Self, SettingError> {
        settings.validate()?;
        if settings.esf == (EsfModel::Optics {}) {
            let needs = "needs the table of a job's optics; a gauge by itself has none";
            return Err(SettingError::at("gauge.esf.optics", needs));
        }
        Ok(Self { settings, systematic_residual: None })
    }

    /// Expects of every edge the residual that a calibration's masters left
    /// (`Calibration::systematic_residual`): what they share with it the calibration has absorbed,
    /// and only what departs from it widens u or is flagged. The same model must be fitted as when
    /// they were measured; another one shows as a systematic residual.
    #[must_use]
    pub fn with_systematic_residual(self, systematic_residual: Option<&SystematicResidual>) -> Self {
        Self { systematic_residual: systematic_residual.cloned(), ..self }
    }

    /// The settings.
    pub fn settings(&self) -> &GaugeSettings {
        &self.settings
    }

    /// Edges of one frame by itself.
    ///
    /// # Errors
    /// Refuses frames that show no part with two edges.
    pub fn edges(&self, view: &FrameView<'_>) -> Result<FrameEdges, FrameRefused> {
        let mut edges = FrameEdges::default();
        self.stream().measure(view, &mut edges)?;
        Ok(edges)
    }

    /// A stream for many frames of one camera: keeps tables and buffers.
    pub fn stream(&self) -> EdgeStream {
        EdgeStream::new(self.settings.clone()).with_systematic_residual(self.systematic_residual.as_ref())
    }
}

impl Lanes {
    /// A given number of streams, usually one a core. The number belongs to the measurement, not to
    /// the machine: another number gives results that differ as those of two streams do, by
    /// thousandths of the noise.
    pub fn new(gauge: &Gauge, lanes: NonZeroUsize) -> Self {
        Self::of(&gauge.stream(), lanes)
    }
}
