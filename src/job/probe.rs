//! Checks of a job that measures with a touch probe.

use super::scan::Masters;
use crate::probe::ProbeSettings;
use crate::setting::{SettingError, positive};

/// The probe's table, and masters that it can be calibrated on.
///
/// # Errors
/// Names the key and what would be right.
pub(super) fn check(probe: &ProbeSettings, masters: &Masters) -> Result<(), SettingError> {
    probe.validate()?;
    if masters.pins.is_empty() {
        return Err(SettingError::at("masters.pins", "is empty; a probe is calibrated on one pin or more"));
    }
    for (index, pin) in masters.pins.iter().enumerate() {
        let key = format!("masters.pins[{index}]");
        positive(&format!("{key}.diameter_mm"), pin.diameter_mm)?;
        positive(&format!("{key}.expanded_u_mm"), pin.expanded_u_mm)?;
        positive(&format!("{key}.coverage_factor"), pin.coverage_factor)?;
    }
    Ok(())
}
