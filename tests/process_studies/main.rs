//! Studies of the process: deflection, single factors, choice of cutting data, reproduction of the slender-shaft paper.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod cli;
mod optimize;
mod reproduce;
