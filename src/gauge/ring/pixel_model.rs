//! What one pixel adds to the fit of an edge: its model value with derivatives, and the sums of a
//! caliper's normal equations.

use nalgebra::{SMatrix, SVector};

use super::edge_fit::POOLED;
use super::edge_pixels::EdgePixel;
use super::model::Sample;
use crate::gauge::edge::model::shape_terms::{ShapeTerms, TERMS, term_border};
use crate::numerics::distributions::phi_pdf;

/// The pooled parameters and the amplitudes of the shape terms.
pub(super) const SHAPED: usize = POOLED + TERMS;
/// Place of the blur among the pooled parameters.
pub(super) const SIGMA: usize = 6;
pub(super) type Vector<const P: usize> = SVector<f64, P>;
pub(super) type Matrix<const P: usize> = SMatrix<f64, P, P>;

/// Sums of one caliper's equations.
pub(super) struct Sums<const P: usize> {
    pub(super) normal: Matrix<P>,
    pub(super) right: Vector<P>,
    pub(super) cross: Vector<P>,
    pub(super) own: f64,
    pub(super) own_right: f64,
    pub(super) chi2: f64,
    pub(super) pixels: f64,
    /// Pixels that no noise explains, which `chi2` and `pixels` leave out.
    pub(super) stray: usize,
    /// Change of `right` and of `own_right` by a relative change of the noise.
    pub(super) by_noise: (Vector<P>, f64),
}

impl<const P: usize> Sums<P> {
    /// Adds a pixel's part of the upper triangle of the normal equations, and of the rest.
    #[inline]
    pub(super) fn add(&mut self, by_pooled: &Vector<P>, by_shift: f64, (informed, weighted): (f64, f64)) {
        for j in 0..P {
            let by = informed * by_pooled[j];
            for i in 0..=j {
                self.normal[(i, j)] += by * by_pooled[i];
            }
            self.right[j] += weighted * by_pooled[j];
            self.cross[j] += by * by_shift;
        }
        self.own += informed * by_shift * by_shift;
        self.own_right += weighted * by_shift;
    }
}

/// A pixel's model value, its derivatives (pooled, shift), and its share of light; `e` is the edge
/// in it.
pub(super) fn model<const P: usize>(
    pixel: &EdgePixel,
    mut e: Sample,
    p: &Vector<P>,
    shift: f64,
    separated: Option<&ShapeTerms>,
) -> (f64, Vector<P>, f64, f64) {
    let (x, y) = (pixel.x, pixel.y);
    let dark = p[0] + p[1] * x + p[2] * y;
    let contrast = p[3] + p[4] * x + p[5] * y;
    let mut by_pooled = Vector::<P>::zeros();
    if let (SHAPED, Some(separated)) = (P, separated) {
        let terms = plain_terms(pixel.distance - shift, p[SIGMA]);
        for (k, term) in separated.at([e.by_distance, e.by_sigma], terms).into_iter().enumerate() {
            e.value += p[POOLED + k] * term;
            by_pooled[POOLED + k] = contrast * term;
        }
    }
    let seven = [1.0, x, y, e.value, e.value * x, e.value * y, contrast * e.by_sigma];
    by_pooled.iter_mut().zip(seven).for_each(|(by, value)| *by = value);
    (dark + contrast * e.value, by_pooled, -contrast * e.by_distance, e.value)
}

/// The shape terms in a pixel a distance from the edge.
pub(super) fn plain_terms(distance: f64, sigma: f64) -> [f64; TERMS] {
    let border = |u: f64| term_border(u, sigma, phi_pdf(u / sigma));
    let (up, down) = (border(distance + 0.5), border(distance - 0.5));
    [up[0] - down[0], up[1] - down[1]]
}
