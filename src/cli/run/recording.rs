//! `run --record`: writes the frames that a simulated cell delivers into a folder that a run reads
//! back by `source`.

use std::fmt::Write as _;

use crate::cell::{CellError, FollowedCut, SeenStation, TrueAxis, TurningCell};
use crate::cli::render::frame_files::{FileFormat, encode};
use crate::control::{PartAndTool, PartEvent};
use crate::files::OutputFolder;
use crate::frame::{Frame, FrameSource, SourceError};
use crate::plan::{CutSummary, FollowPlan, PassPlan, ScanPlan};

/// Columns of the tables; places and angles stand with all digits, so that what is read back is
/// what was taken.
const HEADER: &str = "frame,t_ns,z_mm,angle_deg,exposure_us,bit_depth\n";

/// A cell whose frames are written as they are taken.
pub(super) struct RecordingCell<'a> {
    cell: Box<dyn TurningCell + 'a>,
    folder: &'a OutputFolder,
    um_per_px: f64,
    pass: u32,
    scans: u32,
}

impl<'a> RecordingCell<'a> {
    pub(super) fn new(cell: Box<dyn TurningCell + 'a>, folder: &'a OutputFolder, um_per_px: f64) -> Self {
        Self { cell, folder, um_per_px, pass: 0, scans: 0 }
    }
}

/// Frames on their way to the loop, each written before it is handed over.
struct WrittenFrames<'s> {
    frames: Box<dyn FrameSource + 's>,
    folder: &'s OutputFolder,
    name: String,
    um_per_px: f64,
    table: String,
    count: usize,
}

fn failed(name: &str, why: &dyn std::fmt::Display) -> SourceError {
    SourceError { what: format!("{name}: cannot be recorded: {why}"), cause: None }
}

impl WrittenFrames<'_> {
    fn write(&mut self, frame: &Frame) -> Result<(), SourceError> {
        let name = format!("{}/{:06}.png", self.name, self.count);
        let bytes = encode(frame, FileFormat::Png16, self.um_per_px).map_err(|e| failed(&name, &e))?;
        self.folder.write(&name, &bytes).map_err(|e| failed(&name, &e))?;
        let (meta, bits) = (&frame.meta, frame.view().format().bit_depth());
        let _ = writeln!(
            self.table,
            "{:06},{},{},{},{},{bits}",
            self.count, meta.t_ns, meta.z_mm, meta.angle_deg, meta.exposure_us
        );
        self.count += 1;
        Ok(())
    }
}

impl FrameSource for WrittenFrames<'_> {
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        let frame = self.frames.next_frame()?;
        match &frame {
            Some(frame) => self.write(frame)?,
            None => {
                let name = format!("{}/frames.csv", self.name);
                self.folder.write(&name, self.table.as_bytes()).map_err(|e| failed(&name, &e))?;
            }
        }
        Ok(frame)
    }

    fn remaining(&self) -> Option<usize> {
        self.frames.remaining()
    }

    fn recycle(&mut self, frame: Frame) {
        self.frames.recycle(frame);
    }
}

impl TurningCell for RecordingCell<'_> {
    fn cut(&mut self, plan: &PassPlan) -> Result<(), CellError> {
        (self.pass, self.scans) = (plan.pass, 0);
        self.cell.cut(plan)
    }

    fn scan(&mut self, plan: &ScanPlan) -> Result<Box<dyn FrameSource + '_>, CellError> {
        let name = match (self.pass, self.scans) {
            (0, _) => "stock".to_owned(),
            (pass, 0) => format!("pass_{pass}"),
            (pass, _) => format!("pass_{pass}/again"),
        };
        self.scans += 1;
        let Self { cell, folder, um_per_px, .. } = self;
        let frames = cell.scan(plan)?;
        let table = HEADER.to_owned();
        Ok(Box::new(WrittenFrames { frames, folder, name, um_per_px: *um_per_px, table, count: 0 }))
    }

    fn can_scan_again(&self) -> bool {
        self.cell.can_scan_again()
    }

    fn scan_master(&mut self, index: usize, frames: usize) -> Result<Box<dyn FrameSource + '_>, CellError> {
        let name = match self.pass {
            0 => format!("masters/pin_{}", index + 1),
            pass => format!("pass_{pass}/master"),
        };
        let Self { cell, folder, um_per_px, .. } = self;
        let frames = cell.scan_master(index, frames)?;
        let table = HEADER.to_owned();
        Ok(Box::new(WrittenFrames { frames, folder, name, um_per_px: *um_per_px, table, count: 0 }))
    }

    fn cut_followed(
        &mut self,
        _plan: &PassPlan,
        _follow: &FollowPlan,
    ) -> Result<Box<dyn FollowedCut + '_>, CellError> {
        Err(CellError::NotFollowed)
    }

    fn last_cut(&self) -> Option<CutSummary> {
        self.cell.last_cut()
    }

    fn true_axis(&self, seen: &[SeenStation]) -> Option<TrueAxis> {
        self.cell.true_axis(seen)
    }

    fn next_part(&mut self, part: u64, event: PartEvent) -> Result<(), CellError> {
        self.cell.next_part(part, event)
    }

    fn in_machine(&self) -> Option<PartAndTool> {
        self.cell.in_machine()
    }

    fn now_ns(&self) -> Option<u64> {
        self.cell.now_ns()
    }

    fn number_among_passes(&self, frame_id: u64) -> u64 {
        self.cell.number_among_passes(frame_id)
    }

    fn true_stations_mm(&self, stations_mm: &[(f64, f64)]) -> Option<Vec<f64>> {
        self.cell.true_stations_mm(stations_mm)
    }
}
