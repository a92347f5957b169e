//! Why a file, or an image of a stream, has no frame.

use thiserror::Error;

use super::error::DecodeError;
use super::frame_table::TableError;

/// Largest file read, bytes: an f32 frame of the largest size decoded.
pub(super) const LARGEST_FILE: u64 = 1 << 31;

/// Why a file has no frame.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReadError {
    /// It cannot be read.
    #[error("{path}: {cause}")]
    Io {
        /// The file or folder.
        path: String,
        /// The system's message.
        cause: std::io::Error,
    },
    /// It is not a grey frame.
    #[error("{path}: {cause}")]
    Decode {
        /// The file.
        path: String,
        /// Why.
        cause: DecodeError,
    },
    /// It is larger than any recording of one frame.
    #[error("{path}: more than {LARGEST_FILE} bytes; split the stack into files")]
    TooLarge {
        /// The file.
        path: String,
    },
    /// A folder without images.
    #[error("{path}: no image in this folder; PNG, TIFF, JPEG, BMP or PGM files are needed")]
    NoImages {
        /// The folder.
        path: String,
    },
    /// A `frames.csv` that cannot be parsed.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A table without a row for the frame.
    #[error("{path}: {table} has no row for frame {frame}; add one, or move the table away")]
    NoRow {
        /// The file.
        path: String,
        /// The table.
        table: String,
        /// The frame.
        frame: String,
    },
    /// A frame of a turn that is void.
    #[error("{path}: its spindle angle is not known: {why}")]
    Void {
        /// The file.
        path: String,
        /// Why the turn is void.
        why: String,
    },
    /// Frames of a part without their places and angles.
    #[error("{path}: {}", without_places(missing))]
    NoPlaces {
        /// The table, or where it would be.
        path: String,
        /// The column that is missing; empty where there is no table.
        missing: &'static str,
    },
    /// The file's own scale differs from the table's.
    #[error("{path}: {what}")]
    Scale {
        /// The file.
        path: String,
        /// Both scales.
        what: String,
    },
}

fn without_places(missing: &str) -> String {
    let right = "frames of a part need frames.csv with the columns frame, z_mm (machine z of the central column) and \
                 angle_deg (spindle angle)";
    if missing.is_empty() {
        format!("is not there; {right}")
    } else {
        format!("has no column {missing}; {right}")
    }
}
