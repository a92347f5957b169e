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
//!
//! A frame in memory, measured ([`measurement`] has streams, tolerances, turns and rings; a folder
//! of files is [`source::FileFrames`]):
//!
//! ```
//! use shadowgauge::frame::{FrameView, PixelFormat, Pixels};
//! use shadowgauge::gauge::{Calibration, Gauge, GaugeSettings, calibration::Conditions};
//!
//! let grey = |row: usize| if (41..100).contains(&row) { 12 } else { 210 };
//! let pixels: Vec<u8> = (0..140 * 64).map(|i| grey(i / 64)).collect();
//! let view = FrameView::new(Pixels::U8(&pixels), PixelFormat::Mono8, 140, 64, 64)?;
//! let gauge = Gauge::new(GaugeSettings::default())?;
//! let measured = gauge.measure(&view, &Calibration::from_scale(17.4), &Conditions::default())?;
//! let largest = measured.diameter.ok_or("no column has both edges")?;
//! println!("D = {:.4} mm, u = {:.4} mm", largest.diameter.d_mm, largest.u_mm);
//! # assert!((largest.diameter.d_mm - 59.0 * 0.0174).abs() < 1e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Features, all on by default: `render` is the simulator (`process`, `render`, the simulated cell,
//! whole jobs, `studies`, `truth`, `config`), `report` run folders and their pages, `cli` the
//! program. Without them the crate is the instrument, with the closed loop for a cell of one's own
//! ([`cell::TurningCell`], [`control::Controller`], [`closed_loop::ClosedLoop::with_controller`];
//! `examples/own_controller.rs`).

#![cfg_attr(
    not(feature = "cli"),
    allow(dead_code, unused_imports, reason = "the program uses what a part of the features leaves unused")
)]

// -- 0 vocabulary: types, the rule of conformity, tables of text, mathematics without state
pub mod conformity;
pub mod frame;
pub(crate) mod nose;
mod numerics;
pub(crate) mod outline;
pub mod plan;
pub mod position;
pub mod profile;
pub mod setting;
pub mod shaft;
mod text_table;
// -- 1 stages: import the vocabulary and their own folder
pub mod control;
pub mod gauge;
#[cfg(feature = "render")]
pub(crate) mod machine;
pub mod nc;
pub mod probe;
#[cfg(feature = "render")]
pub mod process;
#[cfg(feature = "render")]
pub mod render;
pub mod source;
#[cfg(feature = "render")]
pub(crate) mod stl;
#[cfg(feature = "render")]
pub(crate) mod tool;
// -- 2 composition: where stages meet
pub mod cell;
pub mod closed_loop;
#[cfg(feature = "render")]
pub(crate) mod identification;
pub mod job;
pub mod measurement;
#[cfg(feature = "render")]
pub(crate) mod part_offsets;
#[cfg(feature = "render")]
pub(crate) mod part_program;
#[cfg(feature = "render")]
pub mod studies;
#[cfg(feature = "render")]
pub mod truth;
// -- 3 surface
#[cfg(feature = "cli")]
pub mod cli;
#[cfg(feature = "render")]
pub mod config;
#[cfg(feature = "report")]
pub(crate) mod files;
#[cfg(feature = "cli")]
pub(crate) mod publish;
#[cfg(feature = "report")]
pub(crate) mod report;
#[cfg(feature = "report")]
pub(crate) mod run_folder;
#[cfg(feature = "serve")]
pub(crate) mod serve;
#[cfg(feature = "store")]
pub(crate) mod store;

#[cfg(all(test, feature = "cli"))]
extern crate self as shadowgauge;
#[cfg(all(test, feature = "cli"))]
#[path = "../tests/inside/mod.rs"]
mod inside;

/// The README's example is compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
