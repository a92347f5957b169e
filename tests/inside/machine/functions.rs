//! An error as a function: waves, polynomial, table, reversal and drift against closed forms.

use super::{close, machine};
use crate::machine::conditions::Direction;
use crate::machine::{Conditions, ErrorName, Motion};

fn motion(errors: &str) -> Motion {
    machine(&[], errors).motion().unwrap()
}

fn exz(motion: &Motion, z: f64, state: &Conditions) -> f64 {
    1e3 * motion.value(ErrorName::Exz, [0.0, z], state)
}

#[test]
fn waves_polynomial_and_table_add_up() {
    let motion = motion(
        "[machine.errors.exz]\nfourier = [{ wavelength_mm = 40.0, amplitude_um = 2.0, phase_deg = 90.0 }]\n\
         polynomial = { coefficients_um = [1.0, -0.5, 0.25] }\n\
         table = { position_mm = [-10, 20, 120], value_um = [3, 6, -4] }\n",
    );
    for z in [0.0, 12.5, 40.0, 99.0] {
        let s = (z - 50.0) / 50.0;
        let table = if z < 20.0 { 3.0 + 0.1 * (z + 10.0) } else { 6.0 - 0.1 * (z - 20.0) };
        let wave = -2.0 * (std::f64::consts::TAU * z / 40.0).sin();
        let right = wave + 1.0 - 0.5 * s + 0.25 * s * s + table;
        close(exz(&motion, z, &Conditions::default()), right, 1e-12, &format!("at {z}"));
    }
}

#[test]
fn tables_of_uneven_steps_are_read_between_their_own_points() {
    let at = [0.0, 1.0, 3.0, 50.0, 51.0, 100.0];
    let values = [0.0, 5.0, -2.0, 1.0, 9.0, 4.0];
    let motion =
        motion(&format!("[machine.errors.exz.table]\nposition_mm = {at:?}\nvalue_um = {values:?}\n"));
    for k in 0..=400 {
        let z = 0.25 * f64::from(k);
        let j = (0..5).find(|j| z <= at[j + 1]).unwrap();
        let right = values[j] + (values[j + 1] - values[j]) * (z - at[j]) / (at[j + 1] - at[j]);
        close(exz(&motion, z, &Conditions::default()), right, 1e-12, &format!("at {z}"));
    }
}

#[test]
fn reversal_is_the_difference_of_the_directions() {
    let backward = Conditions { z_direction: Direction::Backward, ..Conditions::default() };
    let both = motion("[machine.errors.exz]\nreversal_um = 3.0\n");
    let columns = motion(
        "[machine.errors.exz.table]\nposition_mm = [0, 100]\nvalue_um = [2, 4]\nbackward_um = [-1, 1]\n",
    );
    for motion in [&both, &columns] {
        for z in [0.0, 30.0, 100.0] {
            let reversal = exz(motion, z, &Conditions::default()) - exz(motion, z, &backward);
            close(reversal, 3.0, 1e-12, &format!("at {z}"));
        }
    }
    let x_only = Conditions { x_direction: Direction::Backward, ..Conditions::default() };
    close(exz(&both, 0.0, &x_only), 1.5, 1e-12, "the direction of another axis");
}

#[test]
fn drift_follows_temperature_and_time() {
    let motion = motion(
        "[machine.errors.exz]\ndrift = { offset_um_per_k = 0.5, slope_um_per_m_k = 11.5, warm_up_um = 4.0, time_constant_min = 30.0 }\n",
    );
    let at = |temperature_c, minutes| Conditions { temperature_c, minutes, ..Conditions::default() };
    close(exz(&motion, 80.0, &at(20.0, 0.0)), 0.0, 0.0, "cold at 20 °C");
    close(exz(&motion, 80.0, &at(22.0, 0.0)), 2.0 * (0.5 + 0.92), 1e-12, "2 K");
    close(exz(&motion, 80.0, &at(20.0, 30.0)), 4.0 * (1.0 - (-1.0_f64).exp()), 1e-12, "a time constant");
    close(exz(&motion, 80.0, &at(20.0, 1e5)), 4.0, 1e-12, "warm");
}

#[test]
fn the_spindle_closes_its_turn() {
    let motion = motion(
        "[machine.errors.exc]\nfourier = [{ order = 3, amplitude_um = 0.1, phase_deg = 30.0 }]\n\
         [machine.errors.ebc.table]\nangle_deg = [20, 110, 200, 290]\nvalue_urad = [1, 2, 3, 4]\n",
    );
    let at = |name, c_deg| motion.value(name, [0.0; 2], &Conditions { c_deg, ..Conditions::default() });
    close(1e3 * at(ErrorName::Exc, 20.0), 0.1 * 90_f64.to_radians().cos(), 1e-12, "order 3");
    let tilt = |c| 1e6 * at(ErrorName::Ebc, c);
    close(tilt(65.0), 1.5, 1e-9, "between two points");
    close(tilt(335.0), 2.5, 1e-9, "across the end of the turn");
    close(tilt(0.0), 1.0 + 3.0 * 20.0 / 90.0, 1e-9, "before the first point");
    close(tilt(335.0 - 720.0), 2.5, 1e-9, "two turns back");
}

#[test]
fn names_follow_iso_230_1() {
    let words: Vec<String> =
        ErrorName::ALL.iter().map(|name| format!("{} {}", name.code(), name.meaning())).collect();
    for right in [
        "EXX positioning of X",
        "EZX straightness of X along Z",
        "EAX roll of X",
        "EBX yaw of X",
        "ECX pitch of X",
        "EZZ positioning of Z",
        "EAZ pitch of Z",
        "ECZ roll of Z",
        "EXC radial error motion of C along X",
        "EZC axial error motion of C",
        "EBC tilt error motion of C about Y",
        "ECC angular positioning of C",
        "B0X orientation of X about Y",
        "A0C orientation of C about X",
    ] {
        assert!(words.iter().any(|found| found == right), "{right} is not in {words:?}");
    }
    assert_eq!(ErrorName::ALL.iter().filter(|name| name.is_length()).count(), 9);
    assert!(ErrorName::ALL.iter().enumerate().all(|(k, name)| *name as usize == k));
}
