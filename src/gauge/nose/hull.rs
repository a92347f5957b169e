//! The convex hull of a nose's contour, and how far it reaches in every direction.
//!
//! The places of the contour stand in the order of their directions about the centre, over less
//! than 180°: with the centre, which is then a corner of the hull, they are Graham's order (R. L.
//! Graham, Inf. Process. Lett. 1 (1972) 132), and one pass finds the hull. What reaches farthest
//! goes round the hull with the direction.

use glam::DVec2;
use nalgebra::DVector;

use super::limits::NoseLimits;
use super::path::Path;

/// The hull of contours given by departures of their sectors from a path's nominal radius.
pub(super) struct Hull {
    /// Directions in which it is wanted, rad, in even steps from one edge's normal to the other's.
    directions_rad: Vec<f64>,
    /// The same, as vectors.
    normals: Vec<DVec2>,
    /// Directions of the contour's places.
    arms: Vec<DVec2>,
    /// What the four sectors about a place make of its radius, by its place between the middles of
    /// two, in half places.
    weights: Vec<[f64; 4]>,
    /// Nominal radius, and those of the edges' lines in two sectors before the nose and behind it,
    /// px.
    nominal_px: f64,
    before: [f64; 2],
    behind: [f64; 2],
}

impl Hull {
    /// For contours of a path's sectors.
    pub(super) fn new(path: &Path) -> Self {
        let limits = NoseLimits::get();
        let count = (path.sweep_rad.to_degrees() / limits.support_step_deg).ceil().max(2.0) as usize;
        let direction = |k: usize, of: usize| path.from_rad + path.sweep_rad * k as f64 / of as f64;
        let directions_rad: Vec<f64> = (0..=count).map(|i| direction(i, count)).collect();
        let places = limits.fine * path.radii.len();
        let line = |k: isize| path.value(k);
        let n = path.radii.len() as isize;
        Self {
            normals: directions_rad.iter().map(|a| DVec2::from_angle(*a)).collect(),
            directions_rad,
            arms: (0..=places).map(|k| DVec2::from_angle(direction(k, places))).collect(),
            weights: (0..2 * limits.fine).map(|k| weights(2 * limits.fine, k)).collect(),
            nominal_px: path.nominal_px,
            before: [line(-2), line(-1)],
            behind: [line(n), line(n + 1)],
        }
    }

    /// Number of directions.
    pub(super) fn count(&self) -> usize {
        self.directions_rad.len()
    }

    /// A direction, rad.
    pub(super) fn direction_rad(&self, i: usize) -> f64 {
        self.directions_rad[i]
    }

    /// Places of the contour about the centre; at both ends the edges begin, at the nominal radius,
    /// whatever wear has taken of the nose beside them.
    fn places(&self, departures: &DVector<f64>) -> Vec<DVec2> {
        let own = departures.iter().map(|d| self.nominal_px + d);
        let radii: Vec<f64> = self.before.into_iter().chain(own).chain(self.behind).collect();
        let (halves, last) = (self.weights.len(), self.arms.len() - 1);
        let place = |(k, arm): (usize, &DVec2)| {
            // sectors' middles stand half a sector behind their beginnings
            let at = 2 * k + halves / 2;
            let (sector, part) = (at / halves, at % halves);
            let about = &radii[sector..sector + 4];
            let radius = about.iter().zip(self.weights[part]).map(|(r, w)| r * w).sum::<f64>();
            let radius = if k == 0 || k == last { radius.max(self.nominal_px) } else { radius };
            *arm * radius
        };
        self.arms.iter().enumerate().map(place).collect()
    }

    /// Numbers of the places on the hull.
    fn corners(places: &[DVec2]) -> Vec<usize> {
        let mut corners: Vec<usize> = Vec::with_capacity(places.len());
        for (k, place) in places.iter().enumerate() {
            while let [.., a, b] = corners[..]
                && (places[b] - places[a]).perp_dot(*place - places[b]) <= 0.0
            {
                corners.pop();
            }
            corners.push(k);
        }
        corners
    }

    /// In every direction the place that is farthest, and how far it is.
    fn farthest(&self, departures: &DVector<f64>) -> impl Iterator<Item = (usize, f64)> {
        let places = self.places(departures);
        let corners = Self::corners(&places);
        let mut at = 0;
        self.normals.iter().map(move |n| {
            let reach = |at: usize| places[corners[at]].dot(*n);
            while at + 1 < corners.len() && reach(at + 1) >= reach(at) {
                at += 1;
            }
            (corners[at], reach(at))
        })
    }

    /// h about the centre in every direction: the farthest of the contour's places, px.
    pub(super) fn values(&self, departures: &DVector<f64>) -> DVector<f64> {
        DVector::from_iterator(self.count(), self.farthest(departures).map(|(_, reach)| reach))
    }

    /// The sector of the farthest place in every direction.
    pub(super) fn touching(&self, departures: &DVector<f64>) -> Vec<usize> {
        let (fine, last) = (self.weights.len() / 2, departures.len() - 1);
        self.farthest(departures).map(|(k, _)| (k / fine).min(last)).collect()
    }
}

/// What four radii in a row make of the one at part k of `parts` between the second and the third:
/// the cubic of [`Path::radius`].
fn weights(parts: usize, k: usize) -> [f64; 4] {
    let t = k as f64 / parts as f64;
    let (square, cube) = (t * t, t * t * t);
    [
        0.5 * (2.0 * square - cube - t),
        1.0 - 2.5 * square + 1.5 * cube,
        0.5 * (t + 4.0 * square - 3.0 * cube),
        0.5 * (cube - square),
    ]
}

#[cfg(test)]
mod tests {
    use super::super::line::EdgeLine;
    use super::*;

    fn path() -> Path {
        let line = |deg: f64| {
            let normal = DVec2::from_angle(f64::to_radians(deg));
            EdgeLine::coarse(normal, normal * 80.0)
        };
        Path::nominal([line(177.0), line(297.0)], 80.0)
    }

    #[test]
    fn a_hull_reaches_as_far_as_the_farthest_of_its_places() {
        let path = path();
        let hull = Hull::new(&path);
        for seed in 0..40 {
            // waves, noise and a recess
            let departure = |k: usize| {
                let noise = ((k * 7 + seed * 13) as f64 * 0.618_034).fract() - 0.5;
                let dent = if (30..50).contains(&k) { -0.2 * seed as f64 } else { 0.0 };
                0.3 * noise + dent + 0.05 * seed as f64 * (0.2 * k as f64).sin()
            };
            let departures = DVector::from_iterator(120, (0..120).map(departure));
            let radii = departures.iter().map(|d| path.nominal_px + d).collect();
            let shape = Path { radii, ..path.clone() };
            let (found, touching) = (hull.values(&departures), hull.touching(&departures));
            let places = hull.places(&departures);
            for (k, place) in places.iter().enumerate().skip(1).take(places.len() - 2) {
                let turn = path.sweep_rad * k as f64 / (places.len() - 1) as f64;
                assert!((place.length() - shape.radius(turn).0).abs() < 1e-9, "{k}: {place}");
            }
            for (i, touch) in touching.into_iter().enumerate() {
                let n = DVec2::from_angle(hull.direction_rad(i));
                let most = places.iter().map(|p| p.dot(n)).fold(f64::NEG_INFINITY, f64::max);
                assert!((found[i] - most).abs() < 1e-9, "{i}: {} {most}", found[i]);
                let own = &places[8 * touch..(8 * touch + 9).min(places.len())];
                assert!(own.iter().any(|p| (p.dot(n) - most).abs() < 1e-9), "{i}: sector {touch}");
            }
        }
    }
}
