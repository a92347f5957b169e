//! Controllers on equal terms: every one turns the same shafts, rendered and measured; errors by
//! pass with intervals.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::cell::SimulatedCell;
use crate::closed_loop::{Calibrated, ClosedLoop, LoopError};
use crate::control::external::ProgramError;
use crate::control::{self, Controller, ControllerName, OnAlarm};
use crate::job::Job;
use crate::plan::Decision;
use crate::render::Renderer;

/// Confidence of the intervals.
const CONFIDENCE: f64 = 0.95;

/// A controller that is compared: one of these, or a program.
#[derive(Clone, Copy)]
pub(crate) enum Contestant<'a> {
    /// Of `[control]`.
    Own(ControllerName),
    /// In another program.
    Program(&'a dyn ControllerProgram),
}

/// A program that decides offsets, by the protocol of [`crate::control::external`].
pub(crate) trait ControllerProgram {
    /// Its name in tables.
    fn name(&self) -> &str;

    /// Its command, as it was given.
    fn command(&self) -> &str;

    /// Starts it for one shaft, with nothing left of an earlier one.
    ///
    /// # Errors
    /// Where it cannot be started.
    fn start(&self, job: &Job) -> Result<Box<dyn Controller + Send>, ProgramError>;
}

impl Contestant<'_> {
    /// The reference: without control.
    const NONE: Self = Self::Own(ControllerName::None);

    fn is_none(&self) -> bool {
        matches!(self, Self::Own(ControllerName::None))
    }

    /// Its name in tables.
    pub(crate) fn name(&self) -> &str {
        match self {
            Self::Own(name) => name.as_str(),
            Self::Program(program) => program.name(),
        }
    }

    fn start(&self, job: &Job) -> Result<Box<dyn Controller + Send>, LoopError> {
        match self {
            Self::Own(_) => {
                let order = job.loop_job();
                Ok(control::build(&order.run_control(), order.layout())?)
            }
            Self::Program(program) => Ok(program.start(job)?),
        }
    }

    fn command(&self) -> Option<&str> {
        match self {
            Self::Own(_) => None,
            Self::Program(program) => Some(program.command()),
        }
    }
}

/// One pass of one shaft under one controller.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct PassError {
    /// Controller.
    pub controller: String,
    /// Seed of the shaft.
    pub seed: u64,
    /// Pass, from 1.
    pub pass: u32,
    /// Largest |measured − nominal| over the stations, mm.
    pub measured_mm: f64,
    /// Largest |true − nominal|, mm.
    pub true_mm: f64,
    /// Largest |measured − true|, mm.
    pub reading_mm: f64,
    /// The offsets were held after this pass.
    pub held: String,
}

/// Errors of one pass over the shafts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct PassSummary {
    /// Pass, from 1.
    pub pass: u32,
    /// Mean over the shafts of the largest true error, mm.
    pub mean_mm: f64,
    /// Half width of its 95 % interval (Student's t), mm; none for a single shaft.
    pub interval_mm: Option<f64>,
    /// Median, mm.
    pub median_mm: f64,
    /// Worst shaft, mm.
    pub worst_mm: f64,
    /// Largest share of the same shaft's error without control.
    pub worst_share_of_none: f64,
}

/// One controller.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct ControllerSummary {
    /// Its name.
    pub controller: String,
    /// The command of a program; none for a controller of `[control]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub command: Option<String>,
    /// Every pass.
    pub passes: Vec<PassSummary>,
    /// Passes after which the offsets were held.
    pub held: usize,
}

/// The study.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct ControllerStudy {
    /// Shafts turned by every controller.
    pub shafts: usize,
    /// By controller.
    pub controllers: Vec<ControllerSummary>,
    /// Every shaft and pass.
    pub runs: Vec<PassError>,
}

/// Turns `shafts` shafts (seeds counted from the job's) with every controller; `none` always comes
/// first, as the reference. A program has a process a shaft and is given what the others are; the
/// stock is scanned for it where `scan.stock` is `always`.
///
/// # Errors
/// Where a job does not fit together, the renderer, the gauge or a program fails.
pub(crate) fn run(
    job: &Job,
    controllers: &[Contestant<'_>],
    shafts: usize,
    renderer: &Renderer,
    done: &mut dyn FnMut(&str, u64),
) -> Result<ControllerStudy, LoopError> {
    let mut order = vec![Contestant::NONE];
    order.extend(controllers.iter().filter(|c| !c.is_none()));
    let mut runs = Vec::new();
    for i in 0..shafts as u64 {
        let mut calibration = None;
        for contestant in &order {
            let mut one = job.clone();
            one.seed = job.seed + i;
            one.control.controller = match contestant {
                Contestant::Own(name) => *name,
                Contestant::Program(_) => ControllerName::None,
            };
            // all passes of every controller are cut; an alarm counts as offsets held
            one.control.guards.on_alarm = OnAlarm::GoOn;
            runs.extend(turn(&one, contestant, renderer, &mut calibration)?);
            done(contestant.name(), one.seed);
        }
    }
    let controllers = order.iter().map(|c| summary(c, &runs)).collect();
    Ok(ControllerStudy { shafts, controllers, runs })
}

/// One shaft. The optical setup of a seed is calibrated once for all controllers.
fn turn(
    job: &Job,
    contestant: &Contestant<'_>,
    renderer: &Renderer,
    calibration: &mut Option<Calibrated>,
) -> Result<Vec<PassError>, LoopError> {
    let cell = SimulatedCell::new(job, renderer)?;
    let controller = contestant.start(job)?;
    let cell = Box::new(cell);
    let mut turning = ClosedLoop::with_controller(job.checked_loop()?, cell, calibration.take(), controller)?;
    *calibration = Some(turning.calibration().clone());
    let mut passes = Vec::new();
    while turning.next_pass().is_some() {
        let pass = turning.run_pass(&mut |_, _| {})?;
        let nominal: Vec<f64> = pass.plan.station_nominal_mm().collect();
        let largest = |values: &mut dyn Iterator<Item = f64>| values.map(f64::abs).fold(0.0, f64::max);
        let readings = || pass.profile.stations.iter().map(|s| s.reading.value().map(|d| d.d_mm));
        let truth = || pass.truth_mm.iter().flatten().copied();
        passes.push(PassError {
            controller: contestant.name().to_owned(),
            seed: job.seed,
            pass: pass.plan.pass,
            measured_mm: largest(&mut readings().zip(&nominal).filter_map(|(d, r)| Some(d? - r))),
            true_mm: largest(&mut truth().zip(&nominal).map(|(d, r)| d - r)),
            reading_mm: largest(&mut readings().zip(truth()).filter_map(|(d, t)| Some(d? - t))),
            held: match &pass.decision {
                Some(Decision::Held(reason)) => reason.to_string(),
                _ => String::new(),
            },
        });
    }
    Ok(passes)
}

fn summary(contestant: &Contestant<'_>, runs: &[PassError]) -> ControllerSummary {
    let passes = runs.iter().map(|r| r.pass).max().unwrap_or(0);
    let controller = contestant.name();
    ControllerSummary {
        controller: controller.to_owned(),
        command: contestant.command().map(str::to_owned),
        passes: (1..=passes).map(|pass| pass_summary(controller, pass, runs)).collect(),
        held: runs.iter().filter(|r| r.controller == controller && !r.held.is_empty()).count(),
    }
}

fn pass_summary(controller: &str, pass: u32, runs: &[PassError]) -> PassSummary {
    let of = |name: &'static str| runs.iter().filter(move |r| r.pass == pass && r.controller == name);
    let mine: Vec<&PassError> =
        runs.iter().filter(|r| r.pass == pass && r.controller == controller).collect();
    let mut errors: Vec<f64> = mine.iter().map(|r| r.true_mm).collect();
    errors.sort_by(f64::total_cmp);
    let n = errors.len();
    let mean_mm = errors.iter().sum::<f64>() / n as f64;
    let share = |r: &&PassError| of("none").find(|o| o.seed == r.seed).map(|o| r.true_mm / o.true_mm);
    PassSummary {
        pass,
        mean_mm,
        interval_mm: interval(&errors, mean_mm),
        median_mm: 0.5 * (errors[(n - 1) / 2] + errors[n / 2]),
        worst_mm: errors[n - 1],
        worst_share_of_none: mine.iter().filter_map(share).fold(0.0, f64::max),
    }
}

/// Half width t·s/√n of the interval of a mean, mm.
fn interval(errors: &[f64], mean: f64) -> Option<f64> {
    let n = errors.len() as f64;
    let student = StudentsT::new(0.0, 1.0, n - 1.0).ok()?;
    let variance = errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / (n - 1.0);
    Some(student.inverse_cdf(0.5 + 0.5 * CONFIDENCE) * (variance / n).sqrt())
}
