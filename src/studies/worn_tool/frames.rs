//! The workpieces before a camera: cut, drawn in frames, and their sizes by the gauge.
//!
//! The diameter of the fourth is that of its stations. Of the others every frame shows the pieces
//! that a size needs (`seen`), in both halves of the silhouette.

use glam::DVec2;

use super::cut::Cut;
use super::error::WornToolError;
use super::seen::{Measured, Seen, SizeOfFrames};
use super::workpieces::{LARGE_MM, Workpiece};
use crate::cell::SimulatedCell;
use crate::closed_loop::{Calibrated, ClosedLoop, LoopError};
use crate::job::{Job, RunTool};
use crate::plan::CuttingData;
use crate::render::Renderer;
use crate::setting::SettingError;
use crate::tool::MeasuredPass;

/// Workpieces before their cameras.
#[derive(Clone, Debug)]
pub(crate) struct Jobs {
    /// The first three: lengths, cones and radii.
    pub profiles: Job,
    /// The fourth: a diameter.
    pub batch: Job,
}

/// The cameras before the lathe, each calibrated once.
pub(super) struct Frames<'a> {
    jobs: &'a Jobs,
    renderer: &'a Renderer,
    profiles: Option<Calibrated>,
    batch: Option<Calibrated>,
}

/// Depth of the one pass on the diameter, mm.
const ALLOWANCE_MM: f64 = 0.5;

impl<'a> Frames<'a> {
    pub(super) fn new(jobs: &'a Jobs, renderer: &'a Renderer) -> Self {
        Self { jobs, renderer, profiles: None, batch: None }
    }

    /// The error of a workpiece's size where the slides stand off by `slides` along each piece.
    pub(super) fn measure(
        &mut self,
        cut: &Cut<'_>,
        slides: &dyn Fn(usize) -> DVec2,
    ) -> Result<Measured, WornToolError> {
        match cut.workpiece {
            Workpiece::BatchDiameter => self.diameter(cut, slides),
            _ => self.size(cut, slides),
        }
    }

    /// Mean of the stations less the drawn diameter, with the largest standard uncertainty of one.
    fn diameter(
        &mut self,
        cut: &Cut<'_>,
        slides: &dyn Fn(usize) -> DVec2,
    ) -> Result<Measured, WornToolError> {
        let job = job_of(&self.jobs.batch, cut, slides)?;
        let mut turning = start(&job, self.renderer, self.batch.take())?;
        self.batch = Some(turning.calibration().clone());
        let pass = turning.run_pass(&mut |_, _| {})?;
        let stations = &pass.profile.stations;
        let read: Vec<_> = stations.iter().filter_map(|s| s.reading.value()).collect();
        if read.is_empty() {
            let what = "no station that the gauge could measure";
            return Err(WornToolError::Surface { workpiece: cut.workpiece.number(), what });
        }
        let mean = read.iter().map(|d| d.d_mm).sum::<f64>() / read.len() as f64;
        let u = read.iter().map(crate::profile::Diameter::u_mm).fold(0.0, f64::max);
        Ok(Measured { error_um: 1e3 * (mean - LARGE_MM), u_um: 1e3 * u, left_out: None })
    }

    /// A length, a cone's diameter or a radius, by the lines and arcs that the frames show.
    fn size(&mut self, cut: &Cut<'_>, slides: &dyn Fn(usize) -> DVec2) -> Result<Measured, WornToolError> {
        let job = job_of(&self.jobs.profiles, cut, slides)?;
        let mut turning = start(&job, self.renderer, self.profiles.take())?;
        let calibration = turning.calibration().clone();
        self.profiles = Some(calibration.clone());
        let Calibrated::Camera(camera) = &calibration else {
            return Err(LoopError::OtherInstrument("the camera").into());
        };
        let size = SizeOfFrames { workpiece: cut.workpiece, cone_rad: cut.cone_rad() };
        let mut seen: Vec<Result<Seen, WornToolError>> = Vec::new();
        turning.cut_and_look(&mut |frame, edges| seen.push(size.see(frame, edges, camera)))?;
        let seen = seen.into_iter().collect::<Result<Vec<Seen>, WornToolError>>()?;
        size.of_part(&seen, camera)
    }
}

/// A loop of one part, calibrated unless its calibration is known.
fn start<'a>(
    job: &Job,
    renderer: &'a Renderer,
    known: Option<Calibrated>,
) -> Result<ClosedLoop<'a>, WornToolError> {
    let cell = SimulatedCell::new(job, renderer).map_err(LoopError::from)?;
    Ok(ClosedLoop::start(job.checked_loop()?, Box::new(cell), known)?)
}

/// A job with the tool as known to the program, and with what really cuts.
fn job_of(job: &Job, cut: &Cut<'_>, slides: &dyn Fn(usize) -> DVec2) -> Result<Job, WornToolError> {
    let CuttingData { speed_m_per_min, feed_mm_per_rev } = job.cutting;
    let contour = cut.workpiece.corners(cut.cone_rad(), &cut.edit()?);
    let largest = contour.iter().map(|p| p.diameter_mm).fold(0.0, f64::max);
    let mut job = job.clone();
    job.part.length_mm = contour[contour.len() - 1].z_mm;
    job.part.nominal_diameter_mm = vec![largest];
    job.part.stock_diameter_mm = largest + ALLOWANCE_MM;
    job.shaft.contour = contour;
    let mut file = cut.noses.tool;
    let stated = cut.stated();
    (file.setting.x_extent_mm, file.setting.z_extent_mm) = (stated.x_mm, stated.z_mm);
    file.register_mm = cut.register_mm();
    // the nose was worn, and is measured, by cuts like those before compensation
    let depth_mm = Some(0.5 * ALLOWANCE_MM);
    file.measured_pass = Some(MeasuredPass { speed_m_per_min, feed_mm_per_rev, depth_mm });
    let truth = Some(cut.truth(slides));
    let mut tool = RunTool { stated: Some(file), way: cut.program.way(), truth, ..RunTool::default() };
    tool.take_nose(&cut.noses.document).map_err(|e: SettingError| WornToolError::Nose(e.to_string()))?;
    job.tool = Some(tool);
    Ok(job)
}
