//! What a worn nose does to a part, and what a program does about it.
//!
//! A control takes the nose for a circle of the register radius R about a centre that lies R·(σx,
//! σz) from the gauge point. The nose of a real tool reaches h(a) towards a surface with the normal
//! n(a); set by touching, its gauge point lies at g = (σx·Hx, σz·Hz) from the tool point. So a
//! contour programmed with G41 or G42 leaves, along n,
//!
//! e(a) = R(1 + σx·cos a + σz·sin a) − g·n(a) − h(a),
//!
//! positive where material is left. Four ways go about it: the register as it is, the register that
//! leaves least, the contour edited by what is left, and the path of the tool point itself, without
//! the control's compensation.
//!
//! In: `NoseProfile`, `ToolGeometry`, `Outline`. Out: e(a) with u ([`Setting`]), the path of each
//! way ([`Compensator`]), what it leaves ([`Remainder`]) and the [`Document`] of all. `register`
//! holds e(a), `contact` and `biarc` move a piece by what touches it, `chain` joins the moved
//! pieces, `ways` are the four, `left` measures a path against the outline apart from all of these,
//! `sizes` turns that into diameters, faces, cones, arcs and corners. `nose_file` and `settings`
//! read files, `precondition` compares the cut with the one that was measured, `reachable` replaces
//! what a tool cannot cut of an outline. A further way is a variant of [`Way`] and its arm in
//! `ways`. `wear` is the life of an edge by its flank: verdict, history, forecast.

mod biarc;
mod chain;
mod contact;
mod document;
mod error;
mod left;
mod nose_file;
mod precondition;
mod reachable;
mod register;
mod settings;
mod sizes;
mod ways;
pub(crate) mod wear;

pub(crate) use chain::Element;
pub(crate) use document::{Document, LargestLeft, Measured, WayResult, measured};
pub(crate) use error::ToolError;
pub(crate) use left::{Remainder, Tool, largest, moves_of, remainders};
pub(crate) use nose_file::read_nose;
pub(crate) use precondition::MeasuredPass;
pub(crate) use reachable::{LeftOut, OutOfReach, Reachable};
pub(crate) use register::{Setting, Stated};
#[cfg(test)]
pub(crate) use settings::ImageAxes;
pub(crate) use settings::{OutlineFile, ToolFile};
#[cfg(test)]
pub(crate) use sizes::Kind;
pub(crate) use sizes::{PieceChange, changes};
pub(crate) use ways::{Compensated, Compensator, Way};
