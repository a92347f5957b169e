//! Circles and the checks their fits share.

use glam::DVec2;

use super::certificate::Certificate;
use super::error::FormError;

/// A circle in the plane of a section, in the unit of the points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle {
    /// Its centre.
    pub centre: DVec2,
    /// Its radius.
    pub radius: f64,
}

impl Circle {
    /// Diameter.
    pub(crate) fn diameter(&self) -> f64 {
        2.0 * self.radius
    }

    /// Signed distance of a point from the circle, positive outside.
    pub(crate) fn deviation(&self, point: DVec2) -> f64 {
        point.distance(self.centre) - self.radius
    }
}

/// A reference circle with its proof.
#[derive(Clone, Debug, PartialEq)]
pub struct CircleFit {
    /// The circle. For a minimum zone, the mean of its two circles.
    pub circle: Circle,
    /// Greatest distance of a point from the centre.
    pub outer_radius: f64,
    /// Least distance of a point from the centre.
    pub inner_radius: f64,
    /// Proof that it is the best.
    pub certificate: Certificate,
}

impl CircleFit {
    /// Peak-to-valley deviation RONt, the width of the annulus about this centre that holds every
    /// point.
    pub(crate) fn peak_to_valley(&self) -> f64 {
        self.outer_radius - self.inner_radius
    }
}

/// Refuses too few or non-finite points.
pub(super) fn check(points: &[DVec2], needed: usize, feature: &'static str) -> Result<(), FormError> {
    if points.len() < needed {
        return Err(FormError::TooFew { feature, found: points.len(), needed });
    }
    points.iter().position(|p| !p.is_finite()).map_or(Ok(()), |index| Err(FormError::NotFinite { index }))
}

/// Centroid.
pub(super) fn centroid(points: &[DVec2]) -> DVec2 {
    points.iter().copied().sum::<DVec2>() / points.len() as f64
}

/// Least and greatest distance from a centre.
pub(super) fn radii(points: &[DVec2], centre: DVec2) -> (f64, f64) {
    points.iter().fold((f64::INFINITY, 0.0), |(low, high), p| {
        let r = p.distance(centre);
        (r.min(low), r.max(high))
    })
}

/// What counts as touching: distances in f64 are good to some 1e-16 of the radius and of the
/// coordinates.
pub(super) fn touching(points: &[DVec2], centre: DVec2) -> f64 {
    let reach = points.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    2e-13 * (reach + radii(points, centre).1)
}

/// Puts a fit together once its centre is known.
pub(super) fn assemble(
    points: &[DVec2],
    centre: DVec2,
    radius: impl Fn(f64, f64) -> f64,
    certificate: Certificate,
) -> CircleFit {
    let (inner_radius, outer_radius) = radii(points, centre);
    let circle = Circle { centre, radius: radius(inner_radius, outer_radius) };
    CircleFit { circle, outer_radius, inner_radius, certificate }
}
