//! The recorded cell: a lathe whose passes were cut and photographed before.
//!
//! In: the folder of a recorded run. Out: its frames, scan by scan. Cutting does nothing, because
//! the machine has cut; no truth is stated. The same images are never taken for two scans: a second
//! scan that is a copy of the first would confirm any step.
//!
//! A recording names no part, no tool and no time of the cut: one part is in the machine, and time
//! begins anew with every pass, at 0, and goes on by the times of the frames. So the guards of
//! part, tool and age have nothing to see, and those of the check pin and of a scan used twice do.

use std::path::{Path, PathBuf};

use super::simulated::FRAMES_OF_A_PASS;
use super::turning_cell::{CellError, TurningCell};
use crate::control::PartAndTool;
use crate::frame::{Frame, FrameSource, SourceError};
use crate::plan::{PassPlan, ScanPlan};
use crate::source::{FileFrames, ReadError, RecordedScan, Recording, image_digests};

impl From<ReadError> for CellError {
    fn from(error: ReadError) -> Self {
        Self::Refused(Box::new(error))
    }
}

/// A folder of frames in place of a lathe and a camera.
pub(crate) struct RecordedCell {
    recording: Recording,
    /// Number of the last pass; 0 before the first.
    pass: u32,
    /// Whether the last pass was scanned already.
    has_scanned: bool,
    /// Time of the last frame since the pass was cut, ns.
    now_ns: u64,
}

/// Frames of a folder, whose times the cell keeps.
struct Stamped<'a> {
    frames: FileFrames,
    now_ns: &'a mut u64,
}

impl FrameSource for Stamped<'_> {
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        let frame = self.frames.next_frame()?;
        let t_ns = frame.as_ref().map_or(0, |frame| frame.meta.t_ns);
        *self.now_ns = t_ns.max(*self.now_ns);
        Ok(frame)
    }

    fn remaining(&self) -> Option<usize> {
        self.frames.remaining()
    }

    fn recycle(&mut self, frame: Frame) {
        self.frames.recycle(frame);
    }
}

impl RecordedCell {
    /// The cell of a recorded run.
    pub(crate) fn new(recording: Recording) -> Self {
        Self { recording, pass: 0, has_scanned: false, now_ns: 0 }
    }

    /// The scan that is taken next.
    fn next_scan(&self) -> RecordedScan {
        match (self.pass, self.has_scanned) {
            (0, _) => RecordedScan::Stock,
            (pass, false) => RecordedScan::Pass(pass),
            (pass, true) => RecordedScan::Again(pass),
        }
    }

    /// Scans that may have been taken before `scan`.
    fn earlier(&self, scan: RecordedScan) -> Vec<RecordedScan> {
        let last = match scan {
            RecordedScan::Stock => return Vec::new(),
            RecordedScan::Pass(pass) => pass - 1,
            RecordedScan::Again(pass) => pass,
        };
        let scans = (1..=last).flat_map(|pass| [RecordedScan::Pass(pass), RecordedScan::Again(pass)]);
        std::iter::once(RecordedScan::Stock).chain(scans).filter(|s| *s != scan).collect()
    }

    /// Refuses a scan that shares an image with an earlier one, by the first image of that.
    fn check_unused(&self, scan: RecordedScan, images: &[PathBuf]) -> Result<(), CellError> {
        let own = image_digests(images)?;
        for other in self.earlier(scan).into_iter().filter(|s| self.recording.has(*s)) {
            let first = self.recording.images(other)?.into_iter().take(1).collect::<Vec<_>>();
            let Some(digest) = image_digests(&first)?.pop() else { continue };
            if let Some(index) = own.iter().position(|d| *d == digest) {
                let text = format!(
                    "{}: the same image as {}; every scan needs frames of its own",
                    images[index].display(),
                    first[0].display()
                );
                return Err(CellError::Refused(text.into()));
            }
        }
        Ok(())
    }

    /// Frames of a pin; its folder is named where it is missing.
    fn pin(&self, folder: &Path, why: &str) -> Result<Box<dyn FrameSource + '_>, CellError> {
        if !folder.is_dir() {
            return Err(CellError::Refused(format!("{}: is not there; {why}", folder.display()).into()));
        }
        Ok(Box::new(Recording::frames_in(folder)?))
    }
}

/// Refuses a number of images that is not the plan's; a single file may be a stack of all frames.
fn check_count(images: &[PathBuf], plan: &ScanPlan) -> Result<(), CellError> {
    let (found, planned) = (images.len(), plan.frames());
    let folder = images.first().and_then(|image| image.parent()).unwrap_or(Path::new("."));
    if found == planned || found == 1 {
        return Ok(());
    }
    let text = format!(
        "{}: {found} images, but scan.fields and scan.angles make {planned} ({} fields that show stations, {} angles); record \
         all of them, or state what was recorded",
        folder.display(),
        plan.field_z_mm.len(),
        plan.angle_deg.len()
    );
    Err(CellError::Refused(text.into()))
}

impl TurningCell for RecordedCell {
    fn cut(&mut self, plan: &PassPlan) -> Result<(), CellError> {
        (self.pass, self.has_scanned, self.now_ns) = (plan.pass, false, 0);
        Ok(())
    }

    fn scan(&mut self, plan: &ScanPlan) -> Result<Box<dyn FrameSource + '_>, CellError> {
        let scan = self.next_scan();
        let images = self.recording.images(scan)?;
        check_count(&images, plan)?;
        self.check_unused(scan, &images)?;
        self.has_scanned = self.pass > 0;
        let frames = self.recording.frames(images, plan)?;
        Ok(Box::new(Stamped { frames, now_ns: &mut self.now_ns }))
    }

    fn can_scan_again(&self) -> bool {
        self.recording.has(self.next_scan())
    }

    fn scan_master(&mut self, index: usize, _frames: usize) -> Result<Box<dyn FrameSource + '_>, CellError> {
        match self.pass {
            0 => {
                let why = format!(
                    "a recorded run is calibrated on frames of every pin of [[masters.pins]], or by calibration.json in {}",
                    self.recording.root().display()
                );
                self.pin(&self.recording.pin_place(index + 1), &why)
            }
            pass => {
                let why = "masters.check_frames asks for frames of the first pin after every pass; take them, or set it to 0";
                self.pin(&self.recording.check_place(pass), why)
            }
        }
    }

    fn in_machine(&self) -> Option<PartAndTool> {
        Some(PartAndTool { part: "recorded".to_owned(), tool: "recorded".to_owned() })
    }

    fn now_ns(&self) -> Option<u64> {
        Some(self.now_ns)
    }

    /// Frames of every folder are numbered from 0.
    fn number_among_passes(&self, frame_id: u64) -> u64 {
        u64::from(self.pass) * FRAMES_OF_A_PASS + frame_id
    }

    fn true_stations_mm(&self, _stations_mm: &[(f64, f64)]) -> Option<Vec<f64>> {
        None
    }
}
