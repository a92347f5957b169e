//! Manners of the program: examples in every help, completions, manual pages, schemas, starts for
//! files of one's own, warnings said once, and an interrupted run that is resumed.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

#[path = "support/program.rs"]
mod program;

use std::path::Path;

use clap::Command;
use program::{json, shadowgauge, text};

/// The commands that `--help` lists, each with its words.
fn listed(command: &Command, path: &str, into: &mut Vec<(String, Command)>) {
    into.push((path.to_owned(), command.clone()));
    for below in command.get_subcommands().filter(|c| !c.is_hide_set()) {
        listed(below, &format!("{path} {}", below.get_name()), into);
    }
}

fn commands() -> Vec<(String, Command)> {
    let mut all = Vec::new();
    listed(&shadowgauge::cli::command(), "shadowgauge", &mut all);
    all
}

/// The example lines of a command's help.
fn examples(command: &Command) -> Vec<String> {
    let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    let lines = help.strip_prefix("Examples:\n").unwrap_or_default().lines();
    lines.map(|line| line.trim().to_owned()).collect()
}

/// Words of an example, without where its output goes; text in double quotes is one word.
fn words(line: &str) -> Vec<String> {
    let line = line.split(" > ").next().unwrap_or_default();
    let parts = line.split('"').enumerate();
    let words = parts.flat_map(|(k, part)| match k % 2 {
        0 => part.split_whitespace().map(str::to_owned).collect(),
        _ => vec![part.to_owned()],
    });
    words.collect()
}

#[test]
fn every_help_ends_with_examples_that_parse() {
    let all = commands();
    assert!(all.len() > 25, "only {} commands found", all.len());
    for (path, command) in &all {
        let lines = examples(command);
        assert!(!lines.is_empty(), "{path} --help has no examples");
        for line in lines {
            assert!(line.starts_with(path.as_str()), "{path}: an example of another command: {line}");
            let parsed = shadowgauge::cli::command().try_get_matches_from(words(&line));
            assert!(parsed.is_ok(), "{line}: {}", parsed.unwrap_err());
        }
    }
    let printed = text(&shadowgauge(["render", "--help"]).stdout);
    assert!(printed.contains("Examples:\n  shadowgauge render"), "{printed}");
}

#[test]
fn completions_are_printed_for_every_shell() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let output = shadowgauge(["completions", shell]);
        let script = text(&output.stdout);
        assert!(output.status.success() && script.contains("shadowgauge"), "{shell}");
        assert!(script.contains("calibrate") && script.contains("um-per-px"), "{shell}");
    }
    assert_eq!(shadowgauge(["completions", "tcsh"]).status.code(), Some(2));
}

#[test]
fn manual_pages_are_printed_and_written() {
    let page = text(&shadowgauge(["man"]).stdout);
    assert!(page.contains(".TH shadowgauge 1") && page.contains("Examples:"), "{page}");
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("man");
    assert!(shadowgauge(["man", "--out", &out.to_string_lossy()]).status.success());
    for name in ["shadowgauge.1", "shadowgauge-run.1", "shadowgauge-study-parts.1"] {
        let page = std::fs::read_to_string(out.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(page.contains(".SH NAME"), "{name}: {page}");
    }
    assert!(!out.join("shadowgauge-reference.1").exists(), "a hidden command has a page");
}

#[test]
fn every_file_that_a_user_writes_has_a_schema() {
    let names = [
        "job",
        "calibration",
        "conditions",
        "machine",
        "optimize",
        "factor",
        "beam",
        "reproduce_003",
        "frames",
        "contour",
        "edge",
        "forces",
        "rings",
    ];
    for name in names {
        let schema = json(&shadowgauge(["schema", name]));
        assert!(schema["properties"].is_object() && schema["title"].is_string(), "{name}");
    }
    assert_eq!(shadowgauge(["schema"]).stdout, shadowgauge(["schema", "job"]).stdout);
    let unknown = shadowgauge(["schema", "jop"]);
    assert_eq!(unknown.status.code(), Some(2));
    assert!(text(&unknown.stderr).contains("machine"), "{}", text(&unknown.stderr));
}

/// A start as a file of `folder`.
fn start(folder: &Path, kind: &str) -> String {
    let output = shadowgauge(["new", kind]);
    assert!(output.status.success(), "{kind}: {}", text(&output.stderr));
    let path = folder.join(format!("{kind}.toml"));
    std::fs::write(&path, &output.stdout).unwrap();
    path.to_string_lossy().into_owned()
}

#[test]
fn starts_run_as_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    for kind in ["pin", "shaft", "stepped", "wire"] {
        let (file, out) = (start(folder.path(), kind), at(kind));
        let output = shadowgauge(["render", &file, "--out", &out, "--frames", "1", "--backend", "cpu"]);
        assert!(output.status.success(), "{kind}: {}", text(&output.stderr));
        assert!(Path::new(&out).join("frames/000000.png").exists(), "{kind}");
        assert!(output.stderr.is_empty(), "{kind}: {}", text(&output.stderr));
    }
    let (file, out) = (start(folder.path(), "calibrate"), at("bench.json"));
    let output = shadowgauge(["calibrate", &file, "--out", &out, "--backend", "cpu"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(shadowgauge(["new", "gear"]).status.code(), Some(2));
    let taken = shadowgauge(["new", "pin", "--out", &file]);
    assert_eq!(taken.status.code(), Some(2), "a file of the user's is replaced");
    let fresh = at("fresh.toml");
    assert!(shadowgauge(["new", "pin", "--out", &fresh]).status.success());
    assert_eq!(std::fs::read(&fresh).unwrap(), shadowgauge(["new", "pin"]).stdout);
    assert!(text(&shadowgauge(["new", "machine"]).stdout).starts_with("#:schema ./machine.schema.json\n"));
}

/// Warnings of many frames that say the same are said once, with their count; -v says all.
#[test]
fn a_warning_that_repeats_is_said_once() {
    let folder = tempfile::tempdir().unwrap();
    let grey = |name: &str, of: &dyn Fn(u32, u32) -> u8| {
        image::GrayImage::from_fn(320, 200, |x, y| image::Luma([of(x, y)]))
            .save(folder.path().join(name))
            .unwrap();
    };
    let soft = |d: f64| 30.0 + 170.0 / (1.0 + (-2.0 * d).exp());
    let shadow = |y: f64| if y < 100.0 { soft(60.2 - y) } else { soft(y - 140.3) };
    grey("a.png", &|x, y| (shadow(f64::from(y)) as u8).saturating_add((x * 7 % 5) as u8));
    for name in ["b.png", "c.png", "d.png"] {
        grey(name, &|_, _| 255);
    }
    let input = folder.path().to_string_lossy().into_owned();
    let said = |more: &[&str]| {
        let output = shadowgauge([&["measure", input.as_str()], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        text(&output.stderr)
    };
    let short = said(&[]);
    assert!(short.contains("frame b") && !short.contains("frame c"), "{short}");
    assert!(short.contains("2 times more (-v shows each)"), "{short}");
    let long = said(&["-v"]);
    let each = ["frame b", "frame c", "frame d"].iter().all(|name| long.contains(name));
    assert!(each && !long.contains("times more"), "{long}");
}

/// Ctrl-C ends a run with 130 and the command line that resumes it; the folder is taken up again.
#[cfg(unix)]
#[test]
fn an_interrupted_run_says_how_to_resume() {
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let words = ["run", "configs/slender_shaft.toml", "--backend", "cpu", "--no-reference", "--out"];
    let mut command = Command::new(program::path());
    command.args(words).arg(&out).current_dir(env!("CARGO_MANIFEST_DIR")).env("NO_COLOR", "1");
    let child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let deadline = Instant::now() + Duration::from_secs(10);
    while !out.join("run.toml").exists() && Instant::now() < deadline {
        std::thread::sleep(Duration::from_millis(5));
    }
    let signalled = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(signalled.success(), "the run has ended before");
    let output = child.wait_with_output().unwrap();
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(said.contains("The same command line resumes the run"), "{said}");
    assert!(said.contains("run configs/slender_shaft.toml --backend cpu --no-reference --out"), "{said}");
    assert!(out.join("run.toml").exists() && !out.join("report.html").exists());
}
