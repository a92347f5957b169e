//! The instrument: frames -> edges -> calibrated diameters with uncertainty. It has no access to
//! the scene.
//!
//! In: [`FrameView`](crate::frame::FrameView)s of a camera, [`GaugeSettings`], a [`Calibration`].
//! Out: [`FrameEdges`] in px, `ColumnDiameters` and a
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
pub(crate) mod diameter;
mod edge;
mod edges;
pub mod form;
mod instrument;
pub(crate) mod limit;
pub(crate) mod ring;
pub(crate) mod sensor;
mod settings;
pub(crate) mod thresholds;
pub(crate) mod uncertainty;
mod width;

pub(crate) use diameter::{axis_line, plausibility};
#[cfg(test)]
pub(crate) use form::size;
pub(crate) use sensor::photon_transfer;
pub use uncertainty::stated;
pub(crate) use uncertainty::{budget, monte_carlo};

pub use calibration::{Calibration, MasterCertificate, MasterMeasurement};
pub(crate) use calibration::{CalibrationError, MasterFigure};
#[cfg(test)]
pub(crate) use diameter::ColumnDiameter;
#[cfg(feature = "render")]
pub(crate) use diameter::station_mean::StationColumns;
pub(crate) use diameter::{ColumnDiameters, StationAverager};
pub(crate) use edge::edge_stream::EdgeStream;
pub(crate) use edge::estimation::model_bias::ResidualAccumulator;
pub(crate) use edge::estimation::slanted_edge::least_travel_px;
pub(crate) use edge::model::edge_table::EdgeTable;
pub(crate) use edge::model::systematic_residual::SystematicResidual;
pub(crate) use edge::parallel::Lanes;
pub(crate) use edge::settled::SettledStream;
#[cfg(test)]
pub(crate) use edges::EdgeState;
pub use edges::FrameEdges;
pub(crate) use edges::{Edge, FrameRefused, ShadowsSeen};
pub use instrument::Gauge;
pub(crate) use limit::{Limit, replace as replace_limit};
pub(crate) use settings::{EsfModel, EsfSamples, Rejection, Which};
pub use settings::{GaugeSettings, Polarity};
#[cfg(test)]
pub(crate) use settings::{Levels, StationSettings};
pub(crate) use width::axis_pose::Pose;
pub(crate) use width::largest_caliper::{LargestCaliper, largest_caliper, largest_caliper_over};
pub(crate) use width::stretch::crests::crest_pitch_px;
pub(crate) use width::stretch::largest_value::LEAST_STRETCH;
