//! What `--save DIR` keeps: all results as JSON lines, and the frames that had none or a bad one.
//!
//! `results.jsonl` has a line as soon as it is there. Frames are written by another thread as
//! 16-bit PNG (floating point as TIFF) in `frames/`, with their times and places in
//! `frames/frames.csv`, so that `measure DIR/frames` reads them as they were taken.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use serde_json::Value;

use crate::cli::failure::Failure;
use crate::cli::render::frame_files::{FileFormat, encode};
use crate::frame::{Frame, PixelFormat};

/// Frames that wait for the disk.
const WAITING: usize = 4;
/// Columns of the table beside the frames, as `run --record` writes them.
const HEADER: &str = "frame,t_ns,z_mm,angle_deg,exposure_us,bit_depth\n";

/// A folder that is being filled.
pub(super) struct Saved {
    path: PathBuf,
    results: File,
    /// Why results are not written any more.
    failure: Option<io::Error>,
    frames: Option<Frames>,
    /// Frames given to the other thread, and the most of them.
    given: u32,
    most: u32,
    /// Frames that would have been saved, too.
    left_out: u64,
}

/// The thread that writes frames.
struct Frames {
    to: SyncSender<(String, Frame)>,
    thread: JoinHandle<io::Result<()>>,
}

impl Saved {
    /// Begins a folder: a new one, or one that is empty. `most` frames are saved at most; the scale
    /// goes into their tags.
    ///
    /// # Errors
    /// Exit 2 for a folder that holds anything; 3 for one that cannot be written.
    pub(super) fn begin(path: &Path, most: u32, um_per_px: Option<f64>) -> Result<Self, Failure> {
        let shown = path.display();
        let failed = |error: io::Error| Failure::fail(format!("--save {shown}: {error}"));
        let is_taken = match fs::read_dir(path) {
            Ok(mut entries) => entries.next().is_some(),
            Err(error) if error.kind() == io::ErrorKind::NotFound => false,
            Err(error) => return Err(failed(error)),
        };
        if is_taken {
            return Err(Failure::refuse(format!(
                "--save {shown}: the folder is taken, and nothing in it is written over; name a new one"
            )));
        }
        let folder = path.join("frames");
        fs::create_dir_all(&folder).map_err(failed)?;
        let results = File::create_new(path.join("results.jsonl")).map_err(failed)?;
        let table = File::create_new(folder.join("frames.csv")).map_err(failed)?;
        let (to, from) = sync_channel(WAITING);
        let write = move || written(&from, &folder, table, um_per_px);
        let thread = std::thread::Builder::new().name("saving".to_owned()).spawn(write).map_err(failed)?;
        let frames = Some(Frames { to, thread });
        Ok(Self { path: path.to_owned(), results, failure: None, frames, given: 0, most, left_out: 0 })
    }

    /// Adds a result.
    pub(super) fn line(&mut self, line: &Value) {
        if self.failure.is_none()
            && let Err(error) = self.results.write_all(format!("{line}\n").as_bytes())
        {
            // At once: who watches may make room on the disk.
            tracing::error!("{}: results are not written any more: {error}", self.path.display());
            self.failure = Some(error);
        }
    }

    /// Whether another frame may be saved.
    pub(super) fn has_room(&self) -> bool {
        self.given < self.most
    }

    /// Saves a frame by its number; the name of its file from here on, or none where it is left
    /// out: there are enough of them, or the disk is slower.
    pub(super) fn frame(&mut self, number: u64, frame: Option<Frame>) -> Option<String> {
        let stem = format!("{number:06}");
        let given =
            frame.filter(|_| self.has_room()).zip(self.frames.as_ref()).and_then(|(frame, frames)| {
                let name = format!("frames/{stem}.{}", format_of(&frame).extension());
                frames.to.try_send((stem, frame)).ok().map(|()| name)
            });
        match &given {
            Some(_) => self.given += 1,
            None => self.left_out += 1,
        }
        given
    }

    /// Waits until everything is written.
    ///
    /// # Errors
    /// Where the disk refused.
    pub(super) fn finish(mut self) -> Result<(), Failure> {
        let shown = self.path.display();
        if self.left_out > 0 {
            tracing::warn!(
                "{shown}: {} frames more were invalid or not good than are saved (--save-frames {})",
                self.left_out,
                self.most
            );
        }
        let joined = self.frames.take().map_or(Ok(()), |Frames { to, thread }| {
            drop(to);
            thread.join().unwrap_or_else(|_| Err(io::Error::other("the thread that writes frames failed")))
        });
        let finished = self.failure.map_or(Ok(()), Err).and(joined);
        finished.map_err(|error| Failure::fail(format!("--save {shown}: {error}")))
    }
}

fn format_of(frame: &Frame) -> FileFormat {
    if frame.view().format() == PixelFormat::F32 { FileFormat::F32 } else { FileFormat::Png16 }
}

/// Writes what comes until the other end is gone.
fn written(
    from: &Receiver<(String, Frame)>,
    folder: &Path,
    mut table: File,
    um_per_px: Option<f64>,
) -> io::Result<()> {
    table.write_all(HEADER.as_bytes())?;
    for (stem, frame) in from {
        let format = format_of(&frame);
        let bytes = encode(&frame, format, um_per_px)?;
        fs::write(folder.join(format!("{stem}.{}", format.extension())), bytes)?;
        let (meta, bits) = (&frame.meta, frame.view().format().bit_depth());
        let row =
            format!("{stem},{},{},{},{},{bits}\n", meta.t_ns, meta.z_mm, meta.angle_deg, meta.exposure_us);
        table.write_all(row.as_bytes())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Buffer, FrameMeta};

    fn frame(grey: u16) -> Frame {
        let meta = FrameMeta { t_ns: 7, ..FrameMeta::default() };
        Frame::new(Buffer::U16(vec![grey; 12]), PixelFormat::Mono12, 3, 4, meta).unwrap()
    }

    #[test]
    fn lines_and_frames_are_there_and_no_more_than_asked_for() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new");
        let mut saved = Saved::begin(&path, 2, None).unwrap();
        saved.line(&serde_json::json!({ "a": 1 }));
        let names: Vec<_> = (0..3).map(|k| saved.frame(k, Some(frame(4095)))).collect();
        assert_eq!(names[2], None);
        assert!(!saved.has_room() && names[1].as_deref() == Some("frames/000001.png"), "{names:?}");
        saved.finish().unwrap();
        assert_eq!(fs::read_to_string(path.join("results.jsonl")).unwrap(), "{\"a\":1}\n");
        let table = fs::read_to_string(path.join("frames/frames.csv")).unwrap();
        assert!(table.lines().count() == 3 && table.contains("000001,7,0,0,0,12"), "{table}");
        let image = image::open(path.join("frames/000001.png")).unwrap().into_luma16();
        assert!(image.dimensions() == (4, 3) && image.pixels().all(|p| p.0 == [4095]));
        let taken = Saved::begin(&path, 2, None).err().unwrap();
        assert!(taken.exit == 2 && taken.report.to_string().contains("taken"));
    }
}
