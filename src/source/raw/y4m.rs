//! The header of a Y4M stream (yuv4mpeg(5), mjpegtools; `Cmono…` as ffmpeg writes it).
//!
//! Only grey streams are taken: the luma of a colour stream is encoded light in a range of its own,
//! whose edges lie elsewhere.

use super::layout::{RawFormat, RawLayout};

/// First word of a stream.
pub(super) const SIGNATURE: &[u8] = b"YUV4MPEG2";

/// Grey planes by the tag of their chroma.
const GREY: [(&str, RawFormat); 4] = [
    ("mono", RawFormat::Mono8),
    ("mono10", RawFormat::Mono10),
    ("mono12", RawFormat::Mono12),
    ("mono16", RawFormat::Mono16),
];

/// What a stream's header states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Header {
    /// Size and pixel format.
    pub(super) layout: RawLayout,
    /// Whether the grey values are stated to reach from 16 to 235 only.
    pub(super) is_limited: bool,
}

/// Parses the first line of a stream, without its end.
///
/// # Errors
/// What the stream is and what would be right.
pub(super) fn header(line: &[u8]) -> Result<Header, String> {
    let text = std::str::from_utf8(line).map_err(|_| "a header that is no text".to_owned())?;
    let mut words = text.split(' ').filter(|word| !word.is_empty());
    words.next();
    let (mut columns, mut rows, mut chroma, mut is_limited) = (None, None, "420jpeg", false);
    for word in words {
        let mut letters = word.chars();
        match (letters.next(), letters.as_str()) {
            (Some('W'), number) => columns = number.parse().ok(),
            (Some('H'), number) => rows = number.parse().ok(),
            (Some('C'), tag) => chroma = tag,
            (Some('I'), "t" | "b" | "m") => {
                return Err(format!(
                    "{word}: interlaced fields are of two instants; progressive frames (Ip) are needed"
                ));
            }
            (Some('X'), "COLORRANGE=LIMITED") => is_limited = true,
            _ => {}
        }
    }
    let (Some(columns), Some(rows)) = (columns, rows) else {
        return Err(format!("no size in its header \"{text}\"; W and H with a number each are needed"));
    };
    let format = GREY.iter().find(|(tag, _)| *tag == chroma).map(|(_, format)| *format);
    let format = format.ok_or_else(|| not_grey(chroma))?;
    let layout = RawLayout::new(columns, rows, format).map_err(|error| error.to_string())?;
    Ok(Header { layout, is_limited })
}

fn not_grey(chroma: &str) -> String {
    let grey = "Cmono, Cmono10, Cmono12 or Cmono16 is needed: ffmpeg … -pix_fmt gray -f yuv4mpegpipe - \
                (gray10le, gray12le, gray16le with -strict -1)";
    if chroma.starts_with("mono") {
        return format!("C{chroma}: a depth that cameras do not have; {grey}");
    }
    format!(
        "C{chroma}: a colour stream, whose luma is encoded (gamma, limited range) and moves edges; {grey} of a grey camera"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_as_ffmpeg_writes_them() {
        let line = b"YUV4MPEG2 W640 H480 F25:1 Ip A1:1 Cmono12 XYSCSS=MONO12 XCOLORRANGE=FULL";
        let found = header(line).unwrap();
        assert_eq!((found.layout.to_string().as_str(), found.is_limited), ("640x480:mono12", false));
        let line = b"YUV4MPEG2 W4 H2 Cmono XCOLORRANGE=LIMITED";
        let found = header(line).unwrap();
        assert_eq!((found.layout.bytes(), found.is_limited), (8, true));
    }

    #[test]
    fn what_is_not_one_grey_plane_is_refused_by_its_name() {
        for (line, word) in [
            ("YUV4MPEG2 W4 H2", "C420jpeg"),
            ("YUV4MPEG2 W4 H2 C422", "C422"),
            ("YUV4MPEG2 W4 H2 Cmono9", "Cmono9"),
            ("YUV4MPEG2 W4 H2 Cmono It", "It: interlaced"),
            ("YUV4MPEG2 W4 Cmono", "no size"),
            ("YUV4MPEG2 Wx H2 Cmono", "no size"),
            ("YUV4MPEG2 W0 H2 Cmono", "above 0"),
        ] {
            let error = header(line.as_bytes()).unwrap_err();
            assert!(error.contains(word), "{line}: {error}");
        }
    }
}
