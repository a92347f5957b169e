//! Effects of shaft, lens and exposure on the edges, against closed forms, brute force and second
//! integrations.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use crate::inside::support::program;
use crate::inside::support::render as support;

mod corners;
mod exposure;
mod features;
mod form;
mod refused;
mod view;

fn close(found: f64, wanted: f64, tolerance: f64, what: &str) {
    assert!((found - wanted).abs() <= tolerance, "{what}: {found}, not {wanted} ± {tolerance}");
}
