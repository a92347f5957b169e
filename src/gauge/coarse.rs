//! Where the part is: the largest shadow of a thinned image, then whole-pixel edges along its border.
//!
//! The thinned image keeps every s-th pixel (s at most a third of the smallest part), is split at the level that
//! separates its grey values best (Otsu), and its largest connected shadow is the part. Specks of dirt, holes and
//! neighbours that peep in at the border are other components and never seen again.

use image::{GrayImage, Luma};
use imageproc::region_labelling::{Connectivity, connected_components};

use super::pixels::{Plane, Sample};
use super::settings::GaugeSettings;
use crate::profile::Reason;

/// Cells a side of the thinned image, at most.
const CELLS: usize = 256;
/// (Difference of the two class means)²/(variance inside the classes) that two levels must exceed: a Gaussian noise
/// image reaches 7.0, a uniform one or a plain ramp 12.
const TWO_LEVELS: f64 = 16.0;

/// Rows that the shadow itself is looked for inside a stretch of dimmed light.
const INWARDS: usize = 256;

/// A whole-pixel edge: the shadow's outermost pixel, or why there is none.
pub(crate) type CoarseEdge = Result<i32, Reason>;

/// Whole-pixel edges of the part.
#[derive(Clone, Debug)]
pub(crate) struct Coarse {
    /// First shadow row of each column.
    pub(crate) top: Vec<CoarseEdge>,
    /// Last shadow row of each column.
    pub(crate) bottom: Vec<CoarseEdge>,
}

/// The thinned image: one cell stands for `step` rows x `step` columns.
struct Thinned {
    columns: usize,
    row_step: usize,
    column_step: usize,
    values: Vec<f32>,
}

/// Finds the part.
///
/// # Errors
/// The reason for which the frame shows no part.
pub(crate) fn find_part<T: Sample>(plane: &Plane<'_, T>, settings: &GaugeSettings) -> Result<Coarse, Reason> {
    let thinned = thin(plane, settings.min_diameter_px);
    let levels = separate(&thinned.values).ok_or(Reason::LowContrast)?;
    let spans = part_spans(&thinned, levels.threshold).ok_or(Reason::NoEdge)?;
    let mut coarse = Coarse { top: Vec::new(), bottom: Vec::new() };
    for column in 0..plane.columns {
        let (top, bottom) = refine(plane, &thinned, &spans, levels.shadow, column, settings.min_diameter_px);
        coarse.top.push(top);
        coarse.bottom.push(bottom);
    }
    explain(&coarse).map_or(Ok(coarse), Err)
}

/// Why no column has both edges, if so.
fn explain(coarse: &Coarse) -> Option<Reason> {
    let pairs = || coarse.top.iter().zip(&coarse.bottom);
    if pairs().any(|(t, b)| t.is_ok() && b.is_ok()) {
        None
    } else if pairs().any(|(t, b)| t.is_ok() != b.is_ok()) {
        Some(Reason::OneEdge)
    } else {
        Some(Reason::NoEdge)
    }
}

fn thin<T: Sample>(plane: &Plane<'_, T>, min_diameter_px: f64) -> Thinned {
    let finest = (min_diameter_px / 3.0).max(1.0) as usize;
    let step = |n: usize| n.div_ceil(CELLS).clamp(1, finest);
    let (row_step, column_step) = (step(plane.rows), step(plane.columns));
    let (rows, columns) = (plane.rows.div_ceil(row_step), plane.columns.div_ceil(column_step));
    let mut values = Vec::with_capacity(rows * columns);
    for row in 0..rows {
        for column in 0..columns {
            let (r, c) = (row * row_step, column * column_step);
            let next = (c + 1).min(plane.columns - 1);
            values.push(0.5 * (plane.at(r, c) + plane.at(r, next)));
        }
    }
    Thinned { columns, row_step, column_step, values }
}

/// Two levels of grey.
#[derive(Clone, Copy, Debug)]
struct TwoLevels {
    /// Otsu's threshold between them.
    threshold: f32,
    /// What is darker is the part's own shadow, not light dimmed by mist.
    shadow: f32,
}

/// Share of the way from shadow to light below which a pixel is shadow.
const SHADOW: f64 = 0.35;

/// The two levels, if the values fall into two at all.
fn separate(values: &[f32]) -> Option<TwoLevels> {
    const BINS: usize = 1024;
    let (low, high) =
        values.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    if !(high > low) {
        return None;
    }
    let scale = (BINS as f32 - 1.0) / (high - low);
    let mut histogram = [0.0_f64; BINS];
    for v in values {
        histogram[((v - low) * scale) as usize] += 1.0;
    }
    let total = values.len() as f64;
    let moment = |f: fn(f64) -> f64| histogram.iter().enumerate().map(|(i, n)| n * f(i as f64)).sum::<f64>();
    let (sum, square) = (moment(|i| i), moment(|i| i * i));
    let (mut count, mut partial, mut best) = (0.0, 0.0, (0.0, 0.0, 0.0));
    for (i, n) in histogram.iter().enumerate().take(BINS - 1) {
        count += n;
        partial += n * i as f64;
        if count == 0.0 || count == total {
            continue;
        }
        let (below, above) = (partial / count, (sum - partial) / (total - count));
        let between = count * (total - count) * (above - below).powi(2);
        if between > best.0 {
            best = (between, below, above);
        }
    }
    let (between, below, above) = best;
    let within = square / total - (sum / total).powi(2) - between / (total * total);
    let two_levels = (above - below).powi(2) > TWO_LEVELS * within.max(1.0 / 12.0);
    let grey = |bin: f64| low + (bin as f32 + 0.5) / scale;
    two_levels.then(|| TwoLevels {
        threshold: grey(0.5 * (below + above)),
        shadow: grey(below + SHADOW * (above - below)),
    })
}

/// First and last cell row of the largest shadow (four-connected) in each cell column; of two as large the first.
fn part_spans(thinned: &Thinned, threshold: f32) -> Option<Vec<Option<(usize, usize)>>> {
    let rows = thinned.values.len() / thinned.columns;
    let dark = thinned.values.iter().map(|v| u8::from(*v < threshold)).collect();
    let dark = GrayImage::from_raw(thinned.columns as u32, rows as u32, dark)?;
    let labels = connected_components(&dark, Connectivity::Four, Luma([0]));
    let largest = largest_label(labels.as_raw())?;
    let mut spans: Vec<Option<(usize, usize)>> = vec![None; thinned.columns];
    for (cell, _) in labels.as_raw().iter().enumerate().filter(|(_, label)| **label == largest) {
        let (row, column) = (cell / thinned.columns, cell % thinned.columns);
        let (first, last) = spans[column].unwrap_or((row, row));
        spans[column] = Some((first.min(row), last.max(row)));
    }
    Some(spans)
}

/// The label that most cells carry, the smallest of equals; 0 is no shadow.
fn largest_label(labels: &[u32]) -> Option<u32> {
    let mut sizes = vec![0_usize; labels.iter().max().map_or(0, |l| *l as usize) + 1];
    for label in labels {
        sizes[*label as usize] += 1;
    }
    let most = sizes.iter().skip(1).max()?;
    sizes.iter().skip(1).position(|size| size == most).map(|index| index as u32 + 1)
}

fn refine<T: Sample>(
    plane: &Plane<'_, T>,
    thinned: &Thinned,
    spans: &[Option<(usize, usize)>],
    threshold: f32,
    column: usize,
    min_diameter_px: f64,
) -> (CoarseEdge, CoarseEdge) {
    let cell = column / thinned.column_step;
    let nearest = if column % thinned.column_step > thinned.column_step / 2 { cell + 1 } else { cell };
    let span = spans.get(nearest).copied().flatten().or_else(|| spans[cell]);
    let Some((first, last)) = span else { return (Err(Reason::NoEdge), Err(Reason::NoEdge)) };
    let (first, last) = (first * thinned.row_step, (last * thinned.row_step).min(plane.rows - 1));
    let reach = 4 * thinned.row_step.max(thinned.column_step) + 8;
    let top = walk_out(plane, column, first, false, threshold, reach);
    let bottom = walk_out(plane, column, last, true, threshold, reach);
    match (top, bottom) {
        (Ok(t), Ok(b)) if f64::from(b - t) < min_diameter_px => (Err(Reason::NoEdge), Err(Reason::NoEdge)),
        pair => pair,
    }
}

/// From a shadow pixel (or one near the border of the shadow) outwards to the last shadow pixel.
fn walk_out<T: Sample>(
    plane: &Plane<'_, T>,
    column: usize,
    start: usize,
    down: bool,
    threshold: f32,
    reach: usize,
) -> CoarseEdge {
    let outward: i32 = if down { 1 } else { -1 };
    let inside = |row: i32| row >= 0 && (row as usize) < plane.rows;
    let dark = |row: i32| inside(row) && plane.at(row as usize, column) < threshold;
    let mut row = start as i32;
    let mut budget = INWARDS.max(reach);
    while !(dark(row) && dark(row - outward)) {
        row -= outward;
        budget -= 1;
        if budget == 0 || !inside(row) {
            return Err(Reason::NoEdge);
        }
    }
    budget = 4 * reach;
    // Two light pixels in a row end the shadow, one may be noise.
    while inside(row + outward) && (dark(row + outward) || dark(row + 2 * outward)) {
        row += outward;
        budget -= 1;
        if budget == 0 {
            return Err(Reason::Outlier);
        }
    }
    if inside(row + outward) { Ok(row) } else { Err(Reason::OneEdge) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_and_ramps_have_no_two_levels() {
        let ramp: Vec<f32> = (0..10_000).map(|i| i as f32).collect();
        assert!(separate(&ramp).is_none());
        assert!(separate(&[7.0; 100]).is_none());
        let mut state = 1_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1_u64 << 24) as f32
        };
        let noise: Vec<f32> = (0..10_000).map(|_| (0..12).map(|_| uniform()).sum::<f32>() * 20.0).collect();
        assert!(separate(&noise).is_none());
        let shadow: Vec<f32> =
            (0..10_000).map(|i| if i % 100 == 0 { 20.0 } else { 200.0 } + uniform()).collect();
        let threshold = separate(&shadow).unwrap().threshold;
        assert!((30.0..190.0).contains(&threshold));
    }
}
