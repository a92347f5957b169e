//! Pixels of a front-lit flank.

use glam::DVec2;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_pcg::Pcg64;
use rayon::prelude::*;

use super::settings::FlankScene;
use super::surface::Surface;
use super::wear::land_um;
use crate::frame::{Buffer, Frame, FrameMeta, PixelFormat};
use crate::numerics::gaussian::blurred;
use crate::render::error::RenderError;

/// Samples a pixel along each side: the finest structure, facets of 5 µm, is two pixels.
const SAMPLES: usize = 2;
/// Distance of two values of the truth along the edge, µm.
const TRUTH_UM: f64 = 4.0;
/// Length at which the camber is stated, µm.
const CAMBER_AT_UM: f64 = 2000.0;

/// What is true of a flank.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub(crate) struct FlankTruth {
    /// Width of the land every `step_um` along the edge, from the corner, µm; inside the image.
    pub widths_um: Vec<f64>,
    /// Distance of two widths, µm.
    pub step_um: f64,
    /// Their mean over the worn length, µm.
    pub vb_um: f64,
    /// The largest of them, µm.
    pub vb_max_um: f64,
    /// Worn length, µm.
    pub worn_length_um: f64,
}

/// A frame (8 bit grey), the mask of its land (255 land) and the truth. The same scene and seed
/// give the same bytes at any number of threads.
///
/// # Errors
/// A setting out of range.
pub(crate) fn render_flank(
    scene: &FlankScene,
    seed: u64,
) -> Result<(Frame, Vec<u8>, FlankTruth), RenderError> {
    scene.check()?;
    let (rows, columns) = (scene.rows as usize, scene.columns as usize);
    let pose = Pose::of(scene);
    let surface = Surface { scene, seed, end_slope: pose.end_slope };
    let mut light = vec![0.0_f32; rows * columns];
    light.par_chunks_mut(columns).enumerate().for_each(|(row, line)| {
        for (column, out) in line.iter_mut().enumerate() {
            *out = pixel(&surface, &pose, row, column);
        }
    });
    let light = blurred(&light, (rows, columns), (scene.blur_px, scene.blur_px));
    let mut pixels = vec![0_u8; rows * columns];
    pixels.par_chunks_mut(columns).enumerate().for_each(|(row, line)| {
        let mut random = Pcg64::seed_from_u64(seed.wrapping_mul(0x9e37_79b9).wrapping_add(row as u64));
        for (value, light) in line.iter_mut().zip(&light[row * columns..]) {
            let noise: f64 = random.sample(StandardNormal);
            *value = (255.0 * f64::from(*light) + scene.noise_counts * noise).clamp(0.0, 255.0).round() as u8;
        }
    });
    let mask = (0..rows * columns).map(|k| {
        let (s, v) = pose.on_flank(DVec2::new((k % columns) as f64, (k / columns) as f64));
        if v >= 0.0 && v < land_um(&scene.wear, s, seed) && s >= pose.end(v) { 255 } else { 0 }
    });
    let mask = mask.collect();
    let frame = Frame::new(Buffer::U8(pixels), PixelFormat::Mono8, rows, columns, FrameMeta::default());
    let frame = frame.map_err(|e| RenderError::Field { what: e.to_string() })?;
    Ok((frame, mask, truth(scene, &pose, seed)))
}

/// What is true of a scene with a seed, without rendering it.
pub(crate) fn flank_truth(scene: &FlankScene, seed: u64) -> FlankTruth {
    truth(scene, &Pose::of(scene), seed)
}

/// Depth of a place (column, row) below the new edge, µm.
pub(crate) fn below_edge_um(scene: &FlankScene, place: DVec2) -> f64 {
    Pose::of(scene).on_flank(place).1
}

fn pixel(surface: &Surface<'_>, pose: &Pose, row: usize, column: usize) -> f32 {
    let node = |k: usize| (k as f64 + 0.5) / SAMPLES as f64 - 0.5;
    let mut sum = 0.0;
    for k in 0..SAMPLES * SAMPLES {
        let p = DVec2::new(column as f64 + node(k % SAMPLES), row as f64 + node(k / SAMPLES));
        let (s, v) = pose.on_flank(p);
        sum += surface.light(s, v);
    }
    (sum / (SAMPLES * SAMPLES) as f64) as f32
}

/// Where the edge lies; places are (column, row), px.
struct Pose {
    corner: DVec2,
    along: DVec2,
    normal: DVec2,
    um_per_px: f64,
    camber_um: f64,
    end_slope: f64,
}

impl Pose {
    fn of(scene: &FlankScene) -> Self {
        let a = scene.edge.direction_deg.to_radians();
        let along = DVec2::new(a.cos(), -a.sin());
        // rows count down: what lies to the left of the direction as seen
        let normal = DVec2::new(along.y, -along.x);
        Self {
            corner: DVec2::from_array(scene.edge.corner_px),
            along,
            normal,
            um_per_px: scene.um_per_px,
            camber_um: scene.edge.camber_um,
            end_slope: scene.edge.end_deg.to_radians().tan(),
        }
    }

    /// Distance along the edge from the corner and below the new edge, µm.
    fn on_flank(&self, p: DVec2) -> (f64, f64) {
        let arm = (p - self.corner) * self.um_per_px;
        let s = arm.dot(self.along);
        let t = s / CAMBER_AT_UM;
        (s, arm.dot(self.normal) + 4.0 * self.camber_um * t * (1.0 - t))
    }

    /// Where the flank begins at a depth, µm along the edge.
    fn end(&self, v: f64) -> f64 {
        -v * self.end_slope
    }
}

fn truth(scene: &FlankScene, pose: &Pose, seed: u64) -> FlankTruth {
    let (columns, rows) = (f64::from(scene.columns) - 1.0, f64::from(scene.rows) - 1.0);
    let inside = |s: f64| {
        let p = pose.corner + pose.along * (s / scene.um_per_px);
        p.x >= 0.0 && p.y >= 0.0 && p.x <= columns && p.y <= rows
    };
    let steps = (scene.wear.length_um / TRUTH_UM) as usize;
    let places = (0..=steps).map(|k| k as f64 * TRUTH_UM).filter(|s| inside(*s));
    let widths_um: Vec<f64> = places.map(|s| land_um(&scene.wear, s, seed)).collect();
    let worn: Vec<f64> = widths_um.iter().copied().filter(|w| *w > 0.0).collect();
    FlankTruth {
        vb_um: worn.iter().sum::<f64>() / worn.len().max(1) as f64,
        vb_max_um: worn.iter().copied().fold(0.0, f64::max),
        worn_length_um: worn.len() as f64 * TRUTH_UM,
        widths_um,
        step_um: TRUTH_UM,
    }
}
