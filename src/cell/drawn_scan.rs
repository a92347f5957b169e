//! The scan of a job's drawn shaft: the scene, and a request a frame.

use crate::job::Job;
use crate::plan::ScanPlan;
use crate::render::form::form_shaft;
use crate::render::{FrameRequest, OpticalSetup, RenderError, Scene};
use crate::shaft::{ProfileKnot, ShaftForm};

/// The scene of a job: its shaft at the last pass's nominal diameter with the form of `[shaft]`,
/// and with the surface that a measured nose of `[tool]` leaves of its contour.
///
/// # Errors
/// Where optics or shaft are refused, or the tool cannot turn the contour.
pub fn drawn_scene(job: &Job) -> Result<Scene, RenderError> {
    let setup = OpticalSetup::resolve(&job.setup_settings(), job.seed)?;
    let shaft = match job.worn_profile()? {
        Some(worn) => {
            let form = ShaftForm { contour: Vec::new(), ..job.shaft.clone() };
            form_shaft(worn, &form, job.part.length_mm, job.seed)?
        }
        None => {
            let plain = vec![ProfileKnot { z_mm: 0.0, radius_mm: job.part.drawn_diameter_mm() / 2.0 }];
            form_shaft(plain, &job.shaft, job.part.length_mm, job.seed)?
        }
    };
    Scene::new(&setup, shaft)
}

/// Request number `index` of a job's scan, starting over at its end: with noise, in the sensor's
/// own format, one frame a camera period.
pub fn scan_request(job: &Job, plan: &ScanPlan, index: usize) -> FrameRequest {
    let angles = plan.angle_deg.len().max(1);
    let place = index % plan.frames().max(1);
    let windows = job.camera.windows.map(|w| w.rois(job.camera.columns));
    FrameRequest {
        frame_id: index as u64,
        t_ns: (index as f64 * job.camera.period_ms() * 1e6) as u64,
        z_mm: plan.field_z_mm.get(place / angles).copied().unwrap_or(0.0),
        angle_deg: plan.angle_deg.get(place % angles).copied().unwrap_or(0.0),
        noise: true,
        roi: windows.map(|w| w[0]),
        second_roi: windows.map(|w| w[1]),
        seed: job.seed,
        format: None,
    }
}
