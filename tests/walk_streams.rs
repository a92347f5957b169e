//! Long series, from outside: a folder that is followed while it fills, and the memory of
//! `measure`, which does not grow with the number of frames whatever is asked for. Those of 10⁵
//! frames are ignored; `cargo test --release --test walk_streams -- --ignored --nocapture` prints
//! their figures.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use std::collections::HashSet;
use std::fs::File;
use std::io::{BufRead as _, BufReader, BufWriter, Cursor, Write as _};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde_json::Value;

use crate::streamed::{COLUMNS, Running, WIDTH_PX, is_measured, pgm, picture, png as image};

#[path = "support/program.rs"]
mod program;
#[path = "support/streamed.rs"]
mod streamed;

/// Growth of the peak that is allowed while frames are added, kB: the allocator's own, by which
/// equal runs differ. A row of a report kept of each of 1200 frames takes as much.
const FLAT_KB: u64 = 512;
/// What a name costs that stays in a followed folder, bytes: its entry, its letters, and the room
/// that a hash table leaves.
const NAME_BYTES: u64 = 120;

fn name(index: usize) -> String {
    format!("part {index:06}.png")
}

/// Drops files into a folder as drivers of cameras do: most at once under their own name, of every
/// sixteen one before its forerunner, one renamed, and one in halves with its follower between
/// them.
fn fill(folder: &Path, indices: Range<usize>, images: &[Vec<u8>]) {
    let mut begun: Option<(File, &[u8])> = None;
    for turn in indices {
        let index = match turn % 16 {
            9 => turn + 1,
            10 => turn - 1,
            _ => turn,
        };
        let (path, image) = (folder.join(name(index)), &images[index % images.len()]);
        if index % 16 == 3 {
            let (half, rest) = image.split_at(image.len() / 2);
            let mut file = File::create(&path).unwrap();
            file.write_all(half).unwrap();
            begun = Some((file, rest));
            continue;
        }
        let first = if index % 16 == 6 { path.with_extension("png.part") } else { path.clone() };
        std::fs::write(&first, image).unwrap();
        if first != path {
            std::fs::rename(first, &path).unwrap();
        }
        if let Some((mut file, rest)) = begun.take() {
            file.write_all(rest).unwrap();
        }
    }
}

/// Follows a folder while `count` files are dropped into it, so many before their results are
/// waited for; gives the peak of the memory after a tenth of them and after all, kB.
fn followed(count: usize, at_once: usize, removes: bool) -> [u64; 2] {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().to_owned();
    let images: Arc<Vec<Vec<u8>>> = Arc::new((0..16).map(image).collect());
    let arguments = ["--follow", path.to_str().unwrap(), "--idle-s", "3", "--json", "--um-per-px", "10"];
    let running = Running::start(&arguments);
    let (mut seen, mut most_kb) = (HashSet::new(), [0; 2]);
    for from in (0..count).step_by(at_once) {
        let (to, images, into) = (from + at_once, Arc::clone(&images), path.clone());
        let writer = std::thread::spawn(move || fill(&into, from..to, &images));
        let mut batch = Vec::with_capacity(at_once);
        for _ in from..to {
            let frame = running.json();
            assert!(is_measured(&frame), "{frame}");
            batch.push(frame["frame"].as_str().unwrap().to_owned());
        }
        writer.join().unwrap();
        for stem in batch {
            if removes {
                std::fs::remove_file(path.join(format!("{stem}.png"))).unwrap();
            }
            assert!(seen.insert(stem.clone()), "{stem} came twice");
        }
        if to <= count / 10 {
            most_kb[0] = running.most_kb();
        }
    }
    most_kb[1] = running.most_kb();
    let (code, rest) = running.end();
    assert_eq!((code, rest.len()), (Some(0), 1), "{rest:?}");
    let series: Value = serde_json::from_str(&rest[0]).unwrap();
    assert_eq!((seen.len(), &series["statistics"]["count"]), (count, &count.into()));
    assert!((0..count).all(|index| seen.contains(name(index).trim_end_matches(".png"))));
    most_kb
}

#[test]
fn a_folder_that_fills_gives_each_image_once_and_ends_when_it_is_idle() {
    followed(320, 32, true);
}

#[test]
#[ignore = "ten minutes and more"]
fn a_hundred_thousand_images_are_followed_in_flat_memory() {
    for removes in [true, false] {
        let [first_kb, last_kb] = followed(100_000, 2000, removes);
        println!(
            "--follow, files {}: {first_kb} kB at 10 000, {last_kb} kB at 100 000",
            if removes { "taken away once measured" } else { "that stay" }
        );
        let names_kb = if removes { 0 } else { 90_000 * NAME_BYTES / 1000 };
        assert!(last_kb - first_kb <= FLAT_KB + names_kb, "{first_kb} to {last_kb} kB");
    }
}

/// Measures frames that come on stdin and gives the peak of the memory after the first of them and
/// after all, kB, with the document of the series.
fn piped(arguments: &[&str], first: usize, count: usize) -> ([u64; 2], Value) {
    // Sixteen pictures over and over: drawing takes longer than measuring.
    let pictures: Vec<Vec<u8>> = (0..16).map(|seed| pgm(&picture(seed))).collect();
    let mut running = Running::start(&[&["-", "--json", "--um-per-px", "10"], arguments].concat());
    let mut most_kb = [0; 2];
    for (piece, most) in [0..first, first..count].into_iter().zip(&mut most_kb) {
        // Not many are under way at once: lines that wait would be memory of this test alone.
        for from in piece.clone().step_by(100) {
            let some = from..(from + 100).min(piece.end);
            some.clone().for_each(|index| running.send(&pictures[index % 16]));
            for _ in some {
                let frame = running.json();
                assert!(is_measured(&frame), "{frame}");
            }
        }
        *most = running.most_kb();
    }
    let (code, rest) = running.end();
    assert!(code.is_some_and(|code| code < 2) && rest.len() == 1, "{code:?} {rest:?}");
    (most_kb, serde_json::from_str(&rest[0]).unwrap())
}

/// What grows with no number of frames: all outputs at once, over a turn of a camera that stands.
#[test]
fn memory_does_not_grow_with_the_number_of_frames_whatever_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (csv, report, edges) = (file("d.csv"), file("r.html"), file("e.csv"));
    let turn = ["--turn", "--angle-step", "22.5", "--tolerance", "0.355..0.367"];
    let written = ["--csv", &csv, "--report", &report, "--edges", &edges];
    // After 1024 frames a turn is summed up.
    let ([first_kb, last_kb], series) = piped(&[&turn[..], &written].concat(), 1200, 2400);
    assert!(last_kb - first_kb <= FLAT_KB, "{first_kb} to {last_kb} kB");
    assert_eq!(series["statistics"]["count"], 2400);
    let sections = series["turn"]["sections"].as_array().unwrap();
    assert_eq!((sections.len(), &sections[0]["angles"]), (1, &16.into()));
    let size_mm = sections[0]["gg_mm"].as_f64().unwrap();
    assert!((size_mm - 1e-2 * WIDTH_PX).abs() < 5e-3, "{size_mm}");
    let lines = |path: &str| BufReader::new(File::open(path).unwrap()).lines().count();
    assert_eq!((lines(&csv), lines(&edges)), (1 + 2400, 1 + 2400 * COLUMNS as usize));
    let page = std::fs::read_to_string(&report).unwrap();
    assert!(page.contains("400 of 2400 frames") && page.len() < 300_000, "{} bytes", page.len());
}

#[test]
#[ignore = "ten minutes and more"]
fn a_hundred_thousand_frames_are_measured_in_flat_memory() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (csv, report, edges) = (file("d.csv"), file("r.html"), file("e.csv"));
    let turn = ["--turn", "--angle-step", "22.5"];
    let judged = ["--tolerance", "0.355..0.367", "--station-mm", "0.1", "--csv", &csv, "--report", &report];
    let refused = ["--min-diameter-px", "30", "--tolerance", "0.1..0.2"];
    for (what, arguments) in [
        ("plain", &[][..]),
        ("--turn", &turn),
        ("--csv", &["--csv", &csv]),
        ("--edges", &["--edges", &edges]),
        ("--report", &["--report", &report]),
        ("stations judged, --csv, --report", &judged),
        ("all judged bad", &refused),
    ] {
        let ([first_kb, last_kb], _) = piped(arguments, 10_000, 100_000);
        println!("{what}: {first_kb} kB at 10 000, {last_kb} kB at 100 000");
        assert!(last_kb - first_kb <= FLAT_KB, "{what}: {first_kb} to {last_kb} kB");
    }
}

/// Files that are there: a folder of 200 images, each under 5, 50 and 500 names. A table of text.
#[test]
#[ignore = "ten minutes and more"]
fn a_folder_of_a_hundred_thousand_files_takes_what_their_names_take() {
    let most_kb = [1000, 10_000, 100_000].map(|count| {
        let folder = tempfile::tempdir().unwrap();
        for index in 0..count {
            let (path, first) = (folder.path().join(name(index)), folder.path().join(name(index % 200)));
            match index < 200 {
                true => std::fs::write(path, image(index as u64)).unwrap(),
                false => std::fs::hard_link(first, path).unwrap(),
            }
        }
        let running = Running::start(&[folder.path().to_str().unwrap(), "--um-per-px", "10"]);
        // The names of the columns, a row a frame, the statistics.
        for _ in 0..count {
            running.line();
        }
        let most_kb = running.most_kb();
        assert_eq!(running.end().0, Some(0));
        println!("a folder of {count}: {most_kb} kB");
        most_kb
    });
    let name_bytes = 1000 * (most_kb[2] - most_kb[1]) / 90_000;
    println!("{name_bytes} bytes a file");
    assert!(name_bytes <= 3 * NAME_BYTES, "{name_bytes} bytes a file");
}

/// Frames of 2048 x 2048 as cameras of 12 bits give them, in PNG of 16 bits: shot noise, as most of
/// what decoding takes is that of the noise.
fn large_frames(folder: &Path, count: u64) {
    const SIDE: usize = 2048;
    for seed in 0..count {
        let mut random = Pcg64::seed_from_u64(seed);
        let mut bytes = Vec::with_capacity(2 * SIDE * SIDE);
        for row in 0..SIDE {
            let beyond = (row as f64 - 1023.5).abs() - 700.3;
            let light = 100.0 + 1600.0 * (1.0 + (beyond / 1.2).tanh());
            // Half an electron a count, the noise nearly normal.
            let sd = (0.5 * light).sqrt();
            for _ in 0..SIDE {
                let noise: f64 = (0..4).map(|_| random.random_range(-1.0..1.0)).sum();
                let grey = light + sd * noise * (3.0_f64 / 4.0).sqrt();
                bytes.extend((grey.round() as u16).to_be_bytes());
            }
        }
        let file = File::create(folder.join(format!("{seed:06}.png"))).unwrap();
        let mut encoder = png::Encoder::new(BufWriter::new(file), SIDE as u32, SIDE as u32);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::Sixteen);
        encoder.set_compression(png::Compression::Fast);
        encoder.write_header().unwrap().write_image_data(&bytes).unwrap();
    }
}

/// Reads and decodes files on so many threads, nothing else.
fn decode_alone(files: &[PathBuf], threads: usize) {
    let next = AtomicUsize::new(0);
    let decode = || {
        let mut grey = Vec::new();
        while let Some(path) = files.get(next.fetch_add(1, Ordering::Relaxed)) {
            let bytes = std::fs::read(path).unwrap();
            let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
            grey.resize(reader.output_buffer_size().unwrap(), 0);
            reader.next_frame(&mut grey).unwrap();
        }
    };
    std::thread::scope(|scope| (0..threads).for_each(|_| _ = scope.spawn(decode)));
}

/// User and system time, s, of this process and of its children that have ended.
fn cpu_s() -> [f64; 2] {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap();
    let after_name: Vec<&str> = stat.rsplit_once(')').unwrap().1.split_whitespace().collect();
    // proc(5): utime, stime, cutime, cstime in ticks of 10 ms.
    let s = |field: usize| after_name[field].parse::<f64>().unwrap() / 100.0;
    [s(11) + s(12), s(13) + s(14)]
}

/// The median of an odd number of values.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[test]
#[ignore = "a figure, not a check: depends on what else the machine does"]
fn decoding_is_most_of_what_measuring_a_folder_takes() {
    const FRAMES: u64 = 64;
    let folder = tempfile::tempdir().unwrap();
    large_frames(folder.path(), FRAMES);
    let files: Vec<PathBuf> = (0..FRAMES).map(|k| folder.path().join(format!("{k:06}.png"))).collect();
    let arguments = ["measure", folder.path().to_str().unwrap(), "--threads", "2"];
    let (mut wall, mut cpu) = (Vec::new(), Vec::new());
    // The first pair fills the caches.
    for pair in 0..16 {
        let (start, before) = (Instant::now(), cpu_s());
        decode_alone(&files, 2);
        let (alone, between) = (start.elapsed().as_secs_f64(), cpu_s());
        let start = Instant::now();
        let output = program::shadowgauge(arguments);
        let (measured, after) = (start.elapsed().as_secs_f64(), cpu_s());
        assert_eq!(output.status.code(), Some(0), "{}", program::said(&output));
        if pair > 0 {
            wall.push([alone, measured]);
            cpu.push([between[0] - before[0], after[1] - between[1]]);
        }
    }
    for (what, pairs) in [("wall", wall), ("CPU", cpu)] {
        let ms = |k: usize| 1e3 / FRAMES as f64 * median(pairs.iter().map(|pair| pair[k]).collect());
        let share = median(pairs.iter().map(|pair| pair[0] / pair[1]).collect());
        println!("{what} ms a frame: {:.2} decoded alone, {:.2} measured, {share:.3}", ms(0), ms(1));
    }
}
