//! A recording as a producer of live frames: every one, in its order.

use std::fs::File;
use std::io;
use std::path::Path;
use std::time::Duration;

use super::reader::{Next, RecordingReader};
use crate::frame::{CameraBinding, Frame};
use crate::source::live::{Produced, Producer};

/// A recording that is replayed, as fast as its frames are taken.
pub(crate) struct Replay<R = File> {
    name: String,
    reader: RecordingReader<R>,
    /// What was read when it was opened: the camera stands before the first frame.
    first: Option<Result<Next, String>>,
    spare: Option<Frame>,
    has_ended: bool,
}

impl Replay {
    /// A file.
    ///
    /// # Errors
    /// A file that cannot be opened.
    pub(crate) fn open(path: &Path) -> io::Result<Self> {
        let file = File::open(path)?;
        let bytes = file.metadata()?.len();
        Ok(Self::new(file, bytes, path.display().to_string()))
    }
}

impl<R: io::Read> Replay<R> {
    /// A file of so many bytes, of this name in messages.
    pub(super) fn new(input: R, bytes: u64, name: String) -> Self {
        let mut reader = RecordingReader::new(input, bytes);
        let first = Some(reader.next(&mut None));
        Self { name, reader, first, spare: None, has_ended: false }
    }
}

impl<R: io::Read + Send> Producer for Replay<R> {
    fn produce(&mut self, spare: Option<Frame>, _wait: Duration) -> Produced {
        self.spare = spare.or(self.spare.take());
        if self.has_ended {
            return Produced::End(None);
        }
        let next = match self.first.take() {
            Some(first) => first,
            None => self.reader.next(&mut self.spare),
        };
        self.has_ended = !matches!(next, Ok(Next::Frame(_)));
        match next {
            Ok(Next::Frame(frame)) => Produced::Frame(frame),
            Ok(Next::End) => Produced::End(None),
            Ok(Next::Cut) => {
                let (name, given) = (&self.name, self.reader.given());
                tracing::warn!("{name} is cut off: {given} frames, up to its last whole chunk, are read");
                Produced::End(None)
            }
            Err(why) => Produced::End(Some(format!("{}: {why}", self.name))),
        }
    }

    fn camera(&self) -> Option<&CameraBinding> {
        self.reader.camera()
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::io::Cursor;

    use ::mcap::WriteOptions;
    use ::mcap::records::MessageHeader;

    use super::*;
    use crate::frame::{Buffer, FrameMeta, PixelFormat, Roi};
    use crate::source::live::{Clock, Known, LiveMeta, NewFrame, Remarks, Timestamp};
    use crate::source::mcap::wire::Message;
    use crate::source::mcap::writer::{Encoded, RecordingWriter};

    /// A frame of 5 x 3 pixels whose values and facts are those of its number.
    fn frame(number: u64) -> NewFrame {
        let value = |i: u64| 97 * number + i;
        let (buffer, format) = match number % 3 {
            0 => (Buffer::U8((0..15).map(|i| value(i) as u8).collect()), PixelFormat::Mono8),
            1 => (Buffer::U16((0..15).map(|i| value(i) as u16).collect()), PixelFormat::Mono12),
            _ => (Buffer::F32((0..15).map(|i| value(i) as f32 / 7.0).collect()), PixelFormat::F32),
        };
        let roi = Some(Roi { row: 1, column: 0, rows: 3, columns: 5 });
        let of_frame =
            FrameMeta { frame_id: number, angle_deg: 0.1 * number as f64, roi, ..FrameMeta::default() };
        let meta = LiveMeta {
            sequence: (1 << 40) + 3 * number,
            device_t: Some(Timestamp { t_ns: number, clock: Clock::Simulated }),
            z_mm: Some(Known::simulated(-0.3 * number as f64)),
            ..LiveMeta::default()
        };
        let remarks = Remarks { stem: format!("name {number}"), ..Remarks::default() };
        NewFrame { frame: Frame::new(buffer, format, 3, 5, of_frame).unwrap(), meta, remarks }
    }

    /// A recording of so many frames, a chunk a frame, and where each chunk ends: records are an
    /// opcode, a length of 64 bits and content; a chunk's opcode is 6 (<https://mcap.dev/spec>).
    fn recording(frames: u64) -> (Vec<u8>, Vec<usize>) {
        let mut writer = RecordingWriter::begin(Cursor::new(Vec::new()), None).unwrap();
        for number in 0..frames {
            writer.frame(&Encoded::of(&frame(number), Message::default())).unwrap();
            writer.end_chunk().unwrap();
        }
        let bytes = writer.finish().unwrap().into_inner();
        let (mut at, mut ends) = (8, Vec::new());
        while let Some(record) = bytes.get(at..at + 9) {
            at += 9 + u64::from_le_bytes(record[1..].try_into().unwrap()) as usize;
            ends.extend((record[0] == 6).then_some(at));
        }
        // The first chunk has the descriptors alone.
        ends.remove(0);
        assert_eq!(ends.len() as u64, frames);
        (bytes, ends)
    }

    /// The frames that are read, compared with those that were written, and how it ended.
    fn replayed(bytes: &[u8]) -> (u64, Option<String>) {
        let mut replay = Replay::new(Cursor::new(bytes.to_vec()), bytes.len() as u64, "day.mcap".into());
        let mut spare = None;
        for number in 0.. {
            match replay.produce(spare.take(), Duration::ZERO) {
                Produced::Frame(new) => {
                    assert_eq!(format!("{new:?}"), format!("{:?}", Box::new(frame(number))));
                    spare = Some(new.frame);
                }
                Produced::End(why) => return (number, why),
                other => panic!("{other:?}"),
            }
        }
        unreachable!("the frames end")
    }

    #[test]
    fn frames_come_back_to_the_bit() {
        assert_eq!(replayed(&recording(7).0), (7, None));
    }

    #[test]
    fn the_camera_is_known_before_the_first_frame() {
        let camera = CameraBinding { serial_number: "SG-5".to_owned(), ..CameraBinding::default() };
        for stated in [Some(&camera), None] {
            let mut writer = RecordingWriter::begin(Cursor::new(Vec::new()), stated).unwrap();
            writer.frame(&Encoded::of(&frame(0), Message::default())).unwrap();
            let bytes = writer.finish().unwrap().into_inner();
            assert_eq!(replayed(&bytes), (1, None));
            let length = bytes.len() as u64;
            assert_eq!(Replay::new(Cursor::new(bytes), length, "day.mcap".into()).camera(), stated);
        }
    }

    #[test]
    fn a_file_that_is_cut_anywhere_gives_its_whole_chunks() {
        let (bytes, ends) = recording(3);
        for cut in 0..=bytes.len() {
            let whole = ends.iter().filter(|end| **end <= cut).count() as u64;
            let (read, why) = replayed(&bytes[..cut]);
            assert_eq!(read, whole, "{cut} of {ends:?}");
            assert_eq!(why.is_some(), whole == 0, "{cut}: {why:?}");
        }
    }

    #[test]
    fn a_damaged_chunk_is_never_read_as_a_frame() {
        let (bytes, ends) = recording(2);
        for at in ends[1] - 150..ends[1] {
            let mut damaged = bytes.clone();
            damaged[at] ^= 0x10;
            let (read, why) = replayed(&damaged);
            assert!(
                read == 1 && why.as_ref().is_some_and(|why| why.contains("frame 000000")),
                "{at}: {why:?}"
            );
        }
    }

    /// A file of another program: an image of an encoding on each of the topics.
    fn foreign(schema: &str, encoding: &str, topics: &[&str]) -> Vec<u8> {
        let mut writer = WriteOptions::new().compression(None).create(Cursor::new(Vec::new())).unwrap();
        let schema = writer.add_schema(schema, "protobuf", b"").unwrap();
        for (sequence, topic) in (5..).zip(topics) {
            let channel_id = writer.add_channel(schema, topic, "protobuf", &BTreeMap::new()).unwrap();
            let sizes = Message::default().fixed32(2, 2).fixed32(3, 1).fixed32(5, 4).text(4, encoding);
            let image = sizes.filled(6, 4, |to| to.copy_from_slice(&[1, 0, 2, 1]));
            let header = MessageHeader { channel_id, sequence, log_time: 1000, publish_time: 0 };
            writer.write_to_known_channel(&header, image.bytes()).unwrap();
        }
        writer.finish().unwrap();
        writer.into_inner().into_inner()
    }

    fn first(bytes: Vec<u8>) -> Vec<Result<Box<NewFrame>, String>> {
        let length = bytes.len() as u64;
        let mut replay = Replay::new(Cursor::new(bytes), length, "their.mcap".into());
        let next = || match replay.produce(None, Duration::ZERO) {
            Produced::Frame(frame) => Some(Ok(frame)),
            Produced::End(why) => why.map(Err),
            other => panic!("{other:?}"),
        };
        std::iter::from_fn(next).collect()
    }

    #[test]
    fn files_of_other_programs_are_read_by_order_and_time() {
        let frames = first(foreign("foxglove.RawImage", "mono16", &["/cam", "/cam"]));
        let frames: Vec<_> = frames.into_iter().map(Result::unwrap).collect();
        let numbers: Vec<_> = frames.iter().map(|f| (f.meta.sequence, f.remarks.stem.as_str())).collect();
        assert_eq!(numbers, [(0, "000000"), (1, "000001")]);
        assert_eq!(frames[1].meta.device_t, Some(Timestamp { t_ns: 1000, clock: Clock::Device }));
        let NewFrame { frame, .. } = *frames.into_iter().next().unwrap();
        assert_eq!(frame.view().format(), PixelFormat::Mono16);
        assert_eq!(frame.into_buffer(), Buffer::U16(vec![1, 258]));
    }

    #[test]
    fn what_cannot_be_read_is_named_with_what_would_be_right() {
        for (bytes, words) in [
            (
                foreign("foxglove.RawImage", "rgb8", &["/cam"]),
                ["topic /cam, frame 000000", "mono8 and mono16"],
            ),
            (foreign("foxglove.RawImage", "mono8", &["/a", "/b"]), ["/a and /b", "one camera"]),
            (
                foreign("foxglove.CompressedImage", "mono8", &["/jpeg"]),
                ["/jpeg (foxglove.CompressedImage", "RawImage"],
            ),
            (b"\x89PNG\r\n\x1a\n0000".to_vec(), ["their.mcap", "no MCAP file"]),
            (Vec::new(), ["their.mcap", "cut off"]),
        ] {
            let error = first(bytes).pop().unwrap().unwrap_err();
            assert!(words.iter().all(|word| error.contains(word)), "{error}");
        }
    }
}
