//! Errors of the stages as refused settings of a job.

use crate::control::ControlError;
use crate::nc::NcError;
#[cfg(feature = "render")]
use crate::render::RenderError;
use crate::setting::SettingError;

/// An error of the renderer as one of the job.
#[cfg(feature = "render")]
pub(crate) fn from_render(error: RenderError) -> SettingError {
    match error {
        RenderError::Setting(error) => error,
        other => SettingError::at("optics", other.to_string()),
    }
}

pub(super) fn from_control(error: ControlError) -> SettingError {
    match error {
        ControlError::Setting(error) => error,
        other => SettingError::at("control", other.to_string()),
    }
}

pub(super) fn from_nc(error: NcError) -> SettingError {
    match error {
        NcError::Setting(e) => SettingError { key: e.key.replacen("nc.", "nc.machine.", 1), ..e },
        other => SettingError::at("nc.machine", other.to_string()),
    }
}
