//! The end of a source that runs on a thread of its own: waited for before the program ends.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Longest wait for a source to close: a camera that does not answer has half a second to give
/// control back.
const CLOSES: Duration = Duration::from_secs(2);

/// Waits, when it is dropped, until the source on its own thread has closed: a camera has its
/// settings back before the program ends.
pub(crate) struct Closing {
    /// What the source will hold.
    open: Mutex<Option<SyncSender<()>>>,
    closed: Receiver<()>,
}

impl Closing {
    /// For a source that is not open yet.
    pub(super) fn new() -> Self {
        let (open, closed) = sync_channel(1);
        Self { open: Mutex::new(Some(open)), closed }
    }

    /// Frames of a source whose closing is waited for.
    pub(super) fn guarded<I>(&self, frames: I) -> Guarded<I> {
        Guarded { frames, _closed: self.guard() }
    }

    /// What a source holds while it is open.
    fn guard(&self) -> Option<SyncSender<()>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

impl Drop for Closing {
    fn drop(&mut self) {
        drop(self.guard());
        // Nothing is ever sent: the other end is dropped with the source.
        let _ = self.closed.recv_timeout(CLOSES);
    }
}

/// Frames whose source holds a guard until it has closed.
pub(super) struct Guarded<I> {
    // Dropped first.
    frames: I,
    _closed: Option<SyncSender<()>>,
}

impl<I: Iterator> Iterator for Guarded<I> {
    type Item = I::Item;

    fn next(&mut self) -> Option<I::Item> {
        self.frames.next()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};

    use super::*;

    struct Source(Arc<AtomicBool>);

    impl Iterator for Source {
        type Item = u8;

        fn next(&mut self) -> Option<u8> {
            None
        }
    }

    impl Drop for Source {
        fn drop(&mut self) {
            std::thread::sleep(Duration::from_millis(20));
            self.0.store(true, Ordering::SeqCst);
        }
    }

    #[test]
    fn a_source_has_closed_when_the_waiting_ends() {
        let is_closed = Arc::new(AtomicBool::new(false));
        let closing = Closing::new();
        let mut frames = closing.guarded(Source(Arc::clone(&is_closed)));
        let thread = std::thread::spawn(move || frames.next());
        drop(closing);
        assert!(is_closed.load(Ordering::SeqCst));
        assert_eq!(thread.join().unwrap(), None);
        // without a source there is nothing to wait for
        drop(Closing::new());
    }
}
