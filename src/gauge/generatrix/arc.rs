//! The circle through the calipers of an arc.

use glam::DVec2;

use super::band::ArcBand;
use super::limits::GeneratrixLimits;
use crate::gauge::form::least_squares_circle;
use crate::gauge::ring::edge_fit::Caliper;
use crate::numerics::robust::{MEDIAN_TO_SD, median_of};

/// A circle, px.
pub(super) struct ArcFit {
    pub(super) centre: DVec2,
    pub(super) radius: f64,
    pub(super) convex: bool,
    /// Standard uncertainty of the radius by the calipers' own noise.
    pub(super) u_radius: f64,
    /// Calipers on it.
    pub(super) on_arc: usize,
}

/// Places of the calipers, and the least-squares circle of those that lie on it; `sigma` is the
/// blur, px. A blurred edge stands towards the inside of its curve by (σ² + 1/12)/2R
/// (`gauge/ring`).
pub(super) fn arc_fit(arc: &ArcBand, calipers: &[Caliper], sigma: f64) -> Option<ArcFit> {
    let curvature = 0.5 * (sigma * sigma + 1.0 / 12.0) / arc.radius;
    let place = |(k, c): (usize, &Caliper)| {
        let radius = arc.radius + arc.outwards * c.shift + curvature;
        arc.centre + radius * DVec2::from_angle(arc.direction_rad(k))
    };
    let good = || calipers.iter().enumerate().filter(|(_, c)| c.good);
    let mut on: Vec<DVec2> = good().map(place).collect();
    let all = on.clone();
    let usual_u = median_of(good().map(|(_, c)| c.u_own).collect());
    let mut fit = least_squares_circle(&on).ok()?;
    // a round without those that are off, until their number stays
    for _ in 0..8 {
        let (centre, radius) = (fit.fit.circle.centre, fit.fit.circle.radius);
        let off = |p: &DVec2| (p.distance(centre) - radius).abs();
        let spread = (MEDIAN_TO_SD * median_of(all.iter().map(off).collect())).max(usual_u);
        let within = GeneratrixLimits::get().on_arc_spreads * spread;
        let next: Vec<DVec2> = all.iter().copied().filter(|p| off(p) <= within).collect();
        if next.len() == on.len() {
            break;
        }
        fit = least_squares_circle(&next).ok()?;
        on = next;
    }
    let circle = fit.fit.circle;
    Some(ArcFit {
        centre: circle.centre,
        radius: circle.radius,
        convex: arc.outwards > 0.0,
        u_radius: fit.covariance[(2, 2)].max(0.0).sqrt() * usual_u.max(fit.rms),
        on_arc: on.len(),
    })
}
