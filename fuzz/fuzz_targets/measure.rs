//! Arbitrary frames: size, stride, format, orientation and polarity from the first bytes, pixels from the rest.
#![no_main]

use libfuzzer_sys::fuzz_target;
use shadowgauge::frame::{FrameView, PixelFormat, Pixels};
use shadowgauge::gauge::{Gauge, GaugeSettings, Polarity};

fuzz_target!(|bytes: &[u8]| {
    let [rows, columns, padding, kind, pixels @ ..] = bytes else { return };
    let (rows, columns) = (usize::from(*rows), usize::from(*columns));
    let stride = columns + usize::from(padding % 8);
    let words: Vec<u16> = pixels.chunks_exact(2).map(|p| u16::from_le_bytes([p[0], p[1]])).collect();
    let floats: Vec<f32> = pixels.chunks_exact(4).map(|p| f32::from_le_bytes([p[0], p[1], p[2], p[3]])).collect();
    let (pixels, format) = match kind % 4 {
        0 => (Pixels::U8(pixels), PixelFormat::Mono8),
        1 => (Pixels::U16(&words), PixelFormat::Mono12),
        2 => (Pixels::U16(&words), PixelFormat::Mono16),
        _ => (Pixels::F32(&floats), PixelFormat::F32),
    };
    let Ok(view) = FrameView::new(pixels, format, rows, columns, stride) else { return };
    let view = if kind & 4 == 0 { view } else { view.transposed() };
    let polarity = if kind & 8 == 0 { Polarity::DarkOnBright } else { Polarity::BrightOnDark };
    let Ok(gauge) = Gauge::new(GaugeSettings { polarity, ..GaugeSettings::default() }) else { return };
    if let Ok(edges) = gauge.edges(&view) {
        for column in 0..edges.columns() {
            assert!(edges.width_px(column).is_none_or(|w| w.is_finite()));
        }
    }
});
