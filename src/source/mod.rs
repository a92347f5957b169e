//! Frames from files and folders.
//!
//! In: a file or folder (`folder`, in the order of `natural_order`, with `frame_table` where there
//! is a `frames.csv`), a folder that a camera drops images into (`follow`), images one after
//! another on a stream (`piped`, by `split`). Out: frames with their scale and encoding (`stored`),
//! decoded on other threads where `ahead` is asked, in memory that is used again (`spare`). `raw`
//! are pixels without a header of their own and Y4M, `live` sources with events, leases and counted
//! losses, `camera` GigE Vision cameras (feature `camera`), `commanded` what a cell asks of a head
//! that takes frames by triggers, `mcap` recordings, `address` the grammar of SOURCE. `recording`
//! is the folder of a recorded run. `decode` chooses the reader of a format (`png`, `tiff`, `jpeg`,
//! `bmp`, `pnm`); each returns a `raster` of channels, which `depth`, `transfer`, `orientation`,
//! `packed` and `relaid` convert to the pixels of a frame. A new format is a file with a function
//! from bytes to a raster, an entry in `decode` and one in `extension`; it comes on a stream where
//! `split` finds its end.

mod address;
mod ahead;
mod bmp;
#[cfg(feature = "camera")]
pub(crate) mod camera;
#[cfg(feature = "camera")]
pub(crate) mod commanded;
mod decode;
mod depth;
#[cfg(feature = "render")]
mod digest;
mod encoder_rows;
mod error;
mod extension;
mod folder;
mod follow;
mod frame_info;
mod frame_table;
mod host_clock;
mod ifd;
mod jpeg;
pub(crate) mod live;
#[cfg(feature = "mcap")]
pub(crate) mod mcap;
mod natural_order;
mod orientation;
mod packed;
mod piped;
mod png;
mod pnm;
mod raster;
pub(crate) mod raw;
mod read_error;
#[cfg(feature = "render")]
mod recording;
mod relaid;
mod scale;
mod spare;
mod split;
mod stored;
mod tiff;
mod transfer;

pub use self::{
    decode::{Wanted, decode, decode_wanted},
    error::DecodeError,
    folder::FileFrames,
    raster::Channel,
    scale::FileScale,
    stored::StoredFrame,
};
pub(crate) use address::Address;
pub(crate) use ahead::Ahead;
#[cfg(feature = "render")]
pub(crate) use digest::{digest_of_all, hexadecimal, image_digests, sha256_hex};
pub(crate) use folder::{list_images, listing, out_of_order};
pub(crate) use follow::Follow;
pub(crate) use host_clock::host_t_ns;
pub(crate) use piped::Piped;
pub(crate) use read_error::ReadError;
#[cfg(feature = "render")]
pub(crate) use recording::{RecordedScan, Recording, check_places};
pub(crate) use scale::SAME_SCALE;
pub(crate) use spare::Spare;
pub(crate) use stored::{Arrival, Taken};
