//! The recording of what is watched: `--record FILE.mcap`.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::cli::failure::Failure;
use crate::source::live::Producer;
use crate::source::mcap::{Recorded, Tap};

/// A recording that is being written.
pub(super) struct Recording {
    path: PathBuf,
    recorded: Recorded,
}

impl Recording {
    /// Records the frames of a producer in a new file; a source that `waits` is held up by a slow
    /// disk.
    ///
    /// # Errors
    /// Exit 2 for a file that is there already; 3 for one that cannot be written.
    pub(super) fn begin(
        producer: Box<dyn Producer>,
        path: &Path,
        waits: bool,
    ) -> Result<(Box<dyn Producer>, Self), Failure> {
        let shown = path.display();
        let begun = Tap::begin(producer, path, waits).map_err(|error| match error.kind() {
            ErrorKind::AlreadyExists => Failure::refuse(format!(
                "--record {shown}: the file is there already, and a recording is not written over; name a new one"
            )),
            _ => Failure::fail(format!("{shown}: {error}")),
        });
        let (tap, recorded) = begun?;
        Ok((Box::new(tap), Self { path: path.to_owned(), recorded }))
    }

    /// Ends the file, after the source is gone, and logs how many frames are in it.
    ///
    /// # Errors
    /// Where the disk refused.
    pub(super) fn finish(self) -> Result<(), Failure> {
        let shown = self.path.display();
        let finished = self.recorded.finish();
        let [written, left_out] = finished.map_err(|error| Failure::fail(format!("{shown}: {error}")))?;
        tracing::info!("{shown}: {written} frames are recorded");
        if left_out > 0 {
            tracing::warn!(
                "{shown}: {left_out} frames are not in the recording: the disk was slower than the source"
            );
        }
        Ok(())
    }
}
