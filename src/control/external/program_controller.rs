//! A program as a controller: asked once a pass, its offsets guarded as every controller's.

use std::cell::RefCell;
use std::io::{Read, Write};

use super::answered::Answered;
use super::conversation::Conversation;
use super::error::{Fault, ProgramError};
use super::facts::PartFacts;
use super::messages::{Begin, Message, Pass};
use super::reply::Answer;
use crate::control::compensator::{Compensator, step_mm};
use crate::control::context::{PartStart, PassContext};
use crate::control::controller::Controller;
use crate::control::settings::ControlSettings;
use crate::plan::{Decision, DiameterOffset, HeldReason, PassPlan};
use crate::profile::{DiameterProfile, Station};

const FAILED: &str = "the controller's program failed: nothing decides the offsets of the next pass";

/// A controller whose law is a program at the other end of a stream, by the protocol
/// [`PROTOCOL`](super::PROTOCOL).
///
/// The guards of `[control.guards]` and `[control.gaps]` stand between its replies and the machine.
/// Nothing is carried from part to part here: what the program keeps is its own.
pub(crate) struct ProgramController<S: Read + Write> {
    name: String,
    settings: ControlSettings,
    facts: PartFacts,
    compensator: Compensator<Answered>,
    program: RefCell<Program<S>>,
    failure: Option<ProgramError>,
}

/// The program and what it replied.
struct Program<S> {
    conversation: Conversation<S>,
    /// The reply to a pass that is not decided yet.
    reply: Option<(u32, Answer)>,
    /// Why the last reply was not put in force.
    held: Option<String>,
    failure: Option<ProgramError>,
}

impl<S: Read + Write> Program<S> {
    /// The reply to a pass, asked for once.
    fn ask(
        &mut self,
        plan: &PassPlan,
        measured: &DiameterProfile,
        context: &PassContext<'_>,
    ) -> Result<Answer, ProgramError> {
        if let Some(failure) = &self.failure {
            return Err(failure.clone());
        }
        if let Some((_, answer)) = self.reply.as_ref().filter(|(pass, _)| *pass == plan.pass) {
            return Ok(answer.clone());
        }
        let message = Message::Pass(Pass {
            pass: plan.pass,
            nominal_mm: plan.nominal_mm,
            cutting: plan.cutting,
            offsets_mm: &plan.offset.o_mm,
            stations: &measured.stations,
            origin: context.origin,
            held: self.held.as_deref(),
            next: context.next,
        });
        match self.conversation.ask(&message, plan.pass, plan.station_z_mm.len()) {
            Ok(answer) => {
                self.reply = Some((plan.pass, answer.clone()));
                Ok(answer)
            }
            Err(error) => {
                self.failure = Some(error.clone());
                Err(error)
            }
        }
    }

    fn begin(&mut self, message: Begin<'_>) {
        (self.reply, self.held) = (None, None);
        if let Err(error) = self.conversation.send(&Message::Begin(message)) {
            let fault = Fault::Lost { pass: 1, cause: error.to_string() };
            self.failure.get_or_insert(self.conversation.error(fault));
        }
    }
}

impl<S: Read + Write> ProgramController<S> {
    /// A controller over a stream to `command`, which is named in errors. Of `settings` the guards,
    /// the gaps, the plant gain and what the model-based controller assumes are used.
    pub(crate) fn new(
        stream: S,
        name: &str,
        command: &str,
        settings: &ControlSettings,
        facts: PartFacts,
    ) -> Self {
        let mut settings = settings.clone();
        settings.parts.enabled = false;
        let conversation = Conversation::new(stream, format!("{name} ({command})"));
        Self {
            name: name.to_owned(),
            compensator: Compensator::new(&settings, Answered::default()),
            settings,
            facts,
            program: RefCell::new(Program { conversation, reply: None, held: None, failure: None }),
            failure: None,
        }
    }
}

impl<S: Read + Write> Controller for ProgramController<S> {
    fn name(&self) -> &str {
        &self.name
    }

    fn begin_part(&mut self, start: &PartStart<'_>, stations: usize) -> DiameterOffset {
        let stock: Option<&[Station]> = start.stock.map(|stock| stock.stations.as_slice());
        let program = self.program.get_mut();
        program.begin(Begin::new(&self.facts, &self.settings, start.event, stock));
        self.failure.clone_from(&program.failure);
        self.compensator.begin_part(start, stations)
    }

    fn decide_in(
        &mut self,
        plan: &PassPlan,
        measured: &DiameterProfile,
        context: &PassContext<'_>,
    ) -> Decision {
        let program = self.program.get_mut();
        match program.ask(plan, measured, context) {
            Ok(answer) => {
                program.reply = None;
                self.compensator.law_mut().answer = Some(answer);
                let decision = self.compensator.decide_in(plan, measured, context);
                program.held = match &decision {
                    Decision::Held(reason) => Some(reason.to_string()),
                    Decision::Offset(_) => None,
                };
                decision
            }
            Err(error) => {
                let reason = HeldReason::Guard(error.to_string());
                self.failure = Some(error);
                Decision::Held(reason)
            }
        }
    }

    fn needs_repeat(&self, plan: &PassPlan, measured: &DiameterProfile, context: &PassContext<'_>) -> bool {
        let answer = self.program.borrow_mut().ask(plan, measured, context);
        let Ok(Answer::Offsets(proposed)) = answer else { return false };
        self.compensator.reads(plan, measured)
            && step_mm(&proposed, plan) > self.settings.guards.confirm_above_mm
    }

    fn notes(&self) -> &[String] {
        self.compensator.notes()
    }

    fn alarm(&self) -> Option<&str> {
        if self.failure.is_some() { Some(FAILED) } else { self.compensator.alarm() }
    }

    fn failure(&self) -> Option<&ProgramError> {
        self.failure.as_ref()
    }
}

impl<S: Read + Write> Drop for ProgramController<S> {
    fn drop(&mut self) {
        // A program that has gone needs no farewell.
        let _ = self.program.get_mut().conversation.send(&Message::End);
    }
}
