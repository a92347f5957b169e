//! Edges of every column as CSV: the file of `--edges`.

use std::path::{Path, PathBuf};

use crate::cli::failure::Failure;
use crate::files::OutputFile;
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

/// The edges of one frame, or why there are none.
#[derive(Clone, Copy, Debug)]
pub(super) struct FrameRows<'a> {
    pub(super) stem: &'a str,
    /// Columns of a frame that was refused.
    pub(super) columns: usize,
    pub(super) result: Result<&'a FrameEdges, Reason>,
}

/// Writes a row a column of every frame.
pub(super) fn write_rows<'a>(
    out: &mut dyn std::io::Write,
    frames: impl Iterator<Item = FrameRows<'a>>,
) -> Result<(), csv::Error> {
    let mut csv = csv::Writer::from_writer(out);
    csv.write_record(["frame", "column", "top_px", "bottom_px", "u_top_px", "u_bottom_px", "flag"])?;
    let number = |usable: bool, value: f64, digits: usize| {
        if usable { format!("{value:.digits$}") } else { String::new() }
    };
    for FrameRows { stem, columns, result } in frames {
        let edges = match result {
            Ok(edges) => edges,
            Err(reason) => {
                for column in 0..columns.max(1) {
                    csv.write_record([stem, &column.to_string(), "", "", "", "", reason.as_str()])?;
                }
                continue;
            }
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
    }
    csv.flush()?;
    Ok(())
}
