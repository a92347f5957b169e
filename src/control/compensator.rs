//! A law between its guards: compute the errors, check them, apply the law, check the proposal,
//! release or hold.
//!
//! The state of a law after a pass is kept only if its proposal is released: after a refusal it is
//! as if the pass had not been measured.

use super::context::{PartStart, PassContext};
use super::controller::Controller;
use super::guards::{self, GuardState, Guarded, Refusal};
use super::law::{Feedforward, Law, Observation};
use super::parts::PartLoop;
use super::readings::{self, Errors};
use super::settings::{ControlSettings, GuardSettings};
use crate::plan::{Decision, DiameterOffset, HeldReason, PassPlan};
use crate::profile::DiameterProfile;

/// Offsets and the updated law, or the refusal.
type Considered<L> = Result<(Vec<f64>, L), Refusal>;

/// A guarded controller.
pub(crate) struct Compensator<L> {
    settings: ControlSettings,
    law: L,
    parts: PartLoop,
    history: Vec<GuardState>,
    used_scan: Option<u64>,
    notes: Vec<String>,
    alarm: Option<String>,
}

impl<L: Law> Compensator<L> {
    pub(crate) fn new(settings: &ControlSettings, law: L) -> Self {
        Self {
            settings: settings.clone(),
            law,
            parts: PartLoop::new(&settings.parts),
            history: Vec::new(),
            used_scan: None,
            notes: Vec::new(),
            alarm: None,
        }
    }

    /// The law, for one that is given its proposal from outside.
    pub(crate) fn law_mut(&mut self) -> &mut L {
        &mut self.law
    }

    /// Whether a measured profile gives an error at every station, by the settings of the gaps.
    pub(crate) fn reads(&self, plan: &PassPlan, measured: &DiameterProfile) -> bool {
        readings::errors(plan, measured, &self.settings.gaps).is_ok()
    }

    fn release(
        &mut self,
        plan: &PassPlan,
        measured: &DiameterProfile,
        context: &PassContext<'_>,
    ) -> Result<DiameterOffset, Refusal> {
        guards::check_origin(&self.settings.guards, plan, measured, context, self.used_scan)?;
        self.used_scan = context.origin.map(|o| o.scan).or(self.used_scan);
        let errors = readings::errors(plan, measured, &self.settings.gaps)?;
        let filled = errors.stations.iter().zip(&plan.station_z_mm).filter(|(s, _)| s.interpolated);
        let at: Vec<String> = filled.map(|(_, z_mm)| z_mm.to_string()).collect();
        if !at.is_empty() {
            self.notes.push(format!("interpolated between neighbours at z = {} mm", at.join(", ")));
        }
        let (outcome, alarm) = self.consider(plan, &errors, context);
        self.alarm = alarm;
        self.history.push(GuardState::new(plan, &errors));
        let (o_mm, law) = outcome?;
        self.law = law;
        Ok(DiameterOffset { o_mm })
    }

    /// Offsets and the updated law, or the refusal; and why the offsets in force may not be used
    /// again.
    fn consider(
        &mut self,
        plan: &PassPlan,
        errors: &Errors,
        context: &PassContext<'_>,
    ) -> (Considered<L>, Option<String>) {
        let Self { settings, parts, notes, history, .. } = self;
        let guarded = Guarded {
            limits: &settings.guards,
            plan,
            context,
            errors,
            history,
            plant_gain: settings.plant_gain,
        };
        let mut law = self.law.clone();
        let outcome = guards::check_measured(&guarded).and_then(|()| {
            parts.record(plan.pass, &plan.offset.o_mm, &errors.e_mm(), settings.plant_gain);
            let proposal = law.propose(&Observation { plan, errors, next: context.next });
            notes.extend(proposal.notes);
            if let Some(reason) = proposal.hold {
                return Err(HeldReason::Guard(format!("the controller holds: {reason}")).into());
            }
            let mut offsets = proposal.o_mm;
            add_earlier_parts(parts, plan.pass, law.feedforward(), &mut offsets);
            leave_deadband(&settings.guards, errors, &plan.offset.o_mm, &mut offsets);
            guards::check_proposed(&guarded, &offsets).map(|()| offsets)
        });
        let alarm = outcome.as_ref().err().and_then(|_| guards::held_undersize(&guarded));
        (outcome.map(|o_mm| (o_mm, law)), alarm)
    }

    /// Raises the alarm where a refusal rules out a further pass, where the held offsets are
    /// predicted to cut undersize, or where the finishing pass would not be checked.
    fn raise_alarm(&mut self, refusal: &Refusal, context: &PassContext<'_>) {
        if refusal.stop || context.next.is_some_and(|n| n.finishing) {
            self.alarm.get_or_insert_with(|| refusal.reason.to_string());
        }
    }
}

/// Largest change of an offset at a station, mm of diameter.
pub(crate) fn step_mm(proposed_mm: &[f64], plan: &PassPlan) -> f64 {
    let steps = proposed_mm.iter().zip(&plan.offset.o_mm).map(|(new, old)| (new - old).abs());
    steps.fold(0.0, f64::max)
}

fn add_earlier_parts(parts: &PartLoop, pass: u32, how: Feedforward, proposed: &mut [f64]) {
    let Some(next) = parts.forecast(pass + 1) else {
        return;
    };
    let this = parts.forecast(pass);
    for (i, o) in proposed.iter_mut().enumerate() {
        *o += match how {
            Feedforward::Nothing => 0.0,
            Feedforward::Whole => next[i],
            Feedforward::Difference => next[i] - this.map_or(0.0, |f| f[i]),
        };
    }
}

fn leave_deadband(limits: &GuardSettings, errors: &Errors, in_force: &[f64], proposed: &mut [f64]) {
    for ((new, old), read) in proposed.iter_mut().zip(in_force).zip(&errors.stations) {
        let band_mm = limits.deadband_mm.max(limits.deadband_uncertainties * read.u_mm);
        if (*new - old).abs() < band_mm {
            *new = *old;
        }
    }
}

impl<L: Law> Controller for Compensator<L> {
    fn name(&self) -> &str {
        self.settings.controller.as_str()
    }

    fn begin_part(&mut self, start: &PartStart<'_>, stations: usize) -> DiameterOffset {
        self.history.clear();
        self.alarm = None;
        self.notes.clear();
        self.parts.begin(start.event);
        let stock = start.stock.and_then(|s| {
            let diameters: Vec<f64> =
                s.stations.iter().filter_map(|s| s.reading.value()).map(|d| d.d_mm).collect();
            (diameters.len() == stations).then_some(diameters)
        });
        self.law.begin(stock);
        match self.parts.forecast(1).filter(|f| f.len() == stations) {
            Some(forecast) => DiameterOffset { o_mm: forecast.to_vec() },
            None => DiameterOffset::zero(stations),
        }
    }

    fn decide_in(
        &mut self,
        plan: &PassPlan,
        measured: &DiameterProfile,
        context: &PassContext<'_>,
    ) -> Decision {
        self.notes.clear();
        self.alarm = None;
        match self.release(plan, measured, context) {
            Ok(offset) => Decision::Offset(offset),
            Err(refusal) => {
                self.raise_alarm(&refusal, context);
                Decision::Held(refusal.reason)
            }
        }
    }

    fn needs_repeat(&self, plan: &PassPlan, measured: &DiameterProfile, context: &PassContext<'_>) -> bool {
        let Ok(errors) = readings::errors(plan, measured, &self.settings.gaps) else {
            return false;
        };
        let proposed =
            self.law.clone().propose(&Observation { plan, errors: &errors, next: context.next }).o_mm;
        step_mm(&proposed, plan) > self.settings.guards.confirm_above_mm
    }

    fn notes(&self) -> &[String] {
        &self.notes
    }

    fn alarm(&self) -> Option<&str> {
        self.alarm.as_deref()
    }
}

/// A controller that is switched off: no correction, the offsets stay as they are.
pub(crate) struct NoCompensation;

impl Controller for NoCompensation {
    fn name(&self) -> &str {
        crate::control::controller_name::ControllerName::None.as_str()
    }

    fn decide_in(
        &mut self,
        plan: &PassPlan,
        _measured: &DiameterProfile,
        _context: &PassContext<'_>,
    ) -> Decision {
        if plan.offset.o_mm.len() == plan.station_z_mm.len() {
            Decision::Offset(plan.offset.clone())
        } else {
            Decision::Held(HeldReason::Guard("the plan's offsets are not its stations'".into()))
        }
    }
}
