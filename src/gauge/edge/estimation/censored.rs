//! A grey value that is censored at the ends of the scale (Tobin's model).
//!
//! The measurement of a pixel between the ends is its grey value, that of one at an end only that
//! the light lies beyond. With α = (end − μ)/s the scores by the mean μ are (m − μ)/s² between the
//! ends and h(α)/s at the upper end, h = φ/(1 − Φ) (hazard), and the expected information of a
//! pixel is [Φ(α) − α φ(α) + φ(α) h(α)]/s²; at the lower end with the signs reversed.

use crate::numerics::distributions::{phi_cdf, phi_pdf};

/// Ends of the grey scale, counts; infinite where nothing is clipped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ends {
    /// Grey values here or below are clipped.
    pub(crate) low: f64,
    /// Grey values here or above are clipped.
    pub(crate) high: f64,
    /// Distance of two grey values, counts; 0 where they are continuous.
    pub(crate) step: f64,
}

impl Ends {
    /// A scale without ends.
    pub(crate) const NONE: Self = Self { low: f64::NEG_INFINITY, high: f64::INFINITY, step: 0.0 };

    /// Whether the light is clipped.
    pub(crate) fn is_high(self) -> bool {
        self.high.is_finite()
    }

    /// From the ends found in the dark and in the light, each with the distance of two grey values;
    /// `None` where neither was.
    pub(crate) fn of(low: Option<(f32, f64)>, high: Option<(f32, f64)>) -> Option<Self> {
        let step = low.or(high)?.1;
        let at = |end: Option<(f32, f64)>, none: f64| end.map_or(none, |(value, _)| f64::from(value));
        Some(Self { low: at(low, f64::NEG_INFINITY), high: at(high, f64::INFINITY), step })
    }
}

/// Score of the mean of a pixel, in units of its standard deviation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Censored {
    /// Score by the mean.
    pub(crate) residual: f64,
    /// Expected information on the mean.
    pub(crate) information: f64,
    /// Whether the grey value lies between the ends.
    pub(crate) between: bool,
    /// Expected square of the residual over the pixels between the ends.
    pub(crate) expected: f64,
    /// Expected change of the score by a relative change of the standard deviation s: of E ∂/∂ln s,
    /// 2φ(α) come from the pixels between and −φ(α) − αφ(α)(h − α) from those at the upper end, the
    /// negative at the lower one.
    pub(crate) by_noise: f64,
}

/// Distance of the mean beyond an end, standard deviations, from which a pixel at that end carries
/// no information: its score is below 1e-8.
const FAR_BEYOND: f64 = 6.0;

impl Censored {
    /// A grey value `m` of mean `mean` and standard deviation `s`, counts.
    pub(crate) fn new(m: f64, mean: f64, s: f64, ends: Ends) -> Self {
        let Ends { low, high, .. } = ends;
        // Distances to both ends, positive inside the scale.
        let inside = Self::inside(mean, s, ends);
        if (m >= high && inside[0] < -FAR_BEYOND) || (m <= low && inside[1] < -FAR_BEYOND) {
            return Self { residual: 0.0, information: 0.0, between: false, expected: 0.0, by_noise: 0.0 };
        }
        let (mut information, mut expected, mut by_noise) = (1.0, 1.0, 0.0);
        let mut hazards = inside;
        for ((alpha, hazard), sign) in inside.into_iter().zip(&mut hazards).zip([1.0, -1.0]) {
            if alpha < 8.0 {
                let (outside, pdf) = (phi_cdf(-alpha), phi_pdf(alpha));
                // Far inside the hazard is α (Mills' ratio).
                *hazard = if alpha < 6.0 { pdf / outside } else { alpha };
                information -= (outside + alpha * pdf - pdf * *hazard).clamp(0.0, 1.0);
                expected -= (outside + alpha * pdf).clamp(0.0, 1.0);
                by_noise += sign * pdf * (1.0 - alpha * (*hazard - alpha));
            }
        }
        let (residual, between) = if m >= high {
            (hazards[0], false)
        } else if m <= low {
            (-hazards[1], false)
        } else {
            ((m - mean) / s, true)
        };
        let information = information.max(0.0);
        Self { residual, information, between, expected: expected.max(0.0), by_noise }
    }

    /// Distances of the mean to the upper and the lower end, standard deviations, positive inside
    /// the scale.
    fn inside(mean: f64, s: f64, Ends { low, high, step }: Ends) -> [f64; 2] {
        [(high - 0.5 * step - mean) / s, (mean - low - 0.5 * step) / s]
    }

    /// Logarithm of the likelihood of a grey value `m` of mean `mean` and standard deviation `s`,
    /// counts.
    pub(crate) fn log_likelihood(m: f64, mean: f64, s: f64, ends: Ends) -> f64 {
        let inside = Self::inside(mean, s, ends);
        let tail = |alpha: f64| phi_cdf(-alpha).max(1e-300).ln();
        if m >= ends.high {
            tail(inside[0])
        } else if m <= ends.low {
            tail(inside[1])
        } else {
            -0.5 * ((m - mean) / s).powi(2) - s.ln()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Score and information by sums over all grey values of a scale with two ends: the mean score
    /// is 0, its variance is the information, and the mean square between the ends is what is
    /// expected.
    #[test]
    fn scores_average_to_nothing_and_their_variance_is_the_information() {
        let (s, ends) = (2.5, Ends { low: 0.0, high: 20.0, step: 0.0 });
        for mean in [-3.0, 0.5, 10.0, 19.0, 24.0] {
            let n = 200_000;
            let (mut score, mut square, mut between) = (0.0, 0.0, 0.0);
            let (mut information, mut moved) = (0.0, 0.0);
            for k in 0..n {
                let t = -8.0 + 16.0 * (f64::from(k) + 0.5) / f64::from(n);
                let weight = phi_pdf(t) * 16.0 / f64::from(n);
                let grey = (mean + s * t).clamp(ends.low, ends.high);
                let c = Censored::new(grey, mean, s, ends);
                score += weight * c.residual;
                square += weight * c.residual * c.residual;
                between += if c.between { weight * c.residual * c.residual } else { 0.0 };
                information = c.information;
                // The score by the mean is the residual over s.
                let wider = |by: f64| Censored::new(grey, mean, s * by, ends).residual / by;
                moved += weight * (wider(1.0 + 1e-4) - wider(1.0 - 1e-4)) / 2e-4;
                assert!((c.expected - Censored::new(10.0, mean, s, ends).expected).abs() < 1e-12);
            }
            let Censored { expected, by_noise, .. } = Censored::new(10.0, mean, s, ends);
            assert!((moved - by_noise).abs() < 2e-3, "{mean}: {moved} {by_noise}");
            assert!(score.abs() < 2e-4, "{mean}: {score}");
            assert!((square - information).abs() < 2e-3, "{mean}: {square} {information}");
            assert!((between - expected).abs() < 2e-3, "{mean}: {between} {expected}");
        }
    }
}
