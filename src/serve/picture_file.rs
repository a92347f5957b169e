//! Where `watch` leaves the newest frame: a file in a folder of this server alone.

use std::fs::{self, DirBuilder};
use std::io;
use std::path::{Path, PathBuf};

/// The file; its folder is removed with it.
#[derive(Debug)]
pub(super) struct PictureFile {
    folder: PathBuf,
    path: PathBuf,
}

impl PictureFile {
    /// A new folder in the system's place for temporary files, which others may not look into.
    ///
    /// # Errors
    /// Where the disk or the permissions refuse, or the folder is there.
    pub(super) fn new() -> io::Result<Self> {
        let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
        let name = format!("shadowgauge-{}-{:x}", std::process::id(), since.as_nanos());
        let folder = std::env::temp_dir().join(name);
        let mut builder = DirBuilder::new();
        #[cfg(unix)]
        std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
        builder.create(&folder)?;
        Ok(Self { path: folder.join("frame"), folder })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for PictureFile {
    fn drop(&mut self) {
        // a temporary file: the system clears what stays
        let _ = fs::remove_dir_all(&self.folder);
    }
}
