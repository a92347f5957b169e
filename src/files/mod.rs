//! Outputs of every command: the one place that decides which files may be written, and how.
//!
//! A file is written under a temporary name beside its place and renamed, so that no reader gets
//! half a file and the old one stays until the new one is complete. A link is followed and stays a
//! link, the mode of the old file is kept. Other targets (`/dev/null`, a FIFO, a terminal) are
//! written directly; `-` and `/dev/stdout` are the process's own stdout, which takes one output.
//! Refused are the command's own inputs, the file that stdout or stderr goes to, block devices, and
//! outputs that another process is writing.
//!
//! Temporary names are fixed, and the writing process holds an OS lock on them (`flock`, released
//! when the process ends in any way). A second process therefore gets the name of the holder, and
//! the next one finds the remains of a killed process unlocked and clears them.
//!
//! [`OutputFile`] is one file, [`OutputFolder`] a folder that appears in its place once it is
//! finished; `place` decides what may be written, `lock` and `names` exclude other processes.
//! `error` separates refusals from failures.

mod error;
mod file;
mod folder;
mod lock;
mod names;
mod place;

pub(crate) use error::OutputError;
pub(crate) use file::{OpenOutput, OutputFile};
pub(crate) use folder::{OutputFolder, clear, clear_temporary, make_folder};
pub(crate) use lock::Lock;
pub(crate) use names::{LOCK_NAME, TEMPORARY};
pub(crate) use place::replace;
