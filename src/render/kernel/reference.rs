//! The reference: a noise-free frame in f64, sharing no function with the kernels that are compared
//! with it.
//!
//! Gaussian blur separates, so for light above an edge e(x) of any shape the light on a pixel is
//! exactly
//!
//! ```text
//! I(x, y) = ∫ K(x - x') · B(e(x') - y) dx'
//! K(t) = Φ((t + 1/2)/σ) - Φ((t - 1/2)/σ)               box ∗ Gaussian along the row
//! B(u) = G(u + 1/2) - G(u - 1/2)                       box ∗ Gaussian step down the column
//! G(u) = u Φ(u/σ) + σ φ(u/σ)
//! ```
//!
//! The integral is a trapezoidal sum at σ/4: for smooth edges its error falls as exp(-2π²·16). Φ is
//! libm's erf.

use std::f64::consts::{PI, SQRT_2};

use crate::render::optics::edge_spread::EdgeSpread;

/// Distance, in σ beyond the pixel, at which Gaussians are cut: Φ(-7) = 1e-12.
const REACH_SIGMA: f64 = 7.0;

/// A straight or curved Gaussian edge pair, pixel by pixel in f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GaussianReference {
    /// Blur, px.
    pub sigma_px: f64,
    /// Grey value of the shadow.
    pub shadow: f64,
    /// Grey value of the bright field.
    pub bright: f64,
}

impl GaussianReference {
    /// Grey values of a frame, row-major; `edges(x)` returns the rows of both edges at a fractional
    /// column.
    pub(crate) fn frame(&self, rows: usize, columns: usize, edges: impl Fn(f64) -> [f64; 2]) -> Vec<f64> {
        self.lit_frame(rows, columns, edges, |_, _| 1.0)
    }

    /// [`Self::frame`] where the light is not even: `factor(row, column)` multiplies the light
    /// above the shadow.
    pub(crate) fn lit_frame(
        &self,
        rows: usize,
        columns: usize,
        edges: impl Fn(f64) -> [f64; 2],
        factor: impl Fn(usize, usize) -> f64,
    ) -> Vec<f64> {
        let offsets = self.trapezoid(self.sigma_px / 4.0);
        self.integrated([rows, columns], |_| offsets.clone(), edges, factor)
    }

    /// [`Self::frame`] for edges with corners: Simpson's rule at σ/8 between the columns given,
    /// ascending, at which `edges` may jump or bend.
    pub(crate) fn frame_between(
        &self,
        rows: usize,
        columns: usize,
        corners: &[f64],
        edges: impl Fn(f64) -> [f64; 2],
    ) -> Vec<f64> {
        let reach = REACH_SIGMA * self.sigma_px + 0.5;
        let nodes = |column: f64| {
            let inner = corners.iter().map(|c| c - column).filter(|t| t.abs() < reach);
            let ends: Vec<f64> = [-reach].into_iter().chain(inner).chain([reach]).collect();
            ends.windows(2).flat_map(|e| simpson(e[0], e[1], self.sigma_px / 8.0)).collect()
        };
        self.integrated([rows, columns], nodes, edges, |_, _| 1.0)
    }

    /// [`Self::frame`] at another step of the trapezoidal sum, px: the error is proportional to its
    /// square at a bend of the edge, to itself at a jump.
    pub(crate) fn frame_at(
        &self,
        rows: usize,
        columns: usize,
        step: f64,
        edges: impl Fn(f64) -> [f64; 2],
    ) -> Vec<f64> {
        let offsets = self.trapezoid(step);
        self.integrated([rows, columns], |_| offsets.clone(), edges, |_, _| 1.0)
    }

    fn trapezoid(&self, step: f64) -> Vec<(f64, f64)> {
        let reach = (REACH_SIGMA * self.sigma_px + 0.5) / step;
        (-(reach.ceil() as i64)..=reach.ceil() as i64).map(|i| (i as f64 * step, step)).collect()
    }

    fn integrated(
        &self,
        [rows, columns]: [usize; 2],
        nodes: impl Fn(f64) -> Vec<(f64, f64)>,
        edges: impl Fn(f64) -> [f64; 2],
        factor: impl Fn(usize, usize) -> f64,
    ) -> Vec<f64> {
        let mut out = vec![0.0; rows * columns];
        for column in 0..columns {
            let nearby: Vec<([f64; 2], f64)> = nodes(column as f64)
                .into_iter()
                .map(|(t, w)| (edges(column as f64 + t), self.along(t) * w))
                .collect();
            for row in 0..rows {
                let light: f64 = nearby
                    .iter()
                    .map(|([top, bottom], w)| {
                        w * (self.down(top - row as f64) + self.down(row as f64 - bottom))
                    })
                    .sum();
                out[row * columns + column] =
                    self.shadow + (self.bright - self.shadow) * light * factor(row, column);
            }
        }
        out
    }

    /// K: the row's share of the pixel.
    fn along(&self, t: f64) -> f64 {
        phi((t + 0.5) / self.sigma_px) - phi((t - 0.5) / self.sigma_px)
    }

    /// B: light passing a level edge at distance u above the pixel's centre.
    fn down(&self, u: f64) -> f64 {
        let far = REACH_SIGMA * self.sigma_px + 0.5;
        if u > far {
            return 1.0;
        }
        if u < -far {
            return 0.0;
        }
        self.step(u + 0.5) - self.step(u - 0.5)
    }

    /// G: integral of the blurred step.
    fn step(&self, u: f64) -> f64 {
        let v = u / self.sigma_px;
        u * phi(v) + self.sigma_px * (-0.5 * v * v).exp() / (2.0 * PI).sqrt()
    }
}

/// Straight edges of any family: F over the distance to the line, integrated over the pixel's
/// square by the closed form in the table's second integral ([`EdgeSpread::over_pixel`]); the
/// kernels use quadrature nodes over the pixel instead.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StraightReference<'a> {
    /// The edge spread.
    pub esf: &'a EdgeSpread,
    /// Size of a pixel on the object, µm.
    pub pixel_um: f64,
}

impl StraightReference<'_> {
    /// Light on a pixel whose centre lies `above_px` rows above an edge of slope tan β = `slope`,
    /// light above the edge.
    pub(crate) fn light(&self, above_px: f64, slope: f64) -> f64 {
        let distance_um = above_px / slope.hypot(1.0) * self.pixel_um;
        self.esf.over_pixel(distance_um, self.pixel_um, slope.atan())
    }
}

/// Simpson's rule between two corners, its ends moved in by 1e-9.
fn simpson(low: f64, high: f64, step: f64) -> Vec<(f64, f64)> {
    let (low, high) = (low + 1e-9, high - 1e-9);
    if high <= low {
        return Vec::new();
    }
    let count = 2 * ((high - low) / (2.0 * step)).ceil().max(1.0) as usize;
    let h = (high - low) / count as f64;
    (0..=count)
        .map(|i| (low + i as f64 * h, if i == 0 || i == count { 1.0 } else { [2.0, 4.0][i % 2] } * h / 3.0))
        .collect()
}

fn phi(v: f64) -> f64 {
    0.5 * (1.0 + libm::erf(v / SQRT_2))
}
