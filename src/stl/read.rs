//! The bytes of an STL file to triangles.
//!
//! A binary file has 80 bytes of free text, the number n of its facets and 50 bytes a facet: 84 +
//! 50 n bytes in all. The length decides, not the word `solid`, with which many binary headers
//! begin. Coordinates have no unit: they are multiplied by the one stated.

use std::borrow::Cow;
use std::io::Cursor;

use glam::DVec3;

use super::fault::{FaultKind, ModelFault};

/// Unit of the coordinates of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unit {
    /// Millimetres.
    Millimetre,
    /// Centimetres.
    Centimetre,
    /// Metres.
    Metre,
    /// Inches.
    Inch,
}

impl Unit {
    /// All of them.
    pub(crate) const ALL: [Self; 4] = [Self::Millimetre, Self::Centimetre, Self::Metre, Self::Inch];

    /// Its length, mm.
    pub(crate) fn mm(self) -> f64 {
        match self {
            Self::Millimetre => 1.0,
            Self::Centimetre => 10.0,
            Self::Metre => 1000.0,
            Self::Inch => 25.4,
        }
    }

    /// Its name on the command line.
    pub(crate) fn as_str(self) -> &'static str {
        match self {
            Self::Millimetre => "mm",
            Self::Centimetre => "cm",
            Self::Metre => "m",
            Self::Inch => "inch",
        }
    }
}

impl std::str::FromStr for Unit {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|unit| unit.as_str() == word)
            .ok_or_else(|| format!("no unit is called {word:?}; there are mm, cm, m, inch"))
    }
}

/// Bytes of the header, of the number of facets after it, and of a facet.
const HEADER: usize = 80;
const COUNT: usize = 4;
const FACET: usize = 50;
/// First bytes of other files that are met in an STL's place.
const OTHERS: [(&[u8], &str); 5] = [
    (b"\x89PNG", "a PNG image"),
    (b"PK\x03\x04", "a ZIP archive, as a 3MF file is one"),
    (b"ISO-10303", "a STEP file"),
    (b"%PDF", "a PDF document"),
    (b"version https://git-lfs", "a pointer of Git LFS to a file that was not fetched"),
];
/// Most characters of a line that an error shows.
const SHOWN: usize = 60;

/// The corners of every facet, mm.
///
/// # Errors
/// Bytes that are no STL: neither the length of a binary one nor the words of an ASCII one, cut
/// off, coordinates that are no numbers, several solids.
pub(super) fn triangles(bytes: &[u8], unit: Unit) -> Result<Vec<[DVec3; 3]>, ModelFault> {
    let ready = ready(bytes)?;
    let mut cursor = Cursor::new(&ready);
    // of an ASCII file the line is named, which an editor finds
    let refused = |why: String| no_stl(&bad_line(bytes).unwrap_or(why));
    let facets = stl_io::create_stl_reader(&mut cursor).map_err(|e| refused(e.to_string()))?;
    let mut triangles = Vec::with_capacity(facets.size_hint().0);
    for (i, facet) in facets.enumerate() {
        let facet = facet.map_err(|e| refused(format!("facet {}: {e}", i + 1)))?;
        let corners = facet.vertices.map(|v| {
            let [x, y, z]: [f32; 3] = v.into();
            unit.mm() * DVec3::new(f64::from(x), f64::from(y), f64::from(z))
        });
        if let Some(bad) = corners.iter().find(|c| !c.is_finite()) {
            return Err(no_stl(&format!("facet {}: a coordinate of {bad} is no number", i + 1)));
        }
        triangles.push(corners);
    }
    Ok(triangles)
}

fn no_stl(why: &impl std::fmt::Display) -> ModelFault {
    ModelFault::whole(FaultKind::File, format!("no STL file: {why}"))
}

/// Number of facets where the length is that of a binary file.
fn binary_facets(bytes: &[u8]) -> Option<usize> {
    let count: [u8; COUNT] = bytes.get(HEADER..HEADER + COUNT)?.try_into().ok()?;
    let facets = u32::from_le_bytes(count) as usize;
    (bytes.len() == HEADER + COUNT + FACET * facets).then_some(facets)
}

/// The bytes as the reader separates both forms: by `solid ` in the first line.
fn ready(bytes: &[u8]) -> Result<Vec<u8>, ModelFault> {
    if bytes.is_empty() {
        return Err(ModelFault::whole(
            FaultKind::Empty,
            "the file is empty: an STL of a closed body is needed",
        ));
    }
    if binary_facets(bytes).is_some() {
        let mut plain = bytes.to_vec();
        plain[..HEADER].fill(b' ');
        return Ok(plain);
    }
    match solid(bytes) {
        Some(text) => ascii(&text),
        None => Err(no_stl(&mismatch(bytes))),
    }
}

/// The text of an ASCII file from its word `solid` on; names in it need not be UTF-8.
fn solid(bytes: &[u8]) -> Option<Cow<'_, str>> {
    if binary_facets(bytes).is_some() || bytes.contains(&0) {
        return None;
    }
    let text = String::from_utf8_lossy(bytes);
    let start = text.len() - text.trim_start_matches('\u{feff}').trim_start().len();
    text.get(start..start + 5).filter(|word| word.eq_ignore_ascii_case("solid"))?;
    Some(match text {
        Cow::Borrowed(text) => Cow::Borrowed(&text[start..]),
        Cow::Owned(text) => Cow::Owned(text[start..].to_owned()),
    })
}

/// The first line of an ASCII file that should be a vertex and is none.
fn bad_line(bytes: &[u8]) -> Option<String> {
    let text = String::from_utf8_lossy(bytes);
    solid(bytes)?;
    let is_number = |word: &str| word.parse::<f32>().is_ok_and(f32::is_finite);
    for (i, line) in text.lines().enumerate() {
        let words: Vec<&str> = line.split_whitespace().collect();
        if !words.first().is_some_and(|word| word.eq_ignore_ascii_case("vertex")) {
            continue;
        }
        if words.len() != 4 || !words[1..].iter().all(|word| is_number(word)) {
            let shown: String = line.trim().chars().take(SHOWN).collect();
            let right = if line.contains(',') {
                "decimal commas: export it again with decimal points"
            } else {
                "a vertex is three numbers: export it again"
            };
            return Some(format!("line {}, `{shown}`: {right}", i + 1));
        }
    }
    None
}

/// What the length of bytes that are not ASCII contradicts.
fn mismatch(bytes: &[u8]) -> String {
    if let Some((_, name)) = OTHERS.iter().find(|(start, _)| bytes.starts_with(start)) {
        return format!("{name}: export the part as STL");
    }
    if !bytes.contains(&0) && std::str::from_utf8(bytes).is_ok() {
        return "text that does not begin with `solid`: export the part as STL".to_owned();
    }
    let Some(count) = bytes.get(HEADER..HEADER + COUNT) else {
        return format!(
            "{} bytes, without `solid` and without a binary header of {} bytes",
            bytes.len(),
            HEADER + COUNT
        );
    };
    let facets = count.iter().rev().fold(0_u64, |sum, byte| sum * 256 + u64::from(*byte));
    format!(
        "its header counts {facets} facets, which need {} bytes, and the file has {}: it is cut off or no STL; export it again",
        (HEADER + COUNT) as u64 + FACET as u64 * facets,
        bytes.len()
    )
}

/// ASCII in lower case with a name after `solid` and without normals, which are not used and of
/// which some exporters write those of facets without an area as no numbers; one solid alone.
fn ascii(text: &str) -> Result<Vec<u8>, ModelFault> {
    let (_, rest) = text.split_once('\n').unwrap_or((text, ""));
    let rest = rest.to_ascii_lowercase();
    let solids = rest.lines().filter(|line| line.trim_start().starts_with("endsolid")).count();
    if solids > 1 {
        let why = format!("{solids} solids in one file: save the part alone");
        return Err(ModelFault::whole(FaultKind::SeveralBodies, why));
    }
    if solids == 0 {
        return Err(no_stl(&format!(
            "an ASCII file of {} lines without endsolid: it is cut off, or text of another kind",
            1 + rest.lines().count()
        )));
    }
    let mut plain = String::with_capacity(rest.len());
    plain.push_str("solid part\n");
    for line in rest.lines() {
        let is_head = line.trim_start().starts_with("facet");
        plain.push_str(if is_head { "facet normal 0 0 0" } else { line });
        plain.push('\n');
    }
    Ok(plain.into_bytes())
}
