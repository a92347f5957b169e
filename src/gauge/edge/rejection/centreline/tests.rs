//! Of the axis where blocks disagree.

use super::*;

/// The least-squares parabola and the axis taken of 32 blocks on a wave of ±0.15 px, the part bent
/// by `bend` px over half the field, its width the same everywhere.
fn axes(bend: f64) -> [Vector3<f64>; 2] {
    let block = |index: usize| {
        let x = (2 * index + 1) as f64 / 32.0 - 1.0;
        let middle = bend * x * x + 0.15 * (9.0 * x).sin();
        Block { index, x, middle, width: 0.0 }
    };
    let mut scratch = AxisScratch { blocks: (0..32).map(block).collect(), ..AxisScratch::default() };
    let plain = scratch.plain().unwrap();
    [plain, scratch.axis(plain, 0.01).unwrap()]
}

/// A shaft that is wavy, and bends by a fifth of a pixel of its own, lies about its parabola; a
/// parabola of nearly half a pixel is no shaft's, and the axis on which half of the field lies
/// takes its place.
#[test]
fn a_wavy_part_keeps_its_parabola_where_a_part_may_bend_so() {
    let [plain, axis] = axes(0.2);
    assert_eq!(plain, axis);
    let [plain, axis] = axes(0.45);
    assert!((plain - axis).norm() > 0.01, "{plain} {axis}");
}
