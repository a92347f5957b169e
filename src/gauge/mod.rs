//! The instrument: frames -> edges -> calibrated diameters with uncertainty. It never sees the scene.

mod axis;
pub mod axis_line;
mod axis_pose;
mod axis_slope;
mod axis_zero;
pub mod bench;
mod block_scatter;
mod blur;
mod blur_share;
mod blur_track;
mod both_sides;
pub mod budget;
mod budget_conditions;
mod calibration;
mod calibration_error;
mod caliper;
mod censored;
mod clipped;
mod coarse;
mod column_means;
mod columns;
mod components;
mod coverage;
mod curvature;
mod diameter;
mod edge_misfit;
mod edge_table;
mod edges;
mod esf;
mod explain;
mod falloff;
mod finder;
pub mod form;
mod gate;
mod grey_ends;
mod grey_step;
mod lanes;
mod largest_reading;
mod learn;
mod levels;
mod light_field;
mod median;
mod model;
pub mod monte_carlo;
mod narrow;
mod noise;
mod normal_table;
mod other_views;
pub mod photon_transfer;
mod pixels;
pub mod plausibility;
mod repeated;
pub mod ring;
mod rings;
mod rounded_frame;
mod rounding;
mod scene;
mod score;
pub mod series;
pub mod size;
pub mod stated;
pub mod statistics;

mod settings;
mod settled;
mod shadows;
mod shape_terms;
mod side;
mod soft_knee;
mod station;
mod stretch;
mod stuck_rows;
mod survey;
mod table;
pub mod turn_form;
mod turn_scatter;
mod valleys;
mod window;
mod wire;
mod wire_frame;
mod wire_rounding;

pub use axis_pose::Pose;
pub use axis_zero::AxisZero;
pub use calibration::{
    CALIBRATION_VERSION, Calibration, CalibrationError, MasterCertificate, MasterFigure, MasterMeasurement,
};
pub use caliper::{LargestCaliper, largest_caliper, largest_caliper_over};
pub use diameter::ColumnDiameters;
pub use edge_misfit::{EdgeMisfit, MisfitLesson};
pub use edge_table::EdgeTable;
pub use edges::{Edge, EdgeState, FrameEdges, FrameFigures, FrameRefused, Mean};
pub use finder::EdgeStream;
pub use lanes::Lanes;
pub use learn::LEAST_TRAVEL;
pub use settings::{
    Blur, EsfModel, EsfSamples, GaugeSettings, GaugeSettingsError, Levels, Noise, Polarity, Rejection,
    StationSettings, Which,
};
pub use settled::SettledStream;
pub use shadows::ShadowsSeen;
pub(crate) use station::Seen;
pub use station::StationAverager;
pub use stretch::LEAST_STRETCH;
pub use stretch::crests::crest_pitch_px;

use crate::frame::FrameView;

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
    misfit: Option<EdgeMisfit>,
}

impl Gauge {
    /// A gauge with checked settings.
    ///
    /// # Errors
    /// Names the first setting out of its range.
    pub fn new(settings: GaugeSettings) -> Result<Self, GaugeSettingsError> {
        settings.validate()?;
        if settings.esf == (EsfModel::Optics {}) {
            let right = "the table of a job's optics; a gauge by itself has none";
            return Err(GaugeSettingsError { key: "esf.optics", value: f64::NAN, right });
        }
        Ok(Self { settings, misfit: None })
    }

    /// Expects of every edge the residual that a calibration's masters left ([`Calibration::misfit`]): what they share with it
    /// the calibration has absorbed, and only what departs from it widens u or is flagged. The same model must be fitted as
    /// when they were measured; another one shows as a misfit.
    #[must_use]
    pub fn expecting(self, misfit: Option<&EdgeMisfit>) -> Self {
        Self { misfit: misfit.cloned(), ..self }
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
        EdgeStream::new(self.settings.clone()).expecting(self.misfit.as_ref())
    }
}
