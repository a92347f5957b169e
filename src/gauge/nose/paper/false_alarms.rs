//! Threshold and false alarms of the line detector (equations 5 to 7 of the paper).
//!
//! The line detector is that of Grompone von Gioi, Jakubowicz, Morel and Randall (LSD, Image
//! Processing On Line 2, 2012): a gradient below ρ = q/sin τ may have turned by more than τ where
//! grey values are off by q; (NM)^(5/2)·γ rectangles can be drawn in an image, since either end may
//! be any of its NM pixels and the width any up to √(NM).

/// Least gradient whose direction is within `tau_rad` where grey values are off by `q`.
pub(crate) fn gradient_threshold(q: f64, tau_rad: f64) -> f64 {
    q / tau_rad.sin()
}

/// Number of tests γ·(NM)^x of an image.
pub(crate) fn tests((columns, rows): (u32, u32), exponent: f64, gamma: f64) -> f64 {
    gamma * (f64::from(columns) * f64::from(rows)).powf(exponent)
}

/// Equation 6: probability of `k` or more of `n` pixels within the tolerance, each with `p`.
pub(crate) fn binomial_tail(n: u32, k: u32, p: f64) -> f64 {
    let ln_factorial = |m: u32| libm::lgamma(f64::from(m) + 1.0);
    let term = |j: u32| {
        let chosen = ln_factorial(n) - ln_factorial(j) - ln_factorial(n - j);
        (chosen + f64::from(j) * p.ln() + f64::from(n - j) * (-p).ln_1p()).exp()
    };
    // the smallest first
    (k..=n).rev().map(term).sum()
}

/// Least number of `n` pixels that must lie within the tolerance for at most one false alarm in
/// `tests` (equation 7); none where all of them are too few.
pub(crate) fn aligned_needed(n: u32, p: f64, tests: f64) -> Option<u32> {
    (0..=n).find(|&k| tests * binomial_tail(n, k, p) <= 1.0)
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    #[test]
    fn the_threshold_is_where_an_error_of_q_turns_a_gradient_by_tau() {
        // a gradient of length g turns most, by asin(q/g), under an error of q at right angles to
        // the result
        let tau = 22.5f64.to_radians();
        let g = gradient_threshold(2.0, tau);
        let turned = (0..20_000).map(|k| {
            let error = 2.0 * DVec2::from_angle(f64::from(k) * 1e-3);
            DVec2::X.angle_to(DVec2::new(g, 0.0) + error).abs()
        });
        let most = turned.fold(0.0, f64::max);
        assert!((most - tau).abs() < 1e-6 && (g - 5.2263).abs() < 5e-5, "{most} {g}");
    }

    #[test]
    fn the_tail_is_pascals_triangle() {
        // all outcomes of 10 pixels by enumeration
        let p = 0.125f64;
        for k in 0..=10 {
            let sum: f64 = (0u32..1024)
                .filter(|outcome| outcome.count_ones() >= k)
                .map(|outcome| {
                    p.powi(outcome.count_ones() as i32) * (1.0 - p).powi(10 - outcome.count_ones() as i32)
                })
                .sum();
            assert!((binomial_tail(10, k, p) / sum - 1.0).abs() < 1e-12, "{k}");
        }
        assert_eq!(aligned_needed(10, p, 0.5), Some(0));
        assert_eq!(aligned_needed(10, p, 1e10), None);
    }
}
