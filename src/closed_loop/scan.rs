//! The frames of a scan, one by one, and the result over all of them.

use std::time::{Duration, Instant};

use super::error::LoopError;
use super::evidence::Stamp;
use crate::cell::TurningCell;
use crate::frame::{Frame, FrameMeta, FrameSource, SourceError};
use crate::gauge::axis_line::{AxisAverager, AxisLine};
use crate::gauge::calibration::{Conditions, HeadGeometry};
use crate::gauge::diameter::sections::{PartForm, TurnAverager};
use crate::gauge::diameter::turning_depth::{Telecentricity, correct_profile};
use crate::gauge::form::Cutoff;
use crate::gauge::{Calibration, FrameEdges, SettledStream, StationAverager};
use crate::job::LoopJob;
use crate::plan::ScanPlan;
use crate::profile::{DiameterProfile, Reading};

/// Length of the intervals over which one frame's columns are averaged for the record, mm.
const RECORD_STEP_MM: f64 = 0.5;

/// Diameters of a short z interval in one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameReading {
    /// Frame it comes from.
    pub frame_id: u64,
    /// Start of exposure, ns.
    pub t_ns: u64,
    /// Spindle angle, degrees.
    pub angle_deg: f64,
    /// Middle of the interval, mm.
    pub z_mm: f64,
    /// Mean diameter of the interval.
    pub reading: Reading,
}

/// A frame kept for reports, with its edges.
#[derive(Clone, Debug)]
pub struct Sample {
    /// The frame.
    pub frame: Frame,
    /// Its edges.
    pub edges: FrameEdges,
}

/// Called after each frame: (frames done, frames in the pass).
pub(crate) type Progress<'p> = &'p mut dyn FnMut(usize, usize);

/// Frames of a scan, and the time they took.
#[derive(Default)]
pub(super) struct Tally {
    pub(super) frames: usize,
    pub(super) refused: Vec<String>,
    pub(super) waited: Duration,
    pub(super) measured: Duration,
}

impl Tally {
    pub(super) fn add(&mut self, other: Self) {
        self.frames += other.frames;
        self.refused.extend(other.refused);
        self.waited += other.waited;
        self.measured += other.measured;
    }
}

/// A scan, measured.
pub(super) struct Scanned {
    pub(super) profile: DiameterProfile,
    pub(super) form: PartForm,
    pub(super) axis: AxisLine,
    pub(super) readings: Vec<FrameReading>,
    pub(super) sample: Option<Sample>,
    pub(super) tally: Tally,
    pub(super) ends: Option<(Stamp, Stamp)>,
}

/// The results accumulated during a scan.
pub(super) struct Measured<'c> {
    stream: SettledStream<FrameMeta>,
    edges: FrameEdges,
    pub(super) sums: Sums<'c>,
    sample_frame: usize,
    sample: Option<Sample>,
    pub(super) tally: Tally,
    /// First and last frame.
    ends: Option<(Stamp, Stamp)>,
}

impl<'c> Measured<'c> {
    pub(super) fn new(
        job: &LoopJob,
        frames: usize,
        calibration: &'c Calibration,
        stream: SettledStream<FrameMeta>,
    ) -> Self {
        let angles = job.scan.angles.max(1);
        Self {
            stream,
            edges: FrameEdges::default(),
            sums: Sums::new(job, calibration),
            sample_frame: frames / angles / 2 * angles,
            sample: None,
            tally: Tally::default(),
            ends: None,
        }
    }

    pub(super) fn wait(&mut self, source: &mut dyn FrameSource) -> Result<Option<Frame>, SourceError> {
        let start = Instant::now();
        let frame = source.next_frame();
        self.tally.waited += start.elapsed();
        frame
    }

    /// Measures a frame and returns it, unless it is kept as the sample.
    pub(super) fn take(&mut self, frame: Frame) -> Option<Frame> {
        let start = Instant::now();
        let index = self.tally.frames;
        self.tally.frames += 1;
        let stamp = Stamp::of(&frame.meta);
        self.ends = Some((self.ends.map_or(stamp, |e| e.0), stamp));
        let Self { stream, edges, sums, .. } = self;
        let measured =
            stream.measure(&frame.view(), edges, frame.meta.clone(), |meta, edges| sums.add(&meta, edges));
        if let Err(refused) = &measured {
            self.tally.refused.push(format!("frame {index} of the scan: {refused}"));
        }
        self.tally.measured += start.elapsed();
        if measured.is_ok() && index == self.sample_frame {
            self.sample = Some(Sample { frame, edges: self.edges.clone() });
            return None;
        }
        Some(frame)
    }
}

/// Sums over settled frames.
pub(super) struct Sums<'c> {
    calibration: &'c Calibration,
    /// Where the machine carries the head, as far as that is known.
    geometry: Option<HeadGeometry>,
    pub(super) averager: StationAverager,
    turns: TurnAverager,
    axis: AxisAverager,
    readings: Vec<FrameReading>,
    telecentricity: Telecentricity,
    angle_deg: Vec<f64>,
}

impl<'c> Sums<'c> {
    pub(super) fn new(job: &LoopJob, calibration: &'c Calibration) -> Self {
        let (z_mm, station_mm) = (job.station_z_mm(), job.part.station_mm);
        let zero = calibration.axis_zero(job.field.rows_about_axis);
        Self {
            calibration,
            geometry: job.head_geometry.clone(),
            averager: StationAverager::new(&job.gauge.station, z_mm.clone(), station_mm),
            turns: TurnAverager::new(z_mm.clone(), station_mm),
            axis: AxisAverager::new(z_mm, station_mm, zero),
            readings: Vec::new(),
            telecentricity: Telecentricity::of(calibration)
                .unwrap_or_else(|| Telecentricity::within(job.field.limit_telecentricity_per_mm())),
            angle_deg: job.scan_plan().angle_deg,
        }
    }

    pub(super) fn add(&mut self, meta: &FrameMeta, edges: &FrameEdges) {
        let place = self.geometry.as_ref().and_then(|geometry| geometry.at(meta.z_mm));
        let conditions = Conditions { machine: place, ..self.calibration.conditions() };
        let columns = self.calibration.diameters_under(edges, &conditions);
        let axial_mm = place.map_or(0.0, |place| place.axial_mm);
        let meta = &FrameMeta { z_mm: meta.z_mm + axial_mm, ..meta.clone() };
        self.averager.add(meta, &columns);
        self.turns.add(meta, &columns);
        self.axis.add(meta, &columns);
        self.readings.extend(columns.record(meta, RECORD_STEP_MM).map(|(z_mm, reading)| FrameReading {
            frame_id: meta.frame_id,
            t_ns: meta.t_ns,
            angle_deg: meta.angle_deg,
            z_mm,
            reading,
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
            progress(self.tally.frames, of);
        }
        Ok(())
    }

    pub(super) fn finish(mut self, pass: u32) -> Scanned {
        let Self { stream, sums, .. } = &mut self;
        stream.finish(|meta, edges| sums.add(&meta, edges));
        let sums = self.sums;
        let axis = sums.axis.finish();
        let mut profile = sums.averager.finish(pass);
        correct_profile(&mut profile, &axis, &sums.angle_deg, sums.telecentricity);
        Scanned {
            profile,
            form: sums.turns.finish(Cutoff::default()),
            axis,
            readings: sums.readings,
            sample: self.sample,
            tally: self.tally,
            ends: self.ends,
        }
    }
}
