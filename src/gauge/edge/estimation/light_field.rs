//! Light that is not even around a small part: the logarithm of the contrast as a quadratic over
//! the frame.
//!
//! ```text
//! ln C(x, y) = p0 + p1 x + p2 y + p3 x² + p4 xy + p5 y²
//! exact for light that falls exponentially and for Gaussian spots
//! ```
//!
//! Least squares on the light beside the part, residuals beyond three standard deviations counting
//! by their size only (Huber). A wire's or a disc's own pixels are divided by it: their edges are
//! then those of even light.

use nalgebra::{Matrix6, Vector6};

use crate::gauge::limit::limits;
use crate::numerics::robust::{MEDIAN_TO_SD, median_of};

limits! {
    /// From which pixels the field of the light is estimated, and when it is one.
    LightFieldLimits = "light_field";
    /// Fewest pixels of light that show a field: 33 for each of its six parameters.
    least_pixels: usize = 200;
    /// Contrast below which a pixel is not light but contamination or another part, as a fraction
    /// of the median. Tuned: see study limits.
    least_contrast: f64 = 0.15;
    /// Residuals beyond so many standard deviations count by their size only (P. J. Huber, Ann.
    /// Math. Statist. 35 (1964) 73): noise alone is damped in 0.27 % of the pixels.
    huber: f64 = 3.0;
    /// Rounds of the reweighted fit. Tuned: see study limits.
    rounds: usize = 4;
    /// Scatter of the field over the pixels from which light is uneven, in standard deviations of
    /// what noise makes of even light: χ² of the field's five terms is then 36 times its
    /// expectation of 5, which noise alone does not reach. Tuned: see study limits.
    plain: f64 = 6.0;
    /// The same as a share of the light: a light even to half a percent moves an edge by some
    /// thousandths of a pixel.
    least_spread: f64 = 0.005;
    /// Scatter about the field over that of neighbouring pixels up to which the light is smooth,
    /// beside `smooth_share`. Tuned: see study limits.
    smooth: f64 = 1.5;
    /// Scatter about the field beyond that of neighbouring pixels, as a share of the contrast, that
    /// smooth light may have: light that falls linearly is no quadratic of the logarithm.
    smooth_share: f64 = 0.01;
}

/// A pixel of light: its place and its grey value above the shadow's, counts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lit {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) contrast: f64,
}

/// A pixel beside the field, counts.
struct Departure {
    /// The field's contrast there.
    expected: f64,
    /// The pixel's less that.
    residual: f64,
}

/// Sums of the normal equations of a quadratic: Σ w·xⁱyʲ, by powers (i, j) of degrees 0 to 4, and
/// Σ w·v·xⁱyʲ of a value v, of which the first six are the field's terms.
#[derive(Default)]
struct Moments {
    of: [f64; 15],
    value: [f64; 6],
}

impl Moments {
    #[inline]
    fn add(&mut self, x: f64, y: f64, value: f64, weight: f64) {
        let (xx, xy, yy) = (x * x, x * y, y * y);
        let second = [1.0, x, y, xx, xy, yy];
        let higher = [xx * x, xx * y, x * yy, yy * y, xx * xx, xx * xy, xx * yy, xy * yy, yy * yy];
        let terms = second.iter().chain(&higher);
        self.of.iter_mut().zip(terms).for_each(|(sum, term)| *sum += weight * term);
        let weighted = weight * value;
        self.value.iter_mut().zip(second).for_each(|(sum, term)| *sum += weighted * term);
    }

    /// The coefficients; `None` where the points do not determine them.
    fn solved(&self) -> Option<Vector6<f64>> {
        let mut all = (0..5).flat_map(|degree| (0..=degree).map(move |y| (degree - y, y)));
        let powers: [(usize, usize); 15] = std::array::from_fn(|_| all.next().unwrap_or((0, 0)));
        let product = |i: usize, k: usize| {
            let (a, b) = (powers[i], powers[k]);
            let of_both = (a.0 + b.0, a.1 + b.1);
            powers.iter().zip(self.of).find(|(p, _)| **p == of_both).map_or(0.0, |(_, sum)| sum)
        };
        Some(Matrix6::from_fn(product).cholesky()?.solve(&Vector6::from(self.value)))
    }
}

/// A light that is not even.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightField {
    centre: (f64, f64),
    scale: f64,
    by: Vector6<f64>,
}

impl LightField {
    /// From pixels of light in the order of lines; `None` where the light is even, or not smooth.
    pub(crate) fn fit(points: &[Lit]) -> Option<Self> {
        let limits = LightFieldLimits::get();
        let usual = median_of(points.iter().map(|p| p.contrast).collect());
        if !(usual > 0.0) {
            return None;
        }
        let points: Vec<Lit> =
            points.iter().copied().filter(|p| p.contrast > limits.least_contrast * usual).collect();
        if points.len() < limits.least_pixels {
            return None;
        }
        let n = points.len() as f64;
        let mean = |of: &dyn Fn(&Lit) -> f64| points.iter().map(of).sum::<f64>() / n;
        let centre = (mean(&|p| p.x), mean(&|p| p.y));
        let scale = mean(&|p| (p.x - centre.0).powi(2) + (p.y - centre.1).powi(2)).sqrt().max(1.0);
        let mut field = Self { centre, scale, by: Vector6::zeros() };
        field.by[0] = usual.ln();
        let logs: Vec<f64> = points.iter().map(|p| p.contrast.ln()).collect();
        let mut noise = f64::INFINITY;
        let mut departures: Vec<Departure> = field.departures(&points, &logs).collect();
        for _ in 0..limits.rounds {
            let mut fit = Moments::default();
            for ((p, log), at) in points.iter().zip(&logs).zip(&departures) {
                // A residual of the logarithm weighs by the contrast's square, near the field's
                // own.
                let damped = (limits.huber * noise / at.residual.abs().max(1e-12)).min(1.0);
                let (x, y) = field.place(p.x, p.y);
                fit.add(x, y, *log, at.expected.powi(2) * damped);
            }
            field.by = fit.solved()?;
            departures.clear();
            departures.extend(field.departures(&points, &logs));
            noise = MEDIAN_TO_SD * median_of(departures.iter().map(|at| at.residual.abs()).collect());
        }
        (field.is_uneven(&points, noise) && is_smooth(&points, noise, usual)).then_some(field)
    }

    /// A place from the field's centre, in its scale.
    fn place(&self, x: f64, y: f64) -> (f64, f64) {
        ((x - self.centre.0) / self.scale, (y - self.centre.1) / self.scale)
    }

    fn terms(&self, x: f64, y: f64) -> Vector6<f64> {
        let (x, y) = self.place(x, y);
        Vector6::new(1.0, x, y, x * x, x * y, y * y)
    }

    /// What the field has at each pixel, and how far the pixel is from it; `logs` are those of the
    /// pixels' contrasts.
    fn departures(&self, points: &[Lit], logs: &[f64]) -> impl Iterator<Item = Departure> {
        points.iter().zip(logs).map(|(p, own)| {
            let log = self.terms(p.x, p.y).dot(&self.by);
            let expected = log.exp();
            Departure { expected, residual: (own - log) * expected }
        })
    }

    fn is_uneven(&self, points: &[Lit], noise: f64) -> bool {
        let LightFieldLimits { plain, least_spread, .. } = *LightFieldLimits::get();
        let n = points.len() as f64;
        let logs: Vec<f64> = points.iter().map(|p| self.terms(p.x, p.y).dot(&self.by)).collect();
        let mean = logs.iter().sum::<f64>() / n;
        let spread = (logs.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / n).sqrt();
        spread > (plain * noise / mean.exp() * (5.0 / n).sqrt()).max(least_spread)
    }

    /// Light at a place over that at the field's centre.
    pub(crate) fn relative(&self, x: f64, y: f64) -> f64 {
        (self.terms(x, y).dot(&self.by) - self.by[0]).exp()
    }
}

/// Whether the residual of the field is little more than the scatter of neighbouring pixels.
fn is_smooth(points: &[Lit], noise: f64, usual: f64) -> bool {
    let LightFieldLimits { smooth, smooth_share, .. } = *LightFieldLimits::get();
    let beside = points.windows(2).filter(|w| (w[0].x - w[1].x).hypot(w[0].y - w[1].y) < 1.5);
    let scatter = median_of(beside.map(|w| (w[0].contrast - w[1].contrast).abs()).collect());
    let scatter = if scatter.is_nan() { 0.0 } else { MEDIAN_TO_SD * scatter / std::f64::consts::SQRT_2 };
    noise <= smooth * scatter + smooth_share * usual
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(of: impl Fn(f64, f64) -> f64) -> Vec<Lit> {
        let all = (0..60).flat_map(|y| (0..80).map(move |x| (f64::from(x), f64::from(y))));
        // Pseudo-random noise of ± 1 count.
        let noise = |x: f64, y: f64| 2.0 * (0.618_034 * (x * 37.0 + y * 101.0)).fract() - 1.0;
        let beside = all.filter(|(_, y)| !(20.0..40.0).contains(y));
        beside.map(|(x, y)| Lit { x, y, contrast: of(x, y) + noise(x, y) }).collect()
    }

    #[test]
    fn spots_and_exponential_light_are_met_between_the_pixels_seen() {
        type Field = fn(f64, f64) -> f64;
        let fields: [Field; 3] = [
            |_, y| 180.0 * (-y / 50.0).exp(),
            |x, y| 150.0 * (-((x - 30.0).powi(2) + (y - 25.0).powi(2)) / 2500.0).exp(),
            |x, y| 170.0 - 1.2 * x - 0.7 * y,
        ];
        for (k, of) in fields.into_iter().enumerate() {
            let field = LightField::fit(&light(of)).unwrap();
            for (x, y) in [(40.0, 24.0), (10.0, 30.0), (70.0, 36.0)] {
                let (found, right) =
                    (field.relative(x, y) / field.relative(40.0, 15.0), of(x, y) / of(40.0, 15.0));
                let most = if k == 2 { 0.02 } else { 0.003 };
                assert!((found / right - 1.0).abs() < most, "field {k} at {x}, {y}: {found} {right}");
            }
        }
    }

    #[test]
    fn even_light_and_light_with_structure_are_no_field() {
        assert!(LightField::fit(&light(|_, _| 150.0)).is_none());
        let striped = |x: f64, y: f64| 150.0 - 0.5 * x + 25.0 * (0.7 * y).sin() + 25.0 * (0.5 * x).cos();
        assert!(LightField::fit(&light(striped)).is_none());
    }
}
