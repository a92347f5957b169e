//! The pieces of a circle that face one direction, and the largest r(θ)cos(θ + φ) on each.

use std::f64::consts::TAU;

use super::outline::Outline;
use crate::shaft::{Shaft, SurfaceTexture};

/// Steps of the safeguarded Newton method: quadratic from the middle of a piece.
const NEWTON_STEPS: usize = 8;

/// The segments that face one direction, nearest first.
#[derive(Clone, Debug)]
pub(super) struct Direction {
    pub(super) segments: Vec<Segment>,
    /// Angle between the direction and the body's θ = 0: heights are r(θ)cos(θ + facing).
    pub(super) facing: f64,
}

/// One segment of the circle on which r is smooth; t is in ±half about its middle.
#[derive(Clone, Debug)]
pub(super) struct Segment {
    /// Node of the texture at or before the segment, and the next one.
    node: [usize; 2],
    /// Positions of the segment's two ends between these nodes, 0..=1.
    span: [f64; 2],
    /// Body angle of its middle.
    pub(super) middle: f64,
    pub(super) half: f64,
    cos_mid: f64,
    sin_mid: f64,
    /// Largest cos δ on the segment.
    pub(super) cos_near: f64,
    /// Sum of the lobes as a polynomial in t.
    pub(super) lobes: [f64; 6],
    /// Upper bound of the lobes on the segment.
    pub(super) lobes_high: f64,
}

impl Direction {
    /// Segments that can contain the maximum of r(θ)cos(θ + facing).
    pub(super) fn new(outline: &Outline, facing: f64) -> Self {
        let smallest = outline.mean_radii_mm().0;
        // No height is smaller than the radius of the disc inside every slice.
        let ratio = outline.core_mm.min(smallest + outline.low_mm) / (smallest + outline.high_mm);
        let width = TAU / outline.segments as f64;
        let reach = ratio.clamp(-1.0, 1.0).acos();
        let first = (-facing).rem_euclid(TAU) / width;
        let n = outline.segments as i64;
        let around = ((reach / width).ceil() as i64 + 1).min(n / 2);
        let mut segments: Vec<Segment> = (-around..=around.min(n - 1 - around))
            .map(|offset| Segment::new(outline, first.floor() as i64 + offset, first, width))
            .collect();
        segments.sort_by(|a, b| b.cos_near.total_cmp(&a.cos_near));
        Self { segments, facing }
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
            middle: (wrapped as f64 + 0.5) * width,
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
    pub(super) fn texture(&self, rows: &Rows<'_>) -> [f64; 2] {
        if rows.is_flat() {
            return [0.0, 0.0];
        }
        let (a, b) = (rows.node(self.node[0]), rows.node(self.node[1]));
        [a + (b - a) * self.span[0], a + (b - a) * self.span[1]]
    }

    /// Largest r(θ)cos δ on the segment: the inner maximum where the derivative changes sign,
    /// otherwise the larger end.
    pub(super) fn maximum(&self, mean: f64, ends: [f64; 2]) -> f64 {
        let p = self.radius(mean, ends);
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

    /// r over t as a polynomial: mean, lobes and texture.
    pub(super) fn radius(&self, mean: f64, ends: [f64; 2]) -> [f64; 6] {
        let mut p = self.lobes;
        p[0] += mean + 0.5 * (ends[0] + ends[1]);
        p[1] += (ends[1] - ends[0]) / (2.0 * self.half);
        p
    }

    /// Largest r(θ)cos δ for t in `from..=to`, r given as a polynomial: by Newton's method,
    /// bracketed between points of rising and of falling height.
    pub(super) fn maximum_within(&self, p: &[f64; 6], from: f64, to: f64) -> f64 {
        let (left, right) = (self.value(p, from), self.value(p, to));
        let ends = left.value.max(right.value);
        if left.slope <= 0.0 || right.slope >= 0.0 {
            return ends;
        }
        let (mut low, mut high) = (from, to);
        let mut t = 0.5 * (low + high);
        for _ in 0..NEWTON_STEPS {
            let at = self.value(p, t);
            if at.slope > 0.0 {
                low = t;
            } else {
                high = t;
            }
            let next = t - at.slope / at.curvature;
            t = if next >= low && next <= high { next } else { 0.5 * (low + high) };
        }
        self.value(p, t).value.max(ends)
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
pub(super) struct Rows<'a> {
    rows: Option<[&'a [f32]; 2]>,
    weight: f64,
}

impl<'a> Rows<'a> {
    pub(super) fn at(texture: Option<&'a SurfaceTexture>, z_mm: f64) -> Self {
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

    pub(super) fn height(&self, theta: f64) -> f64 {
        let Some([a, _]) = self.rows else { return 0.0 };
        let place = theta.rem_euclid(TAU) / TAU * a.len() as f64;
        let node = (place as usize).min(a.len() - 1);
        let (left, right) = (self.node(node), self.node((node + 1) % a.len()));
        left + (right - left) * (place - node as f64)
    }
}

/// Value and first five derivatives of a lobe at θ.
pub(super) fn lobe_derivatives(lobe: &crate::shaft::Lobe, theta: f64) -> [f64; 6] {
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
