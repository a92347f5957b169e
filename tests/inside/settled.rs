//! A coolant film that runs off, from frames: nothing is proven until the diameter has settled.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use shadowgauge::conformity::Judgement;
use shadowgauge::frame::FrameMeta;
use shadowgauge::gauge::{Calibration, Gauge, GaugeSettings};
use shadowgauge::measurement::{MeasureSettings, Settled, Stream, Verdict};

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
