//! Millimetres: diameters of columns, stations along z, sections over a revolution, the axis,
//! series of readings.
//!
//! In: [`FrameEdges`](crate::gauge::FrameEdges) and a [`Calibration`](crate::gauge::Calibration).
//! Out: [`ColumnDiameters`] of a frame; from the frames of a scan a
//! [`DiameterProfile`](crate::profile::DiameterProfile) (`stations`), form and size (`sections`),
//! the axis (`axis_line`); from successive readings their mean and scatter (`reading_series`,
//! `reading_scatter`). `turning_depth` takes off what a part that turns off its axis changes before
//! a lens that is not quite telecentric. All lengths are in mm, u apart by random and common.
//!
//! One more quantity of a scan is one more averager: `add` a frame's `ColumnDiameters`, `finish` to
//! a result with reasons for its gaps.

pub(crate) mod axis_line;
pub(crate) mod bursts;
pub(crate) mod column_diameters;
pub(crate) mod field_midline;
pub(crate) mod plausibility;
pub(crate) mod reading_scatter;
pub(crate) mod reading_series;
pub(crate) mod running_series;
pub(crate) mod sections;
pub(crate) mod station_mean;
mod station_row;
pub(crate) mod stations;
pub(crate) mod turn_scatter;
pub(crate) mod turning_depth;

pub use column_diameters::{ColumnDiameter, ColumnDiameters};
pub(crate) use stations::StationAverager;
