//! Leases on the memory of frames, bounded in number.
//!
//! A producer takes a [`Slot`], fills it with a frame, and the consumer holds the [`Lease`] until
//! it drops it: then the memory is a spare of the next slot. No more slots and leases are out at
//! once than the pool has places.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::frame::Frame;

/// Places for frames.
#[derive(Clone, Debug)]
pub(crate) struct Pool {
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    state: Mutex<State>,
    returned: Condvar,
}

#[derive(Debug)]
struct State {
    free: usize,
    /// Memory of frames that came back; at most one a free place.
    spare: Vec<Frame>,
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn give_back(&self, spare: Option<Frame>) {
        let mut state = self.state();
        state.free += 1;
        state.spare.extend(spare);
        drop(state);
        self.returned.notify_all();
    }
}

impl Pool {
    /// A pool of so many places, at least 1.
    pub(crate) fn new(places: usize) -> Self {
        let state = State { free: places.max(1), spare: Vec::new() };
        Self { shared: Arc::new(Shared { state: Mutex::new(state), returned: Condvar::new() }) }
    }

    /// Places that are free.
    #[cfg(test)]
    pub(crate) fn free(&self) -> usize {
        self.shared.state().free
    }

    /// A place, after waiting at most so long; `None` where all are taken.
    pub(super) fn slot(&self, wait: Duration) -> Option<Slot> {
        let state = self.shared.state();
        let waited = self.shared.returned.wait_timeout_while(state, wait, |state| state.free == 0);
        let (mut state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        state.free = state.free.checked_sub(1)?;
        let spare = state.spare.pop();
        Some(Slot { shared: Arc::clone(&self.shared), spare })
    }
}

/// A place without a frame, perhaps with the memory of an earlier one.
#[derive(Debug)]
pub(crate) struct Slot {
    shared: Arc<Shared>,
    spare: Option<Frame>,
}

impl Slot {
    /// The memory of an earlier frame.
    pub(super) fn take_spare(&mut self) -> Option<Frame> {
        self.spare.take()
    }

    /// Fills the place.
    pub(crate) fn fill(self, frame: Frame) -> Lease {
        Lease { frame, slot: self }
    }

    /// Gives the place back with the memory of a frame for the next one.
    pub(crate) fn give_back(mut self, spare: Frame) {
        self.spare = Some(spare);
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        self.shared.give_back(self.spare.take());
    }
}

/// A frame in its place. Dropped, it gives the place back; [`Self::give_back`] the memory too.
#[derive(Debug)]
pub(crate) struct Lease {
    /// The frame.
    pub frame: Frame,
    /// Its place.
    pub slot: Slot,
}

impl Lease {
    /// Gives place and memory back.
    #[cfg_attr(not(test), allow(dead_code, reason = "the program gives them back apart"))]
    pub(crate) fn give_back(self) {
        self.slot.give_back(self.frame);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Buffer, FrameMeta, PixelFormat};

    fn frame_of(value: u8) -> Frame {
        Frame::new(Buffer::U8(vec![value; 6]), PixelFormat::Mono8, 2, 3, FrameMeta::default()).unwrap()
    }

    fn address(frame: &Frame) -> *const u8 {
        match frame.view().pixels() {
            crate::frame::Pixels::U8(pixels) => pixels.as_ptr(),
            _ => panic!("8 bits"),
        }
    }

    #[test]
    fn places_are_bounded_and_memory_comes_back() {
        let pool = Pool::new(2);
        let first = pool.slot(Duration::ZERO).unwrap().fill(frame_of(1));
        let second = pool.slot(Duration::ZERO).unwrap();
        assert!(pool.slot(Duration::ZERO).is_none() && pool.free() == 0);
        let place = address(&first.frame);
        first.give_back();
        let mut again = pool.slot(Duration::ZERO).unwrap();
        let spare = again.take_spare().unwrap();
        assert_eq!(address(&spare), place);
        drop(second);
        let Lease { frame, slot } = again.fill(spare);
        assert_eq!(pool.free(), 1);
        slot.give_back(frame);
        // The place alone, with the spare that it was given.
        drop(pool.slot(Duration::ZERO).unwrap().fill(frame_of(2)));
        assert_eq!((pool.free(), pool.shared.state().spare.len()), (2, 1));
    }

    #[test]
    fn a_place_is_waited_for() {
        let pool = Pool::new(1);
        let lease = pool.slot(Duration::ZERO).unwrap().fill(frame_of(1));
        let other = pool.clone();
        let waits = std::thread::spawn(move || other.slot(Duration::from_secs(60)).is_some());
        drop(lease);
        assert!(waits.join().unwrap());
    }
}
