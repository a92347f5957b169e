//! Shades of discs, lines and polygons out of focus: each convolved with the uniform disc of
//! confusion.
//!
//! Distances in any common unit. `blur` is the radius b of the disc of confusion.

use std::f64::consts::PI;

/// Share of the disc of confusion about a point `r` from the middle of a disc of `radius` that this
/// disc covers.
///
/// Area common to two circles, divided by πb²: the exact shade of a disc out of focus.
pub(crate) fn disc(r: f64, radius: f64, blur: f64) -> f64 {
    if r >= radius + blur {
        return 0.0;
    }
    if blur == 0.0 {
        return f64::from(u8::from(r < radius));
    }
    if r <= (radius - blur).abs() {
        return (radius / blur).min(1.0).powi(2);
    }
    let segment = |own: f64, other: f64| {
        let chord = (r * r + own * own - other * other) / (2.0 * r);
        let cos = (chord / own).clamp(-1.0, 1.0);
        own * own * (cos.acos() - cos * (1.0 - cos * cos).sqrt())
    };
    (segment(radius, blur) + segment(blur, radius)) / (PI * blur * blur)
}

/// Share of the disc of confusion that lies inside a straight border at the signed distance
/// `inside`.
pub(crate) fn half_plane(inside: f64, blur: f64) -> f64 {
    if blur == 0.0 || inside.abs() >= blur {
        return f64::from(u8::from(inside > 0.0));
    }
    let u = inside / blur;
    0.5 + (u * (1.0 - u * u).sqrt() + u.asin()) / PI
}

/// Shade of a line of `width` whose middle lies `across` away, far from its ends.
pub(crate) fn line(across: f64, width: f64, blur: f64) -> f64 {
    half_plane(across + 0.5 * width, blur) - half_plane(across - 0.5 * width, blur)
}

/// Signed distance into a polygon (positive inside), corners in either order.
pub(crate) fn into_polygon(point: [f64; 2], corners: &[[f64; 2]]) -> f64 {
    let mut nearest = f64::INFINITY;
    let mut inside = false;
    for (i, a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let (edge, to) = ([b[0] - a[0], b[1] - a[1]], [point[0] - a[0], point[1] - a[1]]);
        let length2 = (edge[0] * edge[0] + edge[1] * edge[1]).max(f64::MIN_POSITIVE);
        let t = ((to[0] * edge[0] + to[1] * edge[1]) / length2).clamp(0.0, 1.0);
        nearest = nearest.min((to[0] - t * edge[0]).powi(2) + (to[1] - t * edge[1]).powi(2));
        if (a[1] > point[1]) != (b[1] > point[1])
            && point[0] < a[0] + (point[1] - a[1]) / (b[1] - a[1]) * edge[0]
        {
            inside = !inside;
        }
    }
    nearest.sqrt() * if inside { 1.0 } else { -1.0 }
}

/// Largest distance from the middle of a ball of `radius` and index n at which a parallel ray is
/// deflected by no more than `angle_rad`: 2(asin(h/a) - asin(h/na)) = angle, by bisection (the left
/// side rises).
pub(crate) fn clear_radius_of_ball(radius: f64, index: f64, angle_rad: f64) -> f64 {
    let turned = |h: f64| 2.0 * (h.asin() - (h / index).asin());
    radius * largest(turned, angle_rad)
}

/// The same for a spherical cap on a window, wetted radius `radius` and contact angle φ, flat side
/// towards the light: the cap's radius is a/sin φ, the ray turns by asin(n sin i) - i.
pub(crate) fn clear_radius_of_cap(radius: f64, contact_rad: f64, index: f64, angle_rad: f64) -> f64 {
    let turned = |h: f64| {
        let sin = h * contact_rad.sin();
        if index * sin >= 1.0 { f64::INFINITY } else { (index * sin).asin() - sin.asin() }
    };
    radius * largest(turned, angle_rad)
}

/// Largest h in 0..=1 with f(h) ≤ limit for a rising f with f(0) = 0.
fn largest(f: impl Fn(f64) -> f64, limit: f64) -> f64 {
    if f(1.0) <= limit {
        return 1.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if f(middle) <= limit { low = middle } else { high = middle }
    }
    low
}
