//! Of the courses through the blocks' blurs.

use super::*;

/// The blocks of a field of which two see the edge whole and a third in so many columns; the blur
/// grows by 0.01 px a block.
fn seen_in(count: f64) -> [BlurSums; BLOCKS] {
    let mut sums = [BlurSums::default(); BLOCKS];
    for (place, count) in [(1, 40.0), (3, 40.0), (6, count)] {
        let information = 10.0 * count;
        sums[place] =
            BlurSums { score: 0.01 * place as f64 * information, information, residual: count, count };
    }
    sums
}

/// A part that stands in three places of the field: a line is laid through its blurs where each of
/// them is known from six columns or more.
#[test]
fn a_course_needs_three_blocks_of_six_columns() {
    assert!(parabola(&seen_in(4.0)).is_none());
    let course = parabola(&seen_in(9.0)).unwrap();
    // Eight blocks to the field.
    assert!((course[1] - 0.08).abs() < 1e-9 && course[2].abs() < 1e-9, "{course:?}");
}

/// Where the residuals are the edge model's, they are alike in every frame: χ² of a trend and a
/// bend is 6.4 by chance once in 25 frames, 12.9 once in 630 (two degrees of freedom, e^(−χ²/2)).
/// Where they are noise, the same course is taken as far as it is likely.
#[test]
fn a_course_among_systematic_residuals_must_be_significant() {
    let course = |chi2: f64, is_noise: bool| {
        // A trend β over blocks of information J each has χ² = β²·J·Σt²/variance, of which the
        // prior of three hundredths of the blur takes 0.1.
        let (variance, trend) = (1e-6, 0.01);
        let squares: f64 = (0..BLOCKS).map(|block| middle(block).powi(2)).sum();
        let information = (chi2 + 0.1) * variance / (trend * trend * squares);
        let sums: [BlurSums; BLOCKS] = std::array::from_fn(|block| BlurSums {
            score: trend * middle(block) * information,
            information,
            ..BlurSums::default()
        });
        likely_course(&sums, variance, 1.0, is_noise)
    };
    assert!(course(6.4, false).is_none());
    assert!(course(6.4, true).is_some());
    assert!(course(12.9, false).is_some());
}
