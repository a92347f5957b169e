//! Outputs of every command: one place that decides what may be written, and how.
//!
//! A file is written under a temporary name beside its place and renamed, so that no reader sees
//! half of it and the file before stays until the new one is whole. A link is followed and stays a
//! link, the mode of the file before is kept. What is no file (`/dev/null`, a FIFO, a terminal) is
//! written through; `-` and `/dev/stdout` are the process's own stdout, which takes one output.
//! Refused are the command's own inputs, the file that stdout or stderr goes to, block devices, and
//! what another process is writing.
//!
//! Temporary names are fixed, and whoever writes holds an OS lock on them (`flock`; gone with its
//! holder, however it ended). So a second process gets the name of the holder, and what a killed
//! one left is found unlocked and cleared by the next.
//!
//! [`OutputFile`] is one file, [`OutputFolder`] a folder that stands in its place once it is
//! finished; `place` decides what may be written, `lock` and `names` keep others out. `error`
//! separates what is refused from what fails.

mod error;
mod file;
mod folder;
mod lock;
mod names;
mod place;

pub use error::OutputError;
pub use file::OutputFile;
pub use folder::{OutputFolder, clear, clear_temporary, make_folder};
pub use lock::Lock;
pub use names::{LOCK_NAME, TEMPORARY};
pub use place::{is_same_file, replace};
