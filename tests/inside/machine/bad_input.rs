//! What no machine can be is refused with its key and what would be right.

use super::study;
use crate::machine::table_file::read_columns;
use crate::studies::machine::MachineStudyError;

#[track_caller]
fn refused(changes: &[(&str, &str)], errors: &str, key: &str, words: &[&str]) {
    let error = study(changes, errors).run().expect_err(key);
    let MachineStudyError::Setting(error) = error else { panic!("{error}") };
    assert_eq!(error.key, key, "{error}");
    let text = error.to_string();
    for word in words {
        assert!(text.contains(word), "'{word}' is missing in: {text}");
    }
}

#[test]
fn tables_that_leave_the_travel_or_are_out_of_order() {
    let table = |positions: &str, values: &str, more: &str| {
        format!("[machine.errors.exz.table]\nposition_mm = {positions}\nvalue_um = {values}\n{more}")
    };
    let key = "machine.errors.exz.table.position_mm";
    refused(
        &[],
        &table("[0, 50, 90]", "[0, 1, 2]", ""),
        key,
        &["0 to 90 mm", "from 0 to 100 mm", "shorten the travel"],
    );
    refused(
        &[],
        &table("[0, 50, 40, 100]", "[0, 1, 2, 3]", ""),
        &format!("{key}[2]"),
        &["40", "above 50", "ascend"],
    );
    refused(&[], &table("[0, 50, 50, 100]", "[0, 1, 2, 3]", ""), &format!("{key}[2]"), &["stand once each"]);
    let mixed = table("[0, 50, 100, 100, 50, 0]", "[0, 1, 2, 3, 2, 1]", "");
    refused(&[], &mixed, &format!("{key}[3]"), &["way back", "backward_um"]);
    let value = "machine.errors.exz.table.value_um";
    refused(&[], &table("[0, 100]", "[0]", ""), value, &["1 values", "one a position, 2"]);
    refused(&[], &table("[0]", "[0]", ""), key, &["at least 2"]);
    let twice = format!(
        "[machine.errors.exz]\nreversal_um = 1.0\n{}",
        table("[0, 100]", "[0, 1]", "backward_um = [0, 1]\n")
    );
    refused(&[], &twice, "machine.errors.exz.reversal_um", &["both directions"]);
}

#[test]
fn a_spindle_table_with_a_gap() {
    let table = |angles: &str| {
        let count = angles.split(',').count();
        format!("[machine.errors.exc.table]\nangle_deg = {angles}\nvalue_um = {:?}\n", vec![0.1; count])
    };
    let key = "machine.errors.exc.table.angle_deg";
    refused(&[], &table("[0, 90, 180]"), key, &["a gap of 180 degrees", "at most 90"]);
    refused(&[], &table("[0, 90, 180, 270, 360]"), key, &["less than 360"]);
}

#[test]
fn errors_of_another_unit() {
    for (errors, key, words) in [
        (
            "exz]\nfourier = [{ wavelength_mm = 10.0, amplitude_um = 2500.0 }]",
            "exz.fourier[0].amplitude_um",
            ["2500", "in nm?"],
        ),
        (
            "ebz]\npolynomial = { coefficients_urad = [0.0, 5000.0] }",
            "ebz.polynomial.coefficients_urad[1]",
            ["5000", "in nrad?"],
        ),
        (
            "ezz.table]\nposition_mm = [0, 100]\nvalue_um = [0, 4000]",
            "ezz.table.value_um[1]",
            ["4000", "in nm?"],
        ),
        ("exx]\nreversal_um = -1500.0", "exx.reversal_um", ["-1500", "thousand times"]),
        ("ezx]\ndrift = { warm_up_um = 2.0 }", "ezx.drift.time_constant_min", ["above 0", "warm_up_um"]),
        (
            "exc]\nfourier = [{ order = 0, amplitude_um = 0.1 }]",
            "exc.fourier[0].order",
            ["1", "waves a turn"],
        ),
    ] {
        refused(&[], &format!("[machine.errors.{errors}\n"), &format!("machine.errors.{key}"), &words);
    }
    let tilted = [("x_travel_mm", "b0c_urad = 20000.0\nx_travel_mm")];
    refused(&tilted, "", "machine.b0c_urad", &["20000", "in nrad?"]);
}

#[test]
fn levers_and_travels_that_do_not_close() {
    let tool = [("tool_mm = [110.0, 90.0, 70.0]", "tool_mm = [110000.0, 90.0, 70.0]")];
    refused(&tool, "", "machine.tool_mm[0]", &["110000", "in µm?"]);
    let off = [("head_mm = [60.0,", "head_mm = [-60.0,")];
    refused(&off, "", "machine.head_mm[0]", &["-60", "170 mm", "leaves the travel"]);
    let high = [("head_mm = [60.0, 90.0,", "head_mm = [60.0, 95.0,")];
    refused(&high, "", "machine.head_mm[1]", &["95", "height of the axis"]);
    let turned = [("z_travel_mm = [0.0, 100.0]", "z_travel_mm = [100.0, 0.0]")];
    refused(&turned, "", "machine.z_travel_mm", &["the first below the second"]);
    let thick = [("diameter_mm = 25.0", "diameter_mm = 250.0")];
    refused(&thick, "", "part.diameter_mm", &["250", "machine.x_travel_mm"]);
    let twin = "[[heads]]\nname = \"a\"\npupil_mm = inf\n".repeat(2);
    refused(&[], &twin, "heads[1].name", &["a", "another name"]);
    refused(&[], "[[heads]]\nname = \"a\"\npupil_mm = 20.0\n", "heads[0].pupil_mm", &["above 25", "inf"]);
    refused(&[], "[spiral]\npitch_mm = 20.0\n", "spiral.pitch_mm", &["20", "a third of the radius"]);
    refused(&[], "[spiral]\nz_mm = 120.0\n", "spiral.z_mm", &["120", "machine.z_travel_mm"]);
    refused(&[], "[spiral]\npoints_per_turn = 2\n", "spiral.points_per_turn", &["between 3 and 360"]);
    let missing = toml::from_str::<crate::studies::machine::MachineStudyConfig>(
        &super::MACHINE.replace("carriage_mm = [40.0, 80.0, 120.0]\n", ""),
    );
    assert!(missing.is_err_and(|e| e.to_string().contains("carriage_mm")));
}

#[test]
fn files_of_tables() {
    let names = ["position_mm", "value_um", "backward_um"].map(str::to_owned);
    let read = |text: &str| read_columns(text.as_bytes(), "k", &names);
    let found = read("# measured\nposition_mm, note, value_um\n0,a,1.5\n10,b,-2\n").unwrap();
    assert_eq!((found.position, found.forward), (vec![0.0, 10.0], vec![1.5, -2.0]));
    assert!(found.backward.is_empty());
    let both = read("position_mm,value_um,backward_um\n0,1,2\n").unwrap();
    assert_eq!(both.backward, [2.0]);
    for (text, words) in [
        ("position_mm,value_urad\n0,1\n", ["value_um", "value_urad"]),
        ("position_mm,value_um\n0,1\n5,\n", ["line 3", "finite"]),
        ("position_mm,value_um\n0,1\n5,1,2\n", ["line", "3"]),
    ] {
        let error = read(text).expect_err(text).to_string();
        words.iter().for_each(|word| assert!(error.contains(word), "'{word}' is missing in: {error}"));
    }
}
