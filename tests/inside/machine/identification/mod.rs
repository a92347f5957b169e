//! Identification of a machine's errors from readings: recovery of a drawn truth, what cannot be
//! separated, the report of ISO 230-2, refusals.

mod compensation;
mod head_place;
mod iso230_2;
mod recovery;
mod refusals;
mod separation;
mod spindle;

use crate::identification::settings::IdentificationConfig;
use crate::identification::{CheckedSet, Identification, checked_set, identify};
use crate::machine::{Conditions, ErrorName, MachineSettings};
use crate::setting::SettingError;
use crate::studies::machine_readings::SimulatedMachine;

/// A lathe with a carriage: geometry without errors.
const GEOMETRY: &str = r#"
chain = "carriage"
tool_mm = [60.0, 120.0, -20.0]
head_mm = [60.0, 119.95, 20.0]
head_on = "x_carrier"
carriage_mm = [0.0, 250.0, -80.0]
tip_above_axis_mm = 0.05
x_travel_mm = [-30.0, 60.0]
z_travel_mm = [-60.0, 140.0]
"#;

/// Its errors.
const TRUTH: &str = r#"
b0c_urad = -60.0
b0x_urad = 30.0
[errors.exx]
polynomial = { coefficients_um = [0.0, 2.0, 0.5] }
[errors.ezx]
fourier = [{ wavelength_mm = 60.0, amplitude_um = 0.6, phase_deg = 40.0 }]
[errors.ebx]
polynomial = { coefficients_urad = [0.0, 4.0, 3.0] }
[errors.exz]
fourier = [{ wavelength_mm = 120.0, amplitude_um = 2.0, phase_deg = 30.0 }]
[errors.ezz]
polynomial = { coefficients_um = [0.0, 3.0, 1.0] }
reversal_um = 1.5
[errors.ebz]
polynomial = { coefficients_urad = [0.0, 10.0, 6.0] }
"#;

/// What is sought, and every kind of reading that holds it.
const SOUGHT: &str = r#"
name = "lathe"
head = "telecentric"
identify = ["exx", "ezx", "ebx", "exz", "ezz", "ebz", "b0c", "b0x"]
"#;

const READINGS: &str = r#"
[[readings]]
instrument = "laser"
line_mm = [60.0, 120.0, -20.0]
u_um = U
u_urad = U
plan = { from_mm = -28.0, to_mm = 58.0, positions = 23, quantities = ["exx", "ebx"] }
[[readings]]
instrument = "laser"
line_mm = [0.0, 250.0, -80.0]
u_um = U
u_urad = U
plan = { from_mm = -60.0, to_mm = 140.0, positions = 26, runs = 2, both_directions = true, quantities = ["ezz", "ebz"] }
[[readings]]
instrument = "cylinder"
radius_mm = 12.5
u_um = U
plan = { from_mm = -60.0, to_mm = 140.0, positions = 26, quantities = ["radius"] }
[[readings]]
instrument = "face"
face_z_mm = 100.0
u_um = U
plan = { from_mm = -28.0, to_mm = 58.0, positions = 23, quantities = ["height"] }
"#;

fn config(text: &str) -> IdentificationConfig {
    let mut config: IdentificationConfig = toml::from_str(text).unwrap();
    config.simulate = Some(toml::from_str("machine = \"truth.toml\"").unwrap());
    config
}

/// The config of all readings, of a standard uncertainty in µm and µrad.
fn whole(u: f64) -> IdentificationConfig {
    let readings = READINGS.replace("= U", &format!("= {u}"));
    config(&format!("{SOUGHT}{readings}[machine]{GEOMETRY}"))
}

fn truth(errors: &str) -> MachineSettings {
    toml::from_str(&format!("{GEOMETRY}{errors}")).unwrap()
}

/// The sets of a config, simulated on a machine.
fn sets(config: &IdentificationConfig, truth: &MachineSettings, seed: u64) -> Vec<CheckedSet> {
    let machine = SimulatedMachine::new(truth.clone(), 20.0, seed).unwrap();
    let set = |k: usize| {
        let text = machine.text(&config.readings[k], k).unwrap();
        checked_set(config, k, text.as_bytes(), "drawn.csv").unwrap()
    };
    (0..config.readings.len()).map(set).collect()
}

/// Slope of the line of least squares through an error over a range, µrad for µm.
fn slope_urad(machine: &MachineSettings, name: ErrorName, [from, to]: [f64; 2]) -> f64 {
    let motion = machine.motion().unwrap();
    let at = |k: u32| from + (to - from) * (f64::from(k) + 0.5) / 400.0;
    let middle = 0.5 * (from + to);
    let (mut product, mut square) = (0.0, 0.0);
    for p in (0..400).map(at) {
        product += (p - middle) * motion.value(name, [p, p], &Conditions::default());
        square += (p - middle) * (p - middle);
    }
    1e6 * product / square
}

fn identified(config: &IdentificationConfig, errors: &str, seed: u64) -> Identification {
    identify(config, &sets(config, &truth(errors), seed)).unwrap()
}

/// The refusal of a set whose file has this text.
fn refusal(config: &IdentificationConfig, k: usize, text: &str) -> SettingError {
    checked_set(config, k, text.as_bytes(), "my.csv").err().unwrap()
}
