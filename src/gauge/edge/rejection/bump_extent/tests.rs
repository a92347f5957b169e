//! Of how far a local bump extends.

use super::*;

/// A field of 256 columns whose width is `width` px more than elsewhere, with a refused stretch.
fn extended(refused: std::ops::Range<usize>, width: impl Fn(usize) -> f32) -> Vec<usize> {
    let mut scratch = AxisScratch {
        departures: vec![0.0; 256],
        widths: (0..256).map(width).collect(),
        refused: (0..256).map(|c| refused.contains(&c)).collect(),
        ..AxisScratch::default()
    };
    scratch.extend_to_base();
    (0..256).filter(|c| scratch.refused[*c]).collect()
}

/// A film that runs out in steps: 0.3 px and then 0.12 px of its height of 1 px, its flank refused.
/// It ends where less than a fifth of it is left; from there on the width falls to its base.
#[test]
fn a_bump_ends_at_a_fifth_of_its_height() {
    let film = |c: usize| match c {
        105..135 => 1.0,
        135..151 => 0.3,
        151..167 => 0.12,
        _ => 0.0,
    };
    assert_eq!(extended(100..111, film), (100..167).collect::<Vec<_>>());
}

/// Behind three refused columns the shadow is wider for 24 columns: by 0.7 px, a slope of 13°, that
/// is a bump whose flank they are; by 1.4 px, a slope of 25°, they are the shoulder of a collar.
#[test]
fn a_rise_steeper_than_what_adheres_is_a_shoulder() {
    let wider = |by: f32| move |c: usize| if (102..126).contains(&c) { by } else { 0.0 };
    assert_eq!(extended(100..103, wider(1.4)), [100, 101, 102]);
    let crossed = extended(100..103, wider(0.7));
    assert!(crossed.len() > 24 && crossed.contains(&125), "{crossed:?}");
}
