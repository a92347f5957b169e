//! Thin edges through a lens with aberrations: tables over the place in the field and the distance
//! from the plane of focus.
//!
//! The image of an edge depends on its place by what the lens does to the path over the pupil
//! ([`PupilPath`]): how far the edge stands out into its own light from the middle of the field,
//! and how far along itself, where the sign does not count. Between the tables a cubic through four
//! in each direction; a change of the path by φ rad rms from table to table leaves 0.02 φ⁴.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::cylinder::half_shadow::lagrange;
use super::cylinder::image::{Limb, View, image};
use super::partial::PartiallyCoherentEdge;
use super::table::EdgeSpread;
use crate::render::error::{RenderError, within};
use crate::render::optics::lens::aberrations::{FieldAberrations, PupilPath};

/// Largest error of a table's interpolation, share of full intensity.
const TOLERANCE: f64 = 1e-5;

/// Tables across the field into the light, -1 to 1 half diagonals, and along the edge, 0 to 1: a
/// tenth of a wave of coma at the corner changes by 0.16 rad from one to the next.
const OUT: usize = 9;
const ALONG: usize = 5;

/// Change of the path by the distance from the plane of focus from table to table, rad rms.
const DEPTH_STEP: f64 = 0.2;

/// Root mean square of ρ² about its mean over the pupil.
const RMS_OF_SQUARE: f64 = 0.288_675_134_594_812_9;

/// Largest S: an integral over pupil and source agrees to 5e-4 of full light up to there (7.5e-4 at
/// S 3).
const WIDEST: f64 = 1.5;

/// Points of the cubics.
const POINTS: usize = 4;

/// Tables of one lens.
#[derive(Clone, Debug)]
pub(crate) struct FieldStack {
    /// Along the edge by out of the field by distance, the first the fastest.
    pub tables: Vec<EdgeSpread>,
    pub grid: FieldGrid,
}

/// What the tables stand for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FieldGrid {
    /// The distances go from minus to plus this, mm.
    depth_mm: f64,
    /// Their number; 1 or at least four.
    depths: usize,
}

/// The image of an edge at a place of the field, `out` into its light and `along` it from the
/// middle in half diagonals, `y_mm` nearer to the camera than the edge's own defocus.
///
/// # Errors
/// Values outside their ranges.
pub(crate) fn edge_in_field(
    edge: &PartiallyCoherentEdge,
    rows: &[FieldAberrations],
    place: [f64; 2],
    y_mm: f64,
) -> Result<EdgeSpread, RenderError> {
    edge.check()?;
    let reach_um = edge.reach * edge.unit_um();
    let one = |(wavelength_nm, share): (f64, f64)| {
        let view = View {
            na: edge.na,
            source_na: edge.na * edge.coherence_ratio,
            // Seen from the edge, the plane of focus lies behind where the edge is nearer.
            focus_mm: -(edge.defocus_mm + y_mm),
            reach_um,
            path: PupilPath::before_edge(rows, place, wavelength_nm),
        };
        (share, image(Limb::screen(wavelength_nm), &view, &[]))
    };
    let band: Vec<_> = edge.wavelengths().into_iter().map(one).collect();
    let table = EdgeSpread::tabulate(-reach_um, reach_um, TOLERANCE, |d| {
        band.iter().fold((0.0, 0.0), |(value, slope), (share, samples)| {
            let (v, s) = samples.at(d);
            (value + share * v, slope + share * s)
        })
    })?;
    edge.blurred(table, TOLERANCE)
}

/// Refuses light that the sum over the source is not made for.
///
/// # Errors
/// Names the key.
pub(crate) fn check_beside_aberrations(edge: &PartiallyCoherentEdge) -> Result<(), RenderError> {
    within("optics.esf.partially_coherent.numerical_aperture", edge.na, 1e-3, 0.2)?;
    within("optics.esf.partially_coherent.coherence_ratio", edge.coherence_ratio, 0.0, WIDEST)?;
    within("optics.esf.partially_coherent.reach", edge.reach, 4.0, 60.0)
}

impl FieldStack {
    /// Tables for edges anywhere in the field, up to `depth_mm` nearer and farther than the edge's
    /// own defocus.
    ///
    /// # Errors
    /// As [`edge_in_field`].
    pub(crate) fn new(
        edge: &PartiallyCoherentEdge,
        rows: &[FieldAberrations],
        depth_mm: f64,
    ) -> Result<Self, RenderError> {
        let grid = FieldGrid::new(edge, depth_mm);
        let tables = (0..grid.depths * OUT * ALONG)
            .into_par_iter()
            .map(|i| {
                let (place, y_mm) = grid.node(i);
                edge_in_field(edge, rows, place, y_mm)
            })
            .collect::<Result<_, _>>()?;
        Ok(Self { tables, grid })
    }
}

impl FieldGrid {
    fn new(edge: &PartiallyCoherentEdge, depth_mm: f64) -> Self {
        // W = y NA² ρ²/2 of an edge that is y out of focus.
        let phase = TAU * RMS_OF_SQUARE * depth_mm * 1e3 * edge.na / edge.unit_um();
        let depths = if depth_mm == 0.0 { 1 } else { ((phase / DEPTH_STEP).ceil() as usize + 1).max(POINTS) };
        Self { depth_mm, depths }
    }

    /// Place and distance of a table.
    fn node(&self, i: usize) -> ([f64; 2], f64) {
        let (along, out, depth) = (i % ALONG, i / ALONG % OUT, i / (ALONG * OUT));
        let share = |k: usize, count: usize| k as f64 / (count - 1).max(1) as f64;
        let y_mm =
            if self.depths == 1 { 0.0 } else { self.depth_mm * (2.0 * share(depth, self.depths) - 1.0) };
        ([2.0 * share(out, OUT) - 1.0, share(along, ALONG)], y_mm)
    }

    /// Tables and their shares at a place of the field and a distance.
    pub(crate) fn shares(&self, [out, along]: [f64; 2], y_mm: f64) -> Vec<(u32, f64)> {
        let last = |count: usize| (count - 1) as f64;
        let outs = cubic(0.5 * (out + 1.0) * last(OUT), OUT);
        let alongs = cubic(along.abs() * last(ALONG), ALONG);
        let depths = match self.depths {
            1 => vec![(0, 1.0)],
            n => cubic(0.5 * (y_mm / self.depth_mm + 1.0) * last(n), n),
        };
        let mut shares = Vec::with_capacity(depths.len() * outs.len() * alongs.len());
        for (d, of_depth) in &depths {
            for (o, of_out) in &outs {
                for (a, of_along) in &alongs {
                    shares.push((((d * OUT + o) * ALONG + a) as u32, of_depth * of_out * of_along));
                }
            }
        }
        shares
    }

    /// The table nearest to a place of the field and a distance.
    pub(crate) fn nearest(&self, [out, along]: [f64; 2], y_mm: f64) -> u32 {
        let at = |place: f64, count: usize| (place.clamp(0.0, 1.0) * (count - 1) as f64).round() as usize;
        let depth = if self.depths == 1 { 0 } else { at(0.5 * (y_mm / self.depth_mm + 1.0), self.depths) };
        ((depth * OUT + at(0.5 * (out + 1.0), OUT)) * ALONG + at(along.abs(), ALONG)) as u32
    }
}

/// Numbers and weights of the cubic through four of `count` even points, at a place in steps.
fn cubic(place: f64, count: usize) -> Vec<(usize, f64)> {
    let place = place.clamp(0.0, (count - 1) as f64);
    let first = (place as usize).saturating_sub(1).min(count - POINTS);
    let weights: [f64; POINTS] = lagrange(place - first as f64);
    weights.into_iter().enumerate().map(|(k, w)| (first + k, w)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lens() -> (PartiallyCoherentEdge, [FieldAberrations; 1]) {
        let edge = PartiallyCoherentEdge { reach: 6.0, ..PartiallyCoherentEdge::default() };
        (edge, [FieldAberrations { field: 1.0, spherical_nm: 20.0, coma_nm: 50.0, astigmatism_nm: 30.0 }])
    }

    #[test]
    fn between_the_tables_the_cubic_is_the_image_of_the_place() {
        let (edge, rows) = lens();
        let stack = FieldStack::new(&edge, &rows, 0.3).unwrap();
        for (place, y_mm) in [([0.55, -0.4], 0.17), ([-0.8, 0.1], -0.22), ([0.3, 0.9], 0.0)] {
            let wanted = edge_in_field(&edge, &rows, place, y_mm).unwrap();
            let shares = stack.grid.shares(place, y_mm);
            assert!((shares.iter().map(|(_, w)| w).sum::<f64>() - 1.0).abs() < 1e-12);
            for i in -40..=40 {
                let d = f64::from(i) * 2.0;
                let value = shares.iter().map(|(t, w)| w * stack.tables[*t as usize].value(d)).sum::<f64>();
                assert!((value - wanted.value(d)).abs() < 1e-4, "{place:?} {d}: {value} {}", wanted.value(d));
            }
        }
    }

    /// Without aberrations it is the edge that the spectrum gives, in and out of focus.
    #[test]
    fn a_perfect_lens_images_the_partially_coherent_edge() {
        for (ratio, defocus_mm) in [(0.5, 0.0), (0.8, 0.6), (1.0, -0.4), (1.5, 0.3)] {
            let edge = PartiallyCoherentEdge {
                coherence_ratio: ratio,
                defocus_mm,
                bandwidth_nm: 20.0,
                extra_sigma_um: 3.0,
                reach: 10.0,
                ..lens().0
            };
            let (own, seen) =
                (edge.edge_spread().unwrap(), edge_in_field(&edge, &[], [0.5, 0.5], 0.0).unwrap());
            for i in -50..=50 {
                let d = f64::from(i) * 2.0;
                assert!((own.value(d) - seen.value(d)).abs() < 3e-4, "{ratio} {defocus_mm} {d}");
            }
        }
    }
}
