//! Errors of the renderer.

use thiserror::Error;

use crate::setting::SettingError;

/// Errors of the render stage.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum RenderError {
    /// A setting outside its range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The shaft does not fit the field of view.
    #[error("{what}")]
    Field {
        /// The part outside the field, by how much, and what would fit.
        what: String,
    },
    /// The shaft cannot be drawn.
    #[error("shaft: {what}")]
    Shaft {
        /// What is wrong with it, and the valid values.
        what: String,
    },
    /// No adapter of the requested kind.
    #[error("no {wanted} adapter: {why}; `doctor` lists what is missing, `--backend cpu` needs none")]
    NoAdapter {
        /// The requested backend.
        wanted: &'static str,
        /// The driver's message.
        why: String,
    },
    /// The adapter cannot hold a frame of this size.
    #[error("{what}")]
    TooLarge {
        /// The size needed and the adapter's limit.
        what: String,
    },
    /// The device refused or was lost.
    #[error("the rendering device failed: {what}")]
    Device {
        /// The driver's message.
        what: String,
    },
}

impl RenderError {
    /// An error for a setting.
    pub(crate) fn setting(
        key: &'static str,
        found: &(impl ToString + ?Sized),
        right: impl Into<String>,
    ) -> Self {
        let found = Some(found.to_string());
        Self::Setting(SettingError { found, ..SettingError::at(key, right) })
    }
}

/// Refuses a number that is not finite or outside `low..=high`.
pub(crate) fn within(key: &'static str, value: f64, low: f64, high: f64) -> Result<(), RenderError> {
    if value.is_finite() && (low..=high).contains(&value) {
        return Ok(());
    }
    Err(RenderError::setting(key, &value, format!("must lie in {low} to {high}")))
}
