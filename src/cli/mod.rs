//! The command line: one file a subcommand. `main.rs` parses, calls, prints the error.
//!
//! Exit codes: 0 done, in tolerance where one is given; 1 a given tolerance is exceeded; 2 the command line or the
//! config is refused; 3 a file, an image, an output or a device fails. Data on stdout, logs on stderr.

/// How a command that did its work ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Done; in tolerance where one is given. Exit 0.
    Done,
    /// Done, but a given tolerance is exceeded. Exit 1.
    OutOfTolerance,
}

/// Why a command stopped, with the exit code that belongs to it.
#[derive(Debug)]
pub struct Failure {
    /// 2 refused, 3 failed.
    pub exit: u8,
    /// What a person reads.
    pub report: miette::Report,
}

impl Failure {
    /// The command line or the config is refused: exit 2.
    pub fn refused(report: impl Into<miette::Report>) -> Self {
        Self { exit: 2, report: report.into() }
    }

    /// A file, an image, an output or a device fails: exit 3.
    pub fn failed(report: impl Into<miette::Report>) -> Self {
        Self { exit: 3, report: report.into() }
    }
}

/// What every subcommand returns.
pub type CommandResult = Result<Outcome, Failure>;
