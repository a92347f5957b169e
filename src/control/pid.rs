//! PID over passes (paper 003, eqs 16-18).
//!
//! ```text
//! positional   u(k)  = Kp e(k) + Ki Σ_{j≤k} e(j) + Kd d(k)        (16; 18 with Ki restored)
//! incremental  Δu(k) = Kp [e(k) − e(k−1)] + Ki e(k) + Kd [d(k) − d(k−1)]         (17)
//! difference   d(k)  = α d(k−1) + (1 − α) [e(k) − e(k−1)],  d(1) = 0
//! ```
//!
//! e = D − r in mm of diameter: the derivative acts on the error because r jumps every pass. α = 0
//! gives the printed equations. Limits: u within ± the output limit, |u(k) − u(k−1)| within the
//! rate limit; while a limit is active, an error that would drive the output further into it is not
//! summed (conditional integration). Without limits both algorithms give the same numbers up to
//! rounding.

use super::settings::{FirstPass, PidAlgorithm, PidSettings};

/// Gains, limits and filter, common to all loops.
#[derive(Clone, Debug, PartialEq)]
struct Gains {
    settings: PidSettings,
}

/// State of one loop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Loop {
    passes: u32,
    error: f64,
    sum: f64,
    difference: f64,
    output: f64,
}

/// Independent PID loops, one per channel (station or shape).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pid {
    gains: Gains,
    loops: Vec<Loop>,
}

impl Pid {
    /// Loops at rest. Only the gains, the algorithm, the filter, the limits and the deadband of
    /// `settings` are used here.
    pub(crate) fn new(settings: &PidSettings, channels: usize) -> Self {
        Self { gains: Gains { settings: settings.clone() }, loops: vec![Loop::default(); channels] }
    }

    /// Takes the errors of one pass, one per channel, and returns the outputs u(k).
    ///
    /// Channels beyond the shorter of errors and loops do not change.
    pub(crate) fn step(&mut self, errors: &[f64]) -> Vec<f64> {
        let gains = &self.gains;
        self.loops.iter_mut().zip(errors).map(|(state, &e)| gains.step(state, e)).collect()
    }
}

impl Gains {
    fn step(&self, state: &mut Loop, error: f64) -> f64 {
        let s = &self.settings;
        let e = if error.abs() < s.deadband_mm { 0.0 } else { error };
        let first = state.passes == 0;
        let difference = if first { 0.0 } else { self.filtered(state, e) };
        // eq. 18 prints u(1) = Kp e(1); the sum nevertheless includes the first error
        let integral_acts = !(first && s.first_pass == FirstPass::Proportional);
        let sum = state.sum + e;
        let wanted = match s.algorithm {
            PidAlgorithm::Positional => {
                s.kp * e + s.kd * difference + if integral_acts { s.ki * sum } else { 0.0 }
            }
            PidAlgorithm::Incremental => {
                let summed = match (integral_acts, state.passes, s.first_pass) {
                    (false, ..) => 0.0,
                    (true, 1, FirstPass::Proportional) => sum,
                    (true, ..) => e,
                };
                state.output
                    + s.kp * (e - state.error)
                    + s.ki * summed
                    + s.kd * (difference - state.difference)
            }
        };
        let output = self.limited(wanted, state.output);
        let winding = (wanted - output) * e > 0.0;
        *state = Loop {
            passes: state.passes + 1,
            error: e,
            sum: if winding { state.sum } else { sum },
            difference,
            output,
        };
        output
    }

    fn filtered(&self, state: &Loop, e: f64) -> f64 {
        let alpha = self.settings.derivative_filter;
        alpha * state.difference + (1.0 - alpha) * (e - state.error)
    }

    fn limited(&self, wanted: f64, last: f64) -> f64 {
        let rate = self.settings.rate_limit_mm.unwrap_or(f64::INFINITY);
        let limit = self.settings.output_limit_mm.unwrap_or(f64::INFINITY);
        wanted.clamp(last - rate, last + rate).clamp(-limit, limit)
    }
}
