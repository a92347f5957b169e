//! Studies of rendered flanks: what they state of a forest, and tools about the limits.

use shadowgauge::gauge::flank::forest::training::Growth;
use shadowgauge::gauge::flank::{FlankSide, Forest, KnownEdge, Labelled, Raster, drawn, locate, train};
use shadowgauge::render::flank::{FlankScene, flank_truth, render_flank};
use shadowgauge::studies::flanks::{self, FlankPlan};
use shadowgauge::studies::worn_flanks;
use shadowgauge::tool::wear::WearLimits;

const SIZE: (u32, u32) = (360, 240);
const UM_PER_PX: f64 = 4.0;

fn small_forest() -> Forest {
    let one = |seed: u64| {
        let (frame, mask, _) = render_flank(&FlankScene::drawn(seed, SIZE, UM_PER_PX), seed).unwrap();
        let image = Raster::of(&frame.view()).unwrap();
        let values = mask.iter().map(|m| f32::from(u8::from(*m > 0))).collect();
        let mask = Raster { rows: image.rows, columns: image.columns, values };
        locate(&image, UM_PER_PX, KnownEdge::default()).ok().map(|flank| Labelled::new(flank, &mask))
    };
    let all: Vec<Labelled> = (1..4).filter_map(one).collect();
    train(&drawn(&all, 1), &Growth { trees: 4, depth: 5, ..Growth::default() })
}

#[test]
fn flanks_and_their_summary_are_the_same_at_any_number_of_threads() {
    let forest = small_forest();
    let plan =
        FlankPlan { model: &forest, size: SIZE, um_per_px: UM_PER_PX, seed: 900, side: FlankSide::Any };
    let run = || flanks::run(&plan, 4, &|| {}).unwrap();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(run);
    assert_eq!(one, run());
    let summary = flanks::summary(&one, UM_PER_PX);
    assert_eq!(summary.measured + summary.refused, 4);
    let errors: Vec<f64> = one.iter().filter_map(|r| Some(r.vbb()?.0.powi(2))).collect();
    let rms_px = (errors.iter().sum::<f64>() / errors.len() as f64).sqrt() / UM_PER_PX;
    assert!((summary.vbb.rms_px - rms_px).abs() < 1e-9, "{summary:?}");
}

/// Widths are linear in the wear's lengths, so that VBB or VBBmax lies where it is drawn.
#[test]
fn tools_are_drawn_about_their_limits() {
    let (forest, limits) = (small_forest(), WearLimits::default());
    let plan = FlankPlan { model: &forest, size: (640, 480), um_per_px: 3.5, seed: 1, side: FlankSide::Any };
    let (mut blunt, mut sharp) = (0, 0);
    for seed in 1..41 {
        let truth = flank_truth(&worn_flanks::scene(&plan, seed, &limits), seed);
        let by_mean = seed % 2 == 0;
        let over = if by_mean { truth.vb_um / limits.vbb_um } else { truth.vb_max_um / limits.vbb_max_um };
        assert!((over - 1.0).abs() <= 0.121, "{seed}: {over}");
        if over > 1.0 { blunt += 1 } else { sharp += 1 }
    }
    assert!(blunt >= 15 && sharp >= 15, "{blunt} {sharp}");
}
