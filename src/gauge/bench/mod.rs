//! Calibration of a bench from frames of master pins at several heights: scale, edge offset, distortion, keystone and
//! telecentricity by least squares, with every source of uncertainty kept apart.

mod adjustment;
mod calibration;
mod certificates;
mod check_pin;
mod conditions;
mod date;
mod defects;
mod finish;
mod flat_field;
mod impossible;
mod lens;
mod observation;
mod response;
mod thermometer;
mod unstated;

pub use adjustment::{Adjusted, Adjustment, CovariancePart, Residual, Solver};
pub use calibration::{BenchCalibration, BenchError, Validity};
pub use certificates::{CertificateShare, MasterPrior, shared_source};
pub use check_pin::{CheckPin, CheckResult};
pub use conditions::{Conditions, GivenConditions};
pub use date::Date;
pub use defects::ShaftRuns;
pub use finish::Finish;
pub use flat_field::{FlatField, FlatFieldError};
pub use lens::{Along, LensLimits, LensModel, PARAMETERS};
pub use observation::{Observation, observe};
pub use response::{NoResponse, Response, response};
pub use thermometer::Thermometer;
pub use unstated::Unstated;

use thiserror::Error;

/// A setting of a calibration out of its range.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{key} = {value} is out of range; right would be {right}")]
pub struct SettingError {
    /// The dotted key.
    pub key: String,
    /// The value found.
    pub value: f64,
    /// What would be right.
    pub right: &'static str,
}

/// Refuses what is not finite or lies outside `low ..= high`.
fn within(key: &str, value: f64, low: f64, high: f64, right: &'static str) -> Result<(), SettingError> {
    if value.is_finite() && (low..=high).contains(&value) {
        Ok(())
    } else {
        Err(SettingError { key: key.to_owned(), value, right })
    }
}
