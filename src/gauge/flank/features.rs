//! What the forest is given of a pixel of the rectified strip: at four scales the Gaussian mean,
//! the gradient across and along the edge and the standard deviation; the same drawn out along the
//! edge, as lands are; the means of what lies between the edge and the pixel and of what lies below
//! it; and by how much the pixel's surroundings and what lies above differ from what lies below, as
//! a share of both: the same for any light.

use super::raster::Raster;
use super::strip::Frame;

/// Standard deviations of the scales, rows of the strip.
pub(crate) const SCALES: [f64; 4] = [1.0, 2.0, 4.0, 8.0];
/// Features a pixel.
pub(crate) const FEATURES: usize = 44;

/// The features of a strip: one raster a feature.
pub(crate) fn features(strip: &Raster, frame: &Frame) -> Vec<Raster> {
    let square = strip.map(|v| v * v);
    let mut all = Vec::with_capacity(FEATURES);
    for sigma in SCALES {
        let mean = strip.blurred(sigma, 0.5 * sigma);
        let deviation = deviation(&square.blurred(sigma, 0.5 * sigma), &mean);
        all.push(difference_down(&mean, sigma));
        all.push(difference_along(&mean, sigma));
        all.push(mean);
        all.push(deviation);
    }
    let detail = all[3].clone();
    for (down, along) in [(1.5, 12.0), (4.0, 12.0), (12.0, 24.0)] {
        let mean = strip.blurred(down, along);
        let deviation = deviation(&square.blurred(down, along), &mean);
        all.push(difference_down(&mean, down));
        all.push(mean);
        all.push(deviation);
    }
    all.extend(compared(strip, &detail, frame));
    all
}

/// Means above and below a pixel of grey values, of their detail and of its share in them, and how
/// the pixel's surroundings compare.
fn compared(strip: &Raster, detail: &Raster, frame: &Frame) -> Vec<Raster> {
    let near = 8.0;
    let mut all = Vec::new();
    let (soft, soft_detail) = (strip.blurred(4.0, near), detail.blurred(4.0, near));
    let contrast = share_of(&soft_detail, &soft);
    for of in [&soft, &soft_detail, &contrast] {
        let total = sums_down(of);
        let (over, under) = (above(&total, frame), [20, 60, 150].map(|rows| below(&total, rows)));
        all.push(compare(of, &under[1]));
        all.push(compare(of, &under[2]));
        all.push(compare(&over, &under[1]));
        all.push(over);
        all.extend(under.into_iter().take(2));
    }
    all.push(contrast);
    all
}

/// (a − b)/(|a| + |b|): −1 to 1; small values of both count as alike.
fn compare(a: &Raster, b: &Raster) -> Raster {
    let of = |(a, b): (&f32, &f32)| (a - b) / (a.abs() + b.abs() + 0.02);
    Raster { values: a.values.iter().zip(&b.values).map(of).collect(), ..*a }
}

/// Detail as a share of the grey value.
fn share_of(detail: &Raster, mean: &Raster) -> Raster {
    let of = |(d, m): (&f32, &f32)| d / (m.abs() + 0.05);
    Raster { values: detail.values.iter().zip(&mean.values).map(of).collect(), ..*detail }
}

fn deviation(square: &Raster, mean: &Raster) -> Raster {
    let values = square.values.iter().zip(&mean.values).map(|(s, m)| (s - m * m).max(0.0).sqrt());
    Raster { values: values.collect(), ..*mean }
}

/// Difference of places one standard deviation above and below.
fn difference_down(mean: &Raster, sigma: f64) -> Raster {
    let by = (sigma.round() as usize).max(1);
    let mut out = Raster::new(mean.rows, mean.columns);
    for row in 0..mean.rows {
        let (a, b) = (row.saturating_sub(by), (row + by).min(mean.rows - 1));
        for column in 0..mean.columns {
            out.values[row * mean.columns + column] = mean.at(b, column) - mean.at(a, column);
        }
    }
    out
}

/// Size of the difference of places before and behind.
fn difference_along(mean: &Raster, sigma: f64) -> Raster {
    let by = ((0.5 * sigma).round() as usize).max(1);
    let mut out = Raster::new(mean.rows, mean.columns);
    for row in 0..mean.rows {
        for column in 0..mean.columns {
            let (a, b) = (column.saturating_sub(by), (column + by).min(mean.columns - 1));
            out.values[row * mean.columns + column] = (mean.at(row, b) - mean.at(row, a)).abs();
        }
    }
    out
}

/// Sums of every column down to a row, that row left out; one row more than the strip.
pub(super) fn sums_down(from: &Raster) -> Raster {
    let mut total = Raster::new(from.rows + 1, from.columns);
    for row in 0..from.rows {
        for column in 0..from.columns {
            total.values[(row + 1) * from.columns + column] = total.at(row, column) + from.at(row, column);
        }
    }
    total
}

/// Mean from the reference down to a pixel.
fn above(total: &Raster, frame: &Frame) -> Raster {
    mean_of(total, |row| (frame.above.min(row), row.max(frame.above.min(row)) + 1))
}

/// Mean of so many rows below a pixel.
fn below(total: &Raster, rows: usize) -> Raster {
    let last = total.rows - 1;
    mean_of(total, move |row| ((row + 2).min(last - 1), (row + 2 + rows).min(last)))
}

/// Means down the columns over the rows that `range` gives of each row, by [`sums_down`].
pub(super) fn mean_of(total: &Raster, range: impl Fn(usize) -> (usize, usize)) -> Raster {
    let mut out = Raster::new(total.rows - 1, total.columns);
    for row in 0..out.rows {
        let (a, b) = range(row);
        for column in 0..total.columns {
            out.values[row * total.columns + column] =
                (total.at(b, column) - total.at(a, column)) / (b - a).max(1) as f32;
        }
    }
    out
}
