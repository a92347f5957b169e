//! Recordings in MCAP (<https://mcap.dev/spec>), written and read.
//!
//! In: live frames on their way to the gauge (`tap`, a [`Producer`](crate::source::live) around
//! another one), or a file. Out: a file whose every chunk ends with a whole frame: a process that
//! is killed leaves all frames but those of the last quarter of a second; the frames of a file
//! with their metadata to the bit (`replay`, a `Producer`). A frame is two messages in protobuf:
//! `foxglove.RawImage`, which other programs show (`raw_image`), and `shadowgauge.Frame` with what
//! is known beside the pixels (`frame_message`); before the first one stands the camera, to which a
//! calibration is bound (`camera_record`). `wire` is the encoding of protobuf, `schema` the
//! descriptors of both messages. One more fact of a frame is a field in `schema` and
//! `frame_message`, of a number not used before; one more encoding of pixels an arm in `raw_image`.
#![cfg_attr(not(feature = "cli"), allow(dead_code, unused_imports, reason = "the program alone records"))]

mod camera_record;
mod frame_message;
mod raw_image;
mod reader;
mod records;
mod replay;
mod schema;
mod tap;
mod wire;
mod writer;

pub(crate) use self::replay::Replay;
pub(crate) use self::tap::{Recorded, Tap};
