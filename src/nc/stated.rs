//! Whether the machine's data are complete for the control, and whether they are in range.

use super::dialect::Dialect;
use super::error::NcError;
use super::machine::{GeometryOffset, Tailstock};
use super::settings::NcSettings;
use crate::setting::{SettingError, require};

impl NcSettings {
    /// Whether all data are stated that differ between machines with this control.
    ///
    /// # Errors
    /// [`NcError::Unstated`] names each key and where to look up its value.
    pub(crate) fn check_stated(&self, dialect: Dialect) -> Result<(), NcError> {
        // the path carries the whole correction where T and D do not choose among offset numbers
        let has_offset_numbers = dialect != Dialect::Sinumerik;
        let missing: Vec<&str> = [
            (has_offset_numbers && self.wear_x.is_none()).then(|| dialect.look_up_wear_x()),
            (has_offset_numbers && self.geometry_offset.is_none()).then(|| dialect.look_up_geometry_offset()),
            self.spindle.is_none().then(|| dialect.look_up_spindle()),
            (dialect == Dialect::Gsk && self.probe.is_some_and(|p| p.skip_variable.is_none()))
                .then(|| dialect.look_up_skip_variable()),
        ]
        .into_iter()
        .flatten()
        .collect();
        if dialect == Dialect::Linuxcnc
            && let Some(orientation) = self.spindle_orientation
        {
            let code = f64::from(orientation.m_code);
            require(code == 19.0, "nc.spindle_orientation.m_code", code, "19 on linuxcnc")?;
        }
        if dialect == Dialect::Linuxcnc || missing.is_empty() {
            return Ok(());
        }
        Err(NcError::Unstated { dialect: dialect.as_str(), missing: missing.join("; ") })
    }

    /// Whether the mean of a correction goes into the wear register: where the register can be
    /// written and its number does not also choose the geometry.
    pub(crate) fn uses_wear_register(&self, dialect: Dialect) -> bool {
        dialect.has_wear_register() && self.geometry_offset != Some(GeometryOffset::ByOffset)
    }

    pub(super) fn validate_surroundings(&self) -> Result<(), SettingError> {
        let positive = |key, value: f64| {
            require(value > 0.0 && value.is_finite(), key, value, "a positive length in mm")
        };
        let finite = |key, value: f64| require(value.is_finite(), key, value, "a length in mm");
        if let Some(r) = self.nose_radius_mm {
            let right = "a radius of 0.05 to 10 mm";
            require((0.05..=10.0).contains(&r), "nc.nose_radius_mm", r, right)?;
        }
        if let Some(orientation) = self.spindle_orientation {
            orientation.validate()?;
        }
        if let Some(change) = self.change_position {
            positive("nc.change_position.x_mm", change.x_mm)?;
            finite("nc.change_position.z_mm", change.z_mm)?;
        }
        if let Some(chuck) = self.chuck {
            positive("nc.chuck.diameter_mm", chuck.diameter_mm)?;
            positive("nc.chuck.jaws_diameter_mm", chuck.jaws_diameter_mm.unwrap_or(chuck.diameter_mm))?;
            let jaws = chuck.jaws_to_z_mm;
            require((0.0..1e4).contains(&jaws), "nc.chuck.jaws_to_z_mm", jaws, "0 mm or more")?;
        }
        if let Some(Tailstock::Centre(centre)) = self.tailstock {
            centre.validate()?;
        }
        for rest in self.steady_rests.iter().flatten() {
            rest.validate([
                "nc.steady_rests.from_z_mm",
                "nc.steady_rests.to_z_mm",
                "nc.steady_rests.diameter_mm",
            ])?;
        }
        if let Some(head) = self.gauge_head {
            head.validate(["nc.gauge_head.from_z_mm", "nc.gauge_head.to_z_mm", "nc.gauge_head.diameter_mm"])?;
        }
        if let Some(travel) = self.travel {
            for (key, (least, most)) in [("nc.travel.x_mm", travel.x_mm), ("nc.travel.z_mm", travel.z_mm)] {
                require(most > least, key, least, "[least, largest], rising")?;
            }
        }
        self.boring_bar.map_or(Ok(()), |bar| bar.validate())?;
        if let Some(holder) = self.holder {
            finite("nc.holder.towards_chuck_mm", holder.towards_chuck_mm)?;
            finite("nc.holder.towards_tailstock_mm", holder.towards_tailstock_mm)?;
            require(holder.above_mm >= 0.0, "nc.holder.above_mm", holder.above_mm, "0 mm or more")?;
        }
        Ok(())
    }
}
