//! The spindle's motion from files of turns: three methods, and files that cannot be right.

use std::f64::consts::TAU;

use crate::identification::spindle_readings::{SpindleMethod, SpindleSet, spindle};
use crate::inside::machine::close;
use crate::machine::ErrorName;
use crate::machine::conditions::Conditions;

const N: usize = 60;

fn motion_um(i: f64) -> f64 {
    0.4 * (2.0 * TAU * i / N as f64).cos() + 0.2 * (3.0 * TAU * i / N as f64 + 1.0).cos()
}

fn form_um(i: f64) -> f64 {
    (3.0 * TAU * i / N as f64 + 0.3).cos() + 0.5 * (5.0 * TAU * i / N as f64).cos()
}

/// A file of turns; a value by step and angle.
fn text(steps: usize, value: impl Fn(usize, f64) -> f64) -> String {
    let mut text = "angle_deg,step,value_um\n".to_owned();
    for (step, i) in (0..steps).flat_map(|step| (0..N).map(move |i| (step, i))) {
        text += &format!("{},{step},{:.12}\n", 360.0 * i as f64 / N as f64, value(step, i as f64));
    }
    text
}

fn set(method: SpindleMethod) -> SpindleSet {
    SpindleSet { method, file: "turns.csv".to_owned(), u_um: 0.1 }
}

#[test]
fn three_methods_separate_the_motion() {
    let reversal = text(2, |step, i| form_um(i) + if step == 0 { motion_um(i) } else { -motion_um(i) });
    let steps = text(4, |step, i| form_um(i + step as f64 * N as f64 / 4.0) + motion_um(i));
    // odd lobes alone reach the midline, and come with the other sign half a turn on
    let half = N as f64 / 2.0;
    let chucked = text(2, |step, i| motion_um(i) + form_um(i + step as f64 * half));
    for (method, text, share) in [
        (SpindleMethod::Reversal, reversal, 2.0_f64),
        (SpindleMethod::MultiStep, steps, 4.0),
        (SpindleMethod::Rechucked, chucked, 2.0),
    ] {
        let found = spindle(&set(method), text.as_bytes(), "spindle[0]", "turns.csv").unwrap();
        for (i, (motion, form)) in found.motion_um.iter().zip(&found.form_um).enumerate() {
            close(*motion, motion_um(i as f64), 1e-11, &format!("{method:?} motion"));
            close(*form, form_um(i as f64), 1e-11, &format!("{method:?} form"));
        }
        close(found.u_um, 0.1 / share.sqrt(), 1e-15, "u");
        let file = super::identified(&super::whole(0.1), "", 1).file.with_spindle(found).unwrap();
        let state = Conditions { c_deg: 30.0, ..Conditions::default() };
        let exc = 1e3 * file.machine.motion().unwrap().value(ErrorName::Exc, [0.0; 2], &state);
        close(exc, motion_um(5.0), 1e-9, "EXC of the table");
        assert!(!file.taken_as_zero.contains(&"EXC".to_owned()));
    }
}

#[test]
fn turns_that_cannot_be_right_are_named() {
    let good = text(2, |_, i| motion_um(i));
    for (text, method, words) in [
        (good.replace("value_um", "value"), SpindleMethod::Reversal, "no column value_um"),
        (good.replacen("6,0,", "7,0,", 1), SpindleMethod::Reversal, "angle 7 where 6 is due"),
        (good.replacen("6,1,", "nan,1,", 1), SpindleMethod::Reversal, "angle_deg 'nan'"),
        (text(1, |_, i| i), SpindleMethod::Rechucked, "1 steps: must be two steps"),
        (text(3, |_, i| i), SpindleMethod::Reversal, "3 steps: must be two steps"),
        (text(7, |_, i| i), SpindleMethod::MultiStep, "which 7 steps must divide"),
        (text(2, |_, i| 1e3 + i), SpindleMethod::Reversal, "was it read in nm?"),
        (good.replacen("0,1,", "0,5,", 1), SpindleMethod::Reversal, "step '5'"),
        (good.lines().take(100).collect::<Vec<_>>().join("\n"), SpindleMethod::Reversal, "step 1: 39 angles"),
    ] {
        let error =
            spindle(&set(method), text.as_bytes(), "spindle[0]", "turns.csv").err().unwrap().to_string();
        assert!(error.contains("spindle[0].file") && error.contains("turns.csv"), "{error}");
        assert!(error.contains(words), "'{words}' is missing in: {error}");
    }
}
