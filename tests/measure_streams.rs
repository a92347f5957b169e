//! `measure` on streams, from outside: frames come out as they go in, each once. `walk_streams`
//! has long ones.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use image::{GrayImage, ImageFormat, Luma};
use serde_json::Value;

use crate::streamed::{COLUMNS, ROWS, Running, encoded, is_measured, pgm, picture, png};

#[path = "support/program.rs"]
mod program;
#[path = "support/streamed.rs"]
mod streamed;

fn written(folder: &Path, count: u64) {
    for seed in 0..count {
        std::fs::write(folder.join(format!("f{seed}.png")), png(seed)).unwrap();
    }
}

#[test]
fn a_line_comes_before_the_next_image_is_sent() {
    let mut running = Running::start(&["-", "--json", "--um-per-px", "10"]);
    for sequence in 0..3_u64 {
        running.send(&png(sequence));
        let frame = running.json();
        assert!(is_measured(&frame), "{frame}");
        assert_eq!(frame["frame"], format!("{sequence:06}"));
        assert_eq!((&frame["sequence"], &frame["lost"]), (&sequence.into(), &0.into()));
        assert!(frame["incomplete"] == false && frame["device_t_ns"].is_null());
        assert!(frame["host_t_ns"].as_u64().is_some_and(|t| t > 1_600_000_000_000_000_000), "{frame}");
    }
    let (code, rest) = running.end();
    assert_eq!((code, rest.len()), (Some(0), 1), "{rest:?}");
    let series: Value = serde_json::from_str(&rest[0]).unwrap();
    assert_eq!(series["statistics"]["count"], 3);
    let mut table = Running::start(&["-"]);
    table.send(&png(1));
    assert!(table.line().starts_with("frame ") && table.line().starts_with("000000 "));
    assert_eq!(table.end().0, Some(0));
}

#[test]
fn images_of_every_format_with_an_end_come_one_after_another() {
    let picture = picture(5);
    let formats = [ImageFormat::Bmp, ImageFormat::Jpeg, ImageFormat::Png];
    let mut stream: Vec<u8> = formats.iter().flat_map(|format| encoded(&picture, *format)).collect();
    stream.extend(pgm(&picture));
    let mut running = Running::start(&["-", "--json"]);
    running.send(&stream);
    running.send(&pgm(&picture)[..900]);
    let (code, lines) = running.end();
    assert_eq!((code, lines.len()), (Some(0), 6), "{lines:?}");
    let frames: Vec<Value> = lines.iter().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert!(frames[..4].iter().all(is_measured), "{lines:?}");
    // The last one was cut.
    assert_eq!(frames[4]["flags"]["unreadable"], 1);
}

#[test]
fn what_cannot_be_split_or_read_is_refused_with_what_would_be_right() {
    let sent = |bytes: &[u8]| {
        let mut command = Command::new(program::path());
        command.args(["measure", "-"]).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        // A program that has refused the stream does not read on.
        let _ = child.stdin.take().unwrap().write_all(bytes);
        let output = child.wait_with_output().unwrap();
        (output.status.code(), program::said(&output))
    };
    let (code, said) = sent(&encoded(&picture(1), ImageFormat::Tiff));
    assert!(code == Some(3) && said.contains("TIFF") && said.contains("PNG"), "{said}");
    let (code, said) = sent(&png(1)[..200]);
    assert!(code == Some(3) && said.contains("000000"), "{said}");
    let (code, said) = sent(b"");
    assert!(code == Some(3) && said.contains("no frame"), "{said}");
    for arguments in [
        &["measure", "-", "a.png"][..],
        &["measure", "-", "--bench", "3"],
        &["measure", "-", "--um-per-px", "file"],
        &["measure", "--follow", ".", "--idle-s", "0"],
        &["measure", "a.png", "--idle-s", "1"],
        &["measure", "a.png", "--follow", "."],
    ] {
        let mut command = Command::new(program::path());
        let output = command.args(arguments).stdin(Stdio::null()).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", program::said(&output));
    }
}

#[test]
fn a_followed_folder_gives_every_image_once_and_waits_for_what_is_written_still() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().to_owned();
    // What is there before comes first, by its numbers.
    std::fs::write(path.join("f10.png"), png(10)).unwrap();
    std::fs::write(path.join("f9.png"), png(9)).unwrap();
    std::fs::write(path.join("frames.csv"), "frame,t_ns\nf9,900\nf10,\nf11,1100\nf12,1200\nf13,1300\n")
        .unwrap();
    let running = Running::start(&[
        "--follow",
        path.to_str().unwrap(),
        "--idle-s",
        "1.5",
        "--json",
        "--um-per-px",
        "10",
    ]);
    let camera = std::thread::spawn(move || {
        let half = |name: &str, bytes: &[u8]| {
            let mut file =
                std::fs::OpenOptions::new().create(true).append(true).open(path.join(name)).unwrap();
            file.write_all(bytes).unwrap();
        };
        let (slow, at) = (png(11), 300);
        half("f11.png", &slow[..at]);
        std::thread::sleep(Duration::from_millis(200));
        half("f12.pgm", &pgm(&picture(12)));
        std::thread::sleep(Duration::from_millis(200));
        half("f11.png", &slow[at..]);
        half("f13.png.part", &png(13));
        std::fs::rename(path.join("f13.png.part"), path.join("f13.png")).unwrap();
    });
    let frames: Vec<Value> = (0..5).map(|_| running.json()).collect();
    camera.join().unwrap();
    let (code, rest) = running.end();
    assert_eq!((code, rest.len()), (Some(0), 1), "{rest:?}");
    let names: Vec<&str> = frames.iter().filter_map(|frame| frame["frame"].as_str()).collect();
    assert_eq!(names, ["f9", "f10", "f11", "f12", "f13"]);
    assert!(frames.iter().all(is_measured), "{frames:?}");
    let times: Vec<Option<u64>> = frames.iter().map(|frame| frame["device_t_ns"].as_u64()).collect();
    assert_eq!(times, [Some(900), None, Some(1100), Some(1200), Some(1300)]);
    let series: Value = serde_json::from_str(&rest[0]).unwrap();
    assert_eq!(series["statistics"]["count"], 5);
}

/// Files as they lie about: each has its row, under a name that stays on its line, or its error.
#[cfg(unix)]
#[test]
fn links_odd_names_and_a_full_disk_are_handled_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let images = folder.path().join("linked images");
    std::fs::create_dir(&images).unwrap();
    std::fs::write(images.join("a b.png"), png(1)).unwrap();
    std::fs::write(images.join("c\nd.png"), png(2)).unwrap();
    std::fs::create_dir(images.join("folder.png")).unwrap();
    std::os::unix::fs::symlink(images.join("a b.png"), images.join("e.png")).unwrap();
    std::os::unix::fs::symlink("/nowhere", images.join("gone.png")).unwrap();
    let link = folder.path().join("link");
    std::os::unix::fs::symlink(&images, &link).unwrap();
    let path = link.to_str().unwrap();
    let output = program::shadowgauge(["measure", path]);
    let (table, said) = (program::text(&output.stdout), program::said(&output));
    assert_eq!(output.status.code(), Some(0), "{said}");
    let names: Vec<&str> = table.lines().skip(1).map(|row| row[..24].trim()).collect();
    assert_eq!(names, ["a b", "c\\nd", "e", "gone"], "{table}");
    assert!(said.contains("gone.png") && table.lines().last().unwrap().contains("unreadable"), "{said}");
    // A folder that vanishes ends its stream with an error, after what was measured of it.
    let running = Running::start(&["--follow", path, "--json"]);
    let found: Vec<Value> = (0..3).map(|_| running.json()).collect();
    assert!(found.iter().all(is_measured), "{found:?}");
    std::fs::remove_dir_all(&images).unwrap();
    let (code, rest) = running.end();
    assert_eq!((code, rest.len()), (Some(3), 1), "{rest:?}");
    if Path::new("/dev/full").exists() {
        let image = folder.path().join("one.png");
        std::fs::write(&image, png(3)).unwrap();
        for option in ["--csv", "--edges", "--report"] {
            let image = image.to_str().unwrap();
            let output = program::shadowgauge(["measure", image, "--um-per-px", "10", option, "/dev/full"]);
            let said = program::said(&output);
            assert!(
                output.status.code() == Some(3) && said.contains("/dev/full: cannot be written"),
                "{said}"
            );
        }
    }
}

#[test]
fn ctrl_c_ends_a_stream_with_its_series() {
    let folder = tempfile::tempdir().unwrap();
    written(folder.path(), 1);
    let path = folder.path().to_str().unwrap();
    for (tolerance, code) in [("0.3..0.4", 0), ("0.1..0.2", 1)] {
        let arguments = ["--follow", path, "--json", "--um-per-px", "10", "--tolerance", tolerance];
        let running = Running::start(&arguments);
        assert!(is_measured(&running.json()));
        let killed = Command::new("kill").args(["-INT", &running.child.id().to_string()]).status().unwrap();
        assert!(killed.success());
        let (found, rest) = running.end();
        assert_eq!((found, rest.len()), (Some(code), 1), "{rest:?}");
        assert!(rest[0].contains("statistics"), "{rest:?}");
    }
}

#[test]
fn a_document_is_the_same_at_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    // Nothing can be measured of the first ones.
    std::fs::write(folder.path().join("a0.png"), b"none").unwrap();
    let white = GrayImage::from_pixel(COLUMNS, ROWS, Luma([255]));
    std::fs::write(folder.path().join("a1.png"), encoded(&white, ImageFormat::Png)).unwrap();
    written(folder.path(), 12);
    let edges = folder.path().join("edges.csv");
    let path = folder.path().to_str().unwrap();
    let run = |threads: &str| {
        let arguments = ["measure", path, "--json", "--um-per-px", "10", "--threads", threads, "--edges"];
        let output = program::shadowgauge([&arguments[..], &[edges.to_str().unwrap()]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", program::said(&output));
        (output.stdout, std::fs::read(&edges).unwrap())
    };
    let one = run("1");
    assert!(one == run("2") && one == run("3"));
    let document: Value = serde_json::from_slice(&one.0).unwrap();
    // The bytes of the whole document, keys in their order.
    assert_eq!(program::text(&one.0), format!("{document}\n"));
    let frames = document["frames"].as_array().unwrap();
    let names: Vec<&str> = frames.iter().filter_map(|frame| frame["frame"].as_str()).collect();
    assert_eq!(names[..5], ["a0", "a1", "f0", "f1", "f2"]);
    assert!(frames.len() == 14 && frames[2..].iter().all(is_measured));
    assert_eq!(document["statistics"]["count"], 12);
    let rows = program::text(&one.1);
    assert_eq!(rows.lines().count(), 1 + 1 + (1 + 12) * COLUMNS as usize);
}

#[test]
fn where_no_frame_can_be_measured_there_is_the_error_alone() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.png", "b.png"] {
        std::fs::write(folder.path().join(name), b"none").unwrap();
    }
    let (path, edges) = (folder.path().to_str().unwrap(), folder.path().join("edges.csv"));
    for more in [&["--json"][..], &[], &["--json", "--edges", edges.to_str().unwrap()], &["--edges", "-"]] {
        let output = program::shadowgauge([&["measure", path], more].concat());
        assert_eq!(output.status.code(), Some(3), "{more:?}");
        assert!(output.stdout.is_empty() && !edges.exists(), "{more:?}");
        assert!(program::said(&output).contains("none of 2 frames"), "{}", program::said(&output));
    }
}
