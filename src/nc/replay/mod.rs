//! Replays a finished program among the solids of the machine, before it is returned.
//!
//! The text is read again by an interpreter (`interpreter`, `event`, `arcs`) that shares nothing
//! with the emitter, from every start position of a lattice and of the solids' corners that is
//! clear; each move sweeps the nose's outline (and the holder's box, where it is stated) through
//! the plane of the tool. A program passes where
//!
//! - no move touches chuck, jaws, centre, quill, steady rest or parked gauge head, or leaves the
//!   travel,
//! - no rapid comes closer to the stock than half the clearance, and none moves X and Z together
//!   below the change position,
//! - the tool is changed, and the part measured, at the change position alone,
//! - the probe goes down to the part in probing moves alone, radially and with the spindle standing
//!   still, and neither its ball nor its body touches anything else, even where no touch stops it,
//! - in a bore no rapid comes closer to the drilled hole than half the clearance, and the bar keeps
//!   off the finished bore in feed as well,
//! - no feed cuts below the commanded diameter (contours are judged by what they leave instead),
//! - in a program from the bar no rapid touches what is left of it at that moment (`turned_stock`),
//! - feeds at the commanded diameter cover the part from the stated end of the cut to its end face,
//! - the gauge head is triggered at the planned places alone, each once and in order, with the tool
//!   retracted, coolant and air off, the shutter open, carriage and spindle at rest; it
//!   passes over the part and touches nothing on the way.

mod arcs;
mod bore_space;
mod commanded_scan;
mod convex;
mod event;
mod expression;
mod finished;
mod flow;
mod interpreter;
mod judge;
mod nose;
mod run;
mod scan;
mod scan_state;
mod sinumerik;
mod sinumerik_edge;
mod surface;
mod touch;
mod turned_stock;

pub(crate) use bore_space::BoreSpace;
pub(crate) use commanded_scan::{CommandedScan, CommandedStop};
pub(crate) use convex::Convex;
#[cfg(test)]
pub(crate) use event::Event;
pub(crate) use event::{Deed, Point, SpindleState};
pub(crate) use finished::FinishedSolid;
#[cfg(test)]
pub(crate) use interpreter::Control;
pub(crate) use judge::{CommandedCut, Solid, WorkingSpace, check, check_once, must_alarm};
pub(crate) use run::run;
#[cfg(test)]
pub(crate) use run::variables;
pub(in crate::nc) use scan_state::frames_s;
pub(crate) use surface::Surface;
pub(crate) use turned_stock::TurnedStock;
