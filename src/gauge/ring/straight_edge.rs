//! The edge in the pixels along a straight line, by interpolation over their distance.
//!
//! Along a line all pixels have one normal and one blur: E of `model` is then a function of the
//! distance alone, E(d). It is tabulated once; between two nodes a step h apart stands the quintic
//! that has E, E′ and E″ of both, E″ = (∂E/∂σ)/σ (heat equation). Its own derivatives are ∂E/∂d and
//! ∂E/∂σ, so that value and gradient belong to one function.
//!
//! E is Φ(d/σ) averaged over the pixel, so that |E⁽⁶⁾| ≤ max|Φ⁽⁶⁾|/σ⁶ = 2.3/σ⁶. The quintic departs
//! from E by at most h⁶/46080·|E⁽⁶⁾|, its second derivative by h⁴/480·|E⁽⁶⁾|: with h = σ/12 by
//! 2e-11, and ∂E/∂σ by 2.4e-7/σ. Valid for σ ≥ 0.25 px.

use std::f64::consts::FRAC_1_SQRT_2;

use super::edge_pixels::EdgePixel;
use super::model::{Sample, exact_edge, square_edge};
use crate::gauge::limit::limits;

limits! {
    /// How the edge along a line is tabulated.
    StraightEdgeLimits = "ring_line";
    /// Nodes within a standard deviation of the blur: ∂E/∂σ is then exact to 1e-6 px⁻¹ from a blur
    /// of a quarter of a pixel on, by the bound above.
    per_sigma: f64 = 12.0;
    /// Standard deviations beyond which light is 0 or 1: Φ(−6.7) = 1e-11.
    reach_sigmas: f64 = 6.7;
}

/// E over the distance from a line.
#[derive(Clone, Debug)]
pub(super) struct StraightEdge {
    /// Direction of the normal (cos, sin) that it is for.
    normal: (f64, f64),
    sigma: f64,
    /// Distance of the first node, px.
    from: f64,
    /// Nodes per px.
    per_px: f64,
    /// Coefficients of the quintic between each node and the next.
    pieces: Vec<[f64; 6]>,
}

impl StraightEdge {
    /// The table for a line with the normal (cos θ, sin θ), of edges blurred by `sigma` px.
    pub(super) fn new(normal: (f64, f64), sigma: f64) -> Self {
        let limits = StraightEdgeLimits::get();
        // a pixel reaches half of its diagonal towards the line
        let reach = FRAC_1_SQRT_2 + limits.reach_sigmas * sigma;
        let count = (2.0 * reach * limits.per_sigma / sigma).ceil().max(1.0) as usize;
        let step = 2.0 * reach / count as f64;
        let node = |k: usize| {
            let edge = exact_edge(k as f64 * step - reach, normal, sigma);
            [edge.value, step * edge.by_distance, step * step * edge.by_sigma / sigma]
        };
        let mut pieces = Vec::with_capacity(count);
        let mut before = node(0);
        for k in 1..=count {
            let after = node(k);
            pieces.push(quintic(before, after));
            before = after;
        }
        Self { normal, sigma, from: -reach, per_px: step.recip(), pieces }
    }

    /// Whether it is for that line and blur.
    pub(super) fn is_of(&self, normal: (f64, f64), sigma: f64) -> bool {
        self.normal == normal && self.sigma == sigma
    }

    /// The edge in a pixel whose centre lies `d` px from the line, towards the light.
    #[inline]
    pub(super) fn at(&self, d: f64) -> Sample {
        let place = (d - self.from) * self.per_px;
        // also of a distance that is no number
        if !(place >= 0.0) {
            return Sample::default();
        }
        let Some(&[a, b, c, p, q, r]) = self.pieces.get(place as usize) else {
            return Sample { value: 1.0, ..Sample::default() };
        };
        let v = place.fract();
        let value = a + v * (b + v * (c + v * (p + v * (q + v * r))));
        let slope = b + v * (2.0 * c + v * (3.0 * p + v * (4.0 * q + v * 5.0 * r)));
        let second = 2.0 * c + v * (6.0 * p + v * (12.0 * q + v * 20.0 * r));
        let by_distance = self.per_px * slope;
        Sample { value, by_distance, by_sigma: self.sigma * self.per_px * self.per_px * second }
    }
}

/// The edge in each pixel of a caliper, blurred by `sigma` px, `shift` px from the contour: by the
/// table of a line where all of them have its normal. `last` is the table of the caliper before.
pub(super) fn edges(
    pixels: &[EdgePixel],
    shift: f64,
    sigma: f64,
    last: &mut Option<StraightEdge>,
) -> Vec<Sample> {
    let normal = |p: &EdgePixel| (p.cos, p.sin);
    let straight = pixels.windows(2).all(|w| normal(&w[0]) == normal(&w[1]));
    match pixels.first() {
        Some(first) if straight && pixels.len() > 1 => {
            let own = last.take().filter(|table| table.is_of(normal(first), sigma));
            let table = last.insert(own.unwrap_or_else(|| StraightEdge::new(normal(first), sigma)));
            pixels.iter().map(|p| table.at(p.distance - shift)).collect()
        }
        _ => pixels.iter().map(|p| square_edge(p.distance - shift, p.cos, p.sin, sigma)).collect(),
    }
}

/// Coefficients of the quintic over 0 to 1 with (value, first, second derivative) at both ends.
fn quintic([f0, s0, c0]: [f64; 3], [f1, s1, c1]: [f64; 3]) -> [f64; 6] {
    let (value, slope, second) = (f1 - f0 - s0 - 0.5 * c0, s1 - s0 - c0, c1 - c0);
    let p = 10.0 * value - 4.0 * slope + 0.5 * second;
    let q = 7.0 * slope - 15.0 * value - second;
    let r = 6.0 * value - 3.0 * slope + 0.5 * second;
    [f0, s0, 0.5 * c0, p, q, r]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_the_area_integral_to_a_part_in_a_million() {
        for k in 0..400 {
            let turn = 0.37 * f64::from(k);
            let sigma = 0.25 + 2.75 * (0.7 * turn).cos().abs();
            let normal = (turn.cos(), turn.sin());
            let table = StraightEdge::new(normal, sigma);
            for i in 0..200 {
                // 0.61 of steps of a node: all places between two
                let d = 0.0061 * sigma * f64::from(i * 13 - 1300) + 1e-3 * f64::from(k);
                let (found, right) = (table.at(d), exact_edge(d, normal, sigma));
                assert!((found.value - right.value).abs() < 1e-9, "{sigma} {d}: {found:?} {right:?}");
                assert!((found.by_distance - right.by_distance).abs() < 1e-7, "{sigma} {d}");
                assert!((found.by_sigma - right.by_sigma).abs() < 1e-6, "{sigma} {d}");
            }
        }
    }

    #[test]
    fn calipers_of_a_line_share_a_table_and_those_of_an_arc_have_none() {
        let pixel = |k: i32, turn: f64| EdgePixel {
            value: 0.0,
            distance: 0.31 * f64::from(k) - 4.0,
            cos: turn.cos(),
            sin: turn.sin(),
            x: 0.0,
            y: 0.0,
        };
        let line: Vec<EdgePixel> = (0..26).map(|k| pixel(k, 0.7)).collect();
        let arc: Vec<EdgePixel> = (0..26).map(|k| pixel(k, 0.7 + 1e-4 * f64::from(k))).collect();
        let mut last = None;
        for shift in [0.0, 0.2] {
            let found = edges(&line, shift, 1.2, &mut last);
            assert!(last.as_ref().is_some_and(|table| table.is_of((line[0].cos, line[0].sin), 1.2)));
            for (e, p) in found.iter().zip(&line) {
                let right = exact_edge(p.distance - shift, (p.cos, p.sin), 1.2);
                assert!((e.value - right.value).abs() < 1e-9, "{e:?} {right:?}");
            }
        }
        let found = edges(&arc, 0.2, 1.2, &mut last);
        let own = |p: &EdgePixel| square_edge(p.distance - 0.2, p.cos, p.sin, 1.2);
        assert_eq!(found, arc.iter().map(own).collect::<Vec<_>>());
    }

    #[test]
    fn far_from_the_line_there_is_shadow_and_light() {
        let table = StraightEdge::new((0.6, -0.8), 1.2);
        assert_eq!((table.at(-40.0), table.at(f64::NAN)), (Sample::default(), Sample::default()));
        assert_eq!(table.at(40.0), Sample { value: 1.0, ..Sample::default() });
        assert!(table.is_of((0.6, -0.8), 1.2) && !table.is_of((0.6, -0.8), 1.3));
    }
}
