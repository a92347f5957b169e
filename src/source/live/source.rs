//! A producer on its thread, and the consumer's side of it.

use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use super::counters::Counters;
use super::event::{Event, LiveFrame};
use super::pool::Slot;
use super::producer::{NewFrame, Produced, Producer};
use super::queue::{Place, Policy, Queue};

/// Time after which a waiting producer looks whether it is to stop: below what a person notices,
/// and well below the 500 ms in which a camera is to be let go.
const LOOK: Duration = Duration::from_millis(50);

/// Frames from a source that does not wait for anyone, or seems not to.
pub(crate) trait LiveSource: Send {
    /// The next event, after waiting at most so long; [`Event::Timeout`] where there is none.
    fn next_event(&mut self, wait: Duration) -> Event;

    /// What became of the frames so far.
    fn counters(&self) -> Counters;

    /// Ceases to take frames; those that wait are still given, then [`Event::End`].
    fn stop(&mut self);

    /// Goes on after [`Self::stop`] or an end; sequence numbers go on.
    ///
    /// # Errors
    /// A system without another thread.
    fn start(&mut self) -> std::io::Result<()>;
}

/// How a producer's frames are given on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LiveSettings {
    /// What becomes of frames for which there is no place.
    pub policy: Policy,
    /// Most frames that wait, at least 1.
    pub waiting: usize,
    /// Frames that the consumer may hold at once, at least 1.
    pub held: usize,
}

/// A source on a thread of its own.
pub(crate) struct Live {
    queue: Arc<Queue>,
    /// The producer while no thread runs.
    resting: Option<Box<dyn Producer>>,
    thread: Option<JoinHandle<Box<dyn Producer>>>,
}

impl Live {
    /// Starts a producer.
    ///
    /// # Errors
    /// A system without another thread.
    pub(crate) fn new(producer: Box<dyn Producer>, settings: LiveSettings) -> std::io::Result<Self> {
        let queue = Queue::new(settings.policy, settings.waiting, settings.held);
        let mut live = Self { queue, resting: Some(producer), thread: None };
        live.start()?;
        Ok(live)
    }
}

impl LiveSource for Live {
    fn next_event(&mut self, wait: Duration) -> Event {
        self.queue.next_event(wait)
    }

    fn counters(&self) -> Counters {
        self.queue.counters()
    }

    fn stop(&mut self) {
        self.queue.set_stopped(true);
        // A producer that panicked is gone: there is only the end.
        self.resting = self.thread.take().and_then(|thread| thread.join().ok()).or(self.resting.take());
    }

    fn start(&mut self) -> std::io::Result<()> {
        if self.thread.is_some() {
            self.stop();
        }
        let Some(mut producer) = self.resting.take() else { return Ok(()) };
        self.queue.set_stopped(false);
        let queue = Arc::clone(&self.queue);
        let run = move || {
            let ends = EndsQueue(&queue);
            producer.start();
            let failure = pump(producer.as_mut(), &queue);
            producer.stop();
            ends.with(failure);
            producer
        };
        self.thread = Some(std::thread::Builder::new().name("source".to_owned()).spawn(run)?);
        Ok(())
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.stop();
    }
}

/// Ends the queue even where a producer panics, so that the consumer does not wait for ever.
struct EndsQueue<'a>(&'a Queue);

impl EndsQueue<'_> {
    fn with(self, failure: Option<String>) {
        self.0.end(failure);
        std::mem::forget(self);
    }
}

impl Drop for EndsQueue<'_> {
    fn drop(&mut self) {
        self.0.end(Some("the source's thread failed".to_owned()));
    }
}

/// Moves frames from the producer to the queue until either wants no more; why the source failed.
fn pump(producer: &mut dyn Producer, queue: &Queue) -> Option<String> {
    while !queue.is_stopped() {
        let mut slot = match queue.place(LOOK) {
            Place::Free(slot) => Some(slot),
            Place::Exhausted => None,
            Place::Wait => continue,
        };
        let spare = slot.as_mut().and_then(Slot::take_spare);
        match (producer.produce(spare, LOOK), slot) {
            (Produced::Frame(new), Some(slot)) => {
                let NewFrame { frame, meta, remarks } = *new;
                queue.frame(Box::new(LiveFrame { lease: slot.fill(frame), meta, remarks }));
            }
            (Produced::Frame(new), None) => queue.dropped(new.meta.sequence),
            (Produced::Incomplete(number, why), _) => queue.incomplete(number, why),
            (Produced::Missing(number), _) => queue.missing(number),
            (Produced::Nothing, _) => {}
            (Produced::Lost(why), _) => queue.lost(why),
            (Produced::End(failure), _) => return failure,
        }
    }
    None
}
