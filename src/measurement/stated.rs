//! The budget of a diameter by a scale alone: rows for what is not stated.

use crate::gauge::Calibration;
use crate::gauge::budget::{Budget, Contribution, Shape, Share, WidthReading};
use crate::gauge::calibration::Conditions;

/// The budget of a reading, with a row for scale and edge offset without an uncertainty.
pub(crate) fn stated_budget(
    reading: &WidthReading,
    calibration: &Calibration,
    conditions: &Conditions,
) -> Budget {
    let mut budget = reading.budget(calibration, conditions);
    if is_uncalibrated(calibration) {
        // Without masters the part's edges and temperature have no reference: U is the image's
        // alone.
        let temperature = (conditions.limit_temperature_k == 0.0).then_some("temperature of the part");
        budget.contributions.extend(temperature.into_iter().chain(["scale and edge offset"]).map(|source| {
            Contribution {
                source: source.to_owned(),
                input: "not stated".to_owned(),
                shape: Shape::Normal,
                share: Share::Common,
                freedom: None,
                u_mm: 0.0,
            }
        }));
    }
    budget
}

/// Whether the calibration is a scale only: no masters, no uncertainty.
pub(super) fn is_uncalibrated(calibration: &Calibration) -> bool {
    calibration.setup.is_none() && calibration.masters.is_empty() && calibration.covariance == [0.0; 3]
}
