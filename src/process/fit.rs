//! The power law's constants from measured forces, by least squares with confidence intervals.
//!
//! ln F = ln C + x·ln a_p + y·ln f + z·ln v is linear in (ln C, x, y, z); equal weights are right
//! where the relative scatter of the forces is the same at every point. A factor that the data do
//! not vary cannot be estimated: its exponent is taken from the given law. Intervals are Student's
//! t on n - p degrees of freedom.

use std::io::Read;

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};
use thiserror::Error;

use super::force::{FittedRange, PowerLaw};
use crate::plan::CuttingData;
use crate::text_table::{Cells, Comments, TextTable, TextTableError};

/// Columns of a table of forces.
const COLUMNS: [&str; 4] = ["depth_mm", "speed_m_per_min", "feed_mm_per_rev", "force_n"];

/// One measured force.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ForcePoint {
    /// Depth of cut, mm.
    pub depth_mm: f64,
    /// Cutting speed, m/min.
    pub speed_m_per_min: f64,
    /// Feed, mm/r.
    pub feed_mm_per_rev: f64,
    /// Radial force, N.
    pub force_n: f64,
}

impl ForcePoint {
    /// Feed and speed of the point.
    pub(crate) fn cutting(&self) -> CuttingData {
        CuttingData { speed_m_per_min: self.speed_m_per_min, feed_mm_per_rev: self.feed_mm_per_rev }
    }
}

/// Why forces cannot be read or fitted.
#[derive(Debug, Error)]
#[non_exhaustive]
pub(crate) enum FitError {
    /// The table cannot be read.
    #[error(
        "forces: {0}; the columns must be depth_mm, speed_m_per_min, feed_mm_per_rev, force_n with a header line"
    )]
    Table(String),
    /// A value whose logarithm does not exist.
    #[error("forces: row {row}: {column} = {value}; every value must be above 0")]
    NotPositive {
        /// Row of data, from 1.
        row: usize,
        /// Column.
        column: &'static str,
        /// Value found.
        value: f64,
    },
    /// Too few rows for the constants that vary.
    #[error("forces: {points} rows cannot give {parameters} constants with an interval; at least {} are needed", parameters + 1)]
    TooFew {
        /// Rows.
        points: usize,
        /// Constants to estimate.
        parameters: usize,
    },
    /// Factors that vary only together.
    #[error("forces: depth, feed and speed vary only together, so that their exponents cannot be told apart")]
    Collinear,
}

/// Reads a table of forces ([`crate::text_table`]); lines that start with `#` are comments, further
/// columns are passed over.
///
/// # Errors
/// A table that cannot be parsed, or a value that is not above zero.
pub(crate) fn read_forces(mut from: impl Read) -> Result<Vec<ForcePoint>, FitError> {
    let mut bytes = Vec::new();
    from.read_to_end(&mut bytes).map_err(|e| FitError::Table(e.to_string()))?;
    let table = TextTable::parse(&bytes, &COLUMNS, Comments::Hash);
    let table = table.map_err(|e| FitError::Table(e.to_string()))?;
    table.require(&COLUMNS).map_err(FitError::Table)?;
    let row = |(index, cells): (usize, Result<Cells<'_>, TextTableError>)| {
        let cells = cells.map_err(|e| FitError::Table(e.to_string()))?;
        point(index + 1, &cells)
    };
    table.rows().enumerate().map(row).collect()
}

fn point(row: usize, cells: &Cells<'_>) -> Result<ForcePoint, FitError> {
    let mut values = [0.0; 4];
    for (value, column) in values.iter_mut().zip(COLUMNS) {
        *value = cells.number(column).map_err(FitError::Table)?;
        if *value <= 0.0 {
            return Err(FitError::NotPositive { row, column, value: *value });
        }
    }
    let [depth_mm, speed_m_per_min, feed_mm_per_rev, force_n] = values;
    Ok(ForcePoint { depth_mm, speed_m_per_min, feed_mm_per_rev, force_n })
}

/// An estimated or given constant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Estimate {
    /// Name as in the config.
    pub name: &'static str,
    /// Value.
    pub value: f64,
    /// Confidence interval; absent where the data do not vary the factor and the value was given.
    pub interval: Option<[f64; 2]>,
}

/// A fitted power law.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct PowerFit {
    /// The law, with the range of the data as its range of validity.
    pub law: PowerLaw,
    /// C, x, y, z with their intervals.
    pub estimates: Vec<Estimate>,
    /// Confidence of the intervals.
    pub confidence: f64,
    /// Relative residual standard deviation.
    pub residual_rel: f64,
    /// Degrees of freedom.
    pub degrees_of_freedom: usize,
}

/// Fits the law to points. Exponents of factors that the points do not vary are taken from `given`.
///
/// # Errors
/// Too few points, or factors that cannot be separated.
pub(crate) fn fit_power_law(
    points: &[ForcePoint],
    given: &PowerLaw,
    confidence: f64,
) -> Result<PowerFit, FitError> {
    let factors: [fn(&ForcePoint) -> f64; 3] =
        [|p| p.depth_mm.ln(), |p| p.feed_mm_per_rev.ln(), |p| p.speed_m_per_min.ln()];
    let exponents = [given.depth_exponent, given.feed_exponent, given.speed_exponent];
    let varied: Vec<usize> = (0..3).filter(|&i| varies(points, factors[i])).collect();
    let parameters = varied.len() + 1;
    if points.len() <= parameters {
        return Err(FitError::TooFew { points: points.len(), parameters });
    }
    let design = DMatrix::from_fn(points.len(), parameters, |row, column| match column {
        0 => 1.0,
        _ => factors[varied[column - 1]](&points[row]),
    });
    let known = |p: &ForcePoint| -> f64 {
        (0..3).filter(|i| !varied.contains(i)).map(|i| exponents[i] * factors[i](p)).sum()
    };
    let y = DVector::from_iterator(points.len(), points.iter().map(|p| p.force_n.ln() - known(p)));
    let inverse = (design.transpose() * &design).try_inverse().ok_or(FitError::Collinear)?;
    if inverse.iter().any(|v| !v.is_finite() || v.abs() > 1e10) {
        return Err(FitError::Collinear);
    }
    let beta = &inverse * design.transpose() * &y;
    let degrees_of_freedom = points.len() - parameters;
    let variance = (y - design * &beta).norm_squared() / degrees_of_freedom as f64;
    let t = student(confidence, degrees_of_freedom);
    let half: Vec<f64> = (0..parameters).map(|i| t * (variance * inverse[(i, i)]).sqrt()).collect();
    let mut estimates = vec![Estimate {
        name: "coefficient_n",
        value: beta[0].exp(),
        interval: Some([(beta[0] - half[0]).exp(), (beta[0] + half[0]).exp()]),
    }];
    for (factor, name) in ["depth_exponent", "feed_exponent", "speed_exponent"].into_iter().enumerate() {
        let column = varied.iter().position(|v| *v == factor).map(|c| c + 1);
        let value = column.map_or(exponents[factor], |c| beta[c]);
        let interval = column.map(|c| [value - half[c], value + half[c]]);
        estimates.push(Estimate { name, value, interval });
    }
    let law = PowerLaw {
        coefficient_n: estimates[0].value,
        depth_exponent: estimates[1].value,
        feed_exponent: estimates[2].value,
        speed_exponent: estimates[3].value,
        fitted: range(points),
        ..*given
    };
    Ok(PowerFit { law, estimates, confidence, residual_rel: variance.sqrt(), degrees_of_freedom })
}

fn varies(points: &[ForcePoint], factor: fn(&ForcePoint) -> f64) -> bool {
    let first = points.first().map_or(0.0, factor);
    points.iter().any(|p| (factor(p) - first).abs() > 1e-9)
}

fn student(confidence: f64, degrees_of_freedom: usize) -> f64 {
    StudentsT::new(0.0, 1.0, degrees_of_freedom as f64)
        .map_or(f64::INFINITY, |t| t.inverse_cdf(0.5 + 0.5 * confidence))
}

fn range(points: &[ForcePoint]) -> FittedRange {
    let of = |value: fn(&ForcePoint) -> f64| {
        points.iter().map(value).fold([f64::INFINITY, 0.0], |[low, high], v| [v.min(low), v.max(high)])
    };
    FittedRange {
        depth_mm: of(|p| p.depth_mm),
        feed_mm_per_rev: of(|p| p.feed_mm_per_rev),
        speed_m_per_min: of(|p| p.speed_m_per_min),
    }
}
