//! `frames.csv`: metadata of each frame, as programs and spreadsheets write it.
//!
//! In any dialect of [`crate::text_table`]. Everything else is refused with its row number as in a
//! spreadsheet: the header is row 1.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::encoder_rows::bind_rows;
#[cfg(feature = "render")]
use super::encoder_rows::check_stops;
use super::frame_info::FrameInfo;
use crate::position::EncoderSettings;
use crate::text_table::{self, Cells, Comments, TextTable, TextTableError};

/// Why a `frames.csv` cannot be parsed.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{}{}: {what}", path.display(), row.map_or(String::new(), |row| format!(", row {row}")))]
pub struct TableError {
    /// The file.
    pub path: PathBuf,
    /// The row, where one is wrong.
    pub row: Option<usize>,
    /// What was found, and the valid values.
    pub what: String,
}

/// `frames.csv`, by frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct FrameTable {
    /// The file.
    pub path: PathBuf,
    rows: HashMap<String, FrameInfo>,
    /// Whether it has a column of angles.
    has_angles: bool,
}

const COLUMNS: [&str; 10] = [
    "frame",
    "t_ns",
    "z_mm",
    "angle_deg",
    "exposure_us",
    "bit_depth",
    "um_per_px",
    "encoder_count",
    "index",
    "stop",
];

impl FrameTable {
    /// Reads a table.
    ///
    /// # Errors
    /// Where the file cannot be read or parsed.
    pub(crate) fn read(path: &Path) -> Result<Self, TableError> {
        let refuse = |what: String| TableError { path: path.to_owned(), row: None, what };
        let bytes = std::fs::read(path).map_err(|e| refuse(e.to_string()))?;
        Self::parse(path, &bytes)
    }

    /// The first column of a file that is missing of those that place a frame on a part.
    ///
    /// # Errors
    /// Where the file cannot be read.
    #[cfg(feature = "render")]
    pub(super) fn missing_place(path: &Path) -> Result<Option<&'static str>, TableError> {
        let refuse = |what: String| TableError { path: path.to_owned(), row: None, what };
        let bytes = std::fs::read(path).map_err(|e| refuse(e.to_string()))?;
        let table = TextTable::parse(&bytes, &["frame"], Comments::None).map_err(|e| placed(path, e))?;
        let angle = if table.has("encoder_count") { "encoder_count" } else { "angle_deg" };
        Ok(["frame", "z_mm", angle].into_iter().find(|name| !table.has(name)))
    }

    /// Gives every row its angle by the encoder where one is stated; where none is, `angle_deg`
    /// must stand beside the counts.
    ///
    /// # Errors
    /// A table without counts, counts without an encoder, a row that cannot be.
    pub(super) fn by_encoder(mut self, encoder: Option<&EncoderSettings>) -> Result<Self, TableError> {
        let refuse = |row: Option<usize>, what: String| TableError { path: self.path.clone(), row, what };
        let counted = self.rows.values().any(|info| info.encoder.is_some());
        let Some(settings) = encoder else {
            return match counted && !self.has_angles {
                true => Err(refuse(
                    None,
                    "encoder_count without angle_deg; state the encoder (measure --counts-per-turn N, scan.encoder of a job)"
                        .to_owned(),
                )),
                false => Ok(self),
            };
        };
        if !counted && !self.rows.is_empty() {
            let what =
                "no column `encoder_count`, and an encoder is stated; add it, or leave the encoder out";
            return Err(refuse(None, what.to_owned()));
        }
        let mut rows: Vec<FrameInfo> = self.rows.values().cloned().collect();
        bind_rows(&mut rows, settings).map_err(|(row, what)| refuse(Some(row), what))?;
        self.rows = rows.into_iter().map(|info| (key(&info.frame), info)).collect();
        Ok(self)
    }

    /// Whether the stops of the scan have the frames of a plan; see `encoder_rows`.
    ///
    /// # Errors
    /// The stop that does not pair.
    #[cfg(feature = "render")]
    pub(super) fn check_stops(&self, planned: usize, fields: usize) -> Result<(), TableError> {
        let rows: Vec<&FrameInfo> = self.rows.values().collect();
        let refuse = |what| TableError { path: self.path.clone(), row: None, what };
        check_stops(&rows, planned, fields).map_err(refuse)
    }

    fn parse(path: &Path, bytes: &[u8]) -> Result<Self, TableError> {
        let refuse = |row: usize, what: String| TableError { path: path.to_owned(), row: Some(row), what };
        let text = TextTable::parse(bytes, &["frame"], Comments::None).map_err(|e| placed(path, e))?;
        if !text.has("frame") {
            let first = text.names().join(", ");
            let what = format!(
                "no column `frame` among {first:?}; the names of the columns stand in the first row, one of them `frame`"
            );
            return Err(refuse(text.head(), what));
        }
        if let Some(name) = text.twice(&COLUMNS) {
            return Err(refuse(text.head(), format!("two columns `{name}`")));
        }
        let has_angles = text.has("angle_deg");
        let mut table = Self { path: path.to_owned(), rows: HashMap::new(), has_angles };
        for cells in text.rows() {
            let cells = cells.map_err(|e| placed(path, e))?;
            let info = Fields(cells).info().map_err(|what| refuse(cells.row(), what))?;
            table.insert(info).map_err(|what| refuse(cells.row(), what))?;
        }
        Ok(table)
    }

    fn insert(&mut self, info: FrameInfo) -> Result<(), String> {
        let row = info.row;
        if let Some(other) = self.rows.get(&key(&info.frame)) {
            let same = FrameInfo { row, frame: info.frame.clone(), ..other.clone() };
            if same != info {
                return Err(format!(
                    "frame {} stands in row {}, too, and says otherwise",
                    info.frame, other.row
                ));
            }
        }
        self.rows.insert(key(&info.frame), info);
        Ok(())
    }

    /// Whether it has no rows.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The row of a frame; names that are numbers match by value.
    pub(crate) fn of(&self, stem: &str) -> Option<&FrameInfo> {
        self.rows.get(&key(stem))
    }

    /// Whether any row is that of one of these images (or of one of their pages).
    pub(super) fn knows_any(&self, stems: &[String]) -> bool {
        let there: HashSet<String> = stems.iter().map(|stem| key(stem)).collect();
        self.rows.values().any(|info| there.contains(&key(file_stem(&info.frame))))
    }

    /// Rows whose image is not among these.
    pub(super) fn without_image(&self, stems: &[String]) -> Vec<&FrameInfo> {
        let known: HashSet<String> = stems.iter().map(|stem| key(stem)).collect();
        let missing = |info: &&FrameInfo| {
            !known.contains(&key(&info.frame)) && !known.contains(&key(file_stem(&info.frame)))
        };
        let mut rows: Vec<&FrameInfo> = self.rows.values().filter(missing).collect();
        rows.sort_by_key(|info| info.row);
        rows
    }
}

/// The name of the file of a page `stack#3`.
fn file_stem(name: &str) -> &str {
    match name.rsplit_once('#') {
        Some((stem, page)) if !stem.is_empty() && page.parse::<usize>().is_ok() => stem,
        _ => name,
    }
}

/// `000012`, `12`, `12.png` and `frames/000012.png` are the same frame.
fn key(name: &str) -> String {
    let name = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let stem = match name.rsplit_once('.') {
        Some((stem, extension)) if super::extension::is_image_extension(extension) => stem,
        _ => name,
    };
    stem.parse::<u64>().map_or_else(|_| stem.to_owned(), |n| n.to_string())
}

/// A refusal of the text with its file.
fn placed(path: &Path, error: TextTableError) -> TableError {
    TableError { path: path.to_owned(), row: error.row, what: error.what }
}

/// One row by the names of its columns.
struct Fields<'a>(Cells<'a>);

impl Fields<'_> {
    fn info(&self) -> Result<FrameInfo, String> {
        let frame = self.text("frame").unwrap_or("").to_owned();
        if frame.is_empty() {
            return Err("no name in column `frame`; the stem of an image is needed".to_owned());
        }
        let um_per_px = self.number("um_per_px")?;
        if um_per_px.is_some_and(|s| s <= 0.0) {
            return Err(self.wrong("um_per_px", "a scale above 0 µm/px"));
        }
        Ok(FrameInfo {
            frame,
            t_ns: self.whole("t_ns")?,
            z_mm: self.number("z_mm")?.unwrap_or(0.0),
            angle_deg: self.number("angle_deg")?.unwrap_or(0.0),
            exposure_us: self.number("exposure_us")?.unwrap_or(0.0),
            bit_depth: match self.whole("bit_depth")? {
                None => None,
                Some(bits @ (8 | 10 | 12 | 14 | 16 | 32)) => Some(bits as u8),
                Some(_) => return Err(self.wrong("bit_depth", "8, 10, 12, 14 or 16 (32 for floating point)")),
            },
            um_per_px,
            encoder: match self.signed("encoder_count")? {
                None => None,
                Some(count) => Some((count, self.signed("index")?)),
            },
            stop: match self.whole("stop")? {
                None => None,
                Some(stop @ 1..=0xffff_ffff) => Some(stop as u32),
                Some(_) => return Err(self.wrong("stop", "a number from 1 on")),
            },
            row: self.0.row(),
            ..FrameInfo::default()
        })
    }

    fn text(&self, name: &str) -> Option<&str> {
        self.0.text(name)
    }

    fn wrong(&self, name: &str, right: &str) -> String {
        format!("{name} {:?}; {right} is needed", self.text(name).unwrap_or(""))
    }

    /// A finite number with a decimal point or a decimal comma.
    fn number(&self, name: &str) -> Result<Option<f64>, String> {
        let Some(field) = self.text(name).filter(|f| !f.is_empty()) else { return Ok(None) };
        text_table::number(field).map(Some).ok_or_else(|| self.wrong(name, "a number"))
    }

    /// A whole number.
    fn signed(&self, name: &str) -> Result<Option<i64>, String> {
        if let Some(whole) = self.text(name).and_then(|f| f.parse().ok()) {
            return Ok(Some(whole));
        }
        let Some(number) = self.number(name)? else { return Ok(None) };
        let is_whole = number.fract() == 0.0 && number.abs() <= 9e15;
        if is_whole { Ok(Some(number as i64)) } else { Err(self.wrong(name, "a whole number")) }
    }

    /// A whole number of 0 or more, also as spreadsheets write large ones (1.2E+09).
    fn whole(&self, name: &str) -> Result<Option<u64>, String> {
        if let Some(whole) = self.text(name).and_then(|f| f.parse().ok()) {
            return Ok(Some(whole));
        }
        let Some(number) = self.number(name)? else { return Ok(None) };
        // Up to 2^53 every whole number is exact.
        if number.fract() == 0.0 && (0.0..=9e15).contains(&number) {
            return Ok(Some(number as u64));
        }
        Err(self.wrong(name, "a whole number of 0 or more"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &[u8]) -> Result<FrameTable, String> {
        FrameTable::parse(Path::new("frames.csv"), text).map_err(|e| e.to_string())
    }

    /// The same two rows in every dialect.
    #[test]
    fn every_dialect_says_the_same() {
        let plain = "frame,z_mm,angle_deg,bit_depth\n000007,-1.25,30.5,10\nb,2,0,12\n";
        let semicolons = "frame;z_mm;angle_deg;bit_depth\n000007;-1,25;30,5;10\nb;2;0;12\n";
        let quoted =
            "\"frame\",\"z_mm\",\"angle_deg\",\"bit_depth\"\n7,\"-1,25\",\"30.5\",\"10\"\n\"b\",2,0,12";
        let marked = [b"\xef\xbb\xbf".as_slice(), plain.as_bytes()].concat();
        let mut wide = vec![0xff, 0xfe];
        wide.extend(semicolons.replace(';', "\t").encode_utf16().flat_map(u16::to_le_bytes));
        let dialects = [
            plain.as_bytes().to_vec(),
            plain.replace('\n', "\r\n").into_bytes(),
            plain.replace('\n', "\r").into_bytes(),
            plain.replace(',', " ; ").into_bytes(),
            semicolons.as_bytes().to_vec(),
            semicolons.replace(';', "\t").into_bytes(),
            format!("sep=;\r\n{semicolons}").into_bytes(),
            format!("{};;\n\n;;;\n", semicolons.replace("10\n", "10;;\n")).into_bytes(),
            quoted.as_bytes().to_vec(),
            plain.replace("frame,", "Frame,").replace("000007", "frames/000007.tif").into_bytes(),
            marked,
            wide,
        ];
        for bytes in dialects {
            let shown = String::from_utf8_lossy(&bytes).into_owned();
            let table = parsed(&bytes).unwrap_or_else(|e| panic!("{e}: {shown:?}"));
            let seven = table.of("7").unwrap_or_else(|| panic!("no frame 7: {shown:?}"));
            let found = (seven.z_mm, seven.angle_deg, seven.bit_depth);
            assert_eq!(found, (-1.25, 30.5, Some(10)), "{shown:?}");
            assert_eq!(table.of("b").map(|b| b.z_mm), Some(2.0), "{shown:?}");
        }
    }

    #[test]
    fn what_is_wrong_is_named_with_its_row() {
        for (text, words) in [
            ("name;bits\na;10\n", "row 1: no column `frame` among \"name, bits\""),
            ("frame,z_mm\na,1\nb,far\n", "row 3: z_mm \"far\"; a number"),
            ("frame,z_mm\na,1,5\n", "row 2: 3 fields under 2 names (a decimal comma"),
            ("frame,z_mm,t_ns\na,1\n", "row 2: 2 fields under 3 names"),
            ("frame;z_mm\na;1.000,5\n", "row 2: z_mm \"1.000,5\""),
            ("frame,z_mm\na,1\na,2\n", "row 3: frame a stands in row 2, too"),
            ("frame,z_mm\n01,1\n1,2\n", "row 3: frame 1 stands in row 2, too"),
            ("frame,bit_depth\na,9\n", "row 2: bit_depth \"9\"; 8, 10, 12, 14 or 16"),
            ("frame,t_ns\na,-3\n", "row 2: t_ns \"-3\"; a whole number"),
            ("frame,angle_deg\na,inf\n", "row 2: angle_deg \"inf\""),
            ("frame,um_per_px\na,0\n", "row 2: um_per_px \"0\"; a scale above 0"),
            ("frame,z_mm,z_mm\na,1,2\n", "row 1: two columns `z_mm`"),
            ("frame,z_mm\n,1\n", "row 2: no name in column `frame`"),
            ("sep=;\nframe;z_mm\na;x\n", "row 3: z_mm \"x\""),
        ] {
            let refused = parsed(text.as_bytes()).unwrap_err();
            assert!(refused.contains(words), "{text:?}: {refused}");
        }
        // The same row twice adds nothing.
        assert!(parsed(b"frame,z_mm\na,1\na,1\n").is_ok());
        assert_eq!(
            parsed(b"frame,t_ns\na,1.2E+09\n").unwrap().of("a").and_then(|a| a.t_ns),
            Some(1_200_000_000)
        );
    }

    #[test]
    fn rows_without_an_image_are_found() {
        let table = parsed(b"frame,z_mm\n0,1\nstack#0,1\nstack#1,2\ngone,3\n").unwrap();
        let stems = ["000000", "stack"].map(str::to_owned);
        assert!(table.knows_any(&stems) && !table.knows_any(&["other".to_owned()]));
        let rows: Vec<usize> = table.without_image(&stems).iter().map(|info| info.row).collect();
        assert_eq!(rows, [5]);
    }
}
