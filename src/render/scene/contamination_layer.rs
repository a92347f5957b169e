//! Contamination of one frame: films on the shaft's surface, and objects that dim the light.

use rayon::prelude::*;

use super::request::FrameRequest;
use super::true_optics::OpticalSetup;
use crate::render::contamination::{Rise, RisenEdge, TransmissionRequest, mark_rise};
use crate::render::error::RenderError;
use crate::render::kernel::column_edges::ColumnEdges;
use crate::render::kernel::light_map::LightMap;
use crate::render::kernel::params::{Window, Windows};
use crate::shaft::Shaft;

/// Raises the edges by the films on the shaft; the rises, column by column, or none where there are
/// no films.
///
/// `edges` reach `halo` columns beyond the window at either end.
pub(crate) fn raise_edges(
    setup: &OpticalSetup,
    shaft: &Shaft,
    request: &FrameRequest,
    window: Window,
    edges: &mut [ColumnEdges],
) -> Result<Vec<Rise>, RenderError> {
    let Some(contamination) = &setup.contamination else { return Ok(Vec::new()) };
    let halo = (edges.len() - window.columns as usize) as f64 / 2.0;
    let z_mm = |i: f64| setup.column_z_mm(request.z_mm, f64::from(window.column) + i - halo);
    // One radius for the whole shaft, so that every field has the same films.
    let radius_mm = shaft.profile.iter().map(|k| k.radius_mm).fold(0.0, f64::max);
    let films = contamination.films(radius_mm, z_mm(0.0)..z_mm(edges.len() as f64))?;
    if films.is_empty() {
        return Ok(Vec::new());
    }
    let raise = |(i, e): (usize, &mut ColumnEdges)| {
        let radius_mm = 0.5 * (e.bottom_px - e.top_px) * setup.pixel_mm;
        let rise = contamination.rise(&films, radius_mm, z_mm(i as f64), request.angle_deg);
        e.top_px -= rise.top_px;
        e.bottom_px += rise.bottom_px;
        rise
    };
    Ok(edges.par_iter_mut().enumerate().map(raise).collect())
}

/// The window for contamination.
pub(crate) struct WindowView<'a> {
    /// Its edges, raised by `rises`.
    pub edges: &'a [ColumnEdges],
    pub rises: &'a [Rise],
    pub blur_px: f64,
    /// Rows in the shadow over all columns.
    pub dark: std::ops::Range<i32>,
}

/// Transmission of the contamination over the window's pixels, with its mask; `None` where the
/// optical setup is clean.
///
/// The mask is empty unless requested; without it, rows in the shadow are skipped.
pub(crate) fn contamination(
    setup: &OpticalSetup,
    request: &FrameRequest,
    windows: Windows,
    seen: &WindowView<'_>,
    with_mask: bool,
) -> Result<Option<LightMap>, RenderError> {
    let Some(contamination) = &setup.contamination else { return Ok(None) };
    let frame = windows.frame();
    let size = [frame.rows as usize, frame.columns as usize];
    let mut map = LightMap::default();
    // Contamination in front of the shadow matters for the mask alone.
    let unseen = if with_mask || windows.second.is_some() { 0..0 } else { seen.dark.clone() };
    if contamination.dims() {
        for part in windows.parts() {
            let [row, column, rows, columns] =
                [part.row, part.column, part.rows, part.columns].map(|n| n as usize);
            let asked = TransmissionRequest { size: [rows, columns], with_mask, unseen: unseen.clone() };
            let piece = contamination.transmission(request.frame_id, [row, column], &asked)?;
            map = if map.words.is_empty() { piece } else { map.followed_by(&piece) };
        }
    } else if with_mask {
        map.mask = vec![0; size[0] * size[1]];
    }
    if !with_mask {
        return Ok(Some(map));
    }
    let blur_px = seen.blur_px;
    for (column, (e, rise)) in seen.edges.iter().zip(seen.rises).enumerate() {
        let top = RisenEdge { clean: e.top_px + rise.top_px, rise_px: -rise.top_px, blur_px };
        let bottom = RisenEdge { clean: e.bottom_px - rise.bottom_px, rise_px: rise.bottom_px, blur_px };
        for edge in [top, bottom] {
            mark_rise(&mut map.mask, size[1], column, edge);
        }
    }
    Ok(Some(map))
}
