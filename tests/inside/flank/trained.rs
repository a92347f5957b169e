//! Forests from rendered flanks: the same bytes again, and what the trees disagree about is in u.

use shadowgauge::gauge::flank::forest::{file, training::Growth};
use shadowgauge::gauge::flank::{
    FlankSettings, KnownEdge, Labelled, Raster, drawn, locate, measure_flank, train,
};
use shadowgauge::render::flank::{FlankScene, render_flank};

const UM_PER_PX: f64 = 4.0;

fn labelled(seed: u64) -> Option<Labelled> {
    let scene = FlankScene::drawn(seed, (360, 240), UM_PER_PX);
    let (frame, mask, _) = render_flank(&scene, seed).unwrap();
    let image = Raster::of(&frame.view()).unwrap();
    let values = mask.iter().map(|m| f32::from(u8::from(*m > 0))).collect();
    let mask = Raster { rows: image.rows, columns: image.columns, values };
    locate(&image, UM_PER_PX, KnownEdge::default()).ok().map(|flank| Labelled::new(flank, &mask))
}

#[test]
fn training_twice_gives_the_same_bytes() {
    let all: Vec<Labelled> = (1..6).filter_map(labelled).collect();
    assert!(all.len() >= 3, "{}", all.len());
    let growth = Growth { trees: 4, depth: 6, ..Growth::default() };
    let bytes = |seed: u64| file::write(&train(&drawn(&all, seed), &Growth { seed, ..growth })).unwrap();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(|| bytes(3));
    assert!(one == bytes(3) && one != bytes(4));
}

/// Trees that do not agree widen u; a forest of one tree has nobody to disagree with.
#[test]
fn what_trees_disagree_about_is_in_the_models_row() {
    let all: Vec<Labelled> = (1..4).filter_map(labelled).collect();
    let forest = train(&drawn(&all, 1), &Growth { trees: 4, depth: 5, ..Growth::default() });
    let mut single = forest.clone();
    single.second.truncate(1);
    let (frame, _, _) = render_flank(&FlankScene::default(), 11).unwrap();
    let of = |forest| measure_flank(&frame.view(), &FlankSettings::at_scale(2.415), forest).unwrap();
    assert!(of(&forest).budget.model_um > 0.0);
    assert_eq!(of(&single).budget.model_um, 0.0);
}
