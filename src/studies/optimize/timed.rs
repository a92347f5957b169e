//! What a benchmark runs of both methods.

use super::config::{GeneticSettings, OptimizeConfig};
use super::problem::Problem;
use super::{exact, genetic};
use crate::setting::SettingError;

/// A problem whose optimum is sought by both methods.
#[derive(Clone, Debug)]
pub struct TimedProblem {
    problem: Problem,
    settings: GeneticSettings,
}

impl TimedProblem {
    /// The problem of a config as TOML (`shadowgauge optimize`).
    ///
    /// # Errors
    /// A text that is no config, and settings out of range.
    pub fn parse(config: &str) -> Result<Self, SettingError> {
        let config: OptimizeConfig =
            toml::from_str(config).map_err(|e| SettingError::at("optimize", e.to_string()))?;
        Ok(Self { problem: Problem::new(&config)?, settings: GeneticSettings::default() })
    }

    /// Least machining time that the genetic algorithm finds, min; `None` where nothing is allowed.
    pub fn genetic_min(&self, seed: u64) -> Option<f64> {
        genetic::minimise(&self.problem, &self.settings, seed).map(|best| best.solution.time_min)
    }

    /// Least machining time, proven to 1e-4 of it, min; `None` where nothing is allowed.
    pub fn exact_min(&self) -> Option<f64> {
        exact::minimise(&self.problem, exact::DEFAULT_GAP).map(|optimum| optimum.solution.time_min)
    }
}
