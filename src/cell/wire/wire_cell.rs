//! The cell of a head on the wire: pass plans out, what stands before the camera, frames in.

use std::time::Duration;

use super::wire_frames::{Numbers, Stop, WireFrames};
use crate::cell::simulated::FRAMES_OF_A_PASS;
use crate::cell::turning_cell::{CellError, TurningCell};
use crate::control::PartAndTool;
use crate::frame::FrameSource;
use crate::plan::{PassPlan, ScanPlan};
use crate::source::commanded::{CommandedHead, HeadError};

/// Pause between two looks whether a pass is cut: a hundredth of a second in a cut of some seconds.
const PAUSE: Duration = Duration::from_millis(10);

/// What stands before the camera, by the entries of `HeadObject`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Object {
    Part,
    Master,
}

/// A head with its process in another program.
pub(crate) struct WireCell {
    head: Box<dyn CommandedHead>,
    /// What the head is called in errors.
    name: String,
    of: PartAndTool,
    /// What frames are acquired of; `None` while none are.
    object: Option<Object>,
    /// Number of the last pass; 0 before the first.
    pass: u32,
    /// Number of the next frame of the part since the pass, and of the pin, from 0.
    of_part: u64,
    of_pin: u64,
}

impl WireCell {
    /// A cell with a new blank clamped; `name` is what the head is called in errors, `part` what
    /// the job calls its part.
    ///
    /// # Errors
    /// A head that refuses, or is gone.
    pub(crate) fn new(head: Box<dyn CommandedHead>, name: &str, part: &str) -> Result<Self, CellError> {
        // the first part of a batch and its first insert, as in the simulated cell: the head
        // changes neither
        let of = PartAndTool { part: format!("{part}, part 1"), tool: "T1, insert 1".to_owned() };
        let (name, object) = (name.to_owned(), None);
        let mut cell = Self { head, name, of, object, pass: 0, of_part: 0, of_pin: 0 };
        let begun = cell.begin();
        begun.map_err(|why| cell.named("the blank", &why))?;
        Ok(cell)
    }

    fn begin(&mut self) -> Result<(), HeadError> {
        for (feature, entry) in
            [("TriggerSelector", "FrameStart"), ("TriggerSource", "Software"), ("TriggerMode", "On")]
        {
            self.head.set_until_end(feature, entry)?;
        }
        self.order(0)
    }

    /// Has a pass cut, or a blank clamped (0), and waits until it is.
    fn order(&mut self, pass: u32) -> Result<(), HeadError> {
        self.head.set("PassNumber", &pass.to_string())?;
        self.head.execute("PassCut")?;
        loop {
            match self.head.value("PassState").as_deref() {
                Some("Cut") => return Ok(()),
                Some("Cutting") => std::thread::sleep(PAUSE),
                Some("Refused") => {
                    let why = self.head.value("HeadMessage").unwrap_or_default();
                    return Err(HeadError::Refused(why));
                }
                other => {
                    self.head.check()?;
                    let why = format!("PassState is {}", other.unwrap_or("not stated"));
                    return Err(HeadError::NotExecuted { command: "PassCut".to_owned(), why });
                }
            }
        }
    }

    fn cut_pass(&mut self, plan: &PassPlan) -> Result<(), HeadError> {
        for (station, offset_mm) in plan.offset.o_mm.iter().enumerate() {
            self.head.set("PassStation", &station.to_string())?;
            self.head.set("PassOffset", &offset_mm.to_string())?;
        }
        self.order(plan.pass)
    }

    /// Begins to acquire frames of an object; `HeadObject` is set at rest.
    fn look_at(&mut self, object: Object) -> Result<(), HeadError> {
        if self.object == Some(object) {
            return Ok(());
        }
        if self.object.take().is_some() {
            self.head.stop()?;
        }
        self.head.set_until_end("HeadObject", &format!("{object:?}"))?;
        self.head.start()?;
        self.object = Some(object);
        Ok(())
    }

    fn look_at_pin(&mut self, index: usize) -> Result<(), HeadError> {
        self.look_at(Object::Master)?;
        // writing it clamps the pin anew
        self.head.set("MasterIndex", &index.to_string())
    }

    /// An error with the head and what was asked of it.
    fn named(&self, what: &str, why: &HeadError) -> CellError {
        CellError::Refused(format!("{}: {what}: {why}", self.name).into())
    }

    /// Frame ids of a pass, from those of its first frame on: as in the simulated cell.
    fn first_frame_id(&self) -> u64 {
        u64::from(self.pass) * FRAMES_OF_A_PASS
    }
}

impl TurningCell for WireCell {
    fn cut(&mut self, plan: &PassPlan) -> Result<(), CellError> {
        self.cut_pass(plan).map_err(|why| self.named(&format!("pass {}", plan.pass), &why))?;
        (self.pass, self.of_part) = (plan.pass, 0);
        Ok(())
    }

    fn scan(&mut self, plan: &ScanPlan) -> Result<Box<dyn FrameSource + '_>, CellError> {
        self.look_at(Object::Part).map_err(|why| self.named("the scan", &why))?;
        let stop = |z_mm| plan.angle_deg.iter().map(move |&angle_deg| Stop { z_mm, angle_deg });
        let stops: Vec<Stop> = plan.field_z_mm.iter().flat_map(|&z_mm| stop(z_mm)).collect();
        let first_id = self.first_frame_id();
        let numbers = Numbers { first_id, next: &mut self.of_part };
        Ok(Box::new(WireFrames::new(self.head.as_mut(), &self.name, stops, numbers)))
    }

    fn scan_master(&mut self, index: usize, frames: usize) -> Result<Box<dyn FrameSource + '_>, CellError> {
        self.look_at_pin(index).map_err(|why| self.named(&format!("master pin {}", index + 1), &why))?;
        let stops = vec![Stop { z_mm: 0.0, angle_deg: 0.0 }; frames];
        let first_id = self.first_frame_id() + (1 << 31) + ((index as u64) << 24);
        self.of_pin = 0;
        let numbers = Numbers { first_id, next: &mut self.of_pin };
        Ok(Box::new(WireFrames::new(self.head.as_mut(), &self.name, stops, numbers)))
    }

    fn in_machine(&self) -> Option<PartAndTool> {
        Some(self.of.clone())
    }

    fn now_ns(&self) -> Option<u64> {
        self.head.now_ns()
    }

    fn true_stations_mm(&self, _stations_mm: &[(f64, f64)]) -> Option<Vec<f64>> {
        None
    }
}
