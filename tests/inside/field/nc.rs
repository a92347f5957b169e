//! Lathes: NC programs of whole runs, from outside.

use std::path::{Path, PathBuf};

use crate::inside::field::support::{collected, shadowgauge};

/// A short shaft in two passes with a small camera: runs in a second. Station length and direction
/// as given.
fn job(station_mm: f64, more: &str) -> String {
    format!(
        "name = \"short shaft\"\nseed = 7\n[part]\nlength_mm = 48.0\nstock_diameter_mm = 9.0\n\
         nominal_diameter_mm = [8.5, 8.0]\naim_mm = -0.005\nstation_mm = {station_mm}\n\
         [part.tolerance]\nnominal_mm = 8.0\nupper_mm = 0.0\nlower_mm = -0.009\n\
         [scan]\nfields = 4\nangles = 2\n[masters]\nframes_each = 1\n\
         [[masters.pins]]\ndiameter_mm = 7.0\nexpanded_u_mm = 0.0001\n\
         [[masters.pins]]\ndiameter_mm = 10.0\nexpanded_u_mm = 0.0001\n\
         [camera]\ncolumns = 320\nrows = 260\npixel_um = 10.0\n[optics]\nmagnification = 0.2\n\
         [control]\ncontroller = \"lsq\"\n[control.guards]\non_alarm = \"go_on\"\n{more}"
    )
}

fn run(folder: &Path, config: &Path) -> PathBuf {
    let out = folder.join("run");
    let arguments = ["--backend", "cpu", "--no-reference", "--out"].map(std::ffi::OsStr::new);
    let mut all = vec!["run".as_ref(), config.as_os_str()];
    all.extend(arguments);
    all.push(out.as_os_str());
    let output = shadowgauge(all);
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", String::from_utf8_lossy(&output.stderr));
    out
}

fn run_text(folder: &Path, text: &str) -> PathBuf {
    let config = folder.join("job.toml");
    std::fs::write(&config, text).expect("written");
    run(folder, &config)
}

/// Exit code, stdout and stderr of `nc RUN --dialect …`.
fn nc(run: &Path, options: &[&str]) -> (Option<i32>, String, String) {
    let mut all = vec!["nc".as_ref(), run.as_os_str()];
    all.extend(options.iter().map(std::ffi::OsStr::new));
    let output = shadowgauge(all);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    // the wrapped lines of a report as one
    let said = text(&output.stderr).replace("\n  │ ", " ");
    (output.status.code(), text(&output.stdout), said)
}

/// Moves of a program in short form: (in rapid, X, Z) after each block, read without macro
/// variables.
fn moves(program: &str) -> Vec<(bool, f64, f64)> {
    let (mut rapid, mut x, mut z) = (true, f64::NAN, f64::NAN);
    let mut all = Vec::new();
    for line in program.lines().filter(|l| !l.starts_with(['(', '#', 'o', '%', 'T', 'M'])) {
        let mut moved = false;
        for word in line.split_whitespace() {
            let value = || word[1..].parse::<f64>().ok();
            match (&word[..1], word) {
                ("X", _) => (x, moved) = (value().expect("a number"), true),
                ("Z", _) => (z, moved) = (value().expect("a number"), true),
                (_, "G00") => rapid = true,
                (_, "G01") => rapid = false,
                _ => {}
            }
        }
        if moved {
            all.push((rapid, x, z));
        }
    }
    all
}

/// No block in rapid below the stock over the part, and the part is cut from least_z_mm to beyond
/// its end face.
fn keeps_clear(program: &str, length: f64, stock: f64, nominal: f64) {
    let all = moves(program);
    for pair in all.windows(2) {
        let ((_, x0, z0), (rapid, x1, z1)) = (pair[0], pair[1]);
        let over = z0.min(z1) < length;
        assert!(!(rapid && over && x0.min(x1) < stock && (x1 < x0 || z0 != z1)), "{pair:?}\n{program}");
        assert!(!rapid || x0 == x1 || z0 == z1 || x0.is_nan() || z0.is_nan(), "{pair:?}");
    }
    let cut: Vec<f64> = all.iter().filter(|m| !m.0 && m.1 < nominal + 0.1).map(|m| m.2).collect();
    let (least, most) = cut.iter().fold((f64::MAX, f64::MIN), |(a, b), z| (a.min(*z), b.max(*z)));
    assert!(least <= 2.1 && most >= length, "cut from Z {least} to {most}");
}

#[test]
fn programs_of_a_run_keep_clear_in_both_directions() {
    for (station, direction) in [(4.0, "towards_chuck"), (16.0, "towards_tailstock")] {
        let folder = tempfile::tempdir().expect("a folder");
        let more = format!("[process.pass]\nfeed_direction = \"{direction}\"\n");
        let run = run_text(folder.path(), &job(station, &more));
        let (code, program, said) = nc(&run, &["--dialect", "linuxcnc"]);
        assert!(code == Some(0) && said.contains("uncut: Z 0 to 0.5 mm"), "{said}");
        keeps_clear(&program, 48.0, 8.5, 7.995);
        let cut: Vec<f64> = moves(&program).iter().filter(|m| !m.0 && m.1 < 8.2).map(|m| m.2).collect();
        assert_eq!(cut[0] < cut[cut.len() - 1], direction == "towards_tailstock");
        let (code, line, said) = nc(&run, &["--dialect", "linuxcnc", "--form", "macro"]);
        assert!(code == Some(0) && line.contains("X#812") && line.contains("STAYS UNCUT"), "{said}");
    }
}

#[test]
fn machine_data_and_tables_that_do_not_fit_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = run_text(folder.path(), &job(4.0, ""));
    let (code, text, said) = nc(&run, &["--dialect", "fanuc"]);
    assert!(code == Some(2) && text.is_empty() && said.contains("wear_x"), "{said}");
    let file = folder.path().join("machine.toml");
    let with = |machine: &str, dialect: &str| {
        std::fs::write(&file, machine).expect("written");
        nc(&run, &["--dialect", dialect, "--machine", file.to_str().expect("a name")])
    };
    let stated = "wear_x = \"diameter\"\ngeometry_offset = \"by_tool\"\nspindle = \"M04\"\n";
    for dialect in ["fanuc", "gsk"] {
        let (code, text, said) = with(stated, dialect);
        assert!(code == Some(0) && text.contains("M04"), "{said}");
        let change = text.find("G28 W0.").expect("to the reference point");
        assert!(change < text.find("\nT01").expect("the tool"), "{text}");
    }
    let (code, text, said) = with("tailstock = \"none\"\nlead_in_mm = 3.0\n", "linuxcnc");
    assert!(code == Some(0) && text.contains("Z51.\n"), "{text}{said}");
    let (code, _, said) = with("[chuck]\ndiameter_mm = -1.0\n", "linuxcnc");
    assert!(code == Some(2) && said.contains("chuck.diameter_mm") && said.contains("machine.toml"), "{said}");
    let (code, _, said) = with("wear_x = \"radios\"\n", "linuxcnc");
    assert!(code == Some(2) && said.contains("radios"), "{said}");
    let (code, text, said) =
        with("[[steady_rests]]\nfrom_z_mm = 20.0\nto_z_mm = 30.0\ndiameter_mm = 50.0\n", "linuxcnc");
    assert!(
        code == Some(2) && text.is_empty() && said.contains("steady rest") && said.contains("block"),
        "{said}"
    );
    tables_are_refused(&run);
}

fn tables_are_refused(run: &Path) {
    let table = run.join("offsets.csv");
    let whole = std::fs::read_to_string(&table).expect("offsets.csv");
    let rows: Vec<&str> = whole.lines().collect();
    let refused = |rows: &[&str], word: &str| {
        std::fs::write(&table, rows.join("\n") + "\n").expect("written");
        let (code, text, said) = nc(run, &["--dialect", "linuxcnc"]);
        assert!(code == Some(2) && text.is_empty() && said.contains(word), "{said}");
    };
    refused(&rows[..rows.len() - 1], "has 11 rows, the part has 12 stations");
    let mut twice = rows.clone();
    twice[rows.len() - 1] = rows[rows.len() - 2];
    refused(&twice, "where the station at 46 mm is due");
    let other = rows[rows.len() - 1].replacen(",46.0,", ",47.0,", 1);
    let mut moved = rows.clone();
    moved[rows.len() - 1] = &other;
    refused(&moved, "z_mm = 47");
    std::fs::write(&table, whole).expect("written");
    let (code, _, said) = nc(run, &["--dialect", "linuxcnc"]);
    assert_eq!(code, Some(0), "{said}");
}

#[test]
fn the_collected_job_gives_programs_that_keep_clear() {
    let Some(config) = collected("nc/job.toml") else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let run = run(folder.path(), &config);
    let (code, program, said) = nc(&run, &["--dialect", "linuxcnc"]);
    assert_eq!(code, Some(0), "{said}");
    keeps_clear(&program, 60.0, 10.5, 9.9955);
    for dialect in ["fanuc", "gsk"] {
        let (code, text, said) = nc(&run, &["--dialect", dialect]);
        assert!(code == Some(2) && text.is_empty() && said.contains("wear_x"), "{said}");
    }
}

#[test]
fn the_schema_has_the_keys_of_the_machine() {
    let schema = String::from_utf8(shadowgauge(["schema"]).stdout).expect("text");
    for key in [
        "wear_x",
        "geometry_offset",
        "change_position",
        "jaws_to_z_mm",
        "quill_from_mm",
        "gauge_head",
        "by_offset",
    ] {
        assert!(schema.contains(&format!("\"{key}\"")), "{key}");
    }
}
