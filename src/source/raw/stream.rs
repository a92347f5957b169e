//! A stream of bytes into raw frames, one after another, as frames of the names `000000`, …

use std::io::{self, BufRead, Read as _};
use std::sync::Arc;

use super::layout::RawLayout;
use super::y4m::{SIGNATURE, header};
use crate::frame::FrameMeta;
use crate::source::decode::Wanted;
use crate::source::error::DecodeError;
use crate::source::host_clock::host_t_ns;
use crate::source::read_error::ReadError;
use crate::source::spare::Spare;
use crate::source::stored::{Arrival, Coded, Taken, TakenFrame, Undecoded};

/// Longest line of a Y4M stream, bytes: some words; ffmpeg's have about a hundred.
const LONGEST_LINE: u64 = 4096;

/// Whether a stream is Y4M, by its first bytes.
///
/// # Errors
/// A stream that cannot be read.
pub(crate) fn begins_y4m(input: &mut impl BufRead) -> io::Result<bool> {
    // A pipe may give fewer bytes than the word has: no image begins with these.
    let ahead = input.fill_buf()?;
    Ok(!ahead.is_empty() && SIGNATURE.iter().zip(ahead).take(4).all(|(a, b)| a == b))
}

/// Raw frames of a stream.
#[derive(Debug)]
pub(crate) struct RawStream<R> {
    input: R,
    /// What errors call the stream.
    name: String,
    /// As stated, or as the header of a Y4M stream has it once that is read.
    layout: Option<RawLayout>,
    is_y4m: bool,
    notices: Vec<String>,
    given: u64,
    has_ended: bool,
    spare: Spare,
}

impl<R: BufRead> RawStream<R> {
    /// Frames of a layout; errors call the stream `name`.
    pub(crate) fn new(input: R, name: String, layout: RawLayout) -> Self {
        Self { layout: Some(layout), is_y4m: false, ..Self::y4m(input, name) }
    }

    /// The frames of a Y4M stream, whose header is read with the first one.
    pub(crate) fn y4m(input: R, name: String) -> Self {
        let (notices, spare) = (Vec::new(), Spare::default());
        Self { input, name, layout: None, is_y4m: true, notices, given: 0, has_ended: false, spare }
    }

    /// Reads frames into spare memory.
    pub(crate) fn reusing(self, spare: Spare) -> Self {
        Self { spare, ..self }
    }

    fn named(&self) -> String {
        format!("{}, frame {:06}", self.name, self.given)
    }

    fn refused(&self, what: String) -> ReadError {
        ReadError::Decode { path: self.name.clone(), cause: DecodeError::Unsupported(what) }
    }

    fn line(&mut self) -> Result<Vec<u8>, ReadError> {
        let mut line = Vec::new();
        let read = self.input.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut line);
        read.map_err(|cause| ReadError::Io { path: self.named(), cause })?;
        Ok(line)
    }

    /// The layout, read from the header where it is not stated.
    fn layout(&mut self) -> Result<RawLayout, ReadError> {
        if let Some(layout) = self.layout {
            return Ok(layout);
        }
        let line = self.line()?;
        if !line.starts_with(SIGNATURE) {
            return Err(self.refused("not a Y4M stream: its first word would be YUV4MPEG2".to_owned()));
        }
        let Some(line) = line.strip_suffix(b"\n") else {
            return Err(self.refused("the stream ends within its header".to_owned()));
        };
        let found = header(line).map_err(|what| self.refused(what))?;
        if found.is_limited {
            self.notices.push(format!(
                "{}: XCOLORRANGE=LIMITED: white is 235, not 255; the values are taken as they are, and light that is \
                 too bright is not detected",
                self.name
            ));
        }
        self.layout = Some(found.layout);
        Ok(found.layout)
    }

    /// Whether another frame begins: a line `FRAME…` in Y4M.
    fn begins(&mut self) -> Result<bool, ReadError> {
        if !self.is_y4m {
            return Ok(true);
        }
        let line = self.line()?;
        if line.is_empty() {
            return Ok(false);
        }
        let what = line.strip_prefix(b"FRAME").filter(|rest| matches!(rest.first(), Some(b'\n' | b' ')));
        match what {
            Some(rest) if rest.ends_with(b"\n") => Ok(true),
            _ => {
                let path = self.named();
                let what =
                    "no line FRAME before it: the frames before have another size than the header states";
                Err(ReadError::Decode { path, cause: DecodeError::Unsupported(what.to_owned()) })
            }
        }
    }

    /// The next frame; `None` at the end.
    fn frame(&mut self) -> Result<Option<TakenFrame>, ReadError> {
        let layout = self.layout()?;
        if !self.begins()? {
            return Ok(None);
        }
        let (named, stem) = (self.named(), format!("{:06}", self.given));
        let (mut content, needed) = (self.spare.file(), layout.bytes());
        content.reserve_exact(needed as usize);
        let read = self.input.by_ref().take(needed).read_to_end(&mut content);
        let had = read.map_err(|cause| ReadError::Io { path: named.clone(), cause })? as u64;
        if had == 0 && !self.is_y4m {
            return Ok(None);
        }
        let notices = std::mem::take(&mut self.notices);
        let arrival =
            Arrival { stem: stem.clone(), host_t_ns: Some(host_t_ns()), notices, ..Arrival::default() };
        if had < needed {
            self.has_ended = true;
            let cause = DecodeError::Cut { had, needed };
            return Ok(Some((arrival, Err(ReadError::Decode { path: named, cause }))));
        }
        let meta = FrameMeta { frame_id: self.given, ..FrameMeta::default() };
        self.given += 1;
        let (coded, content, wanted) = (Coded::Raw(layout), Arc::new(content), Wanted::default());
        Ok(Some((arrival, Ok(Undecoded { stem, named, coded, content, wanted, meta, stated: None }))))
    }
}

impl<R: BufRead> Iterator for RawStream<R> {
    type Item = Taken;

    fn next(&mut self) -> Option<Taken> {
        if self.has_ended {
            return None;
        }
        let next = self.frame().transpose();
        self.has_ended |= !matches!(next, Some(Ok((_, Ok(_)))));
        next
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(taken: Taken) -> Result<Vec<f32>, String> {
        let undecoded = taken.map_err(|e| e.to_string())?.1.map_err(|e| e.to_string())?;
        let frame = undecoded.decode(&Spare::default()).map_err(|e| e.to_string())?.frame;
        let view = frame.view();
        Ok((0..view.rows())
            .flat_map(|r| (0..view.columns()).map(move |c| (r, c)))
            .filter_map(|(r, c)| view.get(r, c))
            .collect())
    }

    #[test]
    fn raw_frames_come_one_after_another_and_a_cut_one_is_named() {
        let layout = "2x2:mono8".parse().unwrap();
        let all: Vec<_> =
            RawStream::new(&[1, 2, 3, 4, 5, 6, 7, 8, 9][..], "stdin".into(), layout).map(grey).collect();
        assert_eq!(all[..2], [Ok(vec![1.0, 2.0, 3.0, 4.0]), Ok(vec![5.0, 6.0, 7.0, 8.0])]);
        let error = all[2].clone().unwrap_err();
        assert!(error.contains("stdin, frame 000002") && error.contains("1 bytes of 4"), "{error}");
        assert_eq!(all.len(), 3);
        assert_eq!(RawStream::new(&[][..], "stdin".into(), layout).count(), 0);
    }

    #[test]
    fn y4m_streams_have_their_own_size() {
        let mut bytes = b"YUV4MPEG2 W2 H1 F25:1 Ip Cmono16\nFRAME\n".to_vec();
        bytes.extend([1, 2, 3, 4]);
        bytes.extend(b"FRAME Xparameter\n");
        bytes.extend([5, 6, 7, 8]);
        let all: Vec<_> = RawStream::y4m(bytes.as_slice(), "a.y4m".into()).map(grey).collect();
        assert_eq!(all, [Ok(vec![513.0, 1027.0]), Ok(vec![1541.0, 2055.0])]);
        bytes.extend(b"FRAME\n\x01");
        let all: Vec<_> = RawStream::y4m(bytes.as_slice(), "a.y4m".into()).map(grey).collect();
        let error = all[2].clone().unwrap_err();
        assert!(error.contains("a.y4m, frame 000002") && error.contains("1 bytes of 4"), "{error}");
    }

    #[test]
    fn what_is_no_y4m_is_refused() {
        for (bytes, word) in [
            (&b"P5 2 2 255\n1234"[..], "YUV4MPEG2"),
            (b"YUV4MPEG2 W2 H2 C420", "ends within its header"),
            (b"YUV4MPEG2 W2 H2 C420\nFRAME\n123456", "C420"),
            (b"YUV4MPEG2 W2 H1 Cmono\nFRAME\n123", "000001"),
            (b"YUV4MPEG2 W2 H1 Cmono\nFRAMES\n12", "no line FRAME"),
        ] {
            let all: Vec<_> = RawStream::y4m(bytes, "x".into()).map(grey).collect();
            let error = all.last().unwrap().clone().unwrap_err();
            assert!(error.contains(word), "{error}");
        }
        assert!(begins_y4m(&mut &b"YUV4MPEG2 W2"[..]).unwrap() && !begins_y4m(&mut &b"P5 2"[..]).unwrap());
        assert!(!begins_y4m(&mut &b""[..]).unwrap());
    }
}
