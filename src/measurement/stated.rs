//! Rows of the budget beside the gauge's own: the drift since the last zero, a reference pin and,
//! of a diameter by a scale alone, what is not stated.

use super::reference_pin::PinCorrection;
use crate::gauge::Calibration;
use crate::gauge::budget::{Budget, Contribution, Shape, Share, Texts, WidthReading};
use crate::gauge::calibration::Conditions;

/// Writes the budget of a reading, with a row for scale and edge offset without an uncertainty, in
/// the memory of an earlier one.
pub(super) fn stated_budget(
    reading: &WidthReading,
    calibration: &Calibration,
    conditions: &Conditions,
    texts: Texts,
    budget: &mut Budget,
) {
    reading.budget_into(calibration, conditions, texts, budget);
    if is_uncalibrated(calibration) {
        // Without masters the part's edges and temperature have no reference: U is the image's
        // alone.
        let temperature = (conditions.limit_temperature_k == 0.0).then_some("temperature of the part");
        budget.contributions.extend(temperature.into_iter().chain(["scale and edge offset"]).map(|source| {
            Contribution {
                source: texts.of(format_args!("{source}")),
                input: texts.of(format_args!("not stated")),
                shape: Shape::Normal,
                share: Share::Common,
                freedom: None,
                u_mm: 0.0,
            }
        }));
    }
}

/// The row of a gauge's drift since it was set to zero; none at the zero itself.
pub(super) fn drift_row(u_mm: f64, since: &str, texts: Texts) -> Option<Contribution> {
    (u_mm != 0.0).then(|| Contribution {
        source: texts.of(format_args!("drift since the last zero")),
        input: texts.of(format_args!("{since}")),
        shape: Shape::Rectangular,
        share: Share::Common,
        freedom: None,
        u_mm,
    })
}

/// The rows of a reference pin's correction, which is taken into the diameter.
pub(super) fn correct_by_pin(budget: &mut Budget, pin: &PinCorrection, texts: Texts) {
    budget.diameter_mm *= pin.ratio;
    let d_mm = budget.diameter_mm;
    let row = |source: &str, shape, share, u_mm| Contribution {
        source: texts.of(format_args!("{source}")),
        input: texts.of(format_args!("{pin}")),
        shape,
        share,
        freedom: None,
        u_mm,
    };
    budget.contributions.extend([
        row("reference pin, its reading", Shape::Normal, Share::Random, d_mm * pin.u_reading),
        row("reference pin, its stated diameter", Shape::Normal, Share::Common, d_mm * pin.u_stated),
        row(
            "reference pin, drift of scale or of edges",
            Shape::Rectangular,
            Share::Common,
            pin.u_kind_mm(d_mm),
        ),
    ]);
}

/// Whether the calibration is a scale only: no masters, no uncertainty.
pub(super) fn is_uncalibrated(calibration: &Calibration) -> bool {
    calibration.setup.is_none() && calibration.masters.is_empty() && calibration.covariance == [0.0; 3]
}
