//! The Airy function Ai of a complex argument and its derivative.
//!
//! Up to |z| = 7 the power series (DLMF 9.4.1), beyond it the asymptotic series (DLMF 9.7.5,
//! 9.7.6), cut before its smallest term. The series loses digits like e^|ζ|, ζ = ⅔z^(3/2), the
//! asymptotic one errs by e^(-2|ζ|): both have 2e-11 of the larger of Ai and Bi where they meet.
//! The asymptotic series is used for |arg z| ≤ ⅔π only; the rest of the plane follows from Ai(z) =
//! -e^(2πi/3)Ai(ze^(2πi/3)) - e^(-2πi/3)Ai(ze^(-2πi/3)) (DLMF 9.2.12).

use std::f64::consts::{FRAC_PI_3, PI};

use rustfft::num_complex::Complex;

pub(crate) type C = Complex<f64>;

/// Limit between the two series.
const MEET: f64 = 7.0;

/// Ai(0) and -Ai'(0) (DLMF 9.2.3, 9.2.4).
const AI_0: f64 = 0.355_028_053_887_817_2;
const MINUS_AI_PRIME_0: f64 = 0.258_819_403_792_806_8;

/// Most terms of the power series; 60 are needed at its limit.
const MOST_TERMS: usize = 120;

/// Most terms of the asymptotic series; 25 are needed at its limit.
const MOST_ASYMPTOTIC: usize = 60;

/// e^(iφ).
pub(crate) fn unit(phase: f64) -> C {
    let (sin, cos) = phase.sin_cos();
    C::new(cos, sin)
}

/// Ai(z) and Ai'(z).
pub(crate) fn airy(z: C) -> [C; 2] {
    if z.norm_sqr() < MEET * MEET {
        return series(z);
    }
    if z.arg().abs() <= 2.0 * FRAC_PI_3 + 1e-9 {
        return asymptotic(z);
    }
    let turn = unit(2.0 * FRAC_PI_3);
    let (ahead, behind) = (asymptotic(z * turn), asymptotic(z * turn.conj()));
    let value = -turn * ahead[0] - turn.conj() * behind[0];
    // The derivative gains the factor of the argument once more.
    [value, -turn * turn * ahead[1] - (turn * turn).conj() * behind[1]]
}

/// Ai = Ai(0) f + Ai'(0) g, f = Σ 1·4·…/(3k)! z^(3k), g = Σ 2·5·…/(3k+1)! z^(3k+1).
fn series(z: C) -> [C; 2] {
    let cube = z * z * z;
    // f_k, z g_k' and their like are kept as terms without the leading power.
    let (mut f, mut g) = (C::new(1.0, 0.0), C::new(1.0, 0.0));
    let (mut sum_f, mut sum_g) = (f, g);
    let (mut slope_f, mut slope_g) = (C::new(0.0, 0.0), g);
    for k in 1..MOST_TERMS {
        let n = 3.0 * k as f64;
        f *= cube / (n * (n - 1.0));
        g *= cube / (n * (n + 1.0));
        sum_f += f;
        sum_g += g;
        slope_f += f * n;
        slope_g += g * (n + 1.0);
        if f.norm_sqr() + g.norm_sqr() < 1e-40 * (sum_f.norm_sqr() + sum_g.norm_sqr()) {
            break;
        }
    }
    let slope_f = if z.norm_sqr() == 0.0 { slope_f } else { slope_f / z };
    [sum_f * AI_0 - z * sum_g * MINUS_AI_PRIME_0, slope_f * AI_0 - slope_g * MINUS_AI_PRIME_0]
}

/// Ai ≈ e^(-ζ)/(2√π z^(1/4)) Σ (-1)^k u_k/ζ^k, Ai' ≈ -z^(1/4) e^(-ζ)/(2√π) Σ (-1)^k v_k/ζ^k.
fn asymptotic(z: C) -> [C; 2] {
    let root = z.sqrt();
    let zeta = z * root * (2.0 / 3.0);
    let inverse = -zeta.inv();
    let mut u = C::new(1.0, 0.0);
    let (mut sum_u, mut sum_v) = (u, u);
    for k in 1..MOST_ASYMPTOTIC {
        let n = 6.0 * k as f64;
        let next =
            u * inverse * ((n - 5.0) * (n - 3.0) * (n - 1.0) / (216.0 * k as f64 * (2.0 * k as f64 - 1.0)));
        if next.norm_sqr() >= u.norm_sqr() || next.norm_sqr() < 1e-34 {
            break;
        }
        u = next;
        sum_u += u;
        sum_v += u * ((n + 1.0) / (1.0 - n));
    }
    let quarter = root.sqrt();
    let front = (-zeta).exp() * (0.5 / PI.sqrt());
    [front * sum_u / quarter, -front * sum_v * quarter]
}
