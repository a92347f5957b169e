//! A stream does not allocate after its warm-up: not for a frame that it follows, nor when it
//! searches the part anew, nor for contamination; neither where it measures the largest diameter.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

#[path = "support/gauge_synth.rs"]
mod gauge_synth;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use gauge_synth::{Synth, drifting};
use shadowgauge::frame::Frame;
use shadowgauge::gauge::{FrameEdges, Gauge, GaugeSettings};
use shadowgauge::measurement::{MeasureSettings, Stream};

static REQUESTS: AtomicUsize = AtomicUsize::new(0);

struct Counting;

#[expect(unsafe_code, reason = "only a global allocator sees every request; it hands all of them on")]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        REQUESTS.fetch_add(1, Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        unsafe { System.dealloc(memory, layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        REQUESTS.fetch_add(1, Ordering::Relaxed);
        unsafe { System.realloc(memory, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Frames of a moving part, two of them with contamination 3 px high on the upper edge.
fn frames() -> Vec<Frame> {
    let synth = Synth { columns: 1024, ..Synth::with_snr(1.0, 80.0, true) };
    (0..6_u32)
        .map(|k| {
            let by = 0.3 * f64::from(k % 3);
            let matter = |c: usize| if k % 3 == 2 && (300..360).contains(&c) { 3.0 } else { 0.0 };
            synth.frame(|c| (drifting(c).0 + by - matter(c), drifting(c).1 + by), Some(u64::from(k)))
        })
        .collect()
}

/// Allocations while `count` frames are measured, after a warm-up of 30.
fn requests(frames: &[Frame], count: usize) -> (usize, usize) {
    let mut stream = Gauge::new(GaugeSettings::default()).unwrap().stream();
    let (mut edges, mut before, mut gaps) = (FrameEdges::default(), 0, 0);
    for (index, frame) in frames.iter().cycle().take(30 + count).enumerate() {
        if index == 30 {
            before = REQUESTS.load(Ordering::Relaxed);
        }
        stream.measure(&frame.view(), &mut edges).unwrap();
        gaps += edges.columns() - edges.valid();
    }
    (REQUESTS.load(Ordering::Relaxed) - before, gaps)
}

/// The same where the frames' largest diameter, flags and shadows are measured with the edges.
fn requests_of_measurements(frames: &[Frame], count: usize) -> (usize, usize) {
    let gauge = Gauge::new(GaugeSettings::default()).unwrap();
    let mut stream = Stream::in_pixels(&gauge, MeasureSettings::default()).unwrap();
    let (mut before, mut gaps) = (0, 0);
    for (index, frame) in frames.iter().cycle().take(30 + count).enumerate() {
        if index == 30 {
            before = REQUESTS.load(Ordering::Relaxed);
        }
        let measured = stream.push(&frame.meta, &frame.view()).unwrap();
        assert!(measured.largest.is_some() && measured.warnings.is_empty());
        gaps += measured.columns - measured.valid;
    }
    (REQUESTS.load(Ordering::Relaxed) - before, gaps)
}

#[test]
fn a_warm_stream_allocates_nothing() {
    let frames = frames();
    // Beyond the frames after which the part is searched anew.
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (requests, gaps) = pool.install(|| requests(&frames, 600));
        assert!(gaps > 2000, "the matter is refused: {gaps} columns");
        assert_eq!(requests, 0, "{threads} threads");
        let (requests, gaps) = pool.install(|| requests_of_measurements(&frames, 60));
        assert!(gaps > 200, "the matter is refused: {gaps} columns");
        assert_eq!(requests, 0, "measurements, {threads} threads");
    }
    // The counter works: a vector is counted.
    let before = REQUESTS.load(Ordering::Relaxed);
    drop(std::hint::black_box(vec![1_u8; 100]));
    assert_eq!(REQUESTS.load(Ordering::Relaxed), before + 1);
}
