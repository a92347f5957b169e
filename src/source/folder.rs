//! Frames in files: single images and folders, with what `frames.csv` says about them.

use std::collections::HashMap;
use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use thiserror::Error;

use super::decode::{DecodeError, decode};
use crate::frame::{Frame, FrameMeta, FrameSource, SourceError};

/// Extensions taken for images in a folder.
const EXTENSIONS: [&str; 7] = ["png", "tif", "tiff", "jpg", "jpeg", "bmp", "pgm"];
/// Largest file read, bytes: an f32 frame of the largest size decoded.
const LARGEST_FILE: u64 = 1 << 31;

/// A file that gives no frame.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReadError {
    /// It cannot be read.
    #[error("{path}: {cause}")]
    Io {
        /// The file or folder.
        path: String,
        /// What the system says.
        cause: std::io::Error,
    },
    /// It is no grey frame.
    #[error("{path}: {cause}")]
    Decode {
        /// The file.
        path: String,
        /// Why.
        cause: DecodeError,
    },
    /// A folder without images.
    #[error("{path}: no image in this folder; PNG, TIFF, JPEG, BMP or PGM files are needed")]
    NoImages {
        /// The folder.
        path: String,
    },
    /// A `frames.csv` that cannot be understood.
    #[error("{path}: {cause}")]
    Table {
        /// The file.
        path: String,
        /// What is wrong.
        cause: csv::Error,
    },
    /// A value of `frames.csv` that is no number.
    #[error("{path}: {column} of frame {frame} is not finite")]
    NotFinite {
        /// The file.
        path: String,
        /// The frame.
        frame: String,
        /// The column.
        column: &'static str,
    },
}

/// One row of `frames.csv`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct FrameInfo {
    /// Name of the frame: the file's stem.
    pub frame: String,
    /// Start of exposure, ns.
    pub t_ns: u64,
    /// Machine z of the central column, mm.
    pub z_mm: f64,
    /// Spindle angle, degrees.
    pub angle_deg: f64,
    /// Exposure, µs.
    pub exposure_us: f64,
    /// Bits of a grey value.
    pub bit_depth: Option<u8>,
    /// Nominal scale, µm/px.
    pub um_per_px: Option<f64>,
}

/// `frames.csv`, by frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameTable {
    rows: HashMap<String, FrameInfo>,
}

impl FrameTable {
    /// The table beside an image or in the folder above; empty where there is none.
    ///
    /// # Errors
    /// Where there is one that cannot be understood.
    pub fn beside(image: &Path) -> Result<Self, ReadError> {
        let folder = image.parent().unwrap_or(Path::new("."));
        let above = folder.parent().map(|p| p.join("frames.csv"));
        let candidates = [Some(folder.join("frames.csv")), above];
        match candidates.into_iter().flatten().find(|path| path.is_file()) {
            Some(path) => Self::read(&path),
            None => Ok(Self::default()),
        }
    }

    fn read(path: &Path) -> Result<Self, ReadError> {
        let table = |cause| ReadError::Table { path: path.display().to_string(), cause };
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_path(path).map_err(table)?;
        let mut rows = HashMap::new();
        for row in reader.deserialize::<FrameInfo>() {
            let row = row.map_err(table)?;
            for (column, value) in
                [("z_mm", row.z_mm), ("angle_deg", row.angle_deg), ("exposure_us", row.exposure_us)]
            {
                if !value.is_finite() {
                    return Err(ReadError::NotFinite {
                        path: path.display().to_string(),
                        frame: row.frame,
                        column,
                    });
                }
            }
            rows.insert(key(&row.frame), row);
        }
        Ok(Self { rows })
    }

    /// What is known about a frame; names that are numbers match by value.
    pub fn of(&self, stem: &str) -> Option<&FrameInfo> {
        self.rows.get(&key(stem))
    }
}

/// `000012` and `12` are the same frame.
fn key(name: &str) -> String {
    name.parse::<u64>().map_or_else(|_| name.to_owned(), |n| n.to_string())
}

/// A frame and the stem of its file.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredFrame {
    /// The file's stem.
    pub stem: String,
    /// The frame.
    pub frame: Frame,
}

/// Images of a folder (or of its `frames` folder), sorted by name; a file is itself.
///
/// # Errors
/// Where the path cannot be read or the folder holds no image.
pub fn list_images(path: &Path) -> Result<Vec<PathBuf>, ReadError> {
    let io = |cause| ReadError::Io { path: path.display().to_string(), cause };
    let kind = fs::metadata(path).map_err(io)?;
    if !kind.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let mut images = images_in(path).map_err(io)?;
    if images.is_empty() && path.join("frames").is_dir() {
        images = images_in(&path.join("frames")).map_err(io)?;
    }
    if images.is_empty() {
        return Err(ReadError::NoImages { path: path.display().to_string() });
    }
    Ok(images)
}

fn images_in(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut images = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        if path.is_file() && extension.is_some_and(|e| EXTENSIONS.contains(&e.as_str())) {
            images.push(path);
        }
    }
    images.sort();
    Ok(images)
}

/// The frames of a list of files, one after another.
#[derive(Debug, Default)]
pub struct FileFrames {
    paths: Vec<PathBuf>,
    next: usize,
    tables: HashMap<PathBuf, FrameTable>,
}

impl FileFrames {
    /// Frames of these files, in this order.
    pub fn new(paths: Vec<PathBuf>) -> Self {
        Self { paths, next: 0, tables: HashMap::new() }
    }

    /// Stem of the file that comes next.
    pub fn next_stem(&self) -> Option<String> {
        self.paths.get(self.next).map(|p| stem(p))
    }

    /// Reads the next file; `None` at the end. After an error the next call goes on with the next file.
    pub fn next_stored(&mut self) -> Option<Result<StoredFrame, ReadError>> {
        let path = self.paths.get(self.next)?.clone();
        self.next += 1;
        Some(self.read(&path))
    }

    fn read(&mut self, path: &Path) -> Result<StoredFrame, ReadError> {
        let name = path.display().to_string();
        let io = |cause| ReadError::Io { path: name.clone(), cause };
        let mut bytes = Vec::new();
        let file = fs::File::open(path).map_err(io)?;
        file.take(LARGEST_FILE).read_to_end(&mut bytes).map_err(io)?;
        let stem = stem(path);
        let folder = path.parent().unwrap_or(Path::new(".")).to_owned();
        if !self.tables.contains_key(&folder) {
            self.tables.insert(folder.clone(), FrameTable::beside(path)?);
        }
        let info = self.tables.get(&folder).and_then(|t| t.of(&stem)).cloned().unwrap_or_default();
        let meta = FrameMeta {
            frame_id: stem.parse().unwrap_or(self.next as u64 - 1),
            t_ns: info.t_ns,
            exposure_us: info.exposure_us,
            angle_deg: info.angle_deg,
            z_mm: info.z_mm,
            roi: None,
        };
        let frame = decode(&bytes, info.bit_depth, meta)
            .map_err(|cause| ReadError::Decode { path: name.clone(), cause })?;
        Ok(StoredFrame { stem, frame })
    }
}

fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned())
}

impl FrameSource for FileFrames {
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        match self.next_stored() {
            None => Ok(None),
            Some(Ok(stored)) => Ok(Some(stored.frame)),
            Some(Err(error)) => Err(SourceError { what: error.to_string(), cause: Some(Box::new(error)) }),
        }
    }

    fn remaining(&self) -> Option<usize> {
        Some(self.paths.len() - self.next)
    }
}
