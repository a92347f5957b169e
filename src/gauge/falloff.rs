//! Light that falls off across an edge: a cloud of mist, a veil, the flank of a light that is not even.
//!
//! The light's level is read from flat pixels D px beyond the edge and holds up to it only where the light is even. A few pixels
//! farther out, in a sample of the columns, tell how it changes. Where it grows outwards by g, a share of the contrast per px, pixel
//! k at y_k px from the edge differs from the model by g·E_k·(y_k − D), so that the edge is placed g·Σ w_k E_k (y_k − D) too far out. A
//! level that neighbours share is also an error that neighbours share: it is stated with the shared uncertainty.

use super::edges::Edge;
use super::levels::LevelCurve;
use super::noise::NoiseModel;
use super::pixels::{Plane, Sample};
use super::table::{Table, half};
use super::window::{Side, Windows};

/// Columns of a tile, whose light falls off alike, and the distance of those looked at.
const TILE: usize = 64;
const STEP: usize = 4;
/// Columns looked at below which a tile says nothing.
const LEAST: usize = 5;
/// Pixels looked at, and the distance of the first from the end of the window, px.
const FAR: usize = 4;
const BEYOND: usize = 8;
/// Change of the light between both places that counts, as a share of the contrast and in standard deviations: a clean frame's
/// uncertainty stays what the noise says. What less may hide moves an edge by some thousandths of a pixel.
const LEAST_CHANGE: f64 = 0.005;
const LIMIT: f64 = 4.0;
/// Standard deviation of a median over that of a mean.
const MEDIAN: f64 = 1.2533;

/// How the light of a side changes outwards, tile by tile.
#[derive(Clone, Debug, Default)]
pub(crate) struct Falloff {
    /// Median change of the light from the window's flat end to the far pixels, counts, and the number of columns; NaN where unknown.
    tiles: Vec<(f32, u32)>,
}

impl Falloff {
    /// Looks at the light beyond the windows of a side.
    pub(crate) fn look<T: Sample>(&mut self, plane: &Plane<'_, T>, windows: &Windows) {
        self.tiles.clear();
        let down = windows.side == Side::Bottom;
        let ahead = (windows.width - 1 + BEYOND - half(windows.width)) as i32 * windows.side.sign();
        for (tile, centres) in windows.centre.chunks(TILE).enumerate() {
            let mut changes = [f32::NAN; TILE / STEP];
            let mut count = 0;
            for (offset, centre) in centres.iter().enumerate().step_by(STEP) {
                let (Ok(centre), column) = (centre, tile * TILE + offset) else { continue };
                let mut far = [0.0_f32; FAR];
                if windows.light[column].is_finite()
                    && plane.gather((centre + ahead) as isize, down, column, &mut far)
                {
                    changes[count] = far.iter().sum::<f32>() / FAR as f32 - windows.light[column];
                    count += 1;
                }
            }
            let known = &mut changes[..count];
            let change = if count < LEAST {
                f32::NAN
            } else {
                *known.select_nth_unstable_by(count / 2, f32::total_cmp).1
            };
            self.tiles.push((change, count as u32));
        }
    }

    /// Adds to the shared uncertainty of a side's edges what the light's change outwards moved them by.
    pub(crate) fn state(
        &self,
        line: &mut [Edge],
        windows: &Windows,
        (dark, light): (&LevelCurve, &LevelCurve),
        (noise, table): (&NoiseModel, &Table),
    ) {
        let flat = windows.flat as f64;
        let apart = BEYOND as f64 + 0.5 * (FAR as f64 + flat);
        let shift = shift(table, windows.flat) / apart;
        for (tile, (edges, (change, count))) in line.chunks_mut(TILE).zip(&self.tiles).enumerate() {
            let middle = tile * TILE + edges.len() / 2;
            let (Some(level), Some(ground)) = (light.level.get(middle), dark.level.get(middle)) else {
                continue;
            };
            let (level, contrast) = (f64::from(*level), f64::from(level - ground));
            let variance = noise.variance(level) * (1.0 / flat + 1.0 / FAR as f64) / f64::from(*count);
            let change = f64::from(change.abs());
            if !(change > (LEAST_CHANGE * contrast).max(LIMIT * MEDIAN * variance.sqrt())) {
                continue;
            }
            let moved = (shift * change / contrast) as f32;
            for edge in edges.iter_mut().filter(|e| e.is_usable()) {
                edge.u_shared_px = edge.u_shared_px.hypot(moved);
            }
        }
    }
}

/// |Σ w_k E_k (y_k − D)| of an edge in the middle of its window, px of the edge per share of the contrast and px.
fn shift(table: &Table, flat: usize) -> f64 {
    let phase = table.phase(0.0);
    let middle = half(table.width) as f64;
    let distance = (table.width - 1) as f64 - 0.5 * (flat as f64 + 1.0) - middle;
    let terms = phase.weights.iter().zip(phase.values).enumerate();
    terms.map(|(k, (w, e))| f64::from(w * e) * (k as f64 - middle - distance)).sum::<f64>().abs()
}

#[cfg(test)]
mod tests {
    use super::super::esf::EdgeShape;
    use super::super::model::EdgeSample;
    use super::super::table::{FINE, window_width};
    use super::*;

    /// An edge under light that grows outwards, placed by a table that takes the level at the flat end for the light's.
    #[test]
    fn the_shift_is_that_of_an_edge_under_a_gradient() {
        let (shape, gradient) = (EdgeShape::Gaussian, 0.004);
        for (sigma, kappa) in [(0.7, 0.0), (1.0, 1.5), (2.0, 0.8)] {
            let width = window_width(&shape, sigma);
            let table = Table::new(&shape, sigma, kappa, width, false, FINE);
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
}
