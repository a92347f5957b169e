//! The limb of a round part before one head: what moves the image of its edge, and how far the
//! part's edges stand from where the masters' calibration places them.
//!
//! In: a [`HeadSetup`](super::HeadSetup) whose optics state lens and light. Out: [`LimbEffects`]
//! (`study optics`) and a [`Comparison`] with the table that a gauge corrects by (`optics limb`).
//!
//! `shift` fits the gauge's edge to the image of a limb; `comparison` takes the masters' line off
//! and gives each cause its limits; `effects` varies one quantity at a time, `advice` states what
//! of it a buyer of a lens can choose; `of_run` is the difference that `run` corrects by.

mod advice;
mod comparison;
mod effects;
mod of_run;
mod shift;

pub(crate) use advice::FocusOfRatio;
pub(crate) use comparison::{Comparison, Surfaces, Texture, compare};
pub(crate) use effects::{Effect, EffectKind, EffectPoint, LimbEffects, effects};
pub(crate) use of_run::limb_of_run;
pub(crate) use shift::{FittedEdge, LimbHead};
