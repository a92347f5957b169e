//! `watch` from outside: the newest frame, one value a part, a reading that goes stale, the alarm,
//! Ctrl-C; a diameter that settles, temperatures, zeros, what is saved, the page of the setup.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

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

/// Sends frames of a part until one is as wanted; that one, and those before it.
fn until(running: &mut Running, wanted: impl Fn(&Value) -> bool) -> (Value, Vec<Value>) {
    let mut before = Vec::new();
    for seed in 0..20_000 {
        running.send(&pgm(&picture(seed)));
        let (line, _) = frame(running);
        if wanted(&line) {
            return (line, before);
        }
        before.push(line);
    }
    panic!("no frame as wanted: {:?}", before.last());
}

/// Host time, ns, so many seconds ago.
fn ago_ns(s: u64) -> u64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
    now.as_nanos() as u64 - s * 1_000_000_000
}

fn append(path: &Path, line: &str) {
    let before = fs::read_to_string(path).unwrap();
    fs::write(path, format!("{before}{line}\n")).unwrap();
}

#[test]
fn nothing_is_proven_until_a_part_has_settled_and_the_next_one_settles_by_itself() {
    let arguments = ["-", "--json", "--um-per-px", "10", "--tolerance", "0.361 ±0.05", "--settle-s", "2"];
    let mut running = Running::of("watch", &arguments);
    let (good, waiting) = until(&mut running, |line| line["settled"]["state"] == "agrees");
    assert_eq!((good["valid"].as_bool(), &good["judgement"]), (Some(true), &"GO".into()), "{good}");
    assert!(waiting.len() >= 3, "{waiting:?}");
    assert!(
        waiting.iter().all(|line| line["valid"] == false && line["judgement"].is_null()),
        "{:?}",
        waiting.last()
    );
    // The last frame of a part may show it leave, and does not count.
    running.send(&pgm(&picture(7)));
    assert_eq!(frame(&running).0["settled"]["state"], "agrees");
    for seed in 0..2 {
        running.send(&pgm(&empty(seed)));
        assert_eq!(frame(&running).0["valid"], false);
    }
    running.send(&pgm(&picture(1)));
    let (next, events) = frame(&running);
    let part = events.iter().find(|line| line["event"] == "part").unwrap();
    assert_eq!((&part["judgement"], part["settled"].as_bool()), (&"GO".into(), Some(true)), "{part}");
    assert_eq!(next["settled"]["state"], "waiting", "{next}");
    let (code, rest) = running.end();
    let parts: Vec<Value> = parsed(&rest).into_iter().filter(|line| line["event"] == "part").collect();
    assert!(parts.is_empty() && code == Some(0), "one frame is no part: {rest:?}");
}

#[test]
fn what_settling_temperatures_and_zeros_need_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let zeros = folder.path().join("zeros.csv").display().to_string();
    fs::write(&zeros, "time\n1\n").unwrap();
    for (arguments, word) in [
        (&["--settle-s", "2"][..], "--um-per-px"),
        (&["--temperature-cmd", "echo 20"], "--um-per-px"),
        (&["--um-per-px", "10", "--turning"], "--settle-s"),
        (&["--um-per-px", "10", "--temperature-max-age-s", "5"], "--temperatures"),
        (&["--um-per-px", "10", "--zero", &zeros], "--zero-interval-s"),
        (&["--um-per-px", "10", "--zero", &zeros, "--zero-interval-s", "60"], "no column t_ns"),
        (&["--um-per-px", "10", "--temperatures", "nowhere.csv"], "nowhere.csv"),
        (&["--save-frames", "3"], "--save"),
    ] {
        let output = shadowgauge([&["watch", "-"][..], arguments].concat());
        assert!(output.status.code() >= Some(2) && said(&output).contains(word), "{word}: {}", said(&output));
    }
    // A source without angles gives no turns.
    let mut running =
        Running::of("watch", &["-", "--json", "--um-per-px", "10", "--settle-s", "1", "--turning"]);
    running.send(&pgm(&picture(1)));
    let (line, _) = frame(&running);
    assert!(
        line["valid"] == false && line.to_string().contains("--turning needs the spindle angle"),
        "{line}"
    );
}

#[test]
fn a_thermometer_brings_the_diameter_to_20_degrees() {
    if cfg!(windows) {
        println!("SKIPPED: the commands are of sh");
        return;
    }
    let of = |arguments: &[&str]| {
        let mut running =
            Running::of("watch", &[&["-", "--json", "--um-per-px", "10"][..], arguments].concat());
        // The thermometer's first answer may come after the first frame; later ones are alike.
        for sent in 1.. {
            running.send(&pgm(&picture(5)));
            let (line, _) = frame(&running);
            if line["valid"] == true && sent > 2 {
                return line;
            }
            assert!(line["valid"] == true || line.to_string().contains("temperature"), "{line}");
        }
        unreachable!("frames are sent until one is valid")
    };
    let (cold, hot) = (of(&[]), of(&["--temperature-cmd", "echo 120,0.5"]));
    let d_mm = |line: &Value| line["mean_diameter_mm"].as_f64().unwrap();
    // 11.5 µm/(m·K) over 100 K.
    assert!((d_mm(&cold) / d_mm(&hot) - (1.0 + 11.5e-6 * 100.0)).abs() < 2e-6, "{cold} {hot}");
    assert_eq!((hot["part_c"].as_f64(), hot["part_limit_k"].as_f64()), (Some(120.0), Some(0.5)));
    let output = shadowgauge(["watch", "-", "--um-per-px", "10", "--temperature-cmd", "exit 4"]);
    assert!(
        output.status.code() == Some(3) && said(&output).contains("--temperature-cmd"),
        "{}",
        said(&output)
    );
}

#[test]
fn a_temperature_that_is_too_old_is_refused_until_another_one_is_appended() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("temperatures.csv");
    fs::write(&table, format!("t_ns,part_c,limit_k\n{},30,0.2\n", ago_ns(900))).unwrap();
    let path = table.display().to_string();
    let mut running = Running::of("watch", &["-", "--json", "--um-per-px", "10", "--temperatures", &path]);
    running.send(&pgm(&picture(1)));
    let (line, _) = frame(&running);
    assert!(line["valid"] == false && line.to_string().contains("is the thermometer connected?"), "{line}");
    append(&table, &format!("{},31,0.2", ago_ns(60)));
    let (line, _) = until(&mut running, |line| line["valid"] == true);
    // The limits have grown for some 50 s by .02 K/s.
    let limit_k = line["part_limit_k"].as_f64().unwrap();
    assert!(line["part_c"] == 31.0 && limit_k > 1.15 && limit_k < 3.0, "{line}");
}

#[test]
fn drift_since_the_zero_is_in_the_budget_and_its_interval_ends_it() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("zeros.csv");
    fs::write(&table, format!("t_ns\n{}\n", ago_ns(3600))).unwrap();
    let path = table.display().to_string();
    let start = |interval_s: &str| {
        let drift = ["--zero", &path, "--zero-interval-s", interval_s, "--zero-um-per-h", "1.2", "--budget"];
        Running::of("watch", &[&["-", "--json", "--um-per-px", "10"][..], &drift].concat())
    };
    let mut running = start("7200");
    running.send(&pgm(&picture(1)));
    let (line, _) = frame(&running);
    let u_mm = 1.2e-3 / 3.0_f64.sqrt();
    assert!((line["u_drift_mm"].as_f64().unwrap() / u_mm - 1.0).abs() < 0.05, "{line}");
    let rows = line["budget"].as_array().unwrap();
    let row = rows.iter().find(|row| row["source"] == "drift since the last zero").unwrap();
    assert!(row["u_mm"] == line["u_drift_mm"] && line["u_max_mm"].as_f64().unwrap() >= u_mm, "{line}");
    running.end();
    let mut running = start("600");
    running.send(&pgm(&picture(1)));
    let (line, _) = frame(&running);
    assert!(line["valid"] == false && line.to_string().contains("measure the zero master again"), "{line}");
    append(&table, &ago_ns(5).to_string());
    let (line, _) = until(&mut running, |line| line["valid"] == true);
    assert!(line["since_zero_s"].as_f64().is_some_and(|s| s < 600.0), "{line}");
}

#[test]
fn what_is_saved_is_every_result_and_a_bounded_number_of_bad_frames() {
    let folder = tempfile::tempdir().unwrap();
    let saved = folder.path().join("saved");
    let path = saved.display().to_string();
    let arguments = [
        "-",
        "--json",
        "--um-per-px",
        "10",
        "--tolerance",
        "0.5 ±0.01",
        "--save",
        &path,
        "--save-frames",
        "2",
    ];
    let mut running = Running::of("watch", &arguments);
    let mut lines = Vec::new();
    running.send(&pgm(&empty(9)));
    lines.push(running.line());
    for seed in 0..3 {
        running.send(&pgm(&picture(seed)));
        lines.push(running.line());
        if seed == 0 {
            // The alarm stands before its frame.
            lines.push(running.line());
        }
    }
    let (code, rest) = running.end();
    lines.extend(rest);
    assert_eq!(code, Some(1));
    let results = fs::read_to_string(saved.join("results.jsonl")).unwrap();
    assert_eq!(results.lines().collect::<Vec<_>>(), lines);
    let files: Vec<Value> = parsed(&lines).into_iter().map(|line| line["saved"].clone()).collect();
    let files: Vec<&str> = files.iter().filter_map(Value::as_str).collect();
    assert_eq!(files, ["frames/000001.png", "frames/000002.png"]);
    for (file, seed) in files.iter().zip(0..) {
        let image = image::open(saved.join(file)).unwrap().into_luma16();
        let sent: Vec<u16> = picture(seed).into_raw().into_iter().map(u16::from).collect();
        assert_eq!(image.into_raw(), sent, "{file}");
    }
    // They measure as they did.
    let again =
        shadowgauge(["measure", &saved.join("frames").display().to_string(), "--um-per-px", "10", "--json"]);
    let again: Value = serde_json::from_str(&text(&again.stdout)).unwrap();
    let first = parsed(&lines).into_iter().find(|line| line["saved"] == "frames/000001.png").unwrap();
    let (then, now) = (&first["max_diameter_px"], &again["frames"][0]["max_diameter_px"]);
    assert!((then.as_f64().unwrap() - now.as_f64().unwrap()).abs() < 1e-6, "{then} {now}");
    let taken = shadowgauge(["watch", "-", "--save", &path]);
    assert!(taken.status.code() == Some(2) && said(&taken).contains("taken"), "{}", said(&taken));
}

#[test]
fn the_setup_states_focus_light_and_exposure_with_a_part_and_without() {
    let mut running = Running::of("watch", &["-", "--json", "--setup"]);
    running.send(&pgm(&picture(1)));
    let page = event(&running, "setup");
    // A logistic edge of scale ½ px has a standard deviation of π/√12 = .91 px.
    let blur = page["edges"]["blur_px"].as_array().unwrap();
    let all: Vec<f64> =
        blur.iter().flat_map(|side| side.as_array().unwrap()).map(|b| b.as_f64().unwrap()).collect();
    assert!(all.len() == 6 && all.iter().all(|px| (0.6..1.2).contains(px)), "{page}");
    assert!(page["edges"]["tilt_deg"].as_f64().unwrap().abs() < 0.1, "{page}");
    // 180 to 184 counts of 255: 204 would be 80 %.
    let factor = page["light"]["exposure_factor"].as_f64().unwrap();
    assert!((factor - 204.0 / 184.0).abs() < 0.01 && page["light"]["saturated_share"] == 0.0, "{page}");
    assert!(page["evenness"]["lowest"].as_f64().unwrap() > -0.02, "{page}");
    running.end();
    // Without a part there is light to set up.
    let mut running = Running::of("watch", &["-", "--setup"]);
    running.send(&pgm(&empty(1)));
    let first = running.line();
    let (code, rest) = running.end();
    let page = [vec![first], rest].concat().join("\n");
    assert!(code == Some(0) && page.contains("edges      none") && page.contains("exposure"), "{page}");
    assert!(page.contains("no flat field is calibrated"), "{page}");
}
