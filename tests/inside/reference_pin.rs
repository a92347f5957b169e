//! A fixed pin beside the part: a drift of magnification is taken off every frame, its noise is in
//! U, and a pin that is contaminated or gone corrects nothing.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use shadowgauge::frame::{Frame, FrameMeta};
use shadowgauge::gauge::{Calibration, Gauge, GaugeSettings};
use shadowgauge::measurement::{MeasureError, MeasureSettings, Measurement, Stream};
use shadowgauge::profile::Reason;

use super::support::gauge_synth::Synth;

const UM_PER_PX: f64 = 20.0;
/// Columns of the pin with the light behind its end, and of the whole field.
const PIN: usize = 200;
const COLUMNS: usize = 448;
/// Diameters of pin and part, mm: 50 ppm of the part are half a µm.
const PIN_MM: f64 = 9.6;
const PART_MM: f64 = 10.4;

fn stream(with_pin: bool) -> Stream {
    let gauge = Gauge::new(GaugeSettings::default()).unwrap();
    let settings = MeasureSettings { budget: true, ..MeasureSettings::default() };
    let stream = Stream::calibrated(&gauge, &Calibration::from_scale(UM_PER_PX), settings).unwrap();
    match with_pin {
        true => stream.with_reference_pin(&gauge, "0-199,9.6,0.1".parse().unwrap()).unwrap(),
        false => stream,
    }
}

/// A frame whose magnification has drifted, with another blur; `pin` draws the edges of a column of
/// the pin from those of a clean one.
fn frame(ppm: f64, sigma: f64, seed: u64, pin: impl Fn(usize, f64, f64) -> (f64, f64)) -> Frame {
    let synth = Synth { rows: 600, columns: COLUMNS, ..Synth::with_snr(sigma, 300.0, true) };
    let px = |mm: f64| 1e3 * mm * (1.0 + 1e-6 * ppm) / UM_PER_PX;
    let about = |middle: f64, mm: f64| (middle - 0.5 * px(mm), middle + 0.5 * px(mm));
    let edges = |column: usize| match column {
        // light between the end faces of both; slopes whose cosine is 1 to a millionth
        175..PIN => (300.0, 300.0),
        0..175 => {
            let (top, bottom) = about(299.4 + 0.001 * column as f64, PIN_MM);
            pin(column, top, bottom)
        }
        _ => about(300.2 - 0.001 * column as f64, PART_MM),
    };
    synth.frame(edges, Some(seed))
}

fn clean(_: usize, top: f64, bottom: f64) -> (f64, f64) {
    (top, bottom)
}

fn measured(stream: &mut Stream, frame: &Frame) -> Result<Measurement, MeasureError> {
    let meta = FrameMeta { z_mm: 100.0, ..FrameMeta::default() };
    stream.push(&meta, &frame.view()).cloned()
}

#[test]
fn a_drift_of_magnification_and_of_blur_is_taken_off_and_u_is_true() {
    let mut corrected = stream(true);
    for (ppm, seed) in [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 50.0].into_iter().zip(1..) {
        let sigma = 1.2 + 0.002 * ppm;
        let found = measured(&mut corrected, &frame(ppm, sigma, seed, clean)).unwrap();
        let mean = found.mean.unwrap();
        let off_um = 1e3 * (mean.d_mm - PART_MM);
        assert!(off_um.abs() < 0.1, "{ppm} ppm: {off_um} um off");
        assert!(off_um.abs() < 3e3 * mean.u_mm(), "{ppm} ppm: {off_um} um, u {} mm", mean.u_mm());
        // the part has the columns from 200 on: its middle lies 100 columns beside the frame's
        let rows = found.budget.unwrap().contributions;
        let u_um = |source: &str| rows.iter().find(|row| row.source == source).map(|row| 1e3 * row.u_mm);
        let stated = u_um("reference pin, its stated diameter").unwrap();
        assert!((stated - 0.05 * PART_MM / PIN_MM).abs() < 1e-3, "{stated}");
        let kind = u_um("reference pin, drift of scale or of edges").unwrap();
        assert!((kind - ppm * 1e-3 * (PART_MM - PIN_MM) / 3.0_f64.sqrt()).abs() < 0.01, "{kind}");
        assert!(u_um("reference pin, its reading").is_some_and(|u| u > 0.005 && u < 0.1));
        assert_eq!(found.columns, COLUMNS - PIN);
    }
    // without the pin the same frame is half a µm off: the test can fail
    let mut alone = stream(false);
    let raw = measured(&mut alone, &frame(50.0, 1.3, 4, |_, _, _| (300.0, 300.0))).unwrap();
    let off_um = 1e3 * (raw.mean.unwrap().d_mm - PART_MM);
    assert!((off_um - 0.52).abs() < 0.1, "{off_um}");
}

/// Edges of the reference pin at a column, of those of a clean one.
type Pin<'a> = &'a dyn Fn(usize, f64, f64) -> (f64, f64);

#[test]
fn a_pin_that_is_contaminated_gone_or_another_one_refuses_the_frame() {
    let mut stream = stream(true);
    measured(&mut stream, &frame(0.0, 1.2, 1, clean)).unwrap();
    let half_px = 0.5 * 3.0 / UM_PER_PX;
    let cases: [(&str, Pin<'_>); 4] = [
        ("reference pin", &|_, _, _| (300.0, 300.0)),
        // a film of 3 µm all over: 310 ppm from one frame to the next
        ("apart from its last readings", &|_, top, bottom| (top - half_px, bottom + half_px)),
        // another pin
        ("off its diameter", &|_, top, bottom| (top - 1.0, bottom + 1.0)),
        // half of it is covered
        ("contaminated or has moved", &|column, top, bottom| {
            if column < 90 { (top, bottom) } else { (300.0, 300.0) }
        }),
    ];
    for ((word, pin), seed) in cases.into_iter().zip(10..) {
        let refused = measured(&mut stream, &frame(0.0, 1.2, seed, pin));
        let why = refused.unwrap_err().to_string();
        assert!(why.contains(word) && why.contains("reference pin"), "{word}: {why}");
        let gap = stream.measurement();
        assert_eq!(gap.refusal.as_ref().unwrap().reason, Reason::Implausible);
        assert!(gap.diameter.is_none() && gap.mean.is_none());
    }
    // and the next clean frame is measured
    let found = measured(&mut stream, &frame(0.0, 1.2, 20, clean)).unwrap();
    assert!((found.mean.unwrap().d_mm - PART_MM).abs() < 1e-4);
}

#[test]
fn a_pin_needs_millimetres_and_a_place_in_the_field() {
    let gauge = Gauge::new(GaugeSettings::default()).unwrap();
    let pin = "0-199,9.6".parse().unwrap();
    let pixels = Stream::in_pixels(&gauge, MeasureSettings::default()).unwrap();
    assert!(pixels.with_reference_pin(&gauge, pin).is_err_and(|why| why.to_string().contains("millimetres")));
    let of = |text: &str| {
        let stream =
            Stream::calibrated(&gauge, &Calibration::from_scale(UM_PER_PX), MeasureSettings::default());
        let mut stream = stream.unwrap().with_reference_pin(&gauge, text.parse().unwrap()).unwrap();
        measured(&mut stream, &frame(0.0, 1.2, 1, clean)).unwrap_err().to_string()
    };
    assert!(of("400-499,9.6").contains("ends at column 499"));
    assert!(of("20-400,9.6").contains("fewer than 64 columns"));
}
