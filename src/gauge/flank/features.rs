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
pub(crate) const FEATURES: usize = 52;

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
    all.extend(directions(strip, frame));
    all
}

/// Direction of the texture by the structure tensor (Förstner, Gülch 1987) at a pixel, above and
/// below it, as cos 2θ and sin 2θ over the share that has a direction; and how far the directions
/// differ: the streaks of a land run otherwise than the grinding lines.
fn directions(strip: &Raster, frame: &Frame) -> Vec<Raster> {
    let fine = strip.blurred(1.0, 1.0);
    // columns lie twice as far apart as rows
    let down = difference(&fine, (1, 0)).map(|d| 0.5 * d);
    let along = difference(&fine, (0, 1)).map(|d| 0.25 * d);
    let product = |of: fn(f32, f32) -> f32| Raster {
        values: along.values.iter().zip(&down.values).map(|(a, d)| of(*a, *d)).collect(),
        ..*strip
    };
    let tensor = [product(|a, d| a * a - d * d), product(|a, d| 2.0 * a * d), product(|a, d| a * a + d * d)];
    let here = tensor.each_ref().map(|t| t.blurred(6.0, 6.0));
    let sums = tensor.each_ref().map(|t| sums_down(&t.blurred(0.0, 6.0)));
    let [over, under] = [sums.each_ref().map(|t| above(t, frame)), sums.each_ref().map(|t| below(t, 60))];
    let [here, over, under] = [here, over, under].map(|[c, s, e]| [of_energy(&c, &e), of_energy(&s, &e)]);
    let differences = [apart(&here, &under), apart(&over, &under)];
    here.into_iter().chain(over).chain(under).chain(differences).collect()
}

/// A part of the tensor over its trace; a gradient of a hundredth a row counts as none.
fn of_energy(part: &Raster, energy: &Raster) -> Raster {
    let of = |(p, e): (&f32, &f32)| p / (e + 1e-4);
    Raster { values: part.values.iter().zip(&energy.values).map(of).collect(), ..*part }
}

/// Distance of two directions as vectors of the double angle.
fn apart(a: &[Raster; 2], b: &[Raster; 2]) -> Raster {
    let of = |k: usize| (a[0].values[k] - b[0].values[k]).hypot(a[1].values[k] - b[1].values[k]);
    Raster { values: (0..a[0].values.len()).map(of).collect(), ..a[0] }
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
    difference(mean, ((sigma.round() as usize).max(1), 0))
}

/// Size of the difference of places before and behind.
fn difference_along(mean: &Raster, sigma: f64) -> Raster {
    difference(mean, (0, ((0.5 * sigma).round() as usize).max(1))).map(f32::abs)
}

/// Difference of places so many rows below or columns behind, and as many above or before.
fn difference(of: &Raster, (rows, columns): (usize, usize)) -> Raster {
    let mut out = Raster::new(of.rows, of.columns);
    for row in 0..of.rows {
        let (a, b) = (row.saturating_sub(rows), (row + rows).min(of.rows - 1));
        for column in 0..of.columns {
            let (left, right) = (column.saturating_sub(columns), (column + columns).min(of.columns - 1));
            out.values[row * of.columns + column] = of.at(b, right) - of.at(a, left);
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

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::super::reference::EdgeLine;
    use super::*;

    /// Stripes whose gradient points at 0, 30, 90 and 140 degrees, in a land of other stripes below
    /// it: cos 2θ and sin 2θ at a pixel, and the distance of both directions, |2 sin(θ₁ − θ₂)|.
    #[test]
    fn directions_are_those_of_the_stripes() {
        let line = EdgeLine { from: DVec2::ZERO, along: DVec2::X, normal: DVec2::Y, length_px: 240.0 };
        let frame = Frame::about(line, 2.0, (40.0, 360.0));
        let border = frame.above + 60;
        for (deg, other_deg) in [(0.0_f32, 90.0_f32), (30.0, 120.0), (90.0, 30.0), (140.0, 100.0)] {
            let mut strip = Raster::new(frame.above + frame.below, 120);
            for (k, value) in strip.values.iter_mut().enumerate() {
                // a column is two rows wide
                let (row, along) = ((k / 120) as f32, 2.0 * (k % 120) as f32);
                let at = if k / 120 < border { deg } else { other_deg }.to_radians();
                *value = 1.0 + 0.5 * (0.35 * (along * at.cos() + row * at.sin())).sin();
            }
            let all = directions(&strip, &frame);
            let (pixel, twice) = ((border - 30) * 120 + 60, 2.0 * deg.to_radians());
            for (found, expected) in
                [(all[0].values[pixel], twice.cos()), (all[1].values[pixel], twice.sin())]
            {
                assert!((found - expected).abs() < 0.1, "{deg}: {found} {expected}");
            }
            let apart = all[7].values[(border - 2) * 120 + 60];
            let expected = 2.0 * (deg - other_deg).to_radians().sin().abs();
            assert!((apart - expected).abs() < 0.2, "{deg} {other_deg}: {apart} {expected}");
        }
    }
}
