//! Arbitrary frames: size, stride, format, orientation and polarity from the first bytes, pixels from the rest; every second one
//! with its pixels shuffled, which leaves nothing but noise.
#![no_main]

use libfuzzer_sys::fuzz_target;
use peak_alloc::PeakAlloc;
use rand::{SeedableRng, seq::SliceRandom};
use rand_pcg::Pcg64;
use shadowgauge::frame::{FrameView, PixelFormat, Pixels};
use shadowgauge::gauge::{Gauge, GaugeSettings, Polarity};

#[global_allocator]
static HEAP: PeakAlloc = PeakAlloc;

/// Tables and scratch of the gauge that no frame's size changes, as in tests/allocation.rs.
const TABLES: usize = 3 << 20;

fn shuffled<T: Clone>(pixels: &[T], seed: u8) -> Vec<T> {
    let mut out = pixels.to_vec();
    out.shuffle(&mut Pcg64::seed_from_u64(u64::from(seed)));
    out
}

fuzz_target!(|bytes: &[u8]| {
    let [rows, columns, padding, kind, pixels @ ..] = bytes else { return };
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
    let Ok(view) = FrameView::new(pixels, format, rows, columns, stride) else { return };
    let view = if kind & 4 == 0 { view } else { view.transposed() };
    let polarity = if kind & 8 == 0 { Polarity::DarkOnBright } else { Polarity::BrightOnDark };
    let Ok(gauge) = Gauge::new(GaugeSettings { polarity, ..GaugeSettings::default() }) else { return };
    HEAP.reset_peak_usage();
    let before = HEAP.current_usage();
    let measured = gauge.edges(&view);
    let most = HEAP.peak_usage().saturating_sub(before);
    assert!(most <= 2 * rows * columns * each + TABLES, "{most} bytes for {rows} x {columns}");
    let Ok(edges) = measured else { return };
    assert_eq!(edges.columns(), view.columns());
    for column in 0..edges.columns() {
        let Some(width) = edges.width_px(column) else { continue };
        assert!(!noise, "a diameter from noise");
        assert!(width.is_finite() && width > 0.0 && width < view.rows() as f64);
        let (top, bottom) = (&edges.top[column], &edges.bottom[column]);
        assert!(top.u_px() > 0.0 && top.u_px().is_finite() && bottom.u_px() > 0.0 && bottom.u_px().is_finite());
    }
});
