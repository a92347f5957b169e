//! Repeatability that is to be expected, from contrast, noise and blur alone.
//!
//! A diameter is two edges: σ_D = √2·σ_edge. With g the bound of a column where levels and blur are
//! given and f that of columns that find them (`bound`), the mean of m columns of a frame whose n
//! columns find them together has the variance g²/m + (f² − g²)/n. Over a turn the sensor's
//! temporal noise averages over the angles, the pixels' own pattern does not, since a part that
//! turns stays on the same pixels.

use serde::Serialize;

use super::bound::{EdgeBound, edge_bound};
use super::error::HeadError;
use super::setup::HeadSetup;

/// Standard deviations of a diameter by noise, µm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Repeatability {
    /// One column, levels and blur given: the bound.
    pub bound_um: f64,
    /// One column, levels and blur found from the whole frame.
    pub column_um: f64,
    /// The mean of a frame's columns.
    pub frame_um: f64,
    /// Columns of a frame.
    pub columns: usize,
    /// The mean of a station in one frame.
    pub station_um: f64,
    /// Columns of a station.
    pub station_columns: usize,
    /// A station over the angles of a turn.
    pub turn_um: f64,
    /// Angles of a turn.
    pub angles: usize,
}

impl Repeatability {
    /// Of a head whose edges are smeared by `smear_px` during the exposure.
    ///
    /// # Errors
    /// Optics whose table cannot be computed; a frame without contrast.
    pub(super) fn of(head: &HeadSetup, smear_px: f64) -> Result<Self, HeadError> {
        let edge = head.optics.at(0.0)?;
        let half_px = if smear_px > 0.0 { head.most_half_px() } else { head.half_px() };
        let bound = |levels| edge_bound(&edge, half_px, smear_px, &levels).ok_or_else(no_contrast);
        let (all, temporal) = (bound(head.levels)?, bound(head.levels.temporal())?);
        let part = &head.job.part;
        let columns = head.job.camera.columns as usize;
        let across = (part.station_mm / head.optics.pixel_mm).floor();
        let station_columns = (across.clamp(1.0, columns as f64)) as usize;
        let angles = head.job.scan.angles.max(1);
        let to_um = std::f64::consts::SQRT_2 * head.um_per_px();
        let mean_um = |edge: &EdgeBound, count: usize| to_um * mean_px(edge, count, columns);
        let station_um = mean_um(&all, station_columns);
        let temporal_um = mean_um(&temporal, station_columns);
        let pattern = (station_um * station_um - temporal_um * temporal_um).max(0.0);
        Ok(Self {
            bound_um: to_um * all.given_px,
            column_um: mean_um(&all, 1),
            frame_um: mean_um(&all, columns),
            columns,
            station_um,
            station_columns,
            turn_um: (pattern + temporal_um * temporal_um / angles as f64).sqrt(),
            angles,
        })
    }
}

/// Standard uncertainty of the mean edge of `count` columns of a frame of `columns`, px.
fn mean_px(edge: &EdgeBound, count: usize, columns: usize) -> f64 {
    let (given, found) = (edge.given_px.powi(2), edge.found_px.powi(2));
    (given / count as f64 + (found - given) / columns as f64).sqrt()
}

fn no_contrast() -> HeadError {
    let what = "must exceed light.shadow_counts: a frame without contrast shows no edge";
    crate::setting::SettingError::at("light.bright_counts", what).into()
}
