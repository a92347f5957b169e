//! Electrons that gather in the dark (EMVA 1288 release 4.0, dark current): in every pixel, lit or
//! not, with the exposure and the sensor's temperature.
//!
//! ```text
//! μ = μ_I · t · 2^((T − T_ref)/T_d)       σ² = σ_d² + μ        DSNU² = DSNU_0² + (DCNU·t·2^…)²
//! ```

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::render::error::{RenderError, within};

/// The `[sensor.dark_current]` table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DarkCurrent {
    /// Dark current μ_I at `measured_at_c`, electrons a second.
    pub electrons_per_s: f64,
    /// Standard deviation of the pixels' dark currents there (DCNU), electrons a second, the same
    /// in every frame.
    pub nonuniformity_e_per_s: f64,
    /// Temperature of the sensor at which both were measured, °C.
    pub measured_at_c: f64,
    /// Rise of temperature that doubles both, K.
    pub doubling_k: f64,
    /// Temperature of the sensor, °C.
    pub temperature_c: f64,
}

impl Default for DarkCurrent {
    /// None, at 25 °C; 8 K is the middle of the 6 to 10 K of silicon near room temperature.
    fn default() -> Self {
        Self {
            electrons_per_s: 0.0,
            nonuniformity_e_per_s: 0.0,
            measured_at_c: 25.0,
            doubling_k: 8.0,
            temperature_c: 25.0,
        }
    }
}

impl DarkCurrent {
    /// Checks every value against its range.
    ///
    /// # Errors
    /// Names the key that is wrong and what would be right.
    pub(super) fn check(&self) -> Result<(), RenderError> {
        within("sensor.dark_current.electrons_per_s", self.electrons_per_s, 0.0, 1e7)?;
        within("sensor.dark_current.nonuniformity_e_per_s", self.nonuniformity_e_per_s, 0.0, 1e7)?;
        within("sensor.dark_current.measured_at_c", self.measured_at_c, -100.0, 150.0)?;
        within("sensor.dark_current.doubling_k", self.doubling_k, 1.0, 100.0)?;
        within("sensor.dark_current.temperature_c", self.temperature_c, -100.0, 150.0)
    }

    /// What gathers over an exposure.
    pub(super) fn over(&self, exposure_us: f64) -> DarkSignal {
        let doublings = (self.temperature_c - self.measured_at_c) / self.doubling_k;
        let seconds = 1e-6 * exposure_us * doublings.exp2();
        DarkSignal { mean_e: self.electrons_per_s * seconds, pattern_e: self.nonuniformity_e_per_s * seconds }
    }
}

/// What gathered in the dark.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct DarkSignal {
    /// Its mean, electrons.
    pub(crate) mean_e: f64,
    /// Its standard deviation over the pixels, electrons.
    pub(crate) pattern_e: f64,
}

impl DarkSignal {
    /// Temporal dark noise with that of these electrons, which are Poisson distributed.
    pub(crate) fn noise_e(&self, read_noise_e: f64) -> f64 {
        if self.mean_e == 0.0 { read_noise_e } else { (read_noise_e * read_noise_e + self.mean_e).sqrt() }
    }

    /// The pixels' offsets with it.
    pub(crate) fn dsnu_e(&self, dsnu_e: f64) -> f64 {
        if self.pattern_e == 0.0 { dsnu_e } else { dsnu_e.hypot(self.pattern_e) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dark_current_grows_with_exposure_and_doubles_with_temperature() {
        let sensor =
            DarkCurrent { electrons_per_s: 40.0, nonuniformity_e_per_s: 6.0, ..DarkCurrent::default() };
        let cold = sensor.over(50_000.0);
        assert!((cold.mean_e - 2.0).abs() < 1e-12 && (cold.pattern_e - 0.3).abs() < 1e-12);
        let warm = DarkCurrent { temperature_c: 41.0, ..sensor }.over(50_000.0);
        assert!((warm.mean_e - 8.0).abs() < 1e-12 && (warm.pattern_e - 1.2).abs() < 1e-12);
        assert!((warm.noise_e(1.0) - 3.0).abs() < 1e-12 && (warm.dsnu_e(0.9) - 1.5).abs() < 1e-12);
        // Without it nothing changes, to the bit.
        let none = DarkSignal::default();
        assert_eq!((none.mean_e, none.noise_e(2.4), none.dsnu_e(0.7)), (0.0, 2.4, 0.7));
    }
}
