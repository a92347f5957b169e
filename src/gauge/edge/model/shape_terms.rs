//! Departures of a real edge-spread function from the fitted one: skewness and kurtosis of its
//! line-spread function (Gram-Charlier series, ∫He₂φ and ∫He₃φ over the pixel).
//!
//! Each term is made orthogonal to position and blur of an edge that is seen whole: its amplitude
//! does not move an edge that is not clipped. Where part of an edge is clipped, the amplitudes,
//! with a prior standard uncertainty of [`ShapeTermLimits::amplitude`], give the shift of the edge
//! by its unseen part.

use nalgebra::{Matrix2, Vector2};

use crate::gauge::limit::limits;

limits! {
    /// How far a lens is taken to depart from its edge model where that is not seen.
    ShapeTermLimits = "shape_terms";
    /// Prior standard deviation of the amplitudes, shares of the contrast; skewness is 6 and excess
    /// kurtosis 24 times as much. It determines the uncertainty of a width in light of 1.5 times
    /// the clip, 0.1 px at a blur of 1 px. Tuned: see study limits.
    amplitude: f64 = 0.0075;
}

/// Number of terms.
pub(crate) const TERMS: usize = 2;

/// A sample of an edge: ∂E/∂x (or by distance), ∂E/∂σ, the plain terms, weight.
pub(crate) type Sampled = ([f64; 2], [f64; TERMS], f64);

/// The terms, orthogonal to position and blur.
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
