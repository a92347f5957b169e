//! A model of a part, a tool and a bar to a whole program.
//!
//! In: a part as `stl` reads it, the tool (`tool`), the machine's data and the control (`nc`). Out:
//! [`PartProgram`], a program from the bar that is replayed on it, with what it leaves and why.
//! `placement` sets the part into the machine, `plan` rough and finishing paths, `left` compares
//! what the replay leaves of the bar with the drawing, `corners` gives a part to a run as a drawing
//! does.

mod corners;
mod error;
mod left;
mod placement;
mod plan;

pub(crate) use corners::shaft_corners;
pub(crate) use error::PartProgramError;
pub(crate) use left::Reason;
#[cfg(test)]
pub(crate) use placement::Placed;
pub(crate) use plan::{Cuts, PartPlan, PartProgram};
