//! The renderer of inserts: golden values, and its light beside the edge-spread function.

use shadowgauge::frame::{PixelFormat, Pixels};
use shadowgauge::render::esf_families::{CylinderEdge, LaserShadow, MeasuredEsf, PartiallyCoherentEdge};
use shadowgauge::render::insert::{InsertSettings, Wear, render_insert};
use shadowgauge::render::settings::{Esf, GaussianEsf};

use super::insert;

fn counts(s: &InsertSettings, noise: bool) -> Vec<f64> {
    let (frame, _) = render_insert(s, (11, 0), noise).unwrap();
    let view = frame.view();
    match view.pixels() {
        Pixels::F32(p) => p.iter().map(|v| f64::from(*v)).collect(),
        Pixels::U16(p) => p.iter().map(|v| f64::from(*v)).collect(),
        Pixels::U8(p) => p.iter().map(|v| f64::from(*v)).collect(),
    }
}

/// The worn insert of the golden values.
fn golden() -> InsertSettings {
    let mut s = insert(0);
    let direction_deg = s.nose.direction_deg + 12.0;
    s.wear =
        vec![Wear::Round { depth_um: 6.0 }, Wear::Chip { direction_deg, width_deg: 18.0, depth_um: 7.0 }];
    s
}

/// (row, column, counts without noise, counts with it), 12 bit.
const GOLDEN: [(usize, usize, f64, f64); 8] = [
    (263, 146, 494.484, 482.0),
    (288, 151, 862.622, 884.0),
    (318, 170, 2299.539, 2294.0),
    (331, 187, 2595.587, 2560.0),
    (336, 198, 3087.074, 3069.0),
    (338, 205, 2660.805, 2674.0),
    (342, 227, 1543.875, 1591.0),
    (337, 255, 606.879, 581.0),
];

#[test]
fn golden_values_stand() {
    let mut s = golden();
    let noisy = counts(&s, true);
    s.sensor.format = PixelFormat::F32;
    let plain = counts(&s, false);
    for (row, column, mean, drawn) in GOLDEN {
        let at = row * 520 + column;
        assert!((plain[at] - mean).abs() < 0.05, "row {row} column {column}: {} {mean}", plain[at]);
        assert!((noisy[at] - drawn).abs() <= 1.0, "row {row} column {column}: {} {drawn}", noisy[at]);
    }
}

#[test]
fn every_family_draws_a_nose_between_shadow_and_light() {
    let measured = MeasuredEsf::default();
    let families = [
        Esf::Gaussian(GaussianEsf::default()),
        Esf::PartiallyCoherent(PartiallyCoherentEdge::default()),
        Esf::Cylinder(CylinderEdge::default()),
        Esf::Fresnel(LaserShadow::default()),
        Esf::Measured(measured),
    ];
    for esf in families {
        // a small field: the fringes of laser light reach far
        let mut s = insert(0);
        (s.camera.columns, s.camera.rows) = (130, 105);
        s.nose.radius_mm = 0.05;
        s.nose.centre_px = [57.0, 65.0];
        s.esf = esf.clone();
        s.sensor.format = PixelFormat::F32;
        if s.esf.check().is_err() {
            // a measured edge needs a file
            continue;
        }
        let values = counts(&s, false);
        // the corner away from the nose, and that to which it points: a coherent edge overshoots
        // by 0.37 at most
        let shadow = values[129];
        assert!(
            (shadow - s.light.shadow_counts).abs() < 0.15 * s.light.bright_counts,
            "{esf:?}: {shadow} in the shadow"
        );
        let lit = values[104 * 130];
        assert!(
            (lit - s.light.bright_counts).abs() < 0.37 * s.light.bright_counts,
            "{esf:?}: {lit} in the light"
        );
    }
}

#[test]
fn light_over_the_nose_of_a_circle_is_that_of_its_edge_but_for_its_curvature() {
    // at the contour of a circle of R the blurred light is ½ + φ(0)·(σ² + 1/12)/(2Rσ'), σ' with the
    // pixel
    let mut s = insert(0);
    s.sensor.format = PixelFormat::F32;
    let (_, truth) = render_insert(&s, (1, 0), false).unwrap();
    let values = counts(&s, false);
    let (mut sum, mut n) = (0.0, 0.0_f64);
    let variance: f64 = 1.44 + 1.0 / 12.0;
    for row in 0..420 {
        for column in 0..520 {
            let (x, y) = (column as f64 - truth.centre_px[0], truth.centre_px[1] - row as f64);
            let turn = (y.atan2(x).to_degrees() - truth.edge_normals_deg[0]).rem_euclid(360.0);
            let d = x.hypot(y) - truth.nominal_radius_px;
            if !(20.0..100.0).contains(&turn) || d.abs() > 0.5 {
                continue;
            }
            let light = (values[row * 520 + column] - s.light.shadow_counts)
                / (s.light.bright_counts - s.light.shadow_counts);
            let edge = 0.5 * libm::erfc(-d / (2.0 * variance).sqrt());
            sum += light - edge;
            n += 1.0;
        }
    }
    let found = sum / n;
    let density = (std::f64::consts::TAU * variance).sqrt().recip();
    let right = density * variance / (2.0 * truth.nominal_radius_px);
    assert!(n > 100.0 && (found - right).abs() < 0.1 * right + 2e-5, "{found} {right}");
}
