//! The life of a cutting edge by its flank wear: whether it is blunt, how it wears, and when it
//! will be blunt.
//!
//! In: VBB and VBBmax with u (µm), rows of a history. Out: a [`WearClass`], a [`WearVerdict`] by
//! the decision rule of `conformity`, a [`Forecast`] of the cut at which a limit is reached, with
//! its interval. One more criterion is a limit of [`WearLimits`] and a line of `verdict`.

mod blunt;
mod forecast;
mod history;

pub(crate) use blunt::{Land, WearClass, WearLimits, WearVerdict};
pub(crate) use forecast::{Forecast, forecast};
pub(crate) use history::{WearRow, read_history, write_history};
