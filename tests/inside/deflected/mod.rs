//! A shaft that sags, is bent by a force and runs out: its diameters are unaffected, and its axis
//! is measured.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

mod axis;
mod depth;
mod setup;
mod sweep;
