//! Raw pixels, Y4M and the simulated head by `measure`, from outside; what is no source.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use serde_json::Value;

use crate::program::{said, shadowgauge, text};
use crate::streamed::{COLUMNS, ROWS, Running, is_measured, picture};

#[path = "support/program.rs"]
mod program;
#[path = "support/streamed.rs"]
mod streamed;

/// A picture in a raw format, by the definition of the format, bit by bit.
fn raw(seed: u64, format: &str) -> Vec<u8> {
    let grey = picture(seed).into_raw();
    let deep = |bits: u32| grey.iter().map(move |v| u32::from(*v) << (bits - 8));
    let words = |bits: u32| deep(bits).flat_map(|v| (v as u16).to_le_bytes()).collect();
    match format {
        "mono8" => grey,
        "mono10" => words(10),
        "mono12" => words(12),
        "mono16" => words(16),
        "mono10p" | "mono12p" => {
            let bits = if format == "mono10p" { 10 } else { 12 };
            let all: Vec<u32> = deep(bits).flat_map(|v| (0..bits).map(move |bit| v >> bit & 1)).collect();
            all.chunks(8).map(|b| b.iter().rev().fold(0, |byte, bit| byte << 1 | *bit) as u8).collect()
        }
        _ => {
            let all: Vec<u32> = deep(12).collect();
            let three = |p: &[u32]| [p[0] >> 4, p[0] & 15 | (p[1] & 15) << 4, p[1] >> 4].map(|b| b as u8);
            all.chunks(2).flat_map(three).collect()
        }
    }
}

fn layout(format: &str) -> String {
    format!("{COLUMNS}x{ROWS}:{format}")
}

#[test]
fn raw_pixels_of_every_format_are_measured_as_they_come() {
    let mut widths = Vec::new();
    for format in ["mono8", "mono10", "mono12", "mono16", "mono10p", "mono12p", "mono12packed"] {
        let layout = layout(format);
        let mut running = Running::start(&["raw:-", "--raw", &layout, "--json", "--um-per-px", "10"]);
        for sequence in 0..2_u64 {
            running.send(&raw(sequence, format));
            let frame = running.json();
            assert!(is_measured(&frame), "{format}: {frame}");
            assert_eq!((&frame["sequence"], &frame["lost"]), (&sequence.into(), &0.into()));
            assert!(frame["host_t_ns"].is_u64() && frame["device_t_ns"].is_null());
            widths.push(frame["max_diameter_px"].as_f64().unwrap());
        }
        let (code, rest) = running.end();
        assert_eq!((code, rest.len()), (Some(0), 1), "{format}: {rest:?}");
    }
    // The same picture: the grey values differ by a factor alone.
    for pair in widths.chunks(2) {
        assert!((pair[0] - widths[0]).abs() < 0.02 && (pair[1] - widths[1]).abs() < 0.02, "{widths:?}");
    }
}

#[test]
fn a_pipe_that_ends_within_a_frame_states_which_and_how_much_of_it_there_was() {
    let mut running = Running::start(&["raw:-", "--raw", &layout("mono12"), "--json"]);
    running.send(&raw(1, "mono12"));
    running.send(&raw(2, "mono12")[..500]);
    let (code, lines) = running.end();
    assert_eq!((code, lines.len()), (Some(0), 3), "{lines:?}");
    let cut: Value = serde_json::from_str(&lines[1]).unwrap();
    let why = cut["warnings"][0].as_str().unwrap();
    let needed = COLUMNS * ROWS * 2;
    assert!(why.contains("frame 000001") && why.contains(&format!("500 bytes of {needed}")), "{why}");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("short.raw");
    std::fs::write(&file, &raw(1, "mono8")[..100]).unwrap();
    let source = format!("raw:{}", file.display());
    let output = shadowgauge(["measure", &source, "--raw", &layout("mono8")]);
    assert!(output.status.code() == Some(3) && said(&output).contains("100 bytes of"), "{}", said(&output));
}

fn y4m(tag: &str, format: &str, frames: u64) -> Vec<u8> {
    let mut all = format!("YUV4MPEG2 W{COLUMNS} H{ROWS} F25:1 Ip A1:1 C{tag}\n").into_bytes();
    for seed in 0..frames {
        all.extend(b"FRAME\n");
        all.extend(raw(seed, format));
    }
    all
}

#[test]
fn y4m_is_measured_from_files_and_pipes_and_colour_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    for (tag, format) in [("mono", "mono8"), ("mono12", "mono12"), ("mono16", "mono16")] {
        let file = folder.path().join(format!("{tag}.y4m"));
        std::fs::write(&file, y4m(tag, format, 3)).unwrap();
        let csv = folder.path().join(format!("{tag}.csv"));
        let arguments = [
            "measure",
            file.to_str().unwrap(),
            "--um-per-px",
            "10",
            "--json",
            "--csv",
            csv.to_str().unwrap(),
        ];
        let output = shadowgauge(arguments);
        let stdout = text(&output.stdout);
        assert_eq!((output.status.code(), stdout.lines().count()), (Some(0), 4), "{}", said(&output));
        assert_eq!(std::fs::read_to_string(csv).unwrap().lines().count(), 4);
        let mut running = Running::start(&["-", "--json"]);
        running.send(&y4m(tag, format, 2));
        assert!(is_measured(&running.json()) && is_measured(&running.json()));
        assert_eq!(running.end().0, Some(0));
    }
    let file = folder.path().join("colour.y4m");
    std::fs::write(&file, y4m("420jpeg", "mono8", 1)).unwrap();
    let output = shadowgauge(["measure", file.to_str().unwrap()]);
    let words = said(&output);
    assert!(
        output.status.code() == Some(3) && words.contains("C420jpeg") && words.contains("Cmono"),
        "{words}"
    );
}

#[test]
fn the_simulated_head_is_measured_scan_by_scan() {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("small.toml");
    std::fs::write(&config, include_str!("support/small_render_job.toml")).unwrap();
    let source = format!("sim:{}", config.display());
    let output = shadowgauge(["measure", &source, "--json", "--um-per-px", "15"]);
    let stdout = text(&output.stdout);
    let lines: Vec<Value> = stdout.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    // One field at two angles, and the series.
    assert_eq!((output.status.code(), lines.len()), (Some(0), 3), "{}", said(&output));
    for (number, frame) in lines[..2].iter().enumerate() {
        assert_eq!((&frame["frame"], &frame["sequence"]), (&format!("{number:06}").into(), &number.into()));
        assert!(frame["device_t_ns"].is_u64() && frame["host_t_ns"].is_u64(), "{frame}");
        // 1 mm at 15 µm a pixel.
        assert!((frame["max_diameter_mm"].as_f64().unwrap() - 1.0).abs() < 0.02, "{frame}");
    }
}

#[test]
fn what_is_no_source_is_refused_with_what_would_be_right() {
    for (arguments, word) in [
        (&["measure", "video:0"][..], "gige:NAME"),
        (&["measure", "usb:"], "serial number"),
        (&["measure", "gige:"], "IP address"),
        (&["measure", "raw:a.bin", "--raw", "4x4:mono8", "--exposure-us", "50"], "sets a camera"),
        (&["watch", "gige:head", "--exposure-us", "0"], "above 0"),
        (&["measure", "raw:a.bin"], "--raw WIDTHxHEIGHT:FORMAT"),
        (&["measure", "raw:"], "missing"),
        (&["measure", "a.png", "--raw", "4x4:mono8"], "has its own"),
        (&["measure", "raw:a.bin", "--raw", "4x4:rgb8"], "mono12packed"),
        (&["measure", "raw:a.bin", "b.png", "--raw", "4x4:mono8"], "stands alone"),
        (&["measure", "--follow", ".", "--raw", "4x4:mono8"], "--follow"),
        (&["measure", "raw:a.bin", "--raw", "4x4:mono8", "--bench", "3"], "--bench"),
        (&["watch", "raw:a.bin"], "--raw"),
        (&["watch", "a.png", "--um-per-px", "file"], "17.4"),
        (&["watch", "a.png", "--tolerance", "25 h6"], "--um-per-px"),
    ] {
        let output = shadowgauge(arguments);
        let words = said(&output);
        assert!(output.status.code() == Some(2) && words.contains(word), "{arguments:?}: {words}");
    }
    for source in ["raw:nowhere.bin", "sim:nowhere.toml", "nowhere.y4m"] {
        let mut arguments = vec!["measure", source];
        if source.starts_with("raw:") {
            arguments.extend(["--raw", "4x4:mono8"]);
        }
        let output = shadowgauge(&arguments);
        let words = said(&output);
        assert!(!output.status.success() && words.contains("nowhere"), "{source}: {words}");
    }
}

#[cfg(not(feature = "camera"))]
#[test]
fn a_program_without_cameras_refuses_them_by_its_feature() {
    for command in ["measure", "watch"] {
        let output = shadowgauge([command, "gige:10.0.0.7"]);
        let words = said(&output);
        assert!(output.status.code() == Some(2) && words.contains("without the feature camera"), "{words}");
    }
}
