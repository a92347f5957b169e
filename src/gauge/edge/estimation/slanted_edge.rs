//! The edge-spread function estimated from the frame itself, as with a slanted edge (after ISO
//! 12233).
//!
//! An edge that is not parallel to the rows passes through all sub-pixel phases along the shaft. A
//! smooth curve through the positions of many columns has smaller phase errors than any one of
//! them; the grey values of all columns over their distance from that curve sample the
//! pixel-integrated edge E(u) many times a pixel. E minus the Gaussian fitted before is a cubic
//! spline, by least squares.
//!
//! Positions of single columns would not do: a grey value at distance u always stems from the same
//! phase, so that an error b(phase) of the positions and a shape E(u + b) cannot be separated. The
//! curve separates them; it needs an edge that travels at least
//! [`SlantedEdgeLimits::least_travel_px`] pixels over the frame, and leaves the zero of the
//! distance open.

use super::blur::BlurLimits;
use super::levels::LevelCurve;
use crate::gauge::edge::image::scan_windows::Windows;
use crate::gauge::edge::image::window_layout::half;
use crate::gauge::edge::model::edge_spread::{Knot, TabulatedEsf};
use crate::gauge::edge::model::gaussian::{EdgeSample, edge_samples};
use crate::gauge::edges::Edge;
use crate::gauge::limit::limits;
use crate::numerics::distributions::{phi_cdf, phi_pdf};
use crate::numerics::robust::{MEDIAN_TO_SD, upper_median};
use crate::numerics::smoothing_spline::{Spline, SplineFit};

limits! {
    /// What an edge must show before its shape is estimated, and how finely it is.
    SlantedEdgeLimits = "slanted_edge";
    /// Rows that an edge must travel over the frame: less than one leaves phases unseen; the half
    /// row beyond shows half of the phases at two places, which separates the curve from the shape.
    least_travel_px: f64 = 1.5;
    /// Fewest columns of a side: they put 32 pixels between two knots a quarter of a pixel apart,
    /// so that the shape is known to 1/√32 = 18 % of the noise of one pixel there.
    least_columns: usize = 128;
    /// Distance of the spline's knots, px: a quarter of the finest detail that a pixel's area lets
    /// through (its transfer function is 0 at one period per px).
    knot_px: f64 = 0.25;
    /// Rows travelled over a segment of the smooth curve: two whole turns of the phase, over which
    /// errors b(phase) of the positions average out.
    travel_per_segment_px: f64 = 2.0;
    /// Most segments of the smooth curve. Tuned: see study limits.
    most_segments: usize = 16;
    /// Weight of a second difference of the spline's coefficients, in units of a knot's mean
    /// weight: settles coefficients without data and takes (2 − 2 cos(π/2))²·1e-5 = 4e-5 of the
    /// finest detail.
    smoothing: f64 = 1e-5;
    /// Knots of the table per pixel: the cubic through I and F errs by h⁴/384·max|F‴| < 2e-7 at the
    /// least blur of 0.2 px.
    table_per_px: f64 = 32.0;
}

/// Rows that an edge must travel over the frame for its shape to be estimated.
#[must_use]
pub(crate) fn least_travel_px() -> f64 {
    SlantedEdgeLimits::get().least_travel_px
}

/// What a side has of its frame.
pub(crate) struct EsfSamples<'a> {
    pub(crate) windows: &'a Windows,
    pub(crate) dark: &'a LevelCurve,
    pub(crate) light: &'a LevelCurve,
    pub(crate) slope: &'a [f32],
    /// Blur of the Gaussian fitted before, px.
    pub(crate) sigma: f64,
}

/// Learns the edge of a side from its columns' places in `line`; `None` where the edge travels too
/// little or too few columns have one.
pub(crate) fn learn(samples_of: &EsfSamples<'_>, line: &[Edge]) -> Option<TabulatedEsf> {
    let sign = f64::from(samples_of.windows.side.sign());
    let steepest = BlurLimits::get().steepest as f32;
    let able = |c: usize| line[c].is_usable() && samples_of.slope[c].abs() < steepest;
    let places: Vec<(usize, f64)> =
        (0..line.len()).filter(|c| able(*c)).map(|c| (c, sign * line[c].row_px)).collect();
    if places.len() < SlantedEdgeLimits::get().least_columns {
        return None;
    }
    let curve = smooth_curve(&places)?;
    let reach = half(samples_of.windows.width) as f64 - 1.0;
    let deviation = deviation(samples_of, &places, &curve, reach)?;
    Some(tabulate(&deviation, samples_of.sigma, reach))
}

/// The smooth curve through the places, outliers left out.
fn smooth_curve(places: &[(usize, f64)]) -> Option<Spline> {
    let limits = SlantedEdgeLimits::get();
    let blocks = places.chunks(places.len().div_ceil(32));
    let middles: Vec<f64> = blocks.map(|b| b.iter().map(|p| p.1).sum::<f64>() / b.len() as f64).collect();
    let travel: f64 = middles.windows(2).map(|w| (w[1] - w[0]).abs()).sum();
    if travel < limits.least_travel_px {
        return None;
    }
    let segments = ((travel / limits.travel_per_segment_px) as usize).clamp(1, limits.most_segments);
    let (from, to) = (places[0].0 as f64, places[places.len() - 1].0 as f64);
    let mut limit = f64::INFINITY;
    let mut curve: Option<Spline> = None;
    for _ in 0..3 {
        let mut fit = SplineFit::new(from, to, segments);
        let away = |c: usize, p: f64| curve.as_ref().map_or(0.0, |s| (p - s.at(c as f64).0).abs());
        for (c, p) in places.iter().filter(|(c, p)| away(*c, *p) <= limit) {
            fit.add(*c as f64, *p);
        }
        let next = fit.solve(limits.smoothing, false)?;
        let mut sizes: Vec<f64> = places.iter().map(|(c, p)| (p - next.at(*c as f64).0).abs()).collect();
        limit = (4.0 * MEDIAN_TO_SD * upper_median(&mut sizes, f64::total_cmp)?).max(1e-6);
        curve = Some(next);
    }
    curve
}

/// The pixel-integrated edge minus the Gaussian one over the distance from the curve.
fn deviation(
    samples_of: &EsfSamples<'_>,
    places: &[(usize, f64)],
    curve: &Spline,
    reach: f64,
) -> Option<Spline> {
    let SlantedEdgeLimits { knot_px, smoothing, .. } = *SlantedEdgeLimits::get();
    let windows = samples_of.windows;
    let segments = (2.0 * reach / knot_px).ceil() as usize;
    let mut fit = SplineFit::new(-reach, reach, segments);
    let mut samples = vec![EdgeSample::default(); windows.width - 1];
    let sign = windows.side.sign();
    for (column, _) in places {
        let Ok(centre) = windows.centre[*column] else { continue };
        let x0 = curve.at(*column as f64).0 - f64::from(sign * centre);
        let first = -(half(windows.width) as f64);
        edge_samples(first, x0, samples_of.sigma, &mut samples);
        let dark = f64::from(samples_of.dark.level[*column]);
        let contrast = f64::from(samples_of.light.level[*column]) - dark;
        for (k, (m, sample)) in windows.of(*column).iter().zip(&samples).enumerate() {
            let n = (f64::from(*m) - dark) / contrast;
            fit.add(first + k as f64 - x0, n - sample.value);
        }
    }
    let seen = fit.counts.iter().skip(8).rev().skip(8).all(|count| *count >= 4);
    if seen { fit.solve(smoothing, true) } else { None }
}

/// F and its integral from E by telescoping: I(v) = Σ E(v − 1/2 − j), F(v) = Σ E′(v − 1/2 − j) over
/// j ≥ 0.
fn tabulate(deviation: &Spline, sigma: f64, reach: f64) -> TabulatedEsf {
    let table_per_px = SlantedEdgeLimits::get().table_per_px;
    let far = reach.ceil() + 4.0;
    let count = (2.0 * far * table_per_px) as usize;
    let mut knots = Vec::with_capacity(count + 1);
    for k in 0..=count {
        let v = -far + k as f64 / table_per_px;
        let (mut i, mut f) = (v * phi_cdf(v / sigma) + sigma * phi_pdf(v / sigma), phi_cdf(v / sigma));
        let mut at = v - 0.5;
        while at >= -reach {
            let (s, slope) = deviation.at(at);
            (i, f) = (i + s, f + slope);
            at -= 1.0;
        }
        knots.push(Knot { integral: i, value: f });
    }
    let area: f64 = deviation.coefficients.iter().sum::<f64>() * deviation.step;
    let far_from_ends = (0..deviation.coefficients.len())
        .map(|k| -reach + k as f64 * deviation.step)
        .filter(|u| deviation.at(*u).0.abs() > 2e-3)
        .fold(0.0, |far: f64, u| far.max(u.abs()));
    TabulatedEsf::learnt(far, knots, sigma, -area, far_from_ends)
}
