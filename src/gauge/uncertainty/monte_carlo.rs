//! Propagation of distributions by a Monte Carlo method (JCGM 101:2008), beside the GUM's law of
//! propagation.
//!
//! A measurement model Y = f(X₁ … X_N) with independent inputs. Trials are drawn in blocks of fixed
//! size, each with a stream of its own, so that the result depends on seed and number of trials
//! alone. Coverage intervals: probabilistically symmetric and shortest (7.7). Validation of the
//! GUM's result (8.1): with δ half a unit of the last significant digit of u(y), |y ± U −
//! y_low,high| ≤ δ for both ends.

use rand_distr::{Distribution as _, StandardNormal, StudentT, Uniform};
use rand_pcg::Pcg64;
use rayon::prelude::*;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal};

/// Trials of a block (JCGM 101, 7.9.4 recommends at least 10⁴).
pub(crate) const BLOCK: usize = 10_000;

/// Distribution of an input about its estimate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Distribution {
    /// Normal with standard uncertainty u.
    Normal {
        /// u.
        u: f64,
    },
    /// Rectangular within ± half.
    Rectangular {
        /// Half width.
        half: f64,
    },
    /// Scaled and shifted t of a type A evaluation: u = s/√n, n − 1 degrees of freedom (6.4.9.2).
    StudentT {
        /// s/√n.
        scale: f64,
        /// Degrees of freedom, above 2.
        freedom: f64,
    },
    /// Product of a normal factor and a rectangular error about zero.
    Product {
        /// Standard deviation of the product.
        u: f64,
        /// The factor's mean over its root mean square, 0 to 1.
        known: f64,
    },
}

impl Distribution {
    /// Standard deviation.
    pub(crate) fn u(&self) -> f64 {
        match *self {
            Self::Normal { u } | Self::Product { u, .. } => u,
            Self::Rectangular { half } => half / 3.0_f64.sqrt(),
            Self::StudentT { scale, freedom } => scale * (freedom / (freedom - 2.0)).sqrt(),
        }
    }

    /// A draw about zero.
    pub(crate) fn draw(&self, random: &mut Pcg64) -> f64 {
        match *self {
            Self::Normal { u } => {
                let z: f64 = StandardNormal.sample(random);
                u * z
            }
            Self::Rectangular { half } => {
                Uniform::new_inclusive(-1.0, 1.0).map_or(0.0, |d| half * d.sample(random))
            }
            Self::StudentT { scale, freedom } => {
                StudentT::new(freedom).map_or(0.0, |d| scale * d.sample(random))
            }
            Self::Product { u, known } => {
                let z: f64 = StandardNormal.sample(random);
                let factor = known + (1.0 - known * known).max(0.0).sqrt() * z;
                factor * Self::Rectangular { half: u * 3.0_f64.sqrt() }.draw(random)
            }
        }
    }
}

/// An input: its best estimate and its distribution.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Input {
    /// Its name.
    pub name: String,
    /// Its estimate.
    pub estimate: f64,
    /// Its distribution about the estimate.
    pub distribution: Distribution,
}

/// Result by the law of propagation of uncertainty, first order (GUM 5.1.2).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct LawOfPropagation {
    /// f at the estimates.
    pub y: f64,
    /// Combined standard uncertainty.
    pub u: f64,
    /// Contribution |∂f/∂x_i|·u_i of each input.
    pub contributions: Vec<f64>,
}

impl LawOfPropagation {
    /// y ± z·u for a normal output, the interval that the GUM gives for a probability.
    pub(crate) fn interval(&self, probability: f64) -> (f64, f64) {
        let half = Normal::standard().inverse_cdf(0.5 + 0.5 * probability) * self.u;
        (self.y - half, self.y + half)
    }
}

/// Result of a Monte Carlo propagation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Propagated {
    /// Trials made.
    pub trials: usize,
    /// Mean of the output.
    pub y: f64,
    /// Its standard deviation.
    pub u: f64,
    /// Probabilistically symmetric interval.
    pub symmetric: (f64, f64),
    /// Shortest interval.
    pub shortest: (f64, f64),
    /// Share of trials whose inputs gave no output; they are left out.
    pub failed: f64,
    /// The output's values in ascending order, for plots.
    #[serde(skip)]
    pub values: Vec<f64>,
}

/// How the GUM's interval compares.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Validation {
    /// Numerical tolerance δ.
    pub tolerance: f64,
    /// |lower end by the GUM − lower end by Monte Carlo|.
    pub d_low: f64,
    /// |upper end − upper end|.
    pub d_high: f64,
    /// Whether both are at most δ.
    pub validated: bool,
}

/// The law of propagation with central differences over ± one standard uncertainty.
pub(crate) fn law_of_propagation(
    inputs: &[Input],
    model: impl Fn(&[f64]) -> Option<f64>,
) -> Option<LawOfPropagation> {
    let mut x: Vec<f64> = inputs.iter().map(|i| i.estimate).collect();
    let y = model(&x)?;
    let mut contributions = Vec::with_capacity(inputs.len());
    for (index, input) in inputs.iter().enumerate() {
        // A small step: the derivative at the estimate, not a chord over the curvature.
        let (u, step) = (input.distribution.u(), 1e-3);
        x[index] = input.estimate + step * u;
        let above = model(&x)?;
        x[index] = input.estimate - step * u;
        let below = model(&x)?;
        x[index] = input.estimate;
        contributions.push(((above - below) / (2.0 * step)).abs());
    }
    let u = contributions.iter().map(|c| c * c).sum::<f64>().sqrt();
    Some(LawOfPropagation { y, u, contributions })
}

fn block(
    inputs: &[Input],
    model: &(impl Fn(&[f64]) -> Option<f64> + Sync),
    seed: u64,
    index: usize,
    size: usize,
) -> Vec<f64> {
    let mut random = Pcg64::new(u128::from(seed), index as u128);
    let mut x = vec![0.0; inputs.len()];
    (0..size)
        .filter_map(|_| {
            for (value, input) in x.iter_mut().zip(inputs) {
                *value = input.estimate + input.distribution.draw(&mut random);
            }
            model(&x).filter(|y| y.is_finite())
        })
        .collect()
}

/// Monte Carlo with a fixed number of trials; `None` where no trial gives an output.
pub(crate) fn monte_carlo(
    inputs: &[Input],
    model: impl Fn(&[f64]) -> Option<f64> + Sync,
    trials: usize,
    probability: f64,
    seed: u64,
) -> Option<Propagated> {
    let blocks = trials.div_ceil(BLOCK).max(1);
    let size = |index: usize| BLOCK.min(trials - index * BLOCK);
    let parts: Vec<Vec<f64>> =
        (0..blocks).into_par_iter().map(|index| block(inputs, &model, seed, index, size(index))).collect();
    summarise(parts, trials, probability)
}

/// When the adaptive procedure ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StopRule {
    /// Twice the standard deviation of the blocks' averages that is enough.
    pub tolerance: f64,
    /// Trials after which it ends in any case.
    pub most: usize,
}

/// The adaptive procedure (7.9): blocks are added until twice the standard deviation of the blocks'
/// averages of y, u and both ends of the interval lies below the tolerance, or the most trials are
/// made.
pub(crate) fn monte_carlo_adaptive(
    inputs: &[Input],
    model: impl Fn(&[f64]) -> Option<f64> + Sync,
    until: StopRule,
    probability: f64,
    seed: u64,
) -> Option<Propagated> {
    let StopRule { tolerance, most } = until;
    let mut parts: Vec<Vec<f64>> = Vec::new();
    let mut figures: Vec<[f64; 4]> = Vec::new();
    loop {
        let from = parts.len();
        let more: Vec<Vec<f64>> =
            (from..from + 8).into_par_iter().map(|index| block(inputs, &model, seed, index, BLOCK)).collect();
        for part in more {
            let of_block = summarise(vec![part.clone()], BLOCK, probability)?;
            figures.push([of_block.y, of_block.u, of_block.symmetric.0, of_block.symmetric.1]);
            parts.push(part);
        }
        let h = figures.len() as f64;
        let stable = (0..4).all(|k| {
            let mean = figures.iter().map(|f| f[k]).sum::<f64>() / h;
            let variance = figures.iter().map(|f| (f[k] - mean).powi(2)).sum::<f64>() / (h * (h - 1.0));
            2.0 * variance.sqrt() < tolerance
        });
        if stable || parts.len() * BLOCK >= most {
            let trials = parts.len() * BLOCK;
            return summarise(parts, trials, probability);
        }
    }
}

fn summarise(parts: Vec<Vec<f64>>, trials: usize, probability: f64) -> Option<Propagated> {
    let mut values: Vec<f64> = parts.into_iter().flatten().collect();
    if values.len() < 2 {
        return None;
    }
    let n = values.len() as f64;
    // Sums about the first value: a diameter of 25 mm must not round its nanometres.
    let base = values[0];
    let mean = values.iter().map(|v| v - base).sum::<f64>() / n;
    let u = (values.iter().map(|v| (v - base - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    values.par_sort_unstable_by(f64::total_cmp);
    let inside = ((probability * n).round() as usize).clamp(1, values.len() - 1);
    let low = (values.len() - inside) / 2;
    let symmetric = (values[low], values[low + inside]);
    let shortest = (0..values.len() - inside)
        .min_by(|a, b| (values[a + inside] - values[*a]).total_cmp(&(values[b + inside] - values[*b])))
        .map_or(symmetric, |i| (values[i], values[i + inside]));
    let failed = 1.0 - n / trials as f64;
    Some(Propagated { trials, y: base + mean, u, symmetric, shortest, failed, values })
}

/// Half a unit of the last of `digits` significant digits of u (JCGM 101, 7.9.2): u = c·10^l gives
/// ½·10^l.
pub(crate) fn numerical_tolerance(u: f64, digits: u32) -> f64 {
    let digits = f64::from(digits);
    // The digits are those of the rounded value: 0.0996 to two digits is 0.10.
    let exponent = u.log10().floor() - (digits - 1.0);
    let rounded = (u / 10f64.powf(exponent)).round();
    let exponent = if rounded >= 10f64.powf(digits) { exponent + 1.0 } else { exponent };
    0.5 * 10f64.powf(exponent)
}

/// Compares the GUM's interval with Monte Carlo's symmetric one (8.1).
pub(crate) fn validate(gum: &LawOfPropagation, mc: &Propagated, probability: f64, digits: u32) -> Validation {
    let tolerance = numerical_tolerance(gum.u, digits);
    let (low, high) = gum.interval(probability);
    let (d_low, d_high) = ((low - mc.symmetric.0).abs(), (high - mc.symmetric.1).abs());
    Validation { tolerance, d_low, d_high, validated: d_low <= tolerance && d_high <= tolerance }
}
