//! Live lines to all readers: each has the newest, a slow one loses those between.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tokio::sync::broadcast;

/// Lines that wait for a slow reader: a second of frames at 50/s, with their events.
const WAITING: usize = 64;

/// What is shown now.
#[derive(Clone, Debug, Default)]
struct Now {
    frame: Option<(Arc<str>, Instant)>,
    ended: Option<String>,
}

/// Where lines come in and readers take them.
#[derive(Debug)]
pub(super) struct Hub {
    lines: broadcast::Sender<Arc<str>>,
    now: Mutex<Now>,
}

impl Hub {
    pub(super) fn new() -> Self {
        Self { lines: broadcast::channel(WAITING).0, now: Mutex::default() }
    }

    /// Gives a line on; one of a frame is what readers that come later see first.
    pub(super) fn line(&self, line: &str) {
        let line: Arc<str> = line.into();
        let is_frame = !line.contains("\"event\":");
        let mut now = self.now.lock().unwrap_or_else(PoisonError::into_inner);
        now.ended = None;
        if is_frame {
            now.frame = Some((Arc::clone(&line), Instant::now()));
        }
        drop(now);
        // there may be no reader
        let _ = self.lines.send(line);
    }

    /// The source is gone: what was measured last is no reading of now.
    pub(super) fn end(&self, why: &str) {
        let mut now = self.now.lock().unwrap_or_else(PoisonError::into_inner);
        now.frame = None;
        now.ended = Some(why.to_owned());
        drop(now);
        let _ = self.lines.send(invalid(why).into());
    }

    /// Whether the last frame is no reading of now.
    pub(super) fn is_dead(&self, stale: Duration) -> bool {
        let now = self.now.lock().unwrap_or_else(PoisonError::into_inner);
        now.ended.is_some() || now.frame.as_ref().is_none_or(|(_, at)| at.elapsed() > stale)
    }

    /// The first line of a new reader, and the lines that follow. A frame older than `stale` is
    /// replaced by the event that states its age.
    pub(super) fn join(&self, stale: Duration) -> (Option<Arc<str>>, broadcast::Receiver<Arc<str>>) {
        let coming = self.lines.subscribe();
        let now = self.now.lock().unwrap_or_else(PoisonError::into_inner);
        let first = match (&now.frame, &now.ended) {
            (_, Some(why)) => Some(invalid(why).into()),
            (Some((line, at)), None) if at.elapsed() <= stale => Some(Arc::clone(line)),
            (Some((_, at)), None) => {
                Some(invalid(&format!("no frame for {:.0} s", at.elapsed().as_secs_f64())).into())
            }
            (None, None) => None,
        };
        (first, coming)
    }
}

/// The event of a reading that is none.
fn invalid(why: &str) -> String {
    let event: Value = json!({ "event": "invalid", "reason": "source_lost", "why": why });
    event.to_string()
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::Hub;

    #[test]
    fn a_reader_that_comes_later_sees_the_newest_frame_or_that_there_is_none() {
        let hub = Hub::new();
        assert!(hub.join(Duration::MAX).0.is_none());
        hub.line("{\"frame\":\"1\"}");
        hub.line("{\"event\":\"part\"}");
        assert_eq!(hub.join(Duration::MAX).0.as_deref(), Some("{\"frame\":\"1\"}"));
        assert!(hub.join(Duration::ZERO).0.unwrap().contains("no frame for"));
        hub.end("the camera is gone");
        assert!(hub.join(Duration::MAX).0.unwrap().contains("the camera is gone"));
    }

    #[test]
    fn a_slow_reader_loses_lines_and_keeps_the_newest() {
        let hub = Hub::new();
        let (_, mut reader) = hub.join(Duration::MAX);
        for k in 0..1000 {
            hub.line(&format!("{{\"frame\":\"{k}\"}}"));
        }
        let mut last = None;
        loop {
            match reader.try_recv() {
                Ok(line) => last = Some(line),
                Err(tokio::sync::broadcast::error::TryRecvError::Lagged(_)) => {}
                Err(_) => break,
            }
        }
        assert_eq!(last.as_deref(), Some("{\"frame\":\"999\"}"));
    }
}
