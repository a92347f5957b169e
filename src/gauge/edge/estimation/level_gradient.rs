//! Illumination gradient across an edge: a cloud of mist, a film on the window, the flank of an
//! uneven light.
//!
//! The light's level is read from flat pixels D px beyond the edge and holds up to it only where
//! the light is even. A few pixels farther out, in a sample of the columns, show how it changes.
//! Where it grows outwards by g, a share of the contrast per px, pixel k at y_k px from the edge
//! differs from the model by g·E_k·(y_k − D), so that the edge is placed g·Σ w_k E_k (y_k − D) too
//! far out. Where the change is significant against its own scatter it is removed from the windows,
//! the contrast of every pixel being divided by
//!
//! ```text
//! exp(g·t + q·t²),  t = y_k − D    exact for light that falls exponentially and for Gaussian spots
//! ```
//!
//! with g from the pixels a few rows farther out and q, one for the side, from those and others
//! farther out still. What is left of it is a share of the shift. A level that neighbours share is
//! also an error that neighbours share: it is stated with the shared uncertainty. Of a lit part
//! before a dark ground the light is inside: all this is then looked at inwards from the flat
//! pixels in the part.

use super::levels::LevelCurve;
use super::noise::NoiseModel;
use super::scoring_table::Table;
use crate::gauge::edge::image::plane::{Plane, Sample};
use crate::gauge::edge::image::scan_windows::{Side, Windows};
use crate::gauge::edge::image::window_layout::half;
use crate::gauge::edges::Edge;
use crate::gauge::limit::limits;
use crate::numerics::robust::{MEDIAN_TO_SD, upper_median};

limits! {
    /// What counts as a gradient of the light, and what stays uncertain of it.
    LevelGradientLimits = "level_gradient";
    /// Columns looked at below which a tile is left out: a median of five holds against two
    /// outlying ones.
    least_columns: usize = 5;
    /// Distance of the first pixel looked at from the end of the window, px. Tuned: see study
    /// limits.
    beyond_px: usize = 8;
    /// Distance of the farther pixels from the far ones, px: nearly twice as far from the flat end,
    /// so that the curvature shows beside the slope. Tuned: see study limits.
    farther_px: usize = 14;
    /// Change of the light between both places that counts, as a share of the contrast: a gradient
    /// below this moves an edge by some thousandths of a pixel.
    least_change: f64 = 0.005;
    /// The same in standard uncertainties: a clean frame's uncertainty remains that of the noise
    /// (false alarms in 6e-5 of the tiles).
    significant: f64 = 4.0;
    /// Share of the shift that stays uncertain where the change was taken out of the windows
    /// without its curvature: the slope under a spot changes by a third of itself over the 20 px
    /// between the edge and the far pixels.
    left: f32 = 0.35;
    /// The same with the curvature: what other light departs from the model.
    left_bent: f32 = 0.04;
    /// Share of what the curvature did that stays uncertain beside: light that falls linearly has
    /// little of it, a spot much.
    left_of_bend: f32 = 0.3;
    /// Ratio of the slopes to the far and the farther pixels beyond which these show something else
    /// than the same light. Tuned: see study limits.
    most_bend: f32 = 2.0;
    /// Departure of the logarithm of the farther pixels' light from a straight fall beyond which
    /// they show something else: a spot of 4:1 within the field departs by 7 %.
    most_bent: f32 = 0.12;
    /// Fewest tiles from which a side's curvature is estimated: one shows no scatter.
    least_bent: usize = 2;
    /// Change of a tile, in its standard uncertainties, from which it is taken out: normal scatter
    /// reaches it in 2e-9 of the tiles, and in 2e-5 where the scatter, a median of 16 columns, is
    /// too small by its own standard uncertainty of 1.17/√16 = 29 %.
    plain: f32 = 6.0;
    /// Least factor of the contrast by which a pixel of a window is divided: farther into the
    /// shadow there is no light. Tuned: see study limits.
    least_factor: f32 = 0.25;
    /// Least change that is taken out, as a share of the contrast: ripples and tails of an
    /// edge-spread function change by 2 % beyond a window, and less than that moves an edge by some
    /// thousandths of a pixel, which are stated.
    least_levelled: f32 = 0.03;
    /// Largest change that is removed, as a fraction of the contrast: a larger one is not a
    /// gradient of the light but a cloud or another part.
    most_change: f32 = 0.5;
    /// Change over the far pixels as a share of that from the flat end to them from which they see
    /// an edge: light that falls off changes by a quarter over them, beside its crest by a half.
    most_step: f32 = 0.75;
}

/// Columns of a tile, whose light falls off alike, and the distance of those looked at.
const TILE: usize = 64;
const STEP: usize = 4;
/// Pixels looked at in a column.
const FAR: usize = 4;
/// Standard deviation of a median over that of a mean, √(π/2).
const MEDIAN: f64 = 1.2533;

/// How the light of a side changes outwards, tile by tile.
#[derive(Clone, Debug, Default)]
pub(crate) struct LevelGradient {
    tiles: Vec<Change>,
    /// Whether the light is the part's, inside its edges.
    inside: bool,
    /// Whether the change was taken out of the windows.
    levelled: bool,
    /// Curvature of the light's logarithm outwards, 1/px², and its standard uncertainty; none where
    /// too few pixels show it.
    bend: Option<(f32, f32)>,
}

/// Columns of a tile.
fn tile_columns(tile: usize, windows: &Windows) -> std::ops::Range<usize> {
    tile * TILE..((tile + 1) * TILE).min(windows.centre.len())
}

/// Change of the light beside a tile of columns.
#[derive(Clone, Copy, Debug)]
struct Change {
    /// Median over the columns looked at, from the window's flat end to the far pixels, counts; NaN
    /// where unknown.
    counts: f32,
    /// Standard uncertainty of that median by the columns' own scatter, counts.
    scatter: f32,
    /// Median change to the farther pixels, counts; NaN where unknown.
    farther: f32,
    /// Standard uncertainty of that, counts.
    farther_scatter: f32,
    /// Whether the far pixels lie in another shadow.
    other: bool,
    /// Columns looked at.
    columns: u32,
    /// Change of the light's logarithm that is taken out of the windows.
    taken: f32,
}

/// Distance of the flat end's middle from that of the far pixels, px.
fn apart(flat: usize) -> f32 {
    LevelGradientLimits::get().beyond_px as f32 + 0.5 * (FAR as f32 + flat as f32)
}

impl LevelGradient {
    /// Looks at the light beyond the windows of a side.
    pub(crate) fn read<T: Sample>(&mut self, plane: &Plane<'_, T>, windows: &Windows) {
        let limits = LevelGradientLimits::get();
        self.tiles.clear();
        (self.levelled, self.bend, self.inside) = (false, None, plane.sign < 0.0);
        let inside = self.inside;
        let down = (windows.side == Side::Bottom) != inside;
        let sign = if down { 1 } else { -1 };
        // From the far pixels to the flat end's middle it is as far on either side.
        let from_centre = if inside {
            limits.beyond_px + 1 + half(windows.width)
        } else {
            windows.width - 1 + limits.beyond_px - half(windows.width)
        };
        let ahead = from_centre as i32 * sign;
        let mut others = 0;
        for (tile, centres) in windows.centre.chunks(TILE).enumerate() {
            let mut changes = [f32::NAN; TILE / STEP];
            let mut farther = [f32::NAN; TILE / STEP];
            let mut steps = [f32::NAN; TILE / STEP];
            let (mut count, mut beyond) = (0, 0);
            let contrast = mean_levels(windows, tile_columns(tile, windows)).1;
            for (offset, centre) in centres.iter().enumerate().step_by(STEP) {
                let (Ok(centre), column) = (centre, tile * TILE + offset) else { continue };
                let mut far = [0.0_f32; FAR];
                // Of light that falls along the tile, too, each column shows its own share.
                let own = windows.light[column] - windows.dark[column];
                let scale = contrast / own.max(limits.least_factor * contrast);
                let outwards = |far: &[f32; FAR]| {
                    let mean = far.iter().sum::<f32>() / FAR as f32;
                    scale * if inside { windows.dark[column] - mean } else { mean - windows.light[column] }
                };
                if windows.light[column].is_finite()
                    && plane.gather((centre + ahead) as isize, down, column, &mut far)
                {
                    changes[count] = outwards(&far);
                    steps[count] = scale * (far[FAR - 1] - far[0]);
                    count += 1;
                    let first = (centre + ahead + limits.farther_px as i32 * sign) as isize;
                    if plane.gather(first, down, column, &mut far) {
                        farther[beyond] = outwards(&far);
                        beyond += 1;
                    }
                }
            }
            let Change { counts: farther, scatter: farther_scatter, .. } = Change::of(&mut farther[..beyond]);
            let change = Change::of(&mut changes[..count]);
            let stepped =
                Change::of(&mut steps[..count]).counts.abs() > limits.most_step * change.counts.abs();
            let other = change.counts < -limits.most_change * contrast
                || (stepped && change.counts < -limits.least_levelled * contrast);
            others += usize::from(other);
            self.tiles.push(Change { farther, farther_scatter, other, ..change });
        }
        // Along most of the side another shadow runs: it does not show the illumination.
        if 2 * others > self.tiles.len() {
            self.tiles.iter_mut().filter(|t| t.other).for_each(|t| t.counts = f32::NAN);
        }
    }

    /// Clears what was known of the light beyond the windows.
    pub(crate) fn clear(&mut self) {
        self.tiles.clear();
        (self.levelled, self.bend) = (false, None);
    }

    /// Whether the grey values of the light are clipped, by where those of shadow and light are.
    pub(crate) fn is_clipped(&self, low: f64, high: f64) -> bool {
        if self.inside { low.is_finite() } else { high.is_finite() }
    }

    /// Takes the change out of the windows of a side where most of its tiles plainly show one.
    /// Their flat ends stay as they are, and so do grey values of `low` or less, at which the
    /// shadow is clipped.
    pub(crate) fn level(&mut self, windows: &mut Windows, low: f32) {
        if self.levelled {
            return;
        }
        let limits = LevelGradientLimits::get();
        let bend = self.side_bend(windows);
        let Some(mean) = self.trend(windows).or_else(|| self.bent(windows, bend)) else { return };
        (self.levelled, self.bend) = (true, bend);
        for tile in 0..self.tiles.len() {
            let columns = tile_columns(tile, windows);
            let share = self.tiles[tile].share(windows, columns.clone());
            let own = self.tiles[tile].counts / mean_levels(windows, columns).1;
            // Beside a light known by its curvature every tile shows its own, also the one at which
            // it is level.
            let plain = share * mean.signum() > limits.least_levelled
                || (bend.is_some() && own.abs() < limits.most_change);
            self.tiles[tile].taken = (if plain { own } else { mean }).ln_1p();
        }
        let width = windows.width;
        // Place of the light's flat end in a window, counted from the shadow's end.
        let to_middle = if self.inside { windows.flat as f32 - 1.0 } else { windows.flat as f32 + 1.0 };
        let end = (width - 1) as f32 - 0.5 * to_middle;
        let (dark, contrast) = mean_levels(windows, 0..windows.centre.len());
        let ground = if self.inside { dark + contrast } else { dark };
        let (bend, far) = (self.bend.map_or(0.0, |b| b.0), apart(windows.flat));
        for column in (0..windows.centre.len()).filter(|c| windows.light[*c].is_finite()) {
            let slope = self.taken_at(column, windows.centre.len()) / far - bend * far;
            // exp(g·t + q·t²) by its ratio from pixel to pixel.
            let mut factor = (bend * end * end - slope * end).exp();
            let mut ratio = (slope + bend * (1.0 - 2.0 * end)).exp();
            let faster = (2.0 * bend).exp();
            let window = &mut windows.pixels[column * width..(column + 1) * width];
            for k in 0..width {
                let value = &mut window[if self.inside { width - 1 - k } else { k }];
                if *value > low {
                    *value = ground + (*value - ground) / factor.max(limits.least_factor);
                }
                (factor, ratio) = (factor * ratio, ratio * faster);
            }
        }
    }

    /// Curvature of the light's logarithm, the median of the tiles, and its standard uncertainty,
    /// by their scatter where that is more.
    fn side_bend(&self, windows: &Windows) -> Option<(f32, f32)> {
        let tiles = self.tiles.iter().enumerate();
        let (mut bends, mut variance) = (Vec::new(), 0.0);
        for (_, bend, u) in tiles.filter_map(|(tile, c)| c.bend(windows, tile_columns(tile, windows))) {
            bends.push(bend);
            variance += u * u;
        }
        if bends.len() < LevelGradientLimits::get().least_bent {
            return None;
        }
        let n = bends.len() as f32;
        let median = upper_median(&mut bends, f32::total_cmp)?;
        let apart = bends.iter().map(|bend| (bend - median).abs()).sum::<f32>() / n;
        Some((median, (MEDIAN as f32 * variance.sqrt() / n).hypot(apart / n.sqrt())))
    }

    /// Mean change of a light that is level beside the windows but significantly curved: a spot in
    /// the row of the edge.
    fn bent(&self, windows: &Windows, bend: Option<(f32, f32)>) -> Option<f32> {
        let LevelGradientLimits { farther_px, plain: sigmas, least_levelled, most_change, .. } =
            *LevelGradientLimits::get();
        let far = apart(windows.flat) + farther_px as f32;
        bend.filter(|(bend, u)| bend.abs() > sigmas * u && bend.abs() * far * far > least_levelled)?;
        let (mut sum, mut known, mut plain) = (0.0, 0, 0);
        for (tile, change) in self.tiles.iter().enumerate().filter(|(_, c)| c.counts.is_finite()) {
            let contrast = mean_levels(windows, tile_columns(tile, windows)).1;
            known += 1;
            if (change.counts / contrast).abs() < most_change
                && change.farther.abs() > (least_levelled * contrast).max(sigmas * change.farther_scatter)
            {
                sum += change.counts / contrast;
                plain += 1;
            }
        }
        (2 * plain > known).then(|| sum / plain as f32)
    }

    /// Mean change, a share of the contrast, of the tiles that plainly change to one side, where
    /// they are most of those known: so does light that a lamp leaves uneven; a cloud of mist is
    /// beside a few tiles, and the tails of an edge change less.
    fn trend(&self, windows: &Windows) -> Option<f32> {
        let limits = LevelGradientLimits::get();
        let (mut sums, mut counts, mut known) = ([0.0_f32; 2], [0_usize; 2], 0);
        for (tile, change) in self.tiles.iter().enumerate().filter(|(_, c)| c.counts.is_finite()) {
            known += 1;
            // Most frames return here.
            if change.counts.abs() > limits.plain * change.scatter {
                let share = change.share(windows, tile_columns(tile, windows));
                let side = usize::from(share > 0.0);
                if share.abs() > limits.least_levelled {
                    sums[side] += share;
                    counts[side] += 1;
                }
            }
        }
        let side = usize::from(counts[1] > counts[0]);
        (2 * counts[side] > known).then(|| sums[side] / counts[side] as f32)
    }

    /// The change of the logarithm taken out at a column, between the middles of its tile and the
    /// next; of smooth light beyond the outer ones, too.
    fn taken_at(&self, column: usize, columns: usize) -> f32 {
        let middle = |tile: usize| 0.5 * ((tile * TILE + ((tile + 1) * TILE).min(columns)) as f32 - 1.0);
        let last = self.tiles.len() - 1;
        if last == 0 {
            return self.tiles[0].taken;
        }
        let left = ((column as f32 / TILE as f32 - 0.5).max(0.0) as usize).min(last - 1);
        let beyond = if self.bend.is_some() { 0.6 } else { 0.0 };
        let t =
            ((column as f32 - middle(left)) / (middle(left + 1) - middle(left))).clamp(-beyond, 1.0 + beyond);
        self.tiles[left].taken + t * (self.tiles[left + 1].taken - self.tiles[left].taken)
    }

    /// Adds to the shared uncertainty of a side's edges their shift by the gradient of the light.
    pub(crate) fn state(
        &self,
        line: &mut [Edge],
        windows: &Windows,
        (dark, light): (&LevelCurve, &LevelCurve),
        (noise, table): (&NoiseModel, &Table),
    ) {
        let limits = LevelGradientLimits::get();
        let flat = windows.flat as f64;
        let shift = shift(table, windows.flat) as f32;
        let near = apart(windows.flat);
        // From the far pixels to the edge.
        let reach = near + distance(table, windows.flat) as f32;
        for (tile, (edges, seen)) in line.chunks_mut(TILE).zip(&self.tiles).enumerate() {
            let middle = tile * TILE + edges.len() / 2;
            let (Some(level), Some(ground)) = (light.level.get(middle), dark.level.get(middle)) else {
                continue;
            };
            let contrast = f64::from(level - ground);
            let level = f64::from(*if self.inside { ground } else { level });
            let variance = noise.variance(level) * (1.0 / flat + 1.0 / FAR as f64) / f64::from(seen.columns);
            let change = f64::from(seen.counts.abs());
            let sloped =
                change > (limits.least_change * contrast).max(limits.significant * MEDIAN * variance.sqrt());
            let bent = seen.bend(windows, tile_columns(tile, windows)).filter(|(_, bend, u)| {
                bend.abs() > (limits.significant as f32 * u).max(limits.least_change as f32 / (reach * reach))
            });
            if !sloped && bent.is_none() {
                continue;
            }
            let slope = (change / contrast) as f32 / near;
            let at_edge =
                bent.map_or(slope, |(slope, bend, _)| (slope - bend * reach).abs().max(slope.abs()));
            let moved = shift
                * match (self.levelled, self.bend) {
                    (false, _) => at_edge,
                    (true, None) => limits.left * at_edge,
                    // The curvature's error turns the slope about the far pixels: ln C at the edge
                    // by u·D·(D + their distance).
                    (true, Some((bend, u))) => {
                        (limits.left_bent * slope).hypot(limits.left_of_bend * bend * reach).hypot(u * reach)
                    }
                };
            for edge in edges.iter_mut().filter(|e| e.is_usable()) {
                edge.u_shared_px = edge.u_shared_px.hypot(moved);
            }
        }
    }
}

impl Change {
    /// From the changes of single columns.
    fn of(changes: &mut [f32]) -> Self {
        let columns = changes.len();
        let nan = f32::NAN;
        let unknown = Self {
            counts: nan,
            scatter: nan,
            farther: nan,
            farther_scatter: nan,
            other: false,
            columns: columns as u32,
            taken: 0.0,
        };
        if columns < LevelGradientLimits::get().least_columns {
            return unknown;
        }
        let counts = *changes.select_nth_unstable_by(columns / 2, f32::total_cmp).1;
        changes.iter_mut().for_each(|change| *change = (*change - counts).abs());
        let spread = *changes.select_nth_unstable_by(columns / 2, f32::total_cmp).1;
        let scatter = MEDIAN_TO_SD as f32 * MEDIAN as f32 * spread / (columns as f32).sqrt();
        Self { counts, scatter, ..unknown }
    }
}

impl Change {
    /// The change as a fraction of the contrast of its columns, where it is significant and within
    /// the limit of a gradient; else 0.
    fn share(&self, windows: &Windows, columns: std::ops::Range<usize>) -> f32 {
        let limits = LevelGradientLimits::get();
        let share = self.counts / mean_levels(windows, columns).1;
        let plain = self.counts.abs() > limits.plain * self.scatter && share.abs() < limits.most_change;
        if plain { share } else { 0.0 }
    }

    /// Mean slope of the light's logarithm to the far pixels, 1/px, its curvature, 1/px², and that
    /// one's standard uncertainty; `None` where the farther pixels show something else.
    fn bend(&self, windows: &Windows, columns: std::ops::Range<usize>) -> Option<(f32, f32, f32)> {
        let limits = LevelGradientLimits::get();
        let (near, far) = (apart(windows.flat), apart(windows.flat) + limits.farther_px as f32);
        let contrast = mean_levels(windows, columns).1;
        let [share, farther] = [self.counts, self.farther].map(|counts| counts / contrast);
        if !(share.abs() < limits.most_change && farther > limits.least_factor - 1.0) {
            return None;
        }
        let [a, b] = [share.ln_1p() / near, farther.ln_1p() / far];
        let alike = a * b > 0.0 && a.abs().max(b.abs()) < limits.most_bend * a.abs().min(b.abs());
        if !alike && (b - a).abs() * far > limits.most_bent {
            return None;
        }
        let u = (self.scatter / near).hypot(self.farther_scatter / far) / (contrast * (far - near));
        Some((a, (b - a) / (far - near), u))
    }
}

/// Mean shadow and contrast of some columns' flat ends, counts.
fn mean_levels(windows: &Windows, columns: std::ops::Range<usize>) -> (f32, f32) {
    let (mut dark, mut light, mut count) = (0.0, 0.0, 0.0_f32);
    for column in columns.filter(|c| windows.light[*c].is_finite()) {
        (dark, light, count) = (dark + windows.dark[column], light + windows.light[column], count + 1.0);
    }
    (dark / count, (light - dark) / count)
}

/// Distance D of an edge in the middle of its window from the light's flat end, px.
fn distance(table: &Table, flat: usize) -> f64 {
    (table.width - 1) as f64 - 0.5 * (flat as f64 + 1.0) - half(table.width) as f64
}

/// |Σ w_k E_k (y_k − D)| of an edge in the middle of its window, px of the edge per share of the
/// contrast and px.
fn shift(table: &Table, flat: usize) -> f64 {
    let phase = table.phase(0.0);
    let middle = half(table.width) as f64;
    let distance = distance(table, flat);
    let terms = phase.weights.iter().zip(phase.values).enumerate();
    terms.map(|(k, (w, e))| f64::from(w * e) * (k as f64 - middle - distance)).sum::<f64>().abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauge::edge::estimation::scoring_table::Tabulation;
    use crate::gauge::edge::image::window_layout::window_width;
    use crate::gauge::edge::model::edge_spread::EdgeSpreadFunction;
    use crate::gauge::edge::model::gaussian::EdgeSample;

    /// An edge under light that grows outwards, placed by a table that takes the level at the flat
    /// end for the light's.
    #[test]
    fn the_shift_is_that_of_an_edge_under_a_gradient() {
        let (shape, gradient) = (EdgeSpreadFunction::Gaussian, 0.004);
        for (sigma, kappa) in [(0.7, 0.0), (1.0, 1.5), (2.0, 0.8)] {
            let width = window_width(&shape, sigma);
            let table =
                Table::new(&shape, Tabulation { sigma, kappa, width, free_levels: false, per_px: 64 });
            let flat = 4;
            let middle = half(width) as f64;
            let mut samples = vec![EdgeSample::default(); width - 1];
            shape.samples(-middle, 0.0, sigma, &mut samples);
            let distance = (width - 1) as f64 - 0.5 * (flat as f64 + 1.0) - middle;
            let grey = |k: usize| samples[k].value * (1.0 + gradient * (k as f64 - middle - distance));
            let mut x = 0.0_f32;
            for _ in 0..20 {
                let phase = table.phase(x);
                let weighted: f64 = (0..width - 1).map(|k| f64::from(phase.weights[k]) * grey(k)).sum();
                x = phase.scalars.phase + (weighted as f32 - phase.scalars.offset);
            }
            let stated = gradient * shift(&table, flat);
            assert!((f64::from(x) / stated - 1.0).abs() < 0.05, "σ {sigma}: {x} for {stated}");
        }
    }

    /// Light whose logarithm falls 1.6 times as steeply to the farther pixels as to the far ones is
    /// bent, one that falls 2.6 times as steeply is something else.
    #[test]
    fn light_that_bends_by_more_than_its_own_fall_is_other_light() {
        let mut windows = Windows::new(Side::Bottom);
        windows.flat = 4;
        (windows.dark, windows.light) = (vec![0.0; 8], vec![1.0; 8]);
        windows.centre = vec![Ok(50); 8];
        let near = apart(windows.flat);
        let far = near + LevelGradientLimits::get().farther_px as f32;
        let bend = |ratio: f32| {
            let slope = 0.3 / far;
            let change = Change {
                counts: (slope * near).exp_m1(),
                farther: (ratio * slope * far).exp_m1(),
                scatter: 0.0,
                farther_scatter: 0.0,
                ..Change::of(&mut [])
            };
            change.bend(&windows, 0..8)
        };
        let (slope, bent, _) = bend(1.6).unwrap();
        assert!((slope * far - 0.3).abs() < 1e-4 && (bent * (far - near) * far - 0.18).abs() < 1e-4);
        assert!(bend(2.6).is_none());
    }
}
