//! Lens, light and motion against inverses, tracing of points and averages in time.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use shadowgauge::render::esf_families::{EdgeSpread, GaussianBlur};
use shadowgauge::render::lens::entocentric::{
    apparent_radius_mm, edges_mm, entocentric_half_height_mm, tilted_half_height_mm,
};
use shadowgauge::render::lens::{Distortion, FieldLight};
use shadowgauge::render::motion::{LightTime, Motion, Strobe, Turning, Vibration};

fn close(found: f64, wanted: f64, tolerance: f64, what: &str) {
    assert!((found - wanted).abs() <= tolerance, "{what}: {found}, not {wanted} ± {tolerance}");
}

// -- distortion

const ROWS: usize = 2048;
const COLUMNS: usize = 2448;

fn barrel() -> Distortion {
    Distortion { k1: -0.03, k2: 0.008, k3: -0.001, p1: 0.002, p2: -0.0015 }
}

#[test]
fn distortion_and_its_inverse_meet_to_1e_9_px() {
    let mut worst = 0.0f64;
    for d in [barrel(), Distortion { k1: 0.1, ..Distortion::default() }] {
        d.check().unwrap();
        for row in (0..ROWS).step_by(97) {
            for column in (0..COLUMNS).step_by(89) {
                let (r, c) = (row as f64, column as f64);
                let (r1, c1) = d.distort_px(r, c, ROWS, COLUMNS);
                let (r2, c2) = d.undistort_px(r1, c1, ROWS, COLUMNS);
                worst = worst.max((r2 - r).abs()).max((c2 - c).abs());
            }
        }
    }
    assert!(worst < 1e-9, "{worst}");
}

#[test]
fn distortion_does_what_its_coefficients_say() {
    // .1 % at the corner: half the diagonal is 1595.9 px.
    let d = Distortion { k1: 1e-3, ..Distortion::default() };
    let half = 0.5 * (ROWS as f64).hypot(COLUMNS as f64);
    let corner = [(ROWS as f64 - 1.0) / 2.0 * 2.0, COLUMNS as f64 - 1.0];
    let (r, c) = d.distort_px(corner[0], corner[1], ROWS, COLUMNS);
    close((r - corner[0]).hypot(c - corner[1]), 1e-3 * half, 3e-3, "corner");
    let centre = d.distort_px(1023.5, 1223.5, ROWS, COLUMNS);
    assert_eq!(centre, (1023.5, 1223.5));
    assert_eq!(Distortion::default().distort_px(12.25, 99.5, ROWS, COLUMNS).0, 12.25);
    // OpenCV's projectPoints(k1 .1, k2 .05, p1 .01, p2 -.02, k3 .03) worked by hand at (.3, -.2).
    let d = Distortion { k1: 0.1, k2: 0.05, k3: 0.03, p1: 0.01, p2: -0.02 };
    let r2: f64 = 0.13;
    let radial = 1.0 + 0.1 * r2 + 0.05 * r2 * r2 + 0.03 * r2 * r2 * r2;
    let (u, v) = d.distort(0.3, -0.2);
    close(u, 0.3 * radial + 2.0 * 0.01 * 0.3 * -0.2 - 0.02 * (r2 + 0.18), 1e-14, "u");
    close(v, -0.2 * radial + 0.01 * (r2 + 0.08) + 2.0 * -0.02 * 0.3 * -0.2, 1e-14, "v");
}

#[test]
fn an_edge_is_found_where_its_points_land() {
    let d = barrel();
    let edge = |c: f64| 300.0 + 0.4 * c + 20.0 * (c / 200.0).sin();
    for ideal in [40.0, 700.3, 1223.5, 2100.9] {
        let (row, column) = d.distort_px(edge(ideal), ideal, ROWS, COLUMNS);
        close(d.edge_row(column, ROWS, COLUMNS, edge), row, 1e-9, "row of the seen edge");
    }
    close(Distortion::default().edge_row(77.0, ROWS, COLUMNS, edge), edge(77.0), 1e-9, "no distortion");
}

#[test]
fn a_folding_lens_is_refused() {
    let text = Distortion { k1: -0.4, ..Distortion::default() }.check().unwrap_err().to_string();
    assert!(text.contains("folds"), "{text}");
    let text = Distortion { p1: f64::NAN, ..Distortion::default() }.check().unwrap_err().to_string();
    assert!(text.contains("optics.distortion.p1"), "{text}");
}

// -- light over the field

#[test]
fn the_field_is_as_bright_as_its_coefficients_say() {
    let light =
        FieldLight { gradient_along: 0.04, gradient_down: -0.02, vignetting_2: 0.1, ..FieldLight::default() };
    light.check().unwrap();
    close(light.at_px(1023.5, 1223.5, ROWS, COLUMNS), 1.0, 1e-15, "centre");
    let half = 0.5 * (ROWS as f64).hypot(COLUMNS as f64);
    let slope = light.at_px(1023.5, 1224.5, ROWS, COLUMNS) - light.at_px(1023.5, 1222.5, ROWS, COLUMNS);
    close(slope, 2.0 * 0.04 / half, 1e-9, "gradient along");
    let mut row = vec![0.0; 32];
    light.row(7, 100, [ROWS, COLUMNS], &mut row);
    assert_eq!(row[3], light.at_px(7.0, 103.0, ROWS, COLUMNS) as f32);
    // cos⁴ of 8° at the corner.
    let t = 8f64.to_radians().tan();
    close(FieldLight::natural(t).factor(0.6, 0.8), 8f64.to_radians().cos().powi(4), 4.0 * t.powi(6), "cos⁴");
    let dark = FieldLight { vignetting_2: 1.0, ..FieldLight::default() }.check().unwrap_err().to_string();
    assert!(dark.contains("light.field"), "{dark}");
}

// -- perspective and tilt

#[test]
fn a_pinhole_sees_the_tangents() {
    close(
        apparent_radius_mm(12.5, 200.0).unwrap(),
        12.5 * 200.0 / (200.0f64.powi(2) - 12.5 * 12.5).sqrt(),
        1e-12,
        "centred",
    );
    // The tangent's distance from the centre of an off-centre circle is its radius.
    let (x0, y0, radius, distance) = (3.0, -4.0, 7.5, 150.0);
    let (top, bottom) = edges_mm(radius, x0, y0, distance).unwrap();
    for x in [top, bottom] {
        // Line from (x, y) = (0, distance) to (x, 0).
        let away = ((x0 - 0.0) * (0.0 - distance) - (y0 - distance) * (x - 0.0)).abs() / x.hypot(distance);
        close(away, radius, 1e-12, "tangent");
    }
    assert!(top > x0 && bottom < x0);
    let text = edges_mm(12.5, 0.0, 190.0, 200.0).unwrap_err().to_string();
    assert!(text.contains("distance_mm"), "{text}");
}

/// Largest height at z of all points of a body of revolution, projected by `project(x, y, s) -> (z,
/// height)`.
fn painted(
    radius: impl Fn(f64) -> f64,
    at: f64,
    width: f64,
    span: f64,
    project: impl Fn(f64, f64, f64) -> (f64, f64),
) -> f64 {
    let mut highest = 0.0f64;
    for i in 0..=8000 {
        let s = at + span * (f64::from(i) / 4000.0 - 1.0);
        let r = radius(s);
        for j in 0..=3000 {
            let t = std::f64::consts::PI * (f64::from(j) / 3000.0 - 0.5);
            let (z, height) = project(r * t.cos(), r * t.sin(), s);
            if (z - at).abs() <= width {
                highest = highest.max(height);
            }
        }
    }
    highest
}

#[test]
fn a_tilted_shoulder_spreads_along_z() {
    let tilt = 0.1f64.to_radians();
    let shoulder = |s: f64| if s < 0.0 { 12.5 } else { 10.0 };
    let at = |z: f64| tilted_half_height_mm(shoulder, 12.5, z, tilt, 4096);
    // The rim of the larger step reaches 12.5 sin .1° = 21.8 µm: its height there is an ellipse.
    let spread = 12.5 * tilt.sin();
    close(spread, 0.0218, 1e-4, "spread");
    close(at(0.3 * spread), 12.5 * (1.0f64 - 0.09).sqrt(), 2e-3, "ellipse");
    close(at(-0.9 * spread), 12.5, 1e-6, "before the shoulder the larger step");
    close(at(1.1 * spread), 10.0, 1e-6, "behind it the smaller one");
    close(tilted_half_height_mm(|_| 8.0, 8.0, 0.4, tilt, 64), 8.0, 1e-9, "a cylinder stays");
    close(tilted_half_height_mm(|s| 8.0 + 0.1 * s, 9.0, 0.4, 0.0, 64), 8.04, 1e-12, "no tilt");
    let cone = |s: f64| 8.0 + 0.3 * s;
    let (sin, cos) = 0.02f64.sin_cos();
    let wanted = painted(cone, 0.4, 1e-4, 0.25, |x, y, s| (s * cos + y * sin, x));
    close(tilted_half_height_mm(cone, 9.0, 0.4, 0.02, 256), wanted, 3e-4, "cone against its points");
}

#[test]
fn an_entocentric_view_is_the_envelope_of_the_slices() {
    let distance = 200.0;
    let half =
        |radius: &dyn Fn(f64) -> f64, z| entocentric_half_height_mm(radius, 12.5, z, distance, 512).unwrap();
    for z in [0.0, 1e-3, -8.0, 21.0] {
        close(half(&|_| 12.5, z), apparent_radius_mm(12.5, distance).unwrap(), 1e-8, "cylinder");
    }
    let cone = |s: f64| 10.0 - 0.08 * s;
    let seen = painted(cone, 15.0, 2e-4, 1.2, |x, y, s| {
        let m = distance / (distance - y);
        (m * s, m * x)
    });
    close(half(&cone, 15.0), seen, 3e-4, "cone against its points");
}

// -- motion

fn gaussian(sigma_um: f64) -> EdgeSpread {
    GaussianBlur { lens_sigma_um: sigma_um, effective_na: 0.0, ..GaussianBlur::default() }
        .edge_spread()
        .unwrap()
}

#[test]
fn blur_by_motion_equals_the_average_in_time() {
    let vibration = |amplitude_um, frequency_hz| Vibration { amplitude_um, frequency_hz, phase_deg: 33.0 };
    let cases = [
        Motion { carriage_mm_s: 20.0, ..Motion::default() },
        Motion { spindle_rpm: 3000.0, ..Motion::default() },
        Motion { vibration: vec![vibration(6.0, 4000.0), vibration(3.0, 130.0)], ..Motion::default() },
        Motion { vibration: vec![vibration(8.0, 3e6)], ..Motion::default() },
        Motion {
            carriage_mm_s: 5.0,
            spindle_rpm: 1500.0,
            vibration: vec![vibration(4.0, 900.0)],
            strobe: Some(Strobe { delay_us: 300.0, pulse_us: 150.0 }),
            ..Motion::default()
        },
    ];
    let turning = [
        Turning { undulations: 1.0, amplitude_um: 25.0, phase_rad: 0.4 },
        Turning { undulations: 12.0, amplitude_um: 4.0, phase_rad: 1.9 },
    ];
    let table = gaussian(5.0);
    for motion in cases {
        motion.check(500.0).unwrap();
        let path = motion.path(0.8, &turning);
        let time = motion.light_time(500.0);
        let steps = 40_000;
        let at =
            |i: i32| path.at_um(time.start_us + time.length_us * (f64::from(i) + 0.5) / f64::from(steps));
        let mean = (0..steps).map(at).sum::<f64>() / f64::from(steps);
        close(path.mean_um(time), mean, 1e-5, "mean position");
        let blurred = path.blurred(&table, time, 1e-7).unwrap();
        for d in [-14.0, -4.0, 0.0, 1.5, 9.0] {
            let average = (0..steps).map(|i| table.value(d - (at(i) - mean))).sum::<f64>() / f64::from(steps);
            close(blurred.value(d), average, 5e-5, &format!("{motion:?} at {d}"));
        }
    }
}

#[test]
fn limits_of_motion_are_box_and_arcsine() {
    let time = LightTime { start_us: 0.0, length_us: 200.0 };
    let feed = Motion { carriage_mm_s: 30.0, ..Motion::default() }.path(0.5, &[]);
    close(feed.mean_um(time), 1.5, 1e-12, "half of the way");
    close(feed.shifts(time).variance_um2(), 3.0 * 3.0 / 12.0, 1e-10, "(vT)²/12");
    let shaking = Vibration { amplitude_um: 7.0, frequency_hz: 2e6, phase_deg: 0.0 };
    let path = Motion { vibration: vec![shaking], ..Motion::default() }.path(0.0, &[]);
    close(path.shifts(time).variance_um2(), 24.5, 1e-9, "A²/2");
    // A flash freezes it: 0.1 µs of a period of 100 µs.
    let still = Motion {
        vibration: vec![Vibration { frequency_hz: 1e4, ..shaking }],
        strobe: Some(Strobe { delay_us: 25.0, pulse_us: 0.1 }),
        ..Motion::default()
    };
    let flash = still.light_time(200.0);
    close(still.path(0.0, &[]).mean_um(flash), 7.0, 1e-3, "stands at its crest");
    assert!(still.path(0.0, &[]).shifts(flash).variance_um2() < 1e-6);
    let poses = Motion { spindle_rpm: 600.0, carriage_mm_s: 2.0, ..Motion::default() }.poses(1000.0, 5);
    let angle: f64 = poses.iter().map(|(a, _, w)| a * w).sum();
    let z: f64 = poses.iter().map(|(_, z, w)| z * w).sum();
    close(angle, 1.8, 1e-12, "mean angle");
    close(z, 1e-3, 1e-15, "mean z");
}

#[test]
fn impossible_exposures_are_refused() {
    let refused = |m: Motion| m.check(50_000.0).unwrap_err().to_string();
    let spin = Motion { spindle_rpm: 3000.0, ..Motion::default() };
    assert!(refused(spin.clone()).contains("allow_more_than_a_turn"), "{}", refused(spin.clone()));
    Motion { allow_more_than_a_turn: true, ..spin.clone() }.check(50_000.0).unwrap();
    Motion { strobe: Some(Strobe { delay_us: 0.0, pulse_us: 5.0 }), ..spin }.check(50_000.0).unwrap();
    let late = Motion { strobe: Some(Strobe { delay_us: 49_999.0, pulse_us: 5.0 }), ..Motion::default() };
    assert!(refused(late).contains("motion.strobe.delay_us"));
    let v = Vibration { amplitude_um: -1.0, frequency_hz: 1.0, phase_deg: 0.0 };
    assert!(refused(Motion { vibration: vec![v], ..Motion::default() }).contains("amplitude_um"));
}
