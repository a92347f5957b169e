//! Contamination in front of the part and on it: a fixed, small part of `shadowgauge study
//! contamination`.

use shadowgauge::gauge::{Gauge, GaugeSettings, Rejection};
use shadowgauge::profile::Reason;
use shadowgauge::studies::contamination_plan::ContaminationPlan;
use shadowgauge::studies::dirty_frames::{Bump, COLUMNS, Piece};
use shadowgauge::studies::sharding::{SceneStudy, outcomes};

#[test]
fn harmful_frames_are_gaps_or_right_and_clean_ones_are_kept() {
    let plan = ContaminationPlan { frames: 12, clean: 60, seed: 4242 };
    let found = outcomes(&plan, &plan.bench().unwrap(), 0..plan.scenes(), &|| {}).unwrap();
    let study = plan.result(&found);
    for kind in &study.kinds {
        println!("{kind:?}");
    }
    println!("mishandled {} of {}; clean lost {}", study.mishandled(), study.harmful(), study.clean_lost);
    assert!(study.harmful() >= 20, "the frames are not dirty enough to tell: {}", study.harmful());
    assert_eq!(study.mishandled(), 0);
    assert!(study.clean_lost <= 1);
}

#[test]
fn a_film_on_one_side_is_refused_with_its_reason_and_a_collar_is_not() {
    let piece = Piece::draw(3);
    let film = Bump { column: 200.0, half_length: 40.0, height_px: 1.0, upper: true };
    let edges = |bumps: &[Bump], rejection| {
        let frame = piece.with_bumps(bumps).frame(None).unwrap();
        let settings = GaugeSettings { rejection, ..GaugeSettings::default() };
        Gauge::new(settings).unwrap().edges(&frame.view()).unwrap()
    };
    let dirty = edges(&[film], Rejection::Full);
    assert!((180..220).all(|c| dirty.top[c].reason() == Some(Reason::Contaminated)));
    // Columns that are not clearly clean may be refused as well, the clean edge beside the film may
    // not.
    assert!((180..220).all(|c| dirty.bottom[c].is_usable()));
    assert!(dirty.valid() > COLUMNS - 160);
    // A collar rises on both sides, so it is form.
    let collar = edges(&[film, Bump { upper: false, ..film }], Rejection::Full);
    assert!(collar.valid() > COLUMNS - 24, "{}", collar.valid());
    // A user with a keyed shaft turns the axis off.
    assert!(edges(&[film], Rejection::ByEdge).valid() > COLUMNS - 4);
}

#[test]
fn a_frame_that_no_edge_spread_explains_is_refused() {
    // Light that falls off by 2 % per pixel beside the upper edge, to half: the fit errs by 0.3 px
    // at u = 0.06 px.
    let synth = crate::inside::gauge_edges::gauge_synth::Synth::with_snr(1.0, 100.0, true);
    let shaded = |fall: f64| {
        let shade = |row: usize, column: usize, mean: f64| {
            let d = crate::inside::gauge_edges::gauge_synth::drifting(column).0 - row as f64;
            if d.abs() < 12.0 {
                mean * (1.0 - fall * (d + 12.0))
            } else if d > 0.0 {
                mean * (1.0 - 24.0 * fall)
            } else {
                mean
            }
        };
        synth.frame_with(crate::inside::gauge_edges::gauge_synth::drifting, shade, Some(5))
    };
    let gauge = Gauge::new(GaugeSettings::default()).unwrap();
    assert!(gauge.edges(&shaded(0.0).view()).is_ok());
    let Err(refused) = gauge.edges(&shaded(0.02).view()) else { panic!("the frame was accepted") };
    assert_eq!(refused.reason, Reason::Residual, "{refused}");
    let settings = GaugeSettings { max_residual_rel: 1.0, ..GaugeSettings::default() };
    let edges = Gauge::new(settings).unwrap().edges(&shaded(0.02).view()).unwrap();
    assert!(edges.figures.reduced_chi2 > 20.0, "{}", edges.figures.reduced_chi2);
}
