//! The commands of the simulated cell: cut, scan, touch, change the part.

use super::in_process::SimulatedCut;
use super::moved_head::Shown;
use super::seen_burst::{axis_of, axis_seen};
use super::simulated::{Acquisition, Batch, MASTER_STREAM, PROCESS_STREAM, SimulatedCell, hand_poses};
use super::true_probe::Target;
use super::turning_cell::{CellError, FollowedCut, SeenStation, TrueAxis, TurningCell};
use crate::control::{PartAndTool, PartEvent};
use crate::frame::FrameSource;
use crate::plan::{CutSummary, FollowPlan, PassPlan, ScanPlan};
use crate::probe::{Touch, TouchOrder};
use crate::render::silhouette::Outline;
use crate::render::{RenderError, Scene};
use crate::shaft::Shaft;
use crate::truth;

/// Time from touch to touch, ns: a path of 2 mm at 50 mm/min and back, 4.8 s.
const TOUCH_NS: u64 = 5_000_000_000;

impl TurningCell for SimulatedCell<'_> {
    fn cut(&mut self, plan: &PassPlan) -> Result<(), CellError> {
        let cut = self.process.cut(plan)?;
        self.part = self.clamped(cut);
        self.begin_pass(plan.pass);
        Ok(())
    }

    fn scan(&mut self, plan: &ScanPlan) -> Result<Box<dyn FrameSource + '_>, CellError> {
        let part = self.process.as_scanned(&self.part);
        let shown = match &self.lathe {
            Some(lathe) => Shown::moved(lathe.clone(), self.setup.clone(), part),
            None => Shown::Scenes(vec![Scene::new(&self.setup, part)?]),
        };
        let stops =
            plan.field_z_mm.iter().flat_map(|&z| plan.angle_deg.iter().map(move |&a| (z, a))).collect();
        Ok(self.acquire(shown, stops, Acquisition::Part))
    }

    fn scan_master(&mut self, index: usize, frames: usize) -> Result<Box<dyn FrameSource + '_>, CellError> {
        let diameter_mm = self.masters.diameter_mm[index];
        // at the calibration the seed alone gives the poses of a pin; at a check after a pass they
        // differ
        let again = u64::from(self.pass) << 40;
        let poses =
            hand_poses(frames, self.batch.seed() ^ MASTER_STREAM ^ ((index as u64 + 1) << 48) ^ again);
        let scenes: Result<Vec<Scene>, RenderError> = poses
            .into_iter()
            .map(|pose| {
                Scene::new(&self.setup, Shaft { pose, ..Shaft::cylinder(diameter_mm) }).map(Scene::wiped)
            })
            .collect();
        self.masters.frame_id = self.first_frame_id() + (1 << 31) + ((index as u64) << 24);
        let stops = (0..frames).map(|_| (0.0, 0.0)).collect();
        Ok(self.acquire(Shown::Scenes(scenes?), stops, Acquisition::Master))
    }

    fn touch(&mut self, master: Option<usize>, orders: &[TouchOrder]) -> Result<Vec<Touch>, CellError> {
        self.touches(master, orders)
    }

    fn cut_followed(
        &mut self,
        plan: &PassPlan,
        follow: &FollowPlan,
    ) -> Result<Box<dyn FollowedCut + '_>, CellError> {
        Ok(Box::new(SimulatedCut::begin(self, plan, follow)?))
    }

    fn last_cut(&self) -> Option<CutSummary> {
        self.process.last_cut().cloned()
    }

    fn true_axis(&self, seen: &[SeenStation]) -> Option<TrueAxis> {
        Some(axis_seen(&self.followed, axis_of(&self.part), self.batch.stock.length_mm, seen))
    }

    fn next_part(&mut self, part: u64, event: PartEvent) -> Result<(), CellError> {
        match event {
            PartEvent::Continued => {}
            PartEvent::InsertChanged => {
                self.process.change_insert();
                self.batch.insert += 1;
            }
            PartEvent::ColdStart => self.process.cool_down(),
        }
        self.batch.part = part;
        self.process = self.process.next_blank(self.batch.stock, self.batch.seed() ^ PROCESS_STREAM)?;
        self.part = self.clamped(self.process.blank());
        self.begin_pass(0);
        Ok(())
    }

    fn in_machine(&self) -> Option<PartAndTool> {
        let Batch { name, part, insert, .. } = &self.batch;
        Some(PartAndTool {
            part: format!("{name}, part {}", part + 1),
            tool: format!("T1, insert {}", insert + 1),
        })
    }

    fn now_ns(&self) -> Option<u64> {
        Some(self.next.t_ns)
    }

    fn true_stations_mm(&self, stations_mm: &[(f64, f64)]) -> Option<Vec<f64>> {
        truth::station_diameters_mm(&self.part, stations_mm).ok()
    }
}

impl SimulatedCell<'_> {
    /// Touches the part or a master pin, in the order requested.
    fn touches(&mut self, master: Option<usize>, orders: &[TouchOrder]) -> Result<Vec<Touch>, CellError> {
        let Some(probe) = self.probe.clone() else { return Err(CellError::NoProbe) };
        let shaft = match master {
            Some(index) => Shaft::cylinder(self.masters.diameter_mm[index]),
            None => self.part.clone(),
        };
        let outline = Outline::new(shaft)?;
        let target = Target {
            outline: &outline,
            warmth_c: if master.is_some() { probe.master_c } else { probe.part_c },
            is_part: master.is_none(),
            drift_mm: probe.drift_mm(self.pass),
        };
        let base = self.first_frame_id();
        let mut next = match master {
            Some(index) => base + (1 << 31) + ((index as u64) << 24),
            None => self.next.id,
        };
        let mut touches = Vec::with_capacity(orders.len());
        for order in orders {
            self.next.t_ns += TOUCH_NS;
            touches.push(Touch {
                order: *order,
                id: next,
                t_ns: self.next.t_ns,
                x_mm: probe.touch(&target, order, next),
            });
            next += 1;
        }
        if master.is_none() {
            self.next.id = next;
        }
        Ok(touches)
    }
}
