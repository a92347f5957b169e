//! A camera before which an operator lays the pins.

use std::time::{Duration, Instant};

use super::asked::{INTERRUPTED, Operator};
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
    operator: Operator,
    /// Whether each frame needs a software trigger.
    is_triggered: bool,
}

impl AskedCamera {
    /// An open camera.
    ///
    /// # Errors
    /// A system without another thread.
    pub(super) fn new(camera: Box<dyn CommandedHead>, name: &str) -> std::io::Result<Self> {
        let is = |feature: &str, entry: &str| camera.value(feature).is_some_and(|value| value == entry);
        let is_triggered = is("TriggerMode", "On") && is("TriggerSource", "Software");
        Ok(Self { is_triggered, camera, name: name.to_owned(), operator: Operator::new()? })
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
