//! The plan of a calibration: from a file of its own, or from a job's config, with the job's
//! optical setup and master pins.

use std::path::{Path, PathBuf};

use super::failure::Failure;
use crate::cli::input_output::ConfigText;
use crate::config;
use crate::gauge::calibration::Date;
use crate::studies::calibration::CalibrationPlan;

/// A plan with its text for error messages and its folder.
pub(crate) struct LoadedPlan {
    /// The plan.
    pub plan: CalibrationPlan,
    /// Its text.
    pub text: ConfigText,
    /// The folder of its files.
    pub folder: PathBuf,
}

/// Keys that occur only in a calibration's own file.
const OF_A_PLAN: [&str; 6] = ["optics_id", "simulate", "check", "fields", "thermometer", "valid_days"];

/// Whether a text is a calibration's own file rather than a job's.
pub(crate) fn is_plan(text: &str) -> bool {
    let Ok(table) = text.parse::<toml::Table>() else { return false };
    OF_A_PLAN.iter().any(|key| table.contains_key(*key))
        || table.get("masters").is_some_and(toml::Value::is_array)
}

/// Reads the plan of a file; a plan from a job is dated `today`.
///
/// # Errors
/// Exit 2 for a text that is refused or names a file that cannot be read.
pub(crate) fn load(path: &Path, today: Date) -> Result<LoadedPlan, Failure> {
    let text = ConfigText::read(path)?;
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    if is_plan(&text.text) {
        return of_text(text, folder);
    }
    let job = config::load(path).map_err(Failure::refused)?;
    if let Some(source) = &job.source {
        tracing::warn!(
            "{}: source = \"{source}\" is not used: the pins of a job are rendered; a calibration's own file \
             (shadowgauge new calibrate) takes frames from a source",
            path.display()
        );
    }
    Ok(LoadedPlan { plan: CalibrationPlan::of_job(&job, today), text, folder })
}

/// Reads a plan's own text, with its files in `folder`.
///
/// # Errors
/// As [`load`].
pub(crate) fn of_text(text: ConfigText, folder: PathBuf) -> Result<LoadedPlan, Failure> {
    let mut plan: CalibrationPlan = text.parse()?;
    if let Some(simulate) = &mut plan.simulate {
        if let Some(name) = simulate.config.take() {
            if !simulate.has_no_setup() {
                let beside = "stands beside tables of a bench; give one of them";
                return Err(text.refuse(format!("simulate.config: {}: {beside}", name.display())));
            }
            let job = config::load(&folder.join(&name)).map_err(Failure::refused)?;
            *simulate = simulate.before_setup_of(&job);
        }
        simulate.setup().check_counts().map_err(|e| text.refuse(format!("simulate.{e}")))?;
        config::read_measured_edge(&mut simulate.optics.esf, &folder)
            .map_err(|e| text.refuse(format!("simulate.{e}")))?;
    }
    Ok(LoadedPlan { plan: plan.settled(), text, folder })
}
