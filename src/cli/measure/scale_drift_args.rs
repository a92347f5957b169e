//! Arguments of the scale's drift with its temperature.

use crate::cli::failure::Failure;
use crate::measurement::ScaleDrift;

/// Drift of the scale with its temperature.
#[derive(Debug, Default, clap::Args)]
pub(crate) struct ScaleDriftArgs {
    /// Limits of the scale's drift with its temperature since the calibration, ± ppm/K (a lens in
    /// aluminium: 23), in U. The temperature is scale_c of the temperatures, else head_c, else the
    /// camera's own; frames without one are refused.
    #[arg(long, value_name = "PPM", value_parser = ppm_per_k, requires = "scale_calibrated_c")]
    scale_ppm_per_k: Option<f64>,
    /// Temperature of the scale when it was calibrated, °C.
    #[arg(
        long,
        value_name = "C",
        value_parser = celsius,
        requires = "scale_ppm_per_k",
        allow_negative_numbers = true
    )]
    scale_calibrated_c: Option<f64>,
}

fn ppm_per_k(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|ppm| (0.0..=1e4).contains(ppm));
    value.ok_or_else(|| "ppm/K from 0 to 10000 are needed, for instance 23".to_owned())
}

fn celsius(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|c| (-50.0..=400.0).contains(c));
    value.ok_or_else(|| "a temperature from -50 to 400 °C is needed, for instance 21.5".to_owned())
}

impl ScaleDriftArgs {
    /// The drift that is stated.
    pub(crate) fn drift(&self) -> Option<ScaleDrift> {
        let (ppm_per_k, calibrated_c) = self.scale_ppm_per_k.zip(self.scale_calibrated_c)?;
        Some(ScaleDrift { ppm_per_k, calibrated_c })
    }

    /// Its name, where it is given.
    pub(crate) fn given(&self) -> Option<&'static str> {
        self.scale_ppm_per_k.map(|_| "--scale-ppm-per-k")
    }

    /// Refuses it where no temperatures are given.
    ///
    /// # Errors
    /// Exit 2.
    pub(super) fn check(&self, has_temperatures: bool) -> Result<(), Failure> {
        match self.given() {
            Some(name) if !has_temperatures => Err(Failure::refuse(format!(
                "{name} needs the scale's temperature: give --temperatures FILE.csv; cameras and their recordings may have their own"
            ))),
            _ => Ok(()),
        }
    }
}
