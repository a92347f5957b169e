//! Where the part is: the largest shadow of a thinned image, then whole-pixel edges along its
//! border.
//!
//! The thinned image keeps every s-th pixel (s at most a third of the smallest part), is split at
//! the level that separates its grey values best (Otsu), and its largest connected shadow is the
//! part (which of several: [`super::shadows`]). Specks of contamination, holes and neighbouring
//! parts at the border are other components and ignored. Where one level does not separate light
//! from shadow in all of the frame (light that falls off, a spot, black margins), or a stuck column
//! cuts the part in two, the part is the largest shadow that stands between light in its own
//! columns ([`super::valleys`]).

use wide::f32x4;

use super::connected_components::Span;
use super::plane::{Plane, Sample};
use super::shadows::{Grid, NoShadow, Shadows};
use super::valleys::ValleyLimits;
use super::valleys::{Bridged, Valleys, median_down};
use crate::gauge::edges::ShadowsSeen;
use crate::gauge::limit::limits;
use crate::gauge::settings::GaugeSettings;
use crate::numerics::robust::upper_median;
use crate::profile::Reason;

limits! {
    /// When a dark area of the thinned image is the part.
    LocalisationLimits = "part_localisation";
    /// Cells a side of the thinned image, at most: as f32 all of them take 256 KiB, which a core's
    /// second cache holds.
    cells: usize = 256;
    /// (Difference of the two class means)²/(variance inside the classes) that two levels must
    /// exceed: a Gaussian noise image reaches 7.0, a uniform one or a plain ramp 12.
    two_levels: f64 = 16.0;
    /// Least width of a column over the least diameter, which the part has in the median of its
    /// columns: a groove may be narrower than the part. Tuned: see study limits.
    neck: f64 = 0.8;
    /// Share of the columns with both edges from which on the second search is saved: 1/`more`,
    /// since no search can find that many more columns than the frame has.
    whole: f64 = 0.98;
    /// Share of the columns that a shadow between light must have where the frame has no two
    /// levels: a speck in a field whose part reaches beyond the border is no part. Tuned: see study
    /// limits.
    least_between: f64 = 0.25;
    /// Columns that the search between light must find over those that the search by two levels
    /// found: as many and two in a hundred, since both find the same part within a few columns of
    /// its ends, ten of 512.
    more: f64 = 1.02;
    /// Columns in which light inside the shadow is looked for: a line along the part crosses most
    /// of them, and a share of a half is known to 9 % from 32.
    looked_at: usize = 32;
    /// Rows beside the edges of the shadow that blur may light: four standard deviations of a blur
    /// of 2 px.
    edge_rows: usize = 8;
    /// Rows, at least, in which the shadow itself is looked for inside a stretch of dimmed light. A
    /// bound of time alone: mist of more rows hides a part.
    inwards: usize = 256;
}

/// A whole-pixel edge: the shadow's outermost pixel, or why there is none.
pub(crate) type CoarseEdge = Result<i32, Reason>;

/// The search for the part: the whole-pixel edges that it found last, and its buffers.
#[derive(Clone, Debug, Default)]
pub(crate) struct PartSearch {
    /// First shadow row of each column.
    pub(crate) top: Vec<CoarseEdge>,
    /// Last shadow row of each column.
    pub(crate) bottom: Vec<CoarseEdge>,
    thinned: Thinned,
    /// Which shadow is the part, and what else there is.
    pub(crate) shadows: Shadows,
    spans: Vec<Span>,
    valleys: Valleys,
    widths: Vec<i32>,
    /// Result of the search by two levels, while valleys are searched.
    spare: [Vec<CoarseEdge>; 2],
}

/// Whether a search found two shadows of which either may be the part.
fn is_several(found: &Result<(), NoShadow>) -> bool {
    found.as_ref().is_err_and(|none| none.reason == Reason::SeveralShadows)
}

/// The thinned image: one cell stands for `row_step` rows x `column_step` columns.
#[derive(Clone, Debug, Default)]
struct Thinned {
    columns: usize,
    row_step: usize,
    column_step: usize,
    values: Vec<f32>,
    line: Vec<f32>,
}

/// Figures of a search.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    /// Median width of the shadow, px.
    pub(crate) width_px: f64,
    /// Share of the columns with both edges.
    pub(crate) share: f64,
}

impl PartSearch {
    /// Result of an independent search in a frame; `None` without a part.
    pub(crate) fn found<T: Sample>(plane: &Plane<'_, T>, settings: &GaugeSettings) -> Option<Found> {
        let mut search = Self::default();
        search.find_part(plane, settings).ok()?;
        let width_px = search.median_width()?;
        Some(Found { width_px, share: search.pairs() as f64 / plane.columns as f64 })
    }

    /// The edges found, top and bottom; the search keeps none.
    pub(crate) fn take_lines(&mut self) -> (Vec<CoarseEdge>, Vec<CoarseEdge>) {
        (std::mem::take(&mut self.top), std::mem::take(&mut self.bottom))
    }

    /// Takes lines over as buffers.
    pub(crate) fn reuse(&mut self, top: Vec<CoarseEdge>, bottom: Vec<CoarseEdge>) {
        (self.top, self.bottom) = (top, bottom);
    }

    /// Median width of the columns with both edges, px.
    pub(crate) fn median_width(&mut self) -> Option<f64> {
        self.widths.clear();
        let pairs = self.top.iter().zip(&self.bottom);
        self.widths.extend(pairs.filter_map(|(t, b)| Some(width((*t).ok()?, (*b).ok()?))));
        upper_median(&mut self.widths, Ord::cmp).map(f64::from)
    }

    /// Finds the part.
    ///
    /// # Errors
    /// The reason for which the frame shows no part.
    pub(crate) fn find_part<T: Sample>(
        &mut self,
        plane: &Plane<'_, T>,
        settings: &GaugeSettings,
    ) -> Result<(), NoShadow> {
        let limits = LocalisationLimits::get();
        self.thinned.fill(plane, settings.min_diameter_px);
        let by_levels = self.find_by_levels(plane, settings);
        let seen = self.pairs();
        if by_levels.is_ok() && seen as f64 >= limits.whole * plane.columns as f64 {
            return Ok(());
        }
        // A choice among several shadows is kept: between light lies one wall as well as one part.
        if settings.which.is_some() || self.shadows.seen.joined > 1 || is_several(&by_levels) {
            return by_levels;
        }
        let [top, bottom] = &mut self.spare;
        std::mem::swap(top, &mut self.top);
        std::mem::swap(bottom, &mut self.bottom);
        self.find_by_valleys(plane, settings);
        let between = self.pairs();
        if between as f64 >= limits.least_between * plane.columns as f64
            && between as f64 > limits.more * seen as f64
        {
            return Ok(());
        }
        let [top, bottom] = &mut self.spare;
        std::mem::swap(top, &mut self.top);
        std::mem::swap(bottom, &mut self.bottom);
        by_levels
    }

    /// Finds the largest shadow of a frame with one level of light and one of shadow.
    fn find_by_levels<T: Sample>(
        &mut self,
        plane: &Plane<'_, T>,
        settings: &GaugeSettings,
    ) -> Result<(), NoShadow> {
        self.shadows.seen = ShadowsSeen::one();
        self.top.clear();
        self.bottom.clear();
        let thinned = &self.thinned;
        let levels = separate(&thinned.values).ok_or(Reason::LowContrast)?;
        let grid = Grid {
            values: &thinned.values,
            columns: thinned.columns,
            row_step: thinned.row_step,
            threshold: levels.threshold,
            min_diameter_px: settings.min_diameter_px,
        };
        self.shadows.choose(&grid, settings.which, &mut self.spans)?;
        self.refine_all(plane, settings.min_diameter_px, |_| levels.shadow);
        let inside_px = self.light_inside(plane, levels.threshold);
        self.shadows.add_light_inside(inside_px);
        self.explain().map_or(Ok(()), |reason| Err(reason.into()))
    }

    /// Finds the largest shadow between light of any level; no column has both edges where there is
    /// none.
    fn find_by_valleys<T: Sample>(&mut self, plane: &Plane<'_, T>, settings: &GaugeSettings) {
        self.top.clear();
        self.bottom.clear();
        let thinned = &self.thinned;
        self.valleys.find(&thinned.values, thinned.columns, Bridged::Yes);
        if self.shadows.largest(&self.valleys.shares, thinned.columns, &mut self.spans) {
            self.valleys.set_levels(&thinned.values, &self.spans);
            let levels = std::mem::take(&mut self.valleys.shadow);
            self.refine_all(plane, settings.min_diameter_px, |cell| levels[cell]);
            self.valleys.shadow = levels;
        }
    }

    /// Whole-pixel edges of one column.
    fn refine<T: Sample>(
        &self,
        plane: &Plane<'_, T>,
        level: &impl Fn(usize) -> f32,
        column: usize,
        (limits, min_diameter_px): (&LocalisationLimits, f64),
    ) -> (CoarseEdge, CoarseEdge) {
        let cell = column / self.thinned.column_step;
        let nearest =
            if column % self.thinned.column_step > self.thinned.column_step / 2 { cell + 1 } else { cell };
        let span = self.spans.get(nearest).copied().flatten().map(|span| (span, nearest));
        let Some(((first, last), cell)) = span.or_else(|| self.spans[cell].map(|span| (span, cell))) else {
            return (Err(Reason::NoEdge), Err(Reason::NoEdge));
        };
        let threshold = level(cell);
        let (first, last) =
            (first * self.thinned.row_step, (last * self.thinned.row_step).min(plane.rows - 1));
        let reach = 4 * self.thinned.row_step.max(self.thinned.column_step) + 8;
        let inwards = limits.inwards.max(reach);
        let top = walk_out(plane, column, &Walk { start: first, down: false, threshold, reach, inwards });
        let bottom = walk_out(plane, column, &Walk { start: last, down: true, threshold, reach, inwards });
        match (top, bottom) {
            (Ok(t), Ok(b)) if f64::from(width(t, b)) < limits.neck * min_diameter_px => {
                (Err(Reason::NoEdge), Err(Reason::NoEdge))
            }
            pair => pair,
        }
    }

    /// Whole-pixel edges of every column along the spans, a pixel being shadow below `level` of its
    /// cell's column.
    fn refine_all<T: Sample>(
        &mut self,
        plane: &Plane<'_, T>,
        min_diameter_px: f64,
        level: impl Fn(usize) -> f32,
    ) {
        let limits = LocalisationLimits::get();
        for column in 0..plane.columns {
            let (top, bottom) = self.refine(plane, &level, column, (limits, min_diameter_px));
            self.top.push(top);
            self.bottom.push(bottom);
        }
        if self.median_width().is_some_and(|width| width < min_diameter_px) {
            let thin = self.top.iter_mut().zip(&mut self.bottom).filter(|(t, b)| t.is_ok() && b.is_ok());
            thin.for_each(|(t, b)| (*t, *b) = (Err(Reason::NoEdge), Err(Reason::NoEdge)));
        }
    }

    /// Columns with both edges.
    fn pairs(&self) -> usize {
        self.top.iter().zip(&self.bottom).filter(|(t, b)| t.is_ok() && b.is_ok()).count()
    }

    /// Light inside the shadow that the thinned image may be too coarse to show, px: its mean
    /// thickness where most of the columns looked at have some, else 0.
    fn light_inside<T: Sample>(&self, plane: &Plane<'_, T>, threshold: f32) -> f64 {
        let limits = LocalisationLimits::get();
        let (mut lit, mut looked, mut sum) = (0, 0, 0.0);
        for column in (0..plane.columns).step_by(plane.columns.div_ceil(limits.looked_at)) {
            let (Ok(top), Ok(bottom)) = (self.top[column], self.bottom[column]) else { continue };
            looked += 1;
            let (mut longest, mut run) = (0, 0);
            for row in top.max(0) as usize + limits.edge_rows
                ..(bottom.max(0) as usize).saturating_sub(limits.edge_rows)
            {
                run = if plane.at(row, column) >= threshold { run + 1 } else { 0 };
                longest = longest.max(run);
            }
            if longest >= 2 {
                (lit, sum) = (lit + 1, sum + f64::from(longest));
            }
        }
        if 2 * lit > looked { sum / f64::from(lit) } else { 0.0 }
    }

    /// Why no column has both edges, if so.
    fn explain(&self) -> Option<Reason> {
        let pairs = || self.top.iter().zip(&self.bottom);
        if pairs().any(|(t, b)| t.is_ok() && b.is_ok()) {
            None
        } else if pairs().any(|(t, b)| t.is_ok() != b.is_ok()) {
            Some(Reason::OneEdge)
        } else {
            Some(Reason::NoEdge)
        }
    }
}

impl Thinned {
    fn fill<T: Sample>(&mut self, plane: &Plane<'_, T>, min_diameter_px: f64) {
        let limits = LocalisationLimits::get();
        let finest = (min_diameter_px / 3.0).max(1.0) as usize;
        let step = |n: usize| n.div_ceil(limits.cells).clamp(1, finest);
        (self.row_step, self.column_step) = (step(plane.rows), step(plane.columns));
        self.columns = plane.columns.div_ceil(self.column_step);
        self.values.clear();
        let (stride, last) = (plane.column_stride, plane.columns - 1);
        for row in (0..plane.rows).step_by(self.row_step) {
            let line = &plane.pixels[row * plane.row_stride..][..last * stride + 1];
            if stride == 1 && self.column_step > 1 {
                self.values.extend(line.chunks(self.column_step).map(|cell| {
                    let (a, b) = (cell[0], cell.get(1).copied().unwrap_or(cell[0]));
                    plane.sign * 0.5 * (a.counts() + b.counts())
                }));
                continue;
            }
            self.values.extend((0..plane.columns).step_by(self.column_step).map(|column| {
                let (a, b) = (line[column * stride], line[(column + 1).min(last) * stride]);
                plane.sign * 0.5 * (a.counts() + b.counts())
            }));
        }
        median_down(&mut self.values, self.columns, &mut self.line);
    }
}

/// Two levels of grey.
#[derive(Clone, Copy, Debug)]
struct TwoLevels {
    /// Otsu's threshold between them.
    threshold: f32,
    /// Darker values are the part's own shadow, not light dimmed by mist.
    shadow: f32,
}

/// The two levels, if the values fall into two at all.
fn separate(values: &[f32]) -> Option<TwoLevels> {
    let limits = LocalisationLimits::get();
    let valley_limits = ValleyLimits::get();
    // The length of arrays: a bin is a quarter of a count of 8 bits.
    const BINS: usize = 1024;
    let (low, high) = range(values);
    if !(high > low) {
        return None;
    }
    let scale = (BINS as f32 - 1.0) / (high - low);
    // Four histograms: neighbours mostly fall into the same bin, and their increments are then
    // independent.
    let mut parts = [[0_u32; BINS]; 4];
    let (fours, rest) = values.as_chunks::<4>();
    for four in fours {
        let bins = (f32x4::from(*four) - f32x4::splat(low)) * f32x4::splat(scale);
        for (part, bin) in parts.iter_mut().zip(bins.fast_trunc_int().to_array()) {
            part[bin as usize % BINS] += 1;
        }
    }
    for v in rest {
        parts[0][((v - low) * scale) as usize % BINS] += 1;
    }
    let mut histogram = [0.0_f64; BINS];
    for part in &parts {
        for (sum, n) in histogram.iter_mut().zip(part) {
            *sum += f64::from(*n);
        }
    }
    let total = values.len() as f64;
    let moment = |f: fn(f64) -> f64| histogram.iter().enumerate().map(|(i, n)| n * f(i as f64)).sum::<f64>();
    let (sum, square) = (moment(|i| i), moment(|i| i * i));
    let (mut count, mut partial, mut best) = (0.0, 0.0, (0.0, 0.0, 0.0));
    for (i, n) in histogram.iter().enumerate().take(BINS - 1) {
        count += n;
        partial += n * i as f64;
        if *n == 0.0 || count == total {
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
    let two_levels = (above - below).powi(2) > limits.two_levels * within.max(1.0 / 12.0);
    let grey = |bin: f64| low + (bin as f32 + 0.5) / scale;
    two_levels.then(|| TwoLevels {
        threshold: grey(0.5 * (below + above)),
        shadow: grey(below + valley_limits.shadow_level * (above - below)),
    })
}

/// Least and greatest of the values.
fn range(values: &[f32]) -> (f32, f32) {
    let (mut low, mut high) = ([f32::INFINITY; 8], [f32::NEG_INFINITY; 8]);
    let (eights, rest) = values.as_chunks::<8>();
    for eight in eights {
        for (k, v) in eight.iter().enumerate() {
            low[k] = if *v < low[k] { *v } else { low[k] };
            high[k] = if *v > high[k] { *v } else { high[k] };
        }
    }
    let least = low.iter().chain(rest).fold(f32::INFINITY, |l, v| l.min(*v));
    (least, high.iter().chain(rest).fold(f32::NEG_INFINITY, |h, v| h.max(*v)))
}

/// Width of a shadow by its outermost pixels, px: they are shadow to two thirds at least, so that
/// the edges lie about half a pixel farther out.
fn width(top: i32, bottom: i32) -> i32 {
    bottom - top + 2
}

/// A way out of the shadow along a column.
struct Walk {
    /// A row in the shadow, or near its border.
    start: usize,
    /// Towards higher rows.
    down: bool,
    /// Grey value below which a pixel is shadow.
    threshold: f32,
    /// Rows within which the border is expected.
    reach: usize,
    /// Rows in which the shadow is looked for inwards.
    inwards: usize,
}

/// From a shadow pixel (or one near the border of the shadow) outwards to the last shadow pixel.
fn walk_out<T: Sample>(plane: &Plane<'_, T>, column: usize, walk: &Walk) -> CoarseEdge {
    let Walk { start, down, threshold, reach, inwards } = *walk;
    let outward: i32 = if down { 1 } else { -1 };
    let inside = |row: i32| row >= 0 && (row as usize) < plane.rows;
    let dark = |row: i32| inside(row) && plane.at(row as usize, column) < threshold;
    let mut row = start as i32;
    let mut budget = inwards;
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
