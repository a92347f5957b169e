//! Images of files and pipes as a producer of live frames.

use std::time::Duration;

use super::event::Remarks;
use super::metadata::{Clock, Known, LiveMeta, Timestamp};
use super::producer::{NewFrame, Produced, Producer};
use crate::frame::{Frame, FrameMeta};
use crate::source::ahead::{Ahead, Within};
use crate::source::stored::{Arrival, StoredFrame};

/// Frames that are decoded ahead, numbered as they come. One that cannot be read is incomplete.
pub(crate) struct StoredProducer {
    frames: Ahead,
    next: u64,
    /// The frame after the numbers that its source lost.
    held: Option<Box<NewFrame>>,
}

impl StoredProducer {
    /// Frames whose places and times stand in a table.
    pub(crate) fn new(frames: Ahead) -> Self {
        Self { frames, next: 0, held: None }
    }

    fn new_frame(&mut self, arrival: Arrival, stored: StoredFrame) -> NewFrame {
        let meta = self.meta(&arrival, &stored.frame.meta);
        let StoredFrame { stem, frame, scale, changed } = stored;
        NewFrame { frame, meta, remarks: Remarks { stem, scale, changed, notices: arrival.notices } }
    }

    /// A table that leaves a column out has zeros there; without a time it has no row.
    fn meta(&self, arrival: &Arrival, of: &FrameMeta) -> LiveMeta {
        let known = |value: f64| arrival.device_t_ns.map(|_| Known::stated(value));
        LiveMeta {
            sequence: self.next,
            device_t: arrival.device_t_ns.map(|t_ns| Timestamp { t_ns, clock: Clock::Table }),
            exposed_t: None,
            host_t: arrival.host_t_ns.map(|t_ns| Timestamp { t_ns, clock: Clock::Host }),
            exposure_us: known(of.exposure_us).filter(|exposure| exposure.value > 0.0),
            gain_db: None,
            angle_deg: known(of.angle_deg),
            u_angle_deg: None,
            z_mm: known(of.z_mm),
            head_c: None,
        }
    }
}

impl Producer for StoredProducer {
    fn produce(&mut self, spare: Option<Frame>, wait: Duration) -> Produced {
        if let Some(spare) = spare {
            self.frames.give_back(spare);
        }
        if let Some(frame) = self.held.take() {
            return Produced::Frame(frame);
        }
        match self.frames.next_within(wait) {
            Within::Nothing => Produced::Nothing,
            Within::End(failure) => Produced::End(failure.map(|error| error.to_string())),
            Within::Frame(frame) => {
                let (arrival, stored) = *frame;
                let lost = arrival.lost;
                self.next += lost;
                let produced = match stored {
                    Ok(stored) => Produced::Frame(Box::new(self.new_frame(arrival, stored))),
                    Err(error) => Produced::Incomplete(self.next, error.to_string()),
                };
                self.next += 1;
                match produced {
                    // Frames lost before the first one leave a gap, too.
                    Produced::Frame(frame) if lost > 0 => {
                        let number = frame.meta.sequence;
                        self.held = Some(frame);
                        Produced::Missing(number)
                    }
                    other => other,
                }
            }
        }
    }
}
