//! Pixels to millimetres: calibration from frames of master pins at several heights.
//!
//! In: edges of certified masters, the conditions they were recorded under, limits of what the lens
//! may be. Out: a [`Calibration`] (scale and edge offset) with
//! [`SetupCalibration`] (distortion, keystone and telecentricity by least squares), every source of
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

pub use adjusted::{Adjusted, CovariancePart, Residual};
pub use adjustment::{Adjustment, Solver};
pub use axis_zero::AxisZero;
pub use conditions::{Conditions, GivenConditions};
pub use date::Date;
pub use error::{CALIBRATION_VERSION, CalibrationError};
pub use finish::Finish;
pub use gauge_calibration::Calibration;
pub use imaging_model::{ColumnSpread, LensLimits, LensModel, PARAMETERS};
pub use masters::{
    CertificateShare, MasterCertificate, MasterFigure, MasterMeasurement, MasterPrior, shared_source,
};
pub use observation::{Observation, observe};
pub use optical_setup::{BenchError, ReadWidth, SetupCalibration, Validity};
pub use thermometer::Thermometer;
pub use unstated::Unstated;
pub use verification::{CheckPin, CheckResult};
