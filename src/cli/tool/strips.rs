//! Rectified strips of labelled flanks as files: what a network of the user's is trained on.
//!
//! `000000.tif` holds what `tool flank --model FILE.onnx` gives the network (float32, 510 rows of
//! 2 µm, columns of 4 µm), `000000_land.png` its land (255), of the same size.

use std::path::Path;

use crate::cli::failure::Failure;
use crate::cli::input_output::StudyFolder;
use crate::cli::render::frame_files::{FileFormat, encode, write_grey};
use crate::frame::{Frame, FrameMeta};
use crate::gauge::flank::{Labelled, normalised};

/// Writes the strips in the order of their images.
///
/// # Errors
/// Exit 2 for a folder that holds anything, 3 where it cannot be written.
pub(super) fn write(dir: &Path, labelled: &[Labelled]) -> Result<(), Failure> {
    let folder = StudyFolder::claim(Some(dir))?;
    StudyFolder::fill(folder, |folder| {
        for (number, one) in labelled.iter().enumerate() {
            let strip = normalised(&one.flank.strip, &one.flank.frame);
            let columns = strip.columns;
            let frame = Frame::linear(strip.values, strip.rows, columns, None, FrameMeta::default());
            // pixels are not square: no scale goes into the tags
            let picture = encode(&frame, FileFormat::F32, None).map_err(Failure::fail)?;
            folder.write(&format!("{number:06}.tif"), &picture)?;
            let land: Vec<u8> = one.land.values.iter().map(|v| if *v > 0.5 { 255 } else { 0 }).collect();
            let land = write_grey(columns, &land).map_err(Failure::fail)?;
            folder.write(&format!("{number:06}_land.png"), &land)?;
        }
        Ok(())
    })
}
