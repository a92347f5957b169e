//! The fourth workpiece before a camera: cut, drawn in frames, and its diameter by the gauge.

use glam::DVec2;

use super::cut::Cut;
use super::error::WornToolError;
use super::workpieces::LARGE_MM;
use crate::cell::SimulatedCell;
use crate::closed_loop::{Calibrated, ClosedLoop, LoopError};
use crate::job::{CuttingTruth, Job, RunTool};
use crate::plan::CuttingData;
use crate::render::Renderer;
use crate::setting::SettingError;
use crate::tool::MeasuredPass;

/// A camera before the lathe, calibrated once.
pub(super) struct Frames<'a> {
    job: &'a Job,
    renderer: &'a Renderer,
    calibration: Option<Calibrated>,
}

/// Depth of the one pass on the diameter, mm.
const ALLOWANCE_MM: f64 = 0.5;

impl<'a> Frames<'a> {
    pub(super) fn new(job: &'a Job, renderer: &'a Renderer) -> Self {
        Self { job, renderer, calibration: None }
    }

    /// Mean of the stations less the drawn diameter, with the largest standard uncertainty of one,
    /// µm.
    pub(super) fn error_um(
        &mut self,
        cut: &Cut<'_>,
        slides_mm: DVec2,
    ) -> Result<(f64, Option<f64>), WornToolError> {
        let job = self.job_of(cut, slides_mm)?;
        let cell = SimulatedCell::new(&job, self.renderer).map_err(LoopError::from)?;
        let checked = job.checked_loop()?;
        let mut turning = ClosedLoop::start(checked, Box::new(cell), self.calibration.take())?;
        self.calibration = Some(turning.calibration().clone());
        let pass = turning.run_pass(&mut |_, _| {})?;
        let stations = &pass.profile.stations;
        let read: Vec<_> = stations.iter().filter_map(|s| s.reading.value()).collect();
        if read.is_empty() {
            let what = "no station that the gauge could measure";
            return Err(WornToolError::Surface { workpiece: cut.workpiece.number(), what });
        }
        let mean = read.iter().map(|d| d.d_mm).sum::<f64>() / read.len() as f64;
        let u = read.iter().map(crate::profile::Diameter::u_mm).fold(0.0, f64::max);
        Ok((1e3 * (mean - LARGE_MM), Some(1e3 * u)))
    }

    /// The job with the tool as known to the program, and with what really cuts.
    fn job_of(&self, cut: &Cut<'_>, slides_mm: DVec2) -> Result<Job, WornToolError> {
        let edit = cut.edit()?;
        let mut job = self.job.clone();
        let contour = cut.workpiece.corners(cut.cone_rad(), &edit);
        let diameter_mm = contour[0].diameter_mm;
        job.part.length_mm = contour[contour.len() - 1].z_mm;
        job.part.nominal_diameter_mm = vec![diameter_mm];
        job.part.stock_diameter_mm = diameter_mm + ALLOWANCE_MM;
        job.shaft.contour = contour;
        let mut file = cut.noses.tool;
        let stated = cut.stated();
        (file.setting.x_extent_mm, file.setting.z_extent_mm) = (stated.x_mm, stated.z_mm);
        file.register_mm = cut.register_mm();
        // the nose was worn, and is measured, by cuts like those before compensation
        let CuttingData { speed_m_per_min, feed_mm_per_rev } = self.job.cutting;
        let depth_mm = Some(0.5 * ALLOWANCE_MM);
        file.measured_pass = Some(MeasuredPass { speed_m_per_min, feed_mm_per_rev, depth_mm });
        let truth = CuttingTruth { nose: cut.noses.real.clone(), slides_mm };
        let mut tool =
            RunTool { stated: Some(file), way: cut.program.way(), truth: Some(truth), ..RunTool::default() };
        tool.take_nose(&cut.noses.document).map_err(|e: SettingError| WornToolError::Nose(e.to_string()))?;
        job.tool = Some(tool);
        Ok(job)
    }
}
