//! The study over chains, functions and heads: closed forms of single errors.

use super::{close, study};
use crate::studies::machine::{MachineStudy, MachineStudyConfig};

fn run(changes: &[(&str, &str)], errors: &str) -> MachineStudy {
    study(changes, errors).run().unwrap()
}

/// Standard deviation of 51 equally spaced points over a range.
fn spread(range: f64) -> f64 {
    let n = 51.0_f64;
    range * ((n + 1.0) / (12.0 * (n - 1.0))).sqrt()
}

#[test]
fn the_map_holds_what_one_error_does() {
    let config = study(&[], "[machine.errors.ebz]\npolynomial = { coefficients_urad = [0.0, 5.0] }\n");
    let points = config.at(&[[30.0, 80.0], [-50.0, 0.0]]).unwrap();
    // e_x = -EBZ·(wz + z), e_z = EBZ·(wx + x); EBZ = 5·(z - 50)/50 µrad.
    for (point, urad) in points.iter().zip([3.0, -5.0]) {
        close(point.e_x_um, -1e-3 * urad * (120.0 + point.z_mm), 1e-5, "e_x");
        close(point.e_z_um, 1e-3 * urad * (40.0 + point.x_mm), 1e-5, "e_z");
        close(point.e_y_um, 0.0, 1e-9, "e_y");
        close(point.first_order.e_x_um, -1e-3 * urad * (120.0 + point.z_mm), 1e-12, "first order");
    }
    let error = config.at(&[[30.0, 101.0]]).expect_err("outside").to_string();
    assert!(error.contains("--at 30,101: z") && error.contains("0 to 100 mm"), "{error}");
}

#[test]
fn a_bilinear_error_is_in_no_sum_of_functions_of_one_axis() {
    let study = run(&[], "[machine.errors.ebz]\npolynomial = { coefficients_urad = [0.0, 5.0] }\n");
    // The interaction of EBZ(z)·x is (EBZ - mean)(x - mean).
    close(study.map.e_z.not_separable_um, spread(10.0) * spread(150.0) * 1e-3, 1e-6, "EBZ·x");
    close(study.map.e_x.not_separable_um, 0.0, 1e-6, "EBZ·(wz + z)");
    let sum = run(
        &[],
        "[machine.errors.exz]\npolynomial = { coefficients_um = [0.0, 0.0, 3.0] }\n[machine.errors.ebx]\npolynomial = { coefficients_urad = [0.0, 4.0] }\n",
    );
    close(sum.map.e_x.not_separable_um, 0.0, 1e-7, "a sum");
}

#[test]
fn the_budget_holds_each_error_alone() {
    let study = run(
        &[("x_travel_mm", "b0c_urad = 20.0\nx_travel_mm")],
        "[machine.errors.exz]\npolynomial = { coefficients_um = [0.0, 0.0, 3.0] }\n\
         [machine.errors.exc]\nfourier = [{ order = 2, amplitude_um = 0.1 }]\n",
    );
    let row = |name: &str| study.budget.rows.iter().find(|row| row.error == name).unwrap();
    let exz = row("EXZ");
    close(exz.size, 3.0, 1e-9, "EXZ");
    close(exz.e_x_um, 3.0, 1e-9, "EXZ along X");
    close(exz.cut_um, 6.0, 1e-6, "EXZ in the diameter");
    close(exz.e_z_um, 0.0, 1e-12, "EXZ along Z");
    let b0c = row("B0C");
    close(b0c.size, 20.0, 1e-9, "B0C");
    close(b0c.e_x_um, 2.0, 1e-9, "B0C over 100 mm of Z");
    close(b0c.e_z_um, 3.0, 1e-9, "B0C over 150 mm of X");
    close(row("EXC").cut_um, 0.4, 1e-6, "EXC over a turn in the diameter");
    close(study.budget.worst.e_x_um, 3.0 + 2.0 + 0.2, 1e-6, "worst");
    close(study.budget.root_sum_square.e_x_um, (9.0_f64 + 4.0 + 0.04).sqrt(), 1e-6, "root sum square");
    assert!(row("EYZ").e_y_um == 0.0 && study.budget.rows.len() == 21);
}

#[test]
fn a_probe_finds_its_own_cut_straight_and_a_two_sided_head_does_not() {
    // The paper's straightness on both sides of the axis: probe and tool on one slide.
    let study = run(
        &[("head_mm = [60.0, 90.0, 130.0]", "head_mm = [60.0, 90.0, 70.0]")],
        "[machine.errors.exz]\npolynomial = { coefficients_um = [0.0, 0.0, 0.13] }\n",
    );
    let reading = |name: &str| study.heads.readings.iter().find(|r| r.name == name).unwrap();
    let cut = reading("telecentric").cut_range_um;
    close(cut, 0.26, 1e-6, "cut");
    close(reading("probe, tool's side").indicated_range_um, 0.0, 1e-6, "the tool's side");
    close(reading("probe, opposite side").indicated_range_um, 0.52, 1e-6, "the opposite side");
    for head in ["telecentric", "entocentric"] {
        close(reading(head).indicated_range_um, cut, 1e-6, head);
        let midline = &reading(head).points;
        // The carriage moves the part by EXZ (chain T): the head sees it come by that much.
        let seen = midline.iter().map(|p| p.midline_um.unwrap());
        let (low, high) = seen.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
        close(high - low, 0.13, 1e-9, "midline");
    }
}

#[test]
fn what_a_part_hardly_feels_moves_an_entocentric_image() {
    let study = run(
        &[
            ("x_travel_mm", "tip_above_axis_mm = 0.05\nx_travel_mm"),
            ("head_mm = [60.0, 90.0,", "head_mm = [60.0, 89.95,"),
        ],
        "",
    );
    let of = |name: &str| study.heads.sensitivities.iter().find(|s| s.error == name).unwrap();
    let eyz = of("EYZ");
    close(eyz.cut_nm.abs(), 8.0, 0.1, "cut, EYZ");
    close(eyz.heads_nm[0].abs(), 0.54, 0.01, "telecentric, EYZ");
    close(eyz.heads_nm[1].abs(), 83.4, 0.2, "entocentric, EYZ");
    let exz = of("EXZ");
    close(exz.cut_nm, -2000.0, 0.1, "cut, EXZ");
    assert!(exz.heads_nm.iter().all(|nm| nm.abs() < 1e-3), "{exz:?}");
    close(exz.midline_nm, 1000.0, 1e-3, "midline, EXZ");
}

#[test]
fn heads_read_only_where_they_reach_what_was_cut() {
    // The head's point lies 60 mm ahead of the tool's: it reaches z from 60 mm.
    let study = run(&[], "");
    let head = study.heads.readings.iter().find(|r| r.name == "telecentric").unwrap();
    assert_eq!(head.points.first().map(|p| p.z_mm), Some(60.0));
    assert_eq!(head.points.len(), 21);
    let far = run(&[("130.0]", "230.0]")], "");
    assert!(far.heads.readings.iter().all(|r| r.name.starts_with("probe")));
    let short = run(&[("x_travel_mm = [-50.0,", "x_travel_mm = [0.0,")], "");
    assert!(short.heads.readings.iter().all(|r| r.name != "probe, opposite side"));
    assert!(short.form.len() == 3 && short.form.iter().all(|row| row.opposite_um.is_none()));
    let outside = run(
        &[("x_travel_mm = [-50.0,", "x_travel_mm = [5.0,"), ("head_mm = [60.0,", "head_mm = [90.0,")],
        "",
    );
    assert!(outside.form.iter().all(|row| !row.form.starts_with("flatness")));
}

#[test]
fn warming_up_is_shown_where_something_warms_up() {
    assert!(run(&[], "").warm_up.is_empty());
    let study = run(&[], "[machine.errors.exx]\ndrift = { warm_up_um = 2.0, time_constant_min = 30.0 }\n");
    let last = study.warm_up.last().unwrap();
    close(last.minutes, 120.0, 1e-9, "four time constants");
    close(last.cut_um, 4.0 * (1.0 - (-4.0_f64).exp()), 1e-6, "the diameter");
}

#[test]
fn the_presets_run() {
    for text in [
        include_str!("../../../configs/machine_001.toml"),
        include_str!("../../../configs/machine_carriage.toml"),
    ] {
        let config: MachineStudyConfig = toml::from_str(text).unwrap();
        let study = config.run().unwrap();
        assert!(study.map.e_x.range_um > 0.05 && study.heads.readings.len() >= 3, "{}", study.name);
        // Tens of µrad at levers of 600 mm: products of two angles are below 1e-9 times that.
        assert!(study.map.first_order_off_nm < 1.0, "{}", study.map.first_order_off_nm);
    }
}

/// The row of a form.
fn form<'a>(study: &'a MachineStudy, name: &str) -> &'a crate::studies::machine::FormRow {
    study.form.iter().find(|row| row.form.starts_with(name)).unwrap()
}

#[test]
fn the_part_has_the_form_of_the_slide_and_of_the_spindle() {
    let study = run(
        &[],
        "[machine.errors.exz]\npolynomial = { coefficients_um = [0.0, 0.0, 0.13] }\n\
         [machine.errors.exc]\nfourier = [{ order = 3, amplitude_um = 0.05 }]\n",
    );
    let straight = form(&study, "straightness");
    close(straight.minimum_zone_um, 0.13, 1e-6, "straightness");
    close(straight.opposite_um.unwrap(), 0.26, 1e-6, "straightness from the opposite side");
    let round = form(&study, "cylindricity");
    close(round.minimum_zone_um, 0.13 + 0.1, 1e-4, "parabola and three lobes");
    assert!(round.least_squares_um >= round.minimum_zone_um - 1e-9);
    close(round.probe_um, 0.0, 1e-5, "the tool's side");
    // Half a turn on, three lobes come with the other sign: out of the sum, while the parabola
    // doubles.
    close(round.opposite_um.unwrap(), 0.26, 1e-4, "the opposite side");
}

#[test]
fn a_face_shows_its_odd_part_on_the_opposite_side_alone() {
    let face = |phase: &str| {
        let errors = format!(
            "[machine.errors.ezx]\nfourier = [{{ wavelength_mm = 60.0, amplitude_um = 0.1, phase_deg = {phase} }}]\n"
        );
        let study = run(&[], &errors);
        let row = form(&study, "flatness");
        (row.minimum_zone_um, row.probe_um, row.opposite_um.unwrap())
    };
    let (even, same, opposite) = face("0.0");
    assert!(even > 0.05 && same < 1e-6 && opposite < 1e-6, "{even} {same} {opposite}");
    let (odd, same, opposite) = face("90.0");
    assert!(odd > 0.02 && same < 1e-6, "{odd} {same}");
    close(opposite, 2.0 * odd, 1e-6, "the odd part");
}

#[test]
fn a_small_part_has_a_spiral_too() {
    let study = run(&[("diameter_mm = 25.0", "diameter_mm = 1.2")], "");
    assert_eq!(form(&study, "flatness").points, 26);
}

#[test]
fn the_papers_spiral_hides_nine_and_eleven_lobes() {
    let changes = [("diameter_mm = 25.0", "diameter_mm = 97.0")];
    let study = run(&changes, "");
    assert_eq!(form(&study, "flatness").points, 481);
    let alias = |order: usize| study.aliases.iter().find(|a| a.order == order).unwrap();
    for order in [9, 11] {
        let a = alias(order);
        assert_eq!(a.reads_as, 1);
        assert!((0.095..=0.100001).contains(&a.true_um), "{a:?}");
        close(a.shown_um, 0.0, 1e-9, "nine or eleven lobes");
    }
    assert_eq!((alias(3).reads_as, alias(7).reads_as, alias(10).reads_as), (3, 3, 0));
    assert!(alias(3).shown_um > 0.08 && !alias(3).is_hidden());
    // Half the points a turn: at the phase where each falls on a zero nothing is left.
    assert!(alias(5).is_hidden() && alias(10).is_hidden() && !alias(1).is_hidden());
}

#[test]
fn separations_leave_what_they_cannot_separate() {
    assert!(run(&[], "").separation.is_empty());
    let study = run(
        &[],
        "[machine.errors.exc]\nfourier = [{ order = 3, amplitude_um = 0.05 }, { order = 4, amplitude_um = 0.02 }]\n",
    );
    let off = |method: &str| {
        let row = study.separation.iter().find(|row| row.method == method).unwrap();
        (row.motion_off_um, row.form_off_um)
    };
    let rms = |amplitude: f64| amplitude * 0.5_f64.sqrt();
    // The part holds the motion with its sign reversed: what stays of one spoils the other alike.
    for (method, left) in [
        ("reversal", 0.0),
        ("3 steps", rms(0.05)),
        ("4 steps", rms(0.02)),
        ("5 steps", 0.0),
        ("12 steps", 0.0),
        ("both edges, chucked again", 0.0),
    ] {
        close(off(method).0, left, 1e-6, method);
        close(off(method).1, left, 1e-6, method);
    }
}
