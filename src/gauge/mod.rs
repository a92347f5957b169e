//! The instrument: frames -> edges -> calibrated diameters with uncertainty. It never sees the scene.

mod blur;
mod calibration;
mod caliper;
mod clipped;
mod coarse;
mod diameter;
mod edges;
mod finder;
pub mod form;
mod gate;
pub mod judgement;
mod levels;
mod model;
mod noise;
pub mod photon_transfer;
mod pixels;
pub mod ring;
mod score;
pub mod size;
pub mod statistics;

mod settings;
mod side;
mod station;
mod table;
mod window;

pub use calibration::{
    CALIBRATION_VERSION, Calibration, CalibrationError, MasterCertificate, MasterFigure, MasterMeasurement,
};
pub use caliper::{LargestCaliper, largest_caliper};
pub use diameter::{ColumnDiameters, Pose};
pub use edges::{Edge, EdgeState, FrameEdges, FrameFigures, FrameRefused, Mean};
pub use finder::EdgeStream;
pub use settings::{Blur, GaugeSettings, GaugeSettingsError, Levels, Noise, Polarity, StationSettings};
pub use station::StationAverager;

use crate::frame::FrameView;

/// The gauge: settings, checked once.
#[derive(Clone, Debug)]
pub struct Gauge {
    settings: GaugeSettings,
}

impl Gauge {
    /// A gauge with checked settings.
    ///
    /// # Errors
    /// Names the first setting out of its range.
    pub fn new(settings: GaugeSettings) -> Result<Self, GaugeSettingsError> {
        settings.validate()?;
        Ok(Self { settings })
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
        EdgeStream::new(self.settings.clone())
    }
}
