//! The instrument: frames -> edges -> calibrated diameters with uncertainty. It has no access to
//! the scene.
//!
//! In: [`FrameView`](crate::frame::FrameView)s of a camera, [`GaugeSettings`], a [`Calibration`].
//! Out: [`FrameEdges`] in px, [`ColumnDiameters`] and a
//! [`DiameterProfile`](crate::profile::DiameterProfile) in mm, each value with u or a gap with its
//! reason.
//!
//! From below, and imports point down only: `settings`, `edges` (results) → `form`, `sensor` →
//! `edge` (one frame to edges) → `width` (px) → `calibration` (px to mm) → `diameter` (mm) →
//! `uncertainty` (budgets) → `ring` (parts seen end-on); `instrument` is the gauge that all begin
//! with. A file imports others by their own path, not through the `mod.rs` above it.
//!
//! One more room is one more folder with a `mod.rs` like these, one line here and one in the order
//! that `tests/architecture.rs` holds.

pub mod calibration;
pub mod diameter;
mod edge;
mod edges;
pub mod form;
mod instrument;
pub(crate) mod limit;
pub mod ring;
pub mod sensor;
mod settings;
pub mod thresholds;
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
#[cfg(feature = "render")]
pub(crate) use diameter::station_mean::StationColumns;
pub use diameter::{ColumnDiameter, ColumnDiameters, StationAverager};
pub use edge::edge_stream::EdgeStream;
pub use edge::estimation::model_bias::ResidualAccumulator;
pub use edge::estimation::slanted_edge::least_travel_px;
pub use edge::model::edge_table::EdgeTable;
pub use edge::model::systematic_residual::SystematicResidual;
pub use edge::parallel::Lanes;
pub use edge::settled::SettledStream;
pub use edges::{Edge, EdgeState, FrameEdges, FrameFigures, FrameRefused, Mean, ShadowsSeen};
pub use instrument::Gauge;
pub use limit::{Limit, replace as replace_limit};
pub use settings::{
    Blur, EsfModel, EsfSamples, GaugeSettings, Levels, Noise, Polarity, Rejection, StationSettings, Which,
};
pub use width::axis_pose::Pose;
pub use width::largest_caliper::{LargestCaliper, largest_caliper, largest_caliper_over};
pub use width::stretch::crests::crest_pitch_px;
pub use width::stretch::largest_value::LEAST_STRETCH;
