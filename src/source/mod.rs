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

pub use decode::{Decoded, Wanted, decode, decode_wanted, pages};
pub use error::DecodeError;
pub use folder::{FileFrames, Listing, ReadError, StoredFrame, list_images, listing, out_of_order};
pub use frame_table::{FrameInfo, FrameTable, TableError};
pub use natural_order::natural;
pub use raster::Channel;
pub use scale::{FileScale, SAME_SCALE, Trust};
