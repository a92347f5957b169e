//! A feed-forward net of one hidden layer, fitted by Levenberg-Marquardt.
//!
//! y = W₂·tanh(W₁·s + b₁) + b₂, the "tansig" and "purelin" layers of the toolbox of the time; s and
//! y are the inputs and outputs scaled to −1 to 1 over the samples. Start: Nguyen and Widrow
//! (1990), which spreads the bends of the hidden units over the range of the inputs. Fit: (JᵀJ +
//! μI)·δ = Jᵀr (Hagan and Menhaj 1994), μ a tenth after a step that lowers the sum of squares, ten
//! times after one that does not. A net has no certificate: what it is worth is its error on
//! samples that it was not given, and of several starts the one with the least such error.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Damping at the start, and beyond which no step lowers the sum of squares.
const DAMPING: f64 = 1e-3;
const MOST_DAMPING: f64 = 1e10;
/// Relative decrease of the sum of squares below which a step no longer counts.
const SMALL_STEP: f64 = 1e-7;
/// Steps in a row that do not count, after which the fit ends.
const SMALL_STEPS: usize = 5;

/// Samples: inputs and outputs, a row each.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Samples {
    /// Inputs, of one length.
    pub inputs: Vec<Vec<f64>>,
    /// Outputs, of one length.
    pub outputs: Vec<Vec<f64>>,
}

impl Samples {
    /// One input and one output.
    pub(crate) fn curve(x: &[f64], y: &[f64]) -> Self {
        let rows = |values: &[f64]| values.iter().map(|v| vec![*v]).collect();
        Self { inputs: rows(x), outputs: rows(y) }
    }
}

/// How a net is fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Training {
    /// Hidden units.
    pub hidden: usize,
    /// Most steps.
    pub steps: usize,
    /// Seed of the start.
    pub seed: u64,
}

/// From and to of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Extent {
    middle: f64,
    half: f64,
}

impl Extent {
    fn of(rows: &[Vec<f64>], k: usize) -> Self {
        let fold = |(low, high): (f64, f64), row: &Vec<f64>| (low.min(row[k]), high.max(row[k]));
        let (low, high) = rows.iter().fold((f64::INFINITY, f64::NEG_INFINITY), fold);
        let half = 0.5 * (high - low);
        Self { middle: 0.5 * (low + high), half: if half > 0.0 { half } else { 1.0 } }
    }

    fn scaled(self, value: f64) -> f64 {
        (value - self.middle) / self.half
    }
}

/// A fitted net.
#[derive(Clone, Debug)]
pub(crate) struct NeuralNet {
    inputs: Vec<Extent>,
    outputs: Vec<Extent>,
    hidden: usize,
    /// A hidden unit after the other: its weights and its bias; then of every output its weights of
    /// the hidden units and its bias.
    parameters: DVector<f64>,
}

impl NeuralNet {
    /// A net fitted to samples; none where there are fewer than two, or of different lengths.
    pub(crate) fn fitted(samples: &Samples, how: &Training) -> Option<Self> {
        let (inputs, outputs) = (samples.inputs.first()?.len(), samples.outputs.first()?.len());
        let alike =
            |rows: &[Vec<f64>], length: usize| rows.iter().all(|row| row.len() == length && length > 0);
        let fits = alike(&samples.inputs, inputs) && alike(&samples.outputs, outputs);
        let count = samples.inputs.len();
        if !fits || count < 2 || count != samples.outputs.len() || how.hidden == 0 {
            return None;
        }
        let mut net = Self {
            inputs: (0..inputs).map(|k| Extent::of(&samples.inputs, k)).collect(),
            outputs: (0..outputs).map(|k| Extent::of(&samples.outputs, k)).collect(),
            hidden: how.hidden,
            parameters: DVector::zeros(how.hidden * (inputs + 1) + outputs * (how.hidden + 1)),
        };
        net.spread(how.seed);
        net.fit(&net.scaled(samples), how.steps);
        Some(net)
    }

    /// Nguyen-Widrow weights: of length .7·H^(1/n), their bends even over the range.
    fn spread(&mut self, seed: u64) {
        let (n, hidden) = (self.inputs.len(), self.hidden);
        let mut random = Pcg64::seed_from_u64(seed);
        let mut draw = || random.random_range(-1.0..1.0_f64);
        let length = 0.7 * (hidden as f64).powf(1.0 / n as f64);
        for unit in 0..hidden {
            let weights: Vec<f64> = (0..n).map(|_| draw()).collect();
            let norm = weights.iter().map(|w| w * w).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
            let first = unit * (n + 1);
            for (k, weight) in weights.iter().enumerate() {
                self.parameters[first + k] = length * weight / norm;
            }
            let place = if hidden == 1 { 0.0 } else { 2.0 * unit as f64 / (hidden - 1) as f64 - 1.0 };
            self.parameters[first + n] = length * place * weights[0].signum();
        }
        for k in hidden * (n + 1)..self.parameters.len() {
            self.parameters[k] = 0.5 * draw();
        }
    }

    fn scaled(&self, samples: &Samples) -> Samples {
        let of = |rows: &[Vec<f64>], extents: &[Extent]| {
            let row = |row: &Vec<f64>| row.iter().zip(extents).map(|(v, e)| e.scaled(*v)).collect();
            rows.iter().map(row).collect()
        };
        Samples { inputs: of(&samples.inputs, &self.inputs), outputs: of(&samples.outputs, &self.outputs) }
    }

    /// Values of the hidden units at scaled inputs.
    fn units(&self, input: &[f64], parameters: &DVector<f64>, units: &mut [f64]) {
        let n = input.len();
        for (unit, value) in units.iter_mut().enumerate() {
            let first = unit * (n + 1);
            let sum: f64 = input.iter().enumerate().map(|(k, v)| parameters[first + k] * v).sum();
            *value = (sum + parameters[first + n]).tanh();
        }
    }

    /// The scaled output `k` by the hidden units.
    fn output(&self, k: usize, units: &[f64], parameters: &DVector<f64>) -> f64 {
        let first = self.first_of_output(k);
        let sum: f64 = units.iter().enumerate().map(|(j, v)| parameters[first + j] * v).sum();
        sum + parameters[first + self.hidden]
    }

    fn first_of_output(&self, k: usize) -> usize {
        self.hidden * (self.inputs.len() + 1) + k * (self.hidden + 1)
    }

    fn sum_of_squares(&self, samples: &Samples, parameters: &DVector<f64>) -> f64 {
        let mut units = vec![0.0; self.hidden];
        let mut sum = 0.0;
        for (input, output) in samples.inputs.iter().zip(&samples.outputs) {
            self.units(input, parameters, &mut units);
            for (k, right) in output.iter().enumerate() {
                sum += (right - self.output(k, &units, parameters)).powi(2);
            }
        }
        sum
    }

    /// JᵀJ and Jᵀr; the rows of J of one sample stand together, columns of `transposed`.
    fn normal(&self, samples: &Samples) -> (DMatrix<f64>, DVector<f64>) {
        let (n, outputs, count) = (self.inputs.len(), self.outputs.len(), samples.inputs.len());
        let p = &self.parameters;
        let mut transposed = DMatrix::zeros(p.len(), count * outputs);
        let mut residuals = DVector::zeros(count * outputs);
        let mut units = vec![0.0; self.hidden];
        for (i, (input, output)) in samples.inputs.iter().zip(&samples.outputs).enumerate() {
            self.units(input, p, &mut units);
            for (k, right) in output.iter().enumerate() {
                let row = i * outputs + k;
                residuals[row] = right - self.output(k, &units, p);
                let own = self.first_of_output(k);
                let mut by = transposed.column_mut(row);
                for (unit, value) in units.iter().enumerate() {
                    let slope = p[own + unit] * (1.0 - value * value);
                    for (j, v) in input.iter().enumerate() {
                        by[unit * (n + 1) + j] = slope * v;
                    }
                    by[unit * (n + 1) + n] = slope;
                    by[own + unit] = *value;
                }
                by[own + self.hidden] = 1.0;
            }
        }
        // a product of two whole matrices takes a sixth of the time of `tr_mul` here
        let jacobian = transposed.transpose();
        (&transposed * jacobian, transposed * residuals)
    }

    fn fit(&mut self, samples: &Samples, steps: usize) {
        let mut damping = DAMPING;
        let mut before = self.sum_of_squares(samples, &self.parameters);
        let mut small = 0;
        for _ in 0..steps {
            let (normal, right) = self.normal(samples);
            let Some((parameters, after, found)) = self.step(samples, (&normal, &right), damping, before)
            else {
                return;
            };
            small = if before - after < SMALL_STEP * before { small + 1 } else { 0 };
            self.parameters = parameters;
            (before, damping) = (after, 0.1 * found);
            if small >= SMALL_STEPS || after == 0.0 {
                return;
            }
        }
    }

    /// A step that lowers the sum of squares, with that sum and the damping it took.
    fn step(
        &self,
        samples: &Samples,
        (normal, right): (&DMatrix<f64>, &DVector<f64>),
        from: f64,
        before: f64,
    ) -> Option<(DVector<f64>, f64, f64)> {
        let mut damping = from.max(1e-15);
        while damping < MOST_DAMPING {
            let mut damped = normal.clone();
            (0..damped.nrows()).for_each(|k| damped[(k, k)] += damping);
            if let Some(factor) = damped.cholesky() {
                let parameters = &self.parameters + factor.solve(right);
                let after = self.sum_of_squares(samples, &parameters);
                if after < before {
                    return Some((parameters, after, damping));
                }
            }
            damping *= 10.0;
        }
        None
    }

    /// The outputs at inputs.
    pub(crate) fn values(&self, input: &[f64]) -> Vec<f64> {
        let scaled: Vec<f64> = input.iter().zip(&self.inputs).map(|(v, e)| e.scaled(*v)).collect();
        let mut units = vec![0.0; self.hidden];
        self.units(&scaled, &self.parameters, &mut units);
        let output = |(k, e): (usize, &Extent)| e.middle + e.half * self.output(k, &units, &self.parameters);
        self.outputs.iter().enumerate().map(output).collect()
    }

    /// The first output at one input.
    pub(crate) fn value(&self, input: f64) -> f64 {
        self.values(&[input])[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(count: usize) -> Vec<f64> {
        (0..count).map(|k| k as f64 / (count - 1) as f64).collect()
    }

    #[test]
    fn a_net_recovers_a_net() {
        // two units: their sum is one of the functions that the net can hold
        let truth = |x: f64| 0.3 + (3.0 * x - 1.0).tanh() - 0.5 * (4.0 * x - 3.0).tanh();
        let x = places(60);
        let y: Vec<f64> = x.iter().map(|x| truth(*x)).collect();
        let best = (0..4)
            .filter_map(|seed| {
                let net =
                    NeuralNet::fitted(&Samples::curve(&x, &y), &Training { hidden: 3, steps: 400, seed })?;
                let off =
                    |k: usize| (net.value((k as f64 + 0.5) / 60.0) - truth((k as f64 + 0.5) / 60.0)).abs();
                Some((0..59).map(off).fold(0.0, f64::max))
            })
            .fold(f64::INFINITY, f64::min);
        assert!(best < 1e-4, "{best}");
    }

    #[test]
    fn the_jacobian_is_that_of_differences() {
        let samples = Samples {
            inputs: vec![vec![0.1, -0.4], vec![0.9, 0.3], vec![-0.7, 0.8]],
            outputs: vec![vec![1.0, 0.2], vec![-0.3, 0.5], vec![0.1, -1.0]],
        };
        let mut net = NeuralNet::fitted(&samples, &Training { hidden: 4, steps: 0, seed: 5 }).unwrap();
        let scaled = net.scaled(&samples);
        let (_, right) = net.normal(&scaled);
        // Jᵀr is minus half of the gradient of the sum of squares
        for k in 0..net.parameters.len() {
            let at = |net: &mut NeuralNet, by: f64| {
                net.parameters[k] += by;
                let sum = net.sum_of_squares(&scaled, &net.parameters);
                net.parameters[k] -= by;
                sum
            };
            let slope = (at(&mut net, 1e-5) - at(&mut net, -1e-5)) / 2e-5;
            assert!((right[k] + 0.5 * slope).abs() < 1e-7, "{k}: {} {slope}", right[k]);
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_net_and_misfits_give_none() {
        let x = places(20);
        let y: Vec<f64> = x.iter().map(|x| (6.0 * x).sin()).collect();
        let how = Training { hidden: 5, steps: 30, seed: 1 };
        let of = |how: &Training| NeuralNet::fitted(&Samples::curve(&x, &y), how).unwrap().parameters;
        assert_eq!(of(&how), of(&how));
        assert_ne!(of(&how), of(&Training { seed: 2, ..how }));
        let uneven = Samples { inputs: vec![vec![0.0], vec![1.0, 2.0]], outputs: vec![vec![0.0], vec![0.0]] };
        assert!(NeuralNet::fitted(&uneven, &how).is_none());
    }
}
