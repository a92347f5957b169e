//! The centre at a radius from both edges, and the radius of a nose whose nominal one is not given.

use glam::DVec2;
use nalgebra::{Matrix2, SymmetricEigen, Vector2};

use super::limits::NoseLimits;
use super::line::product;
use super::path::Path;
use super::result::{NoseSector, Reference};

/// Corner radii of ISO 1832, mm.
const ISO_1832_MM: [f64; 8] = [0.1, 0.2, 0.4, 0.8, 1.2, 1.6, 2.0, 2.4];

/// Covariance of the centre by that of the edges' offsets where they end: N⁻¹·C·N⁻ᵀ.
pub(super) fn covariance(path: &Path) -> Matrix2<f64> {
    let [a, b] = &path.lines;
    let [(ua, sa), (ub, sb)] = [a, b].map(|line| line.u_at(path.centre + line.normal * path.nominal_px));
    let both = product(&sa, &sb);
    let edges = Matrix2::new(ua * ua + product(&sa, &sa), both, both, ub * ub + product(&sb, &sb));
    let normals = Matrix2::new(a.normal.x, a.normal.y, b.normal.x, b.normal.y);
    let Some(inverse) = normals.try_inverse() else { return Matrix2::zeros() };
    inverse * edges * inverse.transpose()
}

/// Standard uncertainty along the axis in which the centre is known least, px.
pub(super) fn u_largest(covariance: &Matrix2<f64>) -> f64 {
    SymmetricEigen::new(*covariance).eigenvalues.max().max(0.0).sqrt()
}

/// Variance of the mean radius by the centre, px²: it moves by −Σn/m·Δ.
pub(super) fn variance_of_mean(path: &Path, covariance: &Matrix2<f64>) -> f64 {
    let m = path.radii.len();
    let mean = (0..m).map(|k| DVec2::from_angle(path.direction_rad(k))).sum::<DVec2>() / m as f64;
    let g = Vector2::new(mean.x, mean.y);
    g.dot(&(covariance * g)).max(0.0)
}

/// A radius with its standard uncertainty, px.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FoundRadius {
    /// Radius, px.
    pub(super) radius_px: f64,
    /// Its standard uncertainty, px; 0 of a nominal one.
    pub(super) u_px: f64,
    /// Where it comes from.
    pub(super) reference: Reference,
}

/// The radius of the circle that touches both edges and fits the nose where it is not worn. A
/// radius larger by δ moves the centre along the bisector and the contour by δ·(1 − cos(a −
/// a_mid)/sin(ε/2)). Sectors inside of it are worn and left out, round by round. Where that leaves
/// too few the nose is worn, and the radius is that of ISO 1832 next to the one found at its ends.
pub(super) fn radius(path: &Path, sectors: &[NoseSector], um_per_px: f64) -> FoundRadius {
    let limits = NoseLimits::get();
    let middle = path.from_rad + 0.5 * path.sweep_rad;
    let lever = |k: usize| 1.0 - (path.direction_rad(k) - middle).cos() / (0.5 * path.sweep_rad).cos();
    let mut on: Vec<usize> = (0..sectors.len()).filter(|k| sectors[*k].fitted).collect();
    let (mut delta, mut u) = (0.0, f64::INFINITY);
    let least = sectors.len() / 5;
    for _ in 0..40 {
        let (mut sum, mut square) = (0.0, 0.0);
        for &k in &on {
            let (g, w) = (lever(k), sectors[k].u_px.powi(-2));
            sum += w * g * (sectors[k].radius_px - path.nominal_px);
            square += w * g * g;
        }
        (delta, u) = (sum / square, square.sqrt().recip());
        let inside = |k: &usize| {
            let residual = sectors[*k].radius_px - path.nominal_px - delta * lever(*k);
            residual < -(limits.on_line_spreads * sectors[*k].u_px).max(limits.on_line_px)
        };
        let kept: Vec<usize> = on.iter().copied().filter(|k| !inside(k)).collect();
        if kept.len() == on.len() || kept.len() < least {
            break;
        }
        on = kept;
    }
    let fitted = path.nominal_px + delta;
    let found = FoundRadius { radius_px: fitted, u_px: u, reference: Reference::Fitted };
    if on.len() as f64 >= limits.new_share * sectors.len() as f64 {
        return found;
    }
    let mm = 1e-3 * fitted * um_per_px;
    let off = |r: &f64| (r / mm).ln().abs();
    match ISO_1832_MM.into_iter().min_by(|a, b| off(a).total_cmp(&off(b))) {
        Some(r) if (r - mm).abs() <= limits.iso_share * r => {
            FoundRadius { radius_px: 1e3 * r / um_per_px, u_px: 0.0, reference: Reference::Iso1832 }
        }
        _ => found,
    }
}

#[cfg(test)]
mod tests {
    use super::super::line::EdgeLine;
    use super::*;

    /// A nose of 405 px of which some sectors, in its middle, lie 5 px inside.
    fn found(worn: usize) -> FoundRadius {
        let edge = |deg: f64| {
            let normal = DVec2::from_angle(f64::to_radians(deg));
            EdgeLine {
                normal,
                at: 405.0 * normal,
                u_offset_px: 0.01,
                u_angle_rad: 1e-4,
                shared_offset: Default::default(),
                shared_angle: Default::default(),
            }
        };
        let path = Path::nominal([edge(40.0), edge(140.0)], 405.0);
        let is_worn = |k: usize| k.abs_diff(50) <= worn / 2;
        let sector = |k: usize| NoseSector {
            direction_deg: path.direction_rad(k).to_degrees(),
            radius_px: if is_worn(k) { 400.0 } else { 405.0 },
            u_px: 0.05,
            fitted: true,
        };
        let sectors: Vec<NoseSector> = (0..path.radii.len()).map(sector).collect();
        radius(&path, &sectors, 2.0)
    }

    /// At 2 µm a px the nose has 0.81 mm. With a chip of 7 % of its arc it is new, and has the
    /// radius found; with a land of 15 % it is worn, and was ground to 0.8 mm.
    #[test]
    fn a_nose_off_its_circle_by_a_tenth_of_the_arc_is_worn() {
        let new = found(7);
        assert_eq!(new.reference, Reference::Fitted);
        assert!((new.radius_px - 405.0).abs() < 0.01, "{new:?}");
        let worn = found(15);
        assert_eq!((worn.reference, worn.radius_px), (Reference::Iso1832, 400.0));
    }
}
