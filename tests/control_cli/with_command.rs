//! `study controllers --with-command`: programs of others, from outside the binary.

use std::path::Path;
use std::process::Command;

use crate::assert_refused;
use crate::program::{json, said, shadowgauge, text};

/// Three stations, two passes, frames of 120 x 160 px.
const JOB: &str = "
[part]
length_mm = 1.5
stock_diameter_mm = 1.3
nominal_diameter_mm = [1.15, 1.0]
station_mm = 0.5
[part.tolerance]
nominal_mm = 1.0
upper_mm = 0.02
lower_mm = -0.02
[scan]
fields = 1
angles = 2
[masters]
frames_each = 1
[[masters.pins]]
diameter_mm = 0.9
expanded_u_mm = 0.0001
[[masters.pins]]
diameter_mm = 1.1
expanded_u_mm = 0.0001
[camera]
columns = 120
rows = 160
pixel_um = 3.0
[optics]
magnification = 0.2
[process.disturbance]
drift_um_per_pass = 5.0
[control.pid]
kp = 0.8
ki = 0.1
kd = 0.0
[control.guards]
min_depth_mm = 0.01
";

fn job(folder: &Path) -> String {
    let path = folder.join("job.toml");
    std::fs::write(&path, JOB).expect("written");
    path.to_string_lossy().into_owned()
}

/// The Python script of the examples, as a command; none, with a notice, where no Python is.
fn script() -> Option<String> {
    if Command::new("python3").arg("--version").output().is_err() {
        println!("SKIPPED (no python3)");
        eprintln!("SKIPPED (no python3)");
        return None;
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/controller.py");
    Some(format!("python3 '{}' --kp 0.8 --ki 0.1", path.display()))
}

#[test]
fn a_python_script_with_the_gains_of_our_pid_turns_what_our_pid_turns() {
    let Some(command) = script() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let (job, out) = (job(folder.path()), folder.path().join("study"));
    let named = format!("twin={command}");
    let run = |more: &[&str]| {
        let study =
            ["study", "controllers", &job, "--shafts", "2", "--backend", "cpu", "--controllers", "pid"];
        let output = shadowgauge([&study[..], more].concat());
        assert!(output.status.success(), "{}", said(&output));
        output
    };
    let more =
        ["--with-command", &command, "--with-command", &named, "--json", "--out", &out.to_string_lossy()];
    let study = json(&run(&more));
    let names: Vec<&str> = study["controllers"]
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(|c| c["controller"].as_str())
        .collect();
    assert_eq!(names, ["none", "pid", "controller", "twin"]);
    assert_eq!(study["controllers"][2]["command"], command.as_str());
    assert!(study["controllers"][1].get("command").is_none());
    let runs = |name: &str| {
        let runs = study["runs"].as_array().expect("a list").iter().filter(|r| r["controller"] == name);
        runs.map(|r| [&r["seed"], &r["pass"], &r["measured_mm"], &r["true_mm"], &r["held"]])
            .collect::<Vec<_>>()
    };
    assert_eq!(runs("pid").len(), 4, "two shafts of two passes");
    assert_eq!(runs("controller"), runs("pid"));
    assert_eq!(runs("twin"), runs("pid"));
    assert_ne!(runs("none")[1][3], runs("pid")[1][3], "the second pass is corrected");
    let file = |name: &str| std::fs::read_to_string(out.join(name)).expect("a file of the study");
    assert_eq!(file("runs.csv").lines().filter(|l| l.starts_with("controller,1,")).count(), 2);
    for (name, words) in
        [("controllers.svg", &["controller", "twin"][..]), ("report.html", &["twin", "controller.py"])]
    {
        assert!(words.iter().all(|word| file(name).contains(word)), "{name}");
    }
    let table = text(&run(&["--with-command", &named]).stdout);
    assert!(table.contains("twin   pass 2"), "{table}");
}

#[test]
fn a_command_that_cannot_be_is_refused_before_anything_is_rendered() {
    let folder = tempfile::tempdir().expect("a folder");
    let job = job(folder.path());
    let refuse = |command: &str, words: &[&str]| {
        assert_refused(&["study", "controllers", &job, "--with-command", command], 2, words);
    };
    refuse("/nowhere/mine --kp 1", &["mine (/nowhere/mine --kp 1)", "cannot be started"]);
    refuse("mine=", &["names no program", "NAME=CMD"]);
    refuse("python3 'mine.py", &["without its partner"]);
    refuse("pid=true", &["\"pid\" is taken", "pid=true"]);
}

#[cfg(unix)]
#[test]
fn a_program_that_fails_ends_the_study_with_one_error() {
    let folder = tempfile::tempdir().expect("a folder");
    let job = job(folder.path());
    let fail = |command: &str, words: &[&str]| {
        let study =
            ["study", "controllers", &job, "--shafts", "1", "--backend", "cpu", "--controllers", "none"];
        let limited = ["--command-timeout-s", "1", "--with-command", command];
        assert_refused(&[&study[..], &limited].concat(), 3, words);
    };
    // It echoes what it is given.
    fail("echo=cat", &["controller echo (cat)", "line 1 of its output", "pass 1", "with 3 numbers"]);
    fail("sh -c 'echo away >&2; exit 7'", &["away", "ended before its reply to pass 1", "exit status: 7"]);
    fail("sh -c 'exec sleep 60'", &["no reply to pass 1", "within 1 s", "(--command"]);
    let short = "sh -c 'read a; read b; echo {\\\"offsets_mm\\\": [0]}; cat >/dev/null'";
    fail(short, &["has 1 offsets for 3 stations", "with 3 numbers"]);
}
