//! Frames recorded on their way: a producer around another one, whose frames go to a thread that
//! writes them, before any is left out.

use std::fs::File;
use std::io::{self, Seek, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::Duration;

use super::wire::Message;
use super::writer::{CHUNK_TIME, Encoded, RecordingWriter};
use crate::frame::{CameraBinding, Frame};
use crate::source::live::{NewFrame, Produced, Producer};

/// Frames that wait for the disk: a third of a second at 50 a second, 64 MB of 4 megapixels in 8
/// bits.
const WAITING: usize = 16;
/// Images whose memory is kept to be taken again: one that is made, one that was just written.
const SPENT: usize = 2;

/// A producer whose frames are recorded.
pub(crate) struct Tap {
    producer: Box<dyn Producer>,
    to: SyncSender<Encoded>,
    /// Images that are written, whose memory is taken again.
    spent: Receiver<Message>,
    left_out: Arc<AtomicU64>,
    /// Whether the disk is waited for.
    waits: bool,
}

/// A recording that is being written.
pub(crate) struct Recorded {
    thread: JoinHandle<io::Result<u64>>,
    left_out: Arc<AtomicU64>,
}

impl Tap {
    /// Records the frames of a producer in a new file. A source that `waits` is held up by a slow
    /// disk; of another one frames are left out of the recording, and counted.
    ///
    /// # Errors
    /// A file that is there already, or cannot be written; a system without another thread.
    pub(crate) fn begin(
        producer: Box<dyn Producer>,
        path: &Path,
        waits: bool,
    ) -> io::Result<(Self, Recorded)> {
        let writer = RecordingWriter::begin(File::create_new(path)?, producer.camera())?;
        let (to, from) = sync_channel(WAITING);
        let (back, spent) = sync_channel(SPENT);
        let left_out = Arc::<AtomicU64>::default();
        let name = path.display().to_string();
        let write = move || written(writer, &Ends { from, back }, &name);
        let thread = std::thread::Builder::new().name("recording".to_owned()).spawn(write)?;
        let tap = Self { producer, to, spent, left_out: Arc::clone(&left_out), waits };
        Ok((tap, Recorded { thread, left_out }))
    }

    fn record(&self, new: &NewFrame) {
        let encoded = Encoded::of(new, self.spent.try_recv().unwrap_or_default());
        let is_taken = match self.waits {
            true => self.to.send(encoded).is_ok(),
            false => self.to.try_send(encoded).is_ok(),
        };
        if !is_taken {
            self.left_out.fetch_add(1, Ordering::Relaxed);
        }
    }
}

impl Producer for Tap {
    fn produce(&mut self, spare: Option<Frame>, wait: Duration) -> Produced {
        let produced = self.producer.produce(spare, wait);
        if let Produced::Frame(new) = &produced {
            self.record(new);
        }
        produced
    }

    fn start(&mut self) {
        self.producer.start();
    }

    fn stop(&mut self) {
        self.producer.stop();
    }

    fn camera(&self) -> Option<&CameraBinding> {
        self.producer.camera()
    }
}

impl Recorded {
    /// Waits until everything is written, after the [`Tap`] is gone: frames that are in the file,
    /// and those that were left out.
    ///
    /// # Errors
    /// Where the disk refused: what was written until then can be read.
    pub(crate) fn finish(self) -> io::Result<[u64; 2]> {
        let failed = |_| Err(io::Error::other("the thread that writes it failed"));
        let written = self.thread.join().unwrap_or_else(failed)?;
        Ok([written, self.left_out.load(Ordering::Relaxed)])
    }
}

/// The writing thread's ends: frames come, memory goes back.
struct Ends {
    from: Receiver<Encoded>,
    back: SyncSender<Message>,
}

/// Writes what comes until the other end is gone; the number of frames.
fn written<W: Write + Seek>(mut writer: RecordingWriter<W>, ends: &Ends, name: &str) -> io::Result<u64> {
    let mut frames = 0;
    loop {
        let done = match ends.from.recv_timeout(CHUNK_TIME) {
            Ok(frame) => {
                let done = writer.frame(&frame).inspect(|()| frames += 1);
                // Full where the source is gone or waits for no memory: it is given up.
                let _ = ends.back.try_send(frame.image);
                done
            }
            Err(RecvTimeoutError::Timeout) => writer.end_chunk(),
            Err(RecvTimeoutError::Disconnected) => break,
        };
        // At once: who watches may make room on the disk.
        done.inspect_err(|error| tracing::error!("{name} is not written any more: {error}"))?;
    }
    writer.finish()?;
    Ok(frames)
}
