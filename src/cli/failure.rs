//! How a command ends: its outcome, or a failure with its exit code.

use crate::files::OutputError;
use crate::run_folder::RunFolderError;

/// Exit codes and what each means; a command that is interrupted ends with the shell's 130, a
/// stream with 0 or 1.
pub(crate) const EXIT_CODES: [(u8, &str); 4] = [
    (0, "done; where a tolerance is given, proven in tolerance"),
    (
        1,
        "done, but a tolerance is exceeded or not proven, an alarm ended a run, or a study's limit is missed",
    ),
    (2, "the command line, a config or a program is refused, or another process writes the output"),
    (3, "a file, an image, an output or a device failed"),
];

/// Outcome of a command that did its work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// Done; in tolerance where one is given. Exit 0.
    Done,
    /// Done, but a given tolerance is exceeded. Exit 1.
    OutOfTolerance,
}

/// Why a command stopped, with its exit code.
#[derive(Debug)]
pub(crate) struct Failure {
    /// 2 refused, 3 failed.
    pub exit: u8,
    /// The message for the user.
    pub report: miette::Report,
}

impl Failure {
    /// The command line or the config is refused: exit 2.
    pub(crate) fn refused(report: impl Into<miette::Report>) -> Self {
        Self { exit: 2, report: report.into() }
    }

    /// A file, an image, an output or a device fails: exit 3.
    pub(crate) fn failed(report: impl Into<miette::Report>) -> Self {
        Self { exit: 3, report: report.into() }
    }

    /// As [`Self::refused`], from an error of the library or a text.
    pub(crate) fn refuse(error: impl std::fmt::Display) -> Self {
        Self::refused(miette::miette!("{error}"))
    }

    /// As [`Self::failed`], from an error of the library or a text.
    pub(crate) fn fail(error: impl std::fmt::Display) -> Self {
        Self::failed(miette::miette!("{error}"))
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        if error.is_refusal() { Self::refuse(error) } else { Self::fail(error) }
    }
}

/// Result of every subcommand.
pub(crate) type CommandResult = Result<Outcome, Failure>;

/// A folder that is taken is refused; one that cannot be written or read fails.
pub(crate) fn folder_failure(error: RunFolderError) -> Failure {
    match error {
        RunFolderError::Taken { .. } => Failure::refuse(error),
        RunFolderError::Output(error) => error.into(),
        other => Failure::fail(other),
    }
}
