//! The law that proposes what a program replied.

use super::reply::Answer;
use crate::control::law::{Feedforward, Law, Observation, Proposal};

/// Proposes the program's last reply.
#[derive(Clone, Debug, Default)]
pub(super) struct Answered {
    pub(super) answer: Option<Answer>,
}

impl Law for Answered {
    fn begin(&mut self, _stock_mm: Option<Vec<f64>>) {
        self.answer = None;
    }

    fn propose(&mut self, seen: &Observation<'_>) -> Proposal {
        match &self.answer {
            Some(Answer::Offsets(o_mm)) => o_mm.clone().into(),
            Some(Answer::Hold(reason)) => Proposal::hold(seen, reason.clone()),
            None => Proposal::hold(seen, "no reply".to_owned()),
        }
    }

    /// What a program carries from part to part is in its offsets already.
    fn feedforward(&self) -> Feedforward {
        Feedforward::Nothing
    }
}
