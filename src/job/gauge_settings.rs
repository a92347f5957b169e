//! The gauge's settings of a job, with the edge of the job's own optics.

use super::edge::NominalEdge;
use super::error::from_render;
use super::simulated::Job;
use crate::gauge::{EsfModel, GaugeSettings};
use crate::setting::SettingError;

impl Job {
    /// The gauge's settings with the edge-spread function of the job's own optics in place of
    /// `[gauge.esf.optics]`: in focus, on the finished part.
    ///
    /// # Errors
    /// Optics whose table cannot be computed.
    pub(crate) fn gauge_settings(&self) -> Result<GaugeSettings, SettingError> {
        if self.gauge.esf != (EsfModel::Optics {}) {
            return Ok(self.gauge.clone());
        }
        let last = self.part.drawn_diameter_mm();
        let pixel_mm = self.nominal_mm_per_px();
        let edge = NominalEdge::new(&self.optics, pixel_mm, 0.5 * last, 0.0).map_err(from_render)?;
        Ok(GaugeSettings { esf: edge.model(1e3 * pixel_mm), ..self.gauge.clone() })
    }
}
