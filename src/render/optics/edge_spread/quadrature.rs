//! Gauss-Legendre rules over intervals, whole and divided at given points.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Newton steps that bring a root of the Legendre polynomial to rounding from Tricomi's start.
const NEWTON_STEPS: usize = 8;

/// Nodes and weights.
type Rule = Arc<[(f64, f64)]>;

/// Rules that were computed. A rule of n nodes takes some n² steps, which is half of the time of a
/// limb's table; tables of one setup need the same few tens of them.
static RULES: Mutex<BTreeMap<usize, Rule>> = Mutex::new(BTreeMap::new());

/// [`gauss_legendre`], computed once for each number of nodes.
pub(crate) fn kept_rule(n: usize) -> Rule {
    let mut rules = RULES.lock().unwrap_or_else(PoisonError::into_inner);
    Arc::clone(rules.entry(n).or_insert_with(|| gauss_legendre(n).into()))
}

/// Nodes and weights on -1..1, exact for polynomials of degree 2n - 1.
///
/// Roots of P_n by Newton's method on its recurrence from cos(π(i + 3/4)/(n + 1/2)) (Abramowitz &
/// Stegun 22.16.6).
pub(crate) fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| {
            let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            for _ in 0..NEWTON_STEPS {
                let (p, slope) = legendre(n, x);
                let before = x;
                x -= p / slope;
                // Every further step would repeat this one.
                if x == before {
                    break;
                }
            }
            let slope = legendre(n, x).1;
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// P_n(x) and its derivative.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut before, mut now) = (1.0, x);
    for k in 2..=n {
        let k = k as f64;
        (before, now) = (now, ((2.0 * k - 1.0) * x * now - (k - 1.0) * before) / k);
    }
    (now, n as f64 * (x * now - before) / (x * x - 1.0))
}

/// A rule on -1..1 moved to `low..high`.
pub(crate) fn scaled(rule: &[(f64, f64)], low: f64, high: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
    let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
    rule.iter().map(move |(x, w)| (centre + half * x, half * w))
}

/// Nodes and weights over `low..high`, divided at `breaks` and further into panels of at most
/// `panel`.
pub(crate) fn panels(
    low: f64,
    high: f64,
    breaks: &[f64],
    panel: f64,
    rule: &[(f64, f64)],
) -> Vec<(f64, f64)> {
    let mut ends: Vec<f64> = breaks.iter().copied().filter(|b| *b > low && *b < high).collect();
    ends.extend([low, high]);
    ends.sort_by(f64::total_cmp);
    ends.windows(2)
        .flat_map(|pair| {
            let (a, b) = (pair[0], pair[1]);
            let count = ((b - a) / panel).ceil().max(1.0);
            let width = (b - a) / count;
            (0..count as usize).flat_map(move |i| {
                let start = a + i as f64 * width;
                scaled(rule, start, start + width)
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rule_is_exact_to_its_degree() {
        for n in [1, 2, 5, 16, 40] {
            let rule = gauss_legendre(n);
            let degree = 2 * n as i32 - 2;
            let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(degree)).sum();
            assert!((sum - 2.0 / f64::from(degree + 1)).abs() < 1e-14, "{n}: {sum}");
        }
    }

    #[test]
    fn a_kept_rule_is_the_computed_one() {
        for n in [6, 37, 6] {
            assert_eq!(kept_rule(n).as_ref(), gauss_legendre(n).as_slice());
        }
    }

    #[test]
    fn panels_cover_the_interval_once() {
        let nodes = panels(-1.0, 3.0, &[0.5, 9.0], 0.7, &gauss_legendre(4));
        let length: f64 = nodes.iter().map(|(_, w)| w).sum();
        let kinked: f64 = nodes.iter().map(|(x, w)| w * (x - 0.5).abs()).sum();
        assert!((length - 4.0).abs() < 1e-14 && (kinked - 4.25).abs() < 1e-13);
    }
}
