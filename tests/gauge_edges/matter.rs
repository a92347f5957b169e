//! Matter before the part and on it: a fixed, small part of `shadowgauge study contamination`.

use shadowgauge::gauge::{Gauge, GaugeSettings, Rejection};
use shadowgauge::profile::Reason;
use shadowgauge::studies::contamination;
use shadowgauge::studies::dirty_frames::{Bump, COLUMNS, Piece};

#[test]
fn harmful_frames_are_gaps_or_right_and_clean_ones_are_kept() {
    let study = contamination::run(&GaugeSettings::default(), 12, 60, 4242).unwrap();
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
    assert!(dirty.bottom.iter().all(|e| e.is_usable()));
    assert!(dirty.valid() > COLUMNS - 120);
    // A collar rises on both sides: it is form.
    let collar = edges(&[film, Bump { upper: false, ..film }], Rejection::Full);
    assert!(collar.valid() > COLUMNS - 4, "{}", collar.valid());
    // A user with a keyed shaft turns the axis off.
    assert!(edges(&[film], Rejection::ByEdge).valid() > COLUMNS - 4);
}

#[test]
fn a_misfit_that_neighbours_share_does_not_average_out() {
    // Light that falls off by 2 % a pixel beside the upper edge.
    let synth = crate::gauge_synth::Synth::with_snr(1.0, 100.0, true);
    let shade = |row: usize, column: usize, mean: f64| {
        let d = crate::gauge_synth::drifting(column).0 - row as f64;
        if d.abs() < 12.0 {
            mean * (1.0 - 0.02 * (d + 12.0))
        } else {
            mean * if d > 0.0 { 0.52 } else { 1.0 }
        }
    };
    let frame = synth.frame_with(crate::gauge_synth::drifting, shade, Some(5));
    let edges = Gauge::new(GaugeSettings::default()).unwrap().edges(&frame.view()).unwrap();
    let mean = shadowgauge::gauge::FrameEdges::mean(&edges.top, edges.shared_length[0], 0..2048).unwrap();
    let error = mean.value_px - (0..2048).map(|c| crate::gauge_synth::drifting(c).0).sum::<f64>() / 2048.0;
    println!("error {error:.4}, u {:.4}, misfit {:.2}", mean.u_px, edges.figures.misfit);
    assert!(error.abs() > 0.005, "the case is harmless: {error}");
    assert!(error.abs() <= 2.0 * mean.u_px, "{error} {}", mean.u_px);
}
