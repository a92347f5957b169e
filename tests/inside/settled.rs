//! A coolant film that runs off, from frames: nothing is proven until the diameter has settled.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use shadowgauge::conformity::Judgement;
use shadowgauge::frame::FrameMeta;
use shadowgauge::gauge::{Calibration, Gauge, GaugeSettings};
use shadowgauge::measurement::{MeasureSettings, Measurement, Settled, Stream, Verdict};

use super::support::gauge_synth::Synth;

const UM_PER_PX: f64 = 10.0;
const WIDTH_PX: f64 = 60.3;
const HALF_A_SECOND_NS: u64 = 500_000_000;

fn stream(settle_s: Option<f64>) -> Stream {
    let gauge = Gauge::new(GaugeSettings::default()).unwrap();
    let tolerance = Some("0.62 ±0.05".parse().unwrap());
    let settings = MeasureSettings { tolerance, settle_s, ..MeasureSettings::default() };
    Stream::calibrated(&gauge, &Calibration::from_scale(UM_PER_PX), settings).unwrap()
}

/// Frame `i` of a part under a film of 24 µm of diameter that runs off over 24 frames.
fn push(stream: &mut Stream, i: u64, timed: bool) {
    let synth = Synth { columns: 256, ..Synth::with_snr(1.2, 100.0, true) };
    let film_px = (24.0 - i as f64).max(0.0) / UM_PER_PX;
    let half = 0.5 * (WIDTH_PX + film_px);
    let frame = synth.frame(|_| (55.2 - half, 55.2 + half), Some(i));
    let t_ns = if timed { 1 + i * HALF_A_SECOND_NS } else { 0 };
    stream.push(&FrameMeta { frame_id: i, t_ns, ..FrameMeta::default() }, &frame.view()).unwrap();
}

#[test]
fn a_film_that_runs_off_is_good_in_no_frame_until_it_has() {
    // without a time to settle every frame stands for itself, and each lies in the tolerance
    let mut alone = stream(None);
    for i in 0..24 {
        push(&mut alone, i, true);
        assert_eq!(alone.measurement().judgement, Verdict::Is(Judgement::GO), "frame {i}");
        assert_eq!(alone.measurement().settled, None);
    }
    let mut settling = stream(Some(5.0));
    let mut first_good = None;
    for i in 0..50 {
        push(&mut settling, i, true);
        let m = settling.measurement();
        let good = m.judgement == Verdict::Is(Judgement::GO);
        assert!(i > 24 || !good, "frame {i} under the film is good: {:?}", m.settled);
        if i == 18 {
            let Some(Settled::Trend { um_per_min, u_um_per_min }) = m.settled else {
                panic!("{:?}", m.settled)
            };
            assert!((um_per_min + 120.0).abs() < 4.0 * u_um_per_min + 1.0, "{um_per_min}");
        }
        if good {
            first_good.get_or_insert(i);
            let u_trend = m.settled.unwrap().u_trend_mm().unwrap();
            assert!(m.mean.unwrap().u_common_mm >= u_trend);
        }
    }
    assert!(first_good.is_some_and(|i| i < 45), "{first_good:?}");
    assert!(settling.finish().unwrap().all_good());
}

#[test]
fn a_series_that_never_settles_is_not_proven_and_says_why() {
    for (timed, frames, word) in [(true, 24, "um/min"), (false, 24, "t_ns"), (true, 3, "too few")] {
        let mut stream = stream(Some(5.0));
        (0..frames).for_each(|i| push(&mut stream, i, timed));
        assert_eq!(stream.measurement().judgement, Verdict::NotProven);
        let series = stream.finish().unwrap();
        assert!(
            !series.all_good() && series.warnings.iter().any(|w| w.contains(word)),
            "{:?}",
            series.warnings
        );
    }
}

#[test]
fn drift_since_the_zero_is_in_every_diameter_once() {
    let at = |drift_mm: Option<f64>| {
        let gauge = Gauge::new(GaugeSettings::default()).unwrap();
        let settings = MeasureSettings { station_mm: Some(0.5), budget: true, ..MeasureSettings::default() };
        let mut stream = Stream::calibrated(&gauge, &Calibration::from_scale(UM_PER_PX), settings).unwrap();
        if let Some(u_mm) = drift_mm {
            stream.set_zero_drift(u_mm, "1 h".to_owned());
        }
        push(&mut stream, 30, true);
        stream.measurement().clone()
    };
    let (before, after) = (at(None), at(Some(3e-3)));
    let grew = |a: f64, b: f64| (b * b - a * a).sqrt();
    let (a, b) = (before.diameter.unwrap(), after.diameter.unwrap());
    assert!((grew(a.u_mm, b.u_mm) - 3e-3).abs() < 1e-9, "{a:?} {b:?}");
    let (a, b) = (before.mean.unwrap(), after.mean.unwrap());
    assert!(a.d_mm == b.d_mm && (grew(a.u_common_mm, b.u_common_mm) - 3e-3).abs() < 1e-9, "{a:?} {b:?}");
    let common = |m: &Measurement| m.stations.as_ref().unwrap()[0].reading.value().unwrap().u_common_mm;
    assert!((grew(common(&before), common(&after)) - 3e-3).abs() < 1e-9);
    let rows = after.budget.unwrap().contributions;
    assert_eq!(
        rows.iter().filter(|row| row.source == "drift since the last zero" && row.input == "1 h").count(),
        1
    );
}

#[test]
fn another_part_settles_by_itself() {
    let mut stream = stream(Some(5.0));
    (30..60).for_each(|i| push(&mut stream, i, true));
    assert!(stream.measurement().settled.unwrap().u_trend_mm().is_some());
    stream.restart_settling();
    push(&mut stream, 60, true);
    assert_eq!(stream.measurement().settled, Some(Settled::Waiting { seen_s: 0.0, readings: 1 }));
}
