//! An OS lock that a process holds on an output while it writes it.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read as _, Seek as _, Write as _};
use std::path::{Path, PathBuf};

use super::error::OutputError;
use super::place::is_open_file;

/// Longest name of a holder that is read, bytes.
const LONGEST_HOLDER: u64 = 300;

/// Attempts to lock a file that other processes move away.
const ATTEMPTS: usize = 100;

/// A locked file with the name of its holder; removed when the lock ends, unless it was moved away.
#[derive(Debug)]
pub(crate) struct Lock {
    path: PathBuf,
    file: File,
}

impl Lock {
    /// Takes the lock at `path`, creating the file, for the output `of`.
    ///
    /// # Errors
    /// [`OutputError::Held`] where another process has it; [`OutputError::Failed`] where the file
    /// cannot be made.
    pub(crate) fn take(path: &Path, of: &Path) -> Result<Self, OutputError> {
        for _ in 0..ATTEMPTS {
            let mut file = OpenOptions::new()
                .read(true)
                .write(true)
                .create(true)
                .truncate(false)
                .open(path)
                .map_err(OutputError::failed(of))?;
            match file.try_lock() {
                Err(TryLockError::WouldBlock) => {
                    return Err(OutputError::Held { path: of.to_owned(), holder: holder(&mut file) });
                }
                // A file system without locks: continue without one.
                Err(TryLockError::Error(cause)) => tracing::debug!("{}: no lock: {cause}", path.display()),
                Ok(()) => {}
            }
            // Between opening and locking its last holder may have moved or removed it.
            if is_open_file(path, &file) {
                let mut lock = Self { path: path.to_owned(), file };
                lock.name_holder().map_err(OutputError::failed(of))?;
                return Ok(lock);
            }
        }
        let cause = std::io::Error::other(format!("{} changes all the time", path.display()));
        Err(OutputError::Failed { path: of.to_owned(), cause })
    }

    fn name_holder(&mut self) -> std::io::Result<()> {
        let words = std::env::args_os().skip(1).take(2);
        let command: Vec<String> = words.map(|word| word.to_string_lossy().into_owned()).collect();
        self.file.set_len(0)?;
        self.file.rewind()?;
        write!(self.file, "process {} (shadowgauge {})", std::process::id(), command.join(" "))?;
        self.file.flush()
    }

    /// The locked file, truncated, for writing.
    pub(super) fn emptied(&mut self) -> std::io::Result<&mut File> {
        self.file.set_len(0)?;
        self.file.rewind()?;
        Ok(&mut self.file)
    }

    /// Path of the file.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Removed while the lock is still held, so that no other process has it. A file that was
        // moved away is not removed.
        if is_open_file(&self.path, &self.file) {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

fn holder(file: &mut File) -> String {
    let mut text = String::new();
    let read = file.take(LONGEST_HOLDER).read_to_string(&mut text);
    if read.is_ok() && text.starts_with("process") { text } else { "another process".to_owned() }
}
