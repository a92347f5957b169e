//! Why the study cannot be carried out.

use crate::closed_loop::LoopError;
use crate::gauge::generatrix::GeneratrixError;
use crate::render::RenderError;
use crate::setting::SettingError;
use crate::tool::ToolError;

/// What stops it.
#[derive(Debug, thiserror::Error)]
pub(crate) enum WornToolError {
    /// A value out of range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// An insert that cannot be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A nose that cannot be measured.
    #[error("the rendered nose: {0}")]
    Nose(String),
    /// A program that is refused.
    #[error("{0}")]
    Program(ToolError),
    /// A program that the paper's mode gives no figures for.
    #[error("the paper's way measures no nose here: {0}")]
    Paper(String),
    /// A surface on which a size cannot be measured.
    #[error("workpiece {workpiece}: {what}")]
    Surface {
        /// Its number.
        workpiece: usize,
        /// What is not there.
        what: &'static str,
    },
    /// A frame that does not show the pieces of a workpiece.
    #[error("a frame of the workpiece: {0}")]
    Frame(#[from] GeneratrixError),
    /// A loop that fails.
    #[error(transparent)]
    Loop(#[from] LoopError),
}

impl WornToolError {
    /// Whether it concerns one program alone.
    pub(super) fn is_of_program(&self) -> bool {
        matches!(self, Self::Program(_) | Self::Paper(_) | Self::Surface { .. } | Self::Frame(_))
    }
}

impl From<ToolError> for WornToolError {
    fn from(error: ToolError) -> Self {
        Self::Program(error)
    }
}
