//! The scenes of the golden frames, built into the program, and the difference of two renderings of
//! one: the comparison of the CPU twin with its golden files also compares any graphics adapter
//! with the twin, without further files.

use crate::frame::{PixelFormat, Pixels};
use crate::render::contamination::Contamination;
use crate::render::form::form_shaft;
use crate::render::settings::{Camera, Light, Optics, Sensor, SetupDeviations, SetupSettings};
use crate::render::{FrameRequest, OpticalSetup, RenderError, Renderer, Scene};
use crate::shaft::{ProfileKnot, ShaftForm};
use crate::truth::true_edges;

/// Largest edge-equivalent shift, px: a thousandth of a pixel is the smallest contribution to the
/// gauge's uncertainty.
pub(crate) const SHIFT_LIMIT_PX: f64 = 0.001;

/// Name and `case.toml` of every golden frame.
pub(crate) const CASES: [(&str, &str); 14] = [
    ("bent_turning", include_str!("../../golden/bent_turning/case.toml")),
    ("dirty_window", include_str!("../../golden/dirty_window/case.toml")),
    ("faint_contrast", include_str!("../../golden/faint_contrast/case.toml")),
    ("films_on_shaft", include_str!("../../golden/films_on_shaft/case.toml")),
    ("full_well", include_str!("../../golden/full_well/case.toml")),
    ("laser_shadow", include_str!("../../golden/laser_shadow/case.toml")),
    ("level_cylinder", include_str!("../../golden/level_cylinder/case.toml")),
    ("partially_coherent", include_str!("../../golden/partially_coherent/case.toml")),
    ("rough_surface", include_str!("../../golden/rough_surface/case.toml")),
    ("sharp_taper", include_str!("../../golden/sharp_taper/case.toml")),
    ("soft_thin_wire", include_str!("../../golden/soft_thin_wire/case.toml")),
    ("thick_cylinder", include_str!("../../golden/thick_cylinder/case.toml")),
    ("tilted_lobes", include_str!("../../golden/tilted_lobes/case.toml")),
    ("uneven_light", include_str!("../../golden/uneven_light/case.toml")),
];

/// The keys of a `case.toml`; missing ones have the defaults of a config.
#[derive(Clone, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct GoldenCase {
    pub diameter_mm: f64,
    pub taper_deg: f64,
    pub length_mm: f64,
    pub z_mm: f64,
    pub angle_deg: f64,
    pub seed: u64,
    pub shaft: ShaftForm,
    pub camera: Camera,
    pub optics: Optics,
    pub light: Light,
    pub sensor: Sensor,
    pub contamination: Contamination,
}

impl Default for GoldenCase {
    fn default() -> Self {
        Self {
            diameter_mm: 1.0,
            taper_deg: 0.0,
            length_mm: 20.0,
            z_mm: 10.0,
            angle_deg: 0.0,
            seed: 0,
            shaft: ShaftForm::default(),
            camera: Camera::default(),
            optics: Optics::default(),
            light: Light::default(),
            sensor: Sensor::default(),
            contamination: Contamination::default(),
        }
    }
}

impl GoldenCase {
    /// The scene of the case.
    ///
    /// # Errors
    /// When its optics or its shaft are refused.
    pub(crate) fn scene(&self) -> Result<Scene, RenderError> {
        let settings = SetupSettings {
            camera: self.camera.clone(),
            optics: self.optics.clone(),
            light: self.light.clone(),
            sensor: self.sensor.clone(),
            motion: Default::default(),
            contamination: self.contamination.clone(),
            departures: SetupDeviations::none(),
        };
        let setup = OpticalSetup::resolve(&settings, self.seed)?;
        let shaft = form_shaft(self.profile(), &self.shaft, self.length_mm, self.seed)?;
        Scene::new(&setup, shaft)
    }

    /// The request for its frame: 16 bit.
    pub(crate) fn request(&self) -> FrameRequest {
        FrameRequest {
            z_mm: self.z_mm,
            angle_deg: self.angle_deg,
            format: Some(PixelFormat::Mono16),
            ..Default::default()
        }
    }

    /// A cylinder, or a cone through the radius at `z_mm`, cut off where the radius would vanish.
    fn profile(&self) -> Vec<ProfileKnot> {
        let radius_mm = self.diameter_mm / 2.0;
        let half_mm = 0.1 * self.length_mm;
        if self.taper_deg == 0.0 {
            return vec![ProfileKnot { z_mm: self.z_mm - half_mm, radius_mm }];
        }
        let slope = self.taper_deg.to_radians().tan();
        let reach_mm = 0.95 * radius_mm / slope;
        let knot = |sign: f64| ProfileKnot {
            z_mm: self.z_mm + sign * reach_mm,
            radius_mm: radius_mm - sign * slope * reach_mm,
        };
        vec![knot(-1.0), knot(1.0)]
    }
}

/// Differences between two frames of one scene.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub(crate) struct FrameDifference {
    /// Largest |difference|, 16-bit counts.
    pub worst_counts: f64,
    /// Its limit: the difference that a shift of [`SHIFT_LIMIT_PX`] causes at the steepest edge,
    /// and one count of rounding.
    pub limit_counts: f64,
    /// Largest edge-equivalent shift of an edge in a column, px: sum of the differences over the
    /// edge's half of the column, over the contrast.
    pub worst_shift_px: f64,
    /// Largest mean of the shift of an edge over all columns, px.
    pub mean_shift_px: f64,
}

impl FrameDifference {
    /// Compares two frames of `columns` columns, 16-bit counts, row-major and equally large.
    /// `edges_px` are the true rows (top, bottom) of every column, `contrast` the counts between
    /// shadow and light.
    pub(crate) fn of(
        test: &[u16],
        judge: &[u16],
        columns: usize,
        edges_px: impl Iterator<Item = (f64, f64)>,
        contrast: f64,
    ) -> Self {
        let rows = judge.len() / columns;
        let delta = |r: usize, c: usize| f64::from(test[r * columns + c]) - f64::from(judge[r * columns + c]);
        let (mut worst_counts, mut worst_shift, mut sums) = (0.0_f64, 0.0_f64, [0.0; 2]);
        for (c, (top, bottom)) in edges_px.enumerate() {
            let middle = ((top + bottom) / 2.0).round() as usize;
            for (side, rows) in [0..middle, middle..rows].into_iter().enumerate() {
                let shift = rows.clone().map(|r| delta(r, c)).sum::<f64>() / contrast;
                worst_counts = rows.map(|r| delta(r, c).abs()).fold(worst_counts, f64::max);
                worst_shift = worst_shift.max(shift.abs());
                sums[side] += shift / columns as f64;
            }
        }
        Self {
            worst_counts,
            limit_counts: SHIFT_LIMIT_PX * steepest(judge, columns) + 1.0,
            worst_shift_px: worst_shift,
            mean_shift_px: sums[0].abs().max(sums[1].abs()),
        }
    }

    /// Whether the grey values lie within their limit.
    pub(crate) fn counts_agree(&self) -> bool {
        self.worst_counts <= self.limit_counts
    }

    /// Whether the edges lie within [`SHIFT_LIMIT_PX`].
    pub(crate) fn edges_agree(&self) -> bool {
        self.worst_shift_px <= SHIFT_LIMIT_PX && self.mean_shift_px <= SHIFT_LIMIT_PX
    }
}

/// Largest change from row to row, counts.
fn steepest(pixels: &[u16], columns: usize) -> f64 {
    let pairs = pixels.iter().zip(&pixels[columns..]);
    pairs.map(|(a, b)| (f64::from(*a) - f64::from(*b)).abs()).fold(0.0, f64::max)
}

/// One case drawn by two renderers.
///
/// # Errors
/// When the case is refused or a device fails.
pub(crate) fn compare(
    case: &GoldenCase,
    test: &Renderer,
    judge: &Renderer,
) -> Result<FrameDifference, RenderError> {
    let (scene, request) = (case.scene()?, case.request());
    let frames = [test, judge].map(|renderer| renderer.render(&scene, &request, None));
    let [a, b] = frames;
    let (a, b) = (a?, b?);
    let edges = true_edges(&scene, &request)?;
    let levels = scene.setup().levels(PixelFormat::Mono16);
    match (a.view().pixels(), b.view().pixels()) {
        (Pixels::U16(test), Pixels::U16(judge)) => Ok(FrameDifference::of(
            test,
            judge,
            b.view().columns(),
            edges.iter().map(|e| (e.top_px, e.bottom_px)),
            levels.bright - levels.shadow,
        )),
        _ => Err(RenderError::Device { what: "a frame of 16 bit came back in another format".into() }),
    }
}
