//! A source that sends what a script states.

use std::collections::VecDeque;
use std::time::Duration;

use shadowgauge::frame::{Buffer, Frame, FrameMeta, PixelFormat};
use shadowgauge::source::live::{IdWidth, LiveMeta, NewFrame, Produced, Producer, Remarks, Unwrapper};

use super::conformance::Factory;

/// A step of a script; ids are those on the wire.
#[derive(Clone, Debug)]
pub(super) enum Step {
    Frame(u64),
    Incomplete(u64),
    /// The ids before this one were sent.
    SentUntil(u64),
    /// The camera is away, and back with ids from its start.
    Away,
    Panic,
}

/// Steps one after another.
pub(super) struct Scripted {
    steps: VecDeque<Step>,
    ids: Unwrapper,
    rows: usize,
}

impl Scripted {
    pub(super) fn boxed(steps: impl IntoIterator<Item = Step>, width: IdWidth) -> Box<dyn Producer> {
        Box::new(Self { steps: steps.into_iter().collect(), ids: Unwrapper::new(width), rows: 4 })
    }

    fn frame(&self, number: u64, spare: Option<Frame>) -> Frame {
        let mut pixels = match spare.map(Frame::into_buffer) {
            Some(Buffer::U8(pixels)) => pixels,
            _ => Vec::new(),
        };
        pixels.clear();
        pixels.resize(self.rows * 3, number as u8);
        Frame::new(Buffer::U8(pixels), PixelFormat::Mono8, self.rows, 3, FrameMeta::default()).unwrap()
    }
}

impl Producer for Scripted {
    fn produce(&mut self, spare: Option<Frame>, _: Duration) -> Produced {
        let Some(step) = self.steps.pop_front() else { return Produced::End(None) };
        match step {
            Step::Frame(id) => {
                let sequence = self.ids.number(id).unwrap();
                let meta = LiveMeta { sequence, ..LiveMeta::default() };
                let remarks = Remarks::default();
                Produced::Frame(Box::new(NewFrame { frame: self.frame(sequence, spare), meta, remarks }))
            }
            Step::Incomplete(id) => {
                Produced::Incomplete(self.ids.number(id).unwrap(), "3 packets of 8".to_owned())
            }
            Step::SentUntil(id) => Produced::Missing(self.ids.number(id).unwrap()),
            Step::Away => {
                self.ids.restart();
                Produced::Lost("no answer for 200 ms".to_owned())
            }
            Step::Panic => panic!("planned"),
        }
    }
}

#[test]
fn the_scripted_source_conforms() {
    let open = |frames: u64| Scripted::boxed((0..frames).map(|n| Step::Frame(n + 1)), IdWidth::GigE16);
    let is_frame = |frame: &Frame, number: u64| frame.view().get(3, 2) == Some(number as f32);
    Factory { open: &open, is_frame: &is_frame }.conforms();
}
