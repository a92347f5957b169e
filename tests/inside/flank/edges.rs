//! Cutting edges of rendered flanks before a background that changes on the way to the edge.

use shadowgauge::gauge::flank::{KnownEdge, Raster, locate};
use shadowgauge::render::flank::{FlankScene, below_edge_um, render_flank};

/// Scale, µm per px.
const UM_PER_PX: f64 = 2.415;

/// By the air's constant level a stretch of air was taken for the edge and bent the reference by
/// more than 100 µm; now it is the new edge within its rounding and blur.
#[test]
fn a_background_that_changes_does_not_bend_the_reference() {
    for seed in [100_016, 100_036, 100_063] {
        let scene = FlankScene::drawn(seed, (900, 560), UM_PER_PX);
        let (frame, _, _) = render_flank(&scene, seed).unwrap();
        let found =
            locate(&Raster::of(&frame.view()).unwrap(), UM_PER_PX, KnownEdge::default()).unwrap().frame;
        let off = |k: usize| below_edge_um(&scene, found.place(k as f64, 0.0)).abs();
        let most_um = (0..found.columns()).map(off).fold(0.0, f64::max);
        assert!(most_um < 6.0, "{seed}: {most_um}");
    }
}
