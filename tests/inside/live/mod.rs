//! Live sources: one suite (`conformance`) that every kind of source passes, driven by a factory of
//! sources; `scripted` is the source whose script states what it sends, `policies` and `identity`
//! what is particular to it; `foreign` are cameras that are not ours; `windows` cuts the frames of
//! any source to two windows.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

mod bound;
#[cfg(all(feature = "camera", feature = "cli"))]
mod camera;
mod conformance;
#[cfg(all(feature = "camera", feature = "cli", unix))]
mod foreign;
mod identity;
mod policies;
#[cfg(feature = "mcap")]
mod replay;
mod scripted;
#[cfg(feature = "render")]
mod simulated;
mod stored;
mod windows;
