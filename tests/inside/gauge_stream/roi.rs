//! Two windows of 32 rows around the edges, read out as one frame: the same edges as in the whole
//! frame.

use shadowgauge::frame::{Buffer, Frame, FrameMeta, PixelFormat};
use shadowgauge::gauge::{FrameEdges, Gauge, GaugeSettings};

use crate::inside::gauge_stream::gauge_synth::Synth;

/// Edges that stay as far from the borders of a window of 32 rows as a fit reaches.
fn near_the_windows_middles(column: usize) -> (f64, f64) {
    (64.3 + 0.0021 * column as f64, 327.7 - 0.0019 * column as f64)
}

/// Rows `top..top + 32` and `bottom..bottom + 32` of a frame, one below the other.
fn windows(frame: &Frame, top: usize, bottom: usize) -> Frame {
    let columns = frame.view().columns();
    let Buffer::U8(pixels) = frame.clone().into_buffer() else { panic!("8 bit") };
    let rows = |from: usize| &pixels[from * columns..(from + 32) * columns];
    let stacked = [rows(top), rows(bottom)].concat();
    Frame::new(Buffer::U8(stacked), PixelFormat::Mono8, 64, columns, FrameMeta::default()).unwrap()
}

#[test]
fn two_windows_read_out_together_give_the_edges_of_the_whole_frame() {
    let synth = Synth { rows: 400, ..crate::inside::gauge_stream::reference() };
    let gauge = Gauge::new(GaugeSettings::default()).unwrap();
    let mut stream = gauge.stream();
    let mut found = FrameEdges::default();
    for seed in 0..4 {
        let whole = synth.frame(near_the_windows_middles, Some(seed));
        let (top, bottom) = (50, 310);
        let frame = windows(&whole, top, bottom);
        stream.measure(&frame.view(), &mut found).unwrap();
        found.place_windows(top as f64, bottom as f64 - 32.0);
        let expected = gauge.edges(&whole.view()).unwrap();
        let why = |c: &usize| found.top[*c].reason().or(found.bottom[*c].reason());
        let gaps: Vec<_> = (0..2048).filter(|c| why(c).is_some()).map(|c| (c, why(&c))).collect();
        assert!(found.valid() >= 2030, "{}: {:?}", found.valid(), &gaps[..gaps.len().min(8)]);
        for column in 0..2048 {
            let (Some(a), Some(b)) = (found.width_px(column), expected.width_px(column)) else { continue };
            let u = expected.top[column].u_px().hypot(expected.bottom[column].u_px());
            assert!((a - b).abs() < 0.5 * u, "column {column}: {a} {b}");
        }
    }
}

/// `cargo test --release --lib gauge_stream
/// frames_a_second -- --ignored --nocapture --test-threads 1`
#[test]
#[ignore = "a measurement of speed"]
fn frames_a_second_of_two_windows() {
    let synth = Synth { rows: 400, ..crate::inside::gauge_stream::reference() };
    let frames: Vec<Frame> =
        (0..4).map(|seed| windows(&synth.frame(near_the_windows_middles, Some(seed)), 50, 310)).collect();
    let mut stream = Gauge::new(GaugeSettings::default()).unwrap().stream();
    let mut found = FrameEdges::default();
    let mut times: Vec<f64> = frames
        .iter()
        .cycle()
        .take(4000)
        .map(|frame| {
            let start = std::time::Instant::now();
            stream.measure(&frame.view(), &mut found).unwrap();
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    let at = |share: f64| times[(share * times.len() as f64) as usize];
    println!(
        "2 x 32 rows x 2048 columns: {:.0} frames/s (median), least {:.3} ms, median {:.3} ms, 99 % below {:.3} ms",
        1.0 / at(0.5),
        1e3 * times[0],
        1e3 * at(0.5),
        1e3 * at(0.99)
    );
}
