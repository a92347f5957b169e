//! The process: beam, force laws, fits, the turning pass.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

mod beam;
mod fit;
mod followed;
mod force;
mod line;
mod pass;
mod worn;
