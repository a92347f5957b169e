//! Frames decoded ahead on other threads, in the order of their source and in bounded memory.
//!
//! One thread reads the source, some decode, and whoever calls [`Ahead::next_frame`] gets the
//! frames in their order. A place in the queue is taken before a frame is decoded: as many frames
//! as there are places are held at once, whatever the source delivers.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, channel, sync_channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use super::error::damaged;
use super::read_error::ReadError;
use super::spare::Spare;
use super::stored::{Arrival, StoredFrame, Taken, Undecoded};
use crate::frame::Frame;

/// Frames held beyond one a decoding thread: one that is decoded and waits, so that the gauge never
/// does, and one that is read meanwhile.
const SPARE: usize = 2;
/// Time after which a waiting reader looks whether it is to stop: below what a person notices.
const LOOK: Duration = Duration::from_millis(50);

/// A decoded frame, or why there is none.
type Stored = Result<StoredFrame, ReadError>;

/// What there is after a time.
pub(super) enum Within {
    /// The next frame, or why it cannot be read.
    Frame(Box<(Arrival, Stored)>),
    /// Nothing yet.
    Nothing,
    /// The end, with the error that ended the source.
    End(Option<ReadError>),
}

/// A place in the queue: the frame comes through its own channel.
type Place = Result<(Arrival, Receiver<Stored>), ReadError>;

/// A frame to be decoded, and where it goes.
type Work = (Undecoded, SyncSender<Stored>);

/// Frames of a source, decoded ahead.
#[derive(Debug)]
pub(crate) struct Ahead {
    places: Receiver<Place>,
    spare: Spare,
    stop: Option<Arc<AtomicBool>>,
}

impl Ahead {
    /// Spare memory for a source whose frames are decoded on so many threads.
    pub(crate) fn spare(threads: usize) -> Spare {
        // One more is measured meanwhile.
        Spare::of(threads + SPARE + 1)
    }

    /// Begins to read a source and to decode its frames on so many threads, in the spare memory
    /// that the source takes as well. Where `stop` is given and becomes true, there are no more
    /// frames.
    ///
    /// # Errors
    /// A system without another thread.
    pub(crate) fn new(
        source: impl Iterator<Item = Taken> + Send + 'static,
        threads: usize,
        stop: Option<Arc<AtomicBool>>,
        spare: Spare,
    ) -> std::io::Result<Self> {
        let (queue, places) = sync_channel(threads + SPARE);
        let (work, works) = channel();
        let works = Arc::new(Mutex::new(works));
        let named = |name: &str| std::thread::Builder::new().name(name.to_owned());
        for _ in 0..threads.max(1) {
            let (works, spare) = (Arc::clone(&works), spare.clone());
            named("decode").spawn(move || decode(&works, &spare))?;
        }
        named("read").spawn(move || read(source, &queue, &work))?;
        Ok(Self { places, spare, stop })
    }

    /// The next frame or why it cannot be read; the outer error ends the source.
    pub(crate) fn next_frame(&mut self) -> Option<Result<(Arrival, Stored), ReadError>> {
        Some(self.next_place()?.map(|(arrival, frame)| {
            let stored = whole(&arrival, &frame);
            (arrival, stored)
        }))
    }

    /// As [`Self::next_frame`], after waiting at most so long.
    pub(super) fn next_within(&mut self, wait: Duration) -> Within {
        match self.places.recv_timeout(wait) {
            Ok(Ok((arrival, frame))) => {
                let stored = whole(&arrival, &frame);
                Within::Frame(Box::new((arrival, stored)))
            }
            Ok(Err(error)) => Within::End(Some(error)),
            Err(RecvTimeoutError::Timeout) => Within::Nothing,
            Err(RecvTimeoutError::Disconnected) => Within::End(None),
        }
    }

    /// Takes back a frame, whose memory one of the next frames uses.
    pub(crate) fn give_back(&self, frame: Frame) {
        self.spare.take_buffer(frame.into_buffer());
    }

    fn next_place(&self) -> Option<Place> {
        let Some(stop) = &self.stop else { return self.places.recv().ok() };
        while !stop.load(Ordering::Relaxed) {
            match self.places.recv_timeout(LOOK) {
                Ok(place) => return Some(place),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return None,
            }
        }
        None
    }
}

/// The decoded frame of a place.
fn whole(arrival: &Arrival, frame: &Receiver<Stored>) -> Stored {
    frame.recv().unwrap_or_else(|_| {
        let (path, cause) = (arrival.stem.clone(), damaged("its decoder gave up"));
        Err(ReadError::Decode { path, cause })
    })
}

/// Reads the source to its end, or until its frames are not waited for any more.
fn read(source: impl Iterator<Item = Taken>, queue: &SyncSender<Place>, work: &Sender<Work>) {
    for taken in source {
        let (arrival, undecoded) = match taken {
            Ok(taken) => taken,
            Err(error) => {
                let _ = queue.send(Err(error));
                return;
            }
        };
        let (give, frame) = sync_channel(1);
        if queue.send(Ok((arrival, frame))).is_err() {
            return;
        }
        // Where frames are not waited for any more, the next place shows it.
        let _ = match undecoded {
            Ok(undecoded) => work.send((undecoded, give)).map_err(|_| ()),
            Err(error) => give.send(Err(error)).map_err(|_| ()),
        };
    }
}

/// Decodes until there is nothing more to come.
fn decode(works: &Mutex<Receiver<Work>>, spare: &Spare) {
    // The lock is held while a thread waits for work, not while it decodes.
    let next = || works.lock().ok()?.recv().ok();
    while let Some((undecoded, give)) = next() {
        let _ = give.send(undecoded.decode(spare));
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicUsize;

    use super::*;
    use crate::frame::FrameMeta;
    use crate::source::decode::Wanted;

    /// Images of one pixel whose value is their number; every third is none.
    fn image(number: usize) -> Taken {
        let bytes =
            if number % 3 == 2 { b"none".to_vec() } else { [b"P5 1 1 255\n", &[number as u8][..]].concat() };
        let stem = number.to_string();
        let undecoded = Undecoded {
            stem: stem.clone(),
            named: stem.clone(),
            coded: crate::source::stored::Coded::Image,
            content: Arc::new(bytes),
            wanted: Wanted::default(),
            meta: FrameMeta::default(),
            stated: None,
        };
        Ok((Arrival { stem, ..Arrival::default() }, Ok(undecoded)))
    }

    #[test]
    fn frames_come_in_their_order_at_any_number_of_threads() {
        for threads in [1, 2, 7] {
            let mut ahead = Ahead::new((0..200).map(image), threads, None, Ahead::spare(threads)).unwrap();
            for number in 0..200 {
                let (arrival, stored) = ahead.next_frame().unwrap().unwrap();
                assert_eq!(arrival.stem, number.to_string());
                let value = stored.ok().and_then(|s| s.frame.view().get(0, 0));
                assert_eq!(value, (number % 3 != 2).then_some(number as f32));
            }
            assert!(ahead.next_frame().is_none());
        }
    }

    #[test]
    fn no_more_is_read_than_there_are_places() {
        let read = Arc::new(AtomicUsize::new(0));
        let count = Arc::clone(&read);
        let source = (0..1000).map(move |number| {
            count.fetch_add(1, Ordering::Relaxed);
            image(number)
        });
        let mut ahead = Ahead::new(source, 2, None, Ahead::spare(2)).unwrap();
        for taken in 1..=20 {
            assert!(ahead.next_frame().is_some());
            std::thread::sleep(Duration::from_millis(2));
            // The places, what was taken out of them, and the one that waits for a place.
            assert!(read.load(Ordering::Relaxed) <= taken + 2 + SPARE + 1);
        }
    }

    #[test]
    fn a_source_that_breaks_or_is_stopped_ends() {
        let broken = |_| Err(ReadError::NoImages { path: "x".to_owned() });
        let mut ahead =
            Ahead::new((0..3).map(image).chain((3..9).map(broken)), 2, None, Ahead::spare(2)).unwrap();
        assert_eq!((0..3).filter(|_| ahead.next_frame().unwrap().is_ok()).count(), 3);
        assert!(ahead.next_frame().unwrap().is_err() && ahead.next_frame().is_none());
        let stop = Arc::new(AtomicBool::new(false));
        let endless = std::iter::repeat_with(|| {
            std::thread::sleep(Duration::from_millis(5));
            image(0)
        });
        let mut ahead = Ahead::new(endless, 1, Some(Arc::clone(&stop)), Ahead::spare(1)).unwrap();
        assert!(ahead.next_frame().is_some());
        stop.store(true, Ordering::Relaxed);
        assert!(ahead.next_frame().is_none());
    }
}
