//! Readings corrected by where the machine carries the head: the correction against the head's own
//! response, the row of the budget, and what is said of a machine at another temperature.

use super::{close, machine};
use crate::config;
use crate::gauge::calibration::{Conditions, HeadPlace};
use crate::identification::head_geometry::{of_machine, temperature_consequence};
use crate::machine::Pose;
use crate::machine::response::{Part, TwoSided};

const RUN: &str = include_str!("../../../configs/machine_run.toml");

#[test]
fn the_correction_undoes_what_the_head_reads_less() {
    // an entocentric lens, pupil 300 mm before the axis: t = −1/ℓ
    let (pupil_mm, part) = (300.0, Part { diameter_mm: 25.0, taper: 0.0 });
    let head = TwoSided { pupil_mm, keystone_per_mm: 0.0, pair_mm: [0.0, 0.0] };
    for u_y_mm in [-8e-3, 1e-3, 20e-3] {
        let pose = Pose { shift_mm: [0.0, u_y_mm, 0.0].into(), turn_rad: [0.0; 3].into() };
        let read_mm = part.diameter_mm + head.read_mm(&part, &pose);
        let place = HeadPlace { axis_y_mm: -u_y_mm, ..HeadPlace::default() };
        let conditions = Conditions { machine: Some(place), ..Conditions::default() };
        let corrected = read_mm * (1.0 - conditions.axis_in_frame_mm() / pupil_mm);
        assert!((read_mm - part.diameter_mm).abs() > 50e-6 * u_y_mm.abs() / 1e-3);
        // the curvature of the perspective, (u_y/ℓ)² and R²/ℓ² of the effect
        close(corrected, part.diameter_mm, 5e-3 * (read_mm - part.diameter_mm).abs(), "corrected");
    }
}

#[test]
fn the_uncertainty_of_the_place_counts_by_the_telecentricity() {
    let place = HeadPlace { z_mm: 30.0, axis_y_mm: -2e-3, u_axis_y_mm: 0.5e-3, axial_mm: 0.0 };
    let conditions = Conditions { machine: Some(place), axis_y_mm: 0.1, ..Conditions::default() };
    close(conditions.axis_in_frame_mm(), 0.098, 1e-15, "the stated place and the machine's");
    // D/ℓ · u: 25/300 · .5 µm
    close(conditions.u_machine_mm(25.0, -1.0 / 300.0, 0.0), 25.0 / 300.0 * 0.5e-3, 1e-15, "u");
    // a lens of which only the uncertainty is known still has it
    assert!(conditions.u_machine_mm(25.0, 0.0, 1e-4) > 0.0);
    assert_eq!(Conditions::default().u_machine_mm(25.0, -1.0 / 300.0, 0.0), 0.0);
    let read: Conditions = serde_json::from_str(&serde_json::to_string(&conditions).unwrap()).unwrap();
    assert_eq!(read.machine, None, "it is of a frame and in no file");
}

#[test]
fn the_geometry_is_the_heads_pose_at_the_levers() {
    let errors = "[machine.errors.eyz]\npolynomial = { coefficients_um = [0.0, 0.0, 8.0] }\n";
    let settings =
        machine(&[("t_shaped", "carriage"), ("z_travel_mm", "a0c_urad = 40.0\nz_travel_mm")], errors);
    let geometry = of_machine(&settings).unwrap();
    // the head stands 60 mm beside the tool
    assert_eq!(geometry.range_mm(), (60.0, 160.0));
    for z_mm in [60.0, 83.0, 110.0, 160.0] {
        let s = (z_mm - 60.0 - 50.0) / 50.0;
        let u_y = 8e-3 * s * s + 40e-6 * z_mm;
        let place = geometry.at(z_mm).unwrap();
        // between the places, half a millimetre apart: 8 µm · (.5/50)²/4
        close(place.axis_y_mm, -u_y, 1e-6, &format!("z {z_mm}"));
        assert_eq!(place.u_axis_y_mm, 0.0);
    }
    assert_eq!(geometry.at(59.0), None);
}

#[test]
fn a_run_is_given_the_tables_place_and_not_the_machines() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let lathe = include_str!("../../../configs/machine/lathe.toml");
    std::fs::write(at("truth.toml"), lathe).unwrap();
    std::fs::write(at("table.toml"), lathe.replace("[0.0, 0.0, 8.0]", "[0.0, 0.0, 6.0]")).unwrap();
    let run = |changes: &str| {
        let table = format!("file = \"truth.toml\"\ntable = \"table.toml\"\n{changes}");
        let text = RUN.replace("file = \"machine/lathe.toml\"", &table);
        std::fs::write(at("run.toml"), text).unwrap();
        config::load(&at("run.toml"))
    };
    let job = run("correct_readings = true").unwrap();
    let place = job.loop_job().head_geometry.unwrap().at(30.0).unwrap();
    // EYZ of the table at Z = 30 − 40, A0C · z
    let s = (-10.0 - 30.0) / 90.0;
    close(place.axis_y_mm, -(6e-3 * s * s + 40e-6 * 30.0), 1e-6, "place");
    // the control's table of commands is another matter
    assert!(job.machine_rows(1).unwrap().iter().all(|row| row.compensated_um == 0.0));
    let again: crate::job::Job = toml::from_str(&config::resolved(&job).unwrap()).unwrap();
    assert_eq!(again, job);
    let refused = run("").unwrap_err().to_string();
    assert!(refused.contains("machine.table") && refused.contains("correct_readings"), "{refused}");
}

#[test]
fn another_temperature_is_said_with_its_figure() {
    // the longest lever is that of the head, |(60, 90, 130)| = 169 mm; 4 K
    let settings = machine(&[], "");
    let words = temperature_consequence(&settings, 20.0, 24.0).unwrap();
    let longest: f64 = [110.0_f64, 90.0, 70.0].iter().map(|v| v * v).sum::<f64>().sqrt();
    let longest = longest.max(60.0_f64.hypot(90.0).hypot(130.0));
    let growth = format!("{:.1} µm", 11.5e-3 * longest * 4.0);
    assert!(words.contains("24 °C") && words.contains("20 °C") && words.contains(&growth), "{words}");
    assert_eq!(temperature_consequence(&settings, 20.0, 20.2), None);
}
