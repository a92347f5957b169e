//! A stream of bytes into the images in it, one after another, by what each format states of its
//! own length. Nothing is read beyond the end of an image, so that it is given as soon as it is
//! whole.
//!
//! PNG: chunks up to `IEND` (PNG, third edition, 5.3). Raw PNM: header and samples (Netpbm). BMP:
//! the size in its header. JPEG: segments, and entropy-coded data up to the next marker, to `EOI`
//! (T.81 B.1). TIFF states nothing of the kind, nor do plain PNM.

use std::io::{self, BufRead, Read as _};

use super::pnm;
use super::read_error::LARGEST_FILE;

/// Longest header of a PNM, bytes: some numbers, and comments as cameras write them.
const LONGEST_HEADER: usize = 4096;
/// Least size of a BMP: its file header and the shortest picture header.
const LEAST_BMP: usize = 26;

/// The next image of a stream.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Piece {
    /// A whole image.
    Whole(Vec<u8>),
    /// The stream ended within it.
    Cut,
}

/// Why a stream cannot be split any further.
#[derive(Debug)]
pub(super) enum SplitError {
    /// It cannot be read.
    Io(io::Error),
    /// Its next bytes begin nothing whose end can be found: what they are.
    NoEnd(&'static str),
}

impl From<io::Error> for SplitError {
    fn from(cause: io::Error) -> Self {
        Self::Io(cause)
    }
}

/// The next image, in empty memory, white space before it left out; `None` at the end of the
/// stream.
///
/// # Errors
/// A stream that fails; bytes that begin no image whose end can be found.
pub(super) fn next_image(input: &mut impl BufRead, bytes: Vec<u8>) -> Result<Option<Piece>, SplitError> {
    if !skip_space(input)? {
        return Ok(None);
    }
    let mut image = Image { input, bytes };
    let whole = image.fill(2)? && image.read_on()?;
    Ok(Some(if whole { Piece::Whole(image.bytes) } else { Piece::Cut }))
}

/// Whether a PNG is there up to its own end; `None` of another format.
pub(super) fn is_whole_png(bytes: &[u8]) -> Option<bool> {
    let mut rest = bytes.strip_prefix(b"\x89PNG\r\n\x1a\n")?;
    // Length and name of a chunk, its data, their check sum.
    while let [a, b, c, d, name @ ..] = rest
        && let Some(name) = name.get(..4)
    {
        let size = (u32::from_be_bytes([*a, *b, *c, *d]) as usize).saturating_add(12);
        let Some(after) = rest.get(size..) else { break };
        if name == b"IEND" {
            return Some(true);
        }
        rest = after;
    }
    Some(false)
}

/// Skips white space; whether anything follows.
fn skip_space(input: &mut impl BufRead) -> io::Result<bool> {
    loop {
        let ahead = input.fill_buf()?;
        if ahead.is_empty() {
            return Ok(false);
        }
        let space = ahead.iter().take_while(|b| b.is_ascii_whitespace()).count();
        let is_all = space == ahead.len();
        input.consume(space);
        if !is_all {
            return Ok(true);
        }
    }
}

/// An image of which some bytes are read.
struct Image<'a, R> {
    input: &'a mut R,
    bytes: Vec<u8>,
}

impl<R: BufRead> Image<'_, R> {
    /// Reads on to its end, by its first two bytes; whether all of it is there.
    fn read_on(&mut self) -> Result<bool, SplitError> {
        match (self.bytes[0], self.bytes[1]) {
            (0x89, b'P') => self.png(),
            (0xff, 0xd8) => self.jpeg(),
            (b'B', b'M') => self.bmp(),
            (b'P', b'4'..=b'7' | b'f' | b'F') => self.pnm(),
            (b'P', b'1'..=b'3') => Err(SplitError::NoEnd("a plain PNM")),
            (b'I', b'I') | (b'M', b'M') => Err(SplitError::NoEnd("a TIFF")),
            _ => Err(SplitError::NoEnd("not an image in a known format")),
        }
    }

    /// Reads until there are `to` bytes; whether there are.
    fn fill(&mut self, to: usize) -> Result<bool, SplitError> {
        if to as u64 > LARGEST_FILE {
            return Err(SplitError::NoEnd("an image larger than any recording of one frame"));
        }
        let missing = to.saturating_sub(self.bytes.len());
        self.input.by_ref().take(missing as u64).read_to_end(&mut self.bytes)?;
        Ok(self.bytes.len() >= to)
    }

    /// A number of the header, the upper byte first.
    fn number(&self, at: usize, size: usize) -> usize {
        self.bytes[at..at + size].iter().fold(0, |number, byte| number << 8 | usize::from(*byte))
    }

    fn png(&mut self) -> Result<bool, SplitError> {
        if !self.fill(8)? {
            return Ok(false);
        }
        loop {
            let at = self.bytes.len();
            if !self.fill(at + 8)? {
                return Ok(false);
            }
            let is_last = &self.bytes[at + 4..at + 8] == b"IEND";
            // Length and name, the data, their check sum.
            let end = at + 12 + self.number(at, 4);
            if !self.fill(end)? || is_last {
                return Ok(self.bytes.len() >= end);
            }
        }
    }

    fn bmp(&mut self) -> Result<bool, SplitError> {
        if !self.fill(6)? {
            return Ok(false);
        }
        let size = (0..4).rev().fold(0, |size, k| size << 8 | usize::from(self.bytes[2 + k]));
        if size < LEAST_BMP {
            return Err(SplitError::NoEnd("a BMP that leaves its size open"));
        }
        self.fill(size)
    }

    fn pnm(&mut self) -> Result<bool, SplitError> {
        loop {
            let at = self.bytes.len();
            if at > LONGEST_HEADER {
                return Err(SplitError::NoEnd("a PNM without a header"));
            }
            if !self.fill(at + 1)? {
                return Ok(false);
            }
            // A header ends in white space.
            if self.bytes[at].is_ascii_whitespace()
                && let Some(length) = pnm::length(&self.bytes)
            {
                return self.fill(length);
            }
        }
    }

    fn jpeg(&mut self) -> Result<bool, SplitError> {
        loop {
            match self.next_marker()? {
                None => return Ok(false),
                Some(0xd9) => return Ok(true),
                // Restarts and a second start have no data.
                Some(0x01 | 0xd0..=0xd8) => {}
                Some(_) => {
                    let at = self.bytes.len();
                    // The length counts its own two bytes.
                    if !self.fill(at + 2)? || !self.fill(at + self.number(at, 2).max(2))? {
                        return Ok(false);
                    }
                }
            }
        }
    }

    /// Reads to the next marker of a JPEG: 0xff followed by neither 0 (a grey value 0xff) nor 0xff.
    fn next_marker(&mut self) -> Result<Option<u8>, SplitError> {
        loop {
            let read = self.input.read_until(0xff, &mut self.bytes)?;
            if read == 0 || self.bytes.last() != Some(&0xff) {
                return Ok(None);
            }
            if self.bytes.len() as u64 > LARGEST_FILE {
                return Err(SplitError::NoEnd("a JPEG larger than any recording of one frame"));
            }
            let mut after = 0xff;
            while after == 0xff {
                let at = self.bytes.len();
                if !self.fill(at + 1)? {
                    return Ok(None);
                }
                after = self.bytes[at];
            }
            if after != 0 {
                return Ok(Some(after));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::{BufReader, Cursor};

    use image::{GrayImage, ImageFormat, Luma};

    use super::*;

    fn encoded(format: ImageFormat, seed: u32) -> Vec<u8> {
        let mut out = Cursor::new(Vec::new());
        let grey = |x: u32, y: u32| Luma([(x.wrapping_mul(37) ^ y.wrapping_mul(91) ^ seed) as u8]);
        GrayImage::from_fn(40, 30, grey).write_to(&mut out, format).unwrap();
        out.into_inner()
    }

    fn pgm(header: &str, pixels: usize) -> Vec<u8> {
        // Grey values that look like white space and like a header.
        let grey = (0..pixels).map(|i| b"P5 \n"[i % 4]);
        header.bytes().chain(grey).collect()
    }

    fn images() -> Vec<Vec<u8>> {
        let formats = [ImageFormat::Png, ImageFormat::Bmp, ImageFormat::Jpeg];
        let mut all: Vec<Vec<u8>> = (0..6).map(|i| encoded(formats[i % 3], i as u32)).collect();
        all.push(pgm("P5\n# a comment 9 9\n6 4 255\n", 24));
        all.push(pgm("P5 6 4\n4095 ", 48));
        all.push(pgm("P7\nWIDTH 3\nHEIGHT 2\nDEPTH 1\nMAXVAL 255\nTUPLTYPE GRAYSCALE\nENDHDR\n", 6));
        all
    }

    /// A reader that gives few bytes at a time.
    fn split(bytes: &[u8], capacity: usize) -> Vec<Piece> {
        let mut input = BufReader::with_capacity(capacity, bytes);
        std::iter::from_fn(|| next_image(&mut input, Vec::new()).unwrap()).collect()
    }

    #[test]
    fn images_come_back_as_they_were_sent() {
        let sent = images();
        let stream: Vec<u8> = sent.iter().flat_map(|image| [image.as_slice(), b"\n"].concat()).collect();
        let right: Vec<Piece> = sent.into_iter().map(Piece::Whole).collect();
        for capacity in [1, 7, 1 << 16] {
            assert_eq!(split(&stream, capacity), right, "{capacity}");
        }
    }

    #[test]
    fn an_image_is_given_before_anything_after_it_is_read() {
        for image in images() {
            let mut input = image.as_slice();
            assert_eq!(next_image(&mut input, Vec::new()).unwrap(), Some(Piece::Whole(image.clone())));
            assert!(input.is_empty());
            let long = [image.as_slice(), b"P"].concat();
            let mut input = long.as_slice();
            next_image(&mut input, Vec::new()).unwrap();
            assert_eq!(input, b"P");
        }
    }

    #[test]
    fn an_image_that_ends_early_is_cut() {
        for image in images() {
            for end in [1, image.len() / 2, image.len() - 1] {
                assert_eq!(split(&image[..end], 64), [Piece::Cut], "{end} of {}", image.len());
            }
        }
    }

    #[test]
    fn what_states_no_end_is_named() {
        for (bytes, word) in [
            (&b"II*\0aaaa"[..], "TIFF"),
            (b"MM\0*aaaa", "TIFF"),
            (b"P2 2 2 255 1 2 3 4", "plain PNM"),
            (b"hello", "not an image"),
            (b"BM\0\0\0\0\0\0", "leaves its size open"),
        ] {
            match next_image(&mut &bytes[..], Vec::new()) {
                Err(SplitError::NoEnd(what)) => assert!(what.contains(word), "{what}"),
                other => panic!("{other:?}"),
            }
        }
        assert_eq!(next_image(&mut &b" \n"[..], Vec::new()).unwrap(), None);
    }
}
