//! Studies of the process: deflection, single factors, choice of cutting data, reproduction of the
//! papers.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

mod cli;
mod constants;
mod optimize;
use crate::inside::support::program;
mod reproduce;
mod tool_wear;
