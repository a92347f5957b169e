//! The simulated head as a live source: a job's drawn shaft, frame after frame, rendered ahead on
//! the source's own thread.

use std::time::{Duration, Instant};

use super::drawn_scan::{drawn_scene, scan_request};
use crate::frame::Frame;
use crate::job::Job;
use crate::plan::ScanPlan;
use crate::render::{RenderError, Renderer, Scene};
use crate::source::host_t_ns;
use crate::source::live::{Clock, Known, LiveMeta, NewFrame, Produced, Producer, Remarks, Timestamp};

/// When the frames of a simulated head come, and how many.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HeadPace {
    /// Those of one scan, as fast as they are rendered.
    Scan,
    /// One a period of the camera at most, scan after scan.
    Live,
}

/// A simulated head.
pub(crate) struct SimulatedHead {
    renderer: Renderer,
    scene: Scene,
    job: Job,
    plan: ScanPlan,
    pace: HeadPace,
    next: usize,
    /// When the next frame is due; `None` at once.
    due: Option<Instant>,
    spare: Option<Frame>,
}

impl SimulatedHead {
    /// The head of a job.
    ///
    /// # Errors
    /// Where optics or shaft are refused.
    pub(crate) fn new(job: Job, renderer: Renderer, pace: HeadPace) -> Result<Self, RenderError> {
        let (scene, plan) = (drawn_scene(&job)?, job.loop_job().scan_plan());
        Ok(Self { renderer, scene, job, plan, pace, next: 0, due: None, spare: None })
    }

    /// Waits until the next frame is due, no longer than `wait`; whether it is.
    fn wait_until_due(&self, wait: Duration) -> bool {
        let Some(due) = self.due.filter(|_| self.pace == HeadPace::Live) else { return true };
        let left = due.saturating_duration_since(Instant::now());
        std::thread::sleep(left.min(wait));
        left <= wait
    }

    fn meta(&self, frame: &Frame) -> LiveMeta {
        let of = &frame.meta;
        LiveMeta {
            sequence: of.frame_id,
            device_t: Some(Timestamp { t_ns: of.t_ns, clock: Clock::Simulated }),
            exposed_t: None,
            host_t: Some(Timestamp { t_ns: host_t_ns(), clock: Clock::Host }),
            exposure_us: Some(Known::simulated(of.exposure_us)),
            gain_db: None,
            angle_deg: Some(Known::simulated(of.angle_deg)),
            u_angle_deg: None,
            z_mm: Some(Known::simulated(of.z_mm)),
            head_c: None,
        }
    }
}

impl Producer for SimulatedHead {
    fn produce(&mut self, spare: Option<Frame>, wait: Duration) -> Produced {
        self.spare = spare.or(self.spare.take());
        if self.pace == HeadPace::Scan && self.next >= self.plan.frames() {
            return Produced::End(None);
        }
        if !self.wait_until_due(wait) {
            return Produced::Nothing;
        }
        let request = scan_request(&self.job, &self.plan, self.next);
        // A renderer that is slower than the camera does not catch up: no two frames are closer
        // than a period.
        self.due = Some(Instant::now() + Duration::from_secs_f64(self.job.camera.period_ms() * 1e-3));
        match self.renderer.render(&self.scene, &request, self.spare.take()) {
            Ok(frame) => {
                self.next += 1;
                let (meta, remarks) = (self.meta(&frame), Remarks::default());
                Produced::Frame(Box::new(NewFrame { frame, meta, remarks }))
            }
            Err(error) => Produced::End(Some(format!(
                "frame {} (z = {:.3} mm, {:.1}°) was not rendered: {error}",
                request.frame_id, request.z_mm, request.angle_deg
            ))),
        }
    }

    fn start(&mut self) {
        self.due = None;
    }
}
