//! A law between its guards: read the errors, guard them, let the law propose, guard the proposal, release or hold.
//!
//! What a law learns from a pass is kept only if its proposal is released: after a refusal it is as if the pass had
//! not been measured.

use super::law::{Law, Seen};
use super::{ControlSettings, Controller, ControllerName, GapSettings, GuardSettings, guards, readings};
use crate::plan::{Decision, DiameterOffset, HeldReason, PassPlan};
use crate::profile::DiameterProfile;

/// A guarded controller.
pub(crate) struct Compensator<L> {
    name: ControllerName,
    law: L,
    gaps: GapSettings,
    guards: GuardSettings,
    notes: Vec<String>,
}

impl<L: Law> Compensator<L> {
    pub(crate) fn new(settings: &ControlSettings, law: L) -> Self {
        Self {
            name: settings.controller,
            law,
            gaps: settings.gaps.clone(),
            guards: settings.guards.clone(),
            notes: Vec::new(),
        }
    }

    fn release(&mut self, plan: &PassPlan, measured: &DiameterProfile) -> Result<DiameterOffset, HeldReason> {
        let errors = readings::errors(plan, measured, &self.gaps)?;
        if !errors.interpolated.is_empty() {
            let at: Vec<String> =
                errors.interpolated.iter().map(|&i| format!("{}", plan.station_z_mm[i])).collect();
            self.notes.push(format!("interpolated between neighbours at z = {} mm", at.join(", ")));
        }
        guards::check_measured(&self.guards, plan, &errors)?;
        let mut law = self.law.clone();
        let proposed = law.propose(&Seen { errors: &errors, offset_mm: &plan.offset.o_mm });
        guards::check_proposed(&self.guards, plan, &proposed)?;
        self.law = law;
        Ok(DiameterOffset { o_mm: proposed })
    }
}

impl<L: Law> Controller for Compensator<L> {
    fn name(&self) -> &str {
        self.name.as_str()
    }

    fn decide(&mut self, plan: &PassPlan, measured: &DiameterProfile) -> Decision {
        self.notes.clear();
        match self.release(plan, measured) {
            Ok(offset) => Decision::Offset(offset),
            Err(reason) => Decision::Held(reason),
        }
    }

    fn notes(&self) -> &[String] {
        &self.notes
    }
}
