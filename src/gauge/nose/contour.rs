//! The coarse silhouette: the contour of the largest shadow, in runs within the frame.
//!
//! Of a large frame the shadow is sought in cells of several pixels, and its contour is followed
//! over the pixels themselves, which are looked at only there. Where anything in that is unclear,
//! all pixels are labelled.

use glam::DVec2;
use image::{GrayImage, Luma};
use imageproc::region_labelling::{Connectivity, connected_components};

use super::cells::{Cells, Smoothed};
use super::error::NoseImageError;
use super::limits::NoseLimits;
use crate::frame::{FrameView, PixelFormat};
use crate::gauge::ring::RingError;
use crate::gauge::ring::coarse::{Grey, threshold};

/// Places of a contour that does not touch the frame's border, the shadow on its left.
pub(super) type Run = Vec<DVec2>;

/// The runs of the contour of the insert.
pub(super) fn runs(view: &FrameView<'_>) -> Result<Vec<Run>, NoseImageError> {
    match by_cells(view) {
        Some(runs) => Ok(runs),
        None => by_pixels(view),
    }
}

/// With every pixel labelled.
fn by_pixels(view: &FrameView<'_>) -> Result<Vec<Run>, NoseImageError> {
    let (grey, level) = grey_and_level(view)?;
    let labels = labelled(&grey, level);
    let own = largest(&labels, grey.columns, 1)?;
    let (rows, columns) = (grey.rows, grey.columns);
    let inside = |row: usize, column: usize| labels[row * columns + column] == own;
    let start = labels.iter().position(|l| *l == own).map(|at| (at / columns, at % columns));
    let corners = start.map_or_else(Vec::new, |start| trace(start, (rows, columns), inside));
    let runs = split(&corners, (rows, columns));
    if runs.is_empty() {
        return Err(NoseImageError::NoInsert { why: "the shadow fills the field".to_owned() });
    }
    Ok(runs)
}

/// The same contour, of a shadow found in cells; `None` of a small frame, and where cells do not
/// show one insert whose contour encloses them.
fn by_cells(view: &FrameView<'_>) -> Option<Vec<Run>> {
    let cells = Cells::of(view)?;
    let level = threshold(&cells.grey, !matches!(view.format(), PixelFormat::F32)).ok()?;
    let labels = labelled(&cells.grey, level);
    let own = largest(&labels, cells.grey.columns, cells.side).ok()?;
    let covered = labels.iter().filter(|l| **l == own).count() * cells.side * cells.side;
    let pixels = Smoothed(view);
    let inside = |row: usize, column: usize| f64::from(pixels.at(row, column)) < level;
    let start = cells.top_of(&labels, own, inside)?;
    let size = (view.rows(), view.columns());
    let corners = trace(start, size, inside);
    if !(enclosed(&corners) > NoseLimits::get().enclosed * covered as f64) {
        return None;
    }
    let runs = split(&corners, size);
    (!runs.is_empty()).then_some(runs)
}

/// Area within closed corners, the shadow on their left, px²; negative around a hole.
fn enclosed(corners: &[(isize, isize)]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    let twice: isize = corners.iter().zip(next).map(|(a, b)| a.0 * b.1 - a.1 * b.0).sum();
    0.5 * twice as f64
}

/// Components of what is darker than the level, 4-connected; 0 is light.
fn labelled(grey: &Grey, level: f64) -> Vec<u32> {
    let image = GrayImage::from_fn(grey.columns as u32, grey.rows as u32, |c, r| {
        let value = f64::from(grey.values[r as usize * grey.columns + c as usize]);
        Luma([if value < level { 255 } else { 0 }])
    });
    connected_components(&image, Connectivity::Four, Luma([0])).into_raw()
}

/// Grey values, and the level between shadow and light.
pub(super) fn grey_and_level(view: &FrameView<'_>) -> Result<(Grey, f64), NoseImageError> {
    let ring = |e: RingError| match e {
        RingError::NotFinite { row, column } => NoseImageError::NotFinite { row, column },
        other => NoseImageError::NoInsert { why: other.to_string() },
    };
    let grey = Grey::read(view, false).map_err(ring)?.without_stuck_lines();
    let level = threshold(&grey, !matches!(view.format(), PixelFormat::F32)).map_err(|e| match e {
        RingError::LowContrast { contrast, noise, .. } => NoseImageError::NoInsert {
            why: format!(
                "the grey values do not fall into light and shadow (halves {contrast:.1} counts apart, scatter {noise:.1})"
            ),
        },
        other => ring(other),
    })?;
    Ok((grey, level))
}

/// Label of the largest shadow, the only one that is no contamination; of cells of `side` px.
fn largest(labels: &[u32], columns: usize, side: usize) -> Result<u32, NoseImageError> {
    let limits = NoseLimits::get();
    let area = side * side;
    let count = labels.iter().max().map_or(0, |m| *m as usize);
    let mut sums = vec![(0_usize, 0_usize, 0_usize); count + 1];
    for (at, label) in labels.iter().enumerate().filter(|(_, l)| **l > 0) {
        let sum = &mut sums[*label as usize];
        *sum = (sum.0 + area, sum.1 + at / columns, sum.2 + at % columns);
    }
    let mut order: Vec<usize> = (1..=count).collect();
    order.sort_by_key(|l| (std::cmp::Reverse(sums[*l].0), *l));
    let first = order.first().map_or(0, |l| sums[*l].0);
    if first < limits.least_area {
        let why = format!("the largest shadow has {first} px, an insert {} or more", limits.least_area);
        return Err(NoseImageError::NoInsert { why });
    }
    if let Some(sum) = order.get(1).map(|l| sums[*l])
        && sum.0 as f64 >= limits.second_part * first as f64
    {
        let (row, column) = (side * area * sum.1 / sum.0, side * area * sum.2 / sum.0);
        return Err(NoseImageError::TwoInserts { first, second: sum.0, row, column });
    }
    Ok(order[0] as u32)
}

/// Corners (row, column) of the closed contour of what is `inside`, the shadow on its left: pixel
/// (r, c) has the corners (r, c) to (r + 1, c + 1). It begins above `first`, a pixel under light.
fn trace(
    first: (usize, usize),
    (rows, columns): (usize, usize),
    inside: impl Fn(usize, usize) -> bool,
) -> Vec<(isize, isize)> {
    // right, up, left, down
    let steps: [(isize, isize); 4] = [(0, 1), (-1, 0), (0, -1), (1, 0)];
    let shadow = |(row, column): (isize, isize)| {
        let within = row >= 0 && column >= 0 && row < rows as isize && column < columns as isize;
        within && inside(row as usize, column as usize)
    };
    // from the upper right corner of a pixel leftwards, the pixel below on the left
    let (mut at, mut heading) = ((first.0 as isize, first.1 as isize + 1), 2_usize);
    let begin = (at, heading);
    let mut corners = Vec::new();
    loop {
        corners.push(at);
        at = (at.0 + steps[heading].0, at.1 + steps[heading].1);
        // pixels ahead on the left and on the right
        let (left, right) = match heading {
            0 => ((at.0 - 1, at.1), (at.0, at.1)),
            1 => ((at.0 - 1, at.1 - 1), (at.0 - 1, at.1)),
            2 => ((at.0, at.1 - 1), (at.0 - 1, at.1 - 1)),
            _ => ((at.0, at.1), (at.0, at.1 - 1)),
        };
        heading = match (shadow(left), shadow(right)) {
            (false, _) => (heading + 1) % 4,
            (true, true) => (heading + 3) % 4,
            (true, false) => heading,
        };
        if (at, heading) == begin || corners.len() > 4 * rows * columns {
            return corners;
        }
    }
}

/// The runs between touches of the frame's border, as smoothed places.
fn split(corners: &[(isize, isize)], (rows, columns): (usize, usize)) -> Vec<Run> {
    let n = corners.len();
    let touches =
        |c: &(isize, isize)| c.0 == 0 || c.1 == 0 || c.0 == rows as isize || c.1 == columns as isize;
    let place = |c: &(isize, isize)| DVec2::new(c.1 as f64 - 0.5, 0.5 - c.0 as f64);
    let Some(first) = corners.iter().position(touches) else {
        // the whole insert: once around, and the nose may lie at the beginning
        let twice: Vec<DVec2> = (0..n + n / 2).map(|k| place(&corners[k % n])).collect();
        return smoothed(&twice).into_iter().collect();
    };
    let turned: Vec<(isize, isize)> = (0..n).map(|k| corners[(first + k) % n]).collect();
    turned.split(touches).filter_map(|run| smoothed(&run.iter().map(place).collect::<Vec<_>>())).collect()
}

/// Means over neighbouring corners: the steps of the pixels are gone.
fn smoothed(corners: &[DVec2]) -> Option<Run> {
    let windows = corners.windows(2 * NoseLimits::get().mean_half + 1);
    let run: Run = windows.map(|w| w.iter().sum::<DVec2>() / w.len() as f64).collect();
    (run.len() > 1).then_some(run)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Pixels;

    /// A shadow with a hole and a notch, and a speck beside it, in noise; 12 bit.
    fn frame(rows: usize, columns: usize) -> Vec<u16> {
        let shadow = |r: f64, c: f64| {
            let body = c > 0.35 * columns as f64 && r < 0.7 * rows as f64 + 0.3 * c && r > 40.0;
            let hole = (r - 300.0).hypot(c - 700.0) < 60.0;
            let notch = (r - 42.0).abs() < 9.0 && (c - 800.0).abs() < 5.0;
            let speck = (r - 100.0).hypot(c - 60.0) < 12.0;
            body && !hole && !notch || speck
        };
        let noise = |k: usize| ((k as f64 * 0.618_033_988_7).fract() - 0.5) * 200.0;
        let at = |k: usize| {
            let dark = shadow((k / columns) as f64, (k % columns) as f64);
            (if dark { 300.0 } else { 3000.0 } + noise(k)) as u16
        };
        let mut values: Vec<u16> = (0..rows * columns).map(at).collect();
        // a stuck row, and hot pixels
        values[200 * columns..201 * columns].fill(4095);
        (0..50).for_each(|k| values[(k * 7919) % (rows * columns)] = 4095);
        values
    }

    #[test]
    fn a_contour_by_cells_is_that_by_pixels() {
        let (rows, columns) = (900, 1100);
        let values = frame(rows, columns);
        let view = FrameView::new(Pixels::U16(&values), PixelFormat::Mono12, rows, columns, columns).unwrap();
        let (cells, pixels) = (by_cells(&view).unwrap(), by_pixels(&view).unwrap());
        assert!(cells.len() == pixels.len() && !cells.is_empty(), "{} {}", cells.len(), pixels.len());
        for run in &cells {
            assert!(pixels.contains(run), "a run of {} places", run.len());
        }
    }

    #[test]
    fn what_cells_cannot_show_is_left_to_the_pixels() {
        let (rows, columns) = (900, 1100);
        // two parts whose gap of one pixel vanishes in cells
        let values: Vec<u16> = (0..rows * columns)
            .map(|k| match (k / columns, k % columns) {
                (r, c) if r > 300 && c != 601 && c > 200 => 300,
                _ => 3000,
            })
            .collect();
        let view = FrameView::new(Pixels::U16(&values), PixelFormat::Mono12, rows, columns, columns).unwrap();
        // the median of three closes it as well: one insert, by either
        assert_eq!(by_cells(&view).is_some(), by_pixels(&view).is_ok());
        let small =
            FrameView::new(Pixels::U16(&values[..90_000]), PixelFormat::Mono12, 300, 300, 300).unwrap();
        assert!(by_cells(&small).is_none());
    }
}
