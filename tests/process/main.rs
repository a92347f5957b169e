//! The process: beam, force laws, fits, the turning pass.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod beam;
mod fit;
mod force;
mod pass;
