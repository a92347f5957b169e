//! Draws the contamination of a field of view and multiplies its shades onto the pixels.

use std::f64::consts::{PI, TAU};

use rand_distr::{Distribution, Poisson, StandardNormal, Uniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use super::map::TransmissionMap;
use super::mask;
use super::settings::{Contamination, SizeDistribution};
use super::shading::{CLOUD_REACH, Layers, Shade};
use super::shapes::{clear_radius_of_ball, clear_radius_of_cap};
use crate::render::error::RenderError;

/// Streams of the generator: for the window, and for the air.
const WINDOW_STREAM: u64 = 0x0077_696e_646f_7700;
const AIR_STREAM: u64 = 0x0061_6972_0000_0000;

/// Most objects of one kind.
const MOST: f64 = 1e5;

/// Geometry of a field of view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FieldGeometry {
    /// Rows of the full sensor.
    pub rows: usize,
    /// Columns of the full sensor.
    pub columns: usize,
    /// Size of a pixel on the object, µm.
    pub pixel_um: f64,
    /// Effective numerical aperture, the smaller one of lens and light, which determines the blur
    /// out of focus.
    pub effective_na: f64,
    /// Standard deviation of the blur in focus, µm on the object.
    pub sigma_um: f64,
}

impl FieldGeometry {
    /// Radius of the disc of confusion at `distance_mm` from the plane of focus, in pixels; the
    /// blur in focus is approximated by a disc of the same variance (radius 2σ), the pixel's area
    /// by one of radius 1/√3.
    fn blur_px(&self, distance_mm: f64) -> f64 {
        let defocus = distance_mm * 1e3 * self.effective_na / self.pixel_um;
        (defocus.powi(2) + (2.0 * self.sigma_um / self.pixel_um).powi(2) + 1.0 / 3.0).sqrt()
    }

    fn px(&self, um: f64) -> f64 {
        um / self.pixel_um
    }
}

/// The contamination of a field of view: the window's once, the air's for every frame.
#[derive(Clone, Debug)]
pub(crate) struct ContaminationField {
    settings: Contamination,
    geometry: FieldGeometry,
    seed: u64,
    window: Vec<(u8, Shade)>,
}

/// Poisson number with mean `mean`.
pub(super) fn poisson(key: &'static str, mean: f64, random: &mut Pcg64) -> Result<usize, RenderError> {
    if mean == 0.0 {
        return Ok(0);
    }
    if mean.is_nan() || mean > MOST {
        let right = format!("draws {mean:.0} of them; lower it until there are fewer than {MOST:.0}");
        return Err(RenderError::setting(key, &format!("{mean:.0} in the field"), right));
    }
    let draw = Poisson::new(mean).map_err(|e| RenderError::setting(key, &mean, e.to_string()))?;
    Ok(draw.sample(random) as usize)
}

/// A size in µm, cut at the largest.
pub(super) fn draw_size(sizes: &SizeDistribution, random: &mut Pcg64) -> f64 {
    let normal: f64 = StandardNormal.sample(random);
    (sizes.median_um * (sizes.geometric_sd.ln() * normal).exp()).min(sizes.largest_um)
}

/// Uniform draws over the field and around it.
struct Draw<'a> {
    geometry: &'a FieldGeometry,
    random: Pcg64,
    unit: Uniform<f64>,
}

impl Draw<'_> {
    fn unit(&mut self) -> f64 {
        self.unit.sample(&mut self.random)
    }

    /// Number of objects over the field, widened by `margin_px` on every side.
    fn count(&mut self, key: &'static str, per_cm2: f64, margin_px: f64) -> Result<usize, RenderError> {
        let side = |pixels: usize| (pixels as f64 + 2.0 * margin_px) * self.geometry.pixel_um * 1e-4;
        let mean = per_cm2 * side(self.geometry.rows) * side(self.geometry.columns);
        poisson(key, mean, &mut self.random)
    }

    /// A place (row, column) in the widened field.
    fn place(&mut self, margin_px: f64) -> [f64; 2] {
        let (rows, columns) = (self.geometry.rows as f64, self.geometry.columns as f64);
        let mut along = |pixels: f64| -margin_px + (pixels + 2.0 * margin_px) * self.unit() - 0.5;
        [along(rows), along(columns)]
    }
}

impl ContaminationField {
    /// Draws the contamination of the window.
    ///
    /// # Errors
    /// Refuses settings outside their ranges and more than a hundred thousand objects of a kind,
    /// naming the key.
    pub(crate) fn new(
        settings: &Contamination,
        geometry: FieldGeometry,
        seed: u64,
    ) -> Result<Self, RenderError> {
        settings.check()?;
        let mut field = Self { settings: settings.clone(), geometry, seed, window: Vec::new() };
        field.window = field.draw_window()?;
        Ok(field)
    }

    fn draw_with(&self, seed: u64) -> Result<Draw<'_>, RenderError> {
        let unit = Uniform::new(0.0, 1.0)
            .map_err(|e| RenderError::setting("contamination", "a uniform draw", e.to_string()))?;
        Ok(Draw { geometry: &self.geometry, random: Pcg64::seed_from_u64(seed), unit })
    }

    fn draw_window(&self) -> Result<Vec<(u8, Shade)>, RenderError> {
        let (s, g) = (&self.settings, &self.geometry);
        let blur = g.blur_px(s.window_distance_mm);
        let angle = s.acceptance_half_angle_deg.to_radians();
        let mut draw = self.draw_with(self.seed ^ WINDOW_STREAM)?;
        let mut shades = Vec::new();
        let drops = &s.window_droplets;
        let margin = g.px(drops.radius_um.largest_um) + blur;
        for _ in 0..draw.count("contamination.window_droplets.per_cm2", drops.per_cm2, margin)? {
            let radius = g.px(draw_size(&drops.radius_um, &mut draw.random));
            let contact = drops.contact_angle_deg.to_radians();
            let clear = clear_radius_of_cap(radius, contact, drops.refractive_index, angle);
            let at = draw.place(margin);
            shades.push((mask::WINDOW_DROPLET, Shade::Disc { at, radius, clear, opacity: 1.0, blur }));
        }
        let margin = g.px(s.dirt.radius_um.largest_um) + blur;
        for _ in 0..draw.count("contamination.dirt.per_cm2", s.dirt.per_cm2, margin)? {
            let radius = g.px(draw_size(&s.dirt.radius_um, &mut draw.random));
            let at = draw.place(margin);
            let opacity = s.dirt.opacity;
            shades.push((mask::DIRT, Shade::Disc { at, radius, clear: 0.0, opacity, blur }));
        }
        let half = 0.5 * g.px(s.scratches.length_mm * 1e3);
        for _ in 0..draw.count("contamination.scratches.per_cm2", s.scratches.per_cm2, half + blur)? {
            let width = g.px(draw_size(&s.scratches.width_um, &mut draw.random));
            let (at, angle) = (draw.place(half + blur), PI * draw.unit());
            let along = [half * angle.sin(), half * angle.cos()];
            let (from, to) = ([at[0] - along[0], at[1] - along[1]], [at[0] + along[0], at[1] + along[1]]);
            let opacity = s.scratches.opacity;
            shades.push((mask::SCRATCH, Shade::Line { from, to, width, opacity, blur }));
        }
        Ok(shades)
    }

    /// The objects in the air during frame `frame_id`.
    ///
    /// # Errors
    /// Refuses more than a hundred thousand objects of a kind.
    pub(super) fn air(&self, frame_id: u64) -> Result<Vec<(u8, Shade)>, RenderError> {
        let (s, g) = (&self.settings, &self.geometry);
        let angle = s.acceptance_half_angle_deg.to_radians();
        // Keys of frames differ by multiples of an odd constant (2⁶⁴ over the golden ratio), so
        // that no two are equal.
        let key = frame_id.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mut draw = self.draw_with(self.seed ^ AIR_STREAM ^ key)?;
        let mut shades = Vec::new();
        let margin = CLOUD_REACH * g.px(s.mist.size_um.largest_um);
        for _ in 0..draw.count("contamination.mist.clouds_per_cm2", s.mist.clouds_per_cm2, margin)? {
            let sigma = g.px(draw_size(&s.mist.size_um, &mut draw.random));
            let at = draw.place(margin);
            shades.push((mask::MIST, Shade::Cloud { at, depth: s.mist.optical_depth, sigma }));
        }
        let deepest = g.blur_px(0.5 * s.beam_depth_mm);
        let drops = &s.air_droplets;
        let margin = g.px(drops.radius_um.largest_um) + deepest;
        for _ in 0..draw.count("contamination.air_droplets.per_cm2", drops.per_cm2, margin)? {
            let radius = g.px(draw_size(&drops.radius_um, &mut draw.random));
            let at = draw.place(margin);
            let blur = g.blur_px(s.beam_depth_mm * (draw.unit() - 0.5));
            let clear = clear_radius_of_ball(radius, drops.refractive_index, angle);
            shades.push((mask::AIR_DROPLET, Shade::Disc { at, radius, clear, opacity: 1.0, blur }));
        }
        let margin = g.px(s.chips.half_length_um.largest_um) + deepest;
        for _ in 0..draw.count("contamination.chips.per_cm2", s.chips.per_cm2, margin)? {
            let half = g.px(draw_size(&s.chips.half_length_um, &mut draw.random));
            let at = draw.place(margin);
            let blur = g.blur_px(s.beam_depth_mm * (draw.unit() - 0.5));
            let corners = self.chip(at, half, &mut draw);
            shades.push((mask::CHIP, Shade::Polygon { corners, blur }));
        }
        Ok(shades)
    }

    /// Corners on an ellipse, each moved towards its middle by up to 40 %.
    fn chip(&self, at: [f64; 2], half: f64, draw: &mut Draw<'_>) -> Vec<[f64; 2]> {
        let count = self.settings.chips.corners;
        let (sin, cos) = (TAU * draw.unit()).sin_cos();
        (0..count)
            .map(|i| {
                let angle = TAU * (f64::from(i) + 0.8 * (draw.unit() - 0.5)) / f64::from(count);
                let radius = half * (1.0 - 0.4 * draw.unit());
                let (u, v) = (radius * angle.cos(), radius * self.settings.chips.aspect * angle.sin());
                [at[0] + u * sin + v * cos, at[1] + u * cos - v * sin]
            })
            .collect()
    }

    /// The window's shades over a map whose first pixel is (`row0`, `column0`): constant over a
    /// stream.
    pub(super) fn window_layers(&self, row0: usize, column0: usize) -> Layers<'_> {
        Layers::new(&self.window, 1.0, [row0, column0])
    }

    /// Haze and objects in the air over a map whose first pixel is (`row0`, `column0`).
    pub(super) fn air_layers<'a>(&self, air: &'a [(u8, Shade)], row0: usize, column0: usize) -> Layers<'a> {
        Layers::new(air, (-self.settings.mist.haze_depth).exp() as f32, [row0, column0])
    }

    /// Window and air of a frame on a clean map of `[rows, columns]`, its first pixel at `[row0,
    /// column0]`.
    ///
    /// # Errors
    /// Refuses more than a hundred thousand objects of a kind.
    pub(crate) fn frame(
        &self,
        frame_id: u64,
        [row0, column0]: [usize; 2],
        [rows, columns]: [usize; 2],
    ) -> Result<TransmissionMap, RenderError> {
        let mut map = TransmissionMap::new(rows, columns);
        map.shade(&self.window_layers(row0, column0));
        map.shade(&self.air_layers(&self.air(frame_id)?, row0, column0));
        Ok(map)
    }
}
