//! Errors of reports.

use crate::run_folder::RunFolderError;

/// Why a report cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum ReportError {
    /// The run folder cannot be read.
    #[error(transparent)]
    Folder(#[from] RunFolderError),
    /// A chart or picture cannot be drawn.
    #[error("report: {0}")]
    Draw(String),
}
