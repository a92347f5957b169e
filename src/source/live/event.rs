//! What comes from a live source.

use super::gap::Gap;
use super::metadata::LiveMeta;
use super::pool::Lease;
use crate::source::scale::FileScale;

/// What the source states of a frame beside its pixels; of cameras nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Remarks {
    /// Name of the frame: a file's stem, or the number of six digits.
    pub stem: String,
    /// Scale of the table or of the file's own tags.
    pub scale: Option<FileScale>,
    /// Changes made to the values of the file, in words.
    pub changed: Vec<String>,
    /// Notes for the user on the files.
    pub notices: Vec<String>,
}

/// A whole frame.
#[derive(Debug)]
pub(crate) struct LiveFrame {
    /// The frame in its place of the pool.
    pub lease: Lease,
    /// When and where it was taken.
    pub meta: LiveMeta,
    /// What its file states.
    pub remarks: Remarks,
}

/// What comes from a live source, in the order of the sequence numbers.
#[derive(Debug)]
pub(crate) enum Event {
    /// A whole frame.
    Frame(Box<LiveFrame>),
    /// Numbers without a frame.
    Gap(Gap),
    /// Nothing came within the time that was waited.
    Timeout,
    /// The source disappeared, and why; frames may come again.
    Lost(String),
    /// Nothing will come until the source is started again; with the reason where it failed.
    End(Option<String>),
}
