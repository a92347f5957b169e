//! The machines of the study by their numbers, and its result from their figures.

use serde::{Deserialize, Serialize};

use super::drawn;
use super::figures::{Off, compensated};
use super::frames::midline_text;
use super::part;
use super::rows::{MachineCoverage, row, scatter_percent};
use crate::identification::instrument::Instrument;
use crate::identification::{IdentificationConfig, checked_set, identify};
use crate::job::Job;
use crate::setting::{SettingError, require};
use crate::studies::machine_readings::SimulatedMachine;
use crate::studies::sharding::{Cell, ColumnKind, Columns, SceneStudy};

/// Most machines: ten times what separates 95 from 95.5 %.
const MOST_MACHINES: u32 = 100_000;

/// What is drawn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MachineCoveragePlan {
    /// The plan of readings.
    pub config: IdentificationConfig,
    /// Machines.
    pub machines: u32,
    /// Seed of the draws.
    pub seed: u64,
    /// A job on whose part and before whose camera every midline is read; else its readings are
    /// simulated as stated.
    pub frames: Option<Job>,
}

impl MachineCoveragePlan {
    /// The figures of all machines in their order.
    pub(crate) fn result(&self, machines: &[Vec<Off>]) -> MachineCoverage {
        let all: Vec<&Off> = machines.iter().flatten().collect();
        let mut names: Vec<&str> = all.iter().map(|off| off.figure.as_ref()).collect();
        names.sort_unstable();
        names.dedup();
        let named = |name: &str| all.iter().copied().filter(|off| off.figure == name).collect::<Vec<_>>();
        MachineCoverage {
            machines: self.machines,
            seed: self.seed,
            figures: names.iter().map(|name| row(name, &named(name))).collect(),
            together: row("all figures", &all),
            scatter_percent: scatter_percent(machines),
            through_frames: self.frames.is_some(),
        }
    }
}

impl SceneStudy for MachineCoveragePlan {
    const NAME: &'static str = "machine-coverage";
    /// A machine has as many figures as its plan seeks: a list of them as JSON, which keeps every
    /// digit.
    const COLUMNS: Columns = &[("figures_json", ColumnKind::Text)];
    type Outcome = Vec<Off>;
    type Bench = ();
    type Error = SettingError;

    fn seed(&self) -> u64 {
        self.seed
    }

    fn scenes(&self) -> u64 {
        u64::from(self.machines)
    }

    fn bench(&self) -> Result<(), SettingError> {
        let right = format!("between 1 and {MOST_MACHINES}");
        require((1..=MOST_MACHINES).contains(&self.machines), "--machines", self.machines, &right)?;
        self.config.check()?;
        let readings = &self.config.readings;
        if let Some(k) = readings.iter().position(|set| set.plan.is_none()) {
            let why = "is needed: readings of drawn machines are simulated at the places of a plan";
            return Err(SettingError::at(format!("readings[{k}].plan"), why));
        }
        let has_midline = readings.iter().any(|set| set.instrument == Instrument::Midline);
        if self.frames.is_some() && !has_midline {
            let why = "needs a set of readings with instrument = \"midline\"";
            return Err(SettingError::at("--frames", why));
        }
        for (number, set) in readings.iter().enumerate() {
            if let (Some(job), Some(stated)) = (&self.frames, &set.part) {
                part::check(job, stated, number)?;
            }
        }
        Ok(())
    }

    fn scene(&self, number: u64, (): &()) -> Result<Vec<Off>, SettingError> {
        // sets of one machine have seeds that follow each other
        let seed = self.seed.wrapping_mul(1_000_003).wrapping_add(1000 * number);
        let config = &self.config;
        let truth = drawn::machine(config, seed)?;
        let simulated = SimulatedMachine::new(truth.clone(), config.temperature_c, seed)?;
        let set = |k: usize| {
            let set = &config.readings[k];
            let text = match (&self.frames, &set.plan, set.instrument) {
                (Some(job), Some(plan), Instrument::Midline) => {
                    midline_text(job, &truth, config.temperature_c, plan, seed)?
                }
                _ => simulated.text(set, k)?,
            };
            checked_set(config, k, text.as_bytes(), "simulated readings")
        };
        let sets: Result<Vec<_>, SettingError> = (0..config.readings.len()).map(set).collect();
        let found = identify(config, &sets?)?;
        compensated(config, &found, &truth)
    }

    fn row(outcome: &Vec<Off>) -> Vec<Cell> {
        // Names and finite numbers: JSON holds them all. An empty text is read as damaged.
        vec![Cell::Text(serde_json::to_string(outcome).unwrap_or_default())]
    }

    fn outcome(row: &[Cell]) -> Option<Vec<Off>> {
        match row {
            [Cell::Text(text)] => serde_json::from_str(text).ok(),
            _ => None,
        }
    }
}
