//! The paper's way on the lands that it is made for, and on one that it is not.

use shadowgauge::gauge::flank::FlankSide;
use shadowgauge::gauge::flank::paper::measure_paper_flank;
use shadowgauge::render::flank::{FlankScene, render_flank};

/// A bright land on a darker flank.
pub(super) fn scene() -> FlankScene {
    let mut scene = FlankScene::default();
    let surface = &mut scene.surface;
    (surface.land, surface.flank, surface.air) = (0.85, 0.15, 0.05);
    (surface.texture, surface.sparkles, surface.shade) = (0.4, 0.0, 0.1);
    (surface.streaks, surface.adhesion, surface.glare) = (0.05, 0.0, 0.0);
    (surface.line, surface.rim) = (0.0, 0.0);
    (scene.wear.scatter, scene.wear.notch_um, scene.wear.chipping_um) = (0.1, 0.0, 0.0);
    scene
}

#[test]
fn a_bright_land_is_measured_by_morphology_and_canny() {
    let scene = scene();
    let (frame, _, truth) = render_flank(&scene, 5).unwrap();
    let found = measure_paper_flank(&frame.view(), scene.um_per_px, FlankSide::Any).unwrap();
    // a line as the reference, closing and opening by some rows of 2 µm
    assert!((found.vb_um - truth.vb_um).abs() < 10.0, "{} {}", found.vb_um, truth.vb_um);
    assert!((found.vb_max_um - truth.vb_max_um).abs() < 15.0, "{} {}", found.vb_max_um, truth.vb_max_um);
}

/// It takes what is bright for land: a dark one is refused, or missed by far.
#[test]
fn a_dark_land_is_not_seen() {
    let mut scene = scene();
    (scene.surface.land, scene.surface.flank) = (0.1, 0.6);
    let (frame, _, truth) = render_flank(&scene, 5).unwrap();
    let found = measure_paper_flank(&frame.view(), scene.um_per_px, FlankSide::Any);
    assert!(found.is_err() || (found.unwrap().vb_um - truth.vb_um).abs() > 20.0);
}
