//! Standard normal distribution function and density from a table, for loops over pixels: cubic
//! Hermite interpolation with the exact slopes (Φ′ = φ, φ′ = −tφ), to 1e-9 everywhere.

use std::sync::LazyLock;

use crate::numerics::distributions::{phi_cdf, phi_pdf};

/// Nodes per unit of t. The error of a cubic of step h is h⁴/384·max|f⁗| ≤ 6e-10, since |Φ⁗| ≤ 1.4
/// and
/// |φ⁗| ≤ 1.2.
const PER_UNIT: f64 = 48.0;
/// Beyond this Φ is 0 or 1 and φ is 0, to 1e-16.
const REACH: f64 = 8.25;

/// Φ and φ at the nodes.
static NODES: LazyLock<Vec<[f64; 2]>> = LazyLock::new(|| {
    let count = (2.0 * REACH * PER_UNIT) as usize + 2;
    let at = |k: usize| k as f64 / PER_UNIT - REACH;
    (0..count).map(|k| [phi_cdf(at(k)), phi_pdf(at(k))]).collect()
});

/// A handle to the table, obtained once before a loop.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NormalTable(&'static [[f64; 2]]);

impl NormalTable {
    /// The table.
    pub(crate) fn get() -> Self {
        Self(&NODES)
    }

    /// Φ(t) and φ(t).
    #[inline]
    pub(crate) fn at(self, t: f64) -> [f64; 2] {
        if !(t.abs() < REACH) {
            return [if t > 0.0 { 1.0 } else { 0.0 }, 0.0];
        }
        let place = (t + REACH) * PER_UNIT;
        let k = place as usize;
        let v = place - k as f64;
        let ([f0, d0], [f1, d1]) = (self.0[k], self.0[k + 1]);
        let (t0, h) = (k as f64 / PER_UNIT - REACH, 1.0 / PER_UNIT);
        let (s0, s1) = (-t0 * d0, -(t0 + h) * d1);
        let hermite = |f0: f64, f1: f64, s0: f64, s1: f64| {
            let (rise, a) = (f1 - f0, s0 * h);
            let (b, c) = (3.0 * rise - (2.0 * s0 + s1) * h, (s0 + s1) * h - 2.0 * rise);
            f0 + v * (a + v * (b + v * c))
        };
        [hermite(f0, f1, d0, d1), hermite(d0, d1, s0, s1)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_the_function_to_a_part_in_a_thousand_million() {
        let table = NormalTable::get();
        for k in -100_000..=100_000 {
            let t = f64::from(k) * 1e-4 + 3e-5;
            let [cdf, pdf] = table.at(t);
            assert!((cdf - phi_cdf(t)).abs() < 1e-9 && (pdf - phi_pdf(t)).abs() < 1e-9, "{t}: {cdf} {pdf}");
        }
        assert_eq!((table.at(f64::NEG_INFINITY), table.at(f64::INFINITY)), ([0.0, 0.0], [1.0, 0.0]));
    }
}
