//! Readings of a line camera, one column each; and the rings of laser light, modelled, clipped or
//! neither.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use crate::inside::support::gauge_synth;

use gauge_synth::{Synth, drifting};
use shadowgauge::frame::{Buffer, Frame, FrameMeta, FrameView};
use shadowgauge::gauge::{EsfModel, FrameEdges, Gauge, GaugeSettings, SettledStream};
use shadowgauge::job::sampled_edge;
use shadowgauge::render::esf_families::LaserShadow;

/// Edges of a part that moves by whole and fractional pixels from reading to reading.
fn place(reading: usize) -> (f64, f64) {
    let by = 2.5 * (0.37 * reading as f64).sin() + 0.8 * (1.91 * reading as f64).cos();
    (30.3 + by, 80.7 + by)
}

/// Readings as frames of one column.
fn readings(synth: &Synth, count: usize) -> Vec<Frame> {
    let synth = Synth { columns: 1, ..synth.clone() };
    (0..count).map(|k| synth.frame(|_| place(k), Some(k as u64))).collect()
}

/// Error of the width over its stated standard uncertainty.
fn normalised(edges: &FrameEdges, truth: (f64, f64)) -> f64 {
    let (top, bottom) = (&edges.top[0], &edges.bottom[0]);
    assert_eq!(edges.columns(), 1);
    let width = edges.width_px(0).expect("both edges");
    (width - (truth.1 - truth.0)) / top.u_px().hypot(bottom.u_px())
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

#[test]
fn one_reading_by_itself_is_measured() {
    let synth = Synth::with_snr(1.1, 60.0, true);
    let gauge = Gauge::new(GaugeSettings::default()).unwrap();
    let errors: Vec<f64> = readings(&synth, 200)
        .iter()
        .enumerate()
        .map(|(k, frame)| normalised(&gauge.edges(&frame.view()).unwrap(), place(k)))
        .collect();
    // Levels, noise and blur from one column alone: u is correct to a quarter.
    let rms = rms(&errors);
    println!("single readings: rms error/u {rms:.3}");
    assert!((0.75..1.25).contains(&rms), "{rms}");
}

#[test]
fn readings_of_a_stream_reach_the_bound() {
    let synth = Synth::with_snr(1.1, 60.0, true);
    let mut stream = Gauge::new(GaugeSettings::default()).unwrap().stream();
    let mut edges = FrameEdges::default();
    let (mut errors, mut widths) = (Vec::new(), Vec::new());
    for (k, frame) in readings(&synth, 600).iter().enumerate() {
        stream.measure(&frame.view(), &mut edges).unwrap();
        if k >= 32 {
            errors.push(normalised(&edges, place(k)));
            widths.push(edges.width_px(0).unwrap() - (place(k).1 - place(k).0));
        }
    }
    let (rms_error, scatter) = (rms(&errors), rms(&widths));
    let bound = 2.0_f64.sqrt() * synth.bound(0.25);
    println!("stream: rms error/u {rms_error:.3}, repeatability {scatter:.5} px, bound {bound:.5} px");
    assert!((0.88..1.12).contains(&rms_error), "{rms_error}");
    assert!(scatter < 1.15 * bound, "{scatter} {bound}");
}

#[test]
fn seven_columns_are_readings_too() {
    let synth = Synth { columns: 7, ..Synth::with_snr(1.1, 60.0, true) };
    let gauge = Gauge::new(GaugeSettings::default()).unwrap();
    let edges = gauge.edges(&synth.frame(drifting, Some(3)).view()).unwrap();
    assert_eq!((edges.columns(), edges.valid()), (7, 7));
}

#[test]
fn a_block_of_readings_is_a_frame() {
    // As from a line camera: one line of pixels after the other.
    let synth = Synth::with_snr(1.1, 60.0, true);
    let frames = readings(&synth, 256);
    let mut lines = Vec::new();
    for frame in &frames {
        let Buffer::U16(pixels) = frame.clone().into_buffer() else { panic!("16 bits") };
        lines.extend(pixels);
    }
    let block = Frame::new(Buffer::U16(lines), synth.format, 256, synth.rows, FrameMeta::default()).unwrap();
    let settings = GaugeSettings { outlier_px: 1e3, max_slope: 3.0, ..GaugeSettings::default() };
    let mut stream = Gauge::new(settings).unwrap().stream();
    let view: FrameView<'_> = block.view().transposed();
    let mut edges = FrameEdges::default();
    stream.measure(&view, &mut edges).unwrap();
    assert!(edges.valid() > 250, "{}", edges.valid());
    let start = std::time::Instant::now();
    for _ in 0..40 {
        stream.measure(&view, &mut edges).unwrap();
    }
    let per_s = 40.0 * 512.0 / start.elapsed().as_secs_f64();
    println!("blocks of 256 readings: {per_s:.0} edges/s, {:.1} kHz readings", per_s / 2e3);
}

const UNIT_UM: f64 = 90.14;

/// Light on a pixel of `pitch_um` whose centre lies `d_px` on the light side, laser light at 25 mm.
fn laser_step(pitch_um: f64) -> impl Fn(f64) -> f64 {
    let laser =
        LaserShadow { wavelength_nm: 650.0, bandwidth_nm: 3.0, distance_mm: 25.0, ..LaserShadow::default() };
    assert!((laser.unit_um() - UNIT_UM).abs() < 0.01);
    let spread = laser.edge_spread().unwrap();
    move |d_px| {
        let at = |k: u32| spread.value(pitch_um * (d_px - 0.5 + (f64::from(k) + 0.5) / 16.0));
        (0..16).map(at).sum::<f64>() / 16.0
    }
}

/// The same edge as a model for the gauge.
fn laser_model(pitch_um: f64) -> EsfModel {
    let spread =
        LaserShadow { wavelength_nm: 650.0, bandwidth_nm: 3.0, distance_mm: 25.0, ..LaserShadow::default() }
            .edge_spread()
            .unwrap();
    let (from, to) = spread.range_um();
    sampled_edge(from / pitch_um, to / pitch_um, |d_px| spread.value(d_px * pitch_um))
}

#[test]
fn rings_are_known_or_refused() {
    let mut measured = 0;
    for pitch_um in [3.45, 5.5, 7.0, 10.0, 14.0] {
        let step = laser_step(pitch_um);
        let (margin, width) = (1400.0 / pitch_um, 2000.0 / pitch_um);
        let rows = (2.0 * margin + width) as usize;
        let edge =
            |column: usize| (margin + 0.31 + 0.02 * column as f64, margin + width + 0.02 * column as f64);
        for light in [2600.0, 3050.0, 3500.0, 4000.0, 6000.0] {
            let synth = Synth { rows, columns: 64, light, dark: 110.0, ..Synth::with_snr(1.0, 150.0, true) };
            let clipped = 110.0 + 1.37 * (light - 110.0) > 4095.0;
            let frame = synth.frame_of(edge, &step, Some(7));
            for (name, esf) in [("table", laser_model(pitch_um)), ("gaussian", EsfModel::Gaussian {})] {
                let gauge = Gauge::new(GaugeSettings { esf, ..GaugeSettings::default() }).unwrap();
                match gauge.edges(&frame.view()) {
                    Err(refused) => {
                        println!("{pitch_um} um, light {light}, {name}: {refused}");
                        assert!(name == "gaussian" || clipped, "{pitch_um} um, light {light}: {refused}");
                    }
                    Ok(edges) => {
                        let both: Vec<usize> = (0..64).filter(|c| edges.width_px(*c).is_some()).collect();
                        let mean = |f: &dyn Fn(usize) -> f64| {
                            both.iter().map(|c| f(*c)).sum::<f64>() / both.len() as f64
                        };
                        let off = mean(&|c| edges.width_px(c).unwrap() - (edge(c).1 - edge(c).0));
                        let u = mean(&|c| edges.top[c].u_px().hypot(edges.bottom[c].u_px()));
                        println!(
                            "{pitch_um} um, light {light}, {name}: off {off:.4} px, u of a column {u:.4} px"
                        );
                        let most = if name == "table" { 0.05 } else { 3.0 * u };
                        assert!(off.abs() < most, "{pitch_um} um, light {light}, {name}: {off} px, u {u}");
                        measured += usize::from(name == "table");
                    }
                }
            }
        }
    }
    assert!(measured >= 5, "{measured}");
}

/// Readings of a laser's shadow, at whole and parts of pixels.
fn laser_readings(count: usize, seed: u64) -> (Vec<Frame>, impl Fn(usize) -> (f64, f64)) {
    let pitch_um = 7.0;
    let step = laser_step(pitch_um);
    let (margin, width) = (2000.0 / pitch_um, 5000.0 / pitch_um);
    let rows = (2.0 * margin + width) as usize;
    let edge = move |k: usize| {
        let by = 2.5 * (0.37 * k as f64).sin() + 0.8 * (1.91 * k as f64).cos();
        (margin + 0.31 + by, margin + width + by)
    };
    let synth = Synth { rows, columns: 1, light: 2700.0, dark: 110.0, ..Synth::with_snr(1.0, 80.0, true) };
    let frames =
        (0..count).map(|k| synth.frame_of(|_| edge(k), &step, Some(1000 * seed + k as u64))).collect();
    (frames, edge)
}

/// Rms error in px, rms stated u in px and rms of error over u.
fn figures(errors: &[(f64, f64)]) -> (f64, f64, f64) {
    let of = |f: &dyn Fn(&(f64, f64)) -> f64| rms(&errors.iter().map(f).collect::<Vec<_>>());
    (of(&|e| e.0), of(&|e| e.1), of(&|e| e.0 / e.1))
}

/// Error and stated u of a reading's width, px.
fn error_of(edges: &FrameEdges, truth: (f64, f64)) -> (f64, f64) {
    let u = edges.top[0].u_px().hypot(edges.bottom[0].u_px());
    (edges.width_px(0).unwrap() - (truth.1 - truth.0), u)
}

#[test]
fn first_readings_of_laser_light_are_settled_with_those_that_follow() {
    let settings = GaugeSettings { esf: laser_model(7.0), ..GaugeSettings::default() };
    let gauge = Gauge::new(settings).unwrap();
    let (mut at_once, mut first, mut later) = (Vec::new(), Vec::new(), Vec::new());
    for seed in 0..12 {
        let (frames, place) = laser_readings(96, seed);
        let mut stream = SettledStream::new(gauge.stream());
        let (mut edges, mut given) = (FrameEdges::default(), Vec::new());
        for (k, frame) in frames.iter().enumerate() {
            stream
                .measure(&frame.view(), &mut edges, k, |k, settled| given.push((k, settled.clone())))
                .unwrap();
            if k < 16 {
                at_once.push(error_of(&edges, place(k)));
            }
        }
        stream.finish(|k, settled| given.push((k, settled.clone())));
        assert!(given.iter().map(|g| g.0).eq(0..96), "every reading once, in its order");
        first.extend(given[..32].iter().map(|(k, settled)| error_of(settled, place(*k))));
        later.extend(given[32..].iter().map(|(k, settled)| error_of(settled, place(*k))));
    }
    for (name, errors) in [("first 16 at once", &at_once), ("first 32 settled", &first), ("later", &later)] {
        let (error, u, ratio) = figures(errors);
        println!("{name}: rms error {error:.4} px, u {u:.4} px, rms error/u {ratio:.3}");
        assert!((0.75..1.2).contains(&ratio), "{name}: {ratio}");
    }
    let (settled, following) = (figures(&first).0, figures(&later).0);
    assert!(settled < 1.15 * following, "{settled} {following}");
}

#[test]
fn fewer_readings_than_a_picture_has_are_given_in_the_end() {
    let (frames, place) = laser_readings(10, 5);
    let settings = GaugeSettings { esf: laser_model(7.0), ..GaugeSettings::default() };
    let mut stream = SettledStream::new(Gauge::new(settings).unwrap().stream());
    let (mut edges, mut given) = (FrameEdges::default(), Vec::new());
    for (k, frame) in frames.iter().enumerate() {
        stream.measure(&frame.view(), &mut edges, k, |k, _| given.push((k, f64::NAN))).unwrap();
    }
    assert!(given.is_empty());
    stream.finish(|k, settled| given.push((k, error_of(settled, place(k)).0)));
    assert!(given.iter().map(|g| g.0).eq(0..10));
    assert!(given.iter().all(|g| g.1.abs() < 0.25), "{given:?}");
}
