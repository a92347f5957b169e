//! From the line of most detail to the cutting edge above it.
//!
//! A smooth land has little detail, so that the search may end at the land's lower border. The
//! edge towards the air is sharp in any case, and what stands behind it is out of focus: in every
//! column the first sharp step from above is a place of the edge, and the line through most of
//! them (Theil and Sen's: medians of slopes and of offsets) is the one to follow.

use super::limits::FlankLimits;
use super::raster::{Raster, quantile};
use super::reference::EdgeLine;
use super::strip::Frame;

/// The line through the first sharp steps above a line; the line itself where there are few.
pub(super) fn lifted(image: &Raster, line: EdgeLine, um_per_px: f64) -> EdgeLine {
    let limits = FlankLimits::get();
    let frame = Frame::about(line, um_per_px, (limits.depth_um, limits.step_um));
    let (strip, _) = frame.cut(image);
    let places: Vec<(f64, f64)> = first_steps(&strip, frame.above)
        .into_iter()
        .map(|(column, row)| (frame.s_px(column as f64), frame.depth_um(row) / um_per_px))
        .collect();
    if 2 * places.len() < strip.columns {
        return line;
    }
    let (slope, offset_px) = theil_sen(&places);
    let size = slope.hypot(1.0);
    EdgeLine {
        from: line.from + line.normal * offset_px,
        along: (line.along + line.normal * slope) / size,
        normal: (line.normal - line.along * slope) / size,
        length_px: line.length_px * size,
    }
}

/// Column and row of the first step of every column that is sharp beside those about the line, and
/// above the noise.
fn first_steps(strip: &Raster, above: usize) -> Vec<(usize, usize)> {
    let limits = FlankLimits::get();
    // less its wide mean: what is out of focus rises slowly, however bright it is
    let (narrow, wide) = (strip.blurred(1.0, 6.0), strip.blurred(10.0, 6.0));
    let step = |r: usize, c: usize| (narrow.at(r, c) - wide.at(r, c)).abs();
    let all = |rows: std::ops::Range<usize>| {
        rows.flat_map(|r| (0..strip.columns).map(move |c| (r, c)))
            .map(|(r, c)| step(r, c))
            .collect::<Vec<f32>>()
    };
    let last = strip.rows - 1;
    let about = (2 * above).saturating_sub(strip.rows).max(1)..last;
    let sharp = quantile(all(about), 0.9) * limits.sharp_share as f32;
    // rows outside of the image repeat its border and have no steps at all
    let noisy =
        |rows: std::ops::Range<usize>| all(rows).into_iter().filter(|s| *s > 1e-3).collect::<Vec<f32>>();
    let first =
        (1..above.max(2)).step_by(10).map(|r| noisy(r..r + 10)).find(|v| 20 * v.len() > strip.columns * 90);
    let noise = quantile(first.unwrap_or_default(), 0.95) * limits.sharp_noise as f32;
    let least = sharp.max(noise);
    (0..strip.columns).filter_map(|c| (1..last).find(|r| step(*r, c) > least).map(|r| (c, r))).collect()
}

/// Slope and offset at 0 of the median line, of at most [`FlankLimits::line_places`] places.
fn theil_sen(places: &[(f64, f64)]) -> (f64, f64) {
    let some: Vec<(f64, f64)> = places
        .iter()
        .copied()
        .step_by(places.len().div_ceil(FlankLimits::get().line_places.max(2)))
        .collect();
    let slopes = some
        .iter()
        .enumerate()
        .flat_map(|(k, a)| some[k + 1..].iter().map(move |b| ((b.1 - a.1) / (b.0 - a.0)) as f32));
    let slope = f64::from(quantile(slopes.collect(), 0.5));
    let offsets = some.iter().map(|p| (p.1 - slope * p.0) as f32);
    (slope, f64::from(quantile(offsets.collect(), 0.5)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_line_leaves_outliers_aside() {
        let places: Vec<(f64, f64)> = (0..200)
            .map(|k| {
                let x = 3.0 * f64::from(k);
                (x, if k % 3 == 0 { -80.0 } else { 12.0 + 0.25 * x })
            })
            .collect();
        let (slope, offset) = theil_sen(&places);
        assert!((slope - 0.25).abs() < 1e-3 && (offset - 12.0).abs() < 0.5, "{slope} {offset}");
    }
}
