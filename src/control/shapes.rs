//! Shape functions along z that a fit or a modal controller uses.
//!
//! Polynomials are represented by Legendre polynomials of ξ = 2(z − z₁)/(z_n − z₁) − 1, which keeps
//! the normal matrix well conditioned; the space they span is that of the plain powers.

use super::error::ControlError;
use crate::plan::StationLayout;
use crate::setting::{SettingError, require};
use nalgebra::{DMatrix, DVector};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Shape functions along z.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Shapes {
    /// Paper 000, eq. 4: ε = b·x + a.
    #[default]
    Line,
    /// Parabola.
    Quadratic,
    /// Polynomial of this degree, 0-8.
    Polynomial {
        /// Highest power.
        degree: usize,
    },
    /// Shapes that a turned shaft is known to take, each with an amplitude of its own.
    Physical(PhysicalShapes),
}

/// Which physical shapes are fitted; a constant always is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PhysicalShapes {
    /// Taper ξ: guideway or tailstock out of line, wear along the cut. −1 at the first station, 1
    /// at the last.
    pub taper: bool,
    /// Barrel 1 − ξ²: deflection between two alike supports, a bent guideway. 1 in the middle, 0 at
    /// the ends.
    pub barrel: bool,
    /// Deflection of a shaft clamped in the chuck (z = 0) and supported by a rigid tailstock (z =
    /// `length_mm`) under a load that travels with the tool, z³(L − z)²(4L − z), scaled to 1 at its
    /// largest.
    pub deflection: bool,
    /// Chuck face to tailstock, mm.
    pub length_mm: f64,
}

impl Default for PhysicalShapes {
    fn default() -> Self {
        Self { taper: true, barrel: false, deflection: true, length_mm: 500.0 }
    }
}

impl Shapes {
    /// Number of shape functions.
    pub(crate) fn count(self) -> usize {
        match self {
            Self::Line => 2,
            Self::Quadratic => 3,
            Self::Polynomial { degree } => degree + 1,
            Self::Physical(p) => 1 + usize::from(p.taper) + usize::from(p.barrel) + usize::from(p.deflection),
        }
    }

    /// Names of the shapes, in the order of the design's columns.
    pub(crate) fn names(self) -> Vec<String> {
        let Self::Physical(p) = self else {
            return (0..self.count()).map(|degree| format!("P{degree}")).collect();
        };
        let all =
            [("constant", true), ("taper", p.taper), ("barrel", p.barrel), ("deflection", p.deflection)];
        all.iter().filter(|(_, used)| *used).map(|(name, _)| (*name).to_owned()).collect()
    }

    /// Description of the shapes for reports.
    pub(crate) fn describe(self) -> String {
        match self {
            Self::Line => "line".into(),
            Self::Quadratic => "quadratic".into(),
            Self::Polynomial { degree } => format!("polynomial of degree {degree}"),
            Self::Physical(_) => self.names().join(" + "),
        }
    }

    /// Shape functions at the stations: one row per station, one column per shape.
    ///
    /// # Errors
    /// [`ControlError::TooFewStations`] where there are fewer stations than shapes.
    pub(crate) fn design(self, station_z_mm: &[f64]) -> Result<DMatrix<f64>, ControlError> {
        let (stations, shapes) = (station_z_mm.len(), self.count());
        if stations < shapes {
            return Err(ControlError::TooFewStations { stations, shapes });
        }
        let first = station_z_mm.first().copied().unwrap_or(0.0);
        let span = station_z_mm.last().copied().unwrap_or(0.0) - first;
        let xi = |z: f64| if span > 0.0 { 2.0 * (z - first) / span - 1.0 } else { 0.0 };
        Ok(match self {
            Self::Physical(p) => {
                let rows: Vec<f64> = station_z_mm.iter().flat_map(|&z| p.at(z, xi(z))).collect();
                DMatrix::from_row_slice(stations, shapes, &rows)
            }
            _ => DMatrix::from_fn(stations, shapes, |row, column| legendre(column, xi(station_z_mm[row]))),
        })
    }

    /// The shapes of every section apart: a column is 0 outside its section, so that nothing is
    /// fitted across a shoulder. A section with fewer stations than shapes has a polynomial through
    /// them. Names of the columns beside them.
    ///
    /// # Errors
    /// As [`Self::design`], for a part of one section.
    pub(crate) fn of_sections(self, stations: &StationLayout) -> Result<SectionShapes, ControlError> {
        let (z, ranges) = (&stations.z_mm, stations.sections());
        if ranges.len() < 2 {
            return Ok(SectionShapes { design: self.design(z)?, names: self.names() });
        }
        let mut names = Vec::new();
        let mut columns: Vec<DVector<f64>> = Vec::new();
        for (k, range) in ranges.into_iter().enumerate() {
            let shapes = self.through(range.len());
            let own = shapes.design(&z[range.clone()])?;
            names.extend(shapes.names().iter().map(|name| format!("section {} {name}", k + 1)));
            columns.extend(own.column_iter().map(|column| {
                let mut whole = DVector::zeros(z.len());
                whole.rows_mut(range.start, range.len()).copy_from(&column);
                whole
            }));
        }
        Ok(SectionShapes { design: DMatrix::from_columns(&columns), names })
    }

    /// The shapes that so few stations determine.
    fn through(self, stations: usize) -> Self {
        if self.count() <= stations { self } else { Self::Polynomial { degree: stations.saturating_sub(1) } }
    }

    pub(crate) fn validate(self, key: &'static str) -> Result<(), SettingError> {
        match self {
            Self::Line | Self::Quadratic => Ok(()),
            Self::Polynomial { degree } => {
                require(degree <= 8, key, degree as f64, "a polynomial degree of 0 to 8")
            }
            Self::Physical(p) => {
                let right = "a positive length in mm (physical.length_mm)";
                require(p.length_mm > 0.0 && p.length_mm.is_finite(), key, p.length_mm, right)
            }
        }
    }
}

/// Shape functions of a part's sections.
#[derive(Clone, Debug)]
pub(crate) struct SectionShapes {
    /// One row per station, one column per shape and section.
    pub design: DMatrix<f64>,
    /// Names of the columns.
    pub names: Vec<String>,
}

impl PhysicalShapes {
    fn at(self, z_mm: f64, xi: f64) -> Vec<f64> {
        let mut row = vec![1.0];
        row.extend(self.taper.then_some(xi));
        row.extend(self.barrel.then_some(1.0 - xi * xi));
        row.extend(self.deflection.then(|| propped(z_mm / self.length_mm)));
        row
    }
}

/// Deflection under a load at a = sL, b = L − a, of a beam clamped at 0 and rigidly supported at L,
/// over its maximum: u ∝ a³b²(4L − a), largest at a = (2 − √2)L (Euler-Bernoulli; the clamp is the
/// chuck).
fn propped(s: f64) -> f64 {
    let shape = |s: f64| s.powi(3) * (1.0 - s).powi(2) * (4.0 - s);
    shape(s.clamp(0.0, 1.0)) / shape(2.0 - std::f64::consts::SQRT_2)
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
