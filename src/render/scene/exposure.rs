//! A frame in time: the edges at the instants of its exposure, raised by films on the shaft.

use rayon::prelude::*;

use super::contamination_layer::{self, WindowView};
use super::request::FrameRequest;
use super::rolling_shutter::{LineTimes, Moving};
use super::scene::Scene;
use crate::frame::PixelFormat;
use crate::render::contamination::Rise;
use crate::render::error::RenderError;
use crate::render::kernel::column_edges::{Bands, ColumnEdges};
use crate::render::kernel::params::{Window, Windows};
use crate::render::motion::Pose;
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
    /// How far these edges stand outside those of `turned`, at the times of their own rows; empty
    /// for a global shutter.
    pub rolled: Vec<Rise>,
}

impl Instant<'_> {
    /// What the edges stand outside those of `turned` by at a fractional place among the columns,
    /// linear between two: films and motions are wide compared with a pixel.
    pub(crate) fn rise_at(&self, place: f64) -> Rise {
        let (film, rolled) = (between(&self.rises, place), between(&self.rolled, place));
        Rise { top_px: film.top_px + rolled.top_px, bottom_px: film.bottom_px + rolled.bottom_px }
    }
}

fn between(rises: &[Rise], place: f64) -> Rise {
    let Some(last) = rises.len().checked_sub(1) else { return Rise::default() };
    let place = place.clamp(0.0, last as f64);
    let (a, b) = (rises[place as usize], rises[(place as usize + 1).min(last)]);
    let between = |a: f64, b: f64| a + place.fract() * (b - a);
    Rise { top_px: between(a.top_px, b.top_px), bottom_px: between(a.bottom_px, b.bottom_px) }
}

/// What a request reads of the sensor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RequestedFrame {
    pub windows: Windows,
    /// From the upper window's first row to the lower one's last.
    pub window: Window,
    pub format: PixelFormat,
    /// Windows as the sensor reads them, from which the times of rows count.
    pub read: Windows,
    /// Columns computed beyond the frame's own at either side.
    pub halo: usize,
}

/// Where the edges of a frame stand while it is exposed, with the halo, in rows of its window.
pub(crate) struct ExposedEdges<'a> {
    pub instants: Vec<Instant<'a>>,
    /// Mean over the instants.
    pub mean: Vec<ColumnEdges>,
    /// The mean with the lower edges in the rows that a second window has in the frame.
    pub stacked: Vec<ColumnEdges>,
}

impl RequestedFrame {
    /// The windows and the format of a request; `read` is the request of the frame that it is
    /// drawn for.
    pub(crate) fn of(
        scene: &Scene,
        request: &FrameRequest,
        read: &FrameRequest,
    ) -> Result<Self, RenderError> {
        let (windows, read) = (scene.setup.windows(request)?, scene.setup.windows(read)?);
        let (format, halo) = (scene.setup.format(request), scene.blur.reach());
        Ok(Self { windows, window: windows.span(), format, read, halo })
    }
}

impl ExposedEdges<'_> {
    /// The frame's own columns as contamination meets them.
    pub(crate) fn view(&self, frame: &RequestedFrame, blur_px: f64, bands: &Bands) -> WindowView<'_> {
        let rises = self.instants.last().map_or(&[][..], |i| &i.rises);
        let (edges, rises) = (within_halo(&self.stacked, frame.halo), within_halo(rises, frame.halo));
        WindowView { edges, rises, blur_px, dark: bands.dark.clone() }
    }
}

/// Exact edges of the silhouette at every column, in rows of the requested frame: the mean over the
/// exposure where they move, distorted by the lens.
///
/// # Errors
/// Refuses a window outside the sensor and a shaft that leaves the field.
pub(crate) fn geometric_edges(
    scene: &Scene,
    request: &FrameRequest,
) -> Result<Vec<ColumnEdges>, RenderError> {
    let windows = scene.setup.windows(request)?;
    let seen = Seen { window: windows.span(), halo: 0, times: LineTimes::of(&scene.setup, windows) };
    let mut edges = mean(&instants(scene, request, &seen)?);
    stack(&mut edges, windows)?;
    Ok(edges)
}

/// The edges of a frame over its exposure, raised by the films that adhere to the part.
pub(crate) fn expose<'a>(
    scene: &'a Scene,
    request: &FrameRequest,
    frame: &RequestedFrame,
) -> Result<ExposedEdges<'a>, RenderError> {
    let times = LineTimes::of(&scene.setup, frame.read);
    let seen = Seen { window: frame.window, halo: frame.halo, times };
    let mut instants = instants(scene, request, &seen)?;
    if !scene.wiped {
        let (setup, shaft) = (&scene.setup, scene.outline.shaft());
        for Instant { edges, rises, .. } in &mut instants {
            *rises = contamination_layer::raise_edges(setup, shaft, request, frame.window, edges)?;
        }
    }
    let mean = mean(&instants);
    let mut stacked = mean.clone();
    stack(&mut stacked, frame.windows)?;
    Ok(ExposedEdges { instants, mean, stacked })
}

/// What of the edges is computed.
struct Seen {
    /// The frame's columns, and the row that edges count from.
    window: Window,
    /// Columns beyond them at either side.
    halo: usize,
    /// When rows are exposed; none for a global shutter.
    times: Option<LineTimes>,
}

/// The instants of a request's exposure; a single one where nothing moves.
fn instants<'a>(
    scene: &'a Scene,
    request: &FrameRequest,
    seen: &Seen,
) -> Result<Vec<Instant<'a>>, RenderError> {
    let nominal = &scene.setup.nominal;
    let poses = nominal.motion.instants(nominal.camera.exposure_us, scene.outline.undulations());
    let mut instants: Vec<Instant<'a>> = Vec::with_capacity(poses.len());
    let mut before: Option<Placed> = None;
    for pose in poses {
        let turned = placed(scene, request, &pose);
        let field_z_mm = request.z_mm + pose.z_mm;
        let base = edges_at(scene, request, &pose, seen, before.as_ref());
        let rolled = seen.times.map_or_else(Vec::new, |times| rolled(scene, request, &base, (seen, times)));
        let mut edges = base.edges.clone();
        for (e, rise) in edges.iter_mut().zip(&rolled) {
            e.top_px -= rise.top_px;
            e.bottom_px += rise.bottom_px;
        }
        check_field(scene, &edges[seen.halo..edges.len() - seen.halo], seen.window)?;
        before = Some(base);
        instants.push(Instant { weight: pose.weight, turned, field_z_mm, edges, rises: Vec::new(), rolled });
    }
    Ok(instants)
}

/// Edges of the shaft at one pose.
struct Placed {
    pose: Pose,
    edges: Vec<ColumnEdges>,
}

/// The shaft at a pose.
fn placed<'a>(scene: &'a Scene, request: &FrameRequest, pose: &Pose) -> Turned<'a> {
    scene.turned(request, request.angle_deg + pose.angle_deg).shifted(pose.lift_mm, 0.0)
}

/// The edges at a pose; those of another one moved where only its height differs.
fn edges_at(
    scene: &Scene,
    request: &FrameRequest,
    pose: &Pose,
    seen: &Seen,
    before: Option<&Placed>,
) -> Placed {
    let shifted_rows = scene.setup.nominal.optics.distortion.is_none() && scene.is_straight();
    let same = |b: &&Placed| shifted_rows && (b.pose.angle_deg, b.pose.z_mm) == (pose.angle_deg, pose.z_mm);
    let edges = match before.filter(same) {
        Some(before) => {
            let pixel_mm = scene.setup.pixel_mm;
            let down = before.pose.lift_mm / pixel_mm - pose.lift_mm / pixel_mm;
            let move_down =
                |e: &ColumnEdges| ColumnEdges { top_px: e.top_px + down, bottom_px: e.bottom_px + down };
            before.edges.iter().map(move_down).collect()
        }
        None => {
            let turned = placed(scene, request, pose);
            edges_over(scene, &turned, request.z_mm + pose.z_mm, seen.window, seen.halo)
        }
    };
    Placed { pose: *pose, edges }
}

/// How far the edges stand outside those of a pose at the times of their own rows.
fn rolled(
    scene: &Scene,
    request: &FrameRequest,
    base: &Placed,
    (seen, times): (&Seen, LineTimes),
) -> Vec<Rise> {
    let (motion, exposure_us) = (&scene.setup.nominal.motion, scene.setup.nominal.camera.exposure_us);
    let quickest = motion.quickest_rad_per_us(exposure_us, scene.outline.undulations());
    if quickest == 0.0 && motion.carriage_mm_s == 0.0 {
        return Vec::new();
    }
    let later = |us: f64| {
        edges_at(scene, request, &motion.later(&base.pose, exposure_us, us), seen, Some(base)).edges
    };
    let row0 = f64::from(seen.window.row);
    Moving { times, row0, first: &base.edges, later, quickest }.displacements()
}

/// Mean edges over the instants.
fn mean(instants: &[Instant<'_>]) -> Vec<ColumnEdges> {
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
    let last = scene.setup.rows() as f64 - 1.0;
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

/// The elements of the frame's own columns, without the `halo` on either side.
fn within_halo<T>(all: &[T], halo: usize) -> &[T] {
    let first = halo.min(all.len());
    &all[first..all.len().saturating_sub(halo).max(first)]
}

/// Moves the lower edges into the rows that a second window has in the frame.
fn stack(edges: &mut [ColumnEdges], windows: Windows) -> Result<(), RenderError> {
    if windows.second.is_none() {
        return Ok(());
    }
    let (split, rows) = (f64::from(windows.first.rows), f64::from(windows.frame().rows));
    for e in &mut *edges {
        e.bottom_px -= f64::from(windows.skip());
    }
    let apart =
        |e: &ColumnEdges| e.top_px >= 0.0 && e.top_px < split && e.bottom_px >= split && e.bottom_px < rows;
    if edges.iter().all(apart) {
        return Ok(());
    }
    let right = "each window must hold one edge of the shaft in every column: move it, or give it more rows";
    Err(RenderError::setting("second_roi", &format!("{windows:?}"), right))
}
