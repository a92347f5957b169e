//! Mistakes that users make in a config: each is refused by exit code 2 with its place or key and
//! with what to write, and nothing is written.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

#[path = "support/program.rs"]
mod program;

use std::path::Path;

use program::{shadowgauge, text};
use tempfile::TempDir;

/// A text without blanks and the rulers of a terminal, which break long lines anywhere.
fn squeezed(text: &str) -> String {
    text.chars().filter(|c| !c.is_whitespace() && *c != '│').collect()
}

/// The refusal of a file's bytes by a command that takes it and writes into `out`.
fn refusal(command: &[&str], bytes: &[u8]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let (file, out) = (folder.path().join("my.toml"), folder.path().join("out.json"));
    std::fs::write(&file, bytes).unwrap();
    let place = |word: &&str| match *word {
        "FILE" => file.to_string_lossy().into_owned(),
        "OUT" => out.to_string_lossy().into_owned(),
        other => other.to_owned(),
    };
    let output = shadowgauge(command.iter().map(place));
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{}: {said}", String::from_utf8_lossy(bytes));
    assert!(output.stdout.is_empty() && !said.contains("panicked"), "{said}");
    assert!(said.contains("my.toml"), "the file is not named: {said}");
    assert_eq!(names(folder.path()), ["my.toml"], "something is written");
    said
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect()
}

const RENDER: [&str; 6] = ["render", "FILE", "--out", "OUT", "--backend", "cpu"];
const RUN: [&str; 6] = ["run", "FILE", "--out", "OUT", "--backend", "cpu"];

/// Refuses a text and looks for the words of place and remedy.
#[track_caller]
fn refused(command: &[&str], config: &str, words: &[&str]) {
    let said = refusal(command, config.as_bytes());
    for word in words {
        assert!(squeezed(&said).contains(&squeezed(word)), "{config}\n{word:?} is missing in: {said}");
    }
}

#[test]
fn keys_and_tables_that_do_not_exist() {
    refused(
        &RENDER,
        "[part]\nlength_cm = 2.0\n",
        &["my.toml:2:1", "part: unknown field `length_cm`", "did you mean `length_mm`"],
    );
    refused(
        &RENDER,
        "seed = 1\n[optik]\nmagnification = 0.2\n",
        &["my.toml:2:", "`optik`", "did you mean `[optics]`"],
    );
    refused(
        &RENDER,
        "[lens]\nmagnification = 0.2\n",
        &[
            "my.toml:1:",
            "unknown field `lens`",
            "did you mean `[optics]`; `lens` belongs to another file: calibration",
        ],
    );
    refused(
        &RENDER,
        "[camera]\nmagnification = 0.2\n",
        &["my.toml:2:1", "`magnification` stands in [optics]"],
    );
}

#[test]
fn two_tables_where_one_is_possible() {
    refused(
        &RENDER,
        "[optics.esf.gaussian]\nsigma_px = 1.2\n[optics.esf.measured]\nfile = \"edge.csv\"\n",
        &[
            "my.toml:3:",
            "optics.esf: 2 tables",
            "`[optics.esf.gaussian]` and `[optics.esf.measured]`",
            "keep one of them",
        ],
    );
    refused(
        &RENDER,
        "[optics.esf.gaussian]\nsigma_px = 1.2\n[optics.esf.table]\nd_um = []\n",
        &["my.toml:3:", "2 tables", "`[optics.esf.table]`", "keep one of them"],
    );
}

#[test]
fn a_key_or_a_table_set_twice() {
    refused(
        &RENDER,
        "[part]\nlength_mm = 20.0\nlength_mm = 30.0\n",
        &["my.toml:3:1", "`length_mm` is set twice, first on line 2", "keep one"],
    );
    refused(
        &RENDER,
        "[part]\nlength_mm = 20.0\n[scan]\nfields = 1\n[part]\nstation_mm = 2.0\n",
        &["my.toml:5:", "`[part]` is set twice, first on line 1"],
    );
}

#[test]
fn values_of_another_type() {
    refused(
        &RENDER,
        "[part]\nlength_mm = \"20\"\n",
        &["my.toml:2:13", "part.length_mm: is a number", "write `length_mm = 20`"],
    );
    refused(
        &RENDER,
        "[part]\nnominal_diameter_mm = 10.0\n",
        &["my.toml:2:23", "part.nominal_diameter_mm: is a list", "write `nominal_diameter_mm = [10.0]`"],
    );
    refused(
        &RENDER,
        "[scan]\nangles = 4.0\n",
        &["my.toml:2:10", "scan.angles: is a whole number", "write `angles = 4`"],
    );
    refused(
        &RENDER,
        "[part]\nlength_mm = [20.0]\n",
        &["my.toml:2:13", "is one number, not a list", "write `length_mm = 20.0`"],
    );
    refused(&RENDER, "name = 5\n", &["my.toml:1:8", "name: is a text", "write `name = \"5\"`"]);
    refused(&RENDER, "optics = 5\n", &["my.toml:1:10", "optics: is a table", "write `[optics]`"]);
}

#[test]
fn numbers_out_of_range() {
    refused(
        &RENDER,
        "[part]\nlength_mm = -5.0\n",
        &["my.toml:2:13: part.length_mm", "-5", "a number above 0"],
    );
    refused(&RENDER, "[part]\nlength_mm = 0.0\n", &["part.length_mm", "a number above 0"]);
    refused(&RENDER, "[part]\nlength_mm = inf\n", &["part.length_mm", "a number above 0"]);
    refused(&RENDER, "[part]\nlength_mm = nan\n", &["part.length_mm", "nan is no number"]);
    refused(&RENDER, "[scan]\nangles = 0\n", &["my.toml:2:10: scan.angles", "between 1 and 100 000"]);
    refused(&RENDER, "[scan]\nangles = -2\n", &["my.toml:2:10", "scan.angles", "must be 0 or more"]);
    refused(
        &RENDER,
        "[optics.esf.gaussian]\nsigma_px = 500.0\n",
        &["optics.esf.gaussian.sigma_px", "500", "must lie in 0.25 to 20"],
    );
}

#[test]
fn words_that_do_not_exist() {
    refused(
        &RENDER,
        "[sensor]\nformat = \"mono18\"\n",
        &["my.toml:2:10", "sensor.format: unknown variant `mono18`", "`mono12`", "did you mean"],
    );
    refused(
        &RUN,
        "[control]\ncontroller = \"pidd\"\n",
        &["my.toml:2:14", "control.controller", "`pid`", "did you mean"],
    );
}

#[test]
fn units_and_decimal_commas_in_values() {
    refused(
        &RENDER,
        "[part]\nlength_mm = 25 mm\n",
        &["my.toml:2:", "`25 mm` is a number with its unit", "`length_mm = 25`"],
    );
    refused(
        &RENDER,
        "[part]\nlength_mm = \"25 mm\"\n",
        &["my.toml:2:13", "part.length_mm", "write `length_mm = 25`", "unit"],
    );
    refused(
        &RENDER,
        "[part]\nlength_mm = 25,4\n",
        &["my.toml:2:", "`25,4` has a decimal comma", "`length_mm = 25.4`"],
    );
    refused(&RENDER, "[part]\nlength_mm = \"25,4\"\n", &["my.toml:2:13", "write `length_mm = 25.4`"]);
    refused(
        &RENDER,
        "[sensor]\nformat = mono12\n",
        &["my.toml:2:", "without quotes", "`format = \"mono12\"`"],
    );
}

#[test]
fn required_keys_that_are_missing() {
    refused(
        &RUN,
        "[nc]\n",
        &["my.toml:1:", "nc: missing field `dialect`", "add `dialect = \"fanuc\"` in [nc]"],
    );
    let calibrate = ["calibrate", "FILE", "--out", "OUT", "--backend", "cpu"];
    refused(
        &calibrate,
        "optic_id = \"bench\"\ndate = \"2026-01-01\"\n[[masters]]\nname = \"a\"\ndiameter_mm = 10.0\nexpanded_u_mm = 0.001\npositions = []\n",
        &["my.toml:1:1", "unknown field `optic_id`", "did you mean `optics_id`"],
    );
    refused(
        &RUN,
        "[[masters.pins]]\ndiameter_mm = 10.0\n",
        &["my.toml:1:", "masters.pins[0]: missing field `expanded_u_mm`", "in [[masters.pins]]"],
    );
}

#[test]
fn one_bracket_or_two() {
    refused(
        &RENDER,
        "[[part]]\nlength_mm = 20.0\n",
        &["my.toml:1:", "part: is one table", "write `[part]` in single brackets"],
    );
    refused(
        &RUN,
        "[masters.pins]\ndiameter_mm = 10.0\nexpanded_u_mm = 0.001\n",
        &["my.toml:1:", "masters.pins: is a list of tables", "write `[[masters.pins]]` in double brackets"],
    );
}

#[test]
fn files_that_are_no_config() {
    refused(&RENDER, "", &["is empty", "shadowgauge new"]);
    refused(&RENDER, "# nothing but a comment\n", &["is empty", "shadowgauge new"]);
    refused(
        &RENDER,
        "{\"version\": 3, \"scale_mm_per_px\": 0.0153}\n",
        &["is a calibration made by `calibrate`", "shadowgauge measure"],
    );
    let wide: Vec<u8> = "[part]\nlength_mm = 20.0\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    let said = refusal(&RENDER, &[b"\xff\xfe".to_vec(), wide].concat());
    assert!(squeezed(&said).contains("isUTF-16") && squeezed(&said).contains("saveitasUTF-8"), "{said}");
    let said = refusal(&RENDER, b"name = \"\xb5\"\n");
    assert!(squeezed(&said).contains(&squeezed("line 1, column 9")), "{said}");
}

/// A byte order mark, as some editors put it before UTF-8, is no mistake.
#[test]
fn a_byte_order_mark_is_read() {
    let folder: TempDir = tempfile::tempdir().unwrap();
    let (file, out) = (folder.path().join("my.toml"), folder.path().join("out"));
    let config = [b"\xef\xbb\xbf", include_bytes!("support/small_render_job.toml").as_slice()].concat();
    std::fs::write(&file, config).unwrap();
    let words = ["render", &file.to_string_lossy(), "--out", &out.to_string_lossy(), "--backend", "cpu"];
    let output = shadowgauge(words);
    assert!(output.status.success(), "{}", text(&output.stderr));
}

#[test]
fn more_counts_than_the_bits_have() {
    refused(
        &RENDER,
        "[light]\nbright_counts = 5000.0\n[sensor]\nformat = \"mono12\"\n",
        &["light.bright_counts", "5000", "4095", "light.bright_photons"],
    );
}

/// What the user set is right, and a default does not fit it: the message names the default.
#[test]
fn defaults_that_do_not_fit() {
    refused(
        &RENDER,
        "[sensor]\nformat = \"mono8\"\n",
        &["light.bright_counts", "255", "leaves light.bright_counts at its default 3100"],
    );
    refused(
        &RENDER,
        "[part]\nlength_mm = 20.0\nstock_diameter_mm = 12.0\n",
        &["part.nominal_diameter_mm", "12 mm", "at its default"],
    );
    refused(
        &RUN,
        "[part]\nlength_mm = 20.0\nstock_diameter_mm = 12.0\nnominal_diameter_mm = [11.0]\n[camera]\nrows = 1024\n",
        &["masters.pins[0].diameter_mm", "does not fit the field", "at its default 24"],
    );
}

/// A picture needs neither masters nor falling diameters; a run does.
#[test]
fn render_needs_only_what_it_draws() {
    let folder = tempfile::tempdir().unwrap();
    let (file, out) = (folder.path().join("my.toml"), folder.path().join("out"));
    let config = "[part]\nlength_mm = 2.0\nnominal_diameter_mm = [1.0, 1.1]\n[scan]\nfields = 1\nangles = 1\n\
                  [camera]\ncolumns = 120\nrows = 100\npixel_um = 3.0\n[optics]\nmagnification = 0.2\n";
    std::fs::write(&file, config).unwrap();
    let command = |name: &str, out: &Path| {
        let words = [name, &file.to_string_lossy(), "--out", &out.to_string_lossy(), "--backend", "cpu"];
        shadowgauge(words)
    };
    let drawn = command("render", &out);
    assert!(drawn.status.success(), "{}", text(&drawn.stderr));
    let truth = std::fs::read_to_string(out.join("truth.csv")).unwrap();
    let row: Vec<f64> = truth.lines().nth(60).unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
    // The last diameter of the list is drawn: 1.1 mm of 15 µm a pixel, the lens off by its 1e-3.
    assert!(((row[3] - row[2]) / (1.1e3 / 15.0) - 1.0).abs() < 0.01, "{row:?}");
    let turned = command("run", &folder.path().join("run"));
    assert_eq!(turned.status.code(), Some(2));
    let said = squeezed(&text(&turned.stderr));
    assert!(said.contains("part.stock_diameter_mm") || said.contains("part.station_mm"), "{said}");
}
