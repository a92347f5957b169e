//! The paper's way to measure on rendered noses: within a few pixels of the truth, as the design's
//! trial found (.004°, 2.57 px, 2.18 px), and far beyond what the program's own mode leaves.

use shadowgauge::gauge::nose::NoseSettings;
use shadowgauge::gauge::nose::paper::{PaperSettings, measure_paper_nose};
use shadowgauge::gauge::nose::{ExpectedNose, measure_nose};
use shadowgauge::render::insert::{InsertSettings, Wear, render_insert};

/// An insert of the paper's scale whose edges are some hundred px long.
fn insert(pose: usize) -> InsertSettings {
    let mut s = InsertSettings::default();
    (s.camera.columns, s.camera.rows) = (900, 800);
    s.nose.direction_deg = (237.0 + 101.3 * pose as f64).rem_euclid(360.0);
    let towards = s.nose.direction_deg.to_radians();
    s.nose.centre_px = [450.0 + 150.0 * towards.cos(), 400.0 - 150.0 * towards.sin()];
    if pose % 2 == 1 {
        s.wear.push(Wear::Round { depth_um: 30.0 });
    }
    s
}

fn known(s: &InsertSettings) -> PaperSettings {
    let nominal_radius_px = 1e3 * s.nose.radius_mm / s.camera.um_per_px;
    PaperSettings { nominal_radius_px, epsilon_deg: s.nose.epsilon_deg, expected: None }
}

#[test]
fn centre_and_radius_come_out_to_some_pixels_and_the_angle_as_forced() {
    let (mut worst, mut own) = ([0.0_f64; 3], 0.0_f64);
    for pose in 0..6 {
        let s = insert(pose);
        let (frame, truth) = render_insert(&s, (50 + pose as u64, 0), true).unwrap();
        let found = measure_paper_nose(&frame.view(), &known(&s)).unwrap();
        let off = |c: glam::DVec2| (c.x - truth.centre_px[0]).hypot(c.y + truth.centre_px[1]);
        let errors = [
            (found.angle_deg - truth.angle_deg).abs(),
            off(found.centre),
            (found.mean_radius_px - truth.mean_radius_px).abs(),
        ];
        println!("pose {pose}: {errors:?}, {:.3}° as found", found.found_angle_deg);
        worst.iter_mut().zip(errors).for_each(|(w, e)| *w = w.max(e));
        // of 180 poses of this insert, new and worn, the largest was .19°
        assert!((found.found_angle_deg - truth.angle_deg).abs() < 0.25, "{}", found.found_angle_deg);
        for (found, wanted) in found.normals_deg.into_iter().zip(truth.edge_normals_deg) {
            let turned = (found - wanted + 180.0).rem_euclid(360.0) - 180.0;
            assert!(turned.abs() < 0.5, "normal at {found}° instead of {wanted}°");
        }
        assert!(found.sectors.len() >= 118, "{} sectors", found.sectors.len());
        let settings = NoseSettings {
            nominal_radius_px: Some(truth.nominal_radius_px),
            um_per_px: s.camera.um_per_px,
            expected: None,
        };
        own = own.max(off(measure_nose(&frame.view(), &settings).unwrap().centre));
    }
    // orders of magnitude of the trial, on edges a third as long
    assert!(worst[0] < 0.005 && worst[1] < 6.0 && worst[2] < 6.0, "{worst:?}");
    assert!(own < 0.1 * worst[1], "{own} {worst:?}");
}

#[test]
fn reach_and_mean_radius_are_those_of_its_pixels() {
    let s = insert(0);
    let (frame, _) = render_insert(&s, (3, 0), true).unwrap();
    let found = measure_paper_nose(&frame.view(), &known(&s)).unwrap();
    let n = found.nose.len() as f64;
    let mean = found.nose.iter().map(|p| p.distance(found.centre)).sum::<f64>() / n;
    assert!((mean - found.mean_radius_px).abs() < 1e-9);
    // a round nose reaches its radius, a pixel more or less
    let middle = found.normals_deg[0] + 60.0;
    assert!((found.reach_px(middle) - found.mean_radius_px).abs() < 2.0, "{}", found.reach_px(middle));
}

#[test]
fn a_blank_frame_another_angle_and_another_direction_are_refused() {
    let s = insert(0);
    let (frame, truth) = render_insert(&s, (1, 0), true).unwrap();
    let said = |known: PaperSettings| measure_paper_nose(&frame.view(), &known).unwrap_err().to_string();
    let other = said(PaperSettings { epsilon_deg: 80.0, ..known(&s) });
    assert!(other.contains("76") && other.contains("84"), "{other}");
    let turned = truth.edge_normals_deg.map(|deg| (deg + 90.0).rem_euclid(360.0));
    let expected = ExpectedNose { epsilon_deg: 60.0, normals_deg: turned, by: "tool's file" };
    let said = said(PaperSettings { expected: Some(expected), ..known(&s) });
    assert!(said.contains("rotated by"), "{said}");
}
