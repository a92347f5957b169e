//! The closed loop: one pass after another is cut, scanned, measured and corrected; each yields a
//! [`PassResult`].
//!
//! The controller's only inputs are measured from frames. The truth of a pass is taken beside it,
//! for comparison only.
//!
//! `instrument` (camera or probe) is calibrated on `masters`; a pass is cut, then scanned (`scan`;
//! `touches` by a probe), or measured while it is cut (`in_process`); `pass_before` compares it
//! with the last one, `evidence` is the input of a decision besides the profile; `station_scan` is
//! a scan whose frames come from elsewhere, `part_frames` hands out the frames themselves. A new
//! way to measure a pass is a method of [`ClosedLoop`] in a file of its own that returns a
//! `Scanned`.

mod error;
mod evidence;
mod in_process;
mod instrument;
mod masters;
#[cfg(feature = "render")]
mod part_frames;
mod pass_before;
mod scan;
#[cfg(feature = "render")]
mod station_scan;
mod touches;

use std::time::Duration;

pub use self::{
    error::LoopError,
    evidence::Evidence,
    instrument::Calibrated,
    scan::{FrameReading, Sample},
};
use crate::cell::{SeenStation, TrueAxis, TurningCell};
use crate::conformity::{DecisionRule, part_verdict};
pub(crate) use scan::Progress;
#[cfg(feature = "render")]
pub(crate) use station_scan::StationScan;

use crate::control::{self, Controller, NextPass, PartEvent, PartStart, PassContext};
use crate::gauge::axis_line::AxisLine;
use crate::gauge::diameter::sections::PartForm;
use crate::gauge::{FrameEdges, Gauge, ResidualAccumulator, SettledStream};
use crate::job::{LoopJob, ScanWhen};
use crate::nc;
use crate::plan::{CutSummary, Decision, DiameterOffset, HeldReason, PassPlan, Section};
use crate::profile::DiameterProfile;
use evidence::AfterCut;
use scan::{Measured, Scanned};

/// One finished pass.
#[derive(Clone, Debug)]
pub struct PassResult {
    /// The commanded pass.
    pub plan: PassPlan,
    /// Measured diameters.
    pub profile: DiameterProfile,
    /// Diameters of each frame.
    pub readings: Vec<FrameReading>,
    /// The controller's decision; `None` after the last pass.
    pub decision: Option<Decision>,
    /// Input of the decision besides the profile.
    pub evidence: Evidence,
    /// Remarks of the controller, and on the rounding of the offsets for the machine.
    pub notes: Vec<String>,
    /// Why the next pass should not be cut before an inspection.
    pub alarm: Option<String>,
    /// True station diameters, mm, for comparison only.
    pub truth_mm: Option<Vec<f64>>,
    /// Forces and deflections while it was cut, where the cell has them.
    pub cut: Option<CutSummary>,
    /// The part's axis in the frames, for comparison only.
    pub true_axis: Option<TrueAxis>,
    /// Form and sizes of the sections over the angles scanned.
    pub form: PartForm,
    /// Axis of the part along z in the image plane: its line at rest and the one that turns.
    pub axis: AxisLine,
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

/// A job on a cell, between passes.
pub struct ClosedLoop<'a> {
    job: LoopJob,
    cell: Box<dyn TurningCell + 'a>,
    gauge: Gauge,
    calibration: Calibrated,
    /// The calibration under the part's conditions.
    of_part: Calibrated,
    controller: Box<dyn Controller + Send>,
    offset: DiameterOffset,
    /// Offsets as the controller decided them; `offset` has them as the machine's program rounds
    /// them.
    asked: DiameterOffset,
    held: Option<HeldReason>,
    alarm: Option<String>,
    part: PartState,
}

/// Progress of the current part.
struct PartState {
    next_pass: u32,
    /// What changed since the last part; consumed when the part begins.
    event: Option<PartEvent>,
    stock: Option<DiameterProfile>,
    /// The last pass: its plan and its measured profile.
    before: Option<(PassPlan, DiameterProfile)>,
}

impl PartState {
    fn new(event: PartEvent) -> Self {
        Self { next_pass: 1, event: Some(event), stock: None, before: None }
    }
}

/// A pass that was cut and measured.
struct CutPass {
    /// As it was finally commanded.
    plan: PassPlan,
    scan: Scanned,
    after_cut: AfterCut,
    /// What could not be corrected within the pass.
    notes: Vec<String>,
}

/// A measured pass with implausible stations as gaps, and what a decision on it rests on.
struct JudgedPass {
    plan: PassPlan,
    scan: Scanned,
    evidence: Evidence,
    notes: Vec<String>,
}

/// A decision, in force.
struct Decided {
    /// `None` after the last pass.
    decision: Option<Decision>,
    notes: Vec<String>,
}

/// From where the gauge took a station's axis.
fn seen_station((from_mm, to_mm): (f64, f64), axis: &AxisLine) -> SeenStation {
    let middle = 0.5 * (from_mm + to_mm);
    let own = axis.stations.iter().find(|s| (s.z_mm - middle).abs() < 1e-6);
    SeenStation { from_mm, to_mm, field_z_mm: own.map_or(middle, |s| s.field_z_mm) }
}

/// Verdict on a finished part by its re-measurement (ISO 14253-1), of a stepped shaft each section
/// by its own tolerance; `None` without a tolerance.
pub(crate) fn part_verdict(job: &LoopJob, measured: &DiameterProfile) -> Option<part_verdict::Verdict> {
    let rule = DecisionRule::new(job.part.conformance_probability).unwrap_or_default();
    let limits = |(lower_mm, upper_mm): (f64, f64)| part_verdict::Limits { lower_mm, upper_mm, rule };
    let Some(contour) = job.turned_contour() else {
        return Some(part_verdict::judge(measured, &limits(job.part.tolerance?.limits_mm())));
    };
    contour.sections.iter().any(|s| s.limits_mm.is_some()).then(|| {
        part_verdict::judge_sections(measured, &|z_mm| contour.section_at(z_mm)?.limits_mm.map(limits))
    })
}

/// Verdict on a section of a finished part; `None` without a tolerance.
pub(crate) fn section_verdict(
    job: &LoopJob,
    section: &Section,
    measured: &DiameterProfile,
) -> Option<part_verdict::PartConformity> {
    let (lower_mm, upper_mm) = section.limits_mm?;
    let rule = DecisionRule::new(job.part.conformance_probability).unwrap_or_default();
    let own = |z_mm: f64| (section.ends_mm.0..=section.ends_mm.1).contains(&z_mm);
    let limits = |z_mm: f64| own(z_mm).then_some(part_verdict::Limits { lower_mm, upper_mm, rule });
    Some(part_verdict::judge_sections(measured, &limits).part())
}

impl<'a> ClosedLoop<'a> {
    /// Checks the job, builds its controller and calibrates its instrument on the masters, unless a
    /// calibration is given (a resumed run).
    ///
    /// # Errors
    /// Where the job does not fit together or the masters cannot be measured.
    pub fn start(
        job: LoopJob,
        cell: Box<dyn TurningCell + 'a>,
        calibration: Option<Calibrated>,
    ) -> Result<Self, LoopError> {
        job.check()?;
        job.check_coverage()?;
        let controller = control::build(&job.run_control(), job.layout())?;
        Self::assemble(job, cell, calibration, controller)
    }

    /// The same with a controller of the caller's own in place of the one that `job.control` names;
    /// `control.within_pass` and `scan.stock` hold for it as well.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub fn with_controller(
        job: LoopJob,
        cell: Box<dyn TurningCell + 'a>,
        calibration: Option<Calibrated>,
        controller: Box<dyn Controller + Send>,
    ) -> Result<Self, LoopError> {
        job.check()?;
        job.check_coverage()?;
        Self::assemble(job, cell, calibration, controller)
    }

    fn assemble(
        job: LoopJob,
        mut cell: Box<dyn TurningCell + 'a>,
        calibration: Option<Calibrated>,
        controller: Box<dyn Controller + Send>,
    ) -> Result<Self, LoopError> {
        let (gauge, calibration) = instrument::instrument(&job, cell.as_mut(), calibration)?;
        let offset = DiameterOffset::zero(job.station_z_mm().len());
        Ok(Self {
            of_part: calibration.of_part(&job),
            job,
            cell,
            gauge,
            calibration,
            controller,
            asked: offset.clone(),
            offset,
            held: None,
            alarm: None,
            part: PartState::new(PartEvent::Continued),
        })
    }

    fn check_controller(&self) -> Result<(), LoopError> {
        self.controller.failure().map_or(Ok(()), |failure| Err(failure.clone().into()))
    }

    /// Clamps the next blank of a batch: edge, machine, calibration and the state of the controller
    /// stay. `part` counts from 0, the part the cell began with.
    ///
    /// # Errors
    /// Where the cell has no other blank.
    pub fn next_part(&mut self, part: u64, event: PartEvent) -> Result<(), LoopError> {
        self.cell.next_part(part, event)?;
        (self.held, self.alarm) = (None, None);
        self.part = PartState::new(event);
        Ok(())
    }

    /// Diameters of the stock, where it was scanned.
    pub fn stock(&self) -> Option<&DiameterProfile> {
        self.part.stock.as_ref()
    }

    /// Resumes with the recorded scan of the stock, so that no frame is taken of it.
    pub fn resume_stock(&mut self, stock: Option<DiameterProfile>) {
        self.begin_part(stock);
    }

    /// Why the next pass should not be cut before an inspection.
    pub fn alarm(&self) -> Option<&str> {
        self.alarm.as_deref()
    }

    /// Scans the stock where the job requires it and starts the controller.
    ///
    /// # Errors
    /// Where the source fails.
    pub fn begin(&mut self) -> Result<(), LoopError> {
        if self.part.event.is_some() {
            let stock = match self.job.scans_stock() {
                true => Some(self.scan(0, &mut |_, _| {})?.profile),
                false => None,
            };
            self.begin_part(stock);
        }
        Ok(())
    }

    fn begin_part(&mut self, stock: Option<DiameterProfile>) {
        self.part.stock = stock;
        if let Some(event) = self.part.event.take() {
            let start = PartStart { event, stock: self.part.stock.as_ref() };
            let stations = self.job.station_z_mm().len();
            let first = self.controller.begin_part(&start, stations);
            match self.put_in_force(first) {
                Ok(_) => self.held = None,
                Err(reason) => {
                    self.offset = DiameterOffset::zero(stations);
                    self.asked = self.offset.clone();
                    self.held = Some(reason);
                }
            }
        }
    }

    /// The calibration in force.
    pub fn calibration(&self) -> &Calibrated {
        &self.calibration
    }

    /// Number of the next pass, `None` when all are done.
    pub fn next_pass(&self) -> Option<u32> {
        (self.part.next_pass as usize <= self.job.passes()).then_some(self.part.next_pass)
    }

    /// Why the offsets in force were held, where a guard refused new ones.
    pub fn held(&self) -> Option<&HeldReason> {
        self.held.as_ref()
    }

    /// Replays a pass that was finished before: cuts it again (no frame is taken) and passes its
    /// recorded profile to the controller.
    ///
    /// # Errors
    /// Where the record does not fit the job, or the cut fails.
    pub fn replay(&mut self, measured: &DiameterProfile, evidence: &Evidence) -> Result<(), LoopError> {
        self.begin_part(self.part.stock.clone());
        let mut plan = self.plan();
        if let Some(applied) = &evidence.applied_mm {
            plan.offset.o_mm.clone_from(applied);
        }
        let (found, expected) = (measured.stations.len(), plan.station_z_mm.len());
        if found != expected {
            return Err(LoopError::Replay { pass: plan.pass, found, expected });
        }
        self.cell.cut(&plan)?;
        self.conclude(&plan, measured, evidence);
        Ok(())
    }

    /// Cuts, scans, measures and corrects the next pass; before the first one the stock is scanned
    /// where the job requires it.
    ///
    /// # Errors
    /// Where the cut or the source fails; a frame that cannot be measured is no error but leaves
    /// gaps.
    pub fn run_pass(&mut self, progress: Progress<'_>) -> Result<PassResult, LoopError> {
        self.begin()?;
        let cut = self.cut_and_scan(self.plan(), progress)?;
        let judged = self.judge(cut)?;
        let judged = self.repeat(judged, progress)?;
        let decided = self.conclude(&judged.plan, &judged.scan.profile, &judged.evidence);
        self.check_controller()?;
        Ok(self.result(judged, decided))
    }

    /// First stage: the pass is cut and its stations are measured, after the cut or during it.
    fn cut_and_scan(&mut self, plan: PassPlan, progress: Progress<'_>) -> Result<CutPass, LoopError> {
        match self.job.scan.when {
            ScanWhen::AfterPass => {
                self.cell.cut(&plan)?;
                let after_cut = AfterCut::of(self.cell.as_ref());
                let scan = self.scan(plan.pass, progress)?;
                Ok(CutPass { plan, scan, after_cut, notes: Vec::new() })
            }
            ScanWhen::DuringCut => self.cut_and_follow(&plan, progress),
        }
    }

    /// Second stage: implausible stations become gaps, and a master is read for the origin.
    fn judge(&mut self, cut: CutPass) -> Result<JudgedPass, LoopError> {
        let CutPass { plan, mut scan, after_cut, mut notes } = cut;
        notes.extend(pass_before::compare(
            self.part.before.as_ref(),
            &plan,
            &mut scan.profile,
            &self.job.gauge,
        ));
        let master = self.check_master()?;
        let evidence = Evidence {
            origin: after_cut.origin(self.cell.as_ref(), scan.ends, master),
            in_machine: self.cell.in_machine(),
            repeat: None,
            applied_mm: self.job.control.within_pass.map(|_| plan.offset.o_mm.clone()),
        };
        Ok(JudgedPass { plan, scan, evidence, notes })
    }

    /// Third stage: a second scan, where the controller needs one before it takes a large step.
    fn repeat(&mut self, mut judged: JudgedPass, progress: Progress<'_>) -> Result<JudgedPass, LoopError> {
        let JudgedPass { plan, scan, evidence, .. } = &mut judged;
        let needed = self.controller.needs_repeat(plan, &scan.profile, &self.context(evidence));
        // without a second scan the guard of large steps holds and names what it lacks
        if needed && self.cell.can_scan_again() {
            let again = self.scan(plan.pass, progress)?;
            scan.tally.add(again.tally);
            evidence.repeat = Some(again.profile);
        }
        Ok(judged)
    }

    fn result(&self, judged: JudgedPass, decided: Decided) -> PassResult {
        let JudgedPass { plan, scan, evidence, mut notes } = judged;
        notes.extend(decided.notes);
        let half = self.job.part.station_mm / 2.0;
        let intervals: Vec<(f64, f64)> = plan.station_z_mm.iter().map(|z| (z - half, z + half)).collect();
        let seen: Vec<SeenStation> = intervals.iter().map(|i| seen_station(*i, &scan.axis)).collect();
        PassResult {
            truth_mm: self.cell.true_stations_mm(&intervals),
            plan,
            profile: scan.profile,
            readings: scan.readings,
            decision: decided.decision,
            evidence,
            notes,
            alarm: self.alarm.clone(),
            cut: self.cell.last_cut(),
            true_axis: self.cell.true_axis(&seen),
            form: scan.form,
            axis: scan.axis,
            sample: scan.sample,
            frames: scan.tally.frames,
            refused: scan.tally.refused,
            render: scan.tally.waited,
            gauge: scan.tally.measured,
        }
    }

    fn scan(&mut self, pass: u32, progress: Progress<'_>) -> Result<Scanned, LoopError> {
        if let Some((settings, probe)) = self.by_probe() {
            return self.touch_part(pass, &settings, &probe, progress);
        }
        let camera = self.of_part.camera()?;
        let plan = self.job.scan_plan();
        let stream = SettledStream::new(self.gauge.stream());
        let mut measured = Measured::new(&self.job, plan.frames(), camera, stream);
        measured.scan(self.cell.as_mut(), &plan, plan.frames(), progress)?;
        Ok(measured.finish(pass))
    }

    /// Reads the first master pin again: its mean diameter less the certified one, mm; `None` where
    /// the job takes no such frame.
    fn check_master(&mut self) -> Result<Option<f64>, LoopError> {
        let Some(certified_mm) = self.job.masters.pins.first().map(|pin| pin.diameter_mm) else {
            return Ok(None);
        };
        let frames = self.job.masters.check_frames;
        if let Some((settings, probe)) = self.by_probe() {
            return self.touch_master(&settings, &probe);
        }
        let camera = self.calibration.camera()?;
        if frames == 0 {
            return Ok(None);
        }
        let (pin_frames, mut residuals) = (masters::pin_frames, ResidualAccumulator::default());
        let (seen, _) = pin_frames(&self.job, self.cell.as_mut(), &self.gauge, (0, frames), &mut residuals)?;
        let mean =
            |edges: &FrameEdges| camera.diameters(edges).mean(0..edges.columns()).value().map(|d| d.d_mm);
        let diameters: Vec<f64> = seen.iter().filter_map(mean).collect();
        // a pin that cannot be measured reads 0 mm, a deviation beyond every limit
        Ok(Some(diameters.iter().sum::<f64>() / diameters.len().max(1) as f64 - certified_mm))
    }

    /// The next pass as it would be commanded now.
    pub fn plan(&self) -> PassPlan {
        self.job.pass_plan(self.part.next_pass, self.offset.clone())
    }

    fn context<'e>(&self, evidence: &'e Evidence) -> PassContext<'e> {
        let coming = self.part.next_pass + 1;
        let next = (coming as usize <= self.job.passes()).then(|| NextPass {
            nominal_mm: self.job.part.target_mm(coming),
            cutting: self.job.cutting,
            finishing: coming as usize == self.job.part.passes(),
        });
        PassContext {
            origin: evidence.origin.as_ref(),
            in_machine: evidence.in_machine.as_ref(),
            repeat: evidence.repeat.as_ref(),
            next,
            blank_mm: None,
        }
    }

    /// Last stage: the controller decides, and its offsets are put in force.
    fn conclude(&mut self, plan: &PassPlan, measured: &DiameterProfile, evidence: &Evidence) -> Decided {
        let context = self.context(evidence);
        self.part.before = Some((plan.clone(), measured.clone()));
        self.part.next_pass += 1;
        // after the last pass there is no decision, but the controller is updated for the next part
        let decision = self.controller.decide_in(plan, measured, &context);
        if self.next_pass().is_none() {
            self.alarm = self.remeasured(plan, measured);
            return Decided { decision: None, notes: Vec::new() };
        }
        let mut notes = self.controller.notes().to_vec();
        self.alarm = self.controller.alarm().map(str::to_owned);
        let put = match decision {
            Decision::Offset(offset) => self.put_in_force(offset),
            Decision::Held(reason) => Err(reason),
        };
        self.held = put.as_ref().err().cloned();
        let decision = match put {
            Ok(rounded) => {
                notes.extend(rounded);
                Decision::Offset(self.offset.clone())
            }
            Err(reason) => Decision::Held(reason),
        };
        Decided { decision: Some(decision), notes }
    }

    /// Alarm of the re-measurement after the finishing pass, where a station is not proven to lie
    /// within the tolerance (ISO 14253-1).
    fn remeasured(&self, plan: &PassPlan, measured: &DiameterProfile) -> Option<String> {
        let finished = plan.pass as usize == self.job.part.passes();
        let verdict = finished.then(|| part_verdict(&self.job, measured)).flatten()?;
        verdict.alarm.map(|a| format!("finished part: {a}"))
    }

    /// Puts offsets in force as the machine's program makes them: knots along z, rounded to the
    /// control's increments, on which it returns a note. The controller gets these in the next
    /// plan. Offsets that no program can apply are not put in force.
    fn put_in_force(&mut self, asked: DiameterOffset) -> Result<Option<String>, HeldReason> {
        let Some(machine) = &self.job.nc else {
            self.offset = asked.clone();
            self.asked = asked;
            return Ok(None);
        };
        let plan = self.job.pass_plan(self.part.next_pass, asked);
        let path = nc::Path::new(&plan, &machine.machine, machine.dialect)
            .map_err(|refused| HeldReason::Guard(format!("program: {refused}")))?;
        let note = format!(
            "{} knots for {}, the program departs from the offsets by up to {:.2} µm",
            path.knots.len(),
            machine.dialect.as_str(),
            path.largest_departure(&plan) * 1e3
        );
        (self.offset, self.asked) = (path.in_force, plan.offset);
        Ok(Some(note))
    }

    /// Offsets of the next pass as the controller decided them, before the machine's program
    /// rounded them.
    pub fn asked(&self) -> &DiameterOffset {
        &self.asked
    }
}
