//! Plants and controllers as transfer functions from pass to pass.

use super::polynomial::{Polynomial, UNBOUNDED};
use crate::control::settings::{DoubleEwmaSettings, OffsetForm, PidSettings};

/// How errors and offsets of one pass make the error of the next: e(k+1) = α e(k) − g o(k+1) + w.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Plant {
    /// α = 0.
    Constant,
    /// α = 1 − g.
    Copying,
    /// α given, the controller's output acting as it is.
    Transfer {
        /// Error carried from pass to pass without control.
        alpha: f64,
    },
}

impl Plant {
    /// α at the gain g.
    pub(crate) fn alpha(self, gain: f64) -> f64 {
        match self {
            Self::Constant => 0.0,
            Self::Copying => 1.0 - gain,
            Self::Transfer { alpha } => alpha,
        }
    }

    /// Its name in reports.
    pub(crate) fn describe(self) -> String {
        match self {
            Self::Constant => "constant disturbance".into(),
            Self::Copying => "error copying".into(),
            Self::Transfer { alpha } => format!("error transfer of {alpha}"),
        }
    }
}

/// A controller o(k+1) = N(q)/D(q) e(k).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Transfer {
    /// N.
    pub numerator: Polynomial,
    /// D, of at least N's degree.
    pub denominator: Polynomial,
}

impl Transfer {
    /// Characteristic polynomial (q − α) D + g N.
    pub(crate) fn closed_loop(&self, plant: Plant, gain: f64) -> Polynomial {
        Polynomial::new([-plant.alpha(gain), 1.0]).times(&self.denominator).plus(&self.numerator.scaled(gain))
    }

    /// With the measurement delayed by `passes` further passes: N/(D q^passes).
    pub(crate) fn delayed(&self, passes: usize) -> Self {
        let mut shift = vec![0.0; passes];
        shift.push(1.0);
        Self {
            numerator: self.numerator.clone(),
            denominator: self.denominator.times(&Polynomial::new(shift)),
        }
    }

    /// Errors e(1), e(2), …, e(passes) from e(1) = 1 and a controller at rest (its derivative acts
    /// on the step), under the constant disturbance that would hold the error at 1 without control;
    /// without disturbance where errors grow in the plant itself (α ≥ 1). Ends early where they
    /// exceed 1e12.
    pub(crate) fn response(&self, plant: Plant, gain: f64, passes: usize) -> Vec<f64> {
        let (n, d) = (self.numerator.coefficients(), self.denominator.coefficients());
        let (degree, lead) = (self.denominator.degree(), d.last().copied().unwrap_or(1.0));
        let alpha = plant.alpha(gain);
        let disturbance = (1.0 - alpha).max(0.0);
        let (mut errors, mut outputs) = (vec![1.0_f64], Vec::<f64>::new());
        for k in 0..passes.saturating_sub(1) {
            // Σ_i d_i o(k + i − degree) = Σ_i n_i e(k + i − degree), o counted so that outputs[k]
            // is o(k+1)
            let past = |series: &[f64], i: usize| (k + i).checked_sub(degree).map_or(0.0, |j| series[j]);
            let fed: f64 = n.iter().enumerate().map(|(i, c)| c * past(&errors, i)).sum();
            let kept: f64 = d.iter().take(degree).enumerate().map(|(i, c)| c * past(&outputs, i)).sum();
            outputs.push((fed - kept) / lead);
            let next = alpha * errors[k] - gain * outputs[k] + disturbance;
            errors.push(next);
            if next.abs() > UNBOUNDED || next.is_nan() {
                break;
            }
        }
        errors
    }

    /// Largest |e(k)|, k ≥ 2, of the response; infinite where it exceeds 1e12.
    pub(crate) fn peak_error(&self, plant: Plant, gain: f64, passes: usize) -> f64 {
        let response = self.response(plant, gain, passes);
        if response.len() < passes {
            return f64::INFINITY;
        }
        response.iter().skip(1).fold(0.0, |peak, e| e.abs().max(peak))
    }
}

/// PID, absolute or accumulated, with its derivative filter α:
/// u = [Kp + Ki q/(q−1) + Kd (1−α)(q−1)/(q−α)] e and, accumulated, o(k+1) = q/(q−1) u(k).
pub(crate) fn pid_transfer(settings: &PidSettings) -> Transfer {
    let (difference, pole) =
        (Polynomial::new([-1.0, 1.0]), Polynomial::new([-settings.derivative_filter, 1.0]));
    let shift = Polynomial::new([0.0, 1.0]);
    let proportional = difference.times(&pole).scaled(settings.kp);
    let integral = shift.times(&pole).scaled(settings.ki);
    let derivative = difference.times(&difference).scaled(settings.kd * (1.0 - settings.derivative_filter));
    let numerator = proportional.plus(&integral).plus(&derivative);
    let denominator = difference.times(&pole);
    match settings.form {
        OffsetForm::Absolute => Transfer { numerator, denominator },
        OffsetForm::Accumulated => {
            Transfer { numerator: numerator.times(&shift), denominator: denominator.times(&difference) }
        }
    }
}

/// Integral action of weight w per pass: o(k+1) = o(k) + w e(k). Run-to-run EWMA (w = λ/b̂),
/// iterative learning without filter (w = L), and the least-squares controller within the space of
/// its shapes (w its gain).
pub(crate) fn integral_transfer(weight: f64) -> Transfer {
    Transfer { numerator: Polynomial::new([0.0, weight]), denominator: Polynomial::new([-1.0, 1.0]) }
}

/// Double EWMA: eliminating level and trend from its recurrences leaves
/// o(k+1)/e(k) = q [(λ₁ + λ₂)(q − 1) + λ₁λ₂]/[b̂ (q − 1)²].
pub(crate) fn double_ewma_transfer(settings: &DoubleEwmaSettings) -> Transfer {
    let (l1, l2) = (settings.level_weight, settings.trend_weight);
    let numerator = Polynomial::new([0.0, l1 * l2 - l1 - l2, l1 + l2]).scaled(settings.gain_estimate.recip());
    Transfer { numerator, denominator: Polynomial::new([1.0, -2.0, 1.0]) }
}

/// Model-based control near the planned depth: the offset compensates the predicted copying, (1 −
/// ĝ)/ĝ of the error, and K/ĝ of the prediction error. With ĝ = g and error copying the poles are 0
/// and 1 − K.
pub(crate) fn model_transfer(gain_estimate: f64, filter_gain: f64) -> Transfer {
    let copied = (1.0 - gain_estimate) / gain_estimate;
    let numerator = Polynomial::new([-copied, copied + filter_gain / gain_estimate]);
    Transfer { numerator, denominator: Polynomial::new([-1.0, 1.0]) }
}
