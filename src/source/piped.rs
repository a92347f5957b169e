//! Images that come one after another on a stream of bytes, as frames of the names `000000`,
//! `000001`, …

use std::io::BufRead;
use std::sync::Arc;

use super::decode::Wanted;
use super::error::{DecodeError, damaged};
use super::host_clock::host_t_ns;
use super::raster::Channel;
use super::read_error::ReadError;
use super::spare::Spare;
use super::split::{Piece, SplitError, next_image};
use super::stored::{Arrival, Coded, Taken, Undecoded};
use crate::frame::FrameMeta;

/// The images of a stream.
#[derive(Debug)]
pub(crate) struct Piped<R> {
    input: R,
    /// What errors call the stream.
    name: &'static str,
    channel: Option<Channel>,
    given: u64,
    has_ended: bool,
    spare: Spare,
}

impl<R: BufRead> Piped<R> {
    /// Images of `input`, which errors call `name`; of colour images this channel.
    pub(crate) fn new(input: R, name: &'static str, channel: Option<Channel>) -> Self {
        Self { input, name, channel, given: 0, has_ended: false, spare: Spare::default() }
    }

    /// Reads images into spare memory.
    pub(crate) fn reusing(self, spare: Spare) -> Self {
        Self { spare, ..self }
    }

    fn named(&self) -> String {
        format!("{}, image {:06}", self.name, self.given)
    }

    /// A whole image, or that the stream ended within it.
    fn taken(&mut self, piece: Piece) -> Taken {
        let named = self.named();
        let stem = format!("{:06}", self.given);
        let arrival = Arrival { stem: stem.clone(), host_t_ns: Some(host_t_ns()), ..Arrival::default() };
        let meta = FrameMeta { frame_id: self.given, ..FrameMeta::default() };
        let wanted = Wanted { channel: self.channel, ..Wanted::default() };
        self.given += 1;
        Ok((
            arrival,
            match piece {
                Piece::Whole(bytes) => {
                    let (coded, content) = (Coded::Image, Arc::new(bytes));
                    Ok(Undecoded { stem, named, coded, content, wanted, meta, stated: None })
                }
                Piece::Cut => {
                    Err(ReadError::Decode { path: named, cause: damaged("the stream ends within it") })
                }
            },
        ))
    }
}

impl<R: BufRead> Iterator for Piped<R> {
    type Item = Taken;

    fn next(&mut self) -> Option<Taken> {
        if self.has_ended {
            return None;
        }
        let next = next_image(&mut self.input, self.spare.file());
        self.has_ended = !matches!(next, Ok(Some(Piece::Whole(_))));
        match next {
            Ok(piece) => Some(self.taken(piece?)),
            Err(SplitError::Io(cause)) => Some(Err(ReadError::Io { path: self.named(), cause })),
            Err(SplitError::NoEnd(what)) => {
                let right = "its end cannot be found; images one after another are PNG, raw PGM and its kin, BMP or \
                             JPEG (others: as files, or in a folder)";
                let cause = DecodeError::Unsupported(format!("{what}: {right}"));
                Some(Err(ReadError::Decode { path: self.named(), cause }))
            }
        }
    }
}
