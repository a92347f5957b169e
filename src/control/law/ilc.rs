//! Iterative learning: o(k+1) = Q [o(k) + L e(k)], Q a zero-phase low-pass along z.
//!
//! Q = (I + μ DᵀD)⁻¹, D the second difference: the smoother of Whittaker (Proc. Edinb. Math. Soc.
//! 41 (1923) 63). It is symmetric with eigenvalues in (0, 1], passes constants and lines unchanged
//! (no end effects), and attenuates a wave of N stations by the factor 1/(1 + μ (2 − 2 cos 2π/N)²).
//! Where Q < 1 the loop does not reach zero error: an error with constant disturbance d settles at
//! (1 − Q) d instead of 0. Convergence: D. A. Bristow, M. Tharayil, A. G. Alleyne, IEEE Control
//! Syst. Mag. 26(3) (2006) 96.

use super::proposal::{Law, Observation, Proposal};
use crate::control::settings::IlcSettings;
use crate::plan::StationLayout;
use nalgebra::{DMatrix, DVector};

/// Iterative-learning law.
#[derive(Clone, Debug)]
pub(crate) struct IlcLaw {
    learning_gain: f64,
    q: Option<DMatrix<f64>>,
}

impl IlcLaw {
    pub(crate) fn new(settings: &IlcSettings, stations: &StationLayout) -> Self {
        Self { learning_gain: settings.learning_gain, q: q_of_sections(settings.q_cutoff_mm, stations) }
    }
}

impl Law for IlcLaw {
    fn begin(&mut self, _stock_mm: Option<Vec<f64>>) {}

    fn propose(&mut self, seen: &Observation<'_>) -> Proposal {
        let pairs = seen.in_force().iter().zip(&seen.errors.stations);
        let learnt: Vec<f64> = pairs.map(|(o, s)| o + self.learning_gain * s.e_mm).collect();
        match &self.q {
            None => learnt.into(),
            Some(q) => (q * DVector::from_vec(learnt)).iter().copied().collect::<Vec<_>>().into(),
        }
    }
}

/// Q of every section apart: nothing is smoothed across a shoulder.
fn q_of_sections(cutoff_mm: f64, stations: &StationLayout) -> Option<DMatrix<f64>> {
    let (z, ranges) = (&stations.z_mm, stations.sections());
    if ranges.len() < 2 {
        return q_filter(cutoff_mm, z);
    }
    let mut whole = DMatrix::identity(z.len(), z.len());
    for range in ranges {
        if let Some(own) = q_filter(cutoff_mm, &z[range.clone()]) {
            whole.view_mut((range.start, range.start), own.shape()).copy_from(&own);
        }
    }
    Some(whole)
}

/// Q; the curvature of stations of uneven pitch is that of the parabola through three of them.
/// `None` where nothing is filtered (cutoff 0 or below two stations, fewer than three).
pub(crate) fn q_filter(cutoff_mm: f64, station_z_mm: &[f64]) -> Option<DMatrix<f64>> {
    let n = station_z_mm.len();
    let span = station_z_mm.last()? - station_z_mm.first()?;
    let per_wave = cutoff_mm * (n as f64 - 1.0) / span;
    if n < 3 || !(per_wave.is_finite() && per_wave > 2.0) {
        return None;
    }
    let mu = (2.0 - 2.0 * (std::f64::consts::TAU / per_wave).cos()).powi(-2);
    let second = DMatrix::from_fn(n - 2, n, |row, column| {
        let weights = curvature(&station_z_mm[row..row + 3], span / (n as f64 - 1.0));
        weights.get(column.wrapping_sub(row)).copied().unwrap_or(0.0)
    });
    let system = DMatrix::identity(n, n) + second.transpose() * second * mu;
    system.cholesky().map(|c| c.inverse())
}

/// Relative deviation of a pitch from the mean one that is rounding of the stations' decimals.
const EVEN: f64 = 1e-9;

/// Weights of three stations in the second derivative of the parabola through them, times the
/// square of the mean pitch.
fn curvature(z: &[f64], pitch: f64) -> [f64; 3] {
    let (before, after) = ((z[1] - z[0]) / pitch, (z[2] - z[1]) / pitch);
    if (before - 1.0).abs() < EVEN && (after - 1.0).abs() < EVEN {
        return [1.0, -2.0, 1.0];
    }
    let scale = 2.0 / (before + after);
    [scale / before, -scale * (1.0 / before + 1.0 / after), scale / after]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stations at arbitrary places: a straight line passes, a zigzag does not, and even pitch is
    /// the limit of uneven.
    #[test]
    fn stations_of_uneven_pitch_are_filtered_alike() {
        let z = [6.0, 40.0, 80.0, 95.0, 160.0, 200.0];
        let q = q_filter(300.0, &z).expect("a filter");
        let line = DVector::from_iterator(6, z.iter().map(|z| 0.3 - 0.01 * z));
        assert!((&q * &line - &line).amax() < 1e-9);
        let zigzag = DVector::from_fn(6, |i, _| if i % 2 == 0 { 1.0 } else { -1.0 });
        assert!((&q * &zigzag).amax() < 0.5, "{}", &q * &zigzag);
        let even: Vec<f64> = (0..6).map(|i| 40.0 * f64::from(i)).collect();
        let nearly: Vec<f64> = (0..6).map(|i| 40.0 * f64::from(i) + 1e-5 * f64::from(i % 2)).collect();
        let apart = (q_filter(300.0, &even).unwrap() - q_filter(300.0, &nearly).unwrap()).amax();
        assert!(apart < 1e-5, "{apart}");
        // the parabola z²: its second derivative is 2 everywhere
        let square: f64 =
            curvature(&[1.0, 3.0, 4.0], 1.0).iter().zip([1.0, 9.0, 16.0]).map(|(w, y)| w * y).sum();
        assert!((square - 2.0).abs() < 1e-12);
    }
}
