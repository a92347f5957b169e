//! The slender shaft on a lathe with a straightness error of 5 µm and a spindle 20 µrad askew: the
//! midline of a test bar before the head, read without an artefact, fed forward into pass 1.

use super::identification_of;
use crate::config;
use crate::job::{Job, RunMachine};
use crate::machine::MachineSettings;

const SHAFT: &str = include_str!("../../../configs/slender_shaft.toml");

/// A flat bed whose X lies level: gravity bends nothing along it.
const GEOMETRY: &str = r#"
chain = "carriage"
tool_mm = [60.0, 120.0, -20.0]
head_mm = [60.0, 120.0, 20.0]
head_on = "x_carrier"
carriage_mm = [0.0, 250.0, -80.0]
x_travel_mm = [-1.0, 60.0]
z_travel_mm = [-60.0, 520.0]
"#;

/// The bar reaches 45 mm beyond the shaft: the head stands 40 mm beside the tool.
const READINGS: &str = r#"
name = "lathe"
head = "telecentric"
identify = ["exz", "b0c"]
model = "structured"
[simulate]
machine = "truth.toml"
[[readings]]
instrument = "midline"
u_um = 0.1
u_urad = 1.0
part = { diameter_mm = 60.0, length_mm = 550.0, held = "overhung", gravity_x = 0.0 }
plan = { from_mm = 0.0, to_mm = 545.0, positions = 110, quantities = ["midline", "slope"] }
"#;

fn truth(phase_deg: f64) -> MachineSettings {
    let errors = format!(
        "b0c_urad = 20.0\n[errors.exz]\nfourier = [{{ wavelength_mm = 400.0, amplitude_um = 2.5, phase_deg = {phase_deg:.1} }}]\n"
    );
    toml::from_str(&format!("{GEOMETRY}{errors}")).unwrap()
}

/// What the machine adds to the diameters of pass 1, less its mean, µm: largest amount.
fn worst_um(stated: &MachineSettings, table: Option<MachineSettings>) -> f64 {
    // the tool stands level with X on this lathe
    let text = SHAFT.replace("tool_deg = 135.0", "tool_deg = 0.0");
    let machine = RunMachine {
        compensate: table.is_some(),
        stated: Some(stated.clone()),
        table_stated: table,
        ..RunMachine::default()
    };
    let job = Job { machine: Some(machine), ..config::parse(&text, "job.toml").unwrap() };
    let left: Vec<f64> = job.machine_rows(1).unwrap().iter().map(|row| row.left_um).collect();
    assert_eq!(left.len(), 100);
    let mean = left.iter().sum::<f64>() / left.len() as f64;
    left.iter().map(|v| (v - mean).abs()).fold(0.0, f64::max)
}

#[test]
fn the_midline_takes_the_machine_out_of_the_first_pass() {
    for (seed, phase_deg) in [(1, 20.0), (2, 110.0), (3, 250.0)] {
        let truth = truth(phase_deg);
        let before = worst_um(&truth, None);
        let found = identification_of(&format!("{READINGS}[machine]{GEOMETRY}"), &truth, seed);
        let after = worst_um(&truth, Some(found.file.machine));
        println!("machine part of pass 1: {before:.2} µm, fed forward {after:.3} µm");
        // EXZ of ±2.5 µm and 20 µrad over 500 mm, both twice on the diameter
        assert!(before > 8.0, "{before}");
        assert!(after <= 0.3, "{after}");
    }
}
