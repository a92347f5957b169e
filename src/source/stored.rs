//! A frame between its source and the gauge: read, then decoded.

use std::sync::Arc;

use super::decode::{Wanted, decode_into};
use super::raw::layout::RawLayout;
use super::read_error::ReadError;
use super::scale::FileScale;
use super::spare::Spare;
use crate::frame::{Frame, FrameMeta};

/// A frame, the name of its file (with its page: `stack#3`), and what the file's own tags state.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredFrame {
    /// The file's stem; `stem#page`, counted from 0, where the file has several pages.
    pub stem: String,
    /// The frame.
    pub frame: Frame,
    /// Scale of the table or of the file's own tags.
    pub scale: Option<FileScale>,
    /// Changes made to the values of the file, in words.
    pub changed: Vec<String>,
}

/// A frame's name and times, as its source states them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Arrival {
    /// The file's stem, with its page where the file has several; the number of an image of a
    /// stream.
    pub stem: String,
    /// Start of exposure on the device's clock, ns, where a table of frames states it.
    pub device_t_ns: Option<u64>,
    /// When this machine had the image, ns since 1970; of streams.
    pub host_t_ns: Option<u64>,
    /// Temperature of the head by its own sensor, °C; of cameras and recordings.
    pub head_c: Option<f64>,
    /// Frames lost before this one, where its source shows them.
    pub lost: u64,
    /// Notes for the user on the files.
    pub notices: Vec<String>,
}

/// A frame that is to be decoded, or why it cannot be read.
pub(super) type TakenFrame = (Arrival, Result<Undecoded, ReadError>);

/// What a source gives: a frame, or why it cannot be read; the outer error ends the source.
pub(crate) type Taken = Result<TakenFrame, ReadError>;

/// What the bytes of a frame are.
#[derive(Clone, Debug, Default)]
pub(crate) enum Coded {
    /// An image in a format of its own.
    #[default]
    Image,
    /// Pixels of a layout that is known.
    Raw(RawLayout),
    /// None: the frame itself, with what its source states of it.
    Ready(Box<StoredFrame>),
}

/// The image of a frame, with what is known of it beside its file.
#[derive(Clone, Debug)]
pub(crate) struct Undecoded {
    /// As in [`Arrival`].
    pub stem: String,
    /// What errors name: the file with its page, or the stream with the image's number.
    pub named: String,
    /// What its bytes are.
    pub coded: Coded,
    /// All bytes of its file.
    pub content: Arc<Vec<u8>>,
    /// The frame among them, and how it is decoded.
    pub wanted: Wanted,
    /// Its metadata.
    pub meta: FrameMeta,
    /// Scale of `frames.csv`, µm per pixel, and the row that states it.
    pub stated: Option<(f64, usize)>,
}

impl Undecoded {
    /// Decodes the frame, in spare memory; leaves that of its file where no other page needs it.
    ///
    /// # Errors
    /// An image that is no grey frame, or whose own scale differs from that of `frames.csv`.
    pub(super) fn decode(self, spare: &Spare) -> Result<StoredFrame, ReadError> {
        let Self { stem, named, coded, content, wanted, meta, stated } = self;
        let decoded = match coded {
            Coded::Image => decode_into(&content, &wanted, meta, spare),
            Coded::Raw(layout) => layout.decode(&content, meta, spare),
            Coded::Ready(stored) => return Ok(*stored),
        };
        Arc::try_unwrap(content).into_iter().for_each(|file| spare.take_file(file));
        let decoded = decoded.map_err(|cause| ReadError::Decode { path: named.clone(), cause })?;
        let mut scale = decoded.scale;
        if let Some((um_per_px, row)) = stated {
            let table = format!("frames.csv (row {row})");
            let own = scale.as_ref().map_or(Ok(()), |own| own.check(um_per_px, &table));
            own.map_err(|what| ReadError::Scale {
                path: named,
                what: format!("{what}; correct the one that is wrong"),
            })?;
            scale = Some(FileScale::stated(um_per_px, table));
        }
        Ok(StoredFrame { stem, frame: decoded.frame, scale, changed: decoded.changed })
    }
}
