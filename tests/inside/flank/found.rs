//! Rendered flanks against their truth, by the shipped forest.

use shadowgauge::gauge::flank::{FlankSettings, measure_flank, shipped};
use shadowgauge::render::flank::{FlankScene, render_flank};

#[test]
fn the_shipped_forest_is_small_and_of_rendered_flanks() {
    let forest = shipped().unwrap();
    assert!(forest.facts.trained_on.contains("rendered"), "{:?}", forest.facts);
    assert!(forest.facts.vb_error_um > 0.0);
}

#[test]
fn the_default_flank_is_measured_within_its_expanded_uncertainty() {
    let scene = FlankScene::default();
    let (frame, _, truth) = render_flank(&scene, 11).unwrap();
    let found =
        measure_flank(&frame.view(), &FlankSettings::at_scale(scene.um_per_px), &shipped().unwrap()).unwrap();
    let off = found.vbb.um - truth.vb_um;
    assert!(off.abs() < 2.0 * found.vbb.u_um.max(scene.um_per_px), "{off} {:?}", found.vbb);
}

/// Widths of a flank seen at an angle appear shortened by its cosine.
#[test]
fn the_viewing_angle_is_taken_into_account() {
    let scene = FlankScene::default();
    let (frame, _, _) = render_flank(&scene, 11).unwrap();
    let forest = shipped().unwrap();
    let mut oblique = FlankSettings::at_scale(scene.um_per_px);
    let straight = measure_flank(&frame.view(), &oblique, &forest).unwrap();
    (oblique.viewing_deg, oblique.u_viewing_deg) = (20.0, 1.0);
    let found = measure_flank(&frame.view(), &oblique, &forest).unwrap();
    assert!((found.vbb.um * 20f64.to_radians().cos() / straight.vbb.um - 1.0).abs() < 1e-9);
    let row = found.vbb.um * 20f64.to_radians().tan() * 1f64.to_radians();
    assert!((found.budget.viewing_um - row).abs() < 1e-9 && straight.budget.viewing_um == 0.0);
}
