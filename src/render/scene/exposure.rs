//! A frame in time: the edges at the instants of its exposure.

use rayon::prelude::*;

use super::request::FrameRequest;
use super::scene::Scene;
use crate::render::contamination::Rise;
use crate::render::error::RenderError;
use crate::render::kernel::column_edges::ColumnEdges;
use crate::render::kernel::params::Window;
use crate::render::silhouette::Turned;

/// Columns of a task; the result does not depend on the number of threads.
const BLOCK: usize = 256;

/// One instant of an exposure.
#[derive(Clone, Debug)]
pub(crate) struct Instant<'a> {
    /// Share of the light.
    pub weight: f64,
    /// The shaft at that instant.
    pub turned: Turned<'a>,
    /// Machine z of the central column, mm.
    pub field_z_mm: f64,
    /// Edges of every column of the window and its halo, in rows of the window.
    pub edges: Vec<ColumnEdges>,
    /// Rises of these edges by films; empty where there are none.
    pub rises: Vec<Rise>,
}

impl Instant<'_> {
    /// The rise at a fractional place among the columns, linear between two, because films are wide
    /// compared with a pixel.
    pub(crate) fn rise_at(&self, place: f64) -> Rise {
        let Some(last) = self.rises.len().checked_sub(1) else { return Rise::default() };
        let place = place.clamp(0.0, last as f64);
        let (a, b) = (self.rises[place as usize], self.rises[(place as usize + 1).min(last)]);
        let between = |a: f64, b: f64| a + place.fract() * (b - a);
        Rise { top_px: between(a.top_px, b.top_px), bottom_px: between(a.bottom_px, b.bottom_px) }
    }
}

/// The instants of a request's exposure; a single one where nothing moves.
pub(crate) fn instants<'a>(
    scene: &'a Scene,
    request: &FrameRequest,
    window: Window,
    halo: usize,
) -> Result<Vec<Instant<'a>>, RenderError> {
    let nominal = &scene.setup().nominal;
    let shifted_rows = nominal.optics.distortion.is_none() && scene.is_straight();
    let poses = nominal.motion.instants(nominal.camera.exposure_us, scene.outline().undulations());
    let mut instants: Vec<Instant<'a>> = Vec::with_capacity(poses.len());
    let mut before: Option<(f64, f64, f64)> = None;
    for pose in poses {
        let (angle, z) = (request.angle_deg + pose.angle_deg, request.z_mm + pose.z_mm);
        let lift_px = pose.lift_mm / scene.setup().pixel_mm;
        let turned = scene.turned(request, angle).shifted(pose.lift_mm, 0.0);
        let same = before.filter(|b| shifted_rows && (b.0, b.1) == (angle, z)).map(|b| b.2);
        let edges = match (same, instants.last()) {
            (Some(lift), Some(last)) => {
                let down = lift - lift_px;
                let move_down =
                    |e: &ColumnEdges| ColumnEdges { top_px: e.top_px + down, bottom_px: e.bottom_px + down };
                last.edges.iter().map(move_down).collect()
            }
            _ => edges_over(scene, &turned, z, window, halo),
        };
        check_field(scene, &edges[halo..edges.len() - halo], window)?;
        before = Some((angle, z, lift_px));
        instants.push(Instant { weight: pose.weight, turned, field_z_mm: z, edges, rises: Vec::new() });
    }
    Ok(instants)
}

/// Mean edges over the instants.
pub(crate) fn mean(instants: &[Instant<'_>]) -> Vec<ColumnEdges> {
    if let [only] = instants {
        return only.edges.clone();
    }
    (0..instants[0].edges.len())
        .map(|i| {
            instants.iter().fold(ColumnEdges { top_px: 0.0, bottom_px: 0.0 }, |sum, at| ColumnEdges {
                top_px: sum.top_px + at.weight * at.edges[i].top_px,
                bottom_px: sum.bottom_px + at.weight * at.edges[i].bottom_px,
            })
        })
        .collect()
}

fn edges_over(
    scene: &Scene,
    turned: &Turned<'_>,
    field_z_mm: f64,
    window: Window,
    halo: usize,
) -> Vec<ColumnEdges> {
    let count = window.columns as usize + 2 * halo;
    let mut edges = vec![ColumnEdges { top_px: 0.0, bottom_px: 0.0 }; count];
    edges.par_chunks_mut(BLOCK).enumerate().for_each(|(block, chunk)| {
        for (i, e) in chunk.iter_mut().enumerate() {
            let column = f64::from(window.column) + (block * BLOCK + i) as f64 - halo as f64;
            let at = scene.edges_at(turned, field_z_mm, column);
            let row0 = f64::from(window.row);
            *e = ColumnEdges { top_px: at.top_px - row0, bottom_px: at.bottom_px - row0 };
        }
    });
    edges
}

fn check_field(scene: &Scene, edges: &[ColumnEdges], window: Window) -> Result<(), RenderError> {
    let row0 = f64::from(window.row);
    let last = scene.setup().rows() as f64 - 1.0;
    let outside = edges.iter().position(|e| !(e.top_px + row0 >= 0.0 && e.bottom_px + row0 <= last));
    let Some(column) = outside else { return Ok(()) };
    let e = edges[column];
    Err(RenderError::Field {
        what: format!(
            "at column {} the shaft's edges stand at rows {:.1} and {:.1}, outside the field's 0 to {last}: move or straighten the shaft, or lower optics.magnification",
            column + window.column as usize,
            e.top_px + row0,
            e.bottom_px + row0
        ),
    })
}
