//! The pixels of a band along a circle.

use glam::DVec2;

use super::super::form::Circle;
use crate::frame::FrameView;
use crate::gauge::edge::estimation::censored::Ends;
use crate::gauge::edge::estimation::grey_ends::{self, Level};
use crate::gauge::edge::estimation::light_field::LightField;
use crate::gauge::limit::limits;

limits! {
    /// Which pixels of the band around an edge are flat.
    BandLimits = "ring_band";
    /// Share of the band's half width beyond which pixels are flat: the band reaches several times
    /// the blur to either side. Tuned: see study limits.
    flat: f64 = 0.7;
}

/// One pixel near an edge.
#[derive(Clone, Copy, Debug)]
pub(in crate::gauge) struct EdgePixel {
    /// Grey value, counts; sign turned for a bright part, so that light is always the larger value.
    pub(in crate::gauge) value: f64,
    /// Distance from the circle towards the light, px.
    pub(in crate::gauge) distance: f64,
    /// Direction of the radius.
    pub(in crate::gauge) cos: f64,
    /// Direction of the radius.
    pub(in crate::gauge) sin: f64,
    /// Place from the band's origin in units of its size, along the columns.
    pub(in crate::gauge) x: f64,
    /// The same down the rows.
    pub(in crate::gauge) y: f64,
}

/// The pixels of each caliper, by sector.
#[derive(Clone, Debug)]
pub(in crate::gauge) struct Band {
    /// Pixels of each sector.
    pub(in crate::gauge) sectors: Vec<Vec<EdgePixel>>,
    /// Whether the signs of the grey values are turned.
    pub(in crate::gauge) turned: bool,
    /// Place that the pixels' count from.
    pub(in crate::gauge) origin: DVec2,
    /// Their unit, px.
    pub(in crate::gauge) unit_px: f64,
}

/// Geometry of a band.
#[derive(Clone, Copy, Debug)]
pub(in crate::gauge) struct BandOrder {
    /// The circle it follows.
    pub(in crate::gauge) circle: Circle,
    /// Light lies outside (outer edge) or inside (inner edge).
    pub(in crate::gauge) light_outside: bool,
    /// Half width towards the light and towards the shadow, px.
    pub(in crate::gauge) half: f64,
    /// Number of sectors.
    pub(in crate::gauge) sectors: usize,
    /// Part brighter than its surroundings.
    pub(in crate::gauge) bright_on_dark: bool,
}

/// Collects the pixels whose centres lie within the band, row by row.
pub(in crate::gauge) fn collect(view: &FrameView<'_>, order: &BandOrder) -> Band {
    let Circle { centre, radius } = order.circle;
    let side = if order.light_outside { 1.0 } else { -1.0 };
    let (outer, inner) = (radius + order.half, (radius - order.half).max(0.0));
    let sign = if order.bright_on_dark { -1.0 } else { 1.0 };
    let mut sectors = vec![Vec::new(); order.sectors];
    let last = |n: usize, v: f64| (v.floor().max(-1.0) as isize).min(n as isize - 1);
    let first_row = (centre.y - outer).ceil().max(0.0) as isize;
    for row in first_row..=last(view.rows(), centre.y + outer) {
        let dy = row as f64 - centre.y;
        let reach = (outer * outer - dy * dy).max(0.0).sqrt();
        let hole = (inner * inner - dy * dy).max(0.0).sqrt();
        for (from, to) in [(centre.x - reach, centre.x - hole), (centre.x + hole, centre.x + reach)] {
            for column in (from.ceil().max(0.0) as isize)..=last(view.columns(), to) {
                let Some(value) = view.get(row as usize, column as usize) else { continue };
                let arm = DVec2::new(column as f64 - centre.x, dy);
                let r = arm.length();
                if r <= inner || r > outer {
                    continue;
                }
                let turn = arm.y.atan2(arm.x).rem_euclid(std::f64::consts::TAU) / std::f64::consts::TAU;
                let sector = ((turn * order.sectors as f64) as usize).min(order.sectors - 1);
                let (cos, sin, reach) = (arm.x / r, arm.y / r, r / radius);
                sectors[sector].push(EdgePixel {
                    value: sign * f64::from(value),
                    distance: side * (r - radius),
                    cos,
                    sin,
                    x: reach * cos,
                    y: reach * sin,
                });
            }
        }
    }
    Band { sectors, turned: order.bright_on_dark, origin: centre, unit_px: radius }
}

impl Band {
    /// Where a pixel stands, px.
    pub(in crate::gauge) fn place(&self, pixel: &EdgePixel) -> DVec2 {
        self.origin + DVec2::new(pixel.x, pixel.y) * self.unit_px
    }

    /// Divides the pixels by an uneven light; `dark` is the shadow's level, counts.
    pub(in crate::gauge) fn level(&mut self, field: &LightField, dark: f64) {
        let (origin, unit) = (self.origin, self.unit_px);
        for pixel in self.sectors.iter_mut().flatten() {
            let light = field.relative(origin.x + unit * pixel.x, origin.y + unit * pixel.y);
            pixel.value = dark + (pixel.value - dark) / light;
        }
    }

    /// Where the band's grey values are clipped, if they are; `flank` is the noise at mid-edge,
    /// counts, and `whole` whether grey values are whole counts.
    pub(in crate::gauge) fn ends(&self, flank: f64, whole: bool) -> Option<Ends> {
        let limits = BandLimits::get();
        let reach = self.sectors.iter().flatten().map(|p| p.distance).fold(0.0, f64::max);
        let flat = |level: Level, p: &&EdgePixel| f64::from(level.sign()) * p.distance > limits.flat * reach;
        let of = |level: Level| -> Vec<Vec<f32>> {
            let values = |sector: &Vec<EdgePixel>| {
                let flat = sector.iter().filter(|p| flat(level, p));
                flat.map(|p| level.sign() * p.value as f32).collect()
            };
            self.sectors.iter().map(values).collect()
        };
        let (dark, light) = (of(Level::Dark), of(Level::Light));
        let mean = |v: &[Vec<f32>]| {
            let sum: f64 = v.iter().flatten().map(|v| f64::from(*v)).sum();
            sum / v.iter().flatten().count().max(1) as f64
        };
        let contrast = mean(&light) + mean(&dark);
        // Light too far beyond the end for a fit: the noise of an ordinary frame.
        let flank = if flank.is_finite() { flank } else { 0.01 * contrast };
        let unit = if whole { 1.0 } else { 0.0 };
        let scatter = [&dark, &light].map(|v| pairs_below(v, f32::INFINITY, unit).unwrap_or(0.0));
        let find = |level: Level, values: &[Vec<f32>], other: f64| {
            let mut pool: Vec<f32> = values.iter().flatten().copied().collect();
            let found = grey_ends::judge(&mut pool, unit, contrast, |end, least, step| {
                let free = |s: f64| (s * s - step * step / 12.0).max(0.0).sqrt();
                let below = pairs_below(values, end, step).map_or(0.0, free);
                // The residuals of the flank are not noise only: they do not show that of the
                // level of less light.
                let brighter = (level == Level::Light) != self.turned;
                let flank = if brighter { free(flank) } else { 0.0 };
                if below > least {
                    below
                } else {
                    grey_ends::expected_noise(brighter, (flank, 0.0), free(other))
                }
            });
            found.map(|(end, step)| (level.sign() * end, step))
        };
        let low = find(Level::Dark, &dark, scatter[1]);
        let high = find(Level::Light, &light, scatter[0]);
        Ends::of(low, high)
    }
}

/// Noise of successive flat pixels of a sector below an end, counts; `None` of too few. `step` is
/// the distance of two grey values, counts, 0 where there is none.
fn pairs_below(sectors: &[Vec<f32>], end: f32, step: f64) -> Option<f64> {
    let pairs = sectors.iter().flat_map(|sector| sector.windows(2)).map(|w| [w[0], w[1]]);
    grey_ends::noise_of_pairs(pairs, end, step)
}
