//! Scenes and frame numbers of the simulated cell one by one, for a head that is asked for single
//! frames: the same as those of a scan.

use super::simulated::{MASTER_STREAM, SimulatedCell, hand_poses};
use crate::render::{OpticalSetup, RenderError, Scene};
use crate::shaft::Shaft;

impl SimulatedCell<'_> {
    /// The part in its present state before an optical setup: the cell's own gives the scenes
    /// of a scan.
    ///
    /// # Errors
    /// Where the part exceeds the field.
    pub(crate) fn part_scene(&self, setup: &OpticalSetup) -> Result<Scene, RenderError> {
        Scene::new(setup, self.process.as_scanned(&self.part))
    }

    /// Master pin `index` as it lies for frame `frame` (from 0) of a look at it; `None` where the
    /// job has no such pin.
    ///
    /// # Errors
    /// Where the pin exceeds the field.
    pub(crate) fn master_scene(
        &self,
        setup: &OpticalSetup,
        index: usize,
        frame: usize,
    ) -> Result<Option<Scene>, RenderError> {
        let Some(diameter_mm) = self.masters.diameter_mm.get(index) else { return Ok(None) };
        let again = u64::from(self.pass) << 40;
        let stream = MASTER_STREAM ^ ((index as u64 + 1) << 48) ^ again;
        // poses are drawn one after another: the last of so many is that of this frame
        let Some(pose) = hand_poses(frame + 1, self.batch.seed() ^ stream).pop() else { return Ok(None) };
        Scene::new(setup, Shaft { pose, ..Shaft::cylinder(*diameter_mm) }).map(|scene| Some(scene.wiped()))
    }

    /// Number of the part's next frame, which is taken: with the seed it gives the noise.
    pub(crate) fn next_part_frame(&mut self) -> u64 {
        let number = self.next.id;
        self.next.id += 1;
        number
    }

    /// Number of frame `frame` (from 0) of the part since its last pass; none is taken.
    pub(crate) fn part_frame(&self, frame: u64) -> u64 {
        self.first_frame_id() + frame
    }

    /// Number of frame `frame` (from 0) of a look at a pin.
    pub(crate) fn master_frame(&self, index: usize, frame: usize) -> u64 {
        self.first_frame_id() + (1 << 31) + ((index as u64) << 24) + frame as u64
    }

    /// The true optical setup.
    #[cfg(test)]
    pub(crate) fn setup(&self) -> &OpticalSetup {
        &self.setup
    }

    /// Seed of the current part's frames.
    pub(crate) fn seed(&self) -> u64 {
        self.batch.seed()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::turning_cell::TurningCell as _;
    use crate::frame::{Frame, FrameSource};
    use crate::job::Job;
    use crate::plan::{DiameterOffset, ScanPlan};
    use crate::render::{BackendChoice, FrameRequest, Renderer};

    fn all(source: &mut dyn FrameSource) -> Vec<Frame> {
        std::iter::from_fn(|| source.next_frame().unwrap()).collect()
    }

    /// Frames that are ordered one by one are those of a scan and of a look at a pin, to the bit.
    #[test]
    fn ordered_frames_are_those_of_scans() {
        let mut job: Job = toml::from_str(include_str!("../../configs/small_shaft.toml")).unwrap();
        (job.camera.columns, job.camera.rows, job.optics.magnification) = (64, 256, 0.0575);
        let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
        let mut scanned = SimulatedCell::new(&job, &renderer).unwrap();
        let mut ordered = SimulatedCell::new(&job, &renderer).unwrap();
        let plan = job.loop_job().pass_plan(1, DiameterOffset::zero(job.loop_job().station_z_mm().len()));
        scanned.cut(&plan).unwrap();
        ordered.cut(&plan).unwrap();
        let scan = ScanPlan { field_z_mm: vec![20.0], angle_deg: vec![0.0, 45.0] };
        let wanted = all(scanned.scan(&scan).unwrap().as_mut());
        let request = |frame_id, z_mm, angle_deg, seed| FrameRequest {
            frame_id,
            z_mm,
            angle_deg,
            noise: true,
            seed,
            ..FrameRequest::default()
        };
        for (frame, angle_deg) in wanted.iter().zip([0.0, 45.0]) {
            let scene = ordered.part_scene(&ordered.setup().clone()).unwrap();
            let counted = ordered.next_part_frame();
            assert_eq!(counted, ordered.part_frame(counted - ordered.part_frame(0)));
            let request = request(counted, 20.0, angle_deg, ordered.seed());
            let single = renderer.render(&scene, &request, None).unwrap();
            assert_eq!(single.clone().into_buffer(), frame.clone().into_buffer());
        }
        let wanted = all(scanned.scan_master(1, 2).unwrap().as_mut());
        for (k, frame) in wanted.iter().enumerate() {
            let scene = ordered.master_scene(&ordered.setup().clone(), 1, k).unwrap().unwrap();
            let request = request(ordered.master_frame(1, k), 0.0, 0.0, ordered.seed());
            let single = renderer.render(&scene, &request, None).unwrap();
            assert_eq!(single.into_buffer(), frame.clone().into_buffer());
        }
        assert!(ordered.master_scene(&ordered.setup().clone(), 2, 0).unwrap().is_none());
    }
}
