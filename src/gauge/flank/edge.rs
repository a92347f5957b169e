//! The cutting edge inside its strip, and the reference curve of what it was before it wore.
//!
//! The edge is the border between air, which keeps its level, and whatever departs from it; the
//! path of least cost through a strip about the straight line. Wear and chips displace it into the
//! flank only: the reference is a parabola that follows the upper side of the path (deviations into
//! the flank lose weight as 1/r², those into the air as 1/r).

use nalgebra::{DMatrix, DVector};

use super::envelope::envelope;
use super::limits::FlankLimits;
use super::path::Costs;
use super::raster::{Raster, quantile};
use super::strip::Frame;
use crate::numerics::robust::MEDIAN_TO_SD;

/// A traced edge.
#[derive(Clone, Debug)]
pub(crate) struct TracedEdge {
    /// Depth of the edge below the straight line in every column, µm.
    pub depth_um: Vec<f64>,
}

/// What the air's grey values do on the way to the edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Air {
    /// They keep their level.
    Even,
    /// They go on changing as far above it: what stands behind the edge is out of focus and changes
    /// slowly, but may do so by more than the noise.
    Changing,
}

/// Follows the edge through a strip that was cut about the straight line.
pub(crate) fn trace(strip: &Raster, frame: &Frame, air: Air) -> TracedEdge {
    let depart = departure(strip, frame, air);
    let window = (20.0 / frame.row_um()) as usize;
    let rows = strip.rows;
    let column = |c: usize| {
        let mut total = vec![0.0_f32; rows + 1];
        for r in 0..rows {
            total[r + 1] = total[r] + depart.at(r, c);
        }
        (0..rows).map(|u| total[u] - (total[(u + window).min(rows)] - total[u])).collect()
    };
    let costs = Costs { columns: (0..strip.columns).map(column).collect(), step: 2.0, most_step: 2 };
    let rows = half_way(strip, frame, &costs.cheapest());
    let depth = rows.into_iter().map(|r| (r - frame.above as f64) * frame.row_um());
    TracedEdge { depth_um: depth.collect() }
}

/// Where grey values have gone half of the way from the air's level to what lies below the path,
/// rows: the border itself, where the first departure is as far above it as the blur reaches.
fn half_way(strip: &Raster, frame: &Frame, path: &[usize]) -> Vec<f64> {
    let limits = FlankLimits::get();
    let rows = |um: f64| (um / frame.row_um()) as usize;
    let (reach, behind) = (rows(limits.border_um), rows(limits.border_below_um));
    let smooth = strip.blurred(0.0, 6.0);
    let air = rows(limits.air_um);
    let one = |c: usize| {
        let (from, to) = (path[c].saturating_sub(reach), (path[c] + behind).min(strip.rows - 1));
        let level = quantile((from.saturating_sub(air)..from.max(1)).map(|r| smooth.at(r, c)).collect(), 0.5);
        let off = |r: usize| (smooth.at(r, c) - level).abs();
        let half = 0.5 * (from..=to).map(off).fold(0.0, f32::max);
        let at = (from..=to).find(|r| off(*r) >= half).unwrap_or(path[c]);
        if at == 0 {
            return 0.0;
        }
        let (before, after) = (off(at - 1).min(half), off(at));
        at as f64 - f64::from((after - half) / (after - before).max(1e-6)).min(1.0)
    };
    (0..strip.columns).map(one).collect()
}

/// How far pixels depart from the air: −1 none, up to 1.5.
fn departure(strip: &Raster, frame: &Frame, air: Air) -> Raster {
    let limits = FlankLimits::get();
    let near = (limits.air_um / frame.row_um()) as usize;
    let air_rows = frame.above.saturating_sub(near).max(1);
    let smooth = strip.blurred(0.0, 12.0);
    let levels: Vec<AirLevel> =
        (0..strip.columns).map(|c| AirLevel::of(&smooth, c, (air_rows, air))).collect();
    let off = |r: usize, c: usize| levels[c].off(strip.at(r, c), r.min(air_rows));
    // about the median, so that a course of the air that is not straight counts as scatter
    let about = |r: usize, c: usize| (strip.at(r, c) - levels[c].middle).abs();
    let scatter =
        (0..air_rows).flat_map(|r| (0..strip.columns).map(move |c| (r, c))).map(|(r, c)| about(r, c));
    let sigma = (MEDIAN_TO_SD as f32 * quantile(scatter.collect(), 0.5)).max(1e-6);
    let mut out = Raster::new(strip.rows, strip.columns);
    for (k, value) in out.values.iter_mut().enumerate() {
        *value = (off(k / strip.columns, k % strip.columns) / (4.0 * sigma) - 1.0).clamp(-1.0, 1.5);
    }
    out
}

/// Grey value of the air in a column: its median, and a straight course over the rows where it
/// changes; what lies between both is air.
struct AirLevel {
    middle: f32,
    upper: f32,
    lower: f32,
    half: f32,
}

impl AirLevel {
    /// From the medians of so many rows, and of the upper and the lower half of them.
    fn of(smooth: &Raster, column: usize, (rows, air): (usize, Air)) -> Self {
        let half = (rows / 2).max(1);
        let median =
            |rows: std::ops::Range<usize>| quantile(rows.map(|r| smooth.at(r, column)).collect(), 0.5);
        let middle = median(0..rows);
        let [upper, lower] = match air {
            Air::Even => [middle; 2],
            Air::Changing => [median(0..half), median(rows.saturating_sub(half)..rows)],
        };
        Self { middle, upper, lower, half: half as f32 }
    }

    /// Distance of a grey value from what the air may have at a row.
    fn off(&self, value: f32, row: usize) -> f32 {
        let t = (row as f32 + 0.5 - 0.5 * self.half) / self.half;
        let straight = self.upper + t * (self.lower - self.upper);
        let (least, most) = (straight.min(self.middle), straight.max(self.middle));
        (least - value).max(value - most).max(0.0)
    }
}

/// A reference curve as fitted.
#[derive(Clone, Debug)]
pub(crate) struct ReferenceCurve {
    /// Coefficients, px into the flank by powers of s/length.
    pub curve: Vec<f64>,
    /// Standard uncertainty of the curve's level, µm.
    pub u_um: f64,
}

/// Fits the curve to a traced edge; `shape` is a curve whose bend is known (the baseline's), to
/// which offset and slope are fitted then.
pub(crate) fn reference(traced: &TracedEdge, frame: &Frame, shape: Option<&[f64]>) -> Option<ReferenceCurve> {
    let limits = FlankLimits::get();
    if shape.is_some() {
        return fitted(traced, frame, shape, 2);
    }
    let found = fitted(traced, frame, None, limits.edge_powers)?;
    // the sagitta of c·t² over 0 to 1 is c/4
    let sagitta_um = found.curve.get(2).map_or(0.0, |c| 0.25 * c.abs() * frame.um_per_px);
    if sagitta_um > limits.most_sagitta_um { fitted(traced, frame, None, 2) } else { Some(found) }
}

fn fitted(
    traced: &TracedEdge,
    frame: &Frame,
    shape: Option<&[f64]>,
    powers: usize,
) -> Option<ReferenceCurve> {
    let limits = FlankLimits::get();
    let n = traced.depth_um.len();
    if n < 4 * powers {
        return None;
    }
    let t = |k: usize| frame.s_px(k as f64) / frame.line.length_px;
    let known = |k: usize| {
        shape.map_or(0.0, |c| c.iter().skip(2).rev().fold(0.0, |sum, c| sum * t(k) + c) * t(k).powi(2))
    };
    let y = DVector::from_fn(n, |k, _| traced.depth_um[k] / frame.um_per_px - known(k));
    let x = DMatrix::from_fn(n, powers, |k, p| t(k).powi(p as i32));
    let depth_um: Vec<f64> = y.iter().map(|v| v * frame.um_per_px).collect();
    let places: Vec<f64> = (0..n).map(t).collect();
    let (mut weights, mut c, mut spread) = (DVector::from_element(n, 1.0), DVector::zeros(powers), 1.0);
    if let Some(on) = envelope(&places, &depth_um, powers) {
        weights = DVector::from_fn(n, |k, _| if on[k] { 1.0 } else { 1e-4 });
    }
    for _ in 0..limits.edge_rounds {
        let weighted = DMatrix::from_fn(n, powers, |k, p| x[(k, p)] * weights[k]);
        let normal = weighted.transpose() * &x;
        c = normal.cholesky()?.solve(&(weighted.transpose() * &y));
        let residual = &y - &x * &c;
        spread = spread_above(residual.iter().copied());
        for k in 0..n {
            let r = residual[k] / spread;
            weights[k] = if r > 1.0 { r.powi(-2) } else { (-r).max(1.0).recip() };
        }
    }
    let mut curve: Vec<f64> = c.iter().copied().collect();
    if let Some(shape) = shape {
        curve.extend(shape.iter().skip(2));
    }
    // the path scatters over lengths of about twenty columns
    let independent = (n as f64 / 20.0).max(1.0);
    let u_um = spread * frame.um_per_px * (powers as f64 / independent).sqrt();
    Some(ReferenceCurve { curve, u_um })
}

/// Standard deviation of what lies on the air's side, px: half a row at least.
fn spread_above(residuals: impl Iterator<Item = f64>) -> f64 {
    let above: Vec<f32> = residuals.filter(|r| *r <= 0.0).map(|r| -r as f32).collect();
    (MEDIAN_TO_SD * f64::from(quantile(above, 0.5))).max(0.5)
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::super::reference::EdgeLine;
    use super::*;

    /// A cambered edge of 400 columns with a chip of three tenths of its length, 24 µm deep, that
    /// scatters by a pixel: the reference passes over the chip. After six rounds it is still off by
    /// more than a pixel.
    #[test]
    fn the_reference_passes_over_a_chip_of_three_tenths_of_the_edge() {
        let um_per_px = 2.4;
        let length_px = 399.0 * 4.0 / um_per_px + 0.1;
        let line = EdgeLine { from: DVec2::ZERO, along: DVec2::X, normal: DVec2::Y, length_px };
        let frame = Frame::about(line, um_per_px, (120.0, 120.0));
        assert_eq!(frame.columns(), 400);
        let place = |k: usize| frame.s_px(k as f64) / length_px;
        let camber_px = |t: f64| 24.0 * t * (1.0 - t);
        let depth_px = |k: usize| {
            let t = place(k);
            let within = 1.0 - ((t - 0.5) / 0.15).powi(2);
            camber_px(t) + (0.618_034 * k as f64).fract() - 0.5 + 10.0 * within.max(0.0).sqrt()
        };
        let traced = TracedEdge { depth_um: (0..400).map(|k| um_per_px * depth_px(k)).collect() };
        let found = reference(&traced, &frame, None).unwrap();
        for t in (0..400).map(place) {
            let curve = found.curve.iter().rev().fold(0.0, |sum, c| sum * t + c);
            assert!((curve - camber_px(t)).abs() < 0.2, "{t}: {curve} {}", camber_px(t));
        }
    }
}
