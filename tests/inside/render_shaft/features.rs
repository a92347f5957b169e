//! Slices with flats, keyways, threads and feed marks: the support function.

use std::f64::consts::{PI, TAU};

use shadowgauge::render::form::form_shaft;
use shadowgauge::render::silhouette::Outline;
use shadowgauge::shaft::{
    AxialWave, FeedMarks, Flat, Keyway, Lobe, ProfileKnot, Shaft, ShaftForm, SpindleHarmonic, SpindleMotion,
    TextureForm, Thread,
};

use crate::inside::render_shaft::close;

const R: f64 = 12.5;

fn shaft(form: &ShaftForm) -> Shaft {
    form_shaft(vec![ProfileKnot { z_mm: 0.0, radius_mm: R }], form, 60.0, 3).unwrap()
}

/// Largest r(θ)cos(θ + facing) by a sweep of θ and a finer one about its best: misses a rim by the
/// last step at most.
fn brute(outline: &Outline, z_mm: f64, facing: f64) -> f64 {
    let height = |t: f64| outline.radius_mm(z_mm, t) * (t + facing).cos();
    let mut best = (0.0, f64::NEG_INFINITY);
    let (n, m) = (100_000, 4000);
    for i in 0..n {
        let t = TAU * f64::from(i) / f64::from(n);
        if height(t) > best.1 {
            best = (t, height(t));
        }
    }
    let step = TAU / f64::from(n);
    for i in -m..=m {
        let t = best.0 + step * f64::from(i) / f64::from(m);
        best.1 = best.1.max(height(t));
    }
    best.1
}

fn against_brute_force(form: &ShaftForm, z: &[f64], tolerance: f64) {
    let outline = Outline::new(shaft(form)).unwrap();
    let mut worst = 0.0f64;
    for angle in [0.0f64, 7.3, 29.9, 88.0, 121.0, 180.0, 201.7, 268.4, 341.0] {
        let turned = outline.turned(angle);
        for &z in z {
            let e = turned.edges(z);
            let phi = angle.to_radians();
            let (top, bottom) = (brute(&outline, z, phi), brute(&outline, z, phi + PI));
            worst = worst.max((e.top_mm - top).abs()).max((e.bottom_mm + bottom).abs());
            assert!((e.top_mm - top).abs() < tolerance, "{angle}° z {z}: {} {top}", e.top_mm);
            assert!((e.bottom_mm + bottom).abs() < tolerance, "{angle}° z {z}: {} {bottom}", e.bottom_mm);
        }
    }
    println!("worst {worst:.1e} mm");
}

fn flat(distance_mm: f64, angle_deg: f64) -> Flat {
    Flat { from_mm: 0.0, to_mm: 60.0, distance_mm, angle_deg }
}

fn keyway(width_mm: f64, floor_mm: f64, angle_deg: f64) -> Keyway {
    Keyway { from_mm: 0.0, to_mm: 60.0, width_mm, floor_mm, angle_deg }
}

#[test]
fn a_flat_that_turns_through_the_edge_is_the_closed_form() {
    let outline =
        Outline::new(shaft(&ShaftForm { flats: vec![flat(11.0, 30.0)], ..Default::default() })).unwrap();
    let half = (11.0f64 / R).acos();
    for i in 0..720 {
        let angle = 0.5 * f64::from(i);
        // The flat's normal is at 30° + φ; the edge is the upper one (0°).
        let away = ((30.0 + angle).to_radians() + PI).rem_euclid(TAU) - PI;
        let wanted = if away.abs() < half { R * (half - away.abs()).cos() } else { R };
        close(outline.turned(angle).edges(20.0).top_mm, wanted, 1e-10, &format!("D at {angle}°"));
    }
}

#[test]
fn a_keyway_that_turns_through_the_edge_is_the_closed_form() {
    let form = ShaftForm { keyways: vec![keyway(8.0, 8.5, -50.0)], ..Default::default() };
    let outline = Outline::new(shaft(&form)).unwrap();
    let half = (4.0f64 / R).asin();
    for i in 0..720 {
        let angle = 0.5 * f64::from(i);
        let away = ((angle - 50.0).to_radians() + PI).rem_euclid(TAU) - PI;
        let wanted = if away.abs() < half { R * (half - away.abs()).cos() } else { R };
        close(outline.turned(angle).edges(20.0).top_mm, wanted, 1e-10, &format!("keyway at {angle}°"));
    }
    close(outline.turned(50.0).edges(20.0).top_mm, (R * R - 16.0).sqrt(), 1e-11, "both corners level");
}

#[test]
fn a_hexagon_shows_its_corners_and_its_width_across_flats() {
    let flats = (0..6).map(|i| flat(10.0, 60.0 * f64::from(i))).collect();
    let outline = Outline::new(shaft(&ShaftForm { flats, ..Default::default() })).unwrap();
    close(outline.turned(0.0).edges(5.0).top_mm, 10.0, 1e-11, "across flats");
    close(outline.turned(30.0).edges(5.0).top_mm, 10.0 / (PI / 6.0).cos(), 1e-11, "across corners");
}

#[test]
fn cuts_in_a_lobed_rough_shaft_meet_brute_force() {
    let lobes = vec![Lobe { order_upr: 9, amplitude_mm: 0.02, phase_deg: 11.0 }];
    let texture = Some(TextureForm { rms_um: 2.0, correlation_z_mm: 1.0, ..Default::default() });
    let flats = vec![flat(12.3, 40.0), flat(11.7, 75.0)];
    let keyways = vec![keyway(5.0, 9.0, 62.0), keyway(3.0, 10.0, 230.0)];
    let form = ShaftForm { lobes, texture, flats, keyways, ..Default::default() };
    // Brute force misses a rim by one step of 1.6e-8 rad.
    against_brute_force(&form, &[3.3, 20.0], 3e-7);
}

#[test]
fn threads_and_feed_marks_meet_brute_force() {
    let thread = Thread { from_mm: 5.0, to_mm: 30.0, pitch_mm: 1.75, ..Default::default() };
    let multi = Thread {
        from_mm: 32.0,
        to_mm: 50.0,
        pitch_mm: 3.0,
        starts: 4,
        left_handed: true,
        included_angle_deg: 30.0,
        crest_mm: Some(1.0),
        depth_mm: Some(1.5),
    };
    let form = ShaftForm {
        threads: vec![thread, multi],
        lobes: vec![Lobe { order_upr: 3, amplitude_mm: 0.01, phase_deg: 0.0 }],
        feed_marks: Some(FeedMarks { feed_mm: 0.2, nose_radius_mm: 0.8 }),
        ..Default::default()
    };
    against_brute_force(&form, &[5.0, 9.137, 10.01, 11.3, 33.3, 47.77, 55.5], 3e-8);
}

#[test]
fn an_iso_thread_has_its_depth_and_climbs_by_its_pitch() {
    let form = ShaftForm {
        threads: vec![Thread { from_mm: 0.0, to_mm: 50.0, pitch_mm: 2.0, ..Default::default() }],
        ..Default::default()
    };
    let outline = Outline::new(shaft(&form)).unwrap();
    let turned = outline.turned(0.0);
    let heights: Vec<f64> = (0..4000).map(|i| turned.edges(10.0 + 1e-3 * f64::from(i)).top_mm).collect();
    let (low, high) = heights.iter().fold((f64::INFINITY, 0.0f64), |(l, h), v| (l.min(*v), h.max(*v)));
    close(high, R, 1e-12, "crest");
    // Major less 5/8 H; the helix hides a small part of the root.
    let depth = 0.625 * 3f64.sqrt() / 2.0 * 2.0;
    assert!((R - depth..R - depth + 0.02).contains(&low), "root {low}");
    for i in 0..2000 {
        close(heights[i], heights[i + 2000], 1e-9, "a pitch further on");
    }
    // On the other edge the crests are half a pitch away.
    let other = |z: f64| -turned.edges(z).bottom_mm;
    for i in 0..500 {
        let z = 10.0 + 4e-3 * f64::from(i);
        close(other(z + 1.0), turned.edges(z).top_mm, 1e-9, "half a turn is half a pitch");
    }
}

#[test]
fn waves_feed_marks_and_spindle_do_what_they_say() {
    let form = ShaftForm {
        waviness: vec![AxialWave { wavelength_mm: 2.5, amplitude_mm: 0.003, phase_deg: 90.0 }],
        spindle: SpindleMotion {
            synchronous: vec![SpindleHarmonic {
                order: 3,
                x_um: 2.0,
                x_phase_deg: 20.0,
                ..Default::default()
            }],
            ..Default::default()
        },
        ..Default::default()
    };
    let outline = Outline::new(shaft(&form)).unwrap();
    for (angle, z) in [(0.0f64, 1.0f64), (17.0, 4.4), (200.0, 33.0)] {
        let e = outline.turned(angle).edges(z);
        let radius = R - 0.003 * (TAU * z / 2.5).sin();
        close(0.5 * (e.top_mm - e.bottom_mm), radius, 1e-12, "wave");
        let shift = 2e-3 * (3.0 * angle.to_radians() + 20f64.to_radians()).cos();
        close(0.5 * (e.top_mm + e.bottom_mm), shift, 1e-12, "error motion");
    }
    let marks = FeedMarks { feed_mm: 0.25, nose_radius_mm: 0.4 };
    let outline = Outline::new(shaft(&ShaftForm { feed_marks: Some(marks), ..Default::default() })).unwrap();
    let turned = outline.turned(33.0);
    let heights = || (0..1000).map(|i| turned.edges(20.0 + 2.5e-4 * f64::from(i)).top_mm - R);
    let (low, high) = heights().fold((f64::INFINITY, 0.0f64), |(l, h), v| (l.min(v), h.max(v)));
    // Points .25 µm apart miss a cusp of slope .31 by 39 nm at most.
    close(high, 0.25 * 0.25 / (8.0 * 0.4), 4e-5, "f²/8r");
    assert!((-1e-9..2e-4).contains(&low), "valleys on the radius: {low}");
}
