//! Arguments of what changes while frames come: the part's temperature and the gauge's zero.

use std::path::PathBuf;

use crate::cli::measure::scale_drift_args::ScaleDriftArgs;
use crate::cli::measure::temperature_args::seconds;
use crate::measurement::{TemperatureAge, ZeroDrift};

/// Temperatures and zeros over time.
#[derive(Debug, Default, clap::Args)]
pub(crate) struct ConditionArgs {
    /// Temperatures over time (CSV: t_ns, part_c and, where known, limit_k, head_c, scale_c), read
    /// on as the file grows or is written anew. t_ns is the host's clock (ns since 1970), of files
    /// that of frames.csv. Each frame has the last one before it; its limits grow by 0.02 K/s after
    /// 10 s.
    #[arg(long, value_name = "FILE.csv", conflicts_with_all = ["part_temperature", "temperature_cmd"])]
    pub(super) temperatures: Option<PathBuf>,
    /// Reads the thermometer by this command of the shell every 5 s: its last line is the part's
    /// temperature, °C, and where they are known its limits, ± K, the head's temperature and
    /// the scale's ("20.4,0.2,24.1,22.8"). A command that fails leaves the last temperature, which
    /// ages.
    #[arg(long, value_name = "CMD", conflicts_with = "part_temperature")]
    pub(super) temperature_cmd: Option<String>,
    /// Refuses frames whose last temperature is older. 600 unless given.
    #[arg(long, value_name = "S", visible_alias = "temperature-max-s", value_parser = seconds)]
    temperature_max_age_s: Option<f64>,
    /// When the gauge was set to zero (CSV: t_ns and, where known, head_c), one row a zero; a row
    /// that is appended counts from then on. Frames have the drift since the last zero in U, and
    /// none is good once its interval is over.
    #[arg(long, value_name = "FILE.csv", requires = "zero_interval_s")]
    pub(super) zero: Option<PathBuf>,
    /// Time after which the gauge must be set to zero again, s.
    #[arg(long, value_name = "S", requires = "zero", value_parser = seconds)]
    zero_interval_s: Option<f64>,
    /// Limits of the drift with time since the zero, ± µm/h of diameter.
    #[arg(long, value_name = "UM", requires = "zero", value_parser = drift, default_value_t = 0.0)]
    zero_um_per_h: f64,
    /// Limits of the drift with the head's temperature since the zero, ± µm/K of diameter.
    #[arg(long, value_name = "UM", requires = "zero", value_parser = drift, default_value_t = 0.0)]
    zero_um_per_k: f64,
    #[command(flatten)]
    pub(super) scale: ScaleDriftArgs,
}

fn drift(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|um| (0.0..=1e4).contains(um));
    value.ok_or_else(|| "micrometres from 0 to 10000 are needed, for instance 0.5".to_owned())
}

impl ConditionArgs {
    /// The first argument given that needs millimetres.
    pub(super) fn needs_scale(&self) -> Option<&'static str> {
        [
            (self.temperatures.is_some(), "--temperatures"),
            (self.temperature_cmd.is_some(), "--temperature-cmd"),
            (self.zero.is_some(), "--zero"),
        ]
        .into_iter()
        .find_map(|(given, name)| given.then_some(name))
        .or(self.scale.given())
    }

    /// Whether an age is limited without temperatures.
    pub(super) fn limits_no_age(&self) -> bool {
        let has_none = self.temperatures.is_none() && self.temperature_cmd.is_none();
        self.temperature_max_age_s.is_some() && has_none
    }

    /// How long temperatures hold.
    pub(super) fn age(&self) -> TemperatureAge {
        let age = TemperatureAge::default();
        let refused_age_s = self.temperature_max_age_s.unwrap_or(age.refused_age_s);
        TemperatureAge { refused_age_s, ..age }
    }

    /// The drift since a zero; `None` where no zero is given.
    pub(super) fn drift(&self) -> Option<ZeroDrift> {
        let interval_s = self.zero_interval_s?;
        Some(ZeroDrift { um_per_h: self.zero_um_per_h, um_per_k: self.zero_um_per_k, interval_s })
    }
}
