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
//! `uncertainty` (budgets) → `ring` (parts seen end-on) → `nose` (the nose of a back-lit insert) →
//! `generatrix` (lines and arcs of a shaft's silhouette at any angle) → `flank` (the worn land of a
//! front-lit one); `instrument` is the gauge that users begin with, and the list of every
//! threshold. A file imports others by their own path, not through the `mod.rs` above it.
//!
//! One more room is one more folder with a `mod.rs` like these, one line here and one in the order
//! that `tests/architecture.rs` holds.

pub mod calibration;
pub(crate) mod diameter;
mod edge;
mod edges;
pub(crate) mod flank;
pub mod form;
pub(crate) mod generatrix;
pub(crate) mod instrument;
pub(crate) mod limit;
pub(crate) mod nose;
pub mod ring;
pub(crate) mod sensor;
mod settings;
pub(crate) mod uncertainty;
mod width;

pub use self::{
    calibration::{Calibration, CalibrationError, MasterCertificate, MasterFigure, MasterMeasurement},
    diameter::ColumnDiameter,
    diameter::ColumnDiameters,
    diameter::axis_line::{AxisLine, AxisStation, TurningOffset},
    diameter::field_midline::FieldMidline,
    diameter::plausibility::Jump,
    diameter::reading_scatter::ScatterTest,
    diameter::reading_series::{Averaging, Capability},
    diameter::sections::{PartForm, SectionForm},
    edge::edge_stream::EdgeStream,
    edge::model::edge_table::EdgeTable,
    edge::model::systematic_residual::SystematicResidual,
    edges::{Edge, EdgeState, FrameEdges, FrameFigures, FrameRefused, ShadowsSeen},
    instrument::Gauge,
    settings::{
        Blur, EsfModel, EsfSamples, GaugeSettings, Levels, Noise, PlausibilitySettings, Polarity, Rejection,
        StationSettings, Which,
    },
    uncertainty::budget::{Budget, Contribution, Shape, Share},
    uncertainty::stated,
    width::largest_caliper::LargestCaliper,
};
pub(crate) use diameter::{axis_line, plausibility};
#[cfg(test)]
pub(crate) use form::size;
pub(crate) use sensor::photon_transfer;
pub(crate) use uncertainty::{budget, monte_carlo};

pub(crate) use diameter::StationAverager;
#[cfg(feature = "render")]
pub(crate) use diameter::station_mean::StationColumns;
pub(crate) use edge::estimation::model_bias::ResidualAccumulator;
pub(crate) use edge::estimation::slanted_edge::least_travel_px;
pub(crate) use edge::parallel::Lanes;
#[cfg(feature = "render")]
pub(crate) use edge::room::EdgeRoom;
pub(crate) use edge::settled::SettledStream;
pub(crate) use limit::{Limit, replace as replace_limit};
pub(crate) use width::axis_pose::Pose;
pub(crate) use width::largest_caliper::{largest_caliper, largest_caliper_over};
pub(crate) use width::stretch::crests::crest_pitch_px;
pub(crate) use width::stretch::largest_value::LEAST_STRETCH;
