//! Outlines that do not project slice by slice: in perspective, or tilted towards the camera.
//!
//! From a pinhole at the distance ℓ from the axis, a circle of radius R centred at (x0, y0), y
//! towards the camera, is bounded by its two tangents. With L = ℓ - y0, ω = atan(x0/L) and sin β =
//! R/√(x0² + L²) they cross the plane of the axis at
//!
//! ```text
//! x = ℓ·tan(ω ± β);   centred: ± R·ℓ/√(ℓ² - R²)
//! ```
//!
//! so that a cylinder appears larger than it is. Where the radius changes along z, a ray that
//! passes one slice may hit the next: the silhouette is the envelope over z, top(z) = max over
//! slices of the projection of each at z. For a telecentric view tilted by τ towards the camera a
//! point (s, y) of the body appears at s·cos τ + y·sin τ: a shoulder of radius R spreads over ±
//! R·sin τ in z (R = 12.5 mm and 0.1°: ± 22 µm).

#[cfg(test)]
use crate::render::error::{RenderError, within};

/// Golden-section steps on a slice's ellipse or a bracket of slices; reduces the bracket to 1e-10.
#[cfg(test)]
const STEPS: usize = 48;

/// Edges of a circle of radius `radius_mm` centred at (`x_mm`, `y_mm`), viewed from `distance_mm`:
/// heights (upper, lower) at which the tangents cross the plane of the axis, mm.
///
/// # Errors
/// Refuses a camera inside the circle.
#[cfg(test)]
pub(crate) fn edges_mm(
    radius_mm: f64,
    x_mm: f64,
    y_mm: f64,
    distance_mm: f64,
) -> Result<(f64, f64), RenderError> {
    within("shaft.radius_mm", radius_mm, 0.0, 1e5)?;
    within("optics.entocentric.distance_mm", distance_mm, 1e-3, 1e6)?;
    let depth = distance_mm - y_mm;
    let centre = x_mm.hypot(depth);
    if !(depth > 0.0 && centre > radius_mm) {
        return Err(RenderError::setting(
            "optics.entocentric.distance_mm",
            &distance_mm,
            format!("must leave the shaft of radius {radius_mm} mm at y = {y_mm} mm in front of the lens"),
        ));
    }
    let (omega, beta) = ((x_mm / depth).atan(), (radius_mm / centre).asin());
    let edge = |angle: f64| distance_mm * angle.tan();
    Ok((edge(omega + beta), edge(omega - beta)))
}

/// Apparent radius of a centred cylinder, R·ℓ/√(ℓ² - R²), mm.
///
/// # Errors
/// Refuses a camera inside the cylinder.
#[cfg(test)]
pub(crate) fn apparent_radius_mm(radius_mm: f64, distance_mm: f64) -> Result<f64, RenderError> {
    Ok(edges_mm(radius_mm, 0.0, 0.0, distance_mm)?.0)
}

/// Apparent half height at `z_mm` of a body of revolution tilted by `tilt_rad` towards the camera,
/// telecentric.
///
/// `radius(s)` is the body's radius over its own axis, about whose point z = 0 it is tilted (z =
/// s·cos τ + y·sin τ). Maximum over the slices s that can appear at z, of the height √(R² - y²) of
/// the slice's rim at y = (z - s·cos τ)/sin τ. `largest_mm` bounds the radius. Steps in `radius`
/// are allowed; slices are searched on a grid of `slices`, the best bracket is refined.
#[cfg(test)]
pub(crate) fn tilted_half_height_mm(
    radius: impl Fn(f64) -> f64,
    largest_mm: f64,
    z_mm: f64,
    tilt_rad: f64,
    slices: usize,
) -> f64 {
    let (sin, cos) = tilt_rad.sin_cos();
    let middle = z_mm / cos;
    let reach = largest_mm * (sin / cos).abs();
    let height = |s: f64| {
        let r = radius(s);
        let y = if sin == 0.0 { 0.0 } else { (z_mm - s * cos) / sin };
        (r * r - y * y).max(0.0).sqrt()
    };
    if reach == 0.0 {
        return height(middle);
    }
    best(height, middle - reach, middle + reach, slices.max(8))
}

/// Apparent upper edge at the image point `z_mm` (in the plane of the axis) of a centred body of
/// revolution, viewed from a pinhole at `distance_mm` in front of z = 0: the largest height, over
/// all slices s crossed by the ray plane of z, at which the ray is tangent to the slice's rim.
///
/// A rim point (R cos t, R sin t, s) appears magnified by m = ℓ/(ℓ - R sin t) at z = m·s and x =
/// m·R cos t. For every s the t with m·s = z is unique, so the envelope is a maximum over s alone;
/// for a straight cylinder it is [`apparent_radius_mm`].
#[cfg(test)]
pub(crate) fn entocentric_half_height_mm(
    radius: impl Fn(f64) -> f64,
    largest_mm: f64,
    z_mm: f64,
    distance_mm: f64,
    slices: usize,
) -> Result<f64, RenderError> {
    let own = apparent_radius_mm(radius(z_mm), distance_mm)?;
    apparent_radius_mm(largest_mm, distance_mm)?;
    if z_mm.abs() < 1e-9 * distance_mm {
        return Ok(own);
    }
    let height = |s: f64| {
        let (r, m) = (radius(s), z_mm / s);
        let y = distance_mm * (1.0 - 1.0 / m);
        m * (r * r - y * y).max(0.0).sqrt()
    };
    // y in ± R: s = z(1 - y/ℓ).
    let ends = [z_mm * (1.0 - largest_mm / distance_mm), z_mm * (1.0 + largest_mm / distance_mm)];
    Ok(best(height, ends[0].min(ends[1]), ends[0].max(ends[1]), slices.max(8)))
}

/// Maximum of `f` over `low..high`: the best of a grid, then a golden-section search about it.
#[cfg(test)]
fn best(f: impl Fn(f64) -> f64, low: f64, high: f64, slices: usize) -> f64 {
    let step = (high - low) / slices as f64;
    let grid = (0..=slices).map(|i| low + i as f64 * step);
    let start = grid.fold((low, f(low)), |best, s| {
        let value = f(s);
        if value > best.1 { (s, value) } else { best }
    });
    let share = 2.0 / (1.0 + 5f64.sqrt());
    let (mut a, mut b) = ((start.0 - step).max(low), (start.0 + step).min(high));
    for _ in 0..STEPS {
        let (c, d) = (b - share * (b - a), a + share * (b - a));
        if f(c) > f(d) { b = d } else { a = c }
    }
    f(0.5 * (a + b)).max(start.1)
}
