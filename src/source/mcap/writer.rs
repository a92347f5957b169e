//! Messages of frames into an MCAP file whose every chunk ends with a whole frame.

use std::collections::BTreeMap;
use std::io::{self, Seek, Write};
use std::time::{Duration, Instant};

use ::mcap::records::MessageHeader;
use ::mcap::{McapError, WriteOptions, Writer};

use super::frame_message::Facts;
use super::wire::Message;
use super::{camera_record, raw_image, schema};
use crate::frame::CameraBinding;
use crate::source::live::NewFrame;

/// Time after which a chunk ends: what is lost when the process is killed.
pub(super) const CHUNK_TIME: Duration = Duration::from_millis(250);
/// Bytes after which a chunk ends: a frame of 4 megapixels in 8 bits, and the default of other
/// writers (1 to 4 MiB).
const CHUNK_BYTES: usize = 4 << 20;

/// Topics of the two messages.
const TOPICS: [&str; 2] = ["frames/facts", "frames/image"];

/// The two messages of a frame.
#[derive(Debug)]
pub(super) struct Encoded {
    /// Low 32 bits of the sequence number.
    pub(super) sequence: u32,
    /// Time of the entry, ns.
    pub(super) t_ns: u64,
    /// `shadowgauge.Frame`.
    pub(super) facts: Message,
    /// `foxglove.RawImage`.
    pub(super) image: Message,
}

impl Encoded {
    /// Of a frame, in the memory of an image that is written. The time of the entry is when this
    /// machine had it, otherwise the device's.
    pub(super) fn of(new: &NewFrame, spent: Message) -> Self {
        let NewFrame { frame, meta, remarks } = new;
        let t_ns = meta.host_t.or(meta.device_t).map_or(frame.meta.t_ns, |time| time.t_ns);
        Self {
            sequence: meta.sequence as u32,
            t_ns,
            facts: Facts::of(frame, meta, remarks).encoded(),
            image: raw_image::encoded(frame, t_ns, &remarks.stem, spent),
        }
    }
}

/// A recording while it is written.
pub(super) struct RecordingWriter<W: Write + Seek> {
    writer: Writer<W>,
    channels: [u16; 2],
    pending: usize,
    begun: Instant,
}

impl<W: Write + Seek> RecordingWriter<W> {
    /// Begins a recording of frames of this camera, where it is known.
    ///
    /// # Errors
    /// Where the disk refuses.
    pub(super) fn begin(to: W, camera: Option<&CameraBinding>) -> io::Result<Self> {
        // A chunk is put together in memory and written at once: its length stands before it, so
        // that one that is cut off is known for that.
        let options = WriteOptions::new()
            .compression(None)
            .chunk_size(None)
            .disable_seeking(true)
            // Every chunk has one of its own.
            .calculate_data_section_crc(false)
            .library(concat!("shadowgauge ", env!("CARGO_PKG_VERSION")));
        let mut writer = options.create(to).map_err(failure)?;
        let mut channel = |name: &str, descriptors: &Message, topic: &str| {
            let schema = writer.add_schema(name, schema::ENCODING, descriptors.bytes())?;
            writer.add_channel(schema, topic, schema::ENCODING, &BTreeMap::new())
        };
        let facts = channel(schema::FRAME, &schema::frame(), TOPICS[0]).map_err(failure)?;
        let image = channel(schema::IMAGE, &schema::image(), TOPICS[1]).map_err(failure)?;
        if let Some(camera) = camera {
            writer.write_metadata(&camera_record::record(camera)).map_err(failure)?;
        }
        writer.flush().map_err(failure)?;
        Ok(Self { writer, channels: [facts, image], pending: 0, begun: Instant::now() })
    }

    /// Adds a frame, and ends the chunk where it is due.
    ///
    /// # Errors
    /// Where the disk refuses.
    pub(super) fn frame(&mut self, frame: &Encoded) -> io::Result<()> {
        if self.pending == 0 {
            self.begun = Instant::now();
        }
        for (channel_id, message) in self.channels.into_iter().zip([&frame.facts, &frame.image]) {
            let Encoded { sequence, t_ns, .. } = *frame;
            let header = MessageHeader { channel_id, sequence, log_time: t_ns, publish_time: t_ns };
            self.writer.write_to_known_channel(&header, message.bytes()).map_err(failure)?;
            self.pending += message.bytes().len();
        }
        let is_due = self.pending >= CHUNK_BYTES || self.begun.elapsed() >= CHUNK_TIME;
        if is_due { self.end_chunk() } else { Ok(()) }
    }

    /// Ends a chunk that was begun: what it holds can be read from now on.
    ///
    /// # Errors
    /// Where the disk refuses.
    pub(super) fn end_chunk(&mut self) -> io::Result<()> {
        if self.pending == 0 {
            return Ok(());
        }
        self.pending = 0;
        self.writer.flush().map_err(failure)
    }

    /// Ends the recording with its index; gives back what was written to.
    ///
    /// # Errors
    /// Where the disk refuses.
    pub(super) fn finish(mut self) -> io::Result<W> {
        self.writer.finish().map_err(failure)?;
        Ok(self.writer.into_inner())
    }
}

fn failure(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}
