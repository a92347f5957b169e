//! The coarse silhouette: the contour of the largest shadow, in runs within the frame.

use glam::DVec2;
use image::{GrayImage, Luma};
use imageproc::region_labelling::{Connectivity, connected_components};

use super::error::NoseImageError;
use super::limits::NoseLimits;
use crate::frame::{FrameView, PixelFormat};
use crate::gauge::ring::RingError;
use crate::gauge::ring::coarse::{Grey, threshold};

/// Places of a contour that does not touch the frame's border, the shadow on its left.
pub(super) type Run = Vec<DVec2>;

/// Shadow or light, with light around the frame.
struct Mask {
    labels: Vec<u32>,
    own: u32,
    rows: usize,
    columns: usize,
}

impl Mask {
    fn at(&self, row: isize, column: isize) -> bool {
        let inside = row >= 0 && column >= 0 && row < self.rows as isize && column < self.columns as isize;
        inside && self.labels[row as usize * self.columns + column as usize] == self.own
    }
}

/// The runs of the contour of the insert.
pub(super) fn runs(view: &FrameView<'_>) -> Result<Vec<Run>, NoseImageError> {
    let (grey, level) = grey_and_level(view)?;
    let image = GrayImage::from_fn(grey.columns as u32, grey.rows as u32, |c, r| {
        let value = f64::from(grey.values[r as usize * grey.columns + c as usize]);
        Luma([if value < level { 255 } else { 0 }])
    });
    let labels = connected_components(&image, Connectivity::Four, Luma([0])).into_raw();
    let own = largest(&labels, grey.columns)?;
    let mask = Mask { labels, own, rows: grey.rows, columns: grey.columns };
    let runs = split(&trace(&mask), &mask);
    if runs.is_empty() {
        return Err(NoseImageError::NoInsert { why: "the shadow fills the field".to_owned() });
    }
    Ok(runs)
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

/// Label of the largest shadow, the only one that is no contamination.
fn largest(labels: &[u32], columns: usize) -> Result<u32, NoseImageError> {
    let limits = NoseLimits::get();
    let count = labels.iter().max().map_or(0, |m| *m as usize);
    let mut sums = vec![(0_usize, 0_usize, 0_usize); count + 1];
    for (at, label) in labels.iter().enumerate().filter(|(_, l)| **l > 0) {
        let sum = &mut sums[*label as usize];
        *sum = (sum.0 + 1, sum.1 + at / columns, sum.2 + at % columns);
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
        let (row, column) = (sum.1 / sum.0, sum.2 / sum.0);
        return Err(NoseImageError::TwoInserts { first, second: sum.0, row, column });
    }
    Ok(order[0] as u32)
}

/// Corners (row, column) of the closed contour, the shadow on its left: pixel (r, c) has the
/// corners (r, c) to (r + 1, c + 1).
fn trace(mask: &Mask) -> Vec<(isize, isize)> {
    // right, up, left, down
    let steps: [(isize, isize); 4] = [(0, 1), (-1, 0), (0, -1), (1, 0)];
    let Some(start) = mask.labels.iter().position(|l| *l == mask.own) else { return Vec::new() };
    let first = ((start / mask.columns) as isize, (start % mask.columns) as isize);
    // from the upper right corner of the first pixel of its row leftwards, the pixel below on the
    // left
    let (mut at, mut heading) = ((first.0, first.1 + 1), 2_usize);
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
        heading = match (mask.at(left.0, left.1), mask.at(right.0, right.1)) {
            (false, _) => (heading + 1) % 4,
            (true, true) => (heading + 3) % 4,
            (true, false) => heading,
        };
        if (at, heading) == begin || corners.len() > 4 * mask.labels.len() {
            return corners;
        }
    }
}

/// The runs between touches of the frame's border, as smoothed places.
fn split(corners: &[(isize, isize)], mask: &Mask) -> Vec<Run> {
    let n = corners.len();
    let touches = |c: &(isize, isize)| {
        c.0 == 0 || c.1 == 0 || c.0 == mask.rows as isize || c.1 == mask.columns as isize
    };
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
