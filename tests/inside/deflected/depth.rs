//! Diameters of a part that turns off its axis before a lens that is not quite telecentric.

use shadowgauge::gauge::axis_line::{AxisAverager, AxisLine};
use shadowgauge::gauge::diameter::turning_depth::{Telecentricity, correct_frames, correct_profile};
use shadowgauge::profile::DiameterProfile;
use shadowgauge::shaft::{Eccentricity, ShaftForm};
use shadowgauge::truth::station_diameters_mm;

use crate::inside::deflected::setup::{Case, Head, Measured};

const CASE: Case = Case {
    diameter_mm: 8.0,
    length_mm: 30.0,
    station_mm: 5.0,
    rows: 672,
    columns: 1280,
    fields: 2,
    angles: 8,
    whole_turn: false,
    field_step: 1,
};
/// Angle of a chief ray at half the diagonal, mrad: ten times what a good lens has, so that it
/// shows.
const TELECENTRICITY_MRAD: f64 = 5.0;
/// Eccentricity away from the camera at most at 90°, mm.
const ECCENTRICITY_MM: f64 = 0.1;

fn axis(head: &Head, frames: &[Measured]) -> AxisLine {
    let zero = head.calibration.axis_zero(f64::from(head.case.rows));
    let mut averager = AxisAverager::new(head.case.stations(), head.case.station_mm, zero);
    frames.iter().for_each(|f| averager.add(&f.meta, &f.columns));
    averager.finish()
}

/// Mean error of the stations and their mean u, mm.
fn off(profile: &DiameterProfile, truth: &[f64]) -> (f64, f64) {
    let pairs = profile.stations.iter().zip(truth);
    let errors: Vec<(f64, f64)> =
        pairs.filter_map(|(s, t)| s.reading.value().map(|d| (d.d_mm - t, d.u_mm()))).collect();
    assert_eq!(errors.len(), truth.len());
    let mean = |f: fn(&(f64, f64)) -> f64| errors.iter().map(f).sum::<f64>() / errors.len() as f64;
    (mean(|e| e.0), mean(|e| e.1))
}

#[test]
fn what_turns_towards_the_camera_is_taken_off_where_the_telecentricity_is_known() {
    let head = Head::with_telecentricity(CASE, 7, TELECENTRICITY_MRAD);
    // Against the same head before a shaft that runs true: what its masters are off by drops out.
    let form = |amplitude_mm: f64| ShaftForm {
        eccentricity: Eccentricity { amplitude_mm, phase_deg: 0.0 },
        ..ShaftForm::default()
    };
    let [centred, eccentric] = [form(0.0), form(ECCENTRICITY_MM)].map(|form| head.shaft(&form));
    let truth = |shaft| station_diameters_mm(shaft, &CASE.intervals()).unwrap();
    let zero = off(&head.profile(&head.scan(&centred)), &truth(&centred)).0;
    let frames = head.scan(&eccentric);
    let line = axis(&head, &frames);
    let half_mm = 0.5 * f64::from(CASE.rows).hypot(f64::from(CASE.columns)) * head.setup.pixel_mm;
    let per_mm = -(1e-3 * TELECENTRICITY_MRAD).tan() / half_mm;
    let plain = off(&head.profile(&frames), &truth(&eccentric));
    // Half a turn at 8 angles: the mean of sin φ is cot(π/16)/8 = .6284.
    let wanted =
        -per_mm * CASE.diameter_mm * ECCENTRICITY_MM * (std::f64::consts::PI / 16.0).tan().recip() / 8.0;
    println!("off by {:.4} um, wanted {:.4} um", 1e3 * (plain.0 - zero), 1e3 * wanted);
    assert!(wanted > 1e-4 && (plain.0 - zero - wanted).abs() < 0.1 * wanted, "{} {wanted}", plain.0 - zero);

    let known = Telecentricity { per_mm, u_per_mm: 0.0 };
    let angles: Vec<f64> = (0..8).map(|a| 22.5 * f64::from(a)).collect();
    let mut profile = head.profile(&frames);
    correct_profile(&mut profile, &line, &angles, known);
    let by_station = off(&profile, &truth(&eccentric)).0 - zero;
    let mut pairs: Vec<_> = frames.into_iter().map(|f| (f.meta, f.columns)).collect();
    correct_frames(&mut pairs, &line, known);
    let frames: Vec<Measured> = pairs.into_iter().map(|(meta, columns)| Measured { meta, columns }).collect();
    let by_frame = off(&head.profile(&frames), &truth(&eccentric)).0 - zero;
    println!("taken off: {:.4} um by station, {:.4} um by frame", 1e3 * by_station, 1e3 * by_frame);
    assert!(by_station.abs() < 0.1 * wanted && by_frame.abs() < 0.1 * wanted, "{by_station} {by_frame}");

    // Limits alone are in u, and the value stays.
    let mut limits = head.profile(&frames);
    let before = off(&limits, &truth(&eccentric));
    correct_profile(&mut limits, &line, &angles, Telecentricity::within(per_mm));
    let after = off(&limits, &truth(&eccentric));
    assert!((after.0 - before.0).abs() < 1e-12);
    let added = (after.1.powi(2) - before.1.powi(2)).sqrt();
    assert!((added / (wanted / 3.0_f64.sqrt()) - 1.0).abs() < 0.15, "{added} {wanted}");
}
