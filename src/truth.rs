//! The truth: exact edges and diameters of a scene, from the rendered geometry alone, without any
//! measurement.

use rayon::prelude::*;

use crate::render::silhouette::Outline;
use crate::render::{FrameRequest, RenderError, Scene, geometric_edges};
use crate::shaft::Shaft;

/// Viewing directions over half a turn (the caliper diameter repeats after it).
const DIRECTIONS: usize = 180;

/// Distance of the slices a station's mean is taken over, mm.
const SLICE_MM: f64 = 0.1;

/// Both true edges of a column, in pixels of the frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueEdges {
    /// Row of the upper edge.
    pub top_px: f64,
    /// Row of the lower edge.
    pub bottom_px: f64,
}

/// True edges of every column of the requested frame, in rows of that frame (a window's rows start
/// at its own 0).
///
/// # Errors
/// As the renderer's: a window outside the sensor, a shaft outside the field.
pub fn true_edges(scene: &Scene, request: &FrameRequest) -> Result<Vec<TrueEdges>, RenderError> {
    Ok(geometric_edges(scene, request)?
        .into_iter()
        .map(|e| TrueEdges { top_px: e.top_px, bottom_px: e.bottom_px })
        .collect())
}

/// Mean caliper diameter of a shaft between `z0_mm` and `z1_mm`, over z and densely over the angle,
/// mm.
///
/// # Errors
/// Refuses a shaft that cannot be drawn.
pub(crate) fn station_diameter_mm(shaft: &Shaft, z0_mm: f64, z1_mm: f64) -> Result<f64, RenderError> {
    Ok(station_diameters_mm(shaft, &[(z0_mm, z1_mm)])?[0])
}

/// [`station_diameter_mm`] of many stations at once: the directions are prepared once.
///
/// # Errors
/// Refuses a shaft that cannot be drawn.
pub(crate) fn station_diameters_mm(
    shaft: &Shaft,
    stations_mm: &[(f64, f64)],
) -> Result<Vec<f64>, RenderError> {
    let outline = Outline::new(shaft.clone())?;
    let turned: Vec<_> =
        (0..DIRECTIONS).map(|i| outline.turned(180.0 * i as f64 / DIRECTIONS as f64)).collect();
    let mean = |&(z0, z1): &(f64, f64)| {
        let slices = ((z1 - z0).abs() / SLICE_MM).ceil().max(1.0) as usize;
        let sum: f64 = (0..slices)
            .map(|i| z0 + (z1 - z0) * (i as f64 + 0.5) / slices as f64)
            .map(|z| turned.iter().map(|t| t.caliper_mm(z)).sum::<f64>())
            .sum();
        sum / (slices * DIRECTIONS) as f64
    };
    Ok(stations_mm.par_iter().map(mean).collect())
}
