//! What a real edge-spread function may have that the fitted one has not: skewness and kurtosis of its line-spread function (the
//! series of Gram and Charlier, ∫He₂φ and ∫He₃φ over the pixel).
//!
//! Of each term the part is taken off that place and blur of an edge that is seen whole would follow: an amplitude moves no edge
//! that is not clipped. Where part of an edge is clipped the amplitudes, known to [`AMPLITUDE`] beforehand, state what its unseen part may
//! have moved the edge by.

use nalgebra::{Matrix2, Vector2};

/// Number of terms.
pub(crate) const TERMS: usize = 2;
/// Standard deviation of the amplitudes where nothing is known of them; skewness is 6 and excess kurtosis 24 times as much. The value
/// decides what light of 1.5 times the clip leaves open of a width, 0.1 px at a blur of 1 px.
pub(crate) const AMPLITUDE: f64 = 0.0075;

/// A sample of an edge: ∂E/∂x (or by distance), ∂E/∂σ, the plain terms, weight.
pub(crate) type Sampled = ([f64; 2], [f64; TERMS], f64);

/// The terms with what place and blur would follow taken off.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ShapeTerms {
    taken_off: [[f64; 2]; TERMS],
}

impl ShapeTerms {
    /// From samples of an edge seen whole.
    pub(crate) fn separate(samples: impl Iterator<Item = Sampled>) -> Self {
        let (mut normal, mut right) = (Matrix2::<f64>::zeros(), [Vector2::<f64>::zeros(); TERMS]);
        for (by, terms, weight) in samples {
            let by = Vector2::from(by);
            normal += by * by.transpose() * weight;
            for (right, term) in right.iter_mut().zip(terms) {
                *right += by * (term * weight);
            }
        }
        let taken_off = normal.try_inverse().map(|inverse| right.map(|right| (inverse * right).into()));
        Self { taken_off: taken_off.unwrap_or_default() }
    }

    /// The separated terms where the edge's derivatives are `by` and the plain terms `plain`.
    #[inline]
    pub(crate) fn at(&self, by: [f64; 2], plain: [f64; TERMS]) -> [f64; TERMS] {
        let mut terms = plain;
        for (term, taken_off) in terms.iter_mut().zip(&self.taken_off) {
            *term -= taken_off[0] * by[0] + taken_off[1] * by[1];
        }
        terms
    }
}

/// Antiderivatives of the plain terms at a border of pixels `u` px from the edge, with φ(u/σ).
#[inline]
pub(crate) fn term_border(u: f64, sigma: f64, pdf: f64) -> [f64; TERMS] {
    let t = u / sigma;
    let density = sigma * pdf;
    [-density * t, -density * (t * t - 1.0)]
}
