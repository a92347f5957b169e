//! An output folder that appears complete or not at all.

use std::fs::DirEntry;
use std::io;
use std::path::{Path, PathBuf};

use super::error::OutputError;
use super::lock::Lock;
use super::names::{LOCK_NAME, TEMPORARY};
use super::place::{behind_links, folder_of, temporary};

/// A folder, absent or empty before, that is filled under a temporary name: beside its place where
/// it is absent, inside it where it exists (it may be a mount point, or have a mode of its own). If
/// dropped before [`OutputFolder::finish`], it leaves nothing.
#[derive(Debug)]
pub(crate) struct OutputFolder {
    named: PathBuf,
    target: PathBuf,
    staging: PathBuf,
    stands: bool,
    finished: bool,
    /// Held until the folder is complete.
    _lock: Lock,
}

/// Attempts to claim a folder that its last holder is just moving into place.
const ATTEMPTS: usize = 3;

/// Refuses a path that is neither absent nor an empty folder; returns whether it exists.
fn check(named: &Path, target: &Path) -> Result<bool, OutputError> {
    if named == Path::new("-") {
        return Err(OutputError::refused(named, "is stdout; a folder is needed"));
    }
    match std::fs::read_dir(target) {
        Ok(entries) => {
            let theirs = |name: &std::ffi::OsStr| !name.to_string_lossy().starts_with(TEMPORARY);
            if entries.filter_map(Result::ok).any(|entry| theirs(&entry.file_name())) {
                return Err(OutputError::refused(named, "is not empty; --out must be absent or empty"));
            }
            Ok(true)
        }
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(e) if e.kind() == io::ErrorKind::NotADirectory => {
            Err(OutputError::refused(named, "is no folder; give one that is absent or empty"))
        }
        Err(cause) => Err(OutputError::Failed { path: named.to_owned(), cause }),
    }
}

impl OutputFolder {
    /// Claims `path` and clears the remains of a killed command.
    ///
    /// # Errors
    /// Anything but an absent or empty folder; one that another process fills; a disk or
    /// permissions that refuse.
    pub(crate) fn claim(path: &Path) -> Result<Self, OutputError> {
        let target = behind_links(path).map_err(OutputError::failed(path))?;
        if target.file_name().is_none() && !target.is_dir() {
            return Err(OutputError::refused(path, "names no folder"));
        }
        for _ in 1..ATTEMPTS {
            match Self::attempt(path, &target) {
                Err(OutputError::Failed { cause, .. }) if cause.kind() == io::ErrorKind::NotFound => {}
                claimed => return claimed,
            }
        }
        Self::attempt(path, &target)
    }

    fn attempt(path: &Path, target: &Path) -> Result<Self, OutputError> {
        let stands = check(path, target)?;
        let staging = if stands { target.join(format!("{TEMPORARY}partial")) } else { temporary(target) };
        if staging.is_file() {
            // A killed command was writing a file of that name.
            drop(Lock::take(&staging, path)?);
        }
        std::fs::create_dir_all(&staging).map_err(OutputError::failed(path))?;
        let lock = Lock::take(&staging.join(LOCK_NAME), path)?;
        let (named, target) = (path.to_owned(), target.to_owned());
        let folder = Self { named, target, staging, stands, finished: false, _lock: lock };
        // Its last holder may have finished since.
        check(path, &folder.target)?;
        clear(&folder.staging)?;
        Ok(folder)
    }

    /// Writes a file; its name may contain folders.
    ///
    /// # Errors
    /// Where the disk or the permissions refuse.
    pub(crate) fn write(&self, name: impl AsRef<Path>, bytes: &[u8]) -> Result<(), OutputError> {
        let path = self.staging.join(&name);
        std::fs::create_dir_all(folder_of(&path))
            .and_then(|()| std::fs::write(&path, bytes))
            .map_err(|cause| OutputError::Failed { path: self.named.join(name), cause })
    }

    /// Puts the whole folder in its place.
    ///
    /// # Errors
    /// Where the disk or the permissions refuse.
    pub(crate) fn finish(mut self) -> Result<(), OutputError> {
        let moved = if self.stands {
            std::fs::read_dir(&self.staging).and_then(|entries| {
                for entry in entries {
                    let name = entry?.file_name();
                    if name != LOCK_NAME {
                        std::fs::rename(self.staging.join(&name), self.target.join(&name))?;
                    }
                }
                Ok(())
            })
        } else {
            // The lock moves with it and is held until it is removed, so that no other process
            // takes the folder for remains.
            std::fs::rename(&self.staging, &self.target)
                .and_then(|()| std::fs::remove_file(self.target.join(LOCK_NAME)))
        };
        moved.map_err(OutputError::failed(&self.named))?;
        self.finished = !self.stands;
        Ok(())
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        // After the move, nothing under the temporary name belongs to this process.
        if !self.finished {
            let _ = std::fs::remove_dir_all(&self.staging);
        }
    }
}

/// Creates a folder, following a dangling link.
///
/// # Errors
/// Where the disk or the permissions refuse.
pub(crate) fn make_folder(path: &Path) -> Result<(), OutputError> {
    behind_links(path).and_then(std::fs::create_dir_all).map_err(OutputError::failed(path))
}

/// Removes all contents of a folder except its lock.
///
/// # Errors
/// Where the disk or the permissions refuse.
pub(crate) fn clear(folder: &Path) -> Result<(), OutputError> {
    each_entry(folder, &|entry| remove(entry)).map_err(OutputError::failed(folder))
}

/// Removes everything under temporary names in a folder and its subfolders, except its lock: the
/// remains of a killed command.
///
/// # Errors
/// Where the disk or the permissions refuse.
pub(crate) fn clear_temporary(folder: &Path) -> Result<(), OutputError> {
    clear_temporary_in(folder).map_err(OutputError::failed(folder))
}

fn clear_temporary_in(folder: &Path) -> io::Result<()> {
    each_entry(folder, &|entry| {
        if entry.file_name().to_string_lossy().starts_with(TEMPORARY) {
            remove(entry)
        } else if entry.file_type()?.is_dir() {
            clear_temporary_in(&entry.path())
        } else {
            Ok(())
        }
    })
}

fn each_entry(folder: &Path, each: &dyn Fn(&DirEntry) -> io::Result<()>) -> io::Result<()> {
    std::fs::read_dir(folder)?.try_for_each(|entry| {
        let entry = entry?;
        if entry.file_name() == LOCK_NAME { Ok(()) } else { each(&entry) }
    })
}

fn remove(entry: &DirEntry) -> io::Result<()> {
    if entry.file_type()?.is_dir() {
        std::fs::remove_dir_all(entry.path())
    } else {
        std::fs::remove_file(entry.path())
    }
}
