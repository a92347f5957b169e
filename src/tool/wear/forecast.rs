//! When a width reaches its limit.
//!
//! Over the steady part of an edge's life wear grows in proportion to use: y = a + b·c, fitted by
//! least squares with weights 1/(u² + s²), s the scatter beyond u (found so that χ² equals its
//! degrees of freedom). The use at which y reaches the limit L follows by inverse regression; its
//! interval is Fieller's: all c for which
//!
//! ```text
//! (a + b·c − L)² ≤ t²·(Var(a) + 2c·Cov(a, b) + c²·Var(b))
//! ```
//!
//! which has no upper end where b is not proven to be above 0.

use nalgebra::{Matrix2, Vector2};

use crate::numerics::distributions::student;

/// Readings from which a forecast is made: two have no scatter.
const LEAST_READINGS: usize = 3;
/// Probability of the interval.
const PROBABILITY: f64 = 0.95;

/// When a limit is reached, in the unit of `cut`.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub(crate) struct Forecast {
    /// The limit, µm.
    pub limit_um: f64,
    /// Growth, µm a cut.
    pub um_per_cut: f64,
    /// Its standard uncertainty.
    pub u_um_per_cut: f64,
    /// The cut at which the limit is reached; `None` where wear does not grow.
    pub cut: Option<f64>,
    /// Beginning of its 95 % interval.
    pub from_cut: Option<f64>,
    /// End of that interval; `None` where growth is not proven.
    pub to_cut: Option<f64>,
    /// Readings it is made from.
    pub readings: usize,
}

/// A forecast from (cut, width, u), µm; `None` of fewer than three readings at two cuts or more.
pub(crate) fn forecast(readings: &[(f64, f64, f64)], limit_um: f64) -> Option<Forecast> {
    if readings.len() < LEAST_READINGS || readings.iter().all(|r| r.0 == readings[0].0) {
        return None;
    }
    let freedom = readings.len() as f64 - 2.0;
    // the scatter beyond u, by doubling and halving: χ² falls with it
    let (mut low, mut high) = (0.0_f64, 1e-3_f64);
    if fit(readings, 0.0)?.1 > freedom {
        while fit(readings, high)?.1 > freedom && high < 1e9 {
            high *= 2.0;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if fit(readings, middle)?.1 > freedom {
                low = middle;
            } else {
                high = middle;
            }
        }
    } else {
        high = 0.0;
    }
    let (line, _) = fit(readings, high)?;
    let t = student(freedom, PROBABILITY);
    let [from_cut, to_cut] = line.fieller(limit_um, t);
    let cut = (line.b > 0.0).then(|| (limit_um - line.a) / line.b);
    Some(Forecast {
        limit_um,
        um_per_cut: line.b,
        u_um_per_cut: line.covariance[(1, 1)].sqrt(),
        cut,
        from_cut,
        to_cut,
        readings: readings.len(),
    })
}

struct Line {
    a: f64,
    b: f64,
    covariance: Matrix2<f64>,
}

/// The weighted line and its χ².
fn fit(readings: &[(f64, f64, f64)], scatter_um: f64) -> Option<(Line, f64)> {
    let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
    let weight = |u: f64| (u * u + scatter_um * scatter_um).max(1e-12).recip();
    for (cut, um, u) in readings {
        let x = Vector2::new(1.0, *cut);
        normal += x * x.transpose() * weight(*u);
        right += x * (um * weight(*u));
    }
    let covariance = normal.try_inverse()?;
    let c = covariance * right;
    let chi2 = readings.iter().map(|(cut, um, u)| weight(*u) * (um - c[0] - c[1] * cut).powi(2)).sum();
    Some((Line { a: c[0], b: c[1], covariance }, chi2))
}

impl Line {
    /// Fieller's interval of the place at which the line reaches a limit.
    fn fieller(&self, limit: f64, t: f64) -> [Option<f64>; 2] {
        let v = self.covariance * (t * t);
        let d = self.a - limit;
        let (qa, qb, qc) = (self.b * self.b - v[(1, 1)], self.b * d - v[(0, 1)], d * d - v[(0, 0)]);
        let root = qb * qb - qa * qc;
        if root < 0.0 {
            return [None, None];
        }
        if qa > 0.0 && self.b > 0.0 {
            return [Some((-qb - root.sqrt()) / qa), Some((-qb + root.sqrt()) / qa)];
        }
        // growth not proven: from the root ahead of the readings on without an end
        let roots = [(-qb - root.sqrt()) / qa, (-qb + root.sqrt()) / qa];
        [
            roots
                .into_iter()
                .filter(|c| self.a + self.b * c <= limit + 1e-9 || self.b <= 0.0)
                .reduce(f64::max),
            None,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_history_reaches_its_limit_where_the_line_does() {
        let rows: Vec<_> =
            (0..6).map(|k| (10.0 * f64::from(k), 50.0 + 2.0 * 10.0 * f64::from(k), 1.0)).collect();
        let found = forecast(&rows, 300.0).unwrap();
        assert!((found.cut.unwrap() - 125.0).abs() < 1e-9 && (found.um_per_cut - 2.0).abs() < 1e-12);
        let (from, to) = (found.from_cut.unwrap(), found.to_cut.unwrap());
        assert!(from < 125.0 && to > 125.0 && to - from < 12.0, "{from} {to}");
    }

    /// Coverage of Fieller's interval by simulation: 95 % ± three standard deviations of 2000.
    #[test]
    fn the_interval_holds_its_probability() {
        use rand::{RngExt, SeedableRng};
        use rand_distr::StandardNormal;
        let mut random = rand_pcg::Pcg64::seed_from_u64(5);
        let mut inside = 0;
        for _ in 0..2000 {
            let rows: Vec<_> = (0..8)
                .map(|k| {
                    let z: f64 = random.sample(StandardNormal);
                    (f64::from(k), 100.0 + 10.0 * f64::from(k) + 4.0 * z, 0.0)
                })
                .collect();
            let f = forecast(&rows, 300.0).unwrap();
            let low = f.from_cut.is_none_or(|c| c <= 20.0);
            let high = f.to_cut.is_none_or(|c| c >= 20.0);
            inside += u32::from(low && high);
        }
        assert!((1870..=1930).contains(&inside), "{inside}");
    }

    #[test]
    fn without_growth_there_is_no_cut() {
        let rows: Vec<_> = (0..5).map(|k| (f64::from(k), 80.0, 2.0)).collect();
        let found = forecast(&rows, 300.0).unwrap();
        assert_eq!((found.cut, found.to_cut), (None, None));
        assert!(forecast(&rows[..2], 300.0).is_none());
    }
}
