//! What a measurement takes from its calibration unless something else is stated: the conditions of
//! the part, the edge-spread function, the gauge that expects the masters' residual.

use super::error::MeasureError;
use crate::gauge::calibration::{Conditions, GivenConditions};
use crate::gauge::{Calibration, EsfModel, Gauge, GaugeSettings};
use crate::setting::SettingError;

/// The conditions that a calibration carries; unstated ones with masters but without conditions,
/// exact ones with a scale alone.
pub fn known_conditions(calibration: Option<&Calibration>) -> Conditions {
    match calibration {
        Some(c) if c.leaves_conditions_open() => Conditions::unstated(),
        Some(c) => c.conditions(),
        None => Conditions::default(),
    }
}

/// The part's conditions: those given, otherwise the calibration's; a temperature of the part, °C,
/// takes the place of either's.
///
/// # Errors
/// Names the first condition out of its range.
pub(crate) fn conditions(
    calibration: Option<&Calibration>,
    given: Option<&GivenConditions>,
    part_temperature_c: Option<f64>,
) -> Result<Conditions, SettingError> {
    let known = known_conditions(calibration);
    let mut conditions = given.map_or(known, |given| given.over(&known));
    if let Some(temperature_c) = part_temperature_c {
        conditions = conditions.at(temperature_c);
    }
    conditions.validate()?;
    Ok(conditions)
}

/// The edge-spread function: the one stated, otherwise the masters', otherwise the Gaussian.
pub(crate) fn edge_model(stated: Option<EsfModel>, calibration: Option<&Calibration>) -> EsfModel {
    stated.or_else(|| calibration.and_then(Calibration::edge_model)).unwrap_or_default()
}

impl Gauge {
    /// A gauge for frames of a calibration: expects the residual that its masters left.
    ///
    /// # Errors
    /// A setting out of its range; an edge-spread function that is not the masters'.
    pub fn calibrated(
        settings: GaugeSettings,
        calibration: Option<&Calibration>,
    ) -> Result<Self, MeasureError> {
        let checked = calibration.map_or(Ok(()), |c| c.check_edge_model(&settings.esf));
        checked.map_err(MeasureError::EdgeModel)?;
        let residual = calibration.and_then(Calibration::systematic_residual);
        Ok(Self::new(settings)?.with_systematic_residual(residual))
    }
}
