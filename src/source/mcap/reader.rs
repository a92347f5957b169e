//! The frames of an MCAP file, one after another.

use std::io::Read;

use ::mcap::records::op;
use ::mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use ::mcap::{McapError, parse_record};

use super::records::Records;
use crate::frame::{CameraBinding, Frame};
use crate::source::live::NewFrame;

/// What comes next from a file.
#[derive(Debug)]
pub(super) enum Next {
    /// A frame.
    Frame(Box<NewFrame>),
    /// The end of a whole file.
    End,
    /// The end of a file that was cut off.
    Cut,
}

/// A file while it is read.
pub(super) struct RecordingReader<R> {
    input: R,
    reader: LinearReader,
    records: Records,
    is_whole: bool,
}

impl<R: Read> RecordingReader<R> {
    /// A file of so many bytes.
    pub(super) fn new(input: R, bytes: u64) -> Self {
        // A record that is longer than the file is cut off: no memory is taken for it.
        let limit = usize::try_from(bytes).unwrap_or(usize::MAX);
        let options = LinearReaderOptions::default()
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(limit);
        let reader = LinearReader::new_with_options(options);
        Self { input, reader, records: Records::default(), is_whole: false }
    }

    /// Frames so far.
    pub(super) fn given(&self) -> u64 {
        self.records.given()
    }

    /// The camera that the file states, known with the first frame.
    pub(super) fn camera(&self) -> Option<&CameraBinding> {
        self.records.camera()
    }

    /// The next frame, in spare memory where there is some. Frames of a chunk that is not whole are
    /// not given.
    ///
    /// # Errors
    /// A file that is no MCAP, is damaged, or has no images that a gauge reads.
    pub(super) fn next(&mut self, spare: &mut Option<Frame>) -> Result<Next, String> {
        loop {
            let event = match self.reader.next_event() {
                None => return self.ended(),
                Some(Err(error)) if is_cut(&error) => return self.ended(),
                Some(event) => event.map_err(|error| self.records.after_given(&wrong(&error)))?,
            };
            match event {
                LinearReadEvent::ReadRequest(bytes) => {
                    let read = self.input.read(self.reader.insert(bytes));
                    self.reader.notify_read(read.map_err(|error| error.to_string())?);
                }
                LinearReadEvent::Record { opcode, data } => {
                    self.is_whole |= opcode == op::FOOTER;
                    let record = parse_record(opcode, data);
                    let record = record.map_err(|error| self.records.after_given(&wrong(&error)))?;
                    if let Some(frame) = self.records.take(record, spare)? {
                        return Ok(Next::Frame(frame));
                    }
                }
            }
        }
    }

    fn ended(&self) -> Result<Next, String> {
        if self.records.given() > 0 {
            return Ok(if self.is_whole { Next::End } else { Next::Cut });
        }
        Err(self.records.why_none(self.is_whole))
    }
}

/// Whether a file ends within a record.
fn is_cut(error: &McapError) -> bool {
    matches!(error, McapError::UnexpectedEof | McapError::RecordTooLarge { .. } | McapError::ChunkTooLarge(_))
}

/// What is wrong with a file, and what would be right.
fn wrong(error: &McapError) -> String {
    match error {
        McapError::BadMagic => "no MCAP file: it does not begin with its signature".to_owned(),
        McapError::UnsupportedCompression(name) => format!(
            "its chunks are compressed by {name}: only those without compression are read; \
             \"mcap decompress IN -o OUT\" (mcap.dev) makes such a file"
        ),
        McapError::BadChunkCrc { .. } => "the next chunk is damaged: its checksum is wrong".to_owned(),
        other => format!("it is damaged: {other}"),
    }
}
