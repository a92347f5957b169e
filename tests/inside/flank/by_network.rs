//! A network that takes what is bright for land, on the lands for which that is right.

use super::by_paper;
use shadowgauge::gauge::flank::network::Network;
use shadowgauge::gauge::flank::{FlankSettings, measure_flank};
use shadowgauge::measurement::flank::FlankImage;
use shadowgauge::render::flank::render_flank;
use shadowgauge::tool::wear::{WearLimits, WearVerdict};

fn network(name: &str) -> Network {
    let path = format!("{}/tests/data/onnx/{name}.onnx", env!("CARGO_MANIFEST_DIR"));
    Network::read(std::fs::read(path).unwrap()).unwrap()
}

#[test]
fn a_bright_land_is_measured_by_a_network_with_its_stated_errors() {
    let scene = by_paper::scene();
    let (frame, _, truth) = render_flank(&scene, 5).unwrap();
    let settings = FlankSettings::at_scale(scene.um_per_px);
    let found = measure_flank(&frame.view(), &settings, &network("threshold")).unwrap();
    // the texture of the flank passes the threshold here and there; the paper's way has 10 µm
    assert!((found.vbb.um - truth.vb_um).abs() < 10.0, "{} {}", found.vbb.um, truth.vb_um);
    assert!(found.budget.model_um >= 5.0 && found.vbb.u_um >= found.budget.model_um, "{:?}", found.budget);
    // the same by log-odds, padded
    let logit = measure_flank(&frame.view(), &settings, &network("logit")).unwrap();
    assert_eq!(logit.vbb.um, found.vbb.um);
}

/// Without stated errors there is no uncertainty, and nothing is proven.
#[test]
fn a_network_without_stated_errors_proves_nothing() {
    let scene = by_paper::scene();
    let (frame, _, _) = render_flank(&scene, 5).unwrap();
    let found =
        measure_flank(&frame.view(), &FlankSettings::at_scale(scene.um_per_px), &network("bare")).unwrap();
    assert!(found.flags.contains(&"no_uncertainty"), "{:?}", found.flags);
    let image = FlankImage::new("000000".to_owned(), &found, &WearLimits::default());
    assert!(image.vbb_um > 0.0 && image.u_vbb_um.is_none() && image.u_vbb_max_um.is_none());
    assert_eq!(image.verdict, WearVerdict::Doubtful);
}
