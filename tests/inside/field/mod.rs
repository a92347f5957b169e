//! Inputs from the field: each module contains one kind of file, camera, part or table on which the
//! program once failed, with property tests around it. Files of the collection itself are read from
//! `$SHADOWGAUGE_FIELD` where it is set.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

mod backends;
mod clipping;
mod conformity;
mod encoding;
mod formats;
use crate::inside::support::gauge_synth;
mod kinds;
mod nc;
mod optics;
mod order;
mod outputs;
mod pictures;
use crate::inside::support::program;
mod refusals;
mod refused;
mod sizes;
mod statistics;
mod support;
mod uneven;
