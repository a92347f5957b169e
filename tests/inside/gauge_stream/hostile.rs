//! Hostile frames, seeded: no panic, no diameter from noise. The fuzz targets' own inputs are run
//! in tests/allocation.rs.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use shadowgauge::frame::{FrameView, PixelFormat, Pixels};
use shadowgauge::gauge::{FrameEdges, Gauge, GaugeSettings};
use shadowgauge::profile::Reason;

use crate::inside::gauge_stream::gauge_synth::{Synth, drifting};

fn gauge() -> Gauge {
    Gauge::new(GaugeSettings::default()).unwrap()
}

/// Noise of any kind and size, any format, stride and orientation: errors, or edges without any
/// accepted column.
#[test]
fn noise_of_any_kind_gives_no_diameter() {
    let mut rng = Pcg64::seed_from_u64(13);
    let gauge = gauge();
    let mut accepted = 0;
    for trial in 0..400 {
        let (rows, columns) = (rng.random_range(1..160_usize), rng.random_range(1..200_usize));
        let stride = columns + rng.random_range(0..9);
        let kind = trial % 5;
        let (low, high) = (rng.random_range(0..2000), rng.random_range(2001..4096));
        let pixels: Vec<u16> = (0..rows * stride)
            .map(|i| match kind {
                0 => rng.random_range(0..4096),
                1 => {
                    if rng.random::<bool>() {
                        low
                    } else {
                        high
                    }
                }
                2 => ((0..8).map(|_| rng.random_range(0..512_u32)).sum::<u32>()) as u16,
                3 => ((i % stride) * 20) as u16,
                _ => {
                    if rng.random_range(0..50) == 0 {
                        high
                    } else {
                        low
                    }
                }
            })
            .collect();
        let view = FrameView::new(Pixels::U16(&pixels), PixelFormat::Mono12, rows, columns, stride).unwrap();
        let view = if trial % 2 == 0 { view } else { view.transposed() };
        let mut edges = FrameEdges::default();
        if gauge.stream().measure(&view, &mut edges).is_ok() {
            accepted += 1;
            println!("trial {trial} (kind {kind}, {rows} x {columns}): {} columns", edges.valid());
        }
    }
    assert_eq!(accepted, 0);
}

/// A good stream with bad frames between: bit errors, lines out of place, frames of another size.
#[test]
fn a_stream_survives_bad_frames() {
    let synth = Synth {
        columns: 256,
        format: PixelFormat::Mono8,
        dark: 20.0,
        light: 200.0,
        read: 2.0,
        gain: 0.0,
        ..Synth::with_snr(1.0, 60.0, false)
    };
    let good = synth.frame(drifting, Some(1));
    let shadowgauge::frame::Buffer::U8(clean) = good.into_buffer() else { panic!("8 bit") };
    let mut rng = Pcg64::seed_from_u64(14);
    let mut stream = gauge().stream();
    let mut edges = FrameEdges::default();
    for trial in 0..60 {
        let mut pixels = clean.clone();
        if trial % 3 == 1 {
            let count = rng.random_range(1..30_000);
            for _ in 0..count {
                let at = rng.random_range(0..pixels.len());
                pixels[at] = rng.random();
            }
        }
        if trial % 3 == 2 {
            pixels.rotate_left(rng.random_range(0..clean.len()));
        }
        let columns = if trial % 7 == 5 { 128 } else { 256 };
        let view = FrameView::new(Pixels::U8(&pixels), PixelFormat::Mono8, 112, columns, 256).unwrap();
        let result = stream.measure(&view, &mut edges);
        if trial % 3 == 0 {
            assert!(result.is_ok() && edges.valid() >= columns - 4, "{trial}: {result:?} {}", edges.valid());
        } else if result.is_ok() {
            for column in 0..edges.columns() {
                assert!(edges.width_px(column).is_none_or(|w| w.is_finite() && w > 0.0));
            }
        }
    }
}

#[test]
fn sizes_at_the_ends_are_clear_errors() {
    let one = [9_u8];
    let view = FrameView::new(Pixels::U8(&one), PixelFormat::Mono8, 1, 1, 1).unwrap();
    assert!(gauge().edges(&view).unwrap_err().to_string().contains("1 rows x 1 columns"));
    assert!(FrameView::new(Pixels::U8(&one), PixelFormat::Mono8, 1, 1, 0).is_err());
    assert!(FrameView::new(Pixels::U8(&one), PixelFormat::Mono8, 0, 1, 1).is_err());
    let huge = FrameView::new(Pixels::U8(&one), PixelFormat::Mono8, usize::MAX, 2, usize::MAX);
    assert!(huge.unwrap_err().to_string().contains("holds 1 pixels"));
    // As wide as an image may be: flat light, then a part.
    let (rows, columns) = (64, 65_535);
    let mut pixels = vec![200_u8; rows * columns];
    let view = FrameView::new(Pixels::U8(&pixels), PixelFormat::Mono8, rows, columns, columns).unwrap();
    assert_eq!(gauge().edges(&view).unwrap_err().reason, Reason::LowContrast);
    pixels[16 * columns..48 * columns].fill(20);
    // Edges blurred by 0.8 px: a step without blur is not an image of an edge.
    for (step, grey) in [(0, 193_u8), (1, 150), (2, 70), (3, 27)] {
        pixels[(14 + step) * columns..(15 + step) * columns].fill(grey);
        pixels[(49 - step) * columns..(50 - step) * columns].fill(grey);
    }
    let view = FrameView::new(Pixels::U8(&pixels), PixelFormat::Mono8, rows, columns, columns).unwrap();
    assert!(gauge().edges(&view).unwrap().valid() > 65_000);
}
