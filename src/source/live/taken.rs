//! A live source as frames that are measured every one, in their order.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use super::event::{Event, LiveFrame};
use super::pool::Lease;
use super::source::LiveSource;
use crate::source::decode::Wanted;
use crate::source::read_error::ReadError;
use crate::source::stored::{Arrival, Coded, StoredFrame, Taken, Undecoded};

/// Time after which it is looked whether frames are wanted still.
const LOOK: Duration = Duration::from_millis(50);

/// The frames of a source up to its end, or until `stop` is true. Numbers without a frame are
/// counted as lost before the next one; a source that disappears is waited for.
pub(crate) fn taken(
    mut source: impl LiveSource + 'static,
    name: String,
    stop: Arc<AtomicBool>,
) -> impl Iterator<Item = Taken> + Send {
    let mut lost = 0;
    let mut has_ended = false;
    std::iter::from_fn(move || {
        while !has_ended && !stop.load(Ordering::Relaxed) {
            match source.next_event(LOOK) {
                Event::Frame(frame) => {
                    return Some(Ok(undecoded(*frame, &name, std::mem::take(&mut lost))));
                }
                Event::Gap(gap) => {
                    lost += gap.count();
                    tracing::warn!("{name}: {gap}");
                }
                Event::Lost(why) => tracing::warn!("{name}: {why}"),
                Event::Timeout => {}
                Event::End(failure) => {
                    has_ended = true;
                    return failure.map(|why| Err(ended(&name, &why)));
                }
            }
        }
        None
    })
}

/// Why a source failed, which its name stands before once: a recording states it itself.
fn ended(name: &str, why: &str) -> ReadError {
    let why = why.strip_prefix(name).and_then(|rest| rest.strip_prefix(": ")).unwrap_or(why);
    ReadError::Io { path: name.to_owned(), cause: std::io::Error::other(why.to_owned()) }
}

/// A frame that needs no decoding. Its memory leaves the pool; the place is free at once.
fn undecoded(frame: LiveFrame, name: &str, lost: u64) -> (Arrival, Result<Undecoded, ReadError>) {
    let LiveFrame { lease: Lease { frame, slot }, meta, remarks } = frame;
    drop(slot);
    let stem = if remarks.stem.is_empty() { format!("{:06}", meta.sequence) } else { remarks.stem };
    let arrival = Arrival {
        stem: stem.clone(),
        device_t_ns: meta.device_t.map(|t| t.t_ns),
        host_t_ns: meta.host_t.map(|t| t.t_ns),
        head_c: meta.head_c.map(|known| known.value),
        lost,
        notices: remarks.notices,
    };
    let named = format!("{name}, frame {stem}");
    let meta = frame.meta.clone();
    let stored = StoredFrame { stem: stem.clone(), frame, scale: remarks.scale, changed: remarks.changed };
    let undecoded = Undecoded {
        stem,
        named,
        meta,
        coded: Coded::Ready(Box::new(stored)),
        content: Arc::default(),
        wanted: Wanted::default(),
        stated: None,
    };
    (arrival, Ok(undecoded))
}
