//! One error as a function of its axis' position, of the direction, of time and temperature.

use super::conditions::{Conditions, Direction, REFERENCE_C};
use super::table::Table;

/// A cosine over the position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Wave {
    /// Angular frequency, rad/mm of a slide, orders of a spindle.
    pub frequency: f64,
    /// Amplitude, mm or rad.
    pub amplitude: f64,
    /// Phase at position 0, rad.
    pub phase: f64,
}

/// Drift after ISO 230-3: with the temperature of the surroundings, and while the machine warms up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Drift {
    /// Offset a kelvin, mm/K or rad/K.
    pub per_k: f64,
    /// Slope over the position a kelvin, 1/K or rad/(mm·K).
    pub slope_per_k: f64,
    /// Offset once the machine is warm, mm or rad.
    pub warm_up: f64,
    /// Time constant of warming up, min; above 0 where `warm_up` is not 0.
    pub time_constant_min: f64,
}

/// An error: mm or rad over mm (slides) or rad (spindle).
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ErrorFunction {
    /// Cosines.
    pub waves: Vec<Wave>,
    /// Coefficients of the powers 0, 1, 2 … of s = (position - middle)/half.
    pub polynomial: Vec<f64>,
    /// Middle of the travel, mm.
    pub middle: f64,
    /// Half of the travel, mm.
    pub half: f64,
    /// A table.
    pub table: Option<Table>,
    /// Forward minus backward (B of ISO 230-2), mm or rad.
    pub reversal: f64,
    /// Drift.
    pub drift: Drift,
}

impl ErrorFunction {
    /// The value at a position.
    pub(crate) fn value(&self, position: f64, direction: Direction, conditions: &Conditions) -> f64 {
        self.lasting(position, direction) + self.drift(position, conditions)
    }

    /// What does not drift.
    pub(crate) fn lasting(&self, position: f64, direction: Direction) -> f64 {
        let waves = self.waves.iter().map(|w| w.amplitude * (w.frequency * position + w.phase).cos());
        let polynomial = self.polynomial(position);
        let is_backward = direction == Direction::Backward;
        let table = self.table.as_ref().map_or(0.0, |table| table.value(position, is_backward));
        let reversal = if is_backward { -0.5 * self.reversal } else { 0.5 * self.reversal };
        waves.sum::<f64>() + polynomial + table + reversal
    }

    /// The polynomial; without one no division.
    fn polynomial(&self, position: f64) -> f64 {
        if self.polynomial.is_empty() {
            return 0.0;
        }
        let s = (position - self.middle) / self.half.max(f64::MIN_POSITIVE);
        self.polynomial.iter().rev().fold(0.0, |sum, c| sum * s + c)
    }

    /// What drifts.
    pub(crate) fn drift(&self, position: f64, conditions: &Conditions) -> f64 {
        let warmer_k = conditions.temperature_c - REFERENCE_C;
        let Drift { per_k, slope_per_k, warm_up, time_constant_min } = self.drift;
        let warm =
            if time_constant_min > 0.0 { -(-conditions.minutes / time_constant_min).exp_m1() } else { 0.0 };
        (per_k + slope_per_k * position) * warmer_k + warm_up * warm
    }
}
