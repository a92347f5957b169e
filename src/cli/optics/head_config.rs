//! The config of a head, for commands that study it.

use std::path::Path;

use crate::cli::calibration_plan::is_plan;
use crate::cli::failure::Failure;
use crate::cli::input_output::ConfigText;
use crate::config;
use crate::studies::head::{HeadConfig, HeadError};

/// A job's config with `[camera]` and `[optics]`.
///
/// # Errors
/// Exit 2 for a config that is refused, a calibration's file, or one without a head.
pub(crate) fn load_head(path: &Path) -> Result<HeadConfig, Failure> {
    let text = ConfigText::read(path)?;
    if is_plan(&text.text) {
        return Err(text.refuse("is a calibration's file: give the job's config whose head it calibrates"));
    }
    let tables = text.tables()?;
    let job = config::load_scene(path).map_err(Failure::refused)?;
    for table in ["camera", "optics"] {
        if !tables.contains_key(table) {
            return Err(text.refuse(format!(
                "has no [{table}]: a head is its camera and its optics; `shadowgauge new pin` prints both with every key"
            )));
        }
    }
    Ok(HeadConfig { name: job.name.clone(), file: text.name, job })
}

/// A head's error with its file; settings and scenes are refused, frames and masters fail.
pub(crate) fn head_failure(file: &str, error: &HeadError) -> Failure {
    let text = format!("{file}: {error}");
    match error {
        HeadError::Calibrate(_) => Failure::fail(text),
        _ => Failure::refuse(text),
    }
}
