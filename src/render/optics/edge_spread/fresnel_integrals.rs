//! Fresnel integrals C(x) = ∫cos(πt²/2)dt and S(x) = ∫sin(πt²/2)dt from 0 to x.
//!
//! Up to |x| = 1.6 the power series (Abramowitz & Stegun 7.3.11, 7.3.13), beyond it the continued
//! fraction of erfc(√π(1 - i)x/2) (Lentz's method), both to about 1e-15: C + iS = (1 + i)/2·(1 -
//! erfc).

use std::f64::consts::PI;

/// Limit between the two methods, where the series needs 20 terms and the fraction 40 steps.
const MEET: f64 = 1.6;

/// Most terms or steps; never reached.
const MOST: usize = 200;

/// C(x) and S(x), absolute error below 1e-13.
pub(crate) fn fresnel(x: f64) -> (f64, f64) {
    let v = x.abs();
    let (c, s) = if v < MEET { series(v) } else { fraction(v) };
    (c.copysign(x), s.copysign(x))
}

fn series(v: f64) -> (f64, f64) {
    // Terms (iπ/2)^n v^(2n+1) / (n! (2n+1)): even n belong to C, odd ones to S, signs alternate.
    let z = 0.5 * PI * v * v;
    let mut power = v;
    let mut sums = [0.0, 0.0];
    for n in 0..MOST {
        let term = power / (2 * n + 1) as f64;
        let sign = if n % 4 < 2 { 1.0 } else { -1.0 };
        sums[n % 2] += sign * term;
        if term < 1e-17 {
            break;
        }
        power *= z / (n + 1) as f64;
    }
    (sums[0], sums[1])
}

/// A complex number (re, im).
type Complex = (f64, f64);

fn times(a: Complex, b: Complex) -> Complex {
    (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
}

fn inverse(a: Complex) -> Complex {
    let norm = a.0 * a.0 + a.1 * a.1;
    (a.0 / norm, -a.1 / norm)
}

fn fraction(v: f64) -> (f64, f64) {
    if v > 1e8 {
        return (0.5, 0.5);
    }
    let z2 = PI * v * v;
    let mut b: Complex = (1.0, -z2);
    let mut c: Complex = (1e300, 0.0);
    let mut d = inverse(b);
    let mut h = d;
    for k in 1..MOST {
        let n = (2 * k - 1) as f64;
        let a = -n * (n + 1.0);
        b.0 += 4.0;
        let ad = (b.0 + a * d.0, b.1 + a * d.1);
        d = inverse(ad);
        let ic = inverse(c);
        c = (b.0 + a * ic.0, b.1 + a * ic.1);
        let factor = times(c, d);
        h = times(h, factor);
        if (factor.0 - 1.0).abs() + factor.1.abs() < 1e-16 {
            break;
        }
    }
    let h = times(h, (v, -v));
    // (1 + i)/2 · (1 - e^{iπv²/2} h); the phase is reduced modulo a turn first.
    let turn = (0.5 * v * v).rem_euclid(2.0) * PI;
    let phase = (turn.cos(), turn.sin());
    let tail = times(phase, h);
    times((0.5, 0.5), (1.0 - tail.0, -tail.1))
}
