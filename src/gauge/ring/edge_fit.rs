//! What a fit of a band around a contour gives: an edge, its calipers, and where a further fit of
//! the same edge may begin.

use crate::gauge::edge::model::shape_terms::TERMS;

/// B0, B1, B2, A0, A1, A2, σ.
pub(super) const POOLED: usize = 7;
/// Most parameters that calipers share: these and the amplitudes of the shape terms.
pub(in crate::gauge) const SHARED: usize = POOLED + TERMS;

/// One caliper's result.
#[derive(Clone, Copy, Debug)]
pub(in crate::gauge) struct Caliper {
    /// Shift of the edge towards the light, px.
    pub(in crate::gauge) shift: f64,
    /// Its standard uncertainty from noise, levels and blur, px.
    pub(in crate::gauge) u_shift: f64,
    /// The part of it that no other caliper shares, px.
    pub(in crate::gauge) u_own: f64,
    /// The part that all share, px: the covariance of two calipers is the product of their rows.
    pub(in crate::gauge) shared: [f64; SHARED],
    /// Σ(residual/σ_n)² over its pixels − 1.
    pub(in crate::gauge) reduced_chi2: f64,
    /// Whether it is usable.
    pub(in crate::gauge) good: bool,
    /// Where the grey values of a caliper that is refused cross the middle of the levels, px
    /// towards the light: the outline of a burr, which no model of one edge fits. `None` where they
    /// do not, and for a good caliper.
    pub(in crate::gauge) crossing: Option<f64>,
}

/// Where a fit begins that follows one of the same edge.
#[derive(Clone, Copy, Debug)]
pub(in crate::gauge) struct Begun {
    /// Levels of shadow and light over the field, and the blur.
    pub(super) pooled: [f64; POOLED],
    /// Noise.
    pub(super) variance: Variance,
}

/// A fitted edge.
#[derive(Clone, Debug)]
pub(in crate::gauge) struct EdgeFit {
    /// One a sector.
    pub(in crate::gauge) calipers: Vec<Caliper>,
    /// Blur, px.
    pub(in crate::gauge) sigma: f64,
    /// Mean levels of shadow and light, counts; the light's may lie above full scale, where it is
    /// clipped.
    pub(in crate::gauge) levels: (f64, f64),
    /// Standard uncertainty of the mean shift, pooled parameters free, px.
    pub(in crate::gauge) u_mean: f64,
    /// Standard deviation of the residuals at mid-edge, counts.
    pub(in crate::gauge) noise: f64,
    /// Root mean square at mid-edge of what the model leaves beyond noise, as a fraction of the
    /// contrast: noise alone is linear between shadow and light (photons), or less (gain).
    pub(in crate::gauge) misfit: f64,
    /// Where a further fit of the same edge may begin; `None` where light or shadow is clipped.
    pub(in crate::gauge) begun: Option<Begun>,
}

impl EdgeFit {
    /// Mean shift of the good calipers, px.
    pub(in crate::gauge) fn mean_shift(&self) -> f64 {
        let good = || self.calipers.iter().filter(|c| c.good);
        good().map(|c| c.shift).sum::<f64>() / good().count().max(1) as f64
    }
}

/// Noise variance over the share of light, linear between shadow, mid-edge and light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Variance(pub(super) [f64; 3]);

impl Variance {
    pub(super) fn at(&self, light: f64) -> f64 {
        let t = 2.0 * light.clamp(0.0, 1.0);
        let k = usize::from(t >= 1.0);
        self.0[k] + (self.0[k + 1] - self.0[k]) * (t - k as f64)
    }

    /// Standard deviation at mid-edge beyond what lies between shadow and light.
    pub(super) fn beyond_noise(&self) -> f64 {
        let [dark, middle, light] = self.0;
        (middle - 0.5 * (dark + light)).max(0.0).sqrt()
    }

    /// Whether its values are those of another within 1 %: weights that differ by so little move an
    /// edge by less than a hundredth of its u.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        self.0.iter().zip(other.0).all(|(a, b)| (a - b).abs() <= 0.01 * b)
    }
}
