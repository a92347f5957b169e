//! Repeatability that is to be expected, from contrast, noise and blur alone.
//!
//! A diameter is two edges: σ_D = √2·σ_edge. The mean of n columns has σ_D/√n; over a turn the
//! sensor's temporal noise averages over the angles, the pixels' own pattern does not, since a part
//! that turns stays on the same pixels.

use serde::Serialize;

use super::bound::edge_bound;
use super::error::HeadError;
use super::setup::HeadSetup;

/// Standard deviations of a diameter by noise, µm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Repeatability {
    /// One column, levels and blur given: the bound.
    pub bound_um: f64,
    /// One column, levels and blur found from the frame.
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
        let diameter_um = |px: f64| std::f64::consts::SQRT_2 * px * head.um_per_px();
        let all = edge_bound(&edge, half_px, smear_px, &head.levels).ok_or_else(no_contrast)?;
        let temporal =
            edge_bound(&edge, half_px, smear_px, &head.levels.temporal()).ok_or_else(no_contrast)?;
        let part = &head.job.part;
        let columns = head.job.camera.columns as usize;
        let across = (part.station_mm / head.optics.pixel_mm).floor();
        let station_columns = (across.clamp(1.0, columns as f64)) as usize;
        let angles = head.job.scan.angles.max(1);
        let column_um = diameter_um(all.found_px);
        let over = |count: usize| (count as f64).sqrt().recip();
        let temporal_um = diameter_um(temporal.found_px);
        let pattern = (column_um * column_um - temporal_um * temporal_um).max(0.0);
        let of_turn = (pattern + temporal_um * temporal_um / angles as f64).sqrt();
        Ok(Self {
            bound_um: diameter_um(all.given_px),
            column_um,
            frame_um: column_um * over(columns),
            columns,
            station_um: column_um * over(station_columns),
            station_columns,
            turn_um: of_turn * over(station_columns),
            angles,
        })
    }
}

fn no_contrast() -> HeadError {
    let what = "must exceed light.shadow_counts: a frame without contrast shows no edge";
    crate::setting::SettingError::at("light.bright_counts", what).into()
}
