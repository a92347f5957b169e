//! Sizes of a section over a revolution: least squares (GG), minimum circumscribed (GN), maximum
//! inscribed (GX).
//!
//! ISO 14405-1 defines these for the section itself; a silhouette shows its convex hull only. GN of
//! the hull is GN of the section (the smallest circle around a body is the smallest around its
//! hull); GX and GG of the hull are not below those of the section, by no more than the depth of
//! hollows that no tangent reaches.
//!
//! GN and GX need no derivative of the support function h: a circle (c, R) holds the body exactly
//! if h(α) ≤ R + c·n(α) in every direction, and lies within the hull if r ≤ h(α) − c·n(α), two
//! linear programmes. GG is the least-squares circle of the hull's boundary, which does need it and
//! so takes the filter's cutoff.

use glam::DVec2;
use std::f64::consts::TAU;

use super::circle::Circle;
use super::error::FormError;
use super::least_squares_circle::{LeastSquaresCircle, least_squares_circle};
use super::linear_program::{LinearProgram, Row};
use super::profile_filter::Cutoff;
use super::silhouette::polar_profile;
use super::turn::Turn;

/// Two-point (caliper) sizes and global sizes of the silhouette over one revolution, mm.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TurnSizes {
    /// Least-squares size GG of the hull.
    pub gg_mm: f64,
    /// Its standard uncertainty from independent edge errors.
    pub u_gg_mm: f64,
    /// Minimum circumscribed size GN.
    pub gn_mm: f64,
    /// Maximum inscribed size GX of the hull.
    pub gx_mm: f64,
    /// Mean caliper diameter over the revolution: the hull's perimeter over π (Cauchy).
    pub mean_caliper_mm: f64,
    /// Least caliper diameter.
    pub min_caliper_mm: f64,
    /// Greatest caliper diameter.
    pub max_caliper_mm: f64,
    /// Circles of GG, GN and GX about the spindle axis, x towards the camera image's up at spindle
    /// angle α = −φ.
    pub circles: [Circle; 3],
}

/// Sizes of a revolution; `u_edge_mm` is the random standard uncertainty of one edge.
///
/// GN and GX are extremes: noise widens GN and narrows GX by some standard uncertainties unless the
/// turn is filtered, so both are taken from the support function after the same filter as GG.
///
/// # Errors
/// A support function that is not convex after the filter.
pub(crate) fn turn_sizes(turn: &Turn, cutoff: Cutoff, u_edge_mm: f64) -> Result<TurnSizes, FormError> {
    let support = super::profile_filter::gaussian_closed(&turn.support_mm(), cutoff);
    let widths = turn.widths_mm();
    let n = widths.len() as f64;
    let least_squares = hull_circle(&turn.support_mm(), cutoff)?;
    let gn = circumscribed(&support)?;
    let gx = inscribed(&support)?;
    let gg = least_squares.fit.circle;
    Ok(TurnSizes {
        gg_mm: gg.diameter(),
        // R is the mean of n widths/2, each of two edges: u(D) = √2·u/√n.
        u_gg_mm: u_edge_mm * (2.0 / n).sqrt(),
        gn_mm: gn.diameter(),
        gx_mm: gx.diameter(),
        mean_caliper_mm: widths.iter().sum::<f64>() / n,
        min_caliper_mm: widths.iter().copied().fold(f64::INFINITY, f64::min),
        max_caliper_mm: widths.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        circles: [gg, gn, gx],
    })
}

/// Least-squares circle of the hull's boundary at even polar angles, as a form tester samples it.
fn hull_circle(support: &[f64], cutoff: Cutoff) -> Result<LeastSquaresCircle, FormError> {
    let profile = polar_profile(support, cutoff)?;
    let n = profile.len() as f64;
    let points: Vec<DVec2> =
        profile.iter().enumerate().map(|(i, r)| DVec2::from_angle(TAU * i as f64 / n) * *r).collect();
    least_squares_circle(&points)
}

/// Smallest circle that holds the body of a support function h(α_i), α_i = i·2π/n.
///
/// # Errors
/// Too few or non-finite samples.
pub(crate) fn circumscribed(support: &[f64]) -> Result<Circle, FormError> {
    chebyshev_centre(support, 1.0, "minimum circumscribed size")
}

/// Largest circle within the hull of a support function h(α_i), α_i = i·2π/n.
///
/// # Errors
/// Too few or non-finite samples.
pub(crate) fn inscribed(support: &[f64]) -> Result<Circle, FormError> {
    chebyshev_centre(support, -1.0, "maximum inscribed size")
}

/// min t subject to t ≥ side·(h − h̄ − c·n): the radius is h̄ + side·t. Repeated in a shrinking box
/// around the centre found, so that the programme's tie-breaking cost vanishes.
fn chebyshev_centre(support: &[f64], side: f64, feature: &'static str) -> Result<Circle, FormError> {
    let n = support.len();
    if n < 8 {
        return Err(FormError::TooFew { feature, found: n, needed: 8 });
    }
    if let Some(index) = support.iter().position(|h| !h.is_finite()) {
        return Err(FormError::NotFinite { index });
    }
    let mean = support.iter().sum::<f64>() / n as f64;
    let reach = support.iter().map(|h| (h - mean).abs()).fold(0.0, f64::max);
    let mut centre = DVec2::ZERO;
    let bound = 8.0 * reach + 1e-12 * mean.abs();
    let mut half = 0.5 * bound;
    let mut t = 0.0;
    for _ in 0..3 {
        let rows: Vec<Row<3>> = support
            .iter()
            .enumerate()
            .map(|(i, h)| {
                let normal = DVec2::from_angle(TAU * i as f64 / n as f64);
                let a = normal * side;
                Row { a: [a.x, a.y, 1.0], b: side * (h - mean - centre.dot(normal)) }
            })
            .collect();
        let lp = LinearProgram {
            cost: [0.0, 0.0, 1.0],
            lower: [-half, -half, -bound],
            upper: [half, half, bound],
            tolerance: 1e-15 * mean.abs(),
        };
        let x = lp.solve(&rows).ok_or(FormError::NotConverged { feature })?;
        centre += DVec2::new(x[0], x[1]);
        t = x[2];
        half *= 1e-3;
    }
    Ok(Circle { centre, radius: mean + side * t })
}
