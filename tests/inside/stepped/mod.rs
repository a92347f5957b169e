//! The stepped shaft: sections, the cut along a contour, control by section, its program.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

mod control;
mod process;
mod program;
mod sections;

use shadowgauge::job::Job;

/// The preset, as it stands.
fn job() -> Job {
    let text = std::fs::read_to_string("configs/stepped_shaft.toml").unwrap();
    shadowgauge::config::parse(&text, "stepped_shaft.toml").unwrap()
}
