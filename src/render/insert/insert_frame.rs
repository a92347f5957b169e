//! Pixels of a back-lit insert: light over each pixel's area, light field, sensor, noise.

use glam::DVec2;
use rayon::prelude::*;

use super::area_blur::{AreaBlur, Contours};
use super::settings::InsertSettings;
use super::shape::{Shape, Truth};
use crate::frame::{Buffer, Frame, FrameMeta, PixelFormat};
use crate::render::error::RenderError;
use crate::render::kernel::params::{FrameKeys, GreyLevels, Params, Window, Windows};
use crate::render::kernel::shadowgraph::{Pixel as _, counts_of};
use crate::render::optics::esf_table::knife_edge;

/// Nodes and weights of Gauss-Legendre over a pixel, three points a side: its error is 1e-6 of the
/// contrast from a blur of 0.6 px on.
const NODES: [(f64, f64); 3] =
    [(-0.387_298_334_620_741_7, 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.387_298_334_620_741_7, 5.0 / 18.0)];
/// Those of two points a side, for pixels beside the transition: of fringes p px wide the error is
/// (2π/p)⁴/4320 of their height.
const NODES_BESIDE: [(f64, f64); 2] = [(-0.288_675_134_594_812_9, 0.5), (0.288_675_134_594_812_9, 0.5)];
/// Distance from the contour from which a pixel lies beside the transition, px.
const BESIDE_PX: f64 = 6.0;
/// Places of the contour a px: a third of the blur of 0.8 px, to which two nodes a piece integrate
/// to (1/3)⁴/4320.
const PLACES_PER_PX: f64 = 4.0;

/// A frame of an insert and what is true of it. The same settings, seed and number give the same
/// bytes at any number of threads; `noise` false leaves out temporal noise.
///
/// # Errors
/// A setting out of range.
pub(crate) fn render_insert(
    settings: &InsertSettings,
    (seed, number): (u64, u64),
    noise: bool,
) -> Result<(Frame, Truth), RenderError> {
    settings.check()?;
    let blur = InsertBlur::new(settings)?;
    render_insert_through(settings, &blur, (seed, number), noise)
}

/// The edge-spread function of an insert as it blurs areas: computed once for frames that differ by
/// pose, wear, contamination and noise alone.
pub(crate) struct InsertBlur(AreaBlur);

impl InsertBlur {
    /// That of the settings' family and scale.
    ///
    /// # Errors
    /// Families whose values are out of range.
    pub(crate) fn new(settings: &InsertSettings) -> Result<Self, RenderError> {
        settings.esf.check()?;
        let spread = knife_edge(&settings.esf, settings.camera.um_per_px)?;
        Ok(Self(AreaBlur::new(spread, settings.camera.um_per_px)))
    }
}

/// [`render_insert`] through a blur that was computed from the same family and scale.
///
/// # Errors
/// A setting out of range.
pub(crate) fn render_insert_through(
    settings: &InsertSettings,
    InsertBlur(blur): &InsertBlur,
    (seed, number): (u64, u64),
    noise: bool,
) -> Result<(Frame, Truth), RenderError> {
    settings.check()?;
    let scene = Scene::new(settings, blur);
    let (rows, columns) = (settings.camera.rows, settings.camera.columns);
    let window = Window { row: 0, column: 0, rows, columns };
    let keys = FrameKeys { seed, frame_id: number, pattern_seed: seed };
    let windows = Windows { first: window, second: None };
    let params = Params::new(windows, settings.sensor.format, &levels(settings), noise, keys);
    let mut counts = vec![0.0_f32; rows as usize * columns as usize];
    counts.par_chunks_mut(columns as usize).enumerate().for_each(|(row, line)| {
        for (column, out) in line.iter_mut().enumerate() {
            let light = scene.light(row, column) * scene.field(row, column);
            *out = counts_of(&params, light as f32, row as u32, column as u32);
        }
    });
    let format = settings.sensor.format;
    let pixels = match format {
        PixelFormat::F32 => Buffer::F32(counts.iter().map(|c| f32::from_counts(&params, *c)).collect()),
        PixelFormat::Mono8 => Buffer::U8(counts.iter().map(|c| u8::from_counts(&params, *c)).collect()),
        _ => Buffer::U16(counts.iter().map(|c| u16::from_counts(&params, *c)).collect()),
    };
    let meta = FrameMeta { frame_id: number, ..FrameMeta::default() };
    let frame = Frame::new(pixels, format, rows as usize, columns as usize, meta);
    let frame = frame.map_err(|e| RenderError::Field { what: e.to_string() })?;
    Ok((frame, scene.shape.truth()))
}

fn levels(s: &InsertSettings) -> GreyLevels {
    GreyLevels {
        shadow: s.light.shadow_counts,
        bright: s.light.bright_in(&s.sensor, s.sensor.electrons_per_count),
        black: s.sensor.black_level_counts,
        electrons_per_count: s.sensor.electrons_per_count,
        read_noise_e: s.sensor.read_noise_e,
        full_well_e: s.sensor.full_well_e,
        prnu: s.sensor.prnu_rel,
        dsnu_e: s.sensor.dsnu_e,
        hot_ppm: s.sensor.hot_pixels_ppm,
        hot_pixel_e: s.sensor.hot_pixel_e,
    }
}

struct Scene<'a> {
    settings: &'a InsertSettings,
    shape: Shape,
    blur: &'a AreaBlur,
    contours: Contours,
    specks: Vec<(DVec2, f64)>,
    /// Distance from the nose's centre beyond which an edge is straight for a pixel, px.
    straight_px: f64,
}

impl<'a> Scene<'a> {
    fn new(settings: &'a InsertSettings, blur: &'a AreaBlur) -> Self {
        let shape = Shape::new(settings);
        let beyond = 3.0 * blur.reach_px() + 4.0;
        let specks: Vec<(DVec2, f64)> = settings
            .dirt
            .iter()
            .map(|d| (DVec2::new(d.centre_px[0], -d.centre_px[1]), d.radius_um / settings.camera.um_per_px))
            .collect();
        let mut contours = vec![shape.contour(1.0 / PLACES_PER_PX, beyond)];
        for (at, radius) in &specks {
            let n = (std::f64::consts::TAU * radius * PLACES_PER_PX).ceil().max(32.0);
            let angle = |k: usize| std::f64::consts::TAU * k as f64 / n;
            contours.push((0..=n as usize).map(|k| *at + DVec2::from_angle(angle(k)) * *radius).collect());
        }
        let contours = Contours::new(&contours, blur.reach_px());
        let straight_px = blur.reach_px() + 2.0;
        Self { settings, shape, blur, contours, specks, straight_px }
    }

    /// Brightness of the field at a pixel.
    fn field(&self, row: usize, column: usize) -> f64 {
        let (rows, columns) = (f64::from(self.settings.camera.rows), f64::from(self.settings.camera.columns));
        let half = 0.5 * rows.hypot(columns);
        let (u, v) = (column as f64 - 0.5 * (columns - 1.0), row as f64 - 0.5 * (rows - 1.0));
        self.settings.light.field.factor(u / half, v / half)
    }

    /// Whether insert or contamination covers a place.
    fn covers(&self, p: DVec2) -> bool {
        self.specks.iter().any(|(c, r)| p.distance(*c) < *r) || self.shape.contains(p)
    }

    /// Light over a pixel's area.
    fn light(&self, row: usize, column: usize) -> f64 {
        let p = DVec2::new(column as f64, -(row as f64));
        let near_speck = self.specks.iter().any(|(at, r)| p.distance(*at) < r + self.straight_px);
        let arm = p - self.shape.centre;
        if !near_speck {
            for (normal, side) in self.shape.normals().into_iter().zip([-1.0, 1.0]) {
                let (d, along) = (normal.dot(arm) - self.shape.radius_px, side * normal.perp().dot(arm));
                if along > self.straight_px && d.abs() < self.straight_px {
                    return self.blur.straight(d, normal.to_angle());
                }
            }
        }
        let Some(distance_px) = self.contours.distance_px(p) else {
            return f64::from(u8::from(!self.covers(p)));
        };
        let nodes: &[(f64, f64)] = if distance_px > BESIDE_PX { &NODES_BESIDE } else { &NODES };
        let mut light = 0.0;
        for (x, wx) in nodes {
            for (y, wy) in nodes {
                let at = p + DVec2::new(*x, *y);
                light += wx * wy * self.contours.light(self.blur, at, self.covers(at));
            }
        }
        light.max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::settings::{Esf, GaussianEsf};

    fn settings(columns: u32, rows: u32) -> InsertSettings {
        let mut s = InsertSettings::default();
        (s.camera.columns, s.camera.rows) = (columns, rows);
        s.nose.centre_px = [0.4 * f64::from(columns), 0.5 * f64::from(rows)];
        s.nose.radius_mm = 0.1;
        s
    }

    #[test]
    fn light_over_area_is_the_sum_over_a_fine_grid_at_a_chip() {
        let mut s = settings(200, 200);
        let (direction_deg, width_deg, depth_um) = (237.0, 20.0, 12.0);
        s.wear = vec![super::super::settings::Wear::Chip { direction_deg, width_deg, depth_um }];
        s.esf = Esf::Gaussian(GaussianEsf { sigma_px: 1.2 });
        let spread = knife_edge(&s.esf, s.camera.um_per_px).unwrap();
        let blur = AreaBlur::new(spread, s.camera.um_per_px);
        let scene = Scene::new(&s, &blur);
        // A border across rows of h px: each is off by h/√12, 2σ√π/h of them: 2e-4 in the mean.
        let (sigma2, h) = (1.44, 0.025);
        for turn in [40.0_f64, 55.0, 60.0, 66.0, 100.0] {
            let a = scene.shape.from_rad + turn.to_radians();
            let at =
                scene.shape.centre + DVec2::from_angle(a) * (scene.shape.radius(turn.to_radians()) + 0.3);
            let (column, row) = (at.x.round(), -at.y.round());
            let (mut lit, mut all) = (0.0, 0.0);
            for i in -220..220 {
                for j in -220..220 {
                    let q = DVec2::new((f64::from(i) + 0.5) * h, (f64::from(j) + 0.5) * h);
                    // the pixel's square convolved with the blur, along each axis
                    let w = |x: f64| {
                        let phi = crate::numerics::distributions::phi_cdf;
                        phi((x + 0.5) / f64::sqrt(sigma2)) - phi((x - 0.5) / f64::sqrt(sigma2))
                    };
                    let weight = w(q.x) * w(q.y);
                    all += weight;
                    lit += if scene.shape.contains(DVec2::new(column, -row) + q) { 0.0 } else { weight };
                }
            }
            let found = scene.light(row as usize, column as usize);
            assert!((found - lit / all).abs() < 6e-4, "{turn}: {found} {}", lit / all);
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_bytes_and_another_one_others() {
        let s = settings(160, 120);
        let render = |seed| render_insert(&s, (seed, 0), true).unwrap().0;
        assert_eq!(render(3), render(3));
        assert_ne!(render(3), render(4));
    }
}
