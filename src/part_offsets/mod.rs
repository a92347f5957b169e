//! From a measured part to the offsets of the next one, with no simulator in between.
//!
//! In: a job, the profile of a part that was just turned, and the state that the last part left.
//! Out: a [`Decided`]: the offsets in force for the next part, with a reason, and the new state.
//!
//! ```text
//! first part, no offsets ─► trial cut, 50 µm larger ─► proven? ─► released, part after part
//!                                                     └► refused, with the likely cause
//! ```
//!
//! Parts take the place of the passes of a run: the same controller and the same guards decide, the
//! stations and the rule of conformity are those of the job. A part is a new blank, so that the
//! guards of depth and of undersize reckon with the diameter before the pass, not with the one just
//! measured, and nothing of one part's form is copied into the next.
//!
//! `labels` are part, tool and insert, `state` is the file between two parts, `proof` judges the
//! trial cut, `release` runs the controller, `decision` joins them. A new stage of the sequence is
//! a variant of `Stage` with an arm in `decision`.

mod decision;
mod labels;
mod proof;
mod release;
mod state;

pub(crate) use decision::{Decided, Outcome, Seen, decide};
pub(crate) use labels::Labels;
pub(crate) use state::{OffsetState, Stage, TRIAL_MM};
