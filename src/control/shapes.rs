//! Shape functions along z that a fit or a modal controller uses.
//!
//! Polynomials are carried as Legendre polynomials of ξ = 2(z − z₁)/(z_n − z₁) − 1, which keeps the normal matrix
//! well conditioned; the space they span is that of the plain powers.

use super::{ControlError, Shapes};
use nalgebra::DMatrix;

impl Shapes {
    /// Number of shape functions.
    pub fn count(self) -> usize {
        match self {
            Self::Line => 2,
            Self::Quadratic => 3,
            Self::Polynomial { degree } => degree + 1,
        }
    }

    /// Shape functions at the stations: one row a station, one column a shape.
    ///
    /// # Errors
    /// [`ControlError::TooFewStations`] where there are fewer stations than shapes.
    pub fn design(self, station_z_mm: &[f64]) -> Result<DMatrix<f64>, ControlError> {
        let (stations, shapes) = (station_z_mm.len(), self.count());
        if stations < shapes {
            return Err(ControlError::TooFewStations { stations, shapes });
        }
        let first = station_z_mm.first().copied().unwrap_or(0.0);
        let span = station_z_mm.last().copied().unwrap_or(0.0) - first;
        let xi = |z: f64| if span > 0.0 { 2.0 * (z - first) / span - 1.0 } else { 0.0 };
        Ok(DMatrix::from_fn(stations, shapes, |row, column| legendre(column, xi(station_z_mm[row]))))
    }
}

/// Legendre polynomial P_n(ξ) by Bonnet's recurrence (DLMF 18.9.1).
pub(crate) fn legendre(n: usize, xi: f64) -> f64 {
    let (mut previous, mut current) = (1.0, xi);
    if n == 0 {
        return previous;
    }
    for k in 1..n {
        let k = k as f64;
        (previous, current) = (current, ((2.0 * k + 1.0) * xi * current - k * previous) / (k + 1.0));
    }
    current
}
