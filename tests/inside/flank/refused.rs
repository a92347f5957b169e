//! What shows no flank, or no whole land, gives no number.

use shadowgauge::frame::{FrameView, PixelFormat, Pixels};
use shadowgauge::gauge::flank::{FlankError, FlankSettings, FlankSide, measure_flank, shipped};
use shadowgauge::render::flank::{FlankScene, render_flank};

fn measured(pixels: &[u8], columns: usize) -> Result<(), FlankError> {
    let rows = pixels.len() / columns;
    let view = FrameView::new(Pixels::U8(pixels), PixelFormat::Mono8, rows, columns, columns).unwrap();
    measure_flank(&view, &FlankSettings::at_scale(2.4), &shipped().unwrap()).map(|_| ())
}

#[test]
fn an_empty_picture_has_no_flank() {
    assert!(matches!(measured(&[80; 400 * 300], 400), Err(FlankError::NoFlank { .. })));
    let noise: Vec<u8> =
        (0..400_u32 * 300).map(|k| 80 + (k.wrapping_mul(2_654_435_761) >> 29) as u8).collect();
    assert!(matches!(measured(&noise, 400), Err(FlankError::NoFlank { .. })));
    assert!(matches!(measured(&[80; 64 * 64], 64), Err(FlankError::TooSmall { .. })));
}

/// A side of the body stands out as the edge does: once it was measured instead. Where the flank's
/// side is stated the edge is found, and the width within its uncertainty.
#[test]
fn a_side_of_the_body_is_not_taken_for_the_edge() {
    for seed in [100_061, 100_076] {
        let scene = FlankScene::drawn(seed, (900, 560), 2.415);
        let (frame, _, truth) = render_flank(&scene, seed).unwrap();
        let by = |side: FlankSide| {
            let settings = FlankSettings { side, ..FlankSettings::at_scale(scene.um_per_px) };
            measure_flank(&frame.view(), &settings, &shipped().unwrap())
        };
        let FlankError::TwoEdges { row, other_row, .. } = by(FlankSide::Any).unwrap_err() else {
            panic!("{seed}: refused for another reason");
        };
        // the edge itself runs through the upper half
        assert!(row.min(other_row) < 280.0 && row.max(other_row) > 280.0, "{seed}: {row}, {other_row}");
        let vbb = by(FlankSide::Below).unwrap().vbb;
        assert!((vbb.um - truth.vb_um).abs() < 2.0 * vbb.u_um, "{seed}: {vbb:?} of {}", truth.vb_um);
    }
}

/// A side at which no edge lies is no edge's because it is stated: refused with the place of the
/// one that stands out. One that could be the edge's is taken, and flagged; without a land it is
/// refused.
#[test]
fn a_side_that_is_stated_wrongly_is_refused() {
    let (mut refused, mut flagged) = (0, 0);
    for seed in [100_011, 100_012, 100_013, 100_014] {
        let scene = FlankScene::drawn(seed, (900, 560), 2.415);
        let (frame, _, _) = render_flank(&scene, seed).unwrap();
        for side in [FlankSide::Right, FlankSide::Above, FlankSide::Left] {
            let settings = FlankSettings { side, ..FlankSettings::at_scale(scene.um_per_px) };
            match measure_flank(&frame.view(), &settings, &shipped().unwrap()) {
                Err(FlankError::OtherSide { .. }) => refused += 1,
                // a border of the body, or no smooth one
                Err(_) => {}
                Ok(found) => {
                    assert!(found.flags.contains(&"side_as_stated"), "{seed}, {side:?}: {:?}", found.flags);
                    assert!(!found.flags.contains(&"no_land"), "{seed}, {side:?}: {:?}", found.vbb);
                    flagged += 1;
                }
            }
        }
    }
    assert!(refused >= 9, "{refused} refused, {flagged} flagged");
}

/// Of two borders the stated one may be the lighter; that it was taken for its side is flagged.
#[test]
fn a_border_that_is_taken_for_its_stated_side_is_flagged() {
    let scene = FlankScene::drawn(100_143, (640, 480), 2.415);
    let (frame, _, _) = render_flank(&scene, 100_143).unwrap();
    let flags = |side: FlankSide| {
        let settings = FlankSettings { side, ..FlankSettings::at_scale(scene.um_per_px) };
        measure_flank(&frame.view(), &settings, &shipped().unwrap()).unwrap().flags
    };
    assert!(flags(FlankSide::Left).contains(&"side_as_stated"), "{:?}", flags(FlankSide::Left));
    assert!(!flags(FlankSide::Below).contains(&"side_as_stated"), "{:?}", flags(FlankSide::Below));
    assert!(!flags(FlankSide::Any).contains(&"side_as_stated"), "{:?}", flags(FlankSide::Any));
}

#[test]
fn a_land_that_leaves_the_field_is_refused() {
    let mut scene = FlankScene::default();
    scene.wear.vb_um = 400.0;
    scene.edge.depth_um = 2000.0;
    scene.rows = 300;
    let (frame, _, _) = render_flank(&scene, 2).unwrap();
    let found = measure_flank(&frame.view(), &FlankSettings::at_scale(scene.um_per_px), &shipped().unwrap());
    assert!(matches!(found, Err(FlankError::LeavesField { .. })), "{:?}", found.map(|f| f.vbb));
}

/// A flank and a land in full light, most of the texture saturated: the border is not seen, whether
/// a land is found or not.
#[test]
fn glare_over_the_land_is_refused() {
    let mut scene = FlankScene::default();
    (scene.surface.land, scene.surface.streaks, scene.surface.adhesion) = (1.0, 0.0, 0.0);
    (scene.surface.flank, scene.surface.texture, scene.surface.glare) = (1.0, 0.3, 5.0);
    let (frame, _, _) = render_flank(&scene, 2).unwrap();
    let settings = FlankSettings { full_scale: 255.0, ..FlankSettings::at_scale(scene.um_per_px) };
    let found = measure_flank(&frame.view(), &settings, &shipped().unwrap());
    assert!(matches!(found, Err(FlankError::Glare { .. })), "{:?}", found.map(|f| (f.vbb, f.flags)));
}
