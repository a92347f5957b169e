//! Positions of the edge: a distribution of shifts with weights.
//!
//! During an exposure the edge moves; an extended source projects it from many directions; a
//! reflecting strip adds a second edge. The light is the mean over all of them, F̄(d) = Σ w_i F(d -
//! s_i). Smooth distributions are represented by suitable quadrature nodes: a box as
//! Gauss-Legendre, an arcsine as Chebyshev nodes of the first kind, a disc as those of the second
//! kind, a Gaussian as the trapezoidal rule, which converges faster than any power there.

use std::f64::consts::PI;

#[cfg(test)]
use super::quadrature::gauss_legendre;

/// Reach of the trapezoidal rule over a Gaussian, standard deviations: the rest weighs 4e-10.
const GAUSSIAN_REACH: f64 = 6.25;

/// Shifts of the edge towards the light, µm, and their weights.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Shifts {
    nodes: Vec<(f64, f64)>,
}

impl Shifts {
    /// Shifts (µm, positive moves the edge into the light) with weights, which are scaled to add up
    /// to one.
    pub(crate) fn new(nodes: Vec<(f64, f64)>) -> Self {
        let sum: f64 = nodes.iter().map(|(_, w)| w).sum();
        if nodes.is_empty() || sum == 0.0 {
            return Self::none();
        }
        Self { nodes: nodes.into_iter().map(|(s, w)| (s, w / sum)).collect() }
    }

    /// An edge at rest.
    pub(crate) fn none() -> Self {
        Self { nodes: vec![(0.0, 1.0)] }
    }

    /// Uniform over ±`width_um`/2: steady motion.
    #[cfg(test)]
    pub(crate) fn uniform(width_um: f64, nodes: usize) -> Self {
        Self::new(gauss_legendre(nodes.max(1)).iter().map(|(x, w)| (0.5 * width_um * x, *w)).collect())
    }

    /// Arcsine over ±`amplitude_um`: many periods of a sinusoidal vibration.
    pub(crate) fn arcsine(amplitude_um: f64, nodes: usize) -> Self {
        let n = nodes.max(1);
        Self::new((0..n).map(|i| (amplitude_um * (PI * (i as f64 + 0.5) / n as f64).cos(), 1.0)).collect())
    }

    /// A uniform disc of radius `radius_um` projected on the normal: a round source out of focus.
    pub(crate) fn disc(radius_um: f64, nodes: usize) -> Self {
        let n = nodes.max(1) as f64;
        let node = |i: usize| {
            let angle = PI * (i as f64 + 1.0) / (n + 1.0);
            (radius_um * angle.cos(), angle.sin().powi(2))
        };
        Self::new((0..nodes.max(1)).map(node).collect())
    }

    /// Normal with standard deviation `sigma_um`.
    pub(crate) fn gaussian(sigma_um: f64, nodes: usize) -> Self {
        let n = nodes.max(3);
        let node = |i: usize| {
            let u = GAUSSIAN_REACH * (2.0 * i as f64 / (n - 1) as f64 - 1.0);
            (sigma_um * u, (-0.5 * u * u).exp())
        };
        Self::new((0..n).map(node).collect())
    }

    /// The convolution with another distribution.
    #[must_use]
    pub(crate) fn folded(&self, other: &Self) -> Self {
        let pairs = |(s, w): &(f64, f64)| {
            let (s, w) = (*s, *w);
            other.nodes.iter().map(move |(t, v)| (s + t, w * v))
        };
        Self::new(self.nodes.iter().flat_map(pairs).collect())
    }

    /// The same distribution about its mean.
    #[must_use]
    #[cfg(test)]
    pub(crate) fn centred(&self) -> Self {
        let mean = self.mean_um();
        Self { nodes: self.nodes.iter().map(|(s, w)| (s - mean, *w)).collect() }
    }

    /// Shifts (µm) and weights.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.nodes.iter().copied()
    }

    /// Mean shift, µm.
    #[cfg(test)]
    pub(crate) fn mean_um(&self) -> f64 {
        self.nodes.iter().map(|(s, w)| s * w).sum()
    }

    /// Variance about the mean, µm²: the equivalent increase of a Gaussian blur's variance.
    #[cfg(test)]
    pub(crate) fn variance_um2(&self) -> f64 {
        let mean = self.mean_um();
        self.nodes.iter().map(|(s, w)| w * (s - mean).powi(2)).sum()
    }

    /// Smallest and largest shift, µm.
    pub(crate) fn range_um(&self) -> (f64, f64) {
        self.nodes
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (s, _)| (low.min(*s), high.max(*s)))
    }
}
