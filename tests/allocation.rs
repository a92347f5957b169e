//! Memory: a frame is decoded and measured within twice its own size in addition to the gauge's
//! tables, whatever its contents. Hostile input: the bodies of the fuzz targets over their seeds
//! and damaged copies of them.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use std::io::Cursor;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use shadowgauge::frame::{Buffer, Frame, FrameMeta, FrameView, PixelFormat, Pixels};
use shadowgauge::gauge::{FrameEdges, Gauge, GaugeSettings};
use shadowgauge::source::decode;
use targets::{A_COLUMN, DECODER, TABLES, peak};

#[path = "../fuzz/targets.rs"]
mod targets;

fn noise(rng: &mut Pcg64, count: usize, kind: usize) -> Vec<u8> {
    (0..count)
        .map(|i| match kind {
            0 => rng.random(),
            1 => {
                if rng.random::<bool>() {
                    220
                } else {
                    15
                }
            }
            2 => (i % 251) as u8,
            _ => 200,
        })
        .collect()
}

/// A soft-edged shadow over the middle half of the rows.
fn shaft(rng: &mut Pcg64, rows: usize, columns: usize) -> Vec<u8> {
    let (top, bottom) = (rows as f64 * 0.25 + 0.3, rows as f64 * 0.75 - 0.4);
    let cover = |d: f64| 1.0 / (1.0 + (-1.7 * d).exp());
    let mut pixels = Vec::with_capacity(rows * columns);
    for row in 0..rows {
        let r = row as f64;
        let mean = 20.0 + 185.0 * (cover(top - r) + cover(r - bottom));
        pixels.extend((0..columns).map(|_| (mean + rng.random_range(-2.0..2.0)) as u8));
    }
    pixels
}

/// A single test, so that no other one allocates at the same time.
#[test]
fn no_allocation_beyond_twice_the_frame() {
    let mut rng = Pcg64::seed_from_u64(21);
    let gauge = Gauge::new(GaugeSettings::default()).unwrap();
    // Threads and their stacks do not count for the frame.
    let warm = shaft(&mut rng, 128, 256);
    let view = FrameView::new(Pixels::U8(&warm), PixelFormat::Mono8, 128, 256, 256).unwrap();
    gauge.edges(&view).unwrap();
    measured(&gauge, &mut rng);
    followed(&gauge, &mut rng);
    decoded(&mut rng);
    hostile("decode", targets::decode, 600, &mut rng);
    hostile("calibration", targets::calibration, 2000, &mut rng);
    hostile("measure", targets::measure, 60, &mut rng);
}

/// Flips, copies, cuts and inserts bytes.
fn mutate(seed: &[u8], rng: &mut Pcg64) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..rng.random_range(1..8) {
        if bytes.is_empty() {
            break;
        }
        let at = rng.random_range(0..bytes.len());
        match rng.random_range(0..5) {
            0 => bytes[at] ^= 1 << rng.random_range(0..8),
            1 => bytes[at] = rng.random(),
            2 => bytes.truncate(at),
            3 => bytes.insert(at, rng.random()),
            _ => {
                let end = (at + rng.random_range(1..16)).min(bytes.len());
                let part = bytes[at..end].to_vec();
                let to = rng.random_range(0..bytes.len());
                bytes.splice(to..to, part);
            }
        }
    }
    bytes
}

/// One body over its seeds and damaged copies of each.
fn hostile(name: &str, body: impl Fn(&[u8]) -> bool, copies: usize, rng: &mut Pcg64) {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds").join(name);
    let mut seeds: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    seeds.sort();
    let (mut taken, mut refused) = (0, 0);
    for path in seeds {
        println!("{}", path.display());
        let seed = std::fs::read(path).unwrap();
        body(&seed);
        for _ in 0..copies {
            let count = if body(&mutate(&seed, rng)) { &mut taken } else { &mut refused };
            *count += 1;
        }
    }
    println!("{name}: {taken} taken, {refused} refused");
    assert!(taken > 20 && refused > 20, "{name}: {taken} taken, {refused} refused");
}

fn measured(gauge: &Gauge, rng: &mut Pcg64) {
    let sizes = [(1, 1), (2048, 2048), (1200, 3000), (3000, 600), (64, 65_535), (65_535, 64), (400, 512)];
    for (rows, columns) in sizes {
        for kind in 0..5 {
            let pixels = if kind == 4 { shaft(rng, rows, columns) } else { noise(rng, rows * columns, kind) };
            let view =
                FrameView::new(Pixels::U8(&pixels), PixelFormat::Mono8, rows, columns, columns).unwrap();
            let (result, most) = peak(|| gauge.edges(&view).map(|e| e.valid()));
            let limit = 2 * pixels.len() + TABLES + if rows < 300 { A_COLUMN * columns } else { 0 };
            let told = result.as_ref().map_or_else(ToString::to_string, |n| format!("{n} columns"));
            println!("{rows} x {columns}, kind {kind}: {most} bytes of {limit}: {told}");
            assert!(most <= limit, "{rows} x {columns}, kind {kind}: {most} bytes, limit {limit}");
            assert_eq!(result.is_ok_and(|n| n > 0), kind == 4 && rows > 1, "{rows} x {columns}, kind {kind}");
        }
    }
}

/// A stream retains no more memory once tables and buffers are allocated.
fn followed(gauge: &Gauge, rng: &mut Pcg64) {
    let frames: Vec<Vec<u8>> = (0..4).map(|_| shaft(rng, 600, 1024)).collect();
    let (mut stream, mut edges) = (gauge.stream(), FrameEdges::default());
    for (index, pixels) in frames.iter().cycle().take(16).enumerate() {
        let view = FrameView::new(Pixels::U8(pixels), PixelFormat::Mono8, 600, 1024, 1024).unwrap();
        let (result, most) = peak(|| stream.measure(&view, &mut edges));
        assert!(result.is_ok());
        if index > 7 {
            println!("frame {index} of a stream: {most} bytes");
            assert!(most < 64 << 10, "frame {index}: {most} bytes");
        }
    }
}

fn decoded(rng: &mut Pcg64) {
    let (rows, columns) = (900_u32, 1300_u32);
    let grey =
        image::GrayImage::from_raw(columns, rows, shaft(rng, rows as usize, columns as usize)).unwrap();
    let deep = image::ImageBuffer::from_fn(columns, rows, |x, y| {
        image::Luma([16 * u16::from(grey.get_pixel(x, y)[0])])
    });
    let colour = image::DynamicImage::ImageLuma8(grey.clone()).to_rgb16();
    let pictures = [
        (image::DynamicImage::ImageLuma8(grey), 1, 1),
        (image::DynamicImage::ImageLuma16(deep), 2, 1),
        // Three channels, unpacked before they are combined into one frame.
        (image::DynamicImage::ImageRgb16(colour), 2, 3),
    ];
    use image::ImageFormat::{Bmp, Jpeg, Png, Pnm, Tiff};
    for (picture, bytes_each, channels) in &pictures {
        for format in [Png, Tiff, Bmp, Pnm, Jpeg] {
            let mut bytes = Cursor::new(Vec::new());
            if picture.write_to(&mut bytes, format).is_err() {
                continue;
            }
            let bytes = bytes.into_inner();
            let whole = (rows * columns) as usize * bytes_each;
            for cut in [bytes.len(), bytes.len() / 2] {
                let mut seen = bytes[..cut].to_vec();
                for damage in 0..4 {
                    let (result, most) = peak(|| decode(&seen, None, FrameMeta::default()));
                    let frame = result.as_ref().map_or(whole, bytes_of);
                    let limit = (1 + channels) * frame + DECODER;
                    let told = result.as_ref().map_or_else(ToString::to_string, |_| "a frame".to_owned());
                    println!("{format:?}, {cut} bytes, damage {damage}: {most} bytes of {limit}: {told}");
                    assert!(
                        most <= limit,
                        "{format:?}, {cut} bytes, damage {damage}: {most}, limit {limit}: {told}"
                    );
                    let at = rng.random_range(0..seen.len().min(2000));
                    seen[at] = rng.random();
                }
            }
        }
    }
}

fn bytes_of(frame: &Frame) -> usize {
    let each = match frame.clone().into_buffer() {
        Buffer::U8(_) => 1,
        Buffer::U16(_) => 2,
        Buffer::F32(_) => 4,
    };
    frame.view().rows() * frame.view().columns() * each
}
