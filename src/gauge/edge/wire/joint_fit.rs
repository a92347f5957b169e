//! Wires: both edges of a thin shadow fitted together.
//!
//! Where a shadow is narrower than an edge's window, each window contains the other edge, and the
//! shadow between them hardly reaches its level. Pixel k of column c then reads
//!
//! ```text
//! m = B + (A_t(c) − B)·[1 − S(k − t_c; σ)] + (A_b(c) − B)·S(k − b_c; σ)
//! ```
//!
//! with S the pixel-integrated edge of the settings, B the shadow's level, A_t and A_b the light
//! above and below (parabolas along the wire), σ the blur: eight parameters pooled over the frame
//! and two edges a column. Weighted Gauss-Newton on all at once, the edges eliminated column by
//! column (Schur complement), residuals beyond three standard deviations counting by their size
//! only (Huber). The errors of B and σ move both edges apart and add up in a width: the uncertainty
//! of each edge is 1/√2 of the width's.
//!
//! Valid from 6 px and three times the blur across, up to the width from which every edge has a
//! window of its own.

use crate::gauge::edge::image::window_layout::WIDEST_PX;
use nalgebra::{Matrix2, SMatrix, SVector, Vector2};

use super::rounding::{WirePixel, WireRounding};
use crate::gauge::edge::estimation::levels::{LevelCurve, LevelPool};
use crate::gauge::edge::estimation::light_field::{LightField, LightFieldLimits, Lit};
use crate::gauge::edge::estimation::noise::{NoiseLimits, Spread};
use crate::gauge::edge::estimation::rounding::noise_in_steps;
use crate::gauge::edge::image::part_localisation::CoarseEdge;
use crate::gauge::edge::image::plane::{Plane, Sample};
use crate::gauge::edge::model::edge_spread::EdgeSpreadFunction;
use crate::gauge::edge::model::gaussian::EdgeSample;
use crate::gauge::edges::{Edge, EdgeState};
use crate::gauge::limit::limits;
use crate::numerics::robust::{MEDIAN_TO_SD, median_of};
use crate::profile::Reason;

limits! {
    /// How a wire is fitted.
    WireFitLimits = "wire_fit";
    /// Fewest pixels of light beside each edge, px: a Gaussian edge reaches 3.6 blurs and 1.25 px,
    /// 7 px at a blur of 1.6 px; less shows no level.
    least_beside_px: usize = 7;
    /// Rounds of the fit; noise and outlying columns are estimated anew in each. Tuned: see study
    /// limits.
    rounds: usize = 4;
    /// Most Gauss-Newton steps in a round; they end before where the last changed places and blur
    /// by less than 1e-5 px.
    steps: usize = 8;
    /// Most columns that the light's field and the noise are estimated from: the field has six
    /// parameters, and 256 columns of 40 pixels determine each to about a hundredth of the noise of
    /// one pixel (1/√10 240).
    field_columns: usize = 256;
    /// Pixels on both sides of the wire that the light's field is estimated from, px: more rows
    /// then show it than the widest wire of 24 px hides.
    field_px: f64 = 20.0;
    /// Most knots of the light along the wire beside the field: five halvings of the two ends'
    /// distance, each of which must be worth the penalty of its knots (`levels.knot_penalty`).
    most_knots: usize = 33;
    /// Fewest pixels from which a zone's noise is estimated: the standard deviation by a median of
    /// 64 is known to 1.17/√64 = 15 %.
    least_pixels: usize = 64;
}

/// Most pixels beside each edge that take part.
const BESIDE: usize = 12;
/// Pooled parameters: B, three of each light, σ.
const POOLED: usize = 8;
const SIGMA: usize = 7;

type Pooled = SVector<f64, POOLED>;
type Normal = SMatrix<f64, POOLED, POOLED>;
type Cross = SMatrix<f64, POOLED, 2>;

/// A column of the wire.
struct Column {
    index: usize,
    /// Row of the first pixel.
    first: i32,
    pixels: Vec<f32>,
    /// Abscissa along the wire, −1 to 1.
    x: f64,
    /// Light in the middle over that of the field's centre: the contrast's factor.
    gain: f64,
    /// Rows of both edges.
    edges: Vector2<f64>,
    /// Whether it takes part in the pooled parameters.
    good: bool,
}

/// Sums of one column's equations.
struct Sums {
    normal: Normal,
    right: Pooled,
    cross: Cross,
    own: Matrix2<f64>,
    own_right: Vector2<f64>,
    chi2: f64,
}

/// A fitted wire.
pub(crate) struct Wire {
    columns: Vec<Column>,
    pooled: Pooled,
    /// Noise variance in the shadow and in the light, counts².
    variance: [f64; 2],
    covariance: Normal,
    shape: EdgeSpreadFunction,
}

impl Wire {
    /// Fits the wire between the coarse edges; `Err` is why not. `floor` is the least variance of a
    /// pixel, counts².
    pub(crate) fn fit<T: Sample>(
        plane: &Plane<'_, T>,
        (top, bottom): (&[CoarseEdge], &[CoarseEdge]),
        shape: &EdgeSpreadFunction,
        floor: f64,
    ) -> Result<Self, Reason> {
        let columns = read(plane, top, bottom)?;
        let mut wire = Self {
            pooled: start(&columns),
            columns,
            variance: [floor; 2],
            covariance: Normal::zeros(),
            shape: shape.clone(),
        };
        if !(wire.contrast() > 0.0) {
            return Err(Reason::LowContrast);
        }
        wire.variance = [(0.01 * wire.contrast()).powi(2).max(floor); 2];
        wire.settle(floor).ok_or(Reason::NoEdge)?;
        if wire.level_light(plane) {
            wire.settle(floor).ok_or(Reason::NoEdge)?;
        }
        wire.covariance = wire.reduced(&wire.all_sums()).0.try_inverse().ok_or(Reason::NoEdge)?;
        Ok(wire)
    }

    /// Solves for all parameters; `None` where the equations are singular.
    fn settle(&mut self, floor: f64) -> Option<()> {
        let WireFitLimits { rounds, steps, .. } = *WireFitLimits::get();
        for _ in 0..rounds {
            for _ in 0..steps {
                if self.step()? < 1e-5 {
                    break;
                }
            }
            self.estimate_variance(floor);
            self.judge();
        }
        Some(())
    }

    /// Divides the columns by the field of the light beside the wire; false where the light is
    /// even.
    fn level_light<T: Sample>(&mut self, plane: &Plane<'_, T>) -> bool {
        let WireFitLimits { field_px, field_columns, .. } = *WireFitLimits::get();
        let dark = self.pooled[0];
        let clear = 4.0 * self.pooled[SIGMA] + 1.0;
        let mut points = Vec::new();
        for column in self.columns.iter().step_by(self.columns.len().div_ceil(field_columns)) {
            let [top, bottom] = [column.edges[0] - clear, column.edges[1] + clear];
            let rows = [(top - field_px, top), (bottom, bottom + field_px)];
            for (from, to) in rows {
                let last = to.min(plane.rows as f64 - 1.0);
                for row in from.max(0.0).ceil() as usize..=last.max(0.0) as usize {
                    let contrast = f64::from(plane.at(row, column.index)) - dark;
                    points.push(Lit { x: column.index as f64, y: row as f64, contrast });
                }
            }
        }
        let Some(field) = LightField::fit(&points) else { return false };
        let along = self.light_along(plane, &field, clear);
        for column in &mut self.columns {
            let x = column.index as f64;
            let middle = field.relative(x, 0.5 * column.edges.sum());
            column.gain = middle * along.get(column.index).copied().map_or(1.0, f64::from);
            for (k, value) in column.pixels.iter_mut().enumerate() {
                let light = field.relative(x, f64::from(column.first) + k as f64) / middle;
                *value = (dark + (f64::from(*value) - dark) / light) as f32;
            }
        }
        // The light that remains has one level all along.
        let light = |from: usize| {
            median_of(
                self.columns
                    .iter()
                    .map(|c| {
                        let end = if from == 1 { c.pixels.first() } else { c.pixels.last() };
                        dark + (f64::from(end.copied().unwrap_or(0.0)) - dark) / c.gain
                    })
                    .collect(),
            )
        };
        let levels = [light(1), light(4)];
        for (from, level) in [1, 4].into_iter().zip(levels) {
            (self.pooled[from], self.pooled[from + 1], self.pooled[from + 2]) = (level, 0.0, 0.0);
        }
        true
    }

    /// Light beside the wire over the field, column by column of the frame, pooled along it: along
    /// a wire light may fall in any way, also linearly, of which the logarithm is no quadratic.
    /// Empty where it cannot be estimated.
    fn light_along<T: Sample>(&self, plane: &Plane<'_, T>, field: &LightField, clear: f64) -> Vec<f32> {
        let WireFitLimits { field_px, most_knots, .. } = *WireFitLimits::get();
        let dark = self.pooled[0];
        let mut means = vec![f32::NAN; plane.columns];
        for column in &self.columns {
            let (x, last) = (column.index as f64, plane.rows as f64 - 1.0);
            let [top, bottom] = [column.edges[0] - clear, column.edges[1] + clear];
            let (mut sum, mut count) = (0.0, 0.0);
            for (from, to) in [(top - field_px, top), (bottom, bottom + field_px)] {
                for row in from.max(0.0).ceil() as usize..=to.clamp(0.0, last) as usize {
                    let contrast = f64::from(plane.at(row, column.index)) - dark;
                    (sum, count) = (sum + contrast / field.relative(x, row as f64), count + 1.0);
                }
            }
            if count > 0.0 {
                means[column.index] = (sum / count) as f32;
            }
        }
        let steps = means.windows(2).map(|w| f64::from((w[1] - w[0]).abs())).filter(|step| step.is_finite());
        let sd = MEDIAN_TO_SD * median_of(steps.collect()) / std::f64::consts::SQRT_2;
        let mut curve = LevelCurve::default();
        if !(sd > 0.0 && LevelPool::default().pool(&means, sd as f32, most_knots, &mut curve)) {
            return Vec::new();
        }
        let usual = curve.mean as f32;
        curve.level.iter().map(|level| level / usual).collect()
    }

    /// Blur, px.
    pub(crate) fn sigma(&self) -> f64 {
        self.pooled[SIGMA]
    }

    /// Level of the shadow and of the light above and below in the middle of the field, counts.
    pub(crate) fn levels(&self) -> (f64, [f64; 2]) {
        (self.pooled[0], [self.pooled[1], self.pooled[4]])
    }

    /// Noise in the shadow and in the light, counts.
    pub(crate) fn noise(&self) -> [f64; 2] {
        self.variance.map(f64::sqrt)
    }

    fn contrast(&self) -> f64 {
        0.5 * (self.pooled[1] + self.pooled[4]) - self.pooled[0]
    }

    /// Median width of the columns, px.
    pub(crate) fn width_px(&self) -> f64 {
        median_of(self.columns.iter().map(|c| c.edges[1] - c.edges[0]).collect())
    }

    /// Degrees of freedom of a column's residual, on the mean.
    pub(crate) fn freedom(&self) -> f64 {
        let pixels: usize = self.columns.iter().map(|c| c.pixels.len()).sum();
        pixels as f64 / self.columns.len().max(1) as f64 - 2.0
    }

    /// The equations of some columns, pooled constants and both edges.
    pub(crate) fn equations(&self, columns: usize) -> Vec<Vec<WirePixel>> {
        let step = self.columns.len().div_ceil(columns).max(1);
        let of = |column: &Column| {
            let mut pixels = Vec::with_capacity(column.pixels.len());
            self.each_pixel(column, |_, light, pooled, edges| {
                let by = [pooled[0], pooled[1], pooled[4], pooled[SIGMA], edges[0], edges[1]];
                let weight = self.variance_at(light * column.gain).recip();
                pixels.push(WirePixel {
                    weight,
                    light: [pooled[1], pooled[4]].map(|l| l / column.gain),
                    by: by.into(),
                });
            });
            pixels
        };
        self.columns.iter().step_by(step).filter(|column| column.good).map(of).collect()
    }

    /// Effect of rounding in steps, counts, on the grey values.
    pub(crate) fn rounding(&self, step: f64) -> WireRounding {
        let mut zones = [Vec::new(), Vec::new()];
        let thinned = (self.columns.len() / WireFitLimits::get().field_columns).max(1);
        for pair in self.columns.windows(2).step_by(thinned).filter(|p| p[0].index + 1 == p[1].index) {
            let mut row = pair[0].first;
            self.each_pixel(&pair[0], |_, light, _, _| {
                let place = |column: &Column| column.pixels.get((row - column.first) as usize).copied();
                if let (Some(a), Some(b)) = (place(&pair[0]), place(&pair[1])) {
                    match light {
                        l if l < 0.02 => zones[0].push(a - b),
                        l if l > 0.98 => zones[1].push(a - b),
                        _ => {}
                    }
                }
                row += 1;
            });
        }
        let least = (step * NoiseLimits::get().least_of_counts) as f32;
        let [dark, light] = zones.map(|zone| Spread::of(&zone, least));
        let dark = if dark.variance().is_some() { dark } else { light };
        let p = &self.pooled;
        let run = |from: usize| (2.0 * p[from + 1]).abs() / step;
        WireRounding {
            step,
            noise: [dark, light].map(|spread| noise_in_steps(spread, step)),
            runs: [0.0, run(1), run(4)],
            alike: (p[1] - p[4]).abs() < 0.5 * step,
        }
    }

    /// Writes both edges of every column of the frame; those that were not fitted keep the gaps
    /// that stand there.
    pub(crate) fn write(&self, top: &mut [Edge], bottom: &mut [Edge]) {
        for column in &self.columns {
            let sums = self.sums(column);
            let Some(own) = sums.own.try_inverse() else { continue };
            // How the edges follow the pooled parameters, and what those leave of the width.
            let lever = sums.cross * own;
            let shared = lever.transpose() * self.covariance * lever;
            let width = shared[(0, 0)] + shared[(1, 1)] - 2.0 * shared[(0, 1)];
            let u_shared_px = (0.5 * width.max(0.0)).sqrt() as f32;
            let chi2 = (sums.chi2 / (column.pixels.len() as f64 - 2.0)) as f32;
            for (side, line) in [&mut *top, &mut *bottom].into_iter().enumerate() {
                line[column.index] = Edge {
                    row_px: column.edges[side],
                    u_own_px: own[(side, side)].max(0.0).sqrt() as f32,
                    u_shared_px,
                    chi2,
                    state: EdgeState::Good,
                };
            }
        }
    }

    /// Sums over a column's pixels.
    fn sums(&self, column: &Column) -> Sums {
        let mut s = Sums {
            normal: Normal::zeros(),
            right: Pooled::zeros(),
            cross: Cross::zeros(),
            own: Matrix2::zeros(),
            own_right: Vector2::zeros(),
            chi2: 0.0,
        };
        let huber = LightFieldLimits::get().huber;
        self.each_pixel(column, |residual, light, by_pooled, by_edges| {
            let variance = self.variance_at(light * column.gain);
            s.chi2 += residual * residual / variance;
            let damping = (huber * variance.sqrt() / residual.abs().max(f64::MIN_POSITIVE)).min(1.0);
            let weight = damping / variance;
            s.normal += by_pooled * by_pooled.transpose() * weight;
            s.right += by_pooled * (weight * residual);
            s.cross += by_pooled * by_edges.transpose() * weight;
            s.own += by_edges * by_edges.transpose() * weight;
            s.own_right += by_edges * (weight * residual);
        });
        s
    }

    /// Calls `sum` with each pixel's residual, share of light and derivatives by the pooled
    /// parameters and both edges.
    fn each_pixel(&self, column: &Column, mut sum: impl FnMut(f64, f64, Pooled, Vector2<f64>)) {
        let (p, x) = (&self.pooled, column.x);
        let powers = [1.0, x, x * x];
        let level = |from: usize| (0..3).map(|k| p[from + k] * powers[k]).sum::<f64>();
        let (above, below) = (column.gain * (level(1) - p[0]), column.gain * (level(4) - p[0]));
        let mut samples = [[EdgeSample::default(); 2 * BESIDE + 2 * WIDEST_PX as usize]; 2];
        let count = column.pixels.len().min(samples[0].len());
        for (side, samples) in samples.iter_mut().enumerate() {
            let place = column.edges[side] - f64::from(column.first);
            // The upper edge runs from light to shadow: a table's ends are exchanged with it.
            if side == 0 {
                self.shape.samples(1.0 - count as f64, -place, p[SIGMA], &mut samples[..count]);
                samples[..count].reverse();
            } else {
                self.shape.samples(0.0, place, p[SIGMA], &mut samples[..count]);
            }
        }
        for (k, m) in column.pixels.iter().take(count).enumerate() {
            let (t, b) = (&samples[0][k], &samples[1][k]);
            let value = p[0] + above * t.value + below * b.value;
            let mut by_pooled = Pooled::zeros();
            by_pooled[0] = 1.0 - column.gain * (t.value + b.value);
            for (power, factor) in powers.iter().enumerate() {
                by_pooled[1 + power] = column.gain * t.value * factor;
                by_pooled[4 + power] = column.gain * b.value * factor;
            }
            by_pooled[SIGMA] = above * t.by_sigma + below * b.by_sigma;
            let by_edges = Vector2::new(-above * t.by_position, below * b.by_position);
            sum(f64::from(*m) - value, t.value + b.value, by_pooled, by_edges);
        }
    }

    fn variance_at(&self, light: f64) -> f64 {
        let share = light.max(0.0);
        self.variance[0] + share * (self.variance[1] - self.variance[0])
    }

    /// Sums of every column.
    fn all_sums(&self) -> Vec<Sums> {
        self.columns.iter().map(|column| self.sums(column)).collect()
    }

    /// The pooled equations with the edges of the good columns eliminated.
    fn reduced(&self, sums: &[Sums]) -> (Normal, Pooled) {
        let (mut normal, mut right) = (Normal::zeros(), Pooled::zeros());
        for (s, _) in sums.iter().zip(&self.columns).filter(|(_, column)| column.good) {
            let Some(own) = s.own.try_inverse() else { continue };
            normal += s.normal - s.cross * own * s.cross.transpose();
            right += s.right - s.cross * own * s.own_right;
        }
        // A parabola that few columns do not determine is tied to zero with a billionth of the
        // constants' weight.
        for k in [2, 3, 5, 6] {
            normal[(k, k)] += 1e-9 * normal[(1, 1)];
        }
        (normal, right)
    }

    /// One Gauss-Newton step; the larger of the blur's change and the edges' mean one, px, or
    /// `None` where the equations are singular.
    fn step(&mut self) -> Option<f64> {
        let sums = self.all_sums();
        let (normal, right) = self.reduced(&sums);
        let full = normal.cholesky()?.solve(&right);
        let tame = |step: f64, limit: f64| (limit / step.abs().max(f64::MIN_POSITIVE)).min(1.0);
        let slow =
            tame(full[SIGMA], 0.25 * self.pooled[SIGMA]).min(tame(full[0], 0.25 * self.contrast().abs()));
        let change = full * slow;
        let (mut moved, mut count) = (0.0, 0.0_f64);
        for (column, s) in self.columns.iter_mut().zip(&sums) {
            let own = s.own.try_inverse().unwrap_or_else(Matrix2::zeros);
            let step = own * (s.own_right - s.cross.transpose() * change);
            column.edges += step.map(|px| px.clamp(-0.5, 0.5));
            if column.good {
                moved += step.amax();
                count += 1.0;
            }
        }
        self.pooled += change;
        self.pooled[SIGMA] = self.pooled[SIGMA].clamp(self.shape.least_sigma(), 8.0);
        Some((moved / count.max(1.0)).max(change[SIGMA].abs()))
    }

    /// Noise in shadow and light from the residuals, robustly; a shadow of too few pixels has the
    /// light's.
    fn estimate_variance(&mut self, floor: f64) {
        let mut zones = [Vec::new(), Vec::new()];
        for column in self.columns.iter().filter(|c| c.good) {
            self.each_pixel(column, |residual, light, _, _| match light {
                l if l < 0.2 => zones[0].push(residual.abs()),
                l if l > 0.9 => zones[1].push(residual.abs()),
                _ => {}
            });
        }
        let counts = zones.each_ref().map(Vec::len);
        let [dark, light] = zones.map(|z| (MEDIAN_TO_SD * median_of(z)).powi(2).max(floor));
        self.variance = [if counts[0] >= WireFitLimits::get().least_pixels { dark } else { light }, light];
    }

    /// Excludes from the pooled parameters the columns with outlying residuals.
    fn judge(&mut self) {
        let chi2: Vec<f64> =
            self.columns.iter().map(|c| self.sums(c).chi2 / (c.pixels.len() as f64 - 2.0)).collect();
        let usual = median_of(chi2.clone());
        for (column, chi2) in self.columns.iter_mut().zip(chi2) {
            column.good = chi2 <= 3.0 * usual;
        }
    }
}

/// The pixels of the columns that have both edges and light beside them.
fn read<T: Sample>(
    plane: &Plane<'_, T>,
    top: &[CoarseEdge],
    bottom: &[CoarseEdge],
) -> Result<Vec<Column>, Reason> {
    let least = WireFitLimits::get().least_beside_px as i32;
    let (mut columns, mut seen) = (Vec::new(), 0);
    for (index, (t, b)) in top.iter().zip(bottom).enumerate() {
        let (Ok(t), Ok(b)) = (*t, *b) else { continue };
        seen += 1;
        let last_row = plane.rows as i32 - 1;
        let (first, last) = ((t - BESIDE as i32).max(0), (b + BESIDE as i32).min(last_row));
        let enough = t - first >= least && last - b >= least;
        if !enough || f64::from(b - t) > 1.5 * WIDEST_PX {
            continue;
        }
        let pixels = (first..=last).map(|row| plane.at(row as usize, index)).collect();
        let x = 2.0 * index as f64 / plane.columns as f64 - 1.0;
        let edges = Vector2::new(f64::from(t) - 0.5, f64::from(b) + 0.5);
        columns.push(Column { index, first, pixels, x, gain: 1.0, edges, good: true });
    }
    match (columns.len(), seen) {
        (n, _) if n >= 8 => Ok(columns),
        (_, n) if n >= 8 => Err(Reason::Border),
        _ => Err(Reason::NoEdge),
    }
}

/// Levels from the outermost pixels and from the darkest one of each column; a blur of one pixel.
fn start(columns: &[Column]) -> Pooled {
    let median = |of: &dyn Fn(&Column) -> f32| median_of(columns.iter().map(|c| f64::from(of(c))).collect());
    let dark = median(&|c| c.pixels.iter().copied().fold(f32::INFINITY, f32::min));
    let above = median(&|c| 0.5 * (c.pixels[0] + c.pixels[1]));
    let below = median(&|c| 0.5 * (c.pixels[c.pixels.len() - 1] + c.pixels[c.pixels.len() - 2]));
    Pooled::from([dark, above, 0.0, 0.0, below, 0.0, 0.0, 1.0])
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::numerics::distributions::phi_cdf;

    /// Light of a wire from t to b at a row, by the midpoint rule over the pixel.
    fn light(row: f64, t: f64, b: f64, sigma: f64) -> f64 {
        let n = 64;
        let at = |i: i32| row - 0.5 + (f64::from(i) + 0.5) / f64::from(n);
        (0..n).map(|i| 1.0 - phi_cdf((at(i) - t) / sigma) + phi_cdf((at(i) - b) / sigma)).sum::<f64>()
            / f64::from(n)
    }

    #[test]
    fn widths_of_thin_wires_lie_within_their_uncertainty() {
        let (rows, columns) = (48, 200);
        let mut beyond = 0;
        let cases = [(6.3, 0.6), (6.3, 1.2), (6.3, 1.8), (9.1, 1.0), (14.7, 2.0), (21.2, 1.5)];
        for (seed, (width, sigma)) in cases.into_iter().enumerate() {
            let mut rng = Pcg64::seed_from_u64(seed as u64);
            let noise = Normal::new(0.0, 1.5).unwrap();
            let mut pixels = vec![0.0_f32; rows * columns];
            let (mut top, mut bottom) = (Vec::new(), Vec::new());
            for c in 0..columns {
                let t = 20.2 + 0.013 * c as f64 - 0.5 * width;
                for r in 0..rows {
                    let bright = 190.0 - 0.1 * c as f64;
                    let mean = 12.0 + (bright - 12.0) * light(r as f64, t, t + width, sigma);
                    pixels[r * columns + c] = (mean + noise.sample(&mut rng)).round() as f32;
                }
                top.push(Ok((t + 1.0) as i32));
                bottom.push(Ok((t + width - 1.0) as i32));
            }
            let plane =
                Plane { pixels: &pixels, rows, columns, row_stride: columns, column_stride: 1, sign: 1.0 };
            let wire = Wire::fit(&plane, (&top, &bottom), &EdgeSpreadFunction::Gaussian, 1.0 / 12.0).unwrap();
            let (mut upper, mut lower) =
                (vec![Edge::gap(Reason::NoEdge); columns], vec![Edge::gap(Reason::NoEdge); columns]);
            wire.write(&mut upper, &mut lower);
            let n = columns as f64;
            let mean = upper.iter().zip(&lower).map(|(t, b)| b.row_px - t.row_px).sum::<f64>() / n;
            let own: f64 =
                upper.iter().chain(&lower).map(|e| f64::from(e.u_own_px).powi(2)).sum::<f64>() / (n * n);
            let shared = 2.0 * f64::from(upper[columns / 2].u_shared_px).powi(2);
            let u = (own + shared).sqrt();
            assert!((mean - width).abs() < 3.5 * u, "{width} px, σ {sigma}: {mean} u {u}");
            assert!(u < 0.03, "{width} px, σ {sigma}: u {u}");
            beyond += usize::from((mean - width).abs() > 2.0 * u);
        }
        assert!(beyond <= 1, "{beyond}");
    }
}
