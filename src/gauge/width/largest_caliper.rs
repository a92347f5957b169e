//! The largest caliper diameter of a frame, without the upward bias that the largest of many noisy
//! widths has.
//!
//! A round part seen end-on has widths w² = D² − 4·(c − c0)²: w² is a parabola over the columns,
//! exactly for a circle and an ellipse. It is fitted robustly around the widest place and its
//! vertex is D. A shaft has no such vertex; there the largest of all stretches of columns down to a
//! least width stands for it (`stretch`), and where crests face roots the distance of the two
//! tangents.

use super::axis_slope::AxisSlope;
use super::curvature_bias::bias_per_curvature;
use super::stretch::crests::Crests;
use super::stretch::largest_value::{LEAST_STRETCH, Largest, Line};
use crate::gauge::edge::stream::StreamLimits;
use crate::gauge::edges::FrameEdges;
use crate::gauge::limit::limits;
use crate::gauge::width::reused::Reused;
use crate::numerics::normal_equations::NormalEquations;
use crate::numerics::robust::{MEDIAN_TO_SD, upper_median};

limits! {
    /// Which width is the largest caliper diameter.
    CaliperLimits = "largest_caliper";
    /// Standard uncertainties by which the tangents must lie farther apart than the largest width
    /// to give the caliper diameter: chance lets them once in forty.
    apart: f64 = 2.0;
    /// −d²(w²)/dc²/2, from which on a part is taken for round and seen end-on: half of the 4 of a
    /// circle, as an ellipse has that is √2 times as long along the columns as it is high.
    least_round: f64 = 2.0;
    /// The same, up to which it is: twice that of a circle.
    most_round: f64 = 8.0;
    /// Half width of the vertex fit, of the diameter: 12 % either side, at whose ends the width is
    /// 3 % less, 1 − √(1 − 0.24²). Wider fits are quieter, narrower ones clear of flats and
    /// keyways. Tuned: see study limits.
    vertex: f64 = 0.12;
}

/// The largest caliper diameter of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LargestCaliper {
    /// Diameter, px.
    pub diameter_px: f64,
    /// Standard uncertainty of it (noise, levels and scatter of the edge about the fit), px.
    pub u_px: f64,
    /// The part of it that columns do not share (noise, scatter and the choice of the place), px.
    pub u_own_px: f64,
    /// The part of that which the noise of the edges explains, px.
    pub u_noise_px: f64,
    /// Column where it stands, px.
    pub column_px: f64,
    /// First and last column of the stretch that it stands for.
    pub stretch: (usize, usize),
    /// Whether it is the vertex of a round part seen end-on.
    pub end_on: bool,
    /// Whether it is the distance of the tangents to crests that face roots.
    pub tangents: bool,
}

impl LargestCaliper {
    /// Columns of the stretch.
    pub(crate) fn stretch_columns(&self) -> usize {
        self.stretch.1 - self.stretch.0 + 1
    }
}

/// Finds it over stretches of 5 columns or more; `None` where no column has both edges.
pub(crate) fn largest_caliper(edges: &FrameEdges) -> Option<LargestCaliper> {
    largest_caliper_over(edges, LEAST_STRETCH)
}

/// Finds it over stretches of `least` columns or more.
pub(crate) fn largest_caliper_over(edges: &FrameEdges, least: usize) -> Option<LargestCaliper> {
    largest_caliper_where(edges, least, |_, top_px, bottom_px| bottom_px - top_px)
}

/// The caliper diameter in the image, px, where `size` of (column, rows of the upper and lower
/// edge) is largest: behind a lens that distorts, the widest place of the image is not that of the
/// part.
pub(crate) fn largest_caliper_where(
    edges: &FrameEdges,
    least: usize,
    size: impl Fn(usize, f64, f64) -> f64,
) -> Option<LargestCaliper> {
    let stream_limits = StreamLimits::get();
    let widths: Reused<(f64, f64)> =
        (0..edges.columns()).filter_map(|c| edges.width_px(c).map(|w| (c as f64, w))).collect();
    if edges.columns() < stream_limits.least_columns {
        return mean_of_readings(edges, size);
    }
    let crests = Crests::find(edges).and_then(|crests| crests.tangents(least));
    let along = widest(edges, &widths, least, size);
    let end_on = along.and_then(|l| vertex(&widths, l.column_px, l.value_px));
    let largest = match (end_on, along, crests) {
        // A disc's middle keeps to its axis; a tooth of a thread may look as round as a disc.
        (_, Some(along), Some(crests)) if rises_above(&crests, &along) => of_shaft(&crests, true),
        (Some(vertex), ..) => vertex,
        (None, Some(along), _) => of_shaft(&along, false),
        (None, None, Some(crests)) => of_shaft(&crests, true),
        (None, None, None) => return None,
    };
    // A disc's width is that along the column, whatever its pose; its edges are curved. A shaft's
    // is that square to its axis.
    let (factor, bias) = match largest.end_on {
        true => (1.0, end_on_bias(edges, largest.diameter_px)),
        false => (AxisSlope::of(edges).factor(largest.column_px.max(0.0) as usize), 0.0),
    };
    Some(LargestCaliper {
        diameter_px: factor * largest.diameter_px + bias,
        u_px: factor * largest.u_px.hypot(shared_u_px(edges)),
        u_own_px: factor * largest.u_px,
        u_noise_px: factor * largest.u_noise_px,
        ..largest
    })
}

/// The mean width of a few readings; `None` where none has both edges.
fn mean_of_readings(edges: &FrameEdges, size: impl Fn(usize, f64, f64) -> f64) -> Option<LargestCaliper> {
    let both: Reused<usize> = (0..edges.columns()).filter(|c| edges.width_px(*c).is_some()).collect();
    let (first, last) = (*both.first()?, *both.last()?);
    let n = both.len() as f64;
    let (mut sum, mut own) = (0.0, 0.0);
    for (top, bottom) in both.iter().map(|c| (&edges.top[*c], &edges.bottom[*c])) {
        own += f64::from(top.u_own_px).powi(2) + f64::from(bottom.u_own_px).powi(2);
    }
    for column in both.iter() {
        sum += size(*column, edges.top[*column].row_px, edges.bottom[*column].row_px);
    }
    let u_own_px = own.sqrt() / n;
    Some(LargestCaliper {
        diameter_px: sum / n,
        u_px: u_own_px.hypot(shared_u_px(edges)),
        u_own_px,
        u_noise_px: u_own_px,
        column_px: 0.5 * (first + last) as f64,
        stretch: (first, last),
        end_on: false,
        tangents: false,
    })
}

/// Whether the tangents lie farther apart than the largest width, beyond what noise explains.
fn rises_above(crests: &Largest, along: &Largest) -> bool {
    crests.value_px - along.value_px > CaliperLimits::get().apart * crests.u_px.hypot(along.u_px)
}

/// The largest width over stretches of the columns that have both edges.
fn widest(
    edges: &FrameEdges,
    widths: &[(f64, f64)],
    least: usize,
    size: impl Fn(usize, f64, f64) -> f64,
) -> Option<Largest> {
    let point = |&(x, width): &(f64, f64)| {
        let (top, bottom) = (&edges.top[x as usize], &edges.bottom[x as usize]);
        let noise = f64::from(top.u_own_px).hypot(f64::from(bottom.u_own_px));
        (x, size(x as usize, top.row_px, bottom.row_px), width, noise)
    };
    let line = Line::new(&widths.iter().map(point).collect::<Reused<_>>());
    line.largest(0..line.len(), least)
}

fn of_shaft(found: &Largest, tangents: bool) -> LargestCaliper {
    LargestCaliper {
        diameter_px: found.value_px,
        u_px: found.u_px,
        u_own_px: found.u_px,
        u_noise_px: found.u_noise_px,
        column_px: found.column_px,
        stretch: found.columns,
        end_on: false,
        tangents,
    }
}

/// Correction of a disc's diameter for the curvature of both edges, px.
fn end_on_bias(edges: &FrameEdges, diameter_px: f64) -> f64 {
    let sum: f64 = edges.figures.sigma_px.iter().map(|s| bias_per_curvature(*s)).sum();
    2.0 * sum / diameter_px
}

/// Root mean square of the shared uncertainties of the widths (levels, clipped light): it does not
/// average down over the columns.
fn shared_u_px(edges: &FrameEdges) -> f64 {
    let usable = edges.top.iter().zip(&edges.bottom).filter(|(t, b)| t.is_usable() && b.is_usable());
    let (sum, count) = usable.fold((0.0, 0.0_f64), |(sum, count), (top, bottom)| {
        (sum + f64::from(top.u_shared_px).powi(2) + f64::from(bottom.u_shared_px).powi(2), count + 1.0)
    });
    (sum / count.max(1.0)).sqrt()
}

/// Vertex of the robust parabola through w² around `centre`; `None` where the part is not round or
/// its vertex not seen.
fn vertex(widths: &[(f64, f64)], centre: f64, widest: f64) -> Option<LargestCaliper> {
    let limits = CaliperLimits::get();
    let reach = limits.vertex * widest;
    let mut centre = centre;
    let mut found = None;
    for _ in 0..3 {
        let near: Reused<(f64, f64)> = widths
            .iter()
            .filter(|w| (w.0 - centre).abs() <= reach)
            .map(|w| ((w.0 - centre) / reach, w.1 * w.1))
            .collect();
        let sides = (near.iter().any(|p| p.0 < -0.5), near.iter().any(|p| p.0 > 0.5));
        if near.len() < 24 || sides != (true, true) {
            return None;
        }
        let (p, u) = robust_parabola(&near)?;
        let curvature = -p[2] / (reach * reach);
        if !(limits.least_round..=limits.most_round).contains(&curvature) {
            return None;
        }
        let at = -0.5 * p[1] / p[2];
        let diameter_px = (p[0] + 0.5 * p[1] * at).max(0.0).sqrt();
        let u_px = u / (2.0 * diameter_px);
        found = Some(LargestCaliper {
            diameter_px,
            u_px,
            u_own_px: u_px,
            u_noise_px: u_px,
            column_px: centre + at * reach,
            stretch: (near_first(&near, centre, reach, -1.0), near_first(&near, centre, reach, 1.0)),
            end_on: true,
            tangents: false,
        });
        if at.abs() < 0.02 {
            break;
        }
        centre += at.clamp(-1.0, 1.0) * reach;
    }
    found
}

/// First (`side` −1) or last (1) column of points given as (column − centre)/reach.
fn near_first(near: &[(f64, f64)], centre: f64, reach: f64, side: f64) -> usize {
    let end = if side < 0.0 { near.first() } else { near.last() };
    end.map_or(0, |p| (centre + p.0 * reach).round().max(0.0) as usize)
}

/// Parabola by least squares with Tukey's weights; gives the coefficients and the standard
/// uncertainty at the middle.
fn robust_parabola(points: &[(f64, f64)]) -> Option<(nalgebra::Vector3<f64>, f64)> {
    let mut weights: Reused<f64> = points.iter().map(|_| 1.0).collect();
    let mut last = None;
    for _ in 0..8 {
        let mut fit = NormalEquations::new();
        for ((t, y), weight) in points.iter().zip(weights.iter()) {
            fit.add(nalgebra::Vector3::new(1.0, *t, t * t), *y, *weight);
        }
        let inverse = fit.normal.try_inverse()?;
        let p = inverse * fit.right;
        let residual = |t: f64, y: f64| y - (p[0] + p[1] * t + p[2] * t * t);
        let mut sizes: Reused<f64> = points.iter().map(|(t, y)| residual(*t, *y).abs()).collect();
        let scale = MEDIAN_TO_SD * upper_median(&mut sizes, f64::total_cmp)? + 1e-9;
        for ((t, y), weight) in points.iter().zip(weights.iter_mut()) {
            let q = residual(*t, *y) / (4.685 * scale);
            *weight = if q.abs() < 1.0 { (1.0 - q * q).powi(2) } else { 0.0 };
        }
        last = Some((p, scale * inverse[(0, 0)].sqrt()));
    }
    last
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauge::edges::{Edge, EdgeState};

    fn edges(width: impl Fn(f64) -> f64, columns: usize) -> FrameEdges {
        let edge = |row_px: f64| {
            if row_px.is_finite() {
                Edge { row_px, u_own_px: 0.01, u_shared_px: 0.0, chi2: 1.0, state: EdgeState::Good }
            } else {
                Edge::gap(crate::profile::Reason::NoEdge)
            }
        };
        let half = |c: usize| 0.5 * width(c as f64);
        FrameEdges {
            top: (0..columns).map(|c| edge(700.0 - half(c))).collect(),
            bottom: (0..columns).map(|c| edge(700.0 + half(c))).collect(),
            ..FrameEdges::default()
        }
    }

    #[test]
    fn a_disc_gives_its_diameter_and_a_speck_does_not_count() {
        let width = |c: f64| {
            2.0 * (500.25_f64.powi(2) - (c - 600.4).powi(2)).sqrt() + if c == 610.0 { 9.0 } else { 0.0 }
        };
        let found = largest_caliper(&edges(width, 1300)).unwrap();
        assert!(found.end_on);
        // Exact widths, from which the bias 2·(1/12)/2R of edges seen through pixels is taken.
        let unbiased_px = 1000.5 + 1.0 / (12.0 * 500.25);
        assert!((found.diameter_px - unbiased_px).abs() < 1e-6, "{}", found.diameter_px);
    }

    /// Where the lens swells the field's right end, the part is largest where it is, not where its
    /// image is.
    #[test]
    fn the_place_is_the_parts_the_width_the_images() {
        let image = |c: f64| 500.0 + 0.02 * c;
        let found = largest_caliper_where(&edges(image, 1000), 5, |c, top, bottom| {
            (bottom - top) / (1.0 + 1e-4 * c as f64)
        })
        .unwrap();
        assert!(!found.end_on && found.column_px < 40.0, "{found:?}");
        assert!((found.diameter_px - image(found.column_px)).abs() < 0.05, "{found:?}");
    }

    #[test]
    fn a_tapered_shaft_gives_its_thick_end() {
        let found = largest_caliper(&edges(|c| 500.0 + 0.01 * c, 1000)).unwrap();
        assert!(!found.end_on);
        assert!((found.diameter_px - 509.99).abs() < 1e-3 && found.column_px > 990.0, "{found:?}");
        assert!(largest_caliper(&edges(|_| f64::NAN, 10)).is_none());
    }
}
