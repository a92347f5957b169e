//! Iterative learning: o(k+1) = Q [o(k) + L e(k)], Q a zero-phase low-pass along z.
//!
//! Q = (I + μ DᵀD)⁻¹, D the second difference: the smoother of Whittaker (Proc. Edinb. Math. Soc. 41 (1923) 63). It is
//! symmetric with eigenvalues in (0, 1], passes constants and lines unchanged (no end effects), and a wave of N
//! stations by 1/(1 + μ (2 − 2 cos 2π/N)²). Where Q < 1 the loop forgets instead of learning: an error with
//! constant disturbance d settles at (1 − Q) d instead of 0. Convergence: D. A. Bristow, M. Tharayil, A. G. Alleyne,
//! IEEE Control Syst. Mag. 26(3) (2006) 96.

use super::{Law, Proposal, Seen};
use crate::control::IlcSettings;
use nalgebra::{DMatrix, DVector};

/// Iterative-learning law.
#[derive(Clone, Debug)]
pub(crate) struct IlcLaw {
    learning_gain: f64,
    q: Option<DMatrix<f64>>,
}

impl IlcLaw {
    pub(crate) fn new(settings: &IlcSettings, station_z_mm: &[f64]) -> Self {
        Self { learning_gain: settings.learning_gain, q: q_filter(settings.q_cutoff_mm, station_z_mm) }
    }
}

impl Law for IlcLaw {
    fn begin(&mut self, _stock_mm: Option<Vec<f64>>) {}

    fn propose(&mut self, seen: &Seen<'_>) -> Proposal {
        let learnt = seen.in_force().iter().zip(&seen.errors.e_mm).map(|(o, e)| o + self.learning_gain * e);
        let learnt: Vec<f64> = learnt.collect();
        match &self.q {
            None => learnt.into(),
            Some(q) => (q * DVector::from_vec(learnt)).iter().copied().collect::<Vec<_>>().into(),
        }
    }
}

/// Q for stations of even pitch; `None` where nothing is filtered (cutoff 0 or below two stations, fewer than three).
pub(crate) fn q_filter(cutoff_mm: f64, station_z_mm: &[f64]) -> Option<DMatrix<f64>> {
    let n = station_z_mm.len();
    let span = station_z_mm.last()? - station_z_mm.first()?;
    let per_wave = cutoff_mm * (n as f64 - 1.0) / span;
    if n < 3 || !(per_wave.is_finite() && per_wave > 2.0) {
        return None;
    }
    let mu = (2.0 - 2.0 * (std::f64::consts::TAU / per_wave).cos()).powi(-2);
    let second = DMatrix::from_fn(n - 2, n, |row, column| match column.wrapping_sub(row) {
        0 | 2 => 1.0,
        1 => -2.0,
        _ => 0.0,
    });
    let system = DMatrix::identity(n, n) + second.transpose() * second * mu;
    system.cholesky().map(|c| c.inverse())
}
