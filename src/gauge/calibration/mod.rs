//! Pixels to millimetres: calibration from frames of master pins at several heights.
//!
//! In: edges of certified masters, the conditions they were recorded under, limits of what the lens
//! may be. Out: a [`Calibration`] (scale and edge offset) with
//! `SetupCalibration` (distortion, keystone and telecentricity by least squares), every source of
//! uncertainty kept apart, as a file of its own version.
//!
//! `observation` → `masters` → `adjustment` over the parameters of `imaging_model`; `conditions`,
//! `thermometer`, `finish` and `limb_difference` state what is known of a part and of masters,
//! `unstated` what is taken where nothing is; `head_geometry` where a machine carries the head;
//! `bound` compares with the camera that it was made with; `verification` is a check pin,
//! `file_checks` refuses damaged files. One more parameter of the lens goes into `imaging_model`
//! (its derivative with it); one more source of uncertainty is a part of `adjustment`'s covariance
//! and a row of the budget.

pub(crate) mod adjusted;
pub(crate) mod adjustment;
pub(crate) mod axis_zero;
mod bound;
mod conditions;
mod date;
pub(crate) mod error;
pub(crate) mod file_checks;
pub(crate) mod finish;
pub(crate) mod gauge_calibration;
pub(crate) mod head_geometry;
mod imaging_model;
pub(crate) mod limb_difference;
pub(crate) mod masters;
pub(crate) mod observation;
pub(crate) mod optical_setup;
mod thermometer;
pub(crate) mod unstated;
mod verification;

pub use self::{
    adjusted::{CovariancePart, Residual},
    conditions::Conditions,
    date::Date,
    error::CalibrationError,
    finish::Finish,
    gauge_calibration::Calibration,
    head_geometry::{HeadGeometry, HeadPlace},
    imaging_model::LensModel,
    limb_difference::{KnownMaterial, LimbDifference},
    masters::{MasterCertificate, MasterFigure, MasterMeasurement},
    optical_setup::{BenchError, SetupCalibration, Validity},
    unstated::Unstated,
    verification::CheckResult,
};
#[cfg(test)]
pub(crate) use adjusted::Adjusted;
pub(crate) use adjustment::{Adjustment, Solver};
pub(crate) use conditions::GivenConditions;
pub(crate) use finish::texture_shift_um;
pub(crate) use imaging_model::{ColumnSpread, LensLimits, PARAMETERS};
pub(crate) use masters::{CertificateShare, MasterPrior, shared_source};
pub(crate) use observation::{Observation, observe};
pub(crate) use optical_setup::ReadWidth;
pub(crate) use thermometer::Thermometer;
pub(crate) use verification::CheckPin;
