//! A camera before which an operator lays the pins.

use std::time::{Duration, Instant};

use super::asked::{Asks, INTERRUPTED};
use crate::frame::Frame;
use crate::source::commanded::{Arrived, CommandedHead, HeadError};

/// Wait for a frame before it is looked whether Ctrl-C ended the command.
const LOOK: Duration = Duration::from_millis(250);
/// Silence that shows that no frame of an earlier step is on its way: twice the time after which
/// the receiver closes a frame whose packets cease.
const QUIET: Duration = Duration::from_millis(200);
/// Longest wait for a frame, as of a source that is watched.
const LONGEST: Duration = Duration::from_secs(8);
/// Frames that arrive in part for each one that is wanted, before the step fails: of a link that
/// loses one frame of ten the chance is 10⁻⁸.
const MOST_INCOMPLETE: usize = 8;

/// A camera whose scene an operator changes.
pub(super) struct AskedCamera {
    camera: Box<dyn CommandedHead>,
    name: String,
    operator: Box<dyn Asks>,
    /// Whether each frame needs a software trigger.
    is_triggered: bool,
}

impl AskedCamera {
    /// An open camera, and who lays pins before it.
    pub(super) fn new(camera: Box<dyn CommandedHead>, name: &str, operator: Box<dyn Asks>) -> Self {
        let is = |feature: &str, entry: &str| camera.value(feature).is_some_and(|value| value == entry);
        let is_triggered = is("TriggerMode", "On") && is("TriggerSource", "Software");
        Self { is_triggered, camera, name: name.to_owned(), operator }
    }

    /// Asks for a step, then takes frames of it; frames that are not whole are taken again. Without
    /// a step the scene is that of the last one.
    ///
    /// # Errors
    /// A step that is not confirmed, frames that do not come, a camera that is gone: as text.
    pub(super) fn frames(&mut self, step: Option<&str>, count: usize) -> Result<Vec<Frame>, String> {
        step.map_or(Ok(()), |step| self.operator.ask(step))?;
        let taken = self.drain().and_then(|()| self.take(count));
        let stopped = self.camera.stop();
        let named = |why: String| if why == INTERRUPTED { why } else { format!("{}: {why}", self.name) };
        let frames = taken.map_err(&named)?;
        stopped.map_err(|why| named(why.to_string()))?;
        Ok(frames)
    }

    /// Sets the exposure time, µs; it has its own back at the end.
    ///
    /// # Errors
    /// A camera that refuses it, or is gone.
    pub(super) fn expose(&mut self, exposure_us: f64) -> Result<(), HeadError> {
        let feature = self.exposure_name();
        self.camera.set_until_end(feature, &exposure_us.to_string())
    }

    /// Exposure time, µs, where the camera states it.
    pub(super) fn exposure_us(&self) -> Option<f64> {
        self.camera.number(self.exposure_name())
    }

    /// Whether Ctrl-C ended the command.
    pub(super) fn is_interrupted(&self) -> bool {
        self.operator.is_interrupted()
    }

    /// The name of the exposure time: `ExposureTimeAbs` before SFNC 1.5.
    fn exposure_name(&self) -> &'static str {
        let names = ["ExposureTime", "ExposureTimeAbs"];
        names.into_iter().find(|name| self.camera.value(name).is_some()).unwrap_or(names[0])
    }

    /// Leaves out what an earlier step still sends.
    fn drain(&mut self) -> Result<(), String> {
        let begun = Instant::now();
        while begun.elapsed() < LONGEST {
            match self.camera.receive(QUIET).map_err(|why| why.to_string())? {
                Arrived::Nothing => return Ok(()),
                Arrived::Frame(arrived) => self.camera.recycle(arrived.frame),
                Arrived::Incomplete(_) => {}
            }
        }
        Err("it sends frames although its acquisition is stopped".to_owned())
    }

    fn take(&mut self, count: usize) -> Result<Vec<Frame>, String> {
        let words = |why: HeadError| why.to_string();
        self.camera.start().map_err(words)?;
        let (mut frames, mut incomplete) = (Vec::with_capacity(count), 0);
        while frames.len() < count {
            if self.is_triggered {
                self.camera.execute("TriggerSoftware").map_err(words)?;
            }
            match self.next()? {
                Ok(frame) => frames.push(frame),
                Err(why) if incomplete == MOST_INCOMPLETE * count => {
                    return Err(format!("{incomplete} frames were not whole: {why}"));
                }
                Err(_) => incomplete += 1,
            }
        }
        if incomplete > 0 {
            tracing::warn!("{}: {incomplete} frames were not whole, and were taken again", self.name);
        }
        Ok(frames)
    }

    /// The next frame, or why one was not whole.
    fn next(&mut self) -> Result<Result<Frame, String>, String> {
        let begun = Instant::now();
        while begun.elapsed() < LONGEST {
            if self.is_interrupted() {
                return Err(INTERRUPTED.to_owned());
            }
            match self.camera.receive(LOOK).map_err(|why| why.to_string())? {
                Arrived::Frame(arrived) => return Ok(Ok(arrived.frame)),
                Arrived::Incomplete(why) => return Ok(Err(why)),
                Arrived::Nothing => self.camera.check().map_err(|why| why.to_string())?,
            }
        }
        let why = "a firewall, packets larger than the network carries, or a trigger that does not come";
        Err(format!("no frame came for {} s, although it answers: {why}", LONGEST.as_secs()))
    }
}

#[cfg(test)]
mod tests {
    use std::collections::VecDeque;
    use std::sync::{Arc, Mutex};

    use super::*;
    use crate::frame::{Buffer, FrameMeta, PixelFormat};
    use crate::source::commanded::HeadFrame;

    /// What was done, in order.
    type Log = Arc<Mutex<Vec<String>>>;

    /// A camera in memory: what is queued comes, one thing a call.
    struct InMemory {
        queue: VecDeque<Arrived>,
        has_trigger: bool,
        log: Log,
    }

    fn frame(value: u8) -> Arrived {
        let frame =
            Frame::new(Buffer::U8(vec![value]), PixelFormat::Mono8, 1, 1, FrameMeta::default()).unwrap();
        Arrived::Frame(Box::new(HeadFrame { frame, place: None, exposed_ns: None }))
    }

    impl InMemory {
        fn done(&self, what: &str) -> Result<(), HeadError> {
            self.log.lock().unwrap().push(what.to_owned());
            Ok(())
        }
    }

    impl CommandedHead for InMemory {
        fn value(&self, feature: &str) -> Option<String> {
            let value = match feature {
                "TriggerMode" if self.has_trigger => "On",
                "TriggerSource" => "Software",
                "ExposureTimeAbs" => "50",
                _ => return None,
            };
            Some(value.to_owned())
        }

        fn set(&mut self, feature: &str, value: &str) -> Result<(), HeadError> {
            self.done(&format!("{feature} = {value}"))
        }

        fn set_until_end(&mut self, feature: &str, value: &str) -> Result<(), HeadError> {
            self.set(feature, value)
        }

        fn execute(&mut self, command: &str) -> Result<(), HeadError> {
            self.done(command)
        }

        fn start(&mut self) -> Result<(), HeadError> {
            self.done("start")
        }

        fn stop(&mut self) -> Result<(), HeadError> {
            self.done("stop")
        }

        fn receive(&mut self, _wait: Duration) -> Result<Arrived, HeadError> {
            Ok(self.queue.pop_front().unwrap_or(Arrived::Nothing))
        }

        fn check(&self) -> Result<(), HeadError> {
            Ok(())
        }

        fn now_ns(&self) -> Option<u64> {
            None
        }
    }

    /// Confirms every step, or ends the command.
    struct Willing(Log, bool);

    impl Asks for Willing {
        fn ask(&mut self, step: &str) -> Result<(), String> {
            self.0.lock().unwrap().push(step.to_owned());
            Ok(())
        }

        fn is_interrupted(&self) -> bool {
            self.1
        }
    }

    fn camera(queue: Vec<Arrived>, has_trigger: bool, is_interrupted: bool) -> (AskedCamera, Log) {
        let log = Log::default();
        let camera = InMemory { queue: queue.into(), has_trigger, log: Arc::clone(&log) };
        let operator = Box::new(Willing(Arc::clone(&log), is_interrupted));
        (AskedCamera::new(Box::new(camera), "gige:x", operator), log)
    }

    fn values(frames: &[Frame]) -> Vec<Option<f32>> {
        frames.iter().map(|frame| frame.view().get(0, 0)).collect()
    }

    #[test]
    fn frames_of_an_earlier_step_are_left_out_and_those_in_part_are_taken_again() {
        let part = || Arrived::Incomplete("3 packets are missing".to_owned());
        let queue = vec![frame(1), part(), Arrived::Nothing, frame(2), part(), frame(3)];
        let (mut camera, log) = camera(queue, false, false);
        let frames = camera.frames(Some("pin 10: lay it"), 2).unwrap();
        assert_eq!(values(&frames), [Some(2.0), Some(3.0)]);
        assert_eq!(*log.lock().unwrap(), ["pin 10: lay it", "start", "stop"]);
    }

    #[test]
    fn a_camera_that_waits_for_software_triggers_has_one_a_frame() {
        let (mut camera, log) = camera(vec![Arrived::Nothing, frame(2), frame(3)], true, false);
        camera.frames(None, 2).unwrap();
        assert_eq!(*log.lock().unwrap(), ["start", "TriggerSoftware", "TriggerSoftware", "stop"]);
        assert_eq!(camera.exposure_us(), Some(50.0));
        camera.expose(25.0).unwrap();
        assert_eq!(log.lock().unwrap().last().unwrap(), "ExposureTimeAbs = 25");
    }

    #[test]
    fn a_link_that_carries_no_whole_frame_and_an_interruption_end_the_step() {
        let part = || Arrived::Incomplete("its last packet is missing".to_owned());
        let mut queue = vec![Arrived::Nothing];
        queue.extend(std::iter::repeat_with(part).take(100));
        let (mut broken, log) = camera(queue, false, false);
        let why = broken.frames(None, 1).unwrap_err();
        assert!(why.starts_with("gige:x: 8 frames were not whole: its last packet"), "{why}");
        assert_eq!(log.lock().unwrap().last().unwrap(), "stop");
        let (mut ended, log) = camera(vec![Arrived::Nothing, frame(1)], false, true);
        assert_eq!(ended.frames(None, 1).unwrap_err(), INTERRUPTED);
        assert_eq!(log.lock().unwrap().last().unwrap(), "stop");
    }
}
