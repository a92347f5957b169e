//! Coarse search: the largest round shadow that lies wholly in the frame.

use glam::DVec2;
use image::{GrayImage, Luma};
use imageproc::region_labelling::{Connectivity, connected_components};
use std::f64::consts::TAU;

use super::super::form::Circle;
use super::{RingError, RingSettings};
use crate::frame::FrameView;

/// What the coarse search found, to a pixel or so.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coarse {
    /// Outline.
    pub(super) outer: Circle,
    /// Bore; `None` for a disc.
    pub(super) inner: Option<Circle>,
}

const DIRECTIONS: usize = 360;

/// Finds the part.
pub(super) fn find(view: &FrameView<'_>, settings: &RingSettings) -> Result<Coarse, RingError> {
    let threshold = threshold(view)?;
    let dark = |row: usize, column: usize| {
        view.get(row, column).is_some_and(|v| (f64::from(v) < threshold) != settings.bright_on_dark)
    };
    let (rows, columns) = (view.rows(), view.columns());
    let shadow = GrayImage::from_fn(columns as u32, rows as u32, |c, r| {
        Luma([if dark(r as usize, c as usize) { 255 } else { 0 }])
    });
    let labels = connected_components(&shadow, Connectivity::Four, Luma([0]));
    let (best, found) = largest_inside(labels.as_raw(), rows, columns);
    let coarse = outline(&best, columns)?;
    match coarse {
        Some(coarse) if coarse.outer.diameter() >= settings.min_diameter_px => Ok(coarse),
        _ => Err(RingError::NoPart { least: settings.min_diameter_px, found }),
    }
}

/// Middle between the means of the two classes that split the histogram best (iterative selection, Ridler & Calvard 1978).
fn threshold(view: &FrameView<'_>) -> Result<f64, RingError> {
    let mut values = Vec::new();
    for row in 0..view.rows() {
        for column in 0..view.columns() {
            let v = view.get(row, column).unwrap_or(f32::NAN);
            if !v.is_finite() {
                return Err(RingError::NotFinite { row, column });
            }
            if row % 2 == 0 && column % 2 == 0 {
                values.push(f64::from(v));
            }
        }
    }
    let mean = |over: &dyn Fn(f64) -> bool| {
        let (mut sum, mut squares, mut n) = (0.0, 0.0, 0.0_f64);
        for v in values.iter().copied().filter(|v| over(*v)) {
            sum += v;
            squares += v * v;
            n += 1.0;
        }
        (sum / n.max(1.0), (squares / n.max(1.0) - (sum / n.max(1.0)).powi(2)).max(0.0).sqrt(), n)
    };
    let mut level = mean(&|_| true).0;
    for _ in 0..50 {
        let (dark, light) = (mean(&|v| v < level), mean(&|v| v >= level));
        let next = 0.5 * (dark.0 + light.0);
        if (next - level).abs() < 1e-3 * (light.0 - dark.0).max(1e-9) {
            break;
        }
        level = next;
    }
    let (dark, light) = (mean(&|v| v < level), mean(&|v| v >= level));
    let (contrast, noise) = (light.0 - dark.0, dark.1.hypot(light.1));
    // Splitting pure Gaussian noise at its mean gives a contrast of 1.87 times the two halves' scatter.
    if dark.2 == 0.0
        || contrast < 2.5 * noise
        || contrast < 4.0 && !matches!(view.format(), crate::frame::PixelFormat::F32)
    {
        return Err(RingError::LowContrast { contrast, noise });
    }
    Ok(level)
}

/// Pixels of the largest component that keeps off the frame's border, and the number of components; of two as large the first.
fn largest_inside(labels: &[u32], rows: usize, columns: usize) -> (Vec<usize>, usize) {
    let count = labels.iter().max().map_or(0, |m| *m as usize);
    let (mut sizes, mut at_border) = (vec![0_usize; count + 1], vec![false; count + 1]);
    for (index, label) in labels.iter().enumerate() {
        let (row, column) = (index / columns, index % columns);
        sizes[*label as usize] += 1;
        at_border[*label as usize] |= row == 0 || column == 0 || row + 1 == rows || column + 1 == columns;
    }
    let best = (1..=count).filter(|l| !at_border[*l]).max_by_key(|l| (sizes[*l], std::cmp::Reverse(*l)));
    let pixels = best
        .map_or_else(Vec::new, |best| (0..labels.len()).filter(|i| labels[*i] as usize == best).collect());
    (pixels, count)
}

/// Circles of the outline and the bore, from the farthest and nearest pixels in each direction, around a centre that is moved
/// until the outline's first harmonic vanishes.
fn outline(pixels: &[usize], columns: usize) -> Result<Option<Coarse>, RingError> {
    if pixels.len() < 100 {
        return Ok(None);
    }
    let at = |p: &usize| DVec2::new((p % columns) as f64, (p / columns) as f64);
    let mut centre = pixels.iter().map(at).sum::<DVec2>() / pixels.len() as f64;
    let mut extremes = Vec::new();
    for _ in 0..4 {
        extremes = vec![(f64::INFINITY, 0.0_f64); DIRECTIONS];
        for p in pixels {
            let arm = at(p) - centre;
            let turn = arm.y.atan2(arm.x).rem_euclid(TAU) / TAU;
            let slot = &mut extremes[((turn * DIRECTIONS as f64) as usize).min(DIRECTIONS - 1)];
            *slot = (slot.0.min(arm.length()), slot.1.max(arm.length()));
        }
        let middle = median(extremes.iter().map(|e| e.1).collect());
        // Medians of opposite directions' differences would do as well; clipping the departures bounds the dirt's pull.
        let shift = extremes.iter().enumerate().map(|(k, e)| {
            let direction = DVec2::from_angle(TAU * (k as f64 + 0.5) / DIRECTIONS as f64);
            direction * (e.1 - middle).clamp(-0.1 * middle, 0.1 * middle) * (2.0 / DIRECTIONS as f64)
        });
        centre += shift.sum::<DVec2>();
    }
    let mut reach: Vec<f64> = extremes.iter().map(|e| e.1).collect();
    reach.sort_by(f64::total_cmp);
    let (low, high) = (reach[DIRECTIONS / 10], reach[DIRECTIONS - 1 - DIRECTIONS / 10]);
    if high - low > 0.05 * high + 2.0 {
        return Err(RingError::NotRound { inner: low, outer: high });
    }
    let outer = Circle { centre, radius: median(reach) + 0.5 };
    let bore = median(extremes.iter().map(|e| e.0).filter(|r| r.is_finite()).collect()) - 0.5;
    // In a disc the nearest pixel of a narrow sector stands some way off, too; a bore is empty.
    let in_bore = pixels.iter().filter(|p| at(p).distance(centre) < 0.5 * bore).count() as f64;
    let bored = bore > 6.0 && in_bore < 0.1 * std::f64::consts::PI * (0.5 * bore).powi(2);
    Ok(Some(Coarse { outer, inner: bored.then_some(Circle { centre, radius: bore }) }))
}

/// Median, 0 of nothing.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
