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

pub use super::range_check::SettingError;
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
