//! What a program that decides offsets can do wrong.

use thiserror::Error;

/// A program that cannot decide: which, and what it did.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("controller {program}: {fault}")]
pub struct ProgramError {
    /// Its name and command.
    pub program: String,
    /// What it did.
    pub fault: Fault,
}

/// What a program did.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Fault {
    /// It cannot be started.
    #[error("cannot be started: {0}")]
    NotStarted(String),
    /// It takes no further input, or its output cannot be read.
    #[error("lost at pass {pass}: {cause}")]
    Lost {
        /// The pass whose reply was due.
        pass: u32,
        /// What the stream reports.
        cause: String,
    },
    /// It ended, or closed its output, before its reply.
    #[error(
        "ended before its reply to pass {pass}{how}: it must reply one line to every pass and run until the line \
         `end` or the end of its input"
    )]
    Ended {
        /// The pass whose reply was due.
        pass: u32,
        /// How it ended, where that is known: " (…)".
        how: String,
    },
    /// It did not reply in time.
    #[error("no reply to pass {pass}: {limit}")]
    Late {
        /// The pass whose reply was due.
        pass: u32,
        /// The limit, in words.
        limit: String,
    },
    /// Its reply is none.
    #[error(
        "line {line} of its output, the reply to pass {pass}, {why}: {text}\nright is one line, \
         {{\"offsets_mm\": […]}} with {stations} numbers (mm of diameter, a station each) or {{\"hold\": \"the reason\"}}; \
         remarks belong on stderr"
    )]
    Reply {
        /// The line, from 1.
        line: u64,
        /// The pass that it replies to.
        pass: u32,
        /// What is wrong with it.
        why: String,
        /// The line, shortened.
        text: String,
        /// Stations of the part.
        stations: usize,
    },
}
