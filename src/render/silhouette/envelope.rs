//! Outlines that do not project slice by slice: tilted towards the camera, or imaged by a lens that
//! is not exactly telecentric, or entocentric.
//!
//! A point (x, y, z) of the body, y towards the camera, is rotated by τ about the middle of the
//! field and projected from a pinhole at ℓ (infinite for a telecentric lens, negative for a
//! hypercentric one):
//!
//! ```text
//! z' = z0 + (z - z0) cos τ + y sin τ,   y' = y cos τ - (z - z0) sin τ,   m = ℓ/(ℓ - y')
//! image:  z0 + m (z' - z0),  m x
//! ```
//!
//! The silhouette at z is the largest m·x over all depths y; for each depth the slice on the ray of
//! z is solved for. The maximum is found on a grid over y, refined twice, and by a golden-section
//! search; both rims of a shoulder crossed by the rays are evaluated separately. A residual
//! chief-ray angle ε at the height h is a pinhole at ℓ = h/tan ε.

use glam::DVec2;

use super::slice::Slice;
use super::turned::{BESIDE_MM, EdgePair, Turned};

/// Depths of the first grid, and of the second one about its best.
const GRID: usize = 24;
const FINE: usize = 16;

/// Steps of the golden section: 1e-7 of its bracket, 1e-14 of the height.
const GOLDEN: usize = 34;

/// Steps that find the slice of a ray and the boundary of a slice.
const STEPS: usize = 4;

/// Bisection steps for the depth at which a ray passes a shoulder.
const HALVINGS: usize = 50;

/// The view of the shaft.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct View {
    /// Middle of the field, mm: the optical axis.
    pub middle_z_mm: f64,
    /// 1/ℓ, one over the distance from the axis' plane to the pinhole, 1/mm; 0 for a telecentric
    /// lens.
    pub per_distance: f64,
}

impl View {
    /// Whether every slice projects independently.
    pub(crate) fn is_straight(&self, tilt_to_camera_mrad: f64) -> bool {
        self.per_distance == 0.0 && tilt_to_camera_mrad == 0.0
    }
}

impl Turned<'_> {
    /// Both edges over image z (in the plane of the axis), mm above the optical axis.
    pub(crate) fn edges_seen(&self, z_mm: f64, view: &View) -> EdgePair {
        let tilt = self.outline.shaft.pose.tilt_to_camera_mrad;
        if view.is_straight(tilt) {
            return self.edges(z_mm);
        }
        EdgePair { top_mm: self.edge_seen(z_mm, view, true), bottom_mm: self.edge_seen(z_mm, view, false) }
    }

    /// One edge over image z, mm above the optical axis.
    pub(crate) fn edge_seen(&self, z_mm: f64, view: &View, top: bool) -> f64 {
        let tilt = self.outline.shaft.pose.tilt_to_camera_mrad;
        if view.is_straight(tilt) {
            return self.edge(z_mm, top);
        }
        let ray = Ray { turned: self, view, z_mm, sin_cos: (tilt * 1e-3).sin_cos() };
        if top { ray.outermost(1.0) } else { -ray.outermost(-1.0) }
    }

    /// Distance from the focal plane of the axis seen at image z, mm towards the camera.
    pub(crate) fn axis_depth_mm(&self, z_mm: f64, view: &View) -> f64 {
        let tilt = self.outline.shaft.pose.tilt_to_camera_mrad * 1e-3;
        self.axis_y_mm(z_mm) - (z_mm - view.middle_z_mm) * tilt.sin()
    }

    /// Height over the axis of rotation of the slice's boundary at depth `y`, times `side` (1
    /// upper, -1 lower).
    fn boundary(&self, s_mm: f64, y_mm: f64, side: f64) -> f64 {
        let outline = self.outline;
        let axis = self.axis(s_mm);
        let depth = y_mm - axis.y;
        let phi = self.sin.atan2(self.cos);
        let mut radius = outline.mean_radius_mm(s_mm);
        for _ in 0..STEPS {
            let sine = (depth / radius).clamp(-1.0, 1.0);
            let machine = if side > 0.0 { sine.asin() } else { std::f64::consts::PI - sine.asin() };
            radius = outline.uncut_radius_mm(s_mm, machine - phi);
        }
        if depth.abs() >= radius {
            return f64::NEG_INFINITY;
        }
        let x = (radius * radius - depth * depth).sqrt() * self.secant(s_mm);
        let features = &outline.shaft.features;
        if features.flats.is_empty() && features.keyways.is_empty() {
            return x + side * axis.x;
        }
        // The lower side is the upper one of the mirrored slice.
        let slice = Slice::at(outline, s_mm);
        let cut = if side > 0.0 {
            slice.cut_along_x(DVec2::new(x, depth), phi)
        } else {
            // Rotated by half a turn, the lower boundary is the upper one with reversed depths.
            slice.cut_along_x(DVec2::new(x, -depth), phi + std::f64::consts::PI)
        };
        cut + side * axis.x
    }
}

/// The plane of rays that end at one z of the image.
struct Ray<'a> {
    turned: &'a Turned<'a>,
    view: &'a View,
    z_mm: f64,
    sin_cos: (f64, f64),
}

impl Ray<'_> {
    /// Largest height times `side` over all depths.
    fn outermost(&self, side: f64) -> f64 {
        let outline = self.turned.outline;
        let axis = self.turned.axis(self.z_mm).y;
        let reach = outline.mean_radii_mm().1 + outline.high_mm.max(0.0);
        let (low, high) = (axis - reach, axis + reach);
        let height = |y: f64| self.height(y, side, None);
        let (at, _) = best_of_grid(&height, low, high, GRID);
        let step = (high - low) / GRID as f64;
        let (low_2, high_2) = ((at - step).max(low), (at + step).min(high));
        let (at, value) = best_of_grid(&height, low_2, high_2, FINE);
        let step = (high_2 - low_2) / FINE as f64;
        let mut best = value.max(golden(&height, (at - step).max(low), (at + step).min(high)));
        for rim in self.rims(low, high, side) {
            best = best.max(rim);
        }
        best
    }

    /// Height times `side` of the body at depth `y` along the plane of rays; `slice` replaces the
    /// slice on the ray.
    fn height(&self, y: f64, side: f64, slice: Option<f64>) -> f64 {
        let (s, x, scale) = self.slice(y, side, slice);
        let outline = self.turned.outline;
        let up = outline.shaft.pose.x_mm + s * outline.sin_tilt;
        scale * (x * outline.cos_tilt + side * up)
    }

    /// The slice on the rays at depth `y`, its height times `side`, and the magnification there.
    fn slice(&self, y: f64, side: f64, given: Option<f64>) -> (f64, f64, f64) {
        let (sin, cos) = self.sin_cos;
        let outline = self.turned.outline;
        let middle = self.view.middle_z_mm;
        let (mut z, mut s, mut x, mut scale) = (self.z_mm, self.z_mm, 0.0, 1.0);
        for _ in 0..STEPS {
            let near = y * cos - (z - middle) * sin;
            scale = 1.0 / (1.0 - near * self.view.per_distance);
            let turned = middle + (self.z_mm - middle) / scale;
            z = middle + (turned - middle - y * sin) / cos;
            s = given.unwrap_or((z + side * x * outline.sin_tilt) / outline.cos_tilt);
            if outline.sin_tilt != 0.0 {
                x = self.turned.boundary(s, y, side);
            }
        }
        if outline.sin_tilt == 0.0 {
            x = self.turned.boundary(s, y, side);
        }
        (s, x, scale)
    }

    /// Heights times `side` of both rims of every shoulder that the rays pass.
    fn rims(&self, low: f64, high: f64, side: f64) -> Vec<f64> {
        let place = |y: f64| self.slice(y, side, None).0;
        let (a, b) = (place(low), place(high));
        let outline = self.turned.outline;
        let first = outline.shoulders_mm.partition_point(|s| *s < a.min(b));
        let passed = outline.shoulders_mm[first..].iter().take_while(|s| **s <= a.max(b));
        let mut rims = Vec::new();
        for &s in passed {
            let (mut near, mut far) = (low, high);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (near + far);
                if (place(middle) < s) == (a < s) { near = middle } else { far = middle }
            }
            let y = 0.5 * (near + far);
            rims.extend([-BESIDE_MM, BESIDE_MM].map(|d| self.height(y, side, Some(s + d))));
        }
        rims
    }
}

fn best_of_grid(f: &impl Fn(f64) -> f64, low: f64, high: f64, steps: usize) -> (f64, f64) {
    let at = |i: usize| low + (high - low) * i as f64 / steps as f64;
    (0..=steps)
        .map(|i| (at(i), f(at(i))))
        .fold((low, f64::NEG_INFINITY), |a, b| if b.1 > a.1 { b } else { a })
}

fn golden(f: &impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    let share = 0.5 * (5f64.sqrt() - 1.0);
    let (mut c, mut d) = (b - share * (b - a), a + share * (b - a));
    let (mut fc, mut fd) = (f(c), f(d));
    for _ in 0..GOLDEN {
        if fc > fd {
            (b, d, fd) = (d, c, fc);
            c = b - share * (b - a);
            fc = f(c);
        } else {
            (a, c, fc) = (c, d, fd);
            d = a + share * (b - a);
            fd = f(d);
        }
    }
    fc.max(fd)
}
