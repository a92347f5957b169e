//! How far the edges of a part stand from where the masters' calibration places them, by cause.
//!
//! ```text
//! δ_D(D) = δ_m(D) - line through the masters' δ_m      nine diameters, a cubic in D^⅓ through them
//! δ_material = δ_p - δ_m,  δ_film = t + δ_p(t) - δ_p   at the part's diameter
//! δ_texture = 1.4·.489 Rq² √(2k/L)                     of the part less that of the masters
//! ```
//!
//! The masters' line is that of equal weights: two masters lie on it.

use nalgebra::{Matrix4, Vector4};
use serde::Serialize;

use super::shift::LimbHead;
use crate::gauge::calibration::{Finish, KnownMaterial, LimbDifference, texture_shift_um};
use crate::render::optics::edge_spread::CylinderEdge;
use crate::render::optics::edge_spread::cylinder::Material;
use crate::studies::head::error::HeadError;

/// Diameters through which the cubic is fitted.
const NODES: usize = 9;
/// Least ratio of the largest to the smallest of them: a cubic needs a span.
const LEAST_SPAN: f64 = 1.05;
/// Half of the distance over which the slope by depth is taken, mm: what parts are held to.
const DEPTH_STEP_MM: f64 = 0.2;
/// Steps of a film's thickness, µm: an eighth of the period λ/2√(n² - 1) of oil in green light.
const FILM_STEP_UM: f64 = 0.03;
/// Most thicknesses looked at.
const MOST_FILMS: usize = 65;
/// Share of the shift by a stated roughness that is not known: its correlation length is known to
/// a factor of four at best, and the shift goes by its inverse root.
const TEXTURE_SHARE: f64 = 0.5;

/// Texture around a part.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Texture {
    /// A finish: anything from smooth to its roughest.
    Finish(Finish),
    /// Rq around the part, µm.
    Roughness(f64),
}

/// What is known of the surfaces of masters and part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Surfaces {
    /// Diameters of the masters, mm.
    pub masters_mm: Vec<f64>,
    /// Material of the masters.
    pub masters_material: Material,
    /// Material of the part; none where it is not known.
    pub part_material: Option<Material>,
    /// Finish of the masters.
    pub masters_finish: Finish,
    /// Whether the masters were certified by contact, on their peaks.
    pub certified_by_contact: bool,
    /// Texture of the part.
    pub part_texture: Texture,
    /// Thickness of a film on the part and its limits, µm.
    pub film_um: (f64, f64),
    /// Smallest and largest diameter of the part, mm.
    pub range_mm: (f64, f64),
    /// Distance of the masters' axes from the plane of focus, mm.
    pub masters_y_mm: f64,
}

/// The table, and what it was made from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Comparison {
    /// What it was asked for.
    pub surfaces: Surfaces,
    /// Diameters, mm, and shifts of masters of that size, µm an edge.
    pub masters: Vec<(f64, f64)>,
    /// The same of other diameters, before the masters' line is taken off.
    pub diameters: Vec<(f64, f64)>,
    /// Largest difference between the cubic and the shifts it was fitted to, µm.
    pub largest_residual_um: f64,
    /// The table.
    pub limb: LimbDifference,
}

/// Compares them.
///
/// # Errors
/// Limbs that cannot be computed or fitted.
pub(crate) fn compare(head: &LimbHead, surfaces: &Surfaces) -> Result<Comparison, HeadError> {
    let master = CylinderEdge { material: surfaces.masters_material, ..bare(&head.lens) };
    let shift = |mm: f64| Ok((mm, head.shift_um(&master, mm, surfaces.masters_y_mm)?));
    let masters = surfaces.masters_mm.iter().map(|mm| shift(*mm)).collect::<Result<Vec<_>, HeadError>>()?;
    let range_mm = spanned(surfaces.range_mm);
    let diameters = nodes(range_mm).into_iter().map(shift).collect::<Result<Vec<_>, HeadError>>()?;
    let line = Line::through(&masters);
    let left: Vec<(f64, f64)> = diameters.iter().map(|(mm, um)| (*mm, um - line.at(*mm))).collect();
    let by_diameter_um = cubic(&left);
    let mut limb = LimbDifference {
        from_mm: range_mm.0,
        to_mm: range_mm.1,
        by_diameter_um,
        ..by_surface(head, surfaces, &master)?
    };
    (limb.by_depth_um_per_mm, limb.by_depth_um_per_mm2) = by_depth(head, &master, surfaces.masters_y_mm)?;
    let residuals = left.iter().map(|(mm, um)| (um - limb.by_diameter_um(*mm)).abs());
    let largest_residual_um = residuals.fold(0.0, f64::max);
    Ok(Comparison { surfaces: surfaces.clone(), masters, diameters, largest_residual_um, limb })
}

/// A lens before a dry, smooth surface of its material.
fn bare(lens: &CylinderEdge) -> CylinderEdge {
    CylinderEdge { refractive_index: None, extinction: None, film_um: 0.0, roughness_um: 0.0, ..lens.clone() }
}

/// A range wide enough for a cubic.
fn spanned((low, high): (f64, f64)) -> (f64, f64) {
    if high >= LEAST_SPAN * low {
        return (low, high);
    }
    let middle = (low * high).sqrt();
    (middle / LEAST_SPAN.sqrt(), middle * LEAST_SPAN.sqrt())
}

/// Diameters even in their cube root.
fn nodes((low, high): (f64, f64)) -> [f64; NODES] {
    let step = (high.cbrt() - low.cbrt()) / (NODES - 1) as f64;
    std::array::from_fn(|k| (low.cbrt() + step * k as f64).powi(3).clamp(low, high))
}

/// Change of the shift by depth, µm/mm, and by its square, µm/mm².
fn by_depth(head: &LimbHead, limb: &CylinderEdge, y_mm: f64) -> Result<(f64, f64), HeadError> {
    let at = |y_mm| head.shift_um(limb, head.diameter_mm, y_mm);
    let (near, here, far) = (at(y_mm + DEPTH_STEP_MM)?, at(y_mm)?, at(y_mm - DEPTH_STEP_MM)?);
    let square = (near + far - 2.0 * here) / (2.0 * DEPTH_STEP_MM * DEPTH_STEP_MM);
    Ok(((near - far) / (2.0 * DEPTH_STEP_MM), square))
}

/// The rows of material, film, texture and peaks.
fn by_surface(
    head: &LimbHead,
    surfaces: &Surfaces,
    master: &CylinderEdge,
) -> Result<LimbDifference, HeadError> {
    let shift = |limb: &CylinderEdge| head.shift_um(limb, head.diameter_mm, surfaces.masters_y_mm);
    let dry_um = shift(master)?;
    let of_part = |material| CylinderEdge { material, ..master.clone() };
    let (material, by_material_um) = match surfaces.part_material {
        None => (KnownMaterial::Unknown, 0.0),
        Some(same) if same == surfaces.masters_material => (KnownMaterial::LikeMasters, 0.0),
        Some(other) => (KnownMaterial::Named, shift(&of_part(other))? - dry_um),
    };
    let part = of_part(surfaces.part_material.unwrap_or(surfaces.masters_material));
    let (by_film_um, limit_film_um) = film(surfaces.film_um, &part, shift)?;
    let (by_texture_um, limit_texture_um) = texture(surfaces, 1e-3 * head.lens.wavelength_nm);
    let peaks = if surfaces.certified_by_contact { 0.5 * surfaces.masters_finish.peaks_um() } else { 0.0 };
    Ok(LimbDifference {
        from_mm: 0.0,
        to_mm: 0.0,
        by_diameter_um: [0.0; 4],
        material,
        by_material_um,
        by_film_um,
        limit_film_um,
        by_texture_um,
        limit_texture_um,
        by_depth_um_per_mm: 0.0,
        by_depth_um_per_mm2: 0.0,
        by_peaks_um: peaks,
        limit_peaks_um: peaks,
    })
}

/// Mean of what films evenly distributed between the limits of a thickness move an edge by, their
/// thickness included, and the half width of the rectangle that is as wide (√3 standard
/// deviations; JCGM 101, 5.2). The shift is the thickness and a swing of a tenth of a micrometre
/// about it: from its least to its most is wider than it is distributed.
fn film(
    (thickness_um, limit_um): (f64, f64),
    part: &CylinderEdge,
    shift: impl Fn(&CylinderEdge) -> Result<f64, HeadError>,
) -> Result<(f64, f64), HeadError> {
    let (low, high) = ((thickness_um - limit_um).max(0.0), thickness_um + limit_um);
    if high == 0.0 {
        return Ok((0.0, 0.0));
    }
    let dry_um = shift(part)?;
    let steps = (((high - low) / FILM_STEP_UM).ceil() as usize).clamp(1, MOST_FILMS);
    let moved = (0..steps).map(|k| {
        // Middles of equal steps: each holds as many thicknesses.
        let film_um = low + (high - low) * (k as f64 + 0.5) / steps as f64;
        Ok(film_um + shift(&CylinderEdge { film_um, ..part.clone() })? - dry_um)
    });
    Ok(rectangle_of(&moved.collect::<Result<Vec<f64>, HeadError>>()?, (high - low) / steps as f64))
}

/// Mean and half width of the rectangle of equal variance; `step` is the distance of the values'
/// causes, which adds its own rectangle's variance where they move by as much.
fn rectangle_of(values: &[f64], step: f64) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n + step * step / 12.0;
    (mean, (3.0 * variance).sqrt())
}

/// Middle and half range of the part's texture less the masters'.
fn texture(surfaces: &Surfaces, wavelength_um: f64) -> (f64, f64) {
    let half_master = 0.5 * surfaces.masters_finish.shift_in_um(wavelength_um);
    let (middle, half) = match surfaces.part_texture {
        Texture::Finish(finish) => {
            let half = 0.5 * finish.shift_in_um(wavelength_um);
            (half, half)
        }
        Texture::Roughness(rq_um) => {
            let whole = texture_shift_um(rq_um, CylinderEdge::default().correlation_um, wavelength_um);
            (whole, TEXTURE_SHARE * whole)
        }
    };
    (middle - half_master, half + half_master)
}

/// Least squares with equal weights.
struct Line {
    middle_mm: f64,
    value_um: f64,
    slope: f64,
}

impl Line {
    fn through(points: &[(f64, f64)]) -> Self {
        let n = points.len().max(1) as f64;
        let middle_mm = points.iter().map(|p| p.0).sum::<f64>() / n;
        let value_um = points.iter().map(|p| p.1).sum::<f64>() / n;
        let square: f64 = points.iter().map(|p| (p.0 - middle_mm).powi(2)).sum();
        let product: f64 = points.iter().map(|p| (p.0 - middle_mm) * (p.1 - value_um)).sum();
        let slope = if square > 0.0 { product / square } else { 0.0 };
        Self { middle_mm, value_um, slope }
    }

    fn at(&self, mm: f64) -> f64 {
        self.value_um + self.slope * (mm - self.middle_mm)
    }
}

/// The cubic in D^⅓ through points by least squares; about their middle first, where powers of a
/// narrow range are separated by the arithmetic.
fn cubic(points: &[(f64, f64)]) -> [f64; 4] {
    let roots: Vec<f64> = points.iter().map(|p| p.0.cbrt()).collect();
    let (low, high) = roots.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), x| (l.min(*x), h.max(*x)));
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let (mut normal, mut right) = (Matrix4::zeros(), Vector4::zeros());
    for (x, (_, um)) in roots.iter().zip(points) {
        let u = (x - middle) / half;
        let by = Vector4::new(1.0, u, u * u, u * u * u);
        normal += by * by.transpose();
        right += by * *um;
    }
    let c = normal.try_inverse().map_or(Vector4::zeros(), |inverse| inverse * right);
    let (a, h) = (-middle / half, half.recip());
    // Powers of a + h·x.
    [
        c[0] + a * (c[1] + a * (c[2] + a * c[3])),
        h * (c[1] + a * (2.0 * c[2] + 3.0 * a * c[3])),
        h * h * (c[2] + 3.0 * a * c[3]),
        h * h * h * c[3],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The design's own numbers at S 0.5 (NA 0.02, steel, 4 µm of blur): masters of 18 and 27 mm
    /// leave -0.29 µm of diameter at Ø6 and -0.11 at Ø40.
    #[test]
    fn a_line_through_two_masters_leaves_what_the_table_of_limbs_says() {
        let line = Line::through(&[(18.0, 1.4424), (27.0, 1.5339)]);
        for (mm, um, left) in [(6.0, 1.1744, -0.29), (10.0, 1.2999, -0.12), (40.0, 1.6119, -0.11)] {
            assert!((2.0 * (um - line.at(mm)) - left).abs() < 0.012, "{mm}");
        }
    }

    /// Thicknesses that move the edge by themselves alone have the rectangle they were stated by,
    /// in any number of steps; a swing about them adds its variance, a²/2.
    #[test]
    fn a_film_row_is_as_wide_as_its_thicknesses_are_distributed() {
        let part = bare(&CylinderEdge::default());
        let found = film((0.5, 0.5), &part, |_| Ok(0.0)).unwrap();
        assert!((found.0 - 0.5).abs() < 1e-12 && (found.1 - 0.5).abs() < 1e-12, "{found:?}");
        assert_eq!(film((0.0, 0.0), &part, |_| Ok(0.3)).unwrap(), (0.0, 0.0));
        let one = film((0.3, 0.0), &part, |limb| Ok(limb.film_um)).unwrap();
        assert!((one.0 - 0.6).abs() < 1e-12 && one.1 < 1e-12, "{one:?}");
        // Four whole periods of a cosine: no mean of their own, uncorrelated with the thickness.
        let swing = |limb: &CylinderEdge| Ok(0.1 * (8.0 * std::f64::consts::PI * limb.film_um).cos());
        let dry = 0.1;
        let (mean, half) = film((0.5, 0.5), &part, swing).unwrap();
        let wanted = (0.25_f64 + 3.0 * 0.1_f64.powi(2) / 2.0).sqrt();
        assert!((mean + dry - 0.5).abs() < 1e-3 && (half - wanted).abs() < 2e-3, "{mean} {half} {wanted}");
    }

    #[test]
    fn the_cubic_is_the_one_its_points_lie_on() {
        let wanted = [0.3, -1.1, 0.7, -0.09];
        let at = |mm: f64| {
            let x = mm.cbrt();
            wanted[0] + x * (wanted[1] + x * (wanted[2] + x * wanted[3]))
        };
        for range in [(2.0, 40.0), (18.0, 20.0)] {
            let points: Vec<(f64, f64)> = nodes(range).iter().map(|mm| (*mm, at(*mm))).collect();
            let found = cubic(&points);
            for (mm, um) in &points {
                let x = mm.cbrt();
                let value = found[0] + x * (found[1] + x * (found[2] + x * found[3]));
                assert!((value - um).abs() < 1e-9, "{mm}: {value} {um}");
            }
        }
        assert!(spanned((18.0, 18.0)).1 / spanned((18.0, 18.0)).0 > 1.049);
    }
}
