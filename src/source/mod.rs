//! Where frames come from when they are not rendered: files and folders (cameras later).

mod decode;
mod folder;
mod jpeg;

pub use decode::{DecodeError, decode};
pub use folder::{FileFrames, FrameInfo, FrameTable, ReadError, StoredFrame, list_images};
