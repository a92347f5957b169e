//! What is identified against the truth that drew the readings.

use super::{TRUTH, config, identified, slope_urad, truth, whole};
use crate::identification::IdentifiedMachine;
use crate::identification::settings::ModelChoice;
use crate::inside::machine::close;
use crate::machine::conditions::{Conditions, Direction};
use crate::machine::{Chain, ErrorName, MachineSettings, Motion, Pose};

fn pose(machine: &MachineSettings, motion: &Motion, [x, z]: [f64; 2]) -> Pose {
    let state = Conditions { x_direction: Direction::Forward, ..Conditions::default() };
    let values = motion.values(x, z, &state);
    Chain { topology: machine.chain, values }.pose(&machine.tool(x, z))
}

/// Tool error, identified less true, µm along X and Z over the range, less its mean.
fn off_um(found: &IdentifiedMachine, truth: &MachineSettings) -> [Vec<f64>; 2] {
    let (own, true_motion) = (found.machine.motion().unwrap(), truth.motion().unwrap());
    let [x, z] = [found.machine.x_travel_mm, found.machine.z_travel_mm];
    let at = |[from, to]: [f64; 2], k: usize| from + (to - from) * k as f64 / 12.0;
    let mut off = [Vec::new(), Vec::new()];
    for (i, k) in (0..13).flat_map(|i| (0..13).map(move |k| (i, k))) {
        let place = [at(x, i), at(z, k)];
        let d = pose(&found.machine, &own, place).shift_mm - pose(truth, &true_motion, place).shift_mm;
        off[0].push(1e3 * d.x);
        off[1].push(1e3 * d.z);
    }
    off.map(|values| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        values.iter().map(|v| v - mean).collect()
    })
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

#[test]
fn every_error_comes_back_from_all_readings() {
    let found = identified(&whole(1e-3), TRUTH, 1);
    assert!(found.file.rank.inseparable.is_empty(), "{:#?}", found.file.rank);
    let [x, z] = off_um(&found.file, &truth(TRUTH));
    assert!(rms(&x) < 0.01 && rms(&z) < 0.01, "{} {}", rms(&x), rms(&z));
    assert_eq!(found.file.model, "structured");
    let of = |code: &str| found.file.errors.iter().find(|e| e.error == code).unwrap();
    // the slopes of EXZ and EZX are orientations (ISO 230-1): e_X = EXZ − B0C·z, e_Z = EZX − B0X·x
    let (z, x) = (found.file.range.z_mm, found.file.range.x_mm);
    let b0c = -60.0 - slope_urad(&truth(TRUTH), ErrorName::Exz, z);
    close(of("B0C").value[0], b0c, 0.2, "B0C");
    // and the mean of EBZ, 6·s² over the range, which acts on x as they do
    let b0x = 30.0 - slope_urad(&truth(TRUTH), ErrorName::Ezx, x) + of("B0C").value[0] + 60.0 + 2.0;
    close(of("B0X").value[0], b0x, 0.5, "B0X");
    let (forward, backward) = (&of("EZZ").value, &of("EZZ").backward);
    close(forward[100] - backward[100], 1.5, 0.01, "reversal");
    assert!(!found.file.taken_as_zero.contains(&"EXZ".to_owned()));
    assert!(found.file.taken_as_zero.contains(&"EYZ".to_owned()));
}

/// Signs of each error alone, in either chain: what is identified is what was drawn.
#[test]
fn each_error_alone_comes_back_with_its_sign() {
    for (chain, errors, code, wanted) in [
        ("carriage", "[errors.exx]\npolynomial = { coefficients_um = [0.0, 2.0] }", "EXX", 1.0),
        ("t_shaped", "[errors.ezz]\npolynomial = { coefficients_um = [0.0, 2.0] }", "EZZ", 1.0),
        ("carriage", "[errors.ezz]\npolynomial = { coefficients_um = [0.0, 2.0] }", "EZZ", 1.0),
        ("t_shaped", "[errors.ebz]\npolynomial = { coefficients_urad = [0.0, 5.0] }", "EBZ", 1.0),
        ("carriage", "[errors.ebx]\npolynomial = { coefficients_urad = [0.0, 5.0] }", "EBX", 1.0),
        ("t_shaped", "[errors.exz]\npolynomial = { coefficients_um = [0.0, 0.0, 2.0] }", "EXZ", 1.0),
        ("carriage", "[errors.ezx]\npolynomial = { coefficients_um = [0.0, 0.0, 2.0] }", "EZX", 1.0),
    ] {
        let mut config = whole(1e-3);
        config.model = ModelChoice::Structured;
        let mut machine = truth("");
        let with: MachineSettings = truth(errors);
        machine.errors = with.errors;
        if chain == "t_shaped" {
            machine.chain = crate::machine::topology::Topology::TShaped;
            config.machine.chain = machine.chain;
        }
        let sets = super::sets(&config, &machine, 4);
        let found = crate::identification::identify(&config, &sets).unwrap();
        let name = ErrorName::ALL.into_iter().find(|name| name.code() == code).unwrap();
        let own = machine.motion().unwrap();
        let error = found.file.errors.iter().find(|e| e.error == code).unwrap();
        let scale = if name.is_length() { 1e3 } else { 1e6 };
        let true_at = |p: f64| scale * own.value(name, [p, p], &Conditions::default());
        let count = error.position_mm.len();
        let [low, middle, high] = [0, count / 2, count - 1].map(|k| (error.position_mm[k], error.value[k]));
        // offsets and, of a straightness, slopes are conventions: the second difference, or the
        // rise
        let bends = |v: [f64; 3]| v[0] - 2.0 * v[1] + v[2];
        let rise = |v: [f64; 3]| v[2] - v[0];
        let (truth, own) =
            ([low, middle, high].map(|(p, _)| true_at(p)), [low, middle, high].map(|(_, v)| v));
        let (found, right) = if code == "EXZ" || code == "EZX" {
            (bends(own), bends(truth))
        } else {
            (rise(own), rise(truth))
        };
        assert!(right.abs() > 1.0, "{code}");
        close(found, wanted * right, 0.05, &format!("{chain} {code}"));
    }
}

/// The bilinear EBZ·x: no sum of a function of x and one of z holds it, the chain does.
#[test]
fn the_model_is_chosen_by_its_held_out_error_and_both_are_shown() {
    let two = format!(
        "{}{}[machine]{}",
        super::SOUGHT,
        super::READINGS
            .replace("= U", "= 0.01")
            .replace("face_z_mm = 100.0", "face_z_mm = 100.0\nread = \"elsewhere\"")
            + "[[readings]]\ninstrument = \"face\"\nface_z_mm = -50.0\nu_um = 0.01\nplan = { from_mm = -28.0, to_mm = 58.0, positions = 23, quantities = [\"height\"] }\n",
        super::GEOMETRY
    );
    let strong = TRUTH.replace("[0.0, 10.0, 6.0]", "[0.0, 40.0, 6.0]");
    let found = identified(&config(&two), &strong, 2);
    let held = |model: &str| {
        let row = found.file.models.iter().find(|row| row.model == model).unwrap();
        (row.held_out_um.unwrap(), row.is_chosen)
    };
    let ((chain, is_chain), (sums, is_sums)) = (held("structured"), held("splines"));
    assert!(is_chain && !is_sums && chain < 0.03 && sums > 5.0 * chain, "{chain} {sums}");
    let mut asked = config(&two);
    asked.model = ModelChoice::Splines;
    let asked = identified(&asked, &strong, 2);
    assert_eq!(asked.file.model, "splines");
    let [_, z] = off_um(&asked.file, &truth(&strong));
    let [_, by_chain] = off_um(&found.file, &truth(&strong));
    assert!(rms(&z) > 10.0 * rms(&by_chain), "{} {}", rms(&z), rms(&by_chain));
}

/// Stated uncertainties against the truth over many drawn machines.
#[test]
fn stated_uncertainties_hold_the_truth() {
    let (mut inside, mut count) = (0, 0);
    for seed in 0..6 {
        let mut config = whole(0.1);
        config.model = ModelChoice::Structured;
        let found = identified(&config, TRUTH, 10 + seed);
        let own = truth(TRUTH).motion().unwrap();
        for error in found.file.errors.iter().filter(|e| e.error == "EBZ" || e.error == "EBX") {
            let name = ErrorName::ALL.into_iter().find(|name| name.code() == error.error).unwrap();
            let state = Conditions::default();
            let (count_of, middle) = (error.value.len(), error.value.len() / 2);
            let true_at = |k: usize| 1e6 * own.value(name, [error.position_mm[k]; 2], &state);
            for k in (0..count_of).step_by(24) {
                let off = error.value[k] - error.value[middle] - true_at(k) + true_at(middle);
                // the difference of two values has at most the sum of their u
                inside += usize::from(off.abs() <= 2.0 * (error.u[k] + error.u[middle]));
                count += 1;
            }
        }
    }
    assert!(inside as f64 >= 0.93 * f64::from(count), "{inside} of {count}");
}

/// The uncertainty itself, without correlation: a straight line of angles at n positions.
#[test]
fn the_uncertainty_of_a_slope_is_that_of_a_line() {
    let text = format!(
        "name = \"a\"\nidentify = [\"eaz\"]\n[[readings]]\ninstrument = \"level\"\nu_urad = 1.0\nplan = {{ from_mm = -60.0, to_mm = 140.0, positions = 201, quantities = [\"eaz\"] }}\n[machine]{}",
        super::GEOMETRY
    );
    let errors = "[errors.eaz]\npolynomial = { coefficients_urad = [0.0, 20.0] }";
    let found = identified(&config(&text), errors, 3);
    let slope = &found.file.unknowns[0];
    assert_eq!(slope.name, "EAZ slope");
    // u²(b) = σ²/Σs², s from −1 to 1; smoothing leaves a little of the shape to it
    let square: f64 = (0..201).map(|k| (f64::from(k) / 100.0 - 1.0).powi(2)).sum();
    let wanted = found.file.birge_ratio.max(1.0) / square.sqrt();
    assert!(slope.u >= 0.95 * wanted && slope.u < 3.0 * wanted, "{} {wanted}", slope.u);
    close(slope.value, 20.0, 4.0 * slope.u, "slope");
    assert!(found.file.covariance[0][0] > 0.0 && found.file.covariance.len() == found.file.unknowns.len());
}
