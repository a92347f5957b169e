//! `study head`: what a head will measure a part to, and how fast, from its config alone; several
//! side by side, so that a lens can be chosen.
//!
//! In: configs with `[camera]`, `[optics]`, `[light]` and `[sensor]`, a diameter. Out: a column of
//! [`HeadFigures`] a head, and which of them has the smaller U.
//!
//! From below: `settings`, `edge` (the edge over pixels), `bound` (information), `displacement` (a
//! changed edge under a fixed model) → `range` (diameters), `setup` (a head before a part) →
//! `optics`, `repeatability`, `exposure`, `depth`, `frames` (rendered and measured beside the
//! prediction), `motion` (in use) → `budget` (by its masters) → `figures`
//! (all of one head) → `verdict`, `study`. `limb` is the edge of a round part before one
//! head: what moves it, and by how much it differs from the masters'. A new figure is a
//! file with a function of a [`HeadSetup`], a field of [`HeadFigures`] and a row in
//! `report/head_rows.rs`.

mod bound;
mod budget;
mod depth;
mod displacement;
mod edge;
mod error;
mod exposure;
mod figures;
mod frames;
pub(crate) mod limb;
mod motion;
mod optics;
mod range;
mod repeatability;
mod settings;
mod setup;
mod study;
mod verdict;

pub(crate) use budget::{HeadBudget, HeadLimit};
pub(crate) use depth::DepthEnd;
pub(crate) use error::HeadError;
pub(crate) use exposure::ExposureEnd;
pub(crate) use figures::HeadFigures;
pub(crate) use frames::{FrameCheck, ModelErrors};
pub(crate) use settings::{ExposureLimits, HeadSettings};
pub(crate) use setup::{HeadConfig, HeadSetup};
pub(crate) use study::{HeadStudy, frames_in_all, study};
