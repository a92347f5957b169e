//! The closed loop: one pass after another is cut, scanned, measured and corrected; each yields a [`PassResult`].
//!
//! Everything the controller knows comes from frames. The truth of a pass is taken beside it, for comparison only.

use std::time::{Duration, Instant};

use thiserror::Error;

use crate::cell::{CellError, TurningCell};
use crate::control::{self, ControlError, Controller, NextPass, PassContext};
use crate::frame::{Frame, FrameSource, SourceError};
use crate::gauge::form::Cutoff;
use crate::gauge::turn_form::{PartForm, TurnAverager};
use crate::gauge::{
    Calibration, CalibrationError, EdgeStream, FrameEdges, Gauge, GaugeSettingsError, MasterCertificate,
    MasterMeasurement, StationAverager,
};
use crate::job::{Job, JobError};
use crate::plan::{Decision, DiameterOffset, HeldReason, PassPlan};
use crate::profile::{DiameterProfile, Reading};

/// Length of the intervals over which one frame's columns are averaged for the record, mm.
const RECORD_STEP_MM: f64 = 0.5;

/// A loop that cannot go on.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LoopError {
    /// The job does not fit together.
    #[error(transparent)]
    Job(#[from] JobError),
    /// The cell failed.
    #[error(transparent)]
    Cell(#[from] CellError),
    /// A frame did not arrive.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The gauge refuses its settings.
    #[error(transparent)]
    Gauge(#[from] GaugeSettingsError),
    /// The gauge cannot be calibrated.
    #[error("calibration: {0}")]
    Calibration(#[from] CalibrationError),
    /// A master pin could not be measured.
    #[error("calibration: no frame of master pin {pin} could be measured: {why}")]
    Master {
        /// Number of the pin, from 1.
        pin: usize,
        /// The gauge's reason.
        why: String,
    },
    /// The controller refuses its settings.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// A recorded pass does not fit the job.
    #[error("the recorded pass {pass} has {found} stations, the job {expected}")]
    Replay {
        /// Pass, from 1.
        pass: u32,
        /// Stations in the record.
        found: usize,
        /// Stations of the job.
        expected: usize,
    },
}

/// What one frame said about a short z interval.
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

/// A frame kept for people to look at, with the edges found in it.
#[derive(Clone, Debug)]
pub struct Sample {
    /// The frame.
    pub frame: Frame,
    /// Its edges.
    pub edges: FrameEdges,
}

/// One finished pass.
#[derive(Clone, Debug)]
pub struct PassResult {
    /// What was commanded.
    pub plan: PassPlan,
    /// What the gauge believes.
    pub profile: DiameterProfile,
    /// What each frame said.
    pub readings: Vec<FrameReading>,
    /// What control decided; `None` after the last pass.
    pub decision: Option<Decision>,
    /// True station diameters, mm, for comparison only.
    pub truth_mm: Option<Vec<f64>>,
    /// Form and sizes of the sections over the angles scanned.
    pub form: PartForm,
    /// The middle field at the first angle.
    pub sample: Option<Sample>,
    /// Frames taken.
    pub frames: usize,
    /// Frames the gauge refused, with its reasons.
    pub refused: Vec<String>,
    /// Time spent waiting for frames.
    pub render: Duration,
    /// Time spent measuring them.
    pub gauge: Duration,
}

/// Told of each frame: (frames done, frames in the pass).
pub type Progress<'p> = &'p mut dyn FnMut(usize, usize);

/// A job on a cell, between passes.
pub struct ClosedLoop<'a> {
    job: &'a Job,
    cell: Box<dyn TurningCell + 'a>,
    gauge: Gauge,
    calibration: Calibration,
    controller: Box<dyn Controller + Send>,
    offset: DiameterOffset,
    held: Option<HeldReason>,
    next_pass: u32,
}

impl<'a> ClosedLoop<'a> {
    /// Checks the job and calibrates the gauge on the masters, unless a calibration is given (a resumed run).
    ///
    /// # Errors
    /// Where the job does not fit together or the masters cannot be measured.
    pub fn start(
        job: &'a Job,
        mut cell: Box<dyn TurningCell + 'a>,
        calibration: Option<Calibration>,
    ) -> Result<Self, LoopError> {
        job.check()?;
        job.check_coverage()?;
        let stations = job.part.station_z_mm().len();
        let controller = control::build(&job.control, &job.part.station_z_mm())?;
        let gauge = Gauge::new(job.gauge.clone())?;
        let calibration = match calibration {
            Some(known) => known,
            None => calibrate(job, cell.as_mut(), &gauge)?,
        };
        let offset = DiameterOffset::zero(stations);
        Ok(Self { job, cell, gauge, calibration, controller, offset, held: None, next_pass: 1 })
    }

    /// The calibration in force.
    pub fn calibration(&self) -> &Calibration {
        &self.calibration
    }

    /// Number of the next pass, `None` when all are done.
    pub fn next_pass(&self) -> Option<u32> {
        (self.next_pass as usize <= self.job.passes()).then_some(self.next_pass)
    }

    /// Why the offsets in force were held, where a guard refused new ones.
    pub fn held(&self) -> Option<&HeldReason> {
        self.held.as_ref()
    }

    /// Takes up a pass that was finished before: cuts it again (no frame is taken) and tells the controller what was measured.
    ///
    /// # Errors
    /// Where the record does not fit the job, or the cut fails.
    pub fn replay(&mut self, measured: &DiameterProfile) -> Result<(), LoopError> {
        let plan = self.plan();
        let (found, expected) = (measured.stations.len(), plan.station_z_mm.len());
        if found != expected {
            return Err(LoopError::Replay { pass: plan.pass, found, expected });
        }
        self.cell.cut(&plan)?;
        self.conclude(&plan, measured);
        Ok(())
    }

    /// Cuts, scans, measures and corrects the next pass.
    ///
    /// # Errors
    /// Where the cut or the source fails; a frame that cannot be measured is no error but leaves gaps.
    pub fn run_pass(&mut self, progress: Progress<'_>) -> Result<PassResult, LoopError> {
        let plan = self.plan();
        self.cell.cut(&plan)?;
        let scan = self.job.scan_plan();
        let mut measured = Measured::new(self.job, scan.frames(), &self.calibration, self.gauge.stream());
        let mut source = self.cell.scan(&scan)?;
        while let Some(frame) = measured.wait(source.as_mut())? {
            let spent = measured.take(frame);
            if let Some(frame) = spent {
                source.recycle(frame);
            }
            progress(measured.frames, scan.frames());
        }
        drop(source);
        let Measured { averager, turns, readings, sample, refused, frames, waited, measured, .. } = measured;
        let profile = averager.finish(plan.pass);
        let form = turns.finish(Cutoff::default());
        let half = self.job.part.station_mm / 2.0;
        let intervals: Vec<(f64, f64)> = plan.station_z_mm.iter().map(|z| (z - half, z + half)).collect();
        let decision = self.conclude(&plan, &profile);
        Ok(PassResult {
            truth_mm: self.cell.true_stations_mm(&intervals),
            plan,
            profile,
            readings,
            decision,
            form,
            sample,
            frames,
            refused,
            render: waited,
            gauge: measured,
        })
    }

    /// The next pass as it would be commanded now.
    pub fn plan(&self) -> PassPlan {
        self.job.pass_plan(self.next_pass, self.offset.clone())
    }

    fn conclude(&mut self, plan: &PassPlan, measured: &DiameterProfile) -> Option<Decision> {
        self.next_pass += 1;
        self.next_pass()?;
        let next = NextPass {
            nominal_mm: self.job.part.target_mm(self.next_pass),
            cutting: self.job.cutting,
            finishing: self.next_pass as usize == self.job.part.passes(),
        };
        let context = PassContext { next: Some(next), ..PassContext::default() };
        let decision = self.controller.decide_in(plan, measured, &context);
        match &decision {
            Decision::Offset(offset) => {
                self.offset = offset.clone();
                self.held = None;
            }
            Decision::Held(reason) => self.held = Some(reason.clone()),
        }
        Some(decision)
    }
}

/// Measures every master pin and fits scale and edge offset.
fn calibrate(job: &Job, cell: &mut dyn TurningCell, gauge: &Gauge) -> Result<Calibration, LoopError> {
    let mut measurements = Vec::new();
    for (index, pin) in job.masters.pins.iter().enumerate() {
        let mut source = cell.scan_master(index, job.masters.frames_each)?;
        let mut edges = Vec::new();
        let mut why = "no frame arrived".to_owned();
        while let Some(frame) = source.next_frame()? {
            match gauge.edges(&frame.view()) {
                Ok(found) => edges.push(found),
                Err(refused) => why = refused.to_string(),
            }
            source.recycle(frame);
        }
        if edges.is_empty() {
            return Err(LoopError::Master { pin: index + 1, why });
        }
        let certificate = MasterCertificate {
            diameter_mm: pin.diameter_mm,
            expanded_u_mm: pin.expanded_u_mm,
            coverage_factor: pin.coverage_factor,
        };
        measurements.push(MasterMeasurement { certificate, frames: edges });
    }
    Ok(Calibration::fit(&measurements)?.with_optics_id(&job.name))
}

/// What is gathered while a pass is scanned.
struct Measured<'c> {
    calibration: &'c Calibration,
    stream: EdgeStream,
    edges: FrameEdges,
    averager: StationAverager,
    turns: TurnAverager,
    sample_frame: usize,
    readings: Vec<FrameReading>,
    sample: Option<Sample>,
    refused: Vec<String>,
    frames: usize,
    waited: Duration,
    measured: Duration,
}

impl<'c> Measured<'c> {
    fn new(job: &Job, frames: usize, calibration: &'c Calibration, stream: EdgeStream) -> Self {
        let averager = StationAverager::new(&job.gauge.station, job.part.station_z_mm(), job.part.station_mm);
        let angles = job.scan.angles.max(1);
        Self {
            calibration,
            stream,
            edges: FrameEdges::default(),
            averager,
            turns: TurnAverager::new(job.part.station_z_mm(), job.part.station_mm),
            sample_frame: frames / angles / 2 * angles,
            readings: Vec::new(),
            sample: None,
            refused: Vec::new(),
            frames: 0,
            waited: Duration::ZERO,
            measured: Duration::ZERO,
        }
    }

    fn wait(&mut self, source: &mut dyn FrameSource) -> Result<Option<Frame>, SourceError> {
        let start = Instant::now();
        let frame = source.next_frame();
        self.waited += start.elapsed();
        frame
    }

    /// Measures a frame and gives it back, unless it is the one kept as a sample.
    fn take(&mut self, frame: Frame) -> Option<Frame> {
        let start = Instant::now();
        let index = self.frames;
        self.frames += 1;
        let measured = self.stream.measure(&frame.view(), &mut self.edges);
        match &measured {
            Ok(()) => self.add(&frame),
            Err(refused) => self.refused.push(format!("frame {}: {refused}", frame.meta.frame_id)),
        }
        self.measured += start.elapsed();
        if measured.is_ok() && index == self.sample_frame {
            self.sample = Some(Sample { frame, edges: self.edges.clone() });
            return None;
        }
        Some(frame)
    }

    fn add(&mut self, frame: &Frame) {
        let columns = self.calibration.diameters(&self.edges);
        self.averager.add(&frame.meta, &columns);
        self.turns.add(&frame.meta, &columns);
        let meta = &frame.meta;
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
