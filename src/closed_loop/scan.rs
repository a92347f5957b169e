//! A scan's frames, taken one by one, and what they come to.

use super::{LoopError, Measured, Progress, Scanned};
use crate::cell::TurningCell;
use crate::gauge::form::Cutoff;
use crate::plan::ScanPlan;

impl Measured<'_> {
    /// Takes all frames of a scan.
    pub(super) fn scan(
        &mut self,
        cell: &mut dyn TurningCell,
        plan: &ScanPlan,
        of: usize,
        progress: Progress<'_>,
    ) -> Result<(), LoopError> {
        let mut source = cell.scan(plan)?;
        while let Some(frame) = self.wait(source.as_mut())? {
            if let Some(spent) = self.take(frame) {
                source.recycle(spent);
            }
            progress(self.frames, of);
        }
        Ok(())
    }

    pub(super) fn finish(self, pass: u32) -> Scanned {
        Scanned {
            profile: self.averager.finish(pass),
            form: self.turns.finish(Cutoff::default()),
            axis: self.axis.finish(),
            readings: self.readings,
            sample: self.sample,
            frames: self.frames,
            refused: self.refused,
            waited: self.waited,
            measured: self.measured,
            ends: self.ends,
        }
    }
}
