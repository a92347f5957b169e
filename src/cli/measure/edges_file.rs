//! Edges of every column as CSV, as the frames come: the file of `--edges`.

use std::path::{Path, PathBuf};

use super::csv_file::named;
use crate::cli::failure::Failure;
use crate::files::{OpenOutput, OutputFile};
use crate::gauge::{Edge, FrameEdges};
use crate::profile::Reason;

/// Claims the file of an option, which must not be an input. On stdout it is the only output.
pub(super) fn claim_output(
    option: &str,
    path: &Path,
    images: &[PathBuf],
    other_inputs: Vec<PathBuf>,
    json: bool,
) -> Result<OutputFile, Failure> {
    // Tables of frames are beside the images or above their folder.
    let tables =
        images.iter().flat_map(|image| image.ancestors().skip(1).take(2)).map(|f| f.join("frames.csv"));
    let file = OutputFile::claim(path, images.iter().cloned().chain(tables).chain(other_inputs))?;
    if file.is_stdout() && json {
        return Err(Failure::refuse(format!("--json and {option} both go to stdout; give {option} a file")));
    }
    Ok(file)
}

const NAMES: [&str; 7] = ["frame", "column", "top_px", "bottom_px", "u_top_px", "u_bottom_px", "flag"];

/// The edges of one frame, or why there are none.
#[derive(Clone, Copy, Debug)]
pub(super) struct FrameRows<'a> {
    pub(super) stem: &'a str,
    /// Columns of a frame that was refused.
    pub(super) columns: usize,
    pub(super) result: Result<&'a FrameEdges, Reason>,
}

/// The file, a row a column of every frame.
pub(super) struct EdgesFile {
    csv: csv::Writer<OpenOutput>,
    /// Whether the rows of a frame are given on at once.
    is_stream: bool,
    has_names: bool,
}

impl EdgesFile {
    /// Begins a claimed file; of a stream, the rows of a frame are given on at once.
    ///
    /// # Errors
    /// Where the disk or the permissions refuse.
    pub(super) fn begin(file: OutputFile, is_stream: bool) -> Result<Self, Failure> {
        Ok(Self { csv: csv::Writer::from_writer(file.begin()?), is_stream, has_names: false })
    }

    /// Adds the rows of a frame.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub(super) fn frame(&mut self, rows: FrameRows<'_>) -> Result<(), Failure> {
        let mut written = Ok(());
        if !self.has_names {
            self.has_names = true;
            written = self.csv.write_record(NAMES);
        }
        let written = written.and_then(|()| write_rows(&mut self.csv, rows));
        self.checked(written)?;
        if self.is_stream { self.flush() } else { Ok(()) }
    }

    /// Ends the file.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub(super) fn finish(mut self) -> Result<(), Failure> {
        self.flush()?;
        let file = self.csv.into_inner().map_err(|error| Failure::fail(error.error()))?;
        Ok(file.finish()?)
    }

    fn flush(&mut self) -> Result<(), Failure> {
        let flushed = self.csv.flush();
        self.checked(flushed.map_err(Into::into))
    }

    fn checked(&self, written: csv::Result<()>) -> Result<(), Failure> {
        written.map_err(|error| named(self.csv.get_ref(), error))
    }
}

fn write_rows(csv: &mut csv::Writer<OpenOutput>, rows: FrameRows<'_>) -> csv::Result<()> {
    let FrameRows { stem, columns, result } = rows;
    let edges = match result {
        Ok(edges) => edges,
        Err(reason) => {
            for column in 0..columns.max(1) {
                csv.write_record([stem, &column.to_string(), "", "", "", "", reason.as_str()])?;
            }
            return Ok(());
        }
    };
    let number = |usable: bool, value: f64, digits: usize| {
        if usable { format!("{value:.digits$}") } else { String::new() }
    };
    for (column, (top, bottom)) in edges.top.iter().zip(&edges.bottom).enumerate() {
        csv.write_record([
            stem,
            &column.to_string(),
            &number(top.is_usable(), top.row_px, 6),
            &number(bottom.is_usable(), bottom.row_px, 6),
            &number(top.is_usable(), top.u_px(), 7),
            &number(bottom.is_usable(), bottom.u_px(), 7),
            Edge::reason_of_both(top, bottom).map_or("", Reason::as_str),
        ])?;
    }
    Ok(())
}
