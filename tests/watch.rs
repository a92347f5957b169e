//! `watch` from outside: the newest frame, one value a part, a reading that goes stale, the alarm,
//! Ctrl-C.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use std::process::Command;

use image::{GrayImage, Luma};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde_json::Value;

use crate::program::{said, shadowgauge, text};
use crate::streamed::{COLUMNS, ROWS, Running, is_measured, pgm, picture};

#[path = "support/program.rs"]
mod program;
#[path = "support/streamed.rs"]
mod streamed;

/// Light without a part.
fn empty(seed: u64) -> GrayImage {
    let mut random = Pcg64::seed_from_u64(seed);
    GrayImage::from_fn(COLUMNS, ROWS, |_, _| Luma([180 + random.random_range(0..5_u8)]))
}

/// The next line that is a frame's, and the events before it.
fn frame(running: &Running) -> (Value, Vec<Value>) {
    let mut events = Vec::new();
    loop {
        let line = running.json();
        if line["event"].is_null() {
            return (line, events);
        }
        events.push(line);
    }
}

fn event(running: &Running, name: &str) -> Value {
    std::iter::from_fn(|| Some(running.json())).find(|line| line["event"] == name).unwrap()
}

fn parsed(lines: &[String]) -> Vec<Value> {
    lines.iter().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn a_line_a_frame_one_value_a_part_and_counts_at_the_end() {
    let mut running = Running::of("watch", &["-", "--json", "--um-per-px", "10"]);
    let mut events = Vec::new();
    let parts = [false, true, true, true, true, false, false, true, true, true];
    for (number, has_part) in parts.into_iter().enumerate() {
        let image = if has_part { picture(number as u64) } else { empty(number as u64) };
        running.send(&pgm(&image));
        let (line, before) = frame(&running);
        events.extend(before);
        assert_eq!(
            (&line["sequence"], &line["lost"], &line["dropped"]),
            (&number.into(), &0.into(), &0.into())
        );
        assert_eq!((is_measured(&line), line["valid"].as_bool()), (has_part, Some(has_part)), "{line}");
        assert!(line["latency_ms"].as_f64().is_some_and(|ms| ms >= 0.0) && line["alarm"] == false, "{line}");
    }
    let (code, rest) = running.end();
    events.extend(parsed(&rest));
    let named = |name: &str| events.iter().filter(|e| e["event"] == name).cloned().collect::<Vec<_>>();
    let parts = named("part");
    let facts =
        |p: &Value| (p["part"].as_u64(), p["first"].as_u64(), p["last"].as_u64(), p["frames"].as_u64());
    let found: Vec<_> = parts.iter().map(facts).collect();
    assert_eq!(
        found,
        [(Some(1), Some(1), Some(4), Some(4)), (Some(2), Some(7), Some(9), Some(3))],
        "{events:?}"
    );
    assert!(parts.iter().all(|p| (p["diameter_mm"].as_f64().unwrap() - 0.361).abs() < 0.005), "{parts:?}");
    let end = &named("end")[0];
    assert_eq!(
        (&end["measured"], &end["dropped"], &end["parts"]),
        (&7.into(), &0.into(), &2.into()),
        "{end}"
    );
    assert_eq!(code, Some(0));
}

#[test]
fn a_value_that_is_proven_bad_raises_one_alarm_with_its_command() {
    let folder = tempfile::tempdir().unwrap();
    let note = folder.path().join("alarm.txt");
    let command = format!("echo \"$SHADOWGAUGE_ALARM\" >> {}", note.display());
    let arguments =
        ["-", "--json", "--um-per-px", "10", "--tolerance", "0.5 ±0.01", "--on-alarm", command.as_str()];
    let mut running = Running::of("watch", &arguments);
    for number in 0..3_u64 {
        running.send(&pgm(&picture(number)));
        let (line, events) = frame(&running);
        // Latched: said once, and true from then on.
        assert_eq!(line["judgement"], "LL", "{line}");
        assert_eq!(
            (line["alarm"].as_bool(), events.len()),
            (Some(true), usize::from(number == 0)),
            "{events:?}"
        );
    }
    let (code, rest) = running.end();
    assert_eq!((code, rest.len()), (Some(1), 2), "{rest:?}");
    if cfg!(unix) {
        let noted = std::fs::read_to_string(note).unwrap();
        assert!(noted.lines().count() == 1 && noted.contains("LL"), "{noted}");
    }
}

#[test]
fn a_source_that_is_still_reads_invalid_not_the_last_value() {
    let arguments = ["-", "--json", "--stale-s", "0.3", "--idle-s", "2"];
    let mut running = Running::of("watch", &arguments);
    running.send(&pgm(&picture(1)));
    assert!(is_measured(&frame(&running).0));
    let invalid = event(&running, "invalid");
    assert_eq!(invalid["reason"], "stale", "{invalid}");
    // Stdin stays open: the time without a frame ends it.
    let end = event(&running, "end");
    assert_eq!((&end["measured"], &end["parts"]), (&1.into(), &0.into()));
    assert_eq!(running.end().0, Some(0));
}

#[test]
fn every_frame_of_a_file_is_measured_and_a_cut_one_is_a_gap() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("frames.raw");
    let mut bytes: Vec<u8> = (0..20).flat_map(|seed| picture(seed).into_raw()).collect();
    bytes.truncate(bytes.len() - 10);
    std::fs::write(&file, bytes).unwrap();
    let (source, layout) = (format!("raw:{}", file.display()), format!("{COLUMNS}x{ROWS}:mono8"));
    let output = shadowgauge(["watch", &source, "--raw", &layout, "--json"]);
    let lines: Vec<String> = text(&output.stdout).lines().map(str::to_owned).collect();
    let lines = parsed(&lines);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert_eq!(lines.iter().filter(|line| line["valid"] == true).count(), 19);
    let gap = lines.iter().find(|line| line["event"] == "gap").unwrap();
    assert_eq!((&gap["first"], &gap["last"], &gap["incomplete"]), (&19.into(), &19.into(), &1.into()));
    assert!(gap["why"].as_str().is_some_and(|why| why.contains("bytes of")), "{gap}");
    let end = lines.last().unwrap();
    assert_eq!((&end["measured"], &end["incomplete"], &end["dropped"]), (&19.into(), &1.into(), &0.into()));
    let output = shadowgauge(["watch", &source, "--raw", &layout]);
    assert!(
        text(&output.stdout).contains("20 frames: 19 taken and 19 measured, 0 left out, 1 incomplete"),
        "{}",
        said(&output)
    );
}

#[test]
fn ctrl_c_ends_it_with_its_counts() {
    if cfg!(not(unix)) {
        println!("SKIPPED: no signals here");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("small.toml");
    std::fs::write(&config, include_str!("support/small_render_job.toml")).unwrap();
    let source = format!("sim:{}", config.display());
    let running = Running::of("watch", &[&source, "--json", "--um-per-px", "15"]);
    for _ in 0..3 {
        let (line, _) = frame(&running);
        assert_eq!(
            (&line["device_clock"], &line["angle_deg"]["from"]),
            (&"simulation".into(), &"simulated".into())
        );
    }
    let id = running.child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let (code, rest) = running.end();
    let end = parsed(&rest).pop().unwrap();
    assert!(code == Some(0) && end["event"] == "end" && end["measured"].as_u64() >= Some(3), "{end}");
}

#[test]
fn a_source_without_a_frame_that_can_be_measured_fails_with_the_reason() {
    let mut running = Running::of("watch", &["-", "--json"]);
    running.send(&pgm(&empty(1)));
    assert_eq!(frame(&running).0["valid"], false);
    assert_eq!(running.end().0, Some(3));
    let output = shadowgauge(["watch", "nowhere"]);
    assert!(output.status.code() == Some(3) && said(&output).contains("nowhere"), "{}", said(&output));
}
