//! Grey values as a stream carries them: seven formats of the PFNC (EMVA, Pixel Format Naming
//! Convention 2.x) with their 32-bit codes of GigE Vision.

use crate::frame::{FrameView, PixelFormat, Pixels};

/// Format of the pixels of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StreamFormat {
    /// A byte a pixel.
    Mono8,
    /// 10 bits in 16, little-endian, unshifted.
    Mono10,
    /// 10 bits a pixel, the least significant first, without gaps.
    Mono10p,
    /// 12 bits in 16, little-endian, unshifted.
    Mono12,
    /// 12 bits a pixel, the least significant first, without gaps.
    Mono12p,
    /// GigE Vision's own: two pixels in three bytes, upper bits in the outer two.
    Mono12Packed,
    /// 16 bits, little-endian.
    Mono16,
}

impl StreamFormat {
    /// All formats, with their names in the PFNC.
    pub(crate) const ALL: [(Self, &'static str); 7] = [
        (Self::Mono8, "Mono8"),
        (Self::Mono10, "Mono10"),
        (Self::Mono10p, "Mono10p"),
        (Self::Mono12, "Mono12"),
        (Self::Mono12p, "Mono12p"),
        (Self::Mono12Packed, "Mono12Packed"),
        (Self::Mono16, "Mono16"),
    ];

    /// The code of the PFNC: 01 (mono), bits that a pixel occupies, number of the format.
    pub(crate) const fn code(self) -> u32 {
        match self {
            Self::Mono8 => 0x0108_0001,
            Self::Mono10 => 0x0110_0003,
            Self::Mono10p => 0x010a_0046,
            Self::Mono12 => 0x0110_0005,
            Self::Mono12p => 0x010c_0047,
            Self::Mono12Packed => 0x010c_0006,
            Self::Mono16 => 0x0110_0007,
        }
    }

    /// The format of a code.
    pub(crate) fn from_code(code: u32) -> Option<Self> {
        Self::ALL.iter().map(|(format, _)| *format).find(|format| format.code() == code)
    }

    /// Bits that a pixel occupies.
    pub(crate) const fn bits(self) -> usize {
        (self.code() >> 16 & 0xff) as usize
    }

    /// Grey values of the frame that is streamed in this format.
    pub(crate) const fn grey(self) -> PixelFormat {
        match self {
            Self::Mono8 => PixelFormat::Mono8,
            Self::Mono10 | Self::Mono10p => PixelFormat::Mono10,
            Self::Mono12 | Self::Mono12p | Self::Mono12Packed => PixelFormat::Mono12,
            Self::Mono16 => PixelFormat::Mono16,
        }
    }

    /// The format in which a sensor of these grey values streams without loss.
    pub(crate) const fn of_sensor(grey: PixelFormat) -> Self {
        match grey {
            PixelFormat::Mono8 => Self::Mono8,
            PixelFormat::Mono10 => Self::Mono10,
            PixelFormat::Mono12 => Self::Mono12,
            PixelFormat::Mono14 | PixelFormat::Mono16 | PixelFormat::F32 => Self::Mono16,
        }
    }
}

/// Bytes of `pixels` pixels; packed formats run on from line to line, the last byte is filled up.
pub(crate) fn packed_bytes(format: StreamFormat, pixels: usize) -> usize {
    // two pixels of Mono12Packed share their middle byte: an odd last one takes two bytes
    (pixels * format.bits()).div_ceil(8)
}

/// Appends a frame's pixels, row by row; `false`, and nothing appended, where the frame has other
/// grey values than the format, or is strided.
pub(crate) fn pack(view: &FrameView<'_>, format: StreamFormat, out: &mut Vec<u8>) -> bool {
    let count = view.rows() * view.columns();
    if view.format() != format.grey() || view.row_stride() != view.columns() || view.column_stride() != 1 {
        return false;
    }
    match (view.pixels(), format) {
        (Pixels::U8(p), StreamFormat::Mono8) => out.extend_from_slice(&p[..count]),
        (Pixels::U16(p), StreamFormat::Mono10p) => bits_of::<10, 4, 5>(&p[..count], out),
        (Pixels::U16(p), StreamFormat::Mono12p) => bits_of::<12, 2, 3>(&p[..count], out),
        (Pixels::U16(p), StreamFormat::Mono12Packed) => packed_12(&p[..count], out),
        (Pixels::U16(p), _) => out.extend(p[..count].iter().flat_map(|grey| grey.to_le_bytes())),
        _ => return false,
    }
    true
}

/// Grey values of `BITS` bits, the least significant first: `PIXELS` of them fill `BYTES` bytes.
fn bits_of<const BITS: u32, const PIXELS: usize, const BYTES: usize>(grey: &[u16], out: &mut Vec<u8>) {
    let joined = |pixels: &[u16]| {
        pixels.iter().rev().fold(0_u64, |bits, grey| bits << BITS | u64::from(*grey & ((1 << BITS) - 1)))
    };
    let (groups, rest) = grey.as_chunks::<PIXELS>();
    for group in groups {
        out.extend_from_slice(&joined(group).to_le_bytes()[..BYTES]);
    }
    let bytes = (rest.len() * BITS as usize).div_ceil(8);
    out.extend_from_slice(&joined(rest).to_le_bytes()[..bytes]);
}

/// A pixel pair as: bits 11 to 4 of the first; bits 3 to 0 of the second and of the first; bits 11
/// to 4 of the second.
fn packed_12(grey: &[u16], out: &mut Vec<u8>) {
    let upper = |grey: u16| (grey >> 4 & 0xff) as u8;
    let lower = |grey: u16| (grey & 0x0f) as u8;
    let (pairs, rest) = grey.as_chunks::<2>();
    for [a, b] in pairs {
        out.extend_from_slice(&[upper(*a), lower(*b) << 4 | lower(*a), upper(*b)]);
    }
    if let [a] = rest {
        out.extend_from_slice(&[upper(*a), lower(*a)]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn packed(grey: &[u16], format: StreamFormat) -> Vec<u8> {
        let view = FrameView::new(Pixels::U16(grey), format.grey(), 1, grey.len(), grey.len()).unwrap();
        let mut out = Vec::new();
        assert!(pack(&view, format, &mut out));
        assert_eq!(out.len(), packed_bytes(format, grey.len()));
        out
    }

    /// Pixel `k` of a bit stream, the least significant first: the definition, bit by bit.
    fn bit_by_bit(bytes: &[u8], bits: usize, k: usize) -> u16 {
        let bit = |at: usize| u16::from(bytes[at / 8] >> (at % 8) & 1);
        (0..bits).map(|b| bit(k * bits + b) << b).sum()
    }

    #[test]
    fn packed_formats_are_the_published_ones() {
        assert_eq!(packed(&[0x123, 0xabc], StreamFormat::Mono12p), [0x23, 0xc1, 0xab]);
        assert_eq!(packed(&[0x123, 0xabc], StreamFormat::Mono12Packed), [0x12, 0xc3, 0xab]);
        assert_eq!(packed(&[0x123, 0xabc, 0xfed], StreamFormat::Mono12Packed)[3..], [0xfe, 0x0d]);
        assert_eq!(packed(&[0x3ff, 0, 0x3ff, 0], StreamFormat::Mono10p), [0xff, 0x03, 0xf0, 0x3f, 0]);
        assert_eq!(packed(&[0x0102, 0xfffe], StreamFormat::Mono16), [2, 1, 0xfe, 0xff]);
    }

    #[test]
    fn a_bit_stream_read_bit_by_bit_gives_the_grey_values_at_any_length() {
        for (format, bits) in [(StreamFormat::Mono10p, 10), (StreamFormat::Mono12p, 12)] {
            for length in 1..40_usize {
                let grey: Vec<u16> =
                    (0..length).map(|k| (k * 2654435761) as u16 & ((1 << bits) - 1)).collect();
                let bytes = packed(&grey, format);
                let back: Vec<u16> = (0..length).map(|k| bit_by_bit(&bytes, bits, k)).collect();
                assert_eq!(back, grey, "{format:?}, {length} pixels");
            }
        }
    }

    #[test]
    fn codes_carry_the_bits_of_a_pixel_and_grey_values_that_do_not_fit_are_refused() {
        let bits = StreamFormat::ALL.map(|(format, _)| format.bits());
        assert_eq!(bits, [8, 16, 10, 16, 12, 12, 16]);
        for (format, name) in StreamFormat::ALL {
            assert_eq!(StreamFormat::from_code(format.code()), Some(format), "{name}");
        }
        assert_eq!(StreamFormat::from_code(0x0210_0014), None);
        let grey = [1_u16, 2];
        let view = FrameView::new(Pixels::U16(&grey), PixelFormat::Mono12, 1, 2, 2).unwrap();
        let mut out = Vec::new();
        assert!(!pack(&view, StreamFormat::Mono10, &mut out) && out.is_empty());
    }
}
