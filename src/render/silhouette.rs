//! Exact silhouette of a turning, bent shaft seen along y by a telecentric lens.
//!
//! A slice at z with radius r(θ) shows the tangent height (support function)
//!
//! ```text
//! h(φ) = max_θ r(θ) cos(θ + φ),   top = c_x + h(φ),   bottom = c_x - h(φ + π)
//! r(θ) = R(z) + Σ a_k cos(k(θ - θ_k)) + texture(z, θ)
//! ```
//!
//! with the maximum taken exactly (r(-φ) alone errs by k²a²/2R, 65 nm at k = 15, a = 10 µm). The texture is linear in θ
//! between its nodes, so the circle falls into segments on which r(θ)cos(θ + φ) is smooth and has at most one inner
//! maximum. Only segments near the top can win: r ≤ r_max needs cos δ ≥ r_min/r_max. Lobes do not change along z, so
//! their Taylor polynomials about every segment's middle are made once a direction and shared by all columns.
//!
//! A pose tilted by τ in the image plane turns the whole outline: z = s cos τ - X sin τ, x = x0 + s sin τ + X cos τ,
//! with X(s) the outline over the body's own axis s. Slopes of bow and deflection (1e-4) are neglected there.

use std::f64::consts::{PI, TAU};

use glam::{DMat2, DVec2};

use super::error::RenderError;
use crate::shaft::{AxisKnot, ProfileKnot, Shaft, SurfaceTexture};

/// Fewest segments of a turn: bounds the half width of a segment at .0123 rad, where cos and sin to the sixth order
/// are exact to 1e-17.
const FEWEST_SEGMENTS: usize = 256;

/// Segments per undulation: k·(half width) ≤ .25, where the fifth-order Taylor polynomial of a lobe errs by 3.4e-7 a_k.
const SEGMENTS_PER_LOBE: usize = 13;

/// Steps that solve s = (z + X(s) sin τ)/cos τ; each gains a factor of |X'| tan τ.
const TILT_STEPS: usize = 3;

/// A shaft made ready for silhouettes: bounds and the division of the circle.
#[derive(Clone, Debug)]
pub struct Outline {
    shaft: Shaft,
    /// Segments of a turn, a multiple of the texture's nodes.
    segments: usize,
    /// Segments between two nodes of the texture.
    per_node: usize,
    /// Bounds of lobes + texture, mm.
    low_mm: f64,
    high_mm: f64,
    tilt: DMat2,
    sin_tilt: f64,
    cos_tilt: f64,
}

/// Both edges of the shaft's shadow over a z, in machine coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgePair {
    /// Height of the upper edge above the optical axis, mm.
    pub top_mm: f64,
    /// Height of the lower edge above the optical axis, mm.
    pub bottom_mm: f64,
}

/// A spindle angle made ready: both viewing directions share it over all columns.
#[derive(Clone, Debug)]
pub struct Turned<'a> {
    outline: &'a Outline,
    cos: f64,
    sin: f64,
    top: Direction,
    bottom: Direction,
}

/// The segments that face one direction, nearest first.
#[derive(Clone, Debug)]
struct Direction {
    segments: Vec<Segment>,
}

/// One piece of the circle on which r is smooth; t runs over ±half about its middle.
#[derive(Clone, Debug)]
struct Segment {
    /// Node of the texture at or before the segment, and the next one.
    node: [usize; 2],
    /// Where the segment's two ends lie between these nodes, 0..=1.
    span: [f64; 2],
    half: f64,
    cos_mid: f64,
    sin_mid: f64,
    /// Largest cos δ on the segment.
    cos_near: f64,
    /// Sum of the lobes as a polynomial in t.
    lobes: [f64; 6],
    /// Upper bound of the lobes on the segment.
    lobes_high: f64,
}

impl Outline {
    /// Prepares a shaft.
    ///
    /// # Errors
    /// Refuses a shaft that cannot be drawn: no knots, knots out of order, values that are not finite, a radius that
    /// is not positive, lobes below order 2, a texture grid that does not fit its heights.
    pub fn new(shaft: Shaft) -> Result<Self, RenderError> {
        check(&shaft)?;
        let highest = shaft.lobes.iter().map(|l| l.order_upr as usize).max().unwrap_or(0);
        let wanted = FEWEST_SEGMENTS.max(SEGMENTS_PER_LOBE * highest);
        let nodes = shaft.texture.as_ref().map_or(1, |t| t.nodes_theta);
        let per_node = wanted.div_ceil(nodes);
        let lobes: f64 = shaft.lobes.iter().map(|l| l.amplitude_mm.abs()).sum();
        let (low, high) = shaft.texture.as_ref().map_or((0.0, 0.0), bounds);
        let (sin_tilt, cos_tilt) = (shaft.pose.tilt_mrad * 1e-3).sin_cos();
        Ok(Self {
            segments: nodes * per_node,
            per_node,
            low_mm: low - lobes,
            high_mm: high + lobes,
            tilt: DMat2::from_cols(DVec2::new(cos_tilt, sin_tilt), DVec2::new(-sin_tilt, cos_tilt)),
            sin_tilt,
            cos_tilt,
            shaft,
        })
    }

    /// The shaft it was made from.
    pub fn shaft(&self) -> &Shaft {
        &self.shaft
    }

    /// Lower bound of the radius, form errors included, mm.
    pub fn smallest_radius_mm(&self) -> f64 {
        self.shaft.profile.iter().map(|k| k.radius_mm).fold(f64::INFINITY, f64::min) + self.low_mm
    }

    /// The outline at spindle angle φ.
    pub fn turned(&self, angle_deg: f64) -> Turned<'_> {
        let phi = angle_deg.to_radians().rem_euclid(TAU);
        let (sin, cos) = phi.sin_cos();
        Turned {
            outline: self,
            cos,
            sin,
            top: Direction::new(self, phi),
            bottom: Direction::new(self, phi + PI),
        }
    }

    /// Radius of the slice at z in body direction θ (radians), mm. Eccentricity moves the axis and is not in it.
    pub fn radius_mm(&self, z_mm: f64, theta: f64) -> f64 {
        let lobes: f64 = self.shaft.lobes.iter().map(|l| lobe_derivatives(l, theta)[0]).sum();
        mean_radius(&self.shaft.profile, z_mm)
            + lobes
            + Rows::at(self.shaft.texture.as_ref(), z_mm).height(theta)
    }
}

impl Turned<'_> {
    /// Caliper diameter of the slice at body coordinate `s_mm`, across its own axis, mm.
    pub fn caliper_mm(&self, s_mm: f64) -> f64 {
        self.support(&self.top, s_mm) + self.support(&self.bottom, s_mm)
    }

    /// Both edges over machine z, mm above the optical axis.
    pub fn edges(&self, z_mm: f64) -> EdgePair {
        EdgePair { top_mm: self.edge(z_mm, true), bottom_mm: self.edge(z_mm, false) }
    }

    /// Distance of the slice's axis from the focal plane, mm towards the camera.
    pub fn axis_y_mm(&self, z_mm: f64) -> f64 {
        self.axis(z_mm).y
    }

    fn edge(&self, z_mm: f64, top: bool) -> f64 {
        let outline = self.outline;
        let pose_x = outline.shaft.pose.x_mm;
        if outline.sin_tilt == 0.0 {
            return pose_x + self.over_axis(z_mm, top);
        }
        let radius = mean_radius(&outline.shaft.profile, z_mm);
        let mut point = DVec2::new(z_mm, if top { radius } else { -radius });
        for _ in 0..TILT_STEPS {
            point.x = (z_mm + point.y * outline.sin_tilt) / outline.cos_tilt;
            point.y = self.over_axis(point.x, top);
        }
        pose_x + (outline.tilt * point).y
    }

    /// Signed height X(s) of an edge over the axis of rotation.
    fn over_axis(&self, s_mm: f64, top: bool) -> f64 {
        let axis = self.axis(s_mm).x;
        if top { axis + self.support(&self.top, s_mm) } else { axis - self.support(&self.bottom, s_mm) }
    }

    /// Where the slice's axis stands: eccentricity and bow turn with the body, deflection does not.
    fn axis(&self, s_mm: f64) -> DVec2 {
        let shaft = &self.outline.shaft;
        let phase = shaft.eccentricity.phase_deg.to_radians();
        let body = shaft.eccentricity.amplitude_mm * DVec2::from_angle(phase) + knot_offset(&shaft.bow, s_mm);
        DVec2::new(self.cos, self.sin).rotate(body) + knot_offset(&shaft.deflection, s_mm)
    }

    fn support(&self, direction: &Direction, s_mm: f64) -> f64 {
        let outline = self.outline;
        let mean = mean_radius(&outline.shaft.profile, s_mm);
        if outline.low_mm == 0.0 && outline.high_mm == 0.0 {
            return mean;
        }
        let rows = Rows::at(outline.shaft.texture.as_ref(), s_mm);
        let mut best = f64::NEG_INFINITY;
        for segment in &direction.segments {
            if (mean + outline.high_mm) * segment.cos_near <= best {
                break;
            }
            let ends = segment.texture(&rows);
            let bound = (mean + segment.lobes_high + ends[0].max(ends[1])) * segment.cos_near;
            if bound > best {
                best = best.max(segment.maximum(mean, ends));
            }
        }
        best
    }
}

impl Direction {
    /// Segments that can hold the maximum of r(θ)cos(θ + facing).
    fn new(outline: &Outline, facing: f64) -> Self {
        let smallest = outline.shaft.profile.iter().map(|k| k.radius_mm).fold(f64::INFINITY, f64::min);
        let ratio = (smallest + outline.low_mm) / (smallest + outline.high_mm);
        let width = TAU / outline.segments as f64;
        let reach = ratio.clamp(-1.0, 1.0).acos();
        let first = (-facing).rem_euclid(TAU) / width;
        let n = outline.segments as i64;
        let around = ((reach / width).ceil() as i64 + 1).min(n / 2);
        let mut segments: Vec<Segment> = (-around..=around.min(n - 1 - around))
            .map(|offset| Segment::new(outline, first.floor() as i64 + offset, first, width))
            .collect();
        segments.sort_by(|a, b| b.cos_near.total_cmp(&a.cos_near));
        Self { segments }
    }
}

impl Segment {
    fn new(outline: &Outline, index: i64, first: f64, width: f64) -> Self {
        let wrapped = index.rem_euclid(outline.segments as i64) as usize;
        let node = wrapped / outline.per_node;
        let nodes = outline.segments / outline.per_node;
        let within = (wrapped % outline.per_node) as f64;
        let (low, high) = ((index as f64 - first) * width, (index as f64 + 1.0 - first) * width);
        let near = if low > 0.0 {
            low
        } else if high < 0.0 {
            high
        } else {
            0.0
        };
        let middle = 0.5 * (low + high);
        let lobes = taylor(&outline.shaft, (wrapped as f64 + 0.5) * width);
        Self {
            node: [node, (node + 1) % nodes],
            span: [within / outline.per_node as f64, (within + 1.0) / outline.per_node as f64],
            half: 0.5 * width,
            cos_mid: middle.cos(),
            sin_mid: middle.sin(),
            cos_near: near.cos(),
            lobes_high: polynomial_bound(&lobes, 0.5 * width),
            lobes,
        }
    }

    /// Texture at the segment's two ends.
    fn texture(&self, rows: &Rows<'_>) -> [f64; 2] {
        if rows.is_flat() {
            return [0.0, 0.0];
        }
        let (a, b) = (rows.node(self.node[0]), rows.node(self.node[1]));
        [a + (b - a) * self.span[0], a + (b - a) * self.span[1]]
    }

    /// Largest r(θ)cos δ on the segment: the inner maximum where the derivative changes sign, else the better end.
    fn maximum(&self, mean: f64, ends: [f64; 2]) -> f64 {
        let mut p = self.lobes;
        p[0] += mean + 0.5 * (ends[0] + ends[1]);
        p[1] += (ends[1] - ends[0]) / (2.0 * self.half);
        let (left, right) = (self.value(&p, -self.half), self.value(&p, self.half));
        if left.slope <= 0.0 || right.slope >= 0.0 {
            return left.value.max(right.value);
        }
        let mut t = self.half * (left.slope + right.slope) / (left.slope - right.slope);
        for _ in 0..2 {
            let at = self.value(&p, t);
            t = (t - at.slope / at.curvature).clamp(-self.half, self.half);
        }
        self.value(&p, t).value
    }

    /// r cos δ with its first two derivatives.
    fn value(&self, p: &[f64; 6], t: f64) -> Local {
        let r = ((((p[5] * t + p[4]) * t + p[3]) * t + p[2]) * t + p[1]) * t + p[0];
        let r1 = (((5.0 * p[5] * t + 4.0 * p[4]) * t + 3.0 * p[3]) * t + 2.0 * p[2]) * t + p[1];
        let r2 = ((20.0 * p[5] * t + 12.0 * p[4]) * t + 6.0 * p[3]) * t + 2.0 * p[2];
        let t2 = t * t;
        let c = 1.0 - t2 * (0.5 - t2 * (1.0 / 24.0 - t2 / 720.0));
        let s = t * (1.0 - t2 * (1.0 / 6.0 - t2 / 120.0));
        let cos = self.cos_mid * c - self.sin_mid * s;
        let sin = self.sin_mid * c + self.cos_mid * s;
        Local { value: r * cos, slope: r1 * cos - r * sin, curvature: (r2 - r) * cos - 2.0 * r1 * sin }
    }
}

struct Local {
    value: f64,
    slope: f64,
    curvature: f64,
}

/// The texture's rows about a z with their weights.
struct Rows<'a> {
    rows: Option<[&'a [f32]; 2]>,
    weight: f64,
}

impl<'a> Rows<'a> {
    fn at(texture: Option<&'a SurfaceTexture>, z_mm: f64) -> Self {
        let Some(texture) = texture else { return Self { rows: None, weight: 0.0 } };
        let n = texture.nodes_theta;
        let last = texture.height_mm.len() / n - 1;
        let place = ((z_mm - texture.z0_mm) / texture.step_mm).clamp(0.0, last as f64);
        let row = (place as usize).min(last.saturating_sub(1));
        let next = (row + 1).min(last);
        let rows = [&texture.height_mm[row * n..(row + 1) * n], &texture.height_mm[next * n..(next + 1) * n]];
        Self { rows: Some(rows), weight: place - row as f64 }
    }

    fn is_flat(&self) -> bool {
        self.rows.is_none()
    }

    fn node(&self, j: usize) -> f64 {
        let Some([a, b]) = self.rows else { return 0.0 };
        let (a, b) = (f64::from(a[j]), f64::from(b[j]));
        a + (b - a) * self.weight
    }

    fn height(&self, theta: f64) -> f64 {
        let Some([a, _]) = self.rows else { return 0.0 };
        let place = theta.rem_euclid(TAU) / TAU * a.len() as f64;
        let node = (place as usize).min(a.len() - 1);
        let (left, right) = (self.node(node), self.node((node + 1) % a.len()));
        left + (right - left) * (place - node as f64)
    }
}

fn mean_radius(profile: &[ProfileKnot], z_mm: f64) -> f64 {
    let after = profile.partition_point(|k| k.z_mm <= z_mm);
    match (after.checked_sub(1).and_then(|i| profile.get(i)), profile.get(after)) {
        (Some(a), Some(b)) => a.radius_mm + (b.radius_mm - a.radius_mm) * (z_mm - a.z_mm) / (b.z_mm - a.z_mm),
        (Some(only), None) | (None, Some(only)) => only.radius_mm,
        (None, None) => f64::NAN,
    }
}

fn knot_offset(knots: &[AxisKnot], z_mm: f64) -> DVec2 {
    let after = knots.partition_point(|k| k.z_mm <= z_mm);
    match (after.checked_sub(1).and_then(|i| knots.get(i)), knots.get(after)) {
        (Some(a), Some(b)) => {
            DVec2::new(a.x_mm, a.y_mm).lerp(DVec2::new(b.x_mm, b.y_mm), (z_mm - a.z_mm) / (b.z_mm - a.z_mm))
        }
        (Some(only), None) | (None, Some(only)) => DVec2::new(only.x_mm, only.y_mm),
        (None, None) => DVec2::ZERO,
    }
}

/// Value and first five derivatives of a lobe at θ.
fn lobe_derivatives(lobe: &crate::shaft::Lobe, theta: f64) -> [f64; 6] {
    let k = f64::from(lobe.order_upr);
    let (s, c) = (k * (theta - lobe.phase_deg.to_radians())).sin_cos();
    let a = lobe.amplitude_mm;
    [a * c, -a * k * s, -a * k.powi(2) * c, a * k.powi(3) * s, a * k.powi(4) * c, -a * k.powi(5) * s]
}

/// Sum of the lobes as a Taylor polynomial about θ.
fn taylor(shaft: &Shaft, theta: f64) -> [f64; 6] {
    const FACTORIAL: [f64; 6] = [1.0, 1.0, 2.0, 6.0, 24.0, 120.0];
    let mut sum = [0.0; 6];
    for lobe in &shaft.lobes {
        let d = lobe_derivatives(lobe, theta);
        for i in 0..6 {
            sum[i] += d[i] / FACTORIAL[i];
        }
    }
    sum
}

fn polynomial_bound(p: &[f64; 6], half: f64) -> f64 {
    p[0] + (1..6).map(|i| p[i].abs() * half.powi(i as i32)).sum::<f64>()
}

/// Lowest and highest node.
fn bounds(texture: &SurfaceTexture) -> (f64, f64) {
    texture
        .height_mm
        .iter()
        .map(|&h| f64::from(h))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)))
}

fn check(shaft: &Shaft) -> Result<(), RenderError> {
    let refuse = |what: String| Err(RenderError::Shaft { what });
    if shaft.profile.is_empty() {
        return refuse("the profile has no knot; at least one is needed".into());
    }
    if !shaft.profile.is_sorted_by(|a, b| a.z_mm <= b.z_mm) {
        return refuse("the profile's knots must ascend in z".into());
    }
    for knots in [&shaft.bow, &shaft.deflection] {
        if !knots.is_sorted_by(|a, b| a.z_mm <= b.z_mm) {
            return refuse("the knots of bow and deflection must ascend in z".into());
        }
        if knots.iter().any(|k| !(k.z_mm.is_finite() && k.x_mm.is_finite() && k.y_mm.is_finite())) {
            return refuse("bow and deflection must be finite".into());
        }
    }
    if let Some(lobe) = shaft.lobes.iter().find(|l| l.order_upr < 2 || !l.amplitude_mm.is_finite()) {
        return refuse(format!(
            "a lobe has order {} and amplitude {} mm; orders start at 2 (1 is eccentricity)",
            lobe.order_upr, lobe.amplitude_mm
        ));
    }
    let placed = [
        shaft.pose.x_mm,
        shaft.pose.tilt_mrad,
        shaft.eccentricity.amplitude_mm,
        shaft.eccentricity.phase_deg,
    ];
    if placed.iter().any(|v| !v.is_finite()) || shaft.pose.tilt_mrad.abs() > 500.0 {
        return refuse("pose and eccentricity must be finite, the tilt within ±500 mrad".into());
    }
    check_texture(shaft.texture.as_ref())?;
    let lobes: f64 = shaft.lobes.iter().map(|l| l.amplitude_mm.abs()).sum();
    let lowest = shaft.texture.as_ref().map_or(0.0, |t| bounds(t).0) - lobes;
    match shaft.profile.iter().find(|k| !(k.radius_mm.is_finite() && k.radius_mm + lowest > 0.0)) {
        Some(k) => refuse(format!(
            "at z = {} mm the radius {} mm less form errors of {} mm is not positive",
            k.z_mm, k.radius_mm, -lowest
        )),
        None => Ok(()),
    }
}

fn check_texture(texture: Option<&SurfaceTexture>) -> Result<(), RenderError> {
    let Some(t) = texture else { return Ok(()) };
    let fits = t.nodes_theta > 0 && !t.height_mm.is_empty() && t.height_mm.len() % t.nodes_theta == 0;
    if fits && t.step_mm > 0.0 && t.z0_mm.is_finite() && t.height_mm.iter().all(|h| h.is_finite()) {
        return Ok(());
    }
    Err(RenderError::Shaft {
        what: format!(
            "the texture has {} heights for {} nodes a turn at a step of {} mm; it needs whole rows, finite heights and a positive step",
            t.height_mm.len(),
            t.nodes_theta,
            t.step_mm
        ),
    })
}
