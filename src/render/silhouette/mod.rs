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
//! with X(s) the outline over the body's own axis s. Sections of a bent body stay square to its axis ([`bent`]), but its shoulders
//! stand upright there (a slope of 1e-3 leans one of R 12.5 by 12 µm along z). Where a
//! shoulder leans over, the outermost edge counts, and the light beneath the overhang is a gap ([`Turned::gap`]). Threads, feed marks, flats and keyways divide the segments further
//! ([`features`]); tilt towards the camera and perspective take the envelope over the slices ([`envelope`]).

use std::f64::consts::{PI, TAU};

mod bent;
mod check;
mod envelope;
mod features;
mod segments;

use glam::{DMat2, DVec2};

pub use self::envelope::View;
use self::features::Slice;
use self::segments::{Direction, Rows, lobe_derivatives};
use super::error::RenderError;
use crate::shaft::{ProfileKnot, Shaft, SurfaceTexture};

/// Fewest segments of a turn: bounds the half width of a segment at .0123 rad, where cos and sin to the sixth order
/// are exact to 1e-17.
const FEWEST_SEGMENTS: usize = 256;

/// Segments per undulation: k·(half width) ≤ .25, where the fifth-order Taylor polynomial of a lobe errs by 3.4e-7 a_k.
const SEGMENTS_PER_LOBE: usize = 13;

/// Most steps that solve s = (z + X(s) sin τ)/cos τ, each of which gains a factor of |X'| tan τ, and the change (mm) at
/// which they end.
const TILT_STEPS: usize = 40;
const TILT_STILL_MM: f64 = 1e-11;

/// Most steps of [`root`], and the residue (mm) at which it ends.
const ROOT_STEPS: usize = 80;
const ROOT_STILL_MM: f64 = 1e-13;

/// Distance at which the two sides of a shoulder are told apart, mm.
pub(super) const BESIDE_MM: f64 = 1e-9;

/// Change of the profile's slope from which a corner is no straight line within the blur: it moves the mean over whole columns
/// by 8e-6 px.
const CORNER: f64 = 3e-4;

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
    /// Radius of a disc that every slice holds, flats and keyways cut away.
    core_mm: f64,
    /// z of every shoulder, ascending.
    shoulders_mm: Vec<f64>,
    /// Stretches of z with corners, threads or ends of features, ascending by their start.
    broken_mm: Vec<(f64, f64)>,
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
    /// Error motion of the spindle.
    shift: DVec2,
}

impl Outline {
    /// Prepares a shaft.
    ///
    /// # Errors
    /// Refuses a shaft that cannot be drawn: no knots, knots out of order, values that are not finite, a radius that
    /// is not positive, lobes below order 2, a texture grid that does not fit its heights.
    pub fn new(shaft: Shaft) -> Result<Self, RenderError> {
        check::check(&shaft)?;
        let highest = shaft.lobes.iter().map(|l| l.order_upr as usize).max().unwrap_or(0);
        let wanted = FEWEST_SEGMENTS.max(SEGMENTS_PER_LOBE * highest);
        let nodes = shaft.texture.as_ref().map_or(1, |t| t.nodes_theta);
        let per_node = wanted.div_ceil(nodes);
        let lobes: f64 = shaft.lobes.iter().map(|l| l.amplitude_mm.abs()).sum();
        let (low, high) = shaft.texture.as_ref().map_or((0.0, 0.0), bounds);
        let (below, above) = features::bounds(&shaft.features);
        let (sin_tilt, cos_tilt) = (shaft.pose.tilt_mrad * 1e-3).sin_cos();
        Ok(Self {
            segments: nodes * per_node,
            per_node,
            low_mm: low - lobes + below,
            high_mm: high + lobes + above,
            core_mm: features::core_mm(&shaft, low - lobes + below),
            shoulders_mm: shoulders(&shaft.profile),
            broken_mm: features::broken(&shaft, CORNER),
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

    /// Lower bound of half the height that any slice shows, mm.
    pub fn smallest_radius_mm(&self) -> f64 {
        self.core_mm
    }

    /// Bound of the distance of any slice's axis from the plane of focus, mm; 0 for a straight, centred shaft.
    pub fn largest_depth_mm(&self) -> f64 {
        let bow = self.shaft.bow.iter().map(|k| k.x_mm.hypot(k.y_mm)).fold(0.0, f64::max);
        let deflection = self.shaft.deflection.iter().map(|k| k.y_mm.abs()).fold(0.0, f64::max);
        let spindle = &self.shaft.spindle;
        let synchronous: f64 = spindle.synchronous.iter().map(|h| h.y_um.abs()).sum();
        let spindle_mm = (synchronous + 4.0 * spindle.asynchronous_rms_um) * 1e-3;
        bow + deflection + self.shaft.eccentricity.amplitude_mm.abs() + spindle_mm
    }

    /// Smallest and largest mean radius R(z), mm.
    pub fn mean_radii_mm(&self) -> (f64, f64) {
        let waves: f64 = self.shaft.features.waves.iter().map(|w| w.amplitude_mm.abs()).sum();
        let radii = self.shaft.profile.iter().map(|k| k.radius_mm);
        (radii.clone().fold(f64::INFINITY, f64::min) - waves, radii.fold(0.0, f64::max) + waves)
    }

    /// Mean radius at z, mm: profile and waves.
    pub fn mean_radius_mm(&self, z_mm: f64) -> f64 {
        let wave = |w: &crate::shaft::AxialWave| {
            w.amplitude_mm * (TAU * z_mm / w.wavelength_mm + w.phase_deg.to_radians()).cos()
        };
        mean_radius(&self.shaft.profile, z_mm) + self.shaft.features.waves.iter().map(wave).sum::<f64>()
    }

    /// Whether a corner, a thread or the end of a feature lies in `from_mm..=to_mm`, so that the outline there may be no
    /// smooth line.
    pub fn is_broken(&self, from_mm: f64, to_mm: f64) -> bool {
        let after = self.broken_mm.partition_point(|(start, _)| *start <= to_mm);
        after.checked_sub(1).is_some_and(|last| self.broken_mm[last].1 >= from_mm)
    }

    /// Undulations a turn of the finest form that turns past the camera.
    pub fn undulations(&self) -> f64 {
        let f = &self.shaft.features;
        let lobes = self.shaft.lobes.iter().map(|l| l.order_upr).max().unwrap_or(1);
        let cut = if f.flats.is_empty() && f.keyways.is_empty() { 1 } else { 12 };
        let spindle = self.shaft.spindle.synchronous.iter().map(|h| h.order).max().unwrap_or(1);
        f64::from(lobes.max(cut).max(spindle))
    }

    /// Whether the outline is made of level pieces and shoulders alone, up to form errors, upright before the camera.
    pub fn is_stepped(&self) -> bool {
        let (shaft, features) = (&self.shaft, &self.shaft.features);
        let level = |k: &[ProfileKnot]| k[0].radius_mm == k[1].radius_mm || k[0].z_mm == k[1].z_mm;
        let uncut = features.helices.is_empty() && features.flats.is_empty() && features.keyways.is_empty();
        uncut && self.sin_tilt == 0.0 && shaft.profile.windows(2).all(level)
    }

    /// Whether the outline has any corner, thread or end of a feature.
    pub fn has_breaks(&self) -> bool {
        !self.broken_mm.is_empty()
    }

    /// z at which the outline changes direction or height between `from_mm` and `to_mm`, ascending.
    pub fn breaks_mm(&self, from_mm: f64, to_mm: f64) -> Vec<f64> {
        let first = self.shaft.profile.partition_point(|k| k.z_mm <= from_mm);
        let mut breaks: Vec<f64> =
            self.shaft.profile[first..].iter().map(|k| k.z_mm).take_while(|z| *z < to_mm).collect();
        let features = &self.shaft.features;
        let ends = features
            .helices
            .iter()
            .map(|h| [h.from_mm, h.to_mm])
            .chain(features.flats.iter().map(|f| [f.from_mm, f.to_mm]))
            .chain(features.keyways.iter().map(|k| [k.from_mm, k.to_mm]));
        breaks.extend(ends.flatten().filter(|z| *z > from_mm && *z < to_mm));
        breaks.sort_by(f64::total_cmp);
        breaks.dedup();
        breaks
    }

    /// The outline at spindle angle φ.
    pub fn turned(&self, angle_deg: f64) -> Turned<'_> {
        let phi = angle_deg.to_radians().rem_euclid(TAU);
        let (sin, cos) = phi.sin_cos();
        let mut shift = DVec2::ZERO;
        for h in &self.shaft.spindle.synchronous {
            let turn = f64::from(h.order) * phi;
            shift.x += 1e-3 * h.x_um * (turn + h.x_phase_deg.to_radians()).cos();
            shift.y += 1e-3 * h.y_um * (turn + h.y_phase_deg.to_radians()).cos();
        }
        Turned {
            outline: self,
            cos,
            sin,
            top: Direction::new(self, phi),
            bottom: Direction::new(self, phi + PI),
            shift,
        }
    }

    /// Radius of the slice at z in body direction θ (radians), mm: the outermost point where a keyway leaves two. Eccentricity
    /// moves the axis and is not in it.
    pub fn radius_mm(&self, z_mm: f64, theta: f64) -> f64 {
        Slice::at(self, z_mm).cut(theta, self.uncut_radius_mm(z_mm, theta))
    }

    /// [`Self::radius_mm`] before flats and keyways are cut.
    fn uncut_radius_mm(&self, z_mm: f64, theta: f64) -> f64 {
        let lobes: f64 = self.shaft.lobes.iter().map(|l| lobe_derivatives(l, theta)[0]).sum();
        let helices = &self.shaft.features.helices;
        self.mean_radius_mm(z_mm)
            + lobes
            + Rows::at(self.shaft.texture.as_ref(), z_mm).height(theta)
            + helices.iter().map(|h| features::helix_height(h, z_mm, theta)).sum::<f64>()
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

    /// Radius of the slice at z in machine direction `angle` (radians from x towards y), about its own axis, mm.
    pub fn radius_at(&self, z_mm: f64, angle: f64) -> f64 {
        self.outline.radius_mm(z_mm, angle - self.sin.atan2(self.cos))
    }

    /// Where the slice's axis stands, mm along x and y from that of the spindle; the pose before a camera is not in it.
    pub fn axis_mm(&self, z_mm: f64) -> (f64, f64) {
        let axis = self.axis(z_mm);
        (axis.x, axis.y)
    }

    /// Distance of the slice's axis from the focal plane, mm towards the camera.
    pub fn axis_y_mm(&self, z_mm: f64) -> f64 {
        self.axis(z_mm).y
    }

    /// Where (z, x) both sides of a corner at body coordinate `s_mm` appear on both edges, mm.
    pub(super) fn corner_seen(&self, s_mm: f64) -> [(f64, f64); 4] {
        let outline = self.outline;
        let seen = |side: f64, top: bool| {
            let point = outline.tilt * DVec2::new(s_mm, self.over_axis(s_mm + side * BESIDE_MM, top));
            (point.x, point.y + outline.shaft.pose.x_mm)
        };
        [seen(-1.0, true), seen(1.0, true), seen(-1.0, false), seen(1.0, false)]
    }

    /// Moves the axis of rotation by an error that does not repeat, mm along x and y.
    #[must_use]
    pub fn shifted(mut self, x_mm: f64, y_mm: f64) -> Self {
        self.shift += DVec2::new(x_mm, y_mm);
        self
    }

    fn edge(&self, z_mm: f64, top: bool) -> f64 {
        let outline = self.outline;
        let pose_x = outline.shaft.pose.x_mm;
        if outline.sin_tilt == 0.0 {
            return pose_x + self.over_axis(z_mm, top);
        }
        let height = |point: DVec2| (outline.tilt * point).y;
        let outer = |best: Option<f64>, x: f64| match best {
            Some(b) if (b > x) == top => Some(b),
            _ => Some(x),
        };
        let outermost = self.crossings(z_mm, top).into_iter().map(height).fold(None, outer);
        pose_x + outermost.unwrap_or_else(|| height(self.on_outline(z_mm, top)))
    }

    /// Light beneath the overhang of a leaning shoulder at z: its inner and outer end, mm above the optical axis.
    pub fn gap(&self, z_mm: f64, top: bool) -> Option<[f64; 2]> {
        let outline = self.outline;
        if outline.sin_tilt == 0.0 {
            return None;
        }
        let points = self.crossings(z_mm, top);
        let mut heights: Vec<f64> = points.into_iter().map(|p| (outline.tilt * p).y).collect();
        heights.sort_by(|a, b| if top { b.total_cmp(a) } else { a.total_cmp(b) });
        let pose_x = outline.shaft.pose.x_mm;
        (heights.len() > 2).then(|| [heights[2], heights[1]].map(|x| pose_x + x))
    }

    /// Every point (s, X) at which a tilted body's outline crosses z, where corners lie near; none where there are no corners.
    fn crossings(&self, z_mm: f64, top: bool) -> Vec<DVec2> {
        let outline = self.outline;
        let (sin, cos) = (outline.sin_tilt, outline.cos_tilt);
        let reach =
            1.1 * (sin.abs() * outline.mean_radii_mm().1 + z_mm.abs() * (1.0 - cos)) / cos + BESIDE_MM;
        let breaks = outline.breaks_mm(z_mm - reach, z_mm + reach);
        let mut found = Vec::new();
        if breaks.is_empty() {
            return found;
        }
        let place = |s: f64| s * cos - self.over_axis(s, top) * sin - z_mm;
        let mut low = (z_mm - reach, place(z_mm - reach));
        for s in breaks.into_iter().map(Some).chain([None]) {
            let end = s.map_or(z_mm + reach, |s| s - BESIDE_MM);
            let high = (end, place(end));
            if (low.1 <= 0.0) != (high.1 <= 0.0) {
                let s = root(place, low, high);
                found.push(DVec2::new(s, self.over_axis(s, top)));
            }
            let Some(s) = s else { break };
            low = (s + BESIDE_MM, place(s + BESIDE_MM));
            if (high.1 <= 0.0) != (low.1 <= 0.0) {
                // On the face of the shoulder.
                found.push(DVec2::new(s, (s * cos - z_mm) / sin));
            }
        }
        found
    }

    /// The outline's point (s, X) that a tilted body shows at z, far from corners.
    fn on_outline(&self, z_mm: f64, top: bool) -> DVec2 {
        let outline = self.outline;
        let radius = mean_radius(&outline.shaft.profile, z_mm);
        let mut point = DVec2::new(z_mm, if top { radius } else { -radius });
        for _ in 0..TILT_STEPS {
            let before = point.x;
            point.x = (z_mm + point.y * outline.sin_tilt) / outline.cos_tilt;
            point.y = self.over_axis(point.x, top);
            if (point.x - before).abs() < TILT_STILL_MM {
                return point;
            }
        }
        // A face too steep for steps.
        let place = |s: f64| s * outline.cos_tilt - self.over_axis(s, top) * outline.sin_tilt - z_mm;
        let reach = 1.1 * outline.mean_radii_mm().1 * outline.sin_tilt.abs();
        let [low, high] = [z_mm - reach, z_mm + reach].map(|s| (s, place(s)));
        let s = root(place, low, high);
        DVec2::new(s, self.over_axis(s, top))
    }

    /// Signed height X(s) of an edge over the axis of rotation.
    fn over_axis(&self, s_mm: f64, top: bool) -> f64 {
        let (axis, secant) = (self.axis(s_mm).x, self.secant(s_mm));
        if top {
            axis + secant * self.support(&self.top, s_mm)
        } else {
            axis - secant * self.support(&self.bottom, s_mm)
        }
    }

    /// Where the slice's axis stands: eccentricity and bow turn with the body, deflection does not.
    fn axis(&self, s_mm: f64) -> DVec2 {
        let shaft = &self.outline.shaft;
        let phase = shaft.eccentricity.phase_deg.to_radians();
        let body =
            shaft.eccentricity.amplitude_mm * DVec2::from_angle(phase) + bent::offset(&shaft.bow, s_mm);
        DVec2::new(self.cos, self.sin).rotate(body) + bent::offset(&shaft.deflection, s_mm) + self.shift
    }

    /// By how much an upright slice is higher than the section square to the axis, where the axis slopes in the image plane.
    fn secant(&self, s_mm: f64) -> f64 {
        let shaft = &self.outline.shaft;
        if shaft.bow.is_empty() && shaft.deflection.is_empty() {
            return 1.0;
        }
        let bow = DVec2::new(self.cos, self.sin).rotate(bent::slope(&shaft.bow, s_mm));
        bent::secant(bow.x + bent::slope(&shaft.deflection, s_mm).x)
    }

    fn support(&self, direction: &Direction, s_mm: f64) -> f64 {
        let outline = self.outline;
        let mean = outline.mean_radius_mm(s_mm);
        let features = &outline.shaft.features;
        if !(features.helices.is_empty() && features.flats.is_empty() && features.keyways.is_empty()) {
            return Slice::at(outline, s_mm).support(direction);
        }
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

/// z of every shoulder: two knots at the same z.
fn shoulders(profile: &[ProfileKnot]) -> Vec<f64> {
    profile.windows(2).filter(|k| k[0].z_mm == k[1].z_mm).map(|k| k[0].z_mm).collect()
}

/// Zero of a function between two points at which it has different signs: false position, the end that stays counted half.
fn root(f: impl Fn(f64) -> f64, mut low: (f64, f64), mut high: (f64, f64)) -> f64 {
    for _ in 0..ROOT_STEPS {
        let s = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        let value = f(s);
        if !s.is_finite() || value.abs() < ROOT_STILL_MM || (high.0 - low.0).abs() < ROOT_STILL_MM {
            return if s.is_finite() { s } else { 0.5 * (low.0 + high.0) };
        }
        if (value <= 0.0) == (low.1 <= 0.0) {
            (low, high.1) = ((s, value), 0.5 * high.1);
        } else {
            (high, low.1) = ((s, value), 0.5 * low.1);
        }
    }
    0.5 * (low.0 + high.0)
}

fn mean_radius(profile: &[ProfileKnot], z_mm: f64) -> f64 {
    let after = profile.partition_point(|k| k.z_mm <= z_mm);
    match (after.checked_sub(1).and_then(|i| profile.get(i)), profile.get(after)) {
        (Some(a), Some(b)) => a.radius_mm + (b.radius_mm - a.radius_mm) * (z_mm - a.z_mm) / (b.z_mm - a.z_mm),
        (Some(only), None) | (None, Some(only)) => only.radius_mm,
        (None, None) => f64::NAN,
    }
}

/// Lowest and highest node.
fn bounds(texture: &SurfaceTexture) -> (f64, f64) {
    texture
        .height_mm
        .iter()
        .map(|&h| f64::from(h))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)))
}
