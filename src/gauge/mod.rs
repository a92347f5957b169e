//! The instrument: frames -> edges -> calibrated diameters with uncertainty. It never sees the scene.

pub mod calibration;
pub mod diameter;
mod edge;
mod edges;
pub mod form;
mod instrument;
mod range_check;
pub mod ring;
pub mod sensor;
mod settings;
pub mod uncertainty;
mod width;

pub use diameter::{axis_line, plausibility};
pub use form::size;
pub use sensor::photon_transfer;
pub use uncertainty::{budget, monte_carlo, stated};

pub use calibration::{
    AxisZero, CALIBRATION_VERSION, Calibration, CalibrationError, MasterCertificate, MasterFigure,
    MasterMeasurement,
};
pub use diameter::ColumnDiameters;
pub use diameter::StationAverager;
pub(crate) use diameter::stations::Seen;
pub use edge::edge_stream::EdgeStream;
pub use edge::estimation::model_bias::MisfitLesson;
pub use edge::estimation::slanted_edge::LEAST_TRAVEL;
pub use edge::model::edge_table::EdgeTable;
pub use edge::model::systematic_residual::EdgeMisfit;
pub use edge::parallel::Lanes;
pub use edges::ShadowsSeen;
pub use edges::{Edge, EdgeState, FrameEdges, FrameFigures, FrameRefused, Mean};
pub use instrument::Gauge;
pub use settings::{
    Blur, EsfModel, EsfSamples, GaugeSettings, GaugeSettingsError, Levels, Noise, Polarity, Rejection,
    StationSettings, Which,
};
pub use width::axis_pose::Pose;
pub use width::largest_caliper::{LargestCaliper, largest_caliper, largest_caliper_over};
pub use width::stretch::crests::crest_pitch_px;
pub use width::stretch::largest_value::LEAST_STRETCH;
