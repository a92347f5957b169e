//! Pixels to millimetres: calibration from frames of master pins at several heights.
//!
//! In: edges of certified masters, the conditions they were recorded under, limits of what the lens
//! may be. Out: a [`Calibration`] (scale and edge offset) with
//! `SetupCalibration` (distortion, keystone and telecentricity by least squares), every source of
//! uncertainty kept apart, as a file of its own version.
//!
//! `observation` → `masters` → `adjustment` over the parameters of `imaging_model`; `conditions`,
//! `thermometer` and `finish` state what is known of a part and of masters, `unstated` what is
//! taken where nothing is; `verification` is a check pin, `file_checks` refuses damaged files. One
//! more parameter of the lens goes into `imaging_model` (its derivative with it); one more source
//! of uncertainty is a part of `adjustment`'s covariance and a row of the budget.

pub(crate) mod adjusted;
pub(crate) mod adjustment;
pub(crate) mod axis_zero;
mod conditions;
mod date;
pub(crate) mod error;
pub(crate) mod file_checks;
pub(crate) mod finish;
pub(crate) mod gauge_calibration;
mod imaging_model;
pub(crate) mod masters;
pub(crate) mod observation;
pub(crate) mod optical_setup;
mod thermometer;
pub(crate) mod unstated;
mod verification;

#[cfg(test)]
pub(crate) use adjusted::Adjusted;
pub(crate) use adjusted::{CovariancePart, Residual};
pub(crate) use adjustment::{Adjustment, Solver};
pub use conditions::Conditions;
pub(crate) use conditions::GivenConditions;
pub(crate) use date::Date;
pub(crate) use error::CalibrationError;
pub use gauge_calibration::Calibration;
pub(crate) use imaging_model::{ColumnSpread, LensLimits, LensModel, PARAMETERS};
pub(crate) use masters::{CertificateShare, MasterFigure, MasterPrior, shared_source};
pub use masters::{MasterCertificate, MasterMeasurement};
pub(crate) use observation::{Observation, observe};
pub(crate) use optical_setup::{BenchError, ReadWidth, SetupCalibration, Validity};
pub(crate) use thermometer::Thermometer;
#[cfg(test)]
pub(crate) use unstated::Unstated;
pub(crate) use verification::{CheckPin, CheckResult};
