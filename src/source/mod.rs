//! Frames from files and folders.
//!
//! In: a file or folder (`folder`, in the order of `natural_order`, with `frame_table` where there
//! is a `frames.csv`). Out: frames with their scale and encoding. `decode` chooses the reader of a
//! format (`png`, `tiff`, `jpeg`, `bmp`, `pnm`); each returns a `raster` of channels, which
//! `depth`, `transfer`, `orientation`, `packed` and `relaid` convert to the pixels of a frame. A
//! new format is a file with a function from bytes to a raster, an entry in `decode` and one in
//! `extension`.

mod bmp;
mod decode;
mod depth;
mod error;
mod extension;
mod folder;
mod frame_table;
mod ifd;
mod jpeg;
mod natural_order;
mod orientation;
mod packed;
mod png;
mod pnm;
mod raster;
mod relaid;
mod scale;
mod tiff;
mod transfer;

pub use self::{
    decode::{Wanted, decode, decode_wanted},
    error::DecodeError,
    folder::{FileFrames, StoredFrame},
    raster::Channel,
    scale::FileScale,
};
pub(crate) use folder::{list_images, listing, out_of_order};
pub(crate) use scale::SAME_SCALE;
