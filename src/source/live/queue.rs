//! The queue between a producer's thread and the consumer, with the policy of a slow consumer.
//!
//! Frames and gaps stand in the order of their numbers; a number is in one frame or one gap.
//! Neighbouring gaps are joined, so that the queue is bounded whatever is lost.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::counters::Counters;
use super::event::{Event, LiveFrame};
use super::gap::Gap;
use super::pool::{Pool, Slot};

/// What becomes of frames for which there is no place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Policy {
    /// The producer waits: files, pipes, the simulator.
    Block,
    /// The oldest one that waits is dropped, so that the consumer gets the newest.
    DropOldest,
    /// The one that came is dropped.
    DropNewest,
}

/// A thing in the queue.
#[derive(Debug)]
enum Entry {
    Frame(Box<LiveFrame>),
    Gap(Gap),
    Lost(String),
}

#[derive(Debug, Default)]
struct State {
    entries: VecDeque<Entry>,
    counters: Counters,
    /// The number after the last one that came.
    next: Option<u64>,
    /// The end of the stream, with the reason of a failure.
    ended: Option<Option<String>>,
    is_stopped: bool,
    /// Whether the source disappeared and no frame has come since.
    is_away: bool,
}

impl State {
    fn push_gap(&mut self, gap: Gap) {
        match self.entries.back_mut() {
            Some(Entry::Gap(last)) => last.join(gap),
            _ => self.entries.push_back(Entry::Gap(gap)),
        }
    }

    /// Takes a number: those before it are lost. Whether it is new.
    fn take_number(&mut self, number: u64) -> bool {
        let next = self.next.unwrap_or(number);
        if number < next {
            self.counters.repeated += 1;
            return false;
        }
        self.lose_until(number);
        self.next = Some(number.saturating_add(1));
        self.is_away = false;
        true
    }

    fn lose_until(&mut self, number: u64) {
        let next = self.next.unwrap_or(number);
        if number > next {
            self.counters.lost += number - next;
            self.next = Some(number);
            self.push_gap(Gap::lost(next, number));
        }
    }

    /// Replaces the oldest waiting frame by a gap; its lease.
    fn drop_oldest(&mut self) -> Option<Box<LiveFrame>> {
        let at = self.entries.iter().position(|entry| matches!(entry, Entry::Frame(_)))?;
        let Some(Entry::Frame(frame)) = self.entries.remove(at) else { return None };
        let mut gap = Gap::dropped(frame.meta.sequence);
        if matches!(self.entries.get(at), Some(Entry::Gap(_)))
            && let Some(Entry::Gap(after)) = self.entries.remove(at)
        {
            gap.join(after);
        }
        match at.checked_sub(1).and_then(|before| self.entries.get_mut(before)) {
            Some(Entry::Gap(before)) => before.join(gap),
            _ => self.entries.insert(at, Entry::Gap(gap)),
        }
        self.counters.waiting -= 1;
        self.counters.dropped += 1;
        Some(frame)
    }
}

/// The queue, shared by both ends.
#[derive(Debug)]
pub(super) struct Queue {
    state: Mutex<State>,
    changed: Condvar,
    policy: Policy,
    /// Most frames that wait.
    places: usize,
    pool: Pool,
}

/// A place for the next frame, or why there is none.
#[derive(Debug)]
pub(super) enum Place {
    /// A place in the pool.
    Free(Slot),
    /// All leases are out: the next frame is to be dropped.
    Exhausted,
    /// None yet, and the producer has to wait.
    Wait,
}

impl Queue {
    /// A queue of so many waiting frames, with leases for them and for as many as the consumer may
    /// hold.
    pub(super) fn new(policy: Policy, waiting: usize, held: usize) -> Arc<Self> {
        let places = waiting.max(1);
        Arc::new(Self {
            state: Mutex::default(),
            changed: Condvar::new(),
            policy,
            places,
            // One more is being made.
            pool: Pool::new(places + held.max(1) + 1),
        })
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    // ---- the producer's end

    /// A place for the next frame, after waiting at most so long where the policy is to wait.
    pub(super) fn place(&self, wait: Duration) -> Place {
        let wait = if self.policy == Policy::Block { wait } else { Duration::ZERO };
        if let Some(slot) = self.pool.slot(wait) {
            return Place::Free(slot);
        }
        let dropped = if self.policy == Policy::DropOldest { self.state().drop_oldest() } else { None };
        if let Some(frame) = dropped {
            frame.lease.give_back();
        }
        match (self.policy, self.pool.slot(Duration::ZERO)) {
            (_, Some(slot)) => Place::Free(slot),
            (Policy::Block, None) => Place::Wait,
            (_, None) => Place::Exhausted,
        }
    }

    /// A whole frame; waits for room by the policy, and no longer than until the source is stopped.
    pub(super) fn frame(&self, frame: Box<LiveFrame>) {
        let mut state = self.state();
        if !state.take_number(frame.meta.sequence) {
            return;
        }
        state.counters.waiting += 1;
        while state.counters.waiting as usize > self.places {
            match self.policy {
                Policy::DropOldest => {
                    state.drop_oldest().into_iter().for_each(|old| old.lease.give_back());
                }
                Policy::Block if !state.is_stopped => {
                    state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
                }
                Policy::Block | Policy::DropNewest => {
                    state.counters.waiting -= 1;
                    state.counters.dropped += 1;
                    state.push_gap(Gap::dropped(frame.meta.sequence));
                    frame.lease.give_back();
                    return self.wake(state);
                }
            }
        }
        state.entries.push_back(Entry::Frame(frame));
        self.wake(state);
    }

    /// A whole frame for which there was no lease.
    pub(super) fn dropped(&self, number: u64) {
        let mut state = self.state();
        if state.take_number(number) {
            state.counters.dropped += 1;
            state.push_gap(Gap::dropped(number));
        }
        self.wake(state);
    }

    /// A frame that arrived in part.
    pub(super) fn incomplete(&self, number: u64, why: String) {
        let mut state = self.state();
        if state.take_number(number) {
            state.counters.incomplete += 1;
            state.push_gap(Gap::incomplete(number, why));
        }
        self.wake(state);
    }

    /// Frames before this number do not come any more.
    pub(super) fn missing(&self, number: u64) {
        let mut state = self.state();
        state.lose_until(number);
        self.wake(state);
    }

    /// The source disappeared. One that comes and goes without a frame in between is reported once.
    pub(super) fn lost(&self, why: String) {
        let mut state = self.state();
        if !std::mem::replace(&mut state.is_away, true) {
            state.counters.disappeared += 1;
            state.entries.push_back(Entry::Lost(why));
        }
        self.wake(state);
    }

    /// There is no more.
    pub(super) fn end(&self, failure: Option<String>) {
        let mut state = self.state();
        state.ended = Some(failure);
        self.wake(state);
    }

    /// Whether the consumer wants no more.
    pub(super) fn is_stopped(&self) -> bool {
        self.state().is_stopped
    }

    // ---- the consumer's end

    /// The next event, after waiting at most so long.
    pub(super) fn next_event(&self, wait: Duration) -> Event {
        let until = Instant::now() + wait;
        let mut state = self.state();
        loop {
            if let Some(entry) = state.entries.pop_front() {
                let event = match entry {
                    Entry::Frame(frame) => {
                        state.counters.waiting -= 1;
                        state.counters.delivered += 1;
                        Event::Frame(frame)
                    }
                    Entry::Gap(gap) => Event::Gap(gap),
                    Entry::Lost(why) => Event::Lost(why),
                };
                self.wake(state);
                return event;
            }
            if let Some(failure) = &state.ended {
                return Event::End(failure.clone());
            }
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Event::Timeout;
            }
            state = self.changed.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Asks the producer to stop, or lets it go on after a stop or an end.
    pub(super) fn set_stopped(&self, is_stopped: bool) {
        let mut state = self.state();
        state.is_stopped = is_stopped;
        if !is_stopped {
            state.ended = None;
        }
        self.wake(state);
    }

    /// What became of the frames so far.
    pub(super) fn counters(&self) -> Counters {
        self.state().counters
    }

    fn wake(&self, state: MutexGuard<'_, State>) {
        drop(state);
        self.changed.notify_all();
    }
}
