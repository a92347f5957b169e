//! A setting of a job that cannot be right, and the stages' refusals as such.

use thiserror::Error;

use crate::control::ControlError;
use crate::nc::NcError;
use crate::render::RenderError;

/// A setting that cannot be right, with the dotted key it stands under.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{key}: {problem}")]
pub struct JobError {
    /// Dotted key as in the TOML file, e.g. `optics.magnification`.
    pub key: String,
    /// What is wrong and what would be right.
    pub problem: String,
}

impl JobError {
    /// An error at `key`.
    pub fn at(key: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { key: key.into(), problem: problem.into() }
    }
}

/// A renderer's refusal as one of the job.
pub fn from_render(error: RenderError) -> JobError {
    match error {
        RenderError::Setting { key, found, right } => JobError::at(key, format!("{found} {right}")),
        other => JobError::at("optics", other.to_string()),
    }
}

pub(super) fn from_control(error: ControlError) -> JobError {
    match error {
        ControlError::Setting { key, value, right } => JobError::at(key, format!("{value} must be {right}")),
        other => JobError::at("control", other.to_string()),
    }
}

pub(super) fn from_nc(error: NcError) -> JobError {
    match error {
        NcError::Setting { key, value, right } => {
            JobError::at(key.replacen("nc.", "nc.machine.", 1), format!("{value} must be {right}"))
        }
        other => JobError::at("nc.machine", other.to_string()),
    }
}

pub(super) fn positive(key: &str, value: f64) -> Result<(), JobError> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(JobError::at(key, format!("{value} must be a positive number")))
    }
}
