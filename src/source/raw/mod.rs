//! Pixels without an image format of their own, and Y4M.
//!
//! In: bytes of a file or a pipe, with the layout that the command line states (`layout`:
//! `2448x2048:mono12`) or that a Y4M header states (`y4m`). Out: frames to be decoded on other
//! threads, where `unpack` turns packed bytes into pixels; `stream` cuts the bytes into frames and
//! names the one within which they end. One more pixel format is a variant of `RawFormat` with its
//! size in `layout` and its bits in `unpack`.

pub(super) mod layout;
mod stream;
mod unpack;
mod y4m;

pub(crate) use self::layout::RawLayout;
pub(crate) use self::stream::{RawStream, begins_y4m};
