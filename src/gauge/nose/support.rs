//! The support of the nose's hull from its sectors, with its covariance.
//!
//! The sectors' departures from the nominal radius are smoothed by penalised least squares (second
//! differences; E. T. Whittaker, Proc. Edinburgh Math. Soc. 41 (1923) 63), the weight of the
//! penalty by generalised cross-validation (P. Craven, G. Wahba, Numer. Math. 31 (1979) 377). A
//! hull over noise reaches too far, and smoothing takes off corners: draws of the sectors' noise
//! about the smooth contour, smoothed again, give the bias, which is taken off. What is taken off
//! for smoothing depends on the measured contour: with H the smoother, the noise of the result is
//! that of 2H − H² (twicing; J. W. Tukey, Exploratory Data Analysis (1977)), larger than that of H,
//! and the covariance is of draws by it.

use glam::DVec2;
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng as _;
use rand_distr::{Distribution as _, StandardNormal};

use super::hidden_corner::{Corners, Hidden};
use super::hull::Hull;
use super::limits::NoseLimits;
use super::line::product;
use super::path::Path;
use super::result::{NoseSector, SupportValue};
use super::smoother::smoother;
use crate::gauge::ring::edge_fit::SHARED;

/// Noise of a sector's radius, px: its own, and what all calipers share.
#[derive(Clone, Copy, Debug)]
pub(super) struct SectorNoise {
    /// Its own standard uncertainty.
    pub(super) own: f64,
    /// What it shares.
    pub(super) shared: [f64; SHARED],
}

/// Support values and their covariance, px and px².
pub(super) struct Support {
    /// Values in even steps from one edge's normal to the other's.
    pub(super) values: Vec<SupportValue>,
    /// Their covariance.
    pub(super) covariance: DMatrix<f64>,
    /// Largest uncertainty by a corner that sectors hide, px.
    pub(super) u_corner_px: f64,
}

/// The support about the path's centre, of edges blurred by `blur_px` (lens and pixel).
pub(super) fn support(
    path: &Path,
    sectors: &[NoseSector],
    noise: &[SectorNoise],
    blur_px: f64,
) -> Option<Support> {
    let limits = NoseLimits::get();
    let departures =
        DVector::from_iterator(sectors.len(), sectors.iter().map(|s| s.radius_px - path.nominal_px));
    let weights = DVector::from_iterator(sectors.len(), sectors.iter().map(|s| s.u_px.powi(-2)));
    let hat = smoother(&departures, &weights)?;
    let smooth = &hat * &departures;
    let hull = Hull::new(path);
    let plain = hull.values(&smooth);
    let twiced = &hat * 2.0 - &hat * &hat;
    let mut random = rand_pcg::Pcg64::seed_from_u64(0);
    let (m, draws) = (plain.len(), limits.draws);
    let (mut sum, mut twiced_sum) = (DVector::zeros(m), DVector::zeros(m));
    let mut products = DMatrix::zeros(m, m);
    for _ in 0..draws {
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        let common: [f64; SHARED] = std::array::from_fn(|_| draw());
        let drawn = noise.iter().map(|n| n.own * draw() + product(&n.shared, &common));
        let drawn = DVector::from_iterator(noise.len(), drawn.collect::<Vec<f64>>());
        sum += hull.values(&(&hat * (&smooth + &drawn))) - &plain;
        let off = hull.values(&(&smooth + &twiced * drawn)) - &plain;
        products.ger(1.0, &off, &off, 1.0);
        twiced_sum += off;
    }
    let (bias, mean) = (sum / draws as f64, twiced_sum / draws as f64);
    // of what is taken off for bias half stays uncertain: it is that of the smooth contour
    let mut covariance = products / draws as f64 - &mean * mean.transpose() + &bias * bias.transpose() * 0.25;
    add_edges(path, &hull, &mut covariance);
    let step_px = path.nominal_px * path.step_rad();
    let own: Vec<f64> = noise.iter().map(|n| n.own).collect();
    let corners = Corners::new(&departures, &own, blur_px / step_px);
    let hidden: Vec<Hidden> = hull.touching(&departures).into_iter().map(|k| corners.at(k)).collect();
    hidden.iter().enumerate().for_each(|(i, hidden)| covariance[(i, i)] += hidden.u_px.powi(2));
    let values = (0..m).map(|i| SupportValue {
        direction_deg: hull.direction_rad(i).to_degrees(),
        h_px: plain[i] - bias[i] + hidden[i].by_px,
        u_px: covariance[(i, i)].max(0.0).sqrt(),
    });
    let values: Vec<SupportValue> = values.collect();
    let symmetric = (&covariance + covariance.transpose()) * 0.5;
    let u_corner_px = hidden.iter().map(|hidden| hidden.u_px).fold(0.0, f64::max);
    Some(Support { values, covariance: symmetric, u_corner_px })
}

/// How far each sector stands below the hull of all, px: the least distance to a tangent of it.
pub(super) fn below_hull(path: &Path, departures: &DVector<f64>) -> Vec<f64> {
    let hull = Hull::new(path);
    let values = hull.values(departures);
    let gap = |k: usize| {
        let p = DVec2::from_angle(path.direction_rad(k)) * (path.nominal_px + departures[k]);
        let to = |i: usize| values[i] - p.dot(DVec2::from_angle(hull.direction_rad(i)));
        (0..hull.count()).map(to).fold(f64::INFINITY, f64::min)
    };
    (0..departures.len()).map(gap).collect()
}

/// The edges' own uncertainty at the ends of the nose, where their tangents are the hull's.
fn add_edges(path: &Path, hull: &Hull, covariance: &mut DMatrix<f64>) {
    let last = hull.count() - 1;
    for (i, line) in [(0, &path.lines[0]), (last, &path.lines[1])] {
        covariance[(i, i)] += line.u_at(path.centre + line.normal * path.nominal_px).0.powi(2);
    }
}
