//! The outline of an edge: caliper by caliper, its roundness, and the outline as traced by a ball.

use glam::DVec2;
use std::f64::consts::TAU;

use super::super::form::{
    Circle, Cutoff, FormError, Reference, gaussian_closed, least_squares_circle, roundness,
};
use super::edge_fit::EdgeFit;

/// How a point of an outline was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointOrigin {
    /// An edge was fitted and is trusted.
    Fitted,
    /// Refused as burr or contamination: where the grey values cross the middle of the levels.
    Crossing,
    /// Nothing to be seen: a straight line between the neighbours.
    Bridged,
}

/// Points of an edge around its circle, one a caliper, at angles (k + ½)·2π/n from the column axis
/// towards the rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outline {
    /// Centre that the angles and radii count from: x the column, y the row, px.
    pub centre_px: [f64; 2],
    /// The points, one a caliper.
    pub points: Vec<OutlinePoint>,
    /// Whether the part lies within: an outline and no bore.
    pub outer: bool,
}

/// A point of an outline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutlinePoint {
    /// Radius with the curvature bias corrected, px.
    pub radius_px: f64,
    /// How it was found.
    pub origin: PointOrigin,
}

/// Least ratio of a part's diameter to the radius of the stylus tip, for a Gaussian filter of so
/// many undulations per revolution (ISO 12181-2): a larger tip would filter more than the filter
/// does.
pub(super) fn least_ratio_to_stylus(cutoff_upr: f64) -> f64 {
    let table = [(15.0, 5.0), (50.0, 15.0), (150.0, 50.0), (500.0, 150.0)];
    table.into_iter().find(|(upr, _)| cutoff_upr <= *upr).map_or(500.0, |(_, ratio)| ratio)
}

impl Outline {
    pub(super) fn new(outer: bool, followed: &Circle, fit: &EdgeFit, curvature: f64) -> Self {
        let sign = if outer { 1.0 } else { -1.0 };
        let at = |shift: f64| followed.radius + sign * shift + curvature;
        let found = fit.calipers.iter().map(|c| match (c.good, c.crossing) {
            (true, _) => (Some(at(c.shift)), PointOrigin::Fitted),
            (false, Some(crossing)) => (Some(at(crossing)), PointOrigin::Crossing),
            (false, None) => (None, PointOrigin::Bridged),
        });
        let (radii, origins): (Vec<_>, Vec<_>) = found.unzip();
        let point = |(radius_px, origin)| OutlinePoint { radius_px, origin };
        let points = bridged(&radii).into_iter().zip(origins).map(point).collect();
        Self { centre_px: followed.centre.to_array(), points, outer }
    }

    /// Angle of point k, radians.
    pub(crate) fn angle(&self, k: usize) -> f64 {
        TAU * (k as f64 + 0.5) / self.points.len() as f64
    }

    /// Point k: x the column, y the row, px.
    pub(crate) fn point_px(&self, k: usize) -> [f64; 2] {
        (DVec2::from(self.centre_px) + DVec2::from_angle(self.angle(k)) * self.points[k].radius_px).to_array()
    }

    /// Radii with straight lines over what is refused.
    pub(super) fn trusted_radii(&self) -> Vec<f64> {
        let trusted = |p: &OutlinePoint| (p.origin == PointOrigin::Fitted).then_some(p.radius_px);
        bridged(&self.points.iter().map(trusted).collect::<Vec<_>>())
    }

    /// RONt of the filtered profile of the trusted calipers about the least-squares circle, px.
    pub(super) fn roundness_px(&self, cutoff_upr: f64) -> Result<f64, FormError> {
        roundness_of(&self.trusted_radii(), cutoff_upr)
    }

    /// Least-squares diameter of the outline as traced by a ball of this radius, burrs included,
    /// px.
    ///
    /// # Errors
    /// A ball that does not fit the bore.
    pub(crate) fn felt_diameter_px(&self, tip_radius_px: f64) -> Result<f64, FormError> {
        let outward = if self.outer { 1.0 } else { -1.0 };
        let radii = || self.points.iter().map(|p| p.radius_px);
        let mean = radii().sum::<f64>() / self.points.len().max(1) as f64;
        // A ball against a convex outline parts from it as 1/tip + 1/R, in a bore as 1/tip - 1/R.
        let curvature = 1.0 / tip_radius_px + outward / mean;
        if !(curvature > 0.0) {
            return Err(FormError::Argument {
                name: "stylus radius",
                value: tip_radius_px,
                right: "below the radius of the bore",
            });
        }
        let heights: Vec<f64> = radii().map(|r| outward * (r - mean)).collect();
        let arc = TAU * mean / heights.len() as f64;
        let felt: Vec<f64> =
            mechanical_closing(&heights, arc, curvature).iter().map(|h| mean + outward * h).collect();
        Ok(least_squares_circle(&closed(&felt))?.fit.circle.diameter())
    }
}

/// RONt about the least-squares circle after a Gaussian filter.
pub(super) fn roundness_of(radii: &[f64], cutoff_upr: f64) -> Result<f64, FormError> {
    let cutoff = Cutoff::upr(cutoff_upr)?;
    Ok(roundness(&closed(&gaussian_closed(radii, cutoff)), Reference::LeastSquares)?.ron_t)
}

/// Points of a closed profile of radii.
fn closed(radii: &[f64]) -> Vec<DVec2> {
    let n = radii.len() as f64;
    radii.iter().enumerate().map(|(k, r)| DVec2::from_angle(TAU * (k as f64 + 0.5) / n) * *r).collect()
}

/// Straight lines over the gaps of a closed profile.
fn bridged(shifts: &[Option<f64>]) -> Vec<f64> {
    let n = shifts.len();
    let nearest = |k: usize, step: usize| {
        (0..n).map(|j| (j, (k + j * step) % n)).find_map(|(j, at)| shifts[at].map(|s| (j as f64, s)))
    };
    (0..n)
        .map(|k| {
            let (ahead, after) = nearest(k, 1).unwrap_or_default();
            let (behind, before) = nearest(k, n - 1).unwrap_or_default();
            if ahead + behind > 0.0 { (before * ahead + after * behind) / (ahead + behind) } else { after }
        })
        .collect()
}

/// Morphological closing of a closed profile by a ball (ISO 16610-41), heights positive out of the
/// material: the ball's centre rides on the highest contact, and its lower side is the traced
/// profile. A parabola of the given curvature approximates the ball, right to (contact
/// distance/radius)² of the height.
fn mechanical_closing(heights: &[f64], arc: f64, curvature: f64) -> Vec<f64> {
    let n = heights.len();
    let (low, high) =
        heights.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
    let reach = (((2.0 * (high - low) / curvature).sqrt() / arc).ceil() as usize).min(n / 2 - 1);
    let ball: Vec<f64> = (0..=reach).map(|j| 0.5 * curvature * (j as f64 * arc).powi(2)).collect();
    let pass = |from: &[f64], sign: f64| -> Vec<f64> {
        (0..n)
            .map(|k| {
                (0..=reach).fold(f64::NEG_INFINITY, |best, j| {
                    let (a, b) = (sign * from[(k + j) % n], sign * from[(k + n - j) % n]);
                    best.max(a.max(b) - ball[j])
                }) * sign
            })
            .collect()
    };
    pass(&pass(heights, 1.0), -1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closing_rides_on_peaks_and_leaves_what_a_ball_can_follow() {
        let (n, arc, radius) = (1000, 1.0, 50.0);
        let smooth: Vec<f64> = (0..n).map(|k| (TAU * k as f64 / n as f64 * 3.0).cos()).collect();
        for (a, b) in smooth.iter().zip(mechanical_closing(&smooth, arc, 1.0 / radius)) {
            assert!((a - b).abs() < 1e-3, "{a} {b}");
        }
        let mut spike = vec![0.0; n];
        spike[500] = 0.5;
        let felt = mechanical_closing(&spike, arc, 1.0 / radius);
        assert_eq!((felt[500], felt[600]), (0.5, 0.0));
        // Beside a spike of height p the ball hangs on it: felt is at most p − s²/2r, and nowhere
        // below the profile.
        assert!(felt[503] > 0.0 && felt.iter().zip(&spike).all(|(f, s)| f >= s));
        let mut groove = vec![0.0; n];
        groove[500] = -0.5;
        let felt = mechanical_closing(&groove, arc, 1.0 / radius);
        assert!(felt[500] > -0.011 - 1e-12, "a ball of 50 sinks 1/(2·50) into a gap of ±1: {}", felt[500]);
    }
}
