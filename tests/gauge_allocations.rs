//! A stream does not allocate after its warm-up: not for a frame that it follows, nor when it
//! searches the part anew, nor for contamination; neither where it measures the largest diameter,
//! nor where it gives millimetres, stations, averages and judgements by a calibration.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

#[path = "support/gauge_synth.rs"]
mod gauge_synth;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use gauge_synth::{Synth, drifting};
use shadowgauge::frame::Frame;
use shadowgauge::gauge::{
    Averaging, Calibration, FrameEdges, Gauge, GaugeSettings, MasterCertificate, MasterMeasurement,
};
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
            let film = |c: usize| if k % 3 == 2 && (300..360).contains(&c) { 3.0 } else { 0.0 };
            synth.frame(|c| (drifting(c).0 + by - film(c), drifting(c).1 + by), Some(u64::from(k)))
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

/// A calibration by two pins, 5 µm a pixel.
fn by_two_pins(gauge: &Gauge) -> Calibration {
    let pin = |width_px: f64| {
        let synth = Synth { columns: 1024, ..Synth::with_snr(1.0, 80.0, true) };
        let edges = (0..4).map(|k| {
            let top = |c: usize| drifting(c).0 + 0.25 * k as f64;
            gauge.edges(&synth.frame(|c| (top(c), top(c) + width_px), Some(100 + k)).view()).unwrap()
        });
        let diameter_mm = 5e-3 * width_px;
        let certificate = MasterCertificate { diameter_mm, expanded_u_mm: 2e-4, coverage_factor: 2.0 };
        MasterMeasurement { certificate, frames: edges.collect() }
    };
    Calibration::fit(&[pin(50.0), pin(72.0)]).unwrap()
}

/// The same with everything that a calibrated series gives of a frame but a text: millimetres with
/// their uncertainty, stations or an average of the frames, judgement.
fn requests_of_diameters(
    calibration: &Calibration,
    average: Averaging,
    frames: &[Frame],
    count: usize,
) -> usize {
    let gauge = Gauge::new(GaugeSettings::default()).unwrap();
    let (columns, rows) = (frames[0].view().columns(), frames[0].view().rows());
    assert!(columns == 1024 && rows > 100);
    let settings = MeasureSettings {
        tolerance: Some("0.33 +0.1/-0.1".parse().unwrap()),
        // Stations of single frames and averages of frames exclude each other.
        station_mm: (average == Averaging::Off).then_some(0.5),
        average,
        ..MeasureSettings::default()
    };
    let mut stream = Stream::calibrated(&gauge, calibration, settings).unwrap();
    let mut before = 0;
    for (index, frame) in frames.iter().cycle().take(30 + count).enumerate() {
        if index == 30 {
            before = REQUESTS.load(Ordering::Relaxed);
        }
        let measured = stream.push(&frame.meta, &frame.view()).unwrap();
        assert!(measured.diameter.is_some() && measured.judged.is_some());
        let stations = measured.stations.as_ref().is_some_and(|stations| stations.len() > 5);
        assert!(stations != measured.average.is_some());
    }
    REQUESTS.load(Ordering::Relaxed) - before
}

#[test]
fn a_warm_stream_allocates_nothing() {
    let frames = frames();
    let calibration = by_two_pins(&Gauge::new(GaugeSettings::default()).unwrap());
    // Beyond the frames after which the part is searched anew.
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (requests, gaps) = pool.install(|| requests(&frames, 600));
        assert!(gaps > 2000, "the film is refused: {gaps} columns");
        assert_eq!(requests, 0, "{threads} threads");
        let (requests, gaps) = pool.install(|| requests_of_measurements(&frames, 60));
        assert!(gaps > 200, "the film is refused: {gaps} columns");
        assert_eq!(requests, 0, "measurements, {threads} threads");
        for calibration in [&calibration, &Calibration::from_scale(5.0)] {
            for average in [Averaging::Off, Averaging::Median { readings: 5 }] {
                let requests = pool.install(|| requests_of_diameters(calibration, average, &frames, 60));
                assert_eq!(requests, 0, "diameters, {threads} threads, {average:?}");
            }
        }
    }
    // The counter works: a vector is counted.
    let before = REQUESTS.load(Ordering::Relaxed);
    drop(std::hint::black_box(vec![1_u8; 100]));
    assert_eq!(REQUESTS.load(Ordering::Relaxed), before + 1);
}
