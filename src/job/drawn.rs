//! What a picture of a job's shaft needs: the optical setup, the part's size and the scan. Passes,
//! masters, gauge, controller and process are a run's alone.

use super::error::from_render;
use super::loop_job::LoopJob;
use super::part::Part;
use super::simulated::Job;
use super::stations;
use crate::plan::ContourKnot;
use crate::setting::{SettingError, positive};
use crate::shaft::ProfileKnot;

impl Part {
    /// Diameter that a picture of the part shows, mm: that of the last pass, otherwise the stock's.
    pub(crate) fn drawn_diameter_mm(&self) -> f64 {
        self.nominal_diameter_mm.last().copied().unwrap_or(self.stock_diameter_mm)
    }

    /// The key of [`Self::drawn_diameter_mm`].
    fn drawn_key(&self) -> String {
        match self.passes() {
            0 => "part.stock_diameter_mm".to_owned(),
            passes => format!("part.nominal_diameter_mm[{}]", passes - 1),
        }
    }

    /// Refuses a drawn diameter larger than the stock, where a config gives the stock alone.
    ///
    /// # Errors
    /// Names both diameters.
    pub(crate) fn check_drawn_from_stock(&self) -> Result<(), SettingError> {
        let (drawn_mm, stock_mm) = (self.drawn_diameter_mm(), self.stock_diameter_mm);
        if drawn_mm <= stock_mm {
            return Ok(());
        }
        let why = format!("{drawn_mm} mm would be drawn, more than part.stock_diameter_mm = {stock_mm} mm");
        Err(SettingError::at("part.nominal_diameter_mm", why))
    }

    /// Checks the length, the diameter that is drawn, the stations that are listed and, where it is
    /// set, the tolerance.
    fn check_drawn(&self) -> Result<(), SettingError> {
        positive("part.length_mm", self.length_mm)?;
        positive(&self.drawn_key(), self.drawn_diameter_mm())?;
        self.check_tolerance()?;
        let Some(listed) = self.listed() else { return Ok(()) };
        positive("part.station_mm", self.station_mm)?;
        stations::check(listed, self.length_mm, self.station_mm)
    }
}

impl LoopJob {
    /// Checks the part, the camera's field and the scan. A contour has diameters of its own:
    /// whether they fit is checked frame by frame.
    fn check_drawn(&self, has_contour: bool) -> Result<(), SettingError> {
        self.part.check_drawn()?;
        self.field.check()?;
        self.check_scan()?;
        if self.field.is_line {
            // The length of a reading along z.
            positive("part.station_mm", self.part.station_mm)?;
        }
        if has_contour {
            return Ok(());
        }
        self.check_fits(&self.part.drawn_key(), self.part.drawn_diameter_mm())
    }
}

impl Job {
    /// Checks what `render` draws.
    ///
    /// # Errors
    /// The first setting that is refused.
    pub(crate) fn check_scene(&self) -> Result<(), SettingError> {
        self.check_setup()?;
        self.loop_job().check_drawn(!self.shaft.contour.is_empty())?;
        self.worn_profile().map(drop)
    }

    /// The surface that the tool's measured nose leaves in the last pass, as a run without
    /// deflection cuts it; none where the tool states no nose.
    ///
    /// # Errors
    /// A contour that cannot be turned, a nose that cannot turn it.
    pub(crate) fn worn_profile(&self) -> Result<Option<Vec<ProfileKnot>>, SettingError> {
        if self.tool.as_ref().is_none_or(|tool| tool.support.is_empty()) {
            return Ok(None);
        }
        let last_mm = self.part.drawn_diameter_mm();
        let knot = |k: &ContourKnot| ProfileKnot { z_mm: k.z_mm, radius_mm: 0.5 * (last_mm + k.relative_mm) };
        Ok(self.contours()?.1.map(|worn| worn.knots.iter().map(knot).collect()))
    }

    /// Checks the optical setup as a user may write it.
    ///
    /// # Errors
    /// The first setting that is refused.
    pub(super) fn check_setup(&self) -> Result<(), SettingError> {
        let setup = self.setup_settings();
        setup.check().and_then(|()| setup.check_counts()).map_err(from_render)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A small part before the default camera: its passes and masters are the defaults', which do
    /// not fit it.
    fn small() -> Job {
        let mut job = Job::default();
        job.part.length_mm = 20.0;
        job.part.nominal_diameter_mm = vec![10.0, 12.0];
        job
    }

    #[test]
    fn a_picture_needs_no_falling_diameters_and_no_masters() {
        let mut job = small();
        job.masters.pins.clear();
        assert_eq!(job.check_scene(), Ok(()));
        let refused = job.check().unwrap_err();
        assert_eq!(refused.key, "part.nominal_diameter_mm[1]");
        assert!((job.part.drawn_diameter_mm() - 12.0).abs() < f64::EPSILON);
    }

    #[test]
    fn a_shaft_larger_than_the_field_is_refused_by_its_key() {
        let mut job = small();
        job.part.nominal_diameter_mm = vec![200.0];
        assert_eq!(job.check_scene().unwrap_err().key, "part.nominal_diameter_mm[0]");
        job.part.nominal_diameter_mm.clear();
        job.part.stock_diameter_mm = 200.0;
        assert_eq!(job.check_scene().unwrap_err().key, "part.stock_diameter_mm");
    }

    #[test]
    fn counts_beyond_the_scale_are_refused_unless_they_are_photons() {
        let mut job = small();
        job.light.bright_counts = 5000.0;
        let refused = job.check_scene().unwrap_err();
        assert_eq!(refused.key, "light.bright_counts");
        assert!(refused.problem.contains("4095") && refused.problem.contains("12 bits"), "{refused}");
        job.light.bright_photons = Some(20_000.0);
        assert_eq!(job.check_scene(), Ok(()));
    }
}
