//! Calibration of a bench from frames of master pins at several heights: scale, edge offset, distortion, keystone and
//! telecentricity by least squares, with every source of uncertainty kept apart.

mod adjustment;
mod calibration;
mod certificates;
mod check_pin;
mod conditions;
mod date;
mod finish;
mod impossible;
mod lens;
mod observation;
mod thermometer;
mod unstated;

pub use super::range_check::SettingError;
pub use adjustment::{Adjusted, Adjustment, CovariancePart, Residual, Solver};
pub use calibration::{BenchCalibration, BenchError, Validity};
pub use certificates::{CertificateShare, MasterPrior, shared_source};
pub use check_pin::{CheckPin, CheckResult};
pub use conditions::{Conditions, GivenConditions};
pub use date::Date;
pub use finish::Finish;
pub use lens::{Along, LensLimits, LensModel, PARAMETERS};
pub use observation::{Observation, observe};
pub use thermometer::Thermometer;
pub use unstated::Unstated;
