//! A scan's frames, taken one by one, and what they come to.

use super::{FrameReading, LoopError, Measured, Progress, Scanned};
use crate::cell::TurningCell;
use crate::frame::FrameMeta;
use crate::gauge::axis_line::AxisAverager;
use crate::gauge::form::Cutoff;
use crate::gauge::turn_form::TurnAverager;
use crate::gauge::{Calibration, FrameEdges, StationAverager};
use crate::job::Job;
use crate::plan::ScanPlan;

/// Length of the intervals over which one frame's columns are averaged for the record, mm.
const RECORD_STEP_MM: f64 = 0.5;

/// What settled frames come to.
pub(super) struct Sums<'c> {
    calibration: &'c Calibration,
    pub(super) averager: StationAverager,
    turns: TurnAverager,
    axis: AxisAverager,
    readings: Vec<FrameReading>,
}

impl<'c> Sums<'c> {
    pub(super) fn new(job: &Job, calibration: &'c Calibration) -> Self {
        let (z_mm, station_mm) = (job.part.station_z_mm(), job.part.station_mm);
        let zero = calibration.axis_zero(job.camera.rows_about_axis());
        Self {
            calibration,
            averager: StationAverager::new(&job.gauge.station, z_mm.clone(), station_mm),
            turns: TurnAverager::new(z_mm.clone(), station_mm),
            axis: AxisAverager::new(z_mm, station_mm, zero),
            readings: Vec::new(),
        }
    }

    pub(super) fn add(&mut self, meta: &FrameMeta, edges: &FrameEdges) {
        let columns = self.calibration.diameters(edges);
        self.averager.add(meta, &columns);
        self.turns.add(meta, &columns);
        self.axis.add(meta, &columns);
        self.readings.extend(columns.record(meta, RECORD_STEP_MM).into_iter().map(|(z_mm, reading)| {
            FrameReading {
                frame_id: meta.frame_id,
                t_ns: meta.t_ns,
                angle_deg: meta.angle_deg,
                z_mm,
                reading,
            }
        }));
    }
}

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

    pub(super) fn finish(mut self, pass: u32) -> Scanned {
        let Self { stream, sums, .. } = &mut self;
        stream.finish(|meta, edges| sums.add(&meta, edges));
        let sums = self.sums;
        Scanned {
            profile: sums.averager.finish(pass),
            form: sums.turns.finish(Cutoff::default()),
            axis: sums.axis.finish(),
            readings: sums.readings,
            sample: self.sample,
            frames: self.frames,
            refused: self.refused,
            waited: self.waited,
            measured: self.measured,
            ends: self.ends,
        }
    }
}
