//! The pixels of a band along a circle.

use glam::DVec2;

use super::super::form::Circle;
use crate::frame::FrameView;

/// One pixel near an edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgePixel {
    /// Grey value, counts; sign turned for a bright part, so that light is always the larger value.
    pub(super) value: f64,
    /// Distance from the circle towards the light, px.
    pub(super) distance: f64,
    /// Direction of the radius.
    pub(super) cos: f64,
    /// Direction of the radius.
    pub(super) sin: f64,
    /// Whether the value stands at the end of the scale on the light's side: the true one is at least that.
    pub(super) clipped: bool,
}

/// The pixels of each caliper, by sector.
#[derive(Clone, Debug)]
pub(super) struct Band {
    /// Pixels of each sector.
    pub(super) sectors: Vec<Vec<EdgePixel>>,
}

/// How to read a band.
#[derive(Clone, Copy, Debug)]
pub(super) struct BandOrder {
    /// The circle it follows.
    pub(super) circle: Circle,
    /// Light lies outside (outer edge) or inside (inner edge).
    pub(super) light_outside: bool,
    /// Half width towards the light and towards the shadow, px.
    pub(super) half: f64,
    /// Number of sectors.
    pub(super) sectors: usize,
    /// Part brighter than its surroundings.
    pub(super) bright_on_dark: bool,
}

/// Collects the pixels whose centres lie within the band, row by row.
pub(super) fn collect(view: &FrameView<'_>, order: &BandOrder) -> Band {
    let Circle { centre, radius } = order.circle;
    let side = if order.light_outside { 1.0 } else { -1.0 };
    let (outer, inner) = (radius + order.half, (radius - order.half).max(0.0));
    let clip = light_end(view, order.bright_on_dark);
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
                sectors[sector].push(EdgePixel {
                    value: sign * f64::from(value),
                    distance: side * (r - radius),
                    cos: arm.x / r,
                    sin: arm.y / r,
                    clipped: clip.is_some_and(|c| sign * f64::from(value) >= sign * c),
                });
            }
        }
    }
    Band { sectors }
}

/// Grey value at which light is clipped: full scale, or zero where the part is bright and the light is its dark ground.
fn light_end(view: &FrameView<'_>, bright_on_dark: bool) -> Option<f64> {
    view.full_scale().map(|full| if bright_on_dark { 0.0 } else { f64::from(full) })
}
