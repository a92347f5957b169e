//! Coarse search: the largest round shadow that lies wholly in the frame.

use glam::DVec2;
use image::{GrayImage, Luma};
use imageproc::region_labelling::{Connectivity, connected_components};
use std::f64::consts::TAU;

use super::super::form::Circle;
use super::error::RingError;
use super::settings::RingSettings;
use crate::frame::FrameView;
use crate::gauge::edge::image::valleys::{Bridged, Valleys, median_down};
use crate::gauge::limit::limits;
use crate::numerics::robust::median_of as median;

limits! {
    /// When a frame shows a ring.
    CoarseRingLimits = "ring_coarse";
    /// Most directions that an outline is looked at in: one a degree.
    most_directions: usize = 360;
    /// Arc between directions, px: the farthest pixel of a narrower sector stands well inside the
    /// outline.
    arc_px: f64 = 3.0;
    /// Least contrast over the scatter of light and shadow: splitting pure Gaussian noise at its
    /// mean gives 1.87 times the two halves' scatter.
    least_contrast: f64 = 2.5;
    /// Least contrast of whole counts: between fewer steps rounding is a shape of its own.
    least_counts: f64 = 4.0;
}

/// Result of the coarse search, to about a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coarse {
    /// Outline.
    pub(super) outer: Circle,
    /// Bore; `None` for a disc.
    pub(super) inner: Option<Circle>,
}

/// Grey values row by row, shadow below light whatever the part's polarity.
pub(in crate::gauge) struct Grey {
    /// Grey values, row by row.
    pub(in crate::gauge) values: Vec<f32>,
    /// Rows.
    pub(in crate::gauge) rows: usize,
    /// Columns.
    pub(in crate::gauge) columns: usize,
}

/// Finds the part: as the largest shadow of a frame with one level of light and one of shadow, else
/// as the largest one that stands between light in its own rows and columns, whatever the light's
/// level there.
pub(super) fn find(view: &FrameView<'_>, settings: &RingSettings) -> Result<Coarse, RingError> {
    let grey = Grey::read(view, settings.bright_on_dark)?.without_stuck_lines();
    let whole_counts = !matches!(view.format(), crate::frame::PixelFormat::F32);
    let by_levels = threshold(&grey, whole_counts).and_then(|t| {
        let shadow = grey.values.iter().map(|v| f64::from(*v) < t).collect::<Vec<bool>>();
        find_in(&shadow, &grey, settings)
    });
    match by_levels {
        Ok(coarse) => Ok(coarse),
        Err(error) => find_in(&grey.between_light(), &grey, settings).map_err(|_| error),
    }
}

/// Finds the largest round part among the pixels that are shadow.
fn find_in(shadow: &[bool], grey: &Grey, settings: &RingSettings) -> Result<Coarse, RingError> {
    let image = GrayImage::from_fn(grey.columns as u32, grey.rows as u32, |c, r| {
        Luma([if shadow[r as usize * grey.columns + c as usize] { 255 } else { 0 }])
    });
    let labels = connected_components(&image, Connectivity::Four, Luma([0]));
    let shadows = largest_inside(labels.as_raw(), grey.rows, grey.columns);
    let none = RingError::NoPart {
        least: settings.min_diameter_px,
        found: shadows.count,
        largest: (4.0 * shadows.largest as f64 / std::f64::consts::PI).sqrt(),
        at_border: shadows.at_border,
    };
    match outline(&shadows.best, grey.columns)? {
        Some(coarse) if coarse.outer.diameter() >= settings.min_diameter_px => Ok(coarse),
        _ => Err(none),
    }
}

impl Grey {
    /// Reads a frame.
    ///
    /// # Errors
    /// A pixel that is no number.
    pub(in crate::gauge) fn read(view: &FrameView<'_>, bright_on_dark: bool) -> Result<Self, RingError> {
        let (rows, columns) = (view.rows(), view.columns());
        let sign = if bright_on_dark { -1.0 } else { 1.0 };
        let mut values = Vec::with_capacity(rows * columns);
        for row in 0..rows {
            for column in 0..columns {
                let v = view.get(row, column).unwrap_or(f32::NAN);
                if !v.is_finite() {
                    return Err(RingError::NotFinite { row, column });
                }
                values.push(sign * v);
            }
        }
        Ok(Self { values, rows, columns })
    }

    fn transposed(&self) -> Self {
        let at = |k: usize| self.values[(k % self.rows) * self.columns + k / self.rows];
        let values = (0..self.values.len()).map(at).collect();
        Self { values, rows: self.columns, columns: self.rows }
    }

    /// Medians of three, down and across: hot and dead pixels and stuck rows and columns neither
    /// cut a part nor join it to the border.
    pub(in crate::gauge) fn without_stuck_lines(mut self) -> Self {
        let mut above = Vec::new();
        median_down(&mut self.values, self.columns, &mut above);
        let mut turned = self.transposed();
        median_down(&mut turned.values, turned.columns, &mut above);
        turned.transposed()
    }

    /// The pixels that lie in a valley of their row and of their column.
    fn between_light(&self) -> Vec<bool> {
        let turned = self.transposed();
        let (mut down, mut across) = (Valleys::default(), Valleys::default());
        down.find(&self.values, self.columns, Bridged::No);
        across.find(&turned.values, turned.columns, Bridged::No);
        let other = |k: usize| across.shares[(k % self.columns) * self.rows + k / self.columns];
        down.shares.iter().enumerate().map(|(k, share)| share.max(other(k)) < 0.5).collect()
    }
}

/// Middle between the means of the two classes that split the histogram best (iterative selection,
/// Ridler & Calvard 1978).
pub(in crate::gauge) fn threshold(grey: &Grey, whole_counts: bool) -> Result<f64, RingError> {
    let limits = CoarseRingLimits::get();
    let line = |row: &[f32]| row.iter().step_by(2).map(|v| f64::from(*v)).collect::<Vec<f64>>();
    let values: Vec<f64> = grey.values.chunks_exact(grey.columns).step_by(2).flat_map(line).collect();
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
        let [dark, light] = means_beside(&values, level);
        let next = 0.5 * (dark + light);
        if (next - level).abs() < 1e-3 * (light - dark).max(1e-9) {
            break;
        }
        level = next;
    }
    let (dark, light) = (mean(&|v| v < level), mean(&|v| v >= level));
    let (contrast, noise) = (light.0 - dark.0, dark.1.hypot(light.1));
    if dark.2 == 0.0 {
        return Err(RingError::LowContrast { contrast: 0.0, noise: light.1, least: limits.least_contrast });
    }
    if contrast < limits.least_contrast * noise || contrast < limits.least_counts && whole_counts {
        return Err(RingError::LowContrast { contrast, noise, least: limits.least_contrast });
    }
    Ok(level)
}

/// Means of the values below a level and of those from it on; 0 of none.
fn means_beside(values: &[f64], level: f64) -> [f64; 2] {
    let (mut sums, mut counts) = ([0.0; 2], [0_usize; 2]);
    for value in values {
        let class = usize::from(*value >= level);
        sums[class] += value;
        counts[class] += 1;
    }
    [0, 1].map(|k| sums[k] / counts[k].max(1) as f64)
}

/// The shadows of a frame.
struct Shadows {
    /// Pixels of the largest one that keeps off the frame's border; of two as large the first.
    best: Vec<usize>,
    /// Their number.
    count: usize,
    /// Pixels of the largest one, at the border or not.
    largest: usize,
    /// Whether that one touches the border.
    at_border: bool,
}

fn largest_inside(labels: &[u32], rows: usize, columns: usize) -> Shadows {
    let count = labels.iter().max().map_or(0, |m| *m as usize);
    let (mut sizes, mut at_border) = (vec![0_usize; count + 1], vec![false; count + 1]);
    for (index, label) in labels.iter().enumerate() {
        let (row, column) = (index / columns, index % columns);
        sizes[*label as usize] += 1;
        at_border[*label as usize] |= row == 0 || column == 0 || row + 1 == rows || column + 1 == columns;
    }
    let order = |l: &usize| (sizes[*l], std::cmp::Reverse(*l));
    let inside = (1..=count).filter(|l| !at_border[*l]).max_by_key(order);
    let largest = (1..=count).max_by_key(order);
    let best = inside
        .map_or_else(Vec::new, |best| (0..labels.len()).filter(|i| labels[*i] as usize == best).collect());
    Shadows {
        best,
        count,
        largest: largest.map_or(0, |l| sizes[l]),
        at_border: largest.is_some_and(|l| at_border[l]),
    }
}

/// Circles of the outline and the bore, from the farthest and nearest pixels in each direction,
/// around a centre that is moved until the outline's first harmonic vanishes.
fn outline(pixels: &[usize], columns: usize) -> Result<Option<Coarse>, RingError> {
    let limits = CoarseRingLimits::get();
    if pixels.len() < 100 {
        return Ok(None);
    }
    let at = |p: &usize| DVec2::new((p % columns) as f64, (p / columns) as f64);
    let mut centre = pixels.iter().map(at).sum::<DVec2>() / pixels.len() as f64;
    let farthest = pixels.iter().map(|p| at(p).distance(centre)).fold(0.0, f64::max);
    let directions = ((TAU * farthest / limits.arc_px) as usize).clamp(12, limits.most_directions);
    let mut extremes = Vec::new();
    for _ in 0..4 {
        extremes = vec![(f64::INFINITY, 0.0_f64); directions];
        for p in pixels {
            let arm = at(p) - centre;
            let turn = arm.y.atan2(arm.x).rem_euclid(TAU) / TAU;
            let slot = &mut extremes[((turn * directions as f64) as usize).min(directions - 1)];
            *slot = (slot.0.min(arm.length()), slot.1.max(arm.length()));
        }
        let middle = median(extremes.iter().map(|e| e.1).collect());
        // Medians of opposite directions' differences would do as well; clipping the departures
        // bounds the influence of contamination.
        let shift = extremes.iter().enumerate().map(|(k, e)| {
            let direction = DVec2::from_angle(TAU * (k as f64 + 0.5) / directions as f64);
            direction * (e.1 - middle).clamp(-0.1 * middle, 0.1 * middle) * (2.0 / directions as f64)
        });
        centre += shift.sum::<DVec2>();
    }
    let mut reach: Vec<f64> = extremes.iter().map(|e| e.1).collect();
    reach.sort_by(f64::total_cmp);
    let (low, high) = (reach[directions / 10], reach[directions - 1 - directions / 10]);
    let most = 0.05 * high + 2.0;
    if high - low > most {
        return Err(RingError::NotRound { inner: low, outer: high, most });
    }
    let outer = Circle { centre, radius: median(reach) + 0.5 };
    let bore = median(extremes.iter().map(|e| e.0).filter(|r| r.is_finite()).collect()) - 0.5;
    // In a disc the nearest pixel of a narrow sector stands some way off, too; a bore is empty.
    let in_bore = pixels.iter().filter(|p| at(p).distance(centre) < 0.5 * bore).count() as f64;
    let bored = bore > 6.0 && in_bore < 0.1 * std::f64::consts::PI * (0.5 * bore).powi(2);
    Ok(Some(Coarse { outer, inner: bored.then_some(Circle { centre, radius: bore }) }))
}
