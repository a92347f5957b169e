//! Control laws: from the errors of one pass to the offsets of the next, without limits or guards.

mod ilc;
mod lsq;
mod model;
mod pid_law;
mod proposal;
mod run_to_run;
mod stepped_beam;

pub(crate) use ilc::{IlcLaw, q_filter};
pub(crate) use lsq::LsqLaw;
pub(crate) use model::{ModelLaw, nominal_gain};
pub(crate) use pid_law::PidLaw;
pub(crate) use proposal::{Feedforward, Law, Observation, Proposal};
pub(crate) use run_to_run::{DoubleEwmaLaw, EwmaLaw};
