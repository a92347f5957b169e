//! The renderer: its mask against its widths, and that it repeats.

use shadowgauge::render::flank::{FlankScene, render_flank};

#[test]
fn the_mask_has_the_area_of_the_widths() {
    let mut scene = FlankScene::default();
    scene.edge.end_deg = 0.0;
    scene.edge.camber_um = 0.0;
    let (_, mask, truth) = render_flank(&scene, 3).unwrap();
    let area_um2 = mask.iter().filter(|m| **m > 0).count() as f64 * scene.um_per_px.powi(2);
    let by_widths: f64 = truth.widths_um.iter().sum::<f64>() * truth.step_um;
    assert!((area_um2 / by_widths - 1.0).abs() < 0.01, "{area_um2} {by_widths}");
    assert!(truth.vb_max_um > truth.vb_um && truth.vb_um > 100.0, "{} {}", truth.vb_um, truth.vb_max_um);
}

#[test]
fn it_repeats_by_seed_at_any_number_of_threads() {
    let scene = FlankScene::drawn(4, (200, 160), 2.4);
    let bytes = |seed: u64| {
        let (frame, mask, _) = render_flank(&scene, seed).unwrap();
        let view = frame.view();
        let values: Vec<f32> = (0..160 * 200).map(|k| view.get(k / 200, k % 200).unwrap()).collect();
        (values, mask)
    };
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(|| bytes(7));
    assert!(one == bytes(7) && one != bytes(8));
}

#[test]
fn a_setting_out_of_range_names_its_key() {
    let mut scene = FlankScene::default();
    scene.surface.adhesion = 1.5;
    let text = render_flank(&scene, 1).unwrap_err().to_string();
    assert!(text.contains("surface.adhesion"), "{text}");
}
