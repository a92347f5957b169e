//! The target of an output.

use std::fs::{File, Metadata};
use std::io;
use std::path::{Path, PathBuf};

use super::error::OutputError;
use super::names::TEMPORARY;

/// Most links followed; more are taken for a cycle.
const MOST_LINKS: usize = 40;

/// Where an output goes.
pub(super) enum Place {
    /// The process's own stdout.
    Stdout,
    /// Something other than a file that takes bytes: a FIFO, a terminal, `/dev/null`.
    Through(PathBuf),
    /// A file, existing or new, links followed.
    File {
        /// The path behind all links.
        path: PathBuf,
        /// Metadata of the existing file, if any.
        before: Option<Metadata>,
    },
}

/// The target at `path`, links followed.
///
/// # Errors
/// A folder, a block device, a file without permission to write.
pub(super) fn of(path: &Path) -> Result<Place, OutputError> {
    if is_stdout(path) {
        return Ok(Place::Stdout);
    }
    let found = match std::fs::metadata(path) {
        Ok(found) => found,
        Err(e) if e.kind() == io::ErrorKind::NotFound => {
            let path = behind_links(path).map_err(OutputError::failed(path))?;
            return Ok(Place::File { path, before: None });
        }
        Err(cause) => return Err(OutputError::Failed { path: path.to_owned(), cause }),
    };
    if found.is_dir() {
        return Err(OutputError::refused(path, "is a folder; give a file"));
    }
    if is_block_device(&found) {
        return Err(OutputError::refused(path, "is a block device; give a file"));
    }
    if !found.is_file() {
        return Ok(Place::Through(path.to_owned()));
    }
    if found.permissions().readonly() {
        let cause = io::Error::new(io::ErrorKind::PermissionDenied, "it is read-only");
        return Err(OutputError::Failed { path: path.to_owned(), cause });
    }
    let target = behind_links(path).map_err(OutputError::failed(path))?;
    Ok(Place::File { path: target, before: Some(found) })
}

fn is_stdout(path: &Path) -> bool {
    ["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"].iter().any(|name| path == Path::new(name))
}

/// The path behind all links; the target may be absent.
pub(super) fn behind_links(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    for _ in 0..MOST_LINKS {
        match std::fs::read_link(&path) {
            Ok(next) => path = folder_of(&path).join(next),
            // Not a link, or absent.
            Err(_) => return Ok(path),
        }
    }
    Err(io::Error::other("too many links"))
}

/// The folder that a path lies in.
pub(super) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The temporary name beside a path.
pub(super) fn temporary(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    folder_of(path).join(format!("{TEMPORARY}{name}"))
}

/// Whether both paths name one file that exists.
pub(crate) fn is_same_file(a: &Path, b: &Path) -> bool {
    match (std::fs::metadata(a), std::fs::metadata(b)) {
        (Ok(a), Ok(b)) => same(&a, &b),
        _ => false,
    }
}

/// Whether a path still names an open file.
pub(super) fn is_open_file(path: &Path, file: &File) -> bool {
    match (std::fs::symlink_metadata(path), file.metadata()) {
        (Ok(a), Ok(b)) => same(&a, &b),
        _ => false,
    }
}

#[cfg(unix)]
fn same(a: &Metadata, b: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

/// Without inode numbers: by name alone.
#[cfg(not(unix))]
fn same(a: &Metadata, b: &Metadata) -> bool {
    a.len() == b.len() && a.modified().ok() == b.modified().ok()
}

#[cfg(unix)]
fn is_block_device(found: &Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt as _;
    found.file_type().is_block_device()
}

#[cfg(not(unix))]
fn is_block_device(_: &Metadata) -> bool {
    false
}

/// Replaces a file in a folder that this process has locked: under a temporary name, then renamed;
/// creates its parent folder.
///
/// # Errors
/// Where the disk or the permissions refuse; no partial file remains under `path`.
pub(crate) fn replace(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let (target, before) = match of(path)? {
        Place::File { path, before } => (path, before),
        Place::Stdout | Place::Through(_) => return Err(OutputError::refused(path, "is no file")),
    };
    let temporary = temporary(&target);
    let written = std::fs::create_dir_all(folder_of(&target))
        .and_then(|()| std::fs::write(&temporary, bytes))
        .and_then(|()| put(&temporary, &target, before.as_ref()));
    written.map_err(|cause| {
        let _ = std::fs::remove_file(&temporary);
        OutputError::Failed { path: path.to_owned(), cause }
    })
}

/// Gives a complete temporary file the mode and the name of the old one.
pub(super) fn put(temporary: &Path, target: &Path, before: Option<&Metadata>) -> io::Result<()> {
    if let Some(before) = before {
        std::fs::set_permissions(temporary, before.permissions())?;
    }
    std::fs::rename(temporary, target)
}
