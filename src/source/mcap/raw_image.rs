//! Pixels as `foxglove.RawImage` and back.

use super::wire::{Damaged, Fields, Message};
use crate::frame::{Buffer, Frame, FrameMeta, PixelFormat, Pixels};

/// An image as its message has it.
#[derive(Clone, Debug, Default)]
pub(super) struct RawImage<'a> {
    width: usize,
    height: usize,
    step: usize,
    encoding: String,
    data: &'a [u8],
}

/// The message of a frame that was taken at a time, ns since 1970; `spent` is memory of an earlier
/// one.
pub(super) fn encoded(frame: &Frame, t_ns: u64, name: &str, spent: Message) -> Message {
    let view = frame.view();
    let (width, height) = (view.columns(), view.rows());
    let (encoding, bytes) = match view.pixels() {
        Pixels::U8(_) => ("mono8", 1),
        Pixels::U16(_) => ("mono16", 2),
        Pixels::F32(_) => ("32FC1", 4),
    };
    let length = bytes * width * height;
    let stamp = Message::default().varint(1, t_ns / 1_000_000_000).varint(2, t_ns % 1_000_000_000);
    // The fields before the pixels take some tens of bytes and the name.
    let message = Message::of_capacity(length + 128 + name.len(), spent)
        .message(1, &stamp)
        .fixed32(2, u32::try_from(width).unwrap_or(u32::MAX))
        .fixed32(3, u32::try_from(height).unwrap_or(u32::MAX))
        .text(4, encoding)
        .fixed32(5, u32::try_from(bytes * width).unwrap_or(u32::MAX));
    let message = match view.pixels() {
        Pixels::U8(p) => message.data(6, p),
        Pixels::U16(p) => message.filled(6, length, |to| {
            to.chunks_exact_mut(2).zip(p).for_each(|(b, v)| b.copy_from_slice(&v.to_le_bytes()));
        }),
        Pixels::F32(p) => message.filled(6, length, |to| {
            to.chunks_exact_mut(4).zip(p).for_each(|(b, v)| b.copy_from_slice(&v.to_le_bytes()));
        }),
    };
    message.text(7, name)
}

impl<'a> RawImage<'a> {
    /// Reads the message.
    ///
    /// # Errors
    /// Bytes that are no protobuf.
    pub(super) fn of(bytes: &'a [u8]) -> Result<Self, Damaged> {
        let mut image = Self::default();
        for field in Fields::of(bytes) {
            let (number, value) = field?;
            let size = || usize::try_from(value.number()).unwrap_or(usize::MAX);
            match number {
                2 => image.width = size(),
                3 => image.height = size(),
                4 => image.encoding = value.text(),
                5 => image.step = size(),
                6 => image.data = value.bytes(),
                _ => {}
            }
        }
        Ok(image)
    }

    /// The frame, of a format that is narrower than its container where one is stated; `spare` is
    /// memory of an earlier frame.
    ///
    /// # Errors
    /// An encoding other than grey, and data that do not fit size and step.
    pub(super) fn frame(
        &self,
        stated: Option<PixelFormat>,
        meta: FrameMeta,
        spare: Option<Frame>,
    ) -> Result<Frame, String> {
        let spare = spare.map(Frame::into_buffer);
        let (buffer, own) = match self.encoding.as_str() {
            "mono8" | "8UC1" => (Buffer::U8(self.rows::<1, u8>(u8_of(spare), |[b]| b)?), PixelFormat::Mono8),
            "mono16" | "16UC1" => {
                (Buffer::U16(self.rows(u16_of(spare), u16::from_le_bytes)?), PixelFormat::Mono16)
            }
            "32FC1" => (Buffer::F32(self.rows(f32_of(spare), f32::from_le_bytes)?), PixelFormat::F32),
            other => return Err(format!("encoding \"{other}\": a gauge reads mono8 and mono16")),
        };
        let format = stated.unwrap_or(own);
        Frame::new(buffer, format, self.height, self.width, meta).map_err(|error| error.to_string())
    }

    fn rows<const N: usize, T>(
        &self,
        mut to: Vec<T>,
        value: impl Fn([u8; N]) -> T,
    ) -> Result<Vec<T>, String> {
        let Self { width, height, step, data, .. } = self;
        let row = width.saturating_mul(N);
        let needed = height.saturating_sub(1).saturating_mul(*step).saturating_add(row);
        if *width == 0 || *height == 0 || *step < row || data.len() < needed {
            return Err(format!(
                "{width} x {height} pixels of {N} bytes at a step of {step} bytes do not fit {} bytes of data: \
                 a step of at least {row} and {needed} bytes are needed",
                data.len()
            ));
        }
        to.clear();
        to.reserve_exact(width * height);
        for row in data.chunks(*step).take(*height) {
            to.extend(row.as_chunks::<N>().0[..*width].iter().map(|bytes| value(*bytes)));
        }
        Ok(to)
    }
}

fn u8_of(spare: Option<Buffer>) -> Vec<u8> {
    if let Some(Buffer::U8(pixels)) = spare { pixels } else { Vec::new() }
}

fn u16_of(spare: Option<Buffer>) -> Vec<u16> {
    if let Some(Buffer::U16(pixels)) = spare { pixels } else { Vec::new() }
}

fn f32_of(spare: Option<Buffer>) -> Vec<f32> {
    if let Some(Buffer::F32(pixels)) = spare { pixels } else { Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(encoding: &str, [width, height, step]: [u32; 3], data: &[u8]) -> Message {
        let sizes = Message::default().fixed32(2, width).fixed32(3, height).fixed32(5, step);
        sizes.text(4, encoding).filled(6, data.len(), |to| to.copy_from_slice(data))
    }

    #[test]
    fn padded_rows_are_read_and_little_endian() {
        let bytes = message("mono16", [2, 2, 6], &[1, 2, 3, 4, 9, 9, 5, 6, 7, 8]);
        let frame = RawImage::of(bytes.bytes()).unwrap().frame(None, FrameMeta::default(), None).unwrap();
        assert_eq!(frame.into_buffer(), Buffer::U16(vec![0x201, 0x403, 0x605, 0x807]));
    }

    #[test]
    fn the_message_of_a_frame_is_exact() {
        let buffer = Buffer::U16(vec![0x201, 0x403]);
        let frame = Frame::new(buffer, PixelFormat::Mono12, 1, 2, FrameMeta::default()).unwrap();
        let right = [
            &[0x0a, 4, 8, 1, 0x10, 2][..], // 1 s and 2 ns
            &[0x15, 2, 0, 0, 0, 0x1d, 1, 0, 0, 0],
            b"\x22\x06mono16",
            &[0x2d, 4, 0, 0, 0, 0x32, 4, 1, 2, 3, 4],
            b"\x3a\x01a",
        ];
        let spent = Message::default().text(1, "an earlier one");
        assert_eq!(encoded(&frame, 1_000_000_002, "a", spent).bytes(), right.concat());
    }

    #[test]
    fn what_is_no_grey_image_is_refused_with_what_would_be_right() {
        for (bytes, word) in [
            (message("rgb8", [1, 1, 3], &[1, 2, 3]), "mono8 and mono16"),
            (message("mono8", [2, 2, 2], &[1, 2, 3]), "4 bytes are needed"),
            (message("mono16", [2, 1, 2], &[1, 2, 3, 4]), "step of at least 4"),
            (message("mono8", [0, 2, 2], &[1, 2, 3]), "0 x 2"),
            (message("mono8", [u32::MAX, u32::MAX, u32::MAX], &[1]), "are needed"),
        ] {
            let image = RawImage::of(bytes.bytes()).unwrap();
            let error = image.frame(None, FrameMeta::default(), None).unwrap_err();
            assert!(error.contains(word), "{error}");
        }
    }
}
