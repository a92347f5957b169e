//! One part measured: what happens to the offsets, and why.

use serde::Serialize;

use super::labels::Labels;
use super::proof::{Proof, prove};
use super::release::{before_mm, observed_over_commanded, release};
use super::state::{OffsetState, PartRead, Stage, TRIAL_MM, station_z_mm};
use crate::closed_loop::part_verdict;
use crate::conformity::part_verdict::{Conformity, Verdict};
use crate::control::ControlError;
use crate::job::LoopJob;
use crate::nc;
use crate::plan::{Decision, DiameterOffset, HeldReason};
use crate::profile::DiameterProfile;

/// A part that was measured.
pub(crate) struct Seen {
    /// Its stations.
    pub profile: DiameterProfile,
    /// Digests of its images.
    pub images: Vec<String>,
    /// One digest of all of them.
    pub all_images: String,
    /// Labels that were given; an empty one is that of the state.
    pub labels: Labels,
}

/// What happened to the offsets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Outcome {
    /// An air cut and then a trial cut are next.
    FirstUse,
    /// New offsets are in force.
    Released,
    /// The offsets stay as they were.
    Held,
    /// Tool or insert were changed: the offsets are those to begin with.
    Reset,
    /// The trial cut did not prove sign and unit.
    Refused,
}

/// A station in the result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct StationOffset {
    /// Middle of the station, mm.
    pub z_mm: f64,
    /// Target of the pass, mm.
    pub nominal_mm: f64,
    /// Measured diameter, mm; `None` for a gap.
    pub d_mm: Option<f64>,
    /// Its expanded uncertainty (k = 2), mm.
    pub expanded_u_mm: Option<f64>,
    /// Judgement by the job's tolerance, where it has one and the pass is the last.
    pub judgement: Option<Conformity>,
    /// Offset that the part was cut with, mm of diameter.
    pub old_offset_mm: f64,
    /// Offset of the next part, mm of diameter.
    pub new_offset_mm: f64,
    /// Diameter commanded for the next part, mm.
    pub commanded_mm: f64,
    /// Why.
    pub reason: String,
}

/// The result of a part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Decided {
    /// What happened.
    pub outcome: Outcome,
    /// Why, for the part as a whole.
    pub reason: String,
    /// Why no further part should be cut before an inspection.
    pub alarm: Option<String>,
    /// Observed over commanded change, where it could be judged.
    pub observed_over_commanded: Option<f64>,
    /// Remarks of the controller, on resets and on rounding.
    pub notes: Vec<String>,
    /// The part by its tolerance, where it has one and the pass is the last.
    #[serde(skip)]
    pub verdict: Option<Verdict>,
    /// Every station.
    pub stations: Vec<StationOffset>,
    /// The state for the next part.
    #[serde(skip)]
    pub state: OffsetState,
}

/// What a stage concludes, before it is put into words a station.
struct Concluded {
    outcome: Outcome,
    reason: String,
    alarm: Option<String>,
    notes: Vec<String>,
}

impl Concluded {
    fn new(outcome: Outcome, reason: impl Into<String>) -> Self {
        Self { outcome, reason: reason.into(), alarm: None, notes: Vec::new() }
    }
}

/// Decides on a part. `state` is the one that belongs to the job, new before the first part.
///
/// # Errors
/// A controller that cannot be built for the job.
pub(crate) fn decide(job: &LoopJob, mut state: OffsetState, seen: &Seen) -> Result<Decided, ControlError> {
    let old_mm = state.offsets_mm();
    let was_trial = state.stage == Stage::Trial;
    let mut concluded = match state.used_in(&seen.images, &seen.all_images) {
        Some(number) => Concluded::new(
            Outcome::Held,
            format!("used once: an image is that of measurement {number}, which was decided on already"),
        ),
        None => take_part(job, &mut state, seen, &old_mm)?,
    };
    state.held =
        matches!(concluded.outcome, Outcome::Held | Outcome::Refused).then(|| concluded.reason.clone());
    relabel(job, &mut state, &seen.labels, &mut concluded);
    Ok(in_words(job, state, seen, (concluded, &old_mm, was_trial)))
}

/// A part whose images are new.
fn take_part(
    job: &LoopJob,
    state: &mut OffsetState,
    seen: &Seen,
    old_mm: &[f64],
) -> Result<Concluded, ControlError> {
    state.measurements += 1;
    state.used.push(seen.all_images.clone());
    state.labels.part.clone_from(&seen.labels.part);
    let mut part = PartRead::new(&seen.profile, old_mm, seen.images.clone());
    (part.measurement, part.part) = (state.measurements, state.labels.part.clone());
    match state.stage {
        Stage::First => Ok(begin_trial(job, state, part)),
        Stage::Trial => judge_trial(job, state, part),
        Stage::Released => {
            state.remember(part);
            release_offsets(job, state)
        }
    }
}

/// The first part of a tool: the trial cut comes next.
fn begin_trial(job: &LoopJob, state: &mut OffsetState, part: PartRead) -> Concluded {
    let missing = part.readings.iter().filter(|r| r.value().is_none()).count();
    let of = part.readings.len();
    if missing as f64 > job.control.gaps.interpolate_share * of as f64 {
        let gaps = HeldReason::Gaps { missing, of };
        return Concluded::new(Outcome::Held, format!("{gaps}; measure the part without offsets again"));
    }
    state.first = Some(part);
    let trial = vec![-TRIAL_MM; state.stations.len()];
    match put_in_force(job, state, trial) {
        Ok(notes) => {
            state.stage = Stage::Trial;
            let reason = format!(
                "first use of these offsets: cut air, then a trial cut of a new blank that leaves {:.0} µm more on the diameter; measure it before any \
                 offset is released",
                1e3 * TRIAL_MM
            );
            Concluded { notes, ..Concluded::new(Outcome::FirstUse, reason) }
        }
        Err(why) => Concluded::new(Outcome::Held, why),
    }
}

/// The trial cut: proven, its part is the first that the controller is given.
fn judge_trial(
    job: &LoopJob,
    state: &mut OffsetState,
    mut part: PartRead,
) -> Result<Concluded, ControlError> {
    part.trial = true;
    let z_mm = station_z_mm(job);
    let Some(first) = &state.first else {
        state.stage = Stage::First;
        return Ok(begin_trial(job, state, part));
    };
    match prove(&job.control, before_mm(job, state.pass), &z_mm, (first, &part)) {
        Proof::Proven(ratio) => {
            state.stage = Stage::Released;
            state.history.clear();
            state.remember(part);
            let mut concluded = release_offsets(job, state)?;
            state.observed_over_commanded = Some(ratio);
            if concluded.outcome == Outcome::Held {
                // the trial offsets would go on leaving 50 µm; without any the part is as the first
                let without = vec![0.0; state.stations.len()];
                concluded.notes.extend(put_in_force(job, state, without).unwrap_or_default());
            }
            let proven = format!("sign and unit are proven: {ratio:.3} of the commanded change was observed");
            concluded.notes.insert(0, proven);
            Ok(concluded)
        }
        Proof::NotProven(why) => {
            Ok(Concluded::new(Outcome::Refused, format!("the trial cut proves nothing: {why}")))
        }
        Proof::Refused { ratio, why } => {
            state.observed_over_commanded = Some(ratio);
            let reason = format!("the trial cut is refused: {why}");
            Ok(Concluded { alarm: Some(reason.clone()), ..Concluded::new(Outcome::Refused, reason) })
        }
    }
}

/// The controller decides on the history.
fn release_offsets(job: &LoopJob, state: &mut OffsetState) -> Result<Concluded, ControlError> {
    state.observed_over_commanded = observed_over_commanded(job, state);
    let Some(released) = release(job, state)? else {
        return Ok(Concluded::new(Outcome::Held, "no part was measured"));
    };
    let mut concluded = match released.decision {
        Decision::Held(reason) => Concluded::new(Outcome::Held, reason.to_string()),
        Decision::Offset(offset) => match put_in_force(job, state, offset.o_mm) {
            Ok(notes) => {
                let new = state.offsets_mm();
                state.new_insert_mm.get_or_insert(new);
                let reason = format!("released by the controller {}", job.control.controller.as_str());
                Concluded { notes, ..Concluded::new(Outcome::Released, reason) }
            }
            Err(why) => Concluded::new(Outcome::Held, why),
        },
    };
    concluded.alarm = released.alarm;
    concluded.notes.splice(0..0, released.notes);
    Ok(concluded)
}

/// Puts offsets in force as the machine's program makes them; a note on the rounding.
fn put_in_force(job: &LoopJob, state: &mut OffsetState, asked_mm: Vec<f64>) -> Result<Vec<String>, String> {
    let Some(machine) = &job.nc else {
        for (station, asked) in state.stations.iter_mut().zip(asked_mm) {
            (station.asked_mm, station.offset_mm) = (asked, asked);
        }
        return Ok(Vec::new());
    };
    let plan = job.pass_plan(state.pass, DiameterOffset { o_mm: asked_mm });
    let path = nc::Path::new(&plan, &machine.machine, machine.dialect)
        .map_err(|refused| format!("program: {refused}"))?;
    let pairs = plan.offset.o_mm.iter().zip(&path.in_force.o_mm);
    for (station, (asked, real)) in state.stations.iter_mut().zip(pairs) {
        (station.asked_mm, station.offset_mm) = (*asked, *real);
    }
    Ok(vec![format!(
        "{} knots for {}, the program departs from the offsets by up to {:.2} µm",
        path.knots.len(),
        machine.dialect.as_str(),
        path.largest_departure(&plan) * 1e3
    )])
}

/// Takes up a change of tool or insert for the next part.
fn relabel(job: &LoopJob, state: &mut OffsetState, given: &Labels, concluded: &mut Concluded) {
    let changed = |old: &str, new: &str| !new.is_empty() && new != old;
    let tool = changed(&state.labels.tool, &given.tool);
    let insert = changed(&state.labels.insert, &given.insert);
    let names = (state.labels.clone(), given);
    if !given.tool.is_empty() {
        state.labels.tool.clone_from(&given.tool);
    }
    if tool || !given.insert.is_empty() {
        state.labels.insert.clone_from(&given.insert);
    }
    // a name that is given for the first time is no change
    if tool && !names.0.tool.is_empty() {
        change_tool(job, state, concluded, &names.0.tool);
    } else if insert && !names.0.insert.is_empty() {
        change_insert(job, state, concluded, &names.0.insert);
    }
}

/// A new tool has another offset register: nothing of the old one holds.
fn change_tool(job: &LoopJob, state: &mut OffsetState, concluded: &mut Concluded, old: &str) {
    let zero = vec![0.0; state.stations.len()];
    let put = put_in_force(job, state, zero);
    (state.stage, state.first, state.new_insert_mm) = (Stage::First, None, None);
    state.history.clear();
    state.observed_over_commanded = None;
    concluded.notes.push(format!(
        "tool {:?} in place of {old:?}: its offsets and their proof do not hold for another tool. Reset: offsets to zero, proof of sign \
         and unit, history of the controller. The next part is cut without offsets and measured",
        state.labels.tool
    ));
    concluded.notes.extend(put.err());
    reset(state, concluded, "the tool was changed");
}

/// Records a reset as the outcome; what the images gave stands in the notes.
fn reset(state: &mut OffsetState, concluded: &mut Concluded, why: &str) {
    let before = std::mem::replace(&mut concluded.reason, why.to_owned());
    concluded.notes.insert(0, format!("by the images: {before}"));
    concluded.outcome = Outcome::Reset;
    state.held = None;
}

/// A new insert is not worn: offsets that make up for wear would cut too small.
fn change_insert(job: &LoopJob, state: &mut OffsetState, concluded: &mut Concluded, old: &str) {
    state.history.clear();
    let insert = state.labels.insert.clone();
    let (Stage::Released, Some(new)) = (state.stage, state.new_insert_mm.take()) else {
        concluded.notes.push(format!(
            "insert {insert:?} in place of {old:?}: no offset was released yet, nothing is reset"
        ));
        return;
    };
    state.observed_over_commanded = None;
    // never larger than now: a larger offset makes the part smaller
    let kept: Vec<f64> = state.offsets_mm().iter().zip(&new).map(|(now, new)| now.min(*new)).collect();
    let put = put_in_force(job, state, kept);
    concluded.notes.push(format!(
        "insert {insert:?} in place of {old:?}: a new edge cuts deeper than a worn one. Reset: offsets to those that were first released \
         with a new insert (at every station the smaller of both, so that the part comes out larger), history of the controller. \
         Kept: proof of sign and unit"
    ));
    concluded.notes.extend(put.err());
    reset(state, concluded, "the insert was changed");
}

/// The result, with a reason a station.
fn in_words(
    job: &LoopJob,
    state: OffsetState,
    seen: &Seen,
    (concluded, old_mm, was_trial): (Concluded, &[f64], bool),
) -> Decided {
    let finishing = state.pass as usize == job.part.passes();
    // a trial cut is too large on purpose
    let verdict = (finishing && !was_trial).then(|| part_verdict(job, &seen.profile)).flatten();
    let plan = state.plan(job);
    let nominal_mm: Vec<f64> = plan.commanded_mm().zip(&plan.offset.o_mm).map(|(b, o)| b + o).collect();
    let stations = seen.profile.stations.iter().zip(&state.stations).enumerate().map(|(i, (read, new))| {
        let value = read.reading.value();
        let old = old_mm.get(i).copied().unwrap_or(0.0);
        let step_um = 1e3 * (new.offset_mm - old);
        let nominal_mm = nominal_mm.get(i).copied().unwrap_or(state.nominal_mm);
        StationOffset {
            z_mm: new.z_mm,
            nominal_mm,
            d_mm: value.map(|d| d.d_mm),
            expanded_u_mm: value.map(|d| 2.0 * d.u_mm()),
            judgement: verdict.as_ref().and_then(|v| v.stations.get(i).copied()),
            old_offset_mm: old,
            new_offset_mm: new.offset_mm,
            commanded_mm: nominal_mm - new.offset_mm,
            reason: match (concluded.outcome, read.reading) {
                (Outcome::FirstUse, _) => format!("trial cut: {:.0} µm larger", 1e3 * TRIAL_MM),
                (Outcome::Refused, _) => "trial cut: not proven".to_owned(),
                (Outcome::Held, _) => "held".to_owned(),
                (Outcome::Reset, _) => format!("reset, {step_um:+.2} µm"),
                (Outcome::Released, _) if step_um == 0.0 => "no change: within the deadband".to_owned(),
                (Outcome::Released, crate::profile::Reading::Gap(gap)) => {
                    format!("{step_um:+.2} µm, interpolated: {gap}")
                }
                (Outcome::Released, _) => format!("{step_um:+.2} µm"),
            },
        }
    });
    let stations = stations.collect();
    Decided {
        outcome: concluded.outcome,
        reason: concluded.reason,
        alarm: concluded.alarm,
        observed_over_commanded: state.observed_over_commanded,
        notes: concluded.notes,
        verdict,
        stations,
        state,
    }
}
