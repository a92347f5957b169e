//! The library gives what the command line prints: 200 frames of a source of one's own, measured by
//! the public types and, as files, by the program, give the same bytes of JSON.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use std::path::Path;

use drawn_frames::{COLUMNS, DrawnFrames, ROWS, UM_PER_PX, counts, width_px};
use shadowgauge::frame::{FrameMeta, FrameSource, FrameView, PixelFormat, Pixels};
use shadowgauge::gauge::calibration::Conditions;
use shadowgauge::gauge::ring::RingSettings;
use shadowgauge::gauge::{Calibration, Gauge, GaugeSettings};
use shadowgauge::measurement::{Document, MeasureError, MeasureSettings, Measurement, Stream, Verdict, ring};
use shadowgauge::profile::Reason;

#[path = "support/drawn_frames.rs"]
mod drawn_frames;
#[path = "support/program.rs"]
mod program;

/// The frames of the source as files.
fn write(folder: &Path) {
    let mut source = DrawnFrames::default();
    while let Some(frame) = source.next_frame().unwrap() {
        let pixels = counts(frame.meta.frame_id);
        let image = image::GrayImage::from_raw(COLUMNS as u32, ROWS as u32, pixels).unwrap();
        image.save(folder.join(format!("{:06}.png", frame.meta.frame_id))).unwrap();
    }
}

/// The document of the library, and the frames in it.
fn measured(mut stream: Stream) -> (String, Vec<Measurement>) {
    let (mut source, mut frames) = (DrawnFrames::default(), Vec::new());
    while let Some(frame) = source.next_frame().unwrap() {
        frames.push(stream.push(&frame.meta, &frame.view()).unwrap().clone());
        source.recycle(frame);
    }
    let series = stream.finish().unwrap();
    (serde_json::to_string(&Document { frames: &frames, series: &series, bench: None }).unwrap(), frames)
}

fn gauge() -> Gauge {
    Gauge::new(GaugeSettings::default()).unwrap()
}

#[test]
fn two_hundred_frames_give_the_bytes_of_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path());
    let input = folder.path().to_string_lossy().into_owned();
    let scale = UM_PER_PX.to_string();
    let calibration = Calibration::from_scale(UM_PER_PX);
    let in_mm = |settings| Stream::calibrated(&gauge(), &calibration, settings).unwrap();
    let tolerance = Some("0.6 ±0.05".parse().unwrap());
    let turn = MeasureSettings {
        turn: true,
        angle_step_deg: Some(1.8),
        station_mm: Some(0.5),
        turn_limit_um: 90.0,
        // The shadow grows from frame to frame, and the turn closes with a step.
        cutoff_upr: 8.0,
        ..MeasureSettings::default()
    };
    let judged = MeasureSettings { tolerance, budget: true, ..MeasureSettings::default() };
    let cases: [(Stream, &[&str]); 4] = [
        (Stream::in_pixels(&gauge(), MeasureSettings::default()).unwrap(), &[]),
        (in_mm(MeasureSettings::default()), &["--um-per-px", &scale]),
        (in_mm(judged), &["--um-per-px", &scale, "--tolerance", "0.6 ±0.05", "--budget"]),
        (
            in_mm(turn),
            &[
                "--um-per-px",
                &scale,
                "--turn",
                "--angle-step",
                "1.8",
                "--station-mm",
                "0.5",
                "--turn-limit-um",
                "90",
                "--cutoff-upr",
                "8",
            ],
        ),
    ];
    for (stream, arguments) in cases {
        let output = program::shadowgauge([&["measure", &input, "--json"], arguments].concat());
        let (document, frames) = measured(stream);
        assert_eq!(frames.len(), 200);
        assert!(document == program::text(&output.stdout).trim_end(), "{arguments:?}: {document}");
        // The shadow is measured, not only the same thing twice: a logistic edge leaves a Gaussian
        // model within a tenth of a pixel.
        for frame in &frames {
            let off_px = frame.largest.unwrap().diameter_px - width_px(frame.frame_id);
            assert!(off_px.abs() < 0.2, "{}: {off_px} px", frame.frame);
        }
    }
}

#[test]
fn one_frame_is_measured_by_itself() {
    let pixels = counts(7);
    let view = FrameView::new(Pixels::U8(&pixels), PixelFormat::Mono8, ROWS, COLUMNS, COLUMNS).unwrap();
    let (calibration, conditions) = (Calibration::from_scale(UM_PER_PX), Conditions::default());
    let alone = gauge().measure(&view, &calibration, &conditions).unwrap();
    let largest = alone.diameter.unwrap();
    assert!((largest.diameter.d_mm - 1e-3 * UM_PER_PX * width_px(7)).abs() < 0.004, "{largest:?}");
    assert!(largest.u_mm > 0.0 && largest.expanded_u_mm > 1.9 * largest.u_mm, "{largest:?}");
    assert_eq!((alone.judgement, &alone.budget), (Verdict::NotJudged, &None));

    let tolerance = Some("0.3 ±0.01".parse().unwrap());
    let settings = MeasureSettings { tolerance, budget: true, ..MeasureSettings::default() };
    let judged = gauge().measure_by(&view, &calibration, &conditions, settings).unwrap();
    assert_eq!(judged.diameter, alone.diameter);
    assert!(judged.judgement.judgement().is_some() && judged.budget.is_some());

    let empty = vec![200; ROWS * COLUMNS];
    let view = FrameView::new(Pixels::U8(&empty), PixelFormat::Mono8, ROWS, COLUMNS, COLUMNS).unwrap();
    let error = gauge().measure(&view, &calibration, &conditions).unwrap_err();
    assert!(matches!(&error, MeasureError::Refused { .. }) && !error.is_of_settings(), "{error}");
}

/// A disc seen end-on, by the public names alone.
#[test]
fn a_disc_is_measured_by_itself() {
    const SIZE: usize = 128;
    let diameter_px = 80.6;
    let grey = |i: usize| {
        let off = |k: usize, middle: f64| k as f64 - middle;
        let outside_px = off(i / SIZE, 63.7).hypot(off(i % SIZE, 63.2)) - 0.5 * diameter_px;
        (18.0 + 196.0 / (1.0 + (-outside_px / 0.56).exp())).round() as u8
    };
    let pixels: Vec<u8> = (0..SIZE * SIZE).map(grey).collect();
    let view = FrameView::new(Pixels::U8(&pixels), PixelFormat::Mono8, SIZE, SIZE, SIZE).unwrap();
    let calibration = Calibration::from_scale(UM_PER_PX);
    let of = Some((&calibration, &Conditions::default()));
    let ring = ring::measure(&view, &RingSettings::default(), of).unwrap();
    // A logistic edge leaves a Gaussian model within a tenth of a pixel.
    assert!((ring.outer.diameter_px - diameter_px).abs() < 0.2, "{:?}", ring.outer.diameter_px);
    let mm = ring.outer.mm.unwrap();
    assert!(
        (mm.diameter_mm - 1e-3 * UM_PER_PX * ring.outer.diameter_px).abs() < 1e-9 && ring.inner.is_none()
    );
}

/// A frame without a part, and one that its source could not deliver, are gaps of the series.
#[test]
fn refused_frames_are_gaps_of_a_stream() {
    let tolerance = Some("0.56 ±0.05".parse().unwrap());
    let settings = MeasureSettings { tolerance, ..MeasureSettings::default() };
    let mut stream = Stream::calibrated(&gauge(), &Calibration::from_scale(UM_PER_PX), settings).unwrap();
    let empty = vec![200; ROWS * COLUMNS];
    let view = FrameView::new(Pixels::U8(&empty), PixelFormat::Mono8, ROWS, COLUMNS, COLUMNS).unwrap();
    assert!(stream.push(&FrameMeta::default(), &view).is_err());
    let refused = stream.measurement();
    assert_eq!((refused.valid, refused.judgement), (0, Verdict::NotProven));
    let reason = refused.refusal.as_ref().unwrap().reason;
    assert_eq!(refused.flags.of(reason), COLUMNS);
    let lost = stream.push_unreadable("lost", "the cable was pulled".to_owned());
    assert_eq!(lost.flags.of(Reason::Unreadable), 1);
    assert!(!stream.finish().unwrap().all_good());
}

#[test]
fn settings_that_cannot_be_right_are_refused() {
    let calibration = Calibration::from_scale(UM_PER_PX);
    let refused =
        |settings| Stream::calibrated(&gauge(), &calibration, settings).err().map(|e| e.to_string());
    let of = MeasureSettings::default;
    assert_eq!(refused(of()), None);
    let tolerance = Some("1 ±0.1".parse().unwrap());
    for (settings, word) in [
        (MeasureSettings { station_mm: Some(-1.0), ..of() }, "measure.station_mm"),
        (MeasureSettings { tolerance: Some("1 ±0.1 (GN)".parse().unwrap()), ..of() }, "--turn"),
        (MeasureSettings { tolerance, conformance_probability: 2.0, ..of() }, "conformance probability"),
        (MeasureSettings { cutoff_upr: f64::NAN, ..of() }, "cutoff"),
    ] {
        let error = refused(settings).unwrap();
        assert!(error.contains(word), "{error}");
    }
    let in_pixels = Stream::in_pixels(&gauge(), MeasureSettings { turn: true, ..of() });
    assert!(matches!(in_pixels.err(), Some(MeasureError::NeedsScale { setting: "turn" })));
    let text = serde_json::to_string(&of()).unwrap();
    assert_eq!(serde_json::from_str::<MeasureSettings>(&text).unwrap(), of());
}
