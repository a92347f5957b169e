//! The stations of a part from frames that come one by one from elsewhere, measured as the frames
//! of a loop are.

use super::scan::Measured;
use crate::frame::Frame;
use crate::gauge::{Calibration, Gauge, SettledStream};
use crate::job::LoopJob;
use crate::profile::DiameterProfile;

/// A scan without a cell.
pub(crate) struct StationScan<'c>(Measured<'c>);

impl<'c> StationScan<'c> {
    /// A scan of the job's stations by a gauge; `calibration` has the conditions of the part.
    pub(crate) fn new(job: &LoopJob, gauge: &Gauge, calibration: &'c Calibration) -> Self {
        // no frame is kept as a sample: there is none of that number
        Self(Measured::new(job, usize::MAX, calibration, SettledStream::new(gauge.stream())))
    }

    /// Measures a frame.
    pub(crate) fn take(&mut self, frame: Frame) {
        self.0.take(frame);
    }

    /// The stations, as those of pass `pass`, and why frames were refused.
    pub(crate) fn finish(self, pass: u32) -> (DiameterProfile, Vec<String>) {
        let scanned = self.0.finish(pass);
        (scanned.profile, scanned.tally.refused)
    }
}
