//! The simulated pass with the gauge behind the tool: every frame shows the shaft as it is bent at
//! that instant.

use super::seen_burst::SeenBurst;
use super::simulated::{NextFrame, SimulatedCell};
use super::turning_cell::{CellError, FollowedCut, TurningCell as _};
use crate::frame::{Frame, FrameSource, SourceError};
use crate::job::HeadView;
use crate::plan::{DiameterOffset, FollowFrame, FollowPlan, PassPlan};
use crate::process::FollowedPass;
use crate::render::{FrameRequest, OpticalSetup, RenderError, Scene};

/// A pass of the simulated cell under way.
pub(super) struct SimulatedCut<'c, 'r> {
    cell: &'c mut SimulatedCell<'r>,
    plan: PassPlan,
    follow: FollowPlan,
    /// The optical setup with spindle and carriage in motion.
    setup: OpticalSetup,
    pass: FollowedPass,
    next: usize,
    begun_ns: u64,
    spare: Option<Frame>,
}

impl<'c, 'r> SimulatedCut<'c, 'r> {
    pub(super) fn begin(
        cell: &'c mut SimulatedCell<'r>,
        plan: &PassPlan,
        follow: &FollowPlan,
    ) -> Result<Self, CellError> {
        let pass = cell.process.followed(plan)?;
        cell.begin_pass(plan.pass);
        cell.followed = follow.rest.field_z_mm.iter().map(|z_mm| SeenBurst::clear(*z_mm)).collect();
        let mut setup = cell.setup.clone();
        setup.nominal.motion.spindle_rpm = follow.spindle_rpm;
        setup.nominal.motion.carriage_mm_s = follow.carriage_mm_s;
        let begun_ns = cell.next.t_ns;
        let (plan, follow) = (plan.clone(), follow.clone());
        Ok(Self { cell, plan, follow, setup, pass, next: 0, begun_ns, spare: None })
    }

    fn time_ns(&self, turns: f64) -> u64 {
        self.begun_ns + (turns / self.follow.spindle_rpm * 60e9) as u64
    }

    fn draw(&mut self, at: &FollowFrame) -> Result<Frame, RenderError> {
        let shaft = self.cell.clamped(self.pass.at(at.tool_z_mm));
        let burst_begins = self.next.is_multiple_of(self.follow.burst.max(1));
        if burst_begins || self.cell.followed.is_empty() {
            self.cell.followed.push(SeenBurst::default());
        }
        if let Some(burst) = self.cell.followed.last_mut() {
            burst.add(at.field_z_mm, &shaft);
        }
        let view = self.cell.lathe.as_ref().map(|lathe| lathe.head(at.field_z_mm));
        let shaft = match &view {
            Some(view) => view.seen(shaft),
            None => shaft,
        };
        let scene = Scene::new(&self.setup, shaft)?;
        let camera = &self.setup.nominal.camera;
        let windows = camera.windows.map(|w| w.rois(camera.columns));
        let request = FrameRequest {
            frame_id: self.cell.next.id,
            t_ns: self.time_ns(at.turns),
            z_mm: view.as_ref().map_or(at.field_z_mm, HeadView::z_mm),
            angle_deg: view.as_ref().map_or(at.angle_deg, |view| view.angle_deg(at.angle_deg)),
            noise: true,
            roi: windows.map(|w| w[0]),
            second_roi: windows.map(|w| w[1]),
            format: None,
            seed: self.cell.batch.seed(),
        };
        let mut frame = self.cell.renderer.render(&scene, &request, self.spare.take())?;
        (frame.meta.z_mm, frame.meta.angle_deg) = (at.field_z_mm, at.angle_deg);
        Ok(frame)
    }
}

impl FrameSource for SimulatedCut<'_, '_> {
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        let Some(&at) = self.follow.frames.get(self.next) else { return Ok(None) };
        let frame = self.draw(&at).map_err(|e| SourceError {
            what: format!("frame {} (tool at {:.1} mm) was not rendered", self.cell.next.id, at.tool_z_mm),
            cause: Some(Box::new(e)),
        })?;
        self.next += 1;
        self.cell.next.id += 1;
        self.cell.next.t_ns = self.time_ns(at.turns);
        Ok(Some(frame))
    }

    fn remaining(&self) -> Option<usize> {
        Some(self.follow.frames.len() - self.next)
    }

    fn recycle(&mut self, frame: Frame) {
        self.spare = Some(frame);
    }
}

impl FollowedCut for SimulatedCut<'_, '_> {
    fn tool_z_mm(&self) -> f64 {
        let seen = self.next.saturating_sub(1);
        self.follow.frames.get(seen).map_or(f64::NAN, |f| f.tool_z_mm)
    }

    fn now_ns(&self) -> Option<u64> {
        Some(self.cell.next.t_ns)
    }

    fn command(&mut self, offset: &DiameterOffset) -> Result<(), CellError> {
        let plan = PassPlan { offset: offset.clone(), ..self.plan.clone() };
        // The cut is causal along the feed: the diameters behind the tool do not change.
        self.pass = self.cell.process.followed(&plan)?;
        self.plan = plan;
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), CellError> {
        let turns = self.cell.process.length_mm() / self.plan.cutting.feed_mm_per_rev;
        let left = NextFrame { id: self.cell.next.id, t_ns: self.time_ns(turns) };
        let followed = std::mem::take(&mut self.cell.followed);
        self.cell.cut(&self.plan)?;
        self.cell.followed = followed;
        self.cell.next = left;
        Ok(())
    }
}
