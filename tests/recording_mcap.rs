//! Recordings in MCAP from outside: what `watch --record` writes, `measure replay:` measures as the
//! source itself, also of a file that is cut off; PyPI `mcap` reads every pixel.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use std::fs::File;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::program::{said, shadowgauge, text};
use crate::streamed::{pgm, picture};

#[path = "support/program.rs"]
mod program;
#[path = "support/streamed.rs"]
mod streamed;

/// Frames of the recording.
const FRAMES: u64 = 4;

/// A stream of images, and the recording of it.
fn recorded(folder: &Path) -> (PathBuf, PathBuf) {
    let [all, file] = ["all.pgm", "day.mcap"].map(|name| folder.join(name));
    let images: Vec<u8> = (0..FRAMES).flat_map(|number| pgm(&picture(number))).collect();
    std::fs::write(&all, images).unwrap();
    let arguments = ["watch", "-", "--json", "--um-per-px", "10", "--record", &file.display().to_string()];
    let mut watch = Command::new(program::path());
    let watch = watch.args(arguments).env("NO_COLOR", "1").stdin(File::open(&all).unwrap());
    let output = watch.output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    (all, file)
}

/// The lines of frames that `measure` prints of a source, and what it says beside.
fn lines(source: &str, stdin: Stdio) -> (Vec<Value>, String) {
    let mut measure = Command::new(program::path());
    let measure = measure.args(["measure", source, "--json", "--um-per-px", "10"]).env("NO_COLOR", "1");
    let output = measure.stdin(stdin).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let stdout = text(&output.stdout);
    let parsed = stdout.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    (parsed.filter(|line| line["frame"].is_string()).collect(), said(&output))
}

fn diameters(lines: &[Value]) -> Vec<String> {
    lines.iter().map(|line| line["max_diameter_mm"].to_string()).collect()
}

#[test]
fn a_recording_measures_as_its_source_and_as_far_as_it_is_whole() {
    let folder = tempfile::tempdir().unwrap();
    let (all, file) = recorded(folder.path());
    let (own, _) = lines("-", File::open(all).unwrap().into());
    let (again, words) = lines(&format!("replay:{}", file.display()), Stdio::null());
    assert_eq!(diameters(&again), diameters(&own));
    assert!(own.len() as u64 == FRAMES && own.iter().all(|l| l["max_diameter_mm"].is_f64()), "{own:?}");
    assert!(again.iter().all(|line| line["host_t_ns"].as_u64().is_some_and(|t| t > 0)), "{again:?}");
    assert!(!words.contains("cut off"), "{words}");

    // The end of the file is its index; the last chunk is before it.
    let bytes = std::fs::read(&file).unwrap();
    let cut = folder.path().join("cut.mcap");
    std::fs::write(&cut, &bytes[..bytes.len() - 100]).unwrap();
    let (again, words) = lines(&format!("replay:{}", cut.display()), Stdio::null());
    assert_eq!(diameters(&again), diameters(&own));
    assert!(words.contains("is cut off: 4 frames"), "{words}");
}

#[test]
fn the_simulated_head_is_recorded_killed_and_replayed_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("small.toml");
    std::fs::write(&config, include_str!("support/small_render_job.toml")).unwrap();
    let file = folder.path().join("head.mcap").display().to_string();
    let sim = format!("sim:{}", config.display());
    let (own, _) = lines(&sim, Stdio::null());
    let mut watch = Command::new(program::path());
    watch.args(["watch", &sim, "--json", "--um-per-px", "10", "--record", &file]);
    let mut running = watch.env("NO_COLOR", "1").stdout(Stdio::piped()).spawn().unwrap();
    // Killed once more than a scan is on the disk: 120 x 100 pixels of 2 bytes at most a frame.
    let needed = (own.len() as u64 + 1) * 24_000;
    let mut printed = BufReader::new(running.stdout.take().unwrap()).lines();
    while std::fs::metadata(&file).map_or(0, |file| file.len()) < needed {
        printed.next().expect("the simulated head does not end").unwrap();
    }
    running.kill().unwrap();
    running.wait().unwrap();
    let (replayed, words) = lines(&format!("replay:{file}"), Stdio::null());
    assert!(replayed.len() >= own.len() && words.contains("is cut off"), "{words}");
    let first = &replayed[..own.len()];
    assert_eq!(diameters(first), diameters(&own));
    let simulated = |lines: &[Value]| lines.iter().map(|l| l["device_t_ns"].clone()).collect::<Vec<_>>();
    assert_eq!(simulated(first), simulated(&own));
}

#[test]
fn a_file_that_is_there_is_not_written_over_and_what_is_no_recording_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let image = folder.path().join("a.pgm");
    std::fs::write(&image, pgm(&picture(1))).unwrap();
    let image = image.display().to_string();
    let output = shadowgauge(["watch", &image, "--record", &image]);
    assert!(output.status.code() == Some(2) && said(&output).contains("name a new one"), "{}", said(&output));
    assert_eq!(std::fs::read(&image).unwrap(), pgm(&picture(1)));
    for (source, word) in
        [(format!("replay:{image}"), "no MCAP file"), ("replay:nowhere.mcap".into(), "nowhere")]
    {
        let output = shadowgauge(["measure", &source]);
        assert!(output.status.code() == Some(3) && said(&output).contains(word), "{}", said(&output));
    }
}

/// Sums of the pixels of every image, by Foxglove's own reader and the descriptors in the file.
const READ: &str = "import sys
from mcap.reader import NonSeekingReader
from mcap_protobuf.decoder import DecoderFactory
with open(sys.argv[1], 'rb') as file:
    reader = NonSeekingReader(file, decoder_factories=[DecoderFactory()])
    for schema, channel, message, of in reader.iter_decoded_messages(log_time_order=False):
        if schema.name == 'foxglove.RawImage':
            print(of.width, of.height, of.encoding, sum(of.data))
";

#[test]
fn another_reader_finds_every_pixel() {
    let python = Command::new("python3").args(["-c", "import mcap, mcap_protobuf"]).output();
    if !python.is_ok_and(|output| output.status.success()) {
        eprintln!(
            "SKIPPED: python3 with the modules mcap and mcap_protobuf is missing (pip install mcap-protobuf-support)"
        );
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (_, file) = recorded(folder.path());
    let output = Command::new("python3").args(["-c", READ]).arg(&file).output().unwrap();
    let right: Vec<String> = (0..FRAMES)
        .map(|number| {
            let image = picture(number);
            let sum: u64 = image.pixels().map(|pixel| u64::from(pixel.0[0])).sum();
            format!("{} {} mono8 {sum}", image.width(), image.height())
        })
        .collect();
    assert_eq!(text(&output.stdout).lines().collect::<Vec<_>>(), right, "{}", text(&output.stderr));
}
