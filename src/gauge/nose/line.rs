//! A straight edge by its calipers, robustly, with the covariance of its place and direction.

use glam::DVec2;

use super::limits::NoseLimits;
use crate::gauge::ring::edge_fit::SHARED;
use crate::numerics::robust::{MEDIAN_TO_SD, median_of};

/// A straight edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::gauge) struct EdgeLine {
    /// Unit normal towards the light; the contour goes on along its perpendicular,
    /// counter-clockwise.
    pub(in crate::gauge) normal: DVec2,
    /// The place about which direction and offset are uncorrelated.
    pub(in crate::gauge) at: DVec2,
    /// Standard uncertainty of the offset along the normal at `at`, px.
    pub(super) u_offset_px: f64,
    /// Standard uncertainty of the direction, rad.
    pub(super) u_angle_rad: f64,
    /// The part of the offset's uncertainty that all calipers of the frame share, px.
    pub(super) shared_offset: [f64; SHARED],
    /// The same of the direction, rad.
    pub(super) shared_angle: [f64; SHARED],
}

/// A caliper of an edge.
#[derive(Clone, Copy, Debug)]
pub(in crate::gauge) struct EdgePoint {
    /// Place along the line it was measured from, px.
    pub(in crate::gauge) along: f64,
    /// Distance of the edge from that line towards the light, px.
    pub(in crate::gauge) shift: f64,
    /// Its own standard uncertainty, px.
    pub(in crate::gauge) u: f64,
    /// What it shares with the other calipers, px.
    pub(in crate::gauge) shared: [f64; SHARED],
}

/// A line through calipers.
#[derive(Clone, Debug)]
pub(in crate::gauge) struct LineFit {
    /// The line.
    pub(in crate::gauge) line: EdgeLine,
    /// Calipers on it.
    pub(in crate::gauge) on_line: usize,
    /// Departures of the others towards the light, px.
    pub(in crate::gauge) off: Vec<f64>,
}

impl EdgeLine {
    /// A line that nothing is known of yet.
    pub(in crate::gauge) fn coarse(normal: DVec2, at: DVec2) -> Self {
        let none = [0.0; SHARED];
        Self { normal, at, u_offset_px: 0.0, u_angle_rad: 0.0, shared_offset: none, shared_angle: none }
    }

    /// Direction in which the contour goes on.
    pub(in crate::gauge) fn along(&self) -> DVec2 {
        self.normal.perp()
    }

    /// Distance of a place from the line towards the light, px.
    pub(in crate::gauge) fn distance(&self, p: DVec2) -> f64 {
        self.normal.dot(p - self.at)
    }

    /// Uncertainty of the offset at a place along it, px: its own, and what all calipers share.
    pub(in crate::gauge) fn u_at(&self, p: DVec2) -> (f64, [f64; SHARED]) {
        let place = self.along().dot(p - self.at);
        let shared = std::array::from_fn(|k| self.shared_offset[k] + place * self.shared_angle[k]);
        (self.u_offset_px.hypot(self.u_angle_rad * place), shared)
    }

    /// Standard uncertainty of the direction, rad.
    pub(super) fn u_direction_rad(&self) -> f64 {
        (self.u_angle_rad.powi(2) + product(&self.shared_angle, &self.shared_angle)).sqrt()
    }
}

/// Covariance of two quantities by what they share.
pub(super) fn product(a: &[f64; SHARED], b: &[f64; SHARED]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The line through calipers that were measured from `from`; of several stretches the one that most
/// of them lie on. `None` where fewer than three do.
pub(in crate::gauge) fn fit(from: &EdgeLine, points: &[EdgePoint]) -> Option<LineFit> {
    let limits = NoseLimits::get();
    let usual_u = median_of(points.iter().map(|p| p.u).collect());
    let mut within = limits.on_line_px.max(limits.on_line_spreads * usual_u);
    let mut line = consensus(points, within)?;
    let mut result = None;
    for _ in 0..6 {
        let on: Vec<&EdgePoint> =
            points.iter().filter(|p| (p.shift - line.at(p.along)).abs() <= within).collect();
        let next = weighted(&on)?;
        let residuals = on.iter().map(|p| (p.shift - next.at(p.along)).abs()).collect();
        let spread = (MEDIAN_TO_SD * median_of(residuals)).max(usual_u);
        within = limits.on_line_spreads * spread;
        line = next;
        result = Some(on.len());
    }
    let beyond = |p: &&EdgePoint| (p.shift - line.at(p.along)).abs() > within;
    let off = points.iter().filter(beyond).map(|p| p.shift - line.at(p.along)).collect();
    let along = from.along();
    let normal = (from.normal - along * line.slope).normalize();
    let at = from.at + along * line.middle + from.normal * line.offset;
    let line = EdgeLine {
        normal,
        at,
        u_offset_px: line.u_offset,
        u_angle_rad: line.u_slope,
        shared_offset: line.shared_offset,
        shared_angle: line.shared_slope,
    };
    Some(LineFit { line, on_line: result?, off })
}

/// shift = offset + slope·(along − middle).
#[derive(Clone, Copy, Debug, Default)]
struct Straight {
    middle: f64,
    offset: f64,
    slope: f64,
    u_offset: f64,
    u_slope: f64,
    shared_offset: [f64; SHARED],
    shared_slope: [f64; SHARED],
}

impl Straight {
    fn at(&self, along: f64) -> f64 {
        self.offset + self.slope * (along - self.middle)
    }
}

/// The line through two calipers that most others lie on.
fn consensus(points: &[EdgePoint], within: f64) -> Option<Straight> {
    let (n, mut best) = (points.len(), None);
    for reach in [n / 4, n / 2, 3 * n / 4].into_iter().filter(|r| *r > 0) {
        for k in 0..n - reach {
            let (a, b) = (points[k], points[k + reach]);
            let slope = (b.shift - a.shift) / (b.along - a.along);
            let line = Straight { middle: a.along, offset: a.shift, slope, ..Straight::default() };
            let on = points.iter().filter(|p| (p.shift - line.at(p.along)).abs() <= within).count();
            if best.is_none_or(|(most, _)| on > most) {
                best = Some((on, line));
            }
        }
    }
    best.map(|(_, line)| line)
}

/// Weighted least squares; u grows with χ² where the calipers scatter more than they state.
fn weighted(on: &[&EdgePoint]) -> Option<Straight> {
    if on.len() < 3 {
        return None;
    }
    let w = |p: &EdgePoint| p.u.max(1e-6).powi(-2);
    let sum: f64 = on.iter().map(|p| w(p)).sum();
    let middle = on.iter().map(|p| w(p) * p.along).sum::<f64>() / sum;
    let offset = on.iter().map(|p| w(p) * p.shift).sum::<f64>() / sum;
    let square: f64 = on.iter().map(|p| w(p) * (p.along - middle).powi(2)).sum();
    let slope = on.iter().map(|p| w(p) * (p.along - middle) * p.shift).sum::<f64>() / square;
    let mut line = Straight { middle, offset, slope, ..Straight::default() };
    let chi2 =
        on.iter().map(|p| w(p) * (p.shift - line.at(p.along)).powi(2)).sum::<f64>() / (on.len() - 2) as f64;
    let wider = chi2.max(1.0).sqrt();
    for k in 0..SHARED {
        line.shared_offset[k] = on.iter().map(|p| w(p) * p.shared[k]).sum::<f64>() / sum;
        let lever = on.iter().map(|p| w(p) * (p.along - middle) * p.shared[k]);
        line.shared_slope[k] = lever.sum::<f64>() / square;
    }
    (line.u_offset, line.u_slope) = (wider / sum.sqrt(), wider / square.sqrt());
    line.slope.is_finite().then_some(line)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Deviates of unit variance, even over ±√3.
    fn noise(k: usize) -> f64 {
        ((k as f64 * 0.618_033_988_7).fract() - 0.5) * 12f64.sqrt()
    }

    #[test]
    fn a_line_passes_worn_and_dirty_calipers_by() {
        let from = EdgeLine::coarse(DVec2::from_angle(0.4), DVec2::new(10.0, -20.0));
        let points: Vec<EdgePoint> = (0..120)
            .map(|k| {
                let along = 8.0 * k as f64;
                let worn = if k < 40 { -3.0 } else { 0.0 };
                let dirt = if (70..74).contains(&k) { 4.0 } else { 0.0 };
                EdgePoint {
                    along,
                    shift: 0.3 + 1e-3 * along + worn + dirt + 0.02 * noise(k),
                    u: 0.02,
                    shared: [0.0; SHARED],
                }
            })
            .collect();
        let found = fit(&from, &points).unwrap();
        assert_eq!(found.off.len(), 44, "{found:?}");
        // a contour that moves outwards along itself turns its normal back
        let turn = from.normal.angle_to(found.line.normal);
        assert!((turn + 1e-3f64.atan()).abs() < 4.0 * found.line.u_angle_rad, "{turn}");
        let right = from.at + from.along() * 500.0 + from.normal * 0.8;
        assert!(found.line.distance(right).abs() < 4.0 * found.line.u_at(right).0);
        // Σ(along − mean)² of 76 places 8 px apart, the closed form of even steps for u of the
        // slope
        assert!((found.line.u_offset_px / (0.02 / 76f64.sqrt()) - 1.0).abs() < 0.1);
    }
}
