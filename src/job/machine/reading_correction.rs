//! Readings of a head that rides on a machine: where it stands, as far as the control is given.
//!
//! In: `correct_readings` of `[machine]` and its table. Out: the [`HeadGeometry`] by which the loop
//! corrects its readings, and what of it is stated before a run. The simulated head stands where
//! the machine's own errors put it; this is what the instrument is given, from the table alone.

use super::run_settings::{RunMachine, StatedPlace};
use crate::gauge::calibration::{HeadGeometry, HeadPlace};
use crate::identification::head_geometry::{self, temperature_consequence};
use crate::job::loop_job::LoopJob;
use crate::machine::Conditions;
use crate::setting::SettingError;

impl RunMachine {
    /// Takes what an identified machine states of the head and of its readings.
    pub(crate) fn take_identified(
        &mut self,
        geometry: &HeadGeometry,
        temperature_c: f64,
        unread: Vec<String>,
    ) {
        if self.correct_readings {
            self.table_head = geometry.places().iter().map(StatedPlace::from).collect();
            self.table_unread = unread;
        }
        self.table_temperature_c = Some(temperature_c);
    }

    /// Where the head stands, as far as the control is given; none where its readings are not
    /// corrected, or where [`Self::lathe`] refuses the table.
    pub(crate) fn head_geometry(&self) -> Option<HeadGeometry> {
        if !self.correct_readings {
            return None;
        }
        if !self.table_head.is_empty() {
            return HeadGeometry::new(self.table_head.iter().map(HeadPlace::from).collect()).ok();
        }
        head_geometry::of_machine(self.table_stated.as_ref().or(self.stated.as_ref())?).ok()
    }

    /// Warnings for a run: a machine at another temperature than that of its readings, errors of
    /// the head that count as zero.
    pub(crate) fn cautions(&self) -> Vec<String> {
        let uses = self.compensate || self.correct_readings;
        let now = self.temperature_c.unwrap_or(Conditions::default().temperature_c);
        let other = self.table_temperature_c.zip(self.table_stated.as_ref()).filter(|_| uses);
        let warmer = other.and_then(|(then, table)| temperature_consequence(table, then, now));
        let unread = (self.correct_readings && !self.table_unread.is_empty()).then(|| {
            format!(
                "{} move the head along Y and count as zero in machine.table: what they add to the readings is corrected by nothing and in no \
                 uncertainty",
                self.table_unread.join(", ")
            )
        });
        warmer.map(|words| format!("machine.table: {words}")).into_iter().chain(unread).collect()
    }

    /// Refuses places of the head that cannot be right.
    pub(super) fn check_head(&self) -> Result<(), SettingError> {
        if self.table_head.is_empty() {
            return Ok(());
        }
        let at = |e: SettingError| SettingError { key: "machine.table_head".to_owned(), ..e };
        HeadGeometry::new(self.table_head.iter().map(HeadPlace::from).collect()).map(drop).map_err(at)
    }
}

/// Refuses a scan with fields where the table has no place of the head.
pub(super) fn check_known(part: &LoopJob) -> Result<(), SettingError> {
    let Some(geometry) = &part.head_geometry else { return Ok(()) };
    let (from, to) = geometry.range_mm();
    let unknown = |z: &f64| geometry.at(*z).is_none();
    let Some(z_mm) = part.scan_plan().field_z_mm.into_iter().find(unknown) else { return Ok(()) };
    let why = format!(
        "the field at z = {z_mm:.3} mm lies outside {from:.3} to {to:.3} mm, where the table knows the head's place: none is extrapolated"
    );
    Err(SettingError::at("machine.table", why))
}
