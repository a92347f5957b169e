//! Why the rows cannot be computed.

use crate::nose::NoseError;
use crate::setting::SettingError;
use crate::tool::ToolError;

/// Inputs that are refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum ReproductionError {
    /// A value out of range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// Radii that are no nose.
    #[error(transparent)]
    Nose(#[from] NoseError),
    /// A nose that cannot be set or driven along the part.
    #[error(transparent)]
    Tool(#[from] ToolError),
}
