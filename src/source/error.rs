//! Errors of decoding, and the largest frame.

use thiserror::Error;

/// Most pixels of an image: 16 times the largest sensors in use, so that a short header cannot
/// request all memory.
pub(super) const MOST_PIXELS: u64 = 1 << 28;

/// Longest side of an image, px.
const LONGEST_SIDE: u32 = 65_535;

/// Why bytes are not a grey frame.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum DecodeError {
    /// No byte at all.
    #[error("the file is empty; a grey PNG, TIFF, JPEG, BMP or PGM image is needed")]
    Empty,
    /// Not an image.
    #[error("not an image in a known format; a grey PNG, TIFF, JPEG, BMP or PGM image is needed")]
    NotAnImage,
    /// An image that ends early or is damaged.
    #[error("damaged or truncated image: {0}; a whole file is needed: record or copy it again")]
    Damaged(String),
    /// An unsupported variant of a known format.
    #[error("{0}")]
    Unsupported(String),
    /// Channels that are neither grey nor red, green and blue.
    #[error("{0}; one grey channel without transparency is needed, or red, green and blue")]
    NotGrey(String),
    /// A colour image of which no channel was chosen.
    #[error(
        "a colour image: red {}, green {}, blue {} at row {row}, column {column}; one grey channel is needed: choose one \
         (--channel r|g|b) or record in grey", value[0], value[1], value[2]
    )]
    Coloured {
        /// Row of the first pixel of unequal channels.
        row: usize,
        /// Its column.
        column: usize,
        /// Its red, green and blue.
        value: [f64; 3],
    },
    /// Pixels that are transparent.
    #[error(
        "a pixel that is not opaque at row {row}, column {column}; a grey image without transparency is needed"
    )]
    Transparent {
        /// Its row.
        row: usize,
        /// Its column.
        column: usize,
    },
    /// A stream that ends within a frame.
    #[error("the stream ends within it: {had} bytes of {needed}")]
    Cut {
        /// Bytes that came.
        had: u64,
        /// Bytes of a frame.
        needed: u64,
    },
    /// A raw grey value that its format does not have.
    #[error(
        "a grey value of {found} at row {row}, column {column}, but {format} reaches to {most}: its bytes are little endian and \
         its values right-aligned; state the format that the camera writes (--raw WIDTHxHEIGHT:FORMAT)"
    )]
    BeyondRaw {
        /// The value.
        found: u16,
        /// Its row.
        row: usize,
        /// Its column.
        column: usize,
        /// The format stated.
        format: &'static str,
        /// Its largest value.
        most: u16,
    },
    /// Grey values in an unsupported encoding.
    #[error("encoded grey values: {0}")]
    Encoding(String),
    /// An image too large to be a frame.
    #[error(
        "{columns} x {rows} pixels are more than a frame may have ({LONGEST_SIDE} a side, {MOST_PIXELS} in all); crop it"
    )]
    TooLarge {
        /// Pixels in a row.
        columns: u32,
        /// Rows.
        rows: u32,
    },
    /// A JPEG whose whole picture is kept as coefficients while it is decoded: three times the
    /// frame's memory.
    #[error("a progressive JPEG; save it as a baseline JPEG, or without loss as PNG, TIFF, BMP or PGM")]
    Progressive,
    /// A JPEG of few and long rows: strips of eight take more memory than the frame.
    #[error(
        "a JPEG of {columns} x {rows} pixels takes more than twice its memory to decode; save it as PNG, TIFF, BMP or PGM"
    )]
    FlatJpeg {
        /// Pixels in a row.
        columns: usize,
        /// Rows.
        rows: usize,
    },
    /// A bit depth that does not determine full scale.
    #[error("a bit depth of {0}; 8, 10, 12, 14 or 16 are needed")]
    Depth(u8),
    /// Values that exceed the stated bit depth.
    #[error("a grey value of {found} in a frame said to have {bits} bits, which reach to {}; state the depth of the camera in the file or in frames.csv (bit_depth)", (1_u32 << bits) - 1)]
    BeyondDepth {
        /// Largest value.
        found: String,
        /// Stated bit depth.
        bits: u8,
    },
}

pub(super) fn check_size(columns: u32, rows: u32) -> Result<(), DecodeError> {
    let fits = u64::from(columns) * u64::from(rows) <= MOST_PIXELS;
    if fits && columns <= LONGEST_SIDE && rows <= LONGEST_SIDE {
        Ok(())
    } else {
        Err(DecodeError::TooLarge { columns, rows })
    }
}

pub(super) fn damaged(error: impl std::fmt::Display) -> DecodeError {
    DecodeError::Damaged(error.to_string())
}
