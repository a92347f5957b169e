//! One file that a command writes.

use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use super::error::OutputError;
use super::lock::Lock;
use super::names::LOCK_NAME;
use super::place::{self, Place, is_same_file};

/// Whether an output has taken stdout.
static STDOUT_IS_TAKEN: AtomicBool = AtomicBool::new(false);

/// An output file claimed by this process: one that may not be written is refused before any work
/// is done. If dropped unwritten, it leaves the old file as it was.
#[derive(Debug)]
pub(crate) struct OutputFile {
    named: PathBuf,
    to: To,
}

#[derive(Debug)]
enum To {
    Stdout,
    Through(PathBuf),
    File { target: PathBuf, before: Option<Box<Metadata>>, lock: Lock },
}

impl OutputFile {
    /// Claims `path`, which must not be one of the command's `inputs`; creates its parent folder.
    ///
    /// # Errors
    /// An input, a folder, a block device, the file that stdout goes to, stdout twice, an output
    /// that another process writes; a disk or permissions that refuse.
    pub(crate) fn claim(path: &Path, inputs: impl IntoIterator<Item = PathBuf>) -> Result<Self, OutputError> {
        let named = path.to_owned();
        if let Some(input) = inputs.into_iter().find(|input| is_same_file(path, input)) {
            let what = if input == path { String::new() } else { format!(" ({})", input.display()) };
            return Err(OutputError::refused(
                path,
                format!("is an input of this command{what}; give another file"),
            ));
        }
        let to = match place::of(path)? {
            Place::Stdout if STDOUT_IS_TAKEN.swap(true, Ordering::Relaxed) => {
                return Err(OutputError::refused(path, "stdout takes one output; give a file to the other"));
            }
            Place::Stdout => To::Stdout,
            Place::Through(path) => To::Through(path),
            Place::File { path: target, before } => {
                for (stream, number) in [("stdout", 1), ("stderr", 2)] {
                    if is_same_file(&target, Path::new(&format!("/proc/self/fd/{number}"))) {
                        return Err(OutputError::refused(
                            path,
                            format!("is where {stream} goes; give another file"),
                        ));
                    }
                }
                let temporary = place::temporary(&target);
                if temporary.is_dir() {
                    // A killed command was filling a folder of that name.
                    let _lock = Lock::take(&temporary.join(LOCK_NAME), path)?;
                    std::fs::remove_dir_all(&temporary).map_err(OutputError::failed(path))?;
                }
                let lock = Lock::take(&temporary, path)?;
                To::File { target, before: before.map(Box::new), lock }
            }
        };
        Ok(Self { named, to })
    }

    /// Whether it is the process's stdout, which must then have no other output.
    pub(crate) fn is_stdout(&self) -> bool {
        matches!(self.to, To::Stdout)
    }

    /// Writes all of it.
    ///
    /// # Errors
    /// Where the disk, the reader or the permissions refuse.
    pub(crate) fn write(self, bytes: &[u8]) -> Result<(), OutputError> {
        self.write_with(|out| out.write_all(bytes))
    }

    /// Writes it piece by piece; it appears under its own name once complete.
    ///
    /// # Errors
    /// As [`Self::write`], and the errors of `pieces`.
    pub(crate) fn write_with(
        self,
        pieces: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        let named = self.named.clone();
        let mut out = self.begin()?;
        pieces(&mut out).map_err(OutputError::failed(&named))?;
        out.finish()
    }

    /// Begins to write it, as what is written comes.
    ///
    /// # Errors
    /// Where the disk or the permissions refuse.
    pub(crate) fn begin(self) -> Result<OpenOutput, OutputError> {
        let Self { named, to } = self;
        let begun = match to {
            To::Stdout => Ok(Open::Stdout(BufWriter::new(io::stdout()))),
            To::Through(path) => {
                OpenOptions::new().write(true).open(path).map(|file| Open::Through(BufWriter::new(file)))
            }
            To::File { target, before, mut lock } => {
                let out = lock.emptied().and_then(|file| file.try_clone()).map(BufWriter::new);
                out.map(|out| Open::File { out, target, before, lock })
            }
        };
        match begun {
            Ok(open) => Ok(OpenOutput { named, open, is_closed: false }),
            Err(cause) => Err(OutputError::Failed { path: named, cause }),
        }
    }
}

/// An output that is being written. Dropped before it is finished, it leaves the old file as it
/// was.
#[derive(Debug)]
pub(crate) struct OpenOutput {
    named: PathBuf,
    open: Open,
    /// Whether the reader of a pipe has gone, who needs no more.
    is_closed: bool,
}

#[derive(Debug)]
enum Open {
    Stdout(BufWriter<io::Stdout>),
    Through(BufWriter<File>),
    File { out: BufWriter<File>, target: PathBuf, before: Option<Box<Metadata>>, lock: Lock },
}

impl Open {
    fn out(&mut self) -> &mut dyn Write {
        match self {
            Self::Stdout(out) => out,
            Self::Through(out) | Self::File { out, .. } => out,
        }
    }
}

impl OpenOutput {
    /// Ends it: all of it appears under its own name.
    ///
    /// # Errors
    /// Where the disk, the reader or the permissions refuse.
    pub(crate) fn finish(mut self) -> Result<(), OutputError> {
        let written = self.flush();
        let put = match self.open {
            Open::File { out, target, before, lock } => written.and_then(|()| {
                // The second handle of the file; the lock is that of the first.
                drop(out);
                place::put(lock.path(), &target, before.as_deref())
            }),
            Open::Stdout(_) | Open::Through(_) => written,
        };
        put.map_err(OutputError::failed(&self.named))
    }

    /// That it could not be written.
    pub(crate) fn failed(&self, cause: io::Error) -> OutputError {
        OutputError::Failed { path: self.named.clone(), cause }
    }

    /// The result of a write; a reader of stdout that has closed the pipe needs no more.
    fn kept(&mut self, result: io::Result<()>) -> io::Result<()> {
        match result {
            Err(e) if e.kind() == ErrorKind::BrokenPipe && matches!(self.open, Open::Stdout(_)) => {
                self.is_closed = true;
                Ok(())
            }
            other => other,
        }
    }
}

impl Write for OpenOutput {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if !self.is_closed {
            let written = self.open.out().write_all(bytes);
            self.kept(written)?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.is_closed {
            return Ok(());
        }
        let flushed = self.open.out().flush();
        self.kept(flushed)
    }
}
