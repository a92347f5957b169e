//! What every input must hold: the bodies of the fuzz targets, which a plain test runs as well (tests/allocation.rs). A panic is a
//! finding.
#![allow(dead_code, reason = "each target runs one of them")]

use peak_alloc::PeakAlloc;
use rand::{SeedableRng, seq::SliceRandom};
use rand_pcg::Pcg64;
use shadowgauge::frame::{FrameMeta, FrameView, PixelFormat, Pixels};
use shadowgauge::gauge::{Calibration, Gauge, GaugeSettings, Polarity};

#[global_allocator]
pub static HEAP: PeakAlloc = PeakAlloc;

/// Tables and scratch of the gauge that no frame's size changes, bytes.
pub const TABLES: usize = 3 << 20;
/// A column's edges and the windows around them, bytes, whatever the number of rows: more than the frame where there are few.
pub const A_COLUMN: usize = 640;
/// Scratch of a decoder, bytes.
pub const DECODER: usize = 512 << 10;

/// What `run` gives and the most bytes it held at once beyond those held before.
pub fn peak<T>(run: impl FnOnce() -> T) -> (T, usize) {
    HEAP.reset_peak_usage();
    let before = HEAP.current_usage();
    let done = run();
    (done, HEAP.peak_usage().saturating_sub(before))
}

/// Image bytes: a frame of sane size within its own memory and that of the file's samples (twice its memory where these are one
/// channel of its own depth), or an error that says something. Whether it is a frame.
pub fn decode(bytes: &[u8]) -> bool {
    let wanted = shadowgauge::source::Wanted::default();
    let (decoded, most) = peak(|| shadowgauge::source::decode_wanted(bytes, &wanted, FrameMeta::default()));
    match decoded {
        Ok(decoded) => {
            let view = decoded.frame.view();
            assert!(view.rows() <= 65_535 && view.columns() <= 65_535);
            let each = usize::from(view.format().bit_depth().div_ceil(8));
            let frame = view.rows() * view.columns() * each;
            let limit = frame + decoded.sample_bytes.max(frame) + DECODER;
            assert!(most <= limit, "{most} bytes of {limit} for {} x {}", view.rows(), view.columns());
            true
        }
        Err(error) => {
            assert!(!error.to_string().is_empty());
            false
        }
    }
}

/// Calibration files: a finite, positive scale or an error. Whether it is a calibration.
pub fn calibration(bytes: &[u8]) -> bool {
    let Ok(calibration) = Calibration::read(bytes) else { return false };
    assert!(calibration.scale_mm_per_px.is_finite() && calibration.scale_mm_per_px > 0.0);
    true
}

fn shuffled<T: Clone>(pixels: &[T], seed: u8) -> Vec<T> {
    let mut out = pixels.to_vec();
    out.shuffle(&mut Pcg64::seed_from_u64(u64::from(seed)));
    out
}

/// Arbitrary frames: size, stride, format, orientation and polarity from the first bytes, pixels from the rest; every second one
/// with its pixels shuffled, which leaves nothing but noise. Whether edges were found.
pub fn measure(bytes: &[u8]) -> bool {
    let [rows, columns, padding, kind, pixels @ ..] = bytes else { return false };
    let (rows, columns) = (usize::from(*rows), usize::from(*columns));
    let stride = columns + usize::from(padding % 8);
    let noise = kind & 16 != 0;
    let mut octets = pixels.to_vec();
    let mut words: Vec<u16> = pixels.chunks_exact(2).map(|p| u16::from_le_bytes([p[0], p[1]])).collect();
    let mut floats: Vec<f32> =
        pixels.chunks_exact(4).map(|p| f32::from_le_bytes([p[0], p[1], p[2], p[3]])).collect();
    if noise {
        (octets, words, floats) =
            (shuffled(&octets, *padding), shuffled(&words, *padding), shuffled(&floats, *padding));
    }
    let (pixels, format, each) = match kind % 4 {
        0 => (Pixels::U8(&octets), PixelFormat::Mono8, 1),
        1 => (Pixels::U16(&words), PixelFormat::Mono12, 2),
        2 => (Pixels::U16(&words), PixelFormat::Mono16, 2),
        _ => (Pixels::F32(&floats), PixelFormat::F32, 4),
    };
    let Ok(view) = FrameView::new(pixels, format, rows, columns, stride) else { return false };
    let view = if kind & 4 == 0 { view } else { view.transposed() };
    let polarity = if kind & 8 == 0 { Polarity::DarkOnBright } else { Polarity::BrightOnDark };
    let gauge = Gauge::new(GaugeSettings { polarity, ..GaugeSettings::default() }).expect("default settings");
    let (measured, most) = peak(|| gauge.edges(&view));
    let limit = 2 * rows * columns * each + TABLES + A_COLUMN * view.columns();
    assert!(most <= limit, "{most} bytes of {limit} for {rows} x {columns}");
    let Ok(edges) = measured else { return false };
    assert_eq!(edges.columns(), view.columns());
    for column in 0..edges.columns() {
        let Some(width) = edges.width_px(column) else { continue };
        assert!(!noise, "a diameter from noise");
        assert!(width.is_finite() && width > 0.0 && width < view.rows() as f64);
        let (top, bottom) = (&edges.top[column], &edges.bottom[column]);
        assert!(
            top.u_px() > 0.0 && top.u_px().is_finite() && bottom.u_px() > 0.0 && bottom.u_px().is_finite()
        );
    }
    true
}
