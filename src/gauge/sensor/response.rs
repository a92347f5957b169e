//! A sensor's response that is not linear, from flat fields at two exposures or more (EMVA 1288,
//! release 4.0, section 6: mean over exposure), and its inverse.
//!
//! ```text
//! y    = (m − black)/reference               signal of a grey value m, 1 at the reference
//! L(y) = y^p · exp(c·(y − 1))                light, 1 at the reference; p a gamma, c a knee
//! ln e = p·ln y + c·(y − 1) + a              for every exposure e at every place of light exp(−a)
//! ```
//!
//! least squares over the medians of tiles, each tile's own light subtracted, so that an
//! illumination gradient is worth as much as
//! exposures that differ; c needs three exposures. L grows as long as p > 0 and p + c > 0.

use nalgebra::{Matrix2, Vector2};
use serde::{Deserialize, Serialize};

use super::photon_transfer::PhotonTransferLimits;
use crate::frame::{Buffer, Frame, FrameView};
use crate::gauge::limit::limits;
use crate::numerics::robust::median_of;

limits! {
    /// When a sensor's response is not linear.
    ResponseLimits = "response";
    /// Departure from a line, as a share of the reference, up to which a response is linear:
    /// cameras state 1 % and less (EMVA 1288 LE), and a lamp that drifts by 1 % between two
    /// exposures a factor of 1.5 apart feigns 0.9 %.
    linear: f64 = 0.01;
    /// Least ratio of the largest to the smallest exposure in use: see `linear`.
    least_ratio: f64 = 1.5;
    /// Least signal of a tile in use, of the brightest: below, the dark level's own error counts.
    /// An error of a thousandth of the brightest is 2 % of it.
    least_signal: f64 = 0.05;
    /// Median signal of an exposure in use, of full scale: above it half of the pixels are clipped,
    /// or nearly, with a scatter of 1 to 3 %.
    most_signal: f64 = 0.97;
    /// Residual of ln e, rms, beyond which the curve does not describe these exposures: three times
    /// the 1 % that lamp and shutter are good to.
    most_residual: f64 = 0.03;
    /// Tiles along either side: the median of each keeps dust and defects out, and light that falls
    /// off shows as 64 levels.
    tiles: usize = 8;
}

/// The inverse of a response that is not linear.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Response {
    /// Exponent p of the light over the signal.
    pub exponent: f64,
    /// Curvature c of the logarithm.
    pub curvature: f64,
    /// Grey value without light, counts.
    pub black_counts: f64,
    /// Signal above black at which light and signal are both 1, counts.
    pub reference_counts: f64,
    /// Largest departure of the response from a line, as a share of the reference.
    pub departure: f64,
    /// Residual of the exposures' logarithms, rms.
    pub residual: f64,
}

/// Flat fields whose signals are none of their exposures'.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the signals of the flat fields depart from a line by {:.1} % and follow no smooth curve of their exposures (exponent {exponent:.2}, {:.1} % left): \
     check the exposures stated, and that the lamp was steady", 1e2 * departure, 1e2 * residual
)]
pub(crate) struct NoResponse {
    /// Exponent found.
    pub exponent: f64,
    /// Largest departure from a line.
    pub departure: f64,
    /// Residual.
    pub residual: f64,
}

/// One exposure's signals, tile by tile.
struct Exposure {
    exposure: f64,
    signals: Vec<f64>,
}

/// The response of flat fields at several exposures (any unit in proportion to the light) above
/// dark frames. `None` where it is linear, or where the exposures do not show it: fewer than two,
/// or too close together.
///
/// # Errors
/// Where signals are neither in proportion to the exposures nor on a curve of them.
pub(crate) fn response(
    dark: &[FrameView<'_>],
    flats: &[(f64, Vec<FrameView<'_>>)],
) -> Result<Option<Response>, NoResponse> {
    let limits = ResponseLimits::get();
    let photon_transfer_limits = PhotonTransferLimits::get();
    let Some(first) = dark.first() else { return Ok(None) };
    let black = median_of(tiles(dark));
    let full = first.full_scale().map_or(f64::INFINITY, f64::from);
    let mut exposures: Vec<Exposure> = flats
        .iter()
        .filter(|(exposure, frames)| *exposure > 0.0 && same_size(first, frames))
        .map(|(exposure, frames)| {
            let signals = tiles(frames).into_iter().map(|m| m - black).collect();
            Exposure { exposure: *exposure, signals }
        })
        .collect();
    exposures.retain(|e| median_of(e.signals.clone()) + black < limits.most_signal * full);
    exposures.sort_by(|a, b| a.exposure.total_cmp(&b.exposure));
    let different = 1 + exposures
        .windows(2)
        .filter(|p| p[1].exposure > p[0].exposure * (1.0 + photon_transfer_limits.same_exposure))
        .count();
    let (Some(least), Some(most)) = (exposures.first(), exposures.last()) else { return Ok(None) };
    if different < 2 || most.exposure < limits.least_ratio * least.exposure {
        return Ok(None);
    }
    let brightest = exposures.iter().flat_map(|e| &e.signals).copied().fold(0.0, f64::max);
    let reference = if full.is_finite() { full - black } else { brightest };
    if !(brightest > 0.0 && reference > 0.0) {
        return Ok(None);
    }
    Ok(fitted(&exposures, (black, reference, brightest), different > 2)?
        .filter(|r| r.departure > limits.linear))
}

fn same_size(first: &FrameView<'_>, frames: &[FrameView<'_>]) -> bool {
    frames.iter().all(|f| (f.rows(), f.columns()) == (first.rows(), first.columns()))
}

/// Least squares for p, and for c where three exposures show it.
fn fitted(
    exposures: &[Exposure],
    (black, reference, brightest): (f64, f64, f64),
    curved: bool,
) -> Result<Option<Response>, NoResponse> {
    let limits = ResponseLimits::get();
    let points = centred(exposures, reference, limits.least_signal * brightest);
    let sum = |f: &dyn Fn(&[f64; 3]) -> f64| points.iter().map(f).sum::<f64>();
    let (xx, xy, yy) = (sum(&|p| p[0] * p[0]), sum(&|p| p[0] * p[1]), sum(&|p| p[1] * p[1]));
    let (xe, ye) = (sum(&|p| p[0] * p[2]), sum(&|p| p[1] * p[2]));
    if !(xx > 0.0) {
        return Ok(None);
    }
    let straight = Vector2::new(xe / xx, 0.0);
    let both = Matrix2::new(xx, xy, xy, yy).try_inverse().map(|inverse| inverse * Vector2::new(xe, ye));
    let found = both.filter(|_| curved).unwrap_or(straight);
    let (exponent, curvature) = (found[0], found[1]);
    let rest = sum(&|p| (p[2] - exponent * p[0] - curvature * p[1]).powi(2));
    let residual = (rest / points.len() as f64).sqrt();
    let mut response = Response {
        exponent,
        curvature,
        black_counts: black,
        reference_counts: reference,
        departure: 0.0,
        residual,
    };
    let off = |i: u32| (response.light(f64::from(i) / 64.0) - f64::from(i) / 64.0).abs();
    response.departure = (0..=64).map(off).fold(0.0, f64::max);
    let refused = response.departure > limits.linear
        && (residual > limits.most_residual || response.impossible().is_some());
    if refused {
        return Err(NoResponse { exponent, departure: response.departure, residual });
    }
    Ok(Some(response))
}

/// ln y, y and ln e of every tile bright enough, less their means over the tile's exposures.
fn centred(exposures: &[Exposure], reference: f64, least: f64) -> Vec<[f64; 3]> {
    let tiles = exposures.first().map_or(0, |e| e.signals.len());
    let mut points = Vec::new();
    for tile in 0..tiles {
        let bright = exposures.iter().filter(|e| e.signals[tile] >= least);
        let own: Vec<[f64; 3]> = bright
            .map(|e| {
                let y = e.signals[tile] / reference;
                [y.ln(), y, e.exposure.ln()]
            })
            .collect();
        let mean: [f64; 3] =
            std::array::from_fn(|k| own.iter().map(|p| p[k]).sum::<f64>() / own.len().max(1) as f64);
        points.extend(own.iter().map(|p| std::array::from_fn::<f64, 3, _>(|k| p[k] - mean[k])));
    }
    points
}

/// Medians of the mean frame's tiles: dust and defects stay out.
fn tiles(frames: &[FrameView<'_>]) -> Vec<f64> {
    let limits = ResponseLimits::get();
    let Some(first) = frames.first() else { return Vec::new() };
    let (rows, columns) = (first.rows(), first.columns());
    let span = |n: usize, i: usize| {
        (i * n / limits.tiles)..((i + 1) * n / limits.tiles).max(i * n / limits.tiles + 1).min(n)
    };
    let mut medians = Vec::new();
    for (i, j) in (0..limits.tiles * limits.tiles).map(|t| (t / limits.tiles, t % limits.tiles)) {
        let pixels = span(rows, i).flat_map(|r| span(columns, j).map(move |c| (r, c)));
        let mean = |(r, c)| {
            frames.iter().filter_map(|f| f.get(r, c)).map(f64::from).sum::<f64>() / frames.len() as f64
        };
        let values: Vec<f64> = pixels.map(mean).collect();
        if !values.is_empty() {
            medians.push(median_of(values));
        }
    }
    medians
}

impl Response {
    /// Light of a signal, both 1 at the reference; below black it falls as it grows above.
    fn light(&self, signal: f64) -> f64 {
        let size = signal.abs();
        (size.powf(self.exponent) * (self.curvature * (size - 1.0)).exp()).copysign(signal)
    }

    /// The frame in proportion to the light; black and the reference stay where they were, clipped
    /// pixels clipped.
    #[must_use]
    pub(crate) fn linearised(&self, frame: Frame) -> Frame {
        let view = frame.view();
        let (rows, columns, full) = (view.rows(), view.columns(), view.full_scale());
        let meta = frame.meta.clone();
        let one = |grey: f32| match full {
            Some(full) if grey >= full => full,
            _ => {
                let signal = (f64::from(grey) - self.black_counts) / self.reference_counts;
                (self.black_counts + self.reference_counts * self.light(signal)) as f32
            }
        };
        let table = |most: u16| -> Vec<f32> { (0..=most).map(|v| one(f32::from(v))).collect() };
        let values = match frame.into_buffer() {
            Buffer::U8(values) => {
                let table = table(255);
                values.into_iter().map(|v| table[usize::from(v)]).collect()
            }
            Buffer::U16(values) => {
                let table = table(values.iter().copied().max().unwrap_or(0));
                values.into_iter().map(|v| table[usize::from(v)]).collect()
            }
            Buffer::F32(values) => values.into_iter().map(one).collect(),
        };
        Frame::linear(values, rows, columns, full, meta)
    }

    /// Names what no response is: (key, value, what would be right).
    pub(crate) fn impossible(&self) -> Option<(&'static str, f64, &'static str)> {
        let finite = self.black_counts.is_finite() && self.curvature.is_finite();
        if !(0.1..=10.0).contains(&self.exponent) {
            return Some(("bench.flat_field.response.exponent", self.exponent, "0.1 to 10"));
        }
        if !finite || self.exponent + self.curvature <= 0.0 {
            let right = "a finite number above minus the exponent, so that light grows with the signal";
            return Some(("bench.flat_field.response.curvature", self.curvature, right));
        }
        let reference = self.reference_counts;
        let positive = reference > 0.0 && reference.is_finite();
        (!positive).then_some(("bench.flat_field.response.reference_counts", reference, "counts above 0"))
    }
}

#[cfg(test)]
mod tests;
