//! The standard normal, Student's and the χ² distribution: functions, density, quantiles.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// Standard normal distribution function.
pub(crate) fn phi_cdf(t: f64) -> f64 {
    0.5 * libm::erfc(-t * FRAC_1_SQRT_2)
}

/// Standard normal density.
pub(crate) fn phi_pdf(t: f64) -> f64 {
    (-0.5 * t * t).exp() / (2.0 * PI).sqrt()
}

/// Student's t for a two-sided probability.
pub(crate) fn student(freedom: f64, probability: f64) -> f64 {
    if freedom > 1e5 {
        // Student's t agrees with the normal distribution to 1e-5 there.
        return Normal::standard().inverse_cdf(0.5 + 0.5 * probability);
    }
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::NAN, |t| t.inverse_cdf(0.5 + 0.5 * probability))
}

/// Quantile of χ²_ν over ν after Wilson and Hilferty; `z` is the normal quantile. Within 1 %
/// for ν ≥ 5.
pub(crate) fn chi2_ratio_limit(freedom: f64, z: f64) -> f64 {
    let h = 2.0 / (9.0 * freedom.max(1.0));
    (1.0 - h + z * h.sqrt()).powi(3)
}

/// Normal quantile of an upper tail probability (Abramowitz and Stegun 26.2.23, |error| < 4.5e-4).
pub(crate) fn upper_normal_quantile(probability: f64) -> f64 {
    let t = (-2.0 * probability.ln()).sqrt();
    t - (2.515_517 + 0.802_853 * t + 0.010_328 * t * t)
        / (1.0 + 1.432_788 * t + 0.189_269 * t * t + 0.001_308 * t * t * t)
}

/// z with Q(z) = share, by bisection: exact, whereas [`upper_normal_quantile`] is an approximation.
pub(crate) fn inverse_tail(share: f64) -> f64 {
    let (mut low, mut high) = (-8.0, 8.0);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if phi_cdf(-middle) > share { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{ChiSquared, ContinuousCDF};

    #[test]
    fn residual_limit_agrees_with_the_distribution() {
        for (freedom, tail) in [(10.0, 1e-5), (14.0, 1e-3), (25.0, 1e-7)] {
            let exact = ChiSquared::new(freedom).unwrap().inverse_cdf(1.0 - tail) / freedom;
            let ours = chi2_ratio_limit(freedom, upper_normal_quantile(tail));
            assert!((ours / exact - 1.0).abs() < 0.02, "{ours} {exact}");
        }
    }
}
