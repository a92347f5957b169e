//! Calibration of an optical setup, its budget, Monte Carlo and coverage.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

mod cli;
mod coverage;
mod jcgm_101;
mod limits;
use crate::inside::support::program;
mod setup;
mod trust;
