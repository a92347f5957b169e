//! The lathe as a measuring machine: chains, functions of errors, what heads make of them, and the
//! study over all of it.

mod bad_input;
mod chain;
mod cli;
mod coverage;
mod dialects;
mod displacement_probe;
mod each_alone;
mod feed_forward;
mod functions;
mod identification;
mod identified_run;
mod midline_frames;
mod models;
mod reading_correction;
mod reproduce_001;
mod response;
mod run;
mod spindle;
mod study;

use crate::identification::{CheckedSet, Identification, IdentificationConfig, checked_set, identify};
use crate::machine::MachineSettings;
use crate::studies::machine::MachineStudyConfig;
use crate::studies::machine_readings::SimulatedMachine;

/// A machine with levers that all differ, without errors.
const MACHINE: &str = r#"
[machine]
chain = "t_shaped"
tool_mm = [110.0, 90.0, 70.0]
head_mm = [60.0, 90.0, 130.0]
carriage_mm = [40.0, 80.0, 120.0]
x_travel_mm = [-50.0, 100.0]
z_travel_mm = [0.0, 100.0]

[part]
diameter_mm = 25.0
"#;

/// The study of [`MACHINE`] with changes of its text and errors behind it.
fn study(changes: &[(&str, &str)], errors: &str) -> MachineStudyConfig {
    let mut text = MACHINE.to_owned();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    toml::from_str(&(text + errors)).unwrap()
}

/// What a config identifies from readings that are simulated on a machine.
fn identification_of(config: &str, truth: &MachineSettings, seed: u64) -> Identification {
    let config: IdentificationConfig = toml::from_str(config).unwrap();
    let machine = SimulatedMachine::new(truth.clone(), config.temperature_c, seed).unwrap();
    let set = |k: usize| {
        let text = machine.text(&config.readings[k], k).unwrap();
        checked_set(&config, k, text.as_bytes(), "drawn.csv").unwrap()
    };
    let sets: Vec<CheckedSet> = (0..config.readings.len()).map(set).collect();
    identify(&config, &sets).unwrap()
}

/// The machine of [`study`].
fn machine(changes: &[(&str, &str)], errors: &str) -> MachineSettings {
    study(changes, errors).machine
}

/// Pseudo-random numbers between -1 and 1 (Knuth's linear congruential generator, upper bits).
struct Draws(u64);

impl Draws {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

#[track_caller]
fn close(found: f64, right: f64, within: f64, what: &str) {
    assert!((found - right).abs() <= within, "{what}: {found}, not {right} within {within}");
}
