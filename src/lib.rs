//! shadowgauge: a vision-based in-process optical diameter gauge.
//!
//! Data flows one way, once per pass:
//!
//! ```text
//! PassPlan -> process -> Shaft -> render -> frames -> gauge -> DiameterProfile
//!          -> control -> DiameterOffset -> next PassPlan
//! ```
//!
//! Frames come from a simulator, a recording or a camera; everything after [`frame::Frame`] is the
//! same for all three. The instrument (`gauge`, `probe`, `control`, `nc`, `source`) has no access
//! to the truth: it imports only the vocabulary. `tests/architecture.rs` holds the direction of
//! imports.

// -- 0 vocabulary: types, the rule of conformity, mathematics without state
pub mod conformity;
pub mod frame;
mod numerics;
pub mod plan;
pub mod profile;
pub mod setting;
pub mod shaft;
// -- 1 stages: import the vocabulary and their own folder
pub mod control;
pub mod gauge;
pub mod nc;
pub mod probe;
pub mod process;
pub mod render;
pub mod source;
// -- 2 composition: where stages meet
pub mod cell;
pub mod closed_loop;
pub mod job;
pub mod measurement;
pub mod studies;
pub mod truth;
// -- 3 surface
pub mod cli;
pub mod config;
pub mod files;
pub mod report;
pub mod run_folder;
