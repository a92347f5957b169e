//! The path of the programmed point along a stepped contour: the contour offset by the nose.
//!
//! The nose of radius r touches a line with the normal n (Z, radius; away from the part) where its
//! centre lies r·n away from it. Between two lines the centre turns about the point
//!
//! ```text
//! C = V + r (n₁ + n₂)/(1 + n₁·n₂)      V the corner of both lines
//! ```
//!
//! where their parallels meet, outside a corner as inside one. The programmed point, the leading
//! side and the lowest point of the nose, is P = C − r (±1, 1). On cylinders and shoulders P lies
//! on the contour; on a taper of the angle α it lies r (sin α + cos α − 1) inside of it, which a
//! program without this offset leaves uncut (r = 0.8 mm and 2.9°: 0.08 mm of diameter). The offset
//! is in the path: no G41 or G42, which controls take up differently.

use super::error::NcError;
use super::settings::NcSettings;
use crate::plan::{Contour, FeedDirection, PassPlan, Side, value_at};
use crate::setting::SettingError;

/// Points closer than this are one, mm.
const SAME_MM: f64 = 1e-7;

/// A point of the contour or of the path: (Z, radius), mm.
type Place = (f64, f64);

/// The surface that a pass commands, (Z, radius), Z ascending; two points at one Z are a shoulder.
pub(super) fn commanded_surface(plan: &PassPlan, contour: &Contour) -> Vec<Place> {
    let offsets = contour.offset_knots(&plan.station_z_mm, &plan.offset.o_mm);
    let own = contour.knots.iter().map(|k| k.z_mm);
    let mut z_mm: Vec<f64> = own.chain(offsets.iter().map(|o| o.0)).collect();
    z_mm.sort_by(f64::total_cmp);
    z_mm.dedup_by(|a, b| (*a - *b).abs() < SAME_MM);
    let at = |z: f64, side: Side| {
        let diameter = plan.nominal_mm + contour.relative_mm(z, side) - value_at(&offsets, z, side, |o| *o);
        (z, 0.5 * diameter)
    };
    let mut surface: Vec<Place> =
        z_mm.iter().flat_map(|z| [at(*z, Side::Chuck), at(*z, Side::Tailstock)]).collect();
    surface.dedup_by(|a, b| distance(*a, *b) < SAME_MM);
    surface
}

/// The path (Z, X) along the contour of a plan, Z ascending, X a diameter, not rounded.
///
/// # Errors
/// A nose radius that is not stated, or that does not fit into a fillet or a groove.
pub(super) fn path(plan: &PassPlan, contour: &Contour, settings: &NcSettings) -> Result<Vec<Place>, NcError> {
    let nose_mm = nose(settings)?;
    let surface = commanded_surface(plan, contour);
    let lead = lead(contour);
    let centres = offset(&surface, nose_mm)?;
    Ok(centres.into_iter().map(|(z, r)| (z - lead * nose_mm, 2.0 * (r - nose_mm))).collect())
}

/// Z of the programmed point where the nose touches a cylinder at `z_mm`.
pub(super) fn programmed_z(contour: &Contour, settings: &NcSettings, z_mm: f64) -> Result<f64, NcError> {
    Ok(z_mm - lead(contour) * nose(settings)?)
}

/// The nose radius, which a contour needs.
pub(super) fn nose(settings: &NcSettings) -> Result<f64, NcError> {
    settings.nose_radius_mm.ok_or_else(|| {
        let why = "is not stated: along tapers and fillets the path lies beside the contour by what the nose radius makes it";
        NcError::Setting(SettingError::at("nc.nose_radius_mm", why))
    })
}

/// 1 where the programmed side of the nose is the one towards the chuck, otherwise −1.
pub(super) fn lead(contour: &Contour) -> f64 {
    match contour.direction {
        FeedDirection::TowardsChuck => 1.0,
        FeedDirection::TowardsTailstock => -1.0,
    }
}

fn distance(a: Place, b: Place) -> f64 {
    (a.0 - b.0).hypot(a.1 - b.1)
}

/// The parallel of a surface at the distance `r`, outside.
fn offset(surface: &[Place], r: f64) -> Result<Vec<Place>, NcError> {
    let normals: Vec<Place> = surface
        .windows(2)
        .map(|p| {
            let length = distance(p[0], p[1]);
            ((p[0].1 - p[1].1) / length, (p[1].0 - p[0].0) / length)
        })
        .collect();
    let centre = |i: usize| {
        let before = normals[i.saturating_sub(1)];
        let behind = normals[i.min(normals.len() - 1)];
        let share = r / (1.0 + before.0 * behind.0 + before.1 * behind.1);
        (surface[i].0 + share * (before.0 + behind.0), surface[i].1 + share * (before.1 + behind.1))
    };
    let centres: Vec<Place> = (0..surface.len()).map(centre).collect();
    for (i, pair) in centres.windows(2).enumerate() {
        let (a, b) = (surface[i], surface[i + 1]);
        let along = (pair[1].0 - pair[0].0) * (b.0 - a.0) + (pair[1].1 - pair[0].1) * (b.1 - a.1);
        if along < -SAME_MM * distance(a, b) {
            return Err(NcError::Plan(format!(
                "at Z {:.3} mm a nose radius of {r} mm (nc.nose_radius_mm) does not fit: a fillet there is smaller, or a step \
                 lower or a groove narrower; a smaller nose, or a larger fillet",
                a.0
            )));
        }
    }
    Ok(centres)
}

/// The part of a path between two Z, with a point at both, level beyond its ends.
pub(super) fn between(path: &[Place], (low, high): (f64, f64)) -> Vec<Place> {
    let mut cut = vec![(low, value_at(path, low, Side::Tailstock, |p| *p))];
    cut.extend(path.iter().copied().filter(|p| p.0 > low && p.0 < high));
    cut.push((high, value_at(path, high, Side::Chuck, |p| *p)));
    cut
}

#[cfg(test)]
mod tests {
    use super::*;

    const R: f64 = 0.8;

    /// Distance of a point from a polyline, by the closest point of every line.
    fn distance_to(line: &[Place], p: Place) -> f64 {
        let to = |a: Place, b: Place| {
            let (dz, dr) = (b.0 - a.0, b.1 - a.1);
            let square = dz * dz + dr * dr;
            let t = if square > 0.0 { ((p.0 - a.0) * dz + (p.1 - a.1) * dr) / square } else { 0.0 };
            let t = t.clamp(0.0, 1.0);
            distance(p, (a.0 + t * dz, a.1 + t * dr))
        };
        line.windows(2).map(|w| to(w[0], w[1])).fold(f64::INFINITY, f64::min)
    }

    /// The centre keeps the distance of the radius from every line of a surface with a shoulder, a
    /// taper and a fillet; at an outer corner it passes farther out.
    #[test]
    fn the_centre_of_the_nose_keeps_its_radius_from_the_surface() {
        let fillet = (0..=40).map(|i| {
            let t = std::f64::consts::FRAC_PI_2 * f64::from(i) / 40.0;
            (20.0 + 1.2 - 1.2 * t.cos(), 10.0 + 1.2 - 1.2 * t.sin())
        });
        let mut surface = vec![(0.0, 15.0), (20.0, 15.0)];
        surface.extend(fillet);
        surface.extend([(40.0, 10.0), (60.0, 9.0), (80.0, 9.0)]);
        let centres = offset(&surface, R).unwrap();
        for pair in centres.windows(2) {
            for k in 0..=10 {
                let t = f64::from(k) / 10.0;
                let at = (pair[0].0 + t * (pair[1].0 - pair[0].0), pair[0].1 + t * (pair[1].1 - pair[0].1));
                let d = distance_to(&surface, at);
                assert!(d > R - 1e-3, "{at:?}: {d}");
            }
        }
        // On the taper of 1:20 (radius): P lies r(sin α + cos α − 1) below the line.
        let alpha = (1.0_f64 / 20.0).atan();
        let taper = centres.iter().find(|c| c.0 > 59.0 && c.0 < 61.0).unwrap();
        let line = 9.0 + (60.0 - (taper.0 - R)) * alpha.tan();
        let below = (line - (taper.1 - R)) * alpha.cos();
        assert!((below - R * (alpha.sin() + alpha.cos() - 1.0)).abs() < 1e-12, "{below}");
    }

    #[test]
    fn a_fillet_smaller_than_the_nose_is_refused() {
        let fillet = (0..=10).map(|i| {
            let t = std::f64::consts::FRAC_PI_2 * f64::from(i) / 10.0;
            (20.4 - 0.4 * t.cos(), 10.4 - 0.4 * t.sin())
        });
        let mut surface = vec![(0.0, 15.0), (20.0, 15.0)];
        surface.extend(fillet);
        surface.push((40.0, 10.0));
        let refused = offset(&surface, R).unwrap_err().to_string();
        assert!(refused.contains("does not fit") && refused.contains("nose_radius"), "{refused}");
    }
}
