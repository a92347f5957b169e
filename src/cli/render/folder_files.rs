//! Files of a folder of frames: the table beside them, writing, and the exit codes of renderer
//! errors.

use std::fmt::Write as _;
use std::io::Error as IoError;

use crate::cli::failure::Failure;
use crate::files::OutputFolder;
use crate::frame::Frame;
use crate::render::RenderError;

/// Columns of `frames.csv`.
pub(super) const FRAMES_HEADER: &str = "frame,t_ns,z_mm,angle_deg,exposure_us,bit_depth,um_per_px\n";

pub(super) fn describe(csv: &mut String, stem: &str, frame: &Frame, um_per_px: f64) {
    let meta = &frame.meta;
    let _ = writeln!(
        csv,
        "{stem},{},{:.6},{:.6},{},{},{um_per_px:.6}",
        meta.t_ns,
        meta.z_mm,
        meta.angle_deg,
        meta.exposure_us,
        frame.view().format().bit_depth()
    );
}

/// Writes a file of a folder; its name may contain folders.
pub(super) fn put(folder: &OutputFolder, name: &str, bytes: Result<Vec<u8>, IoError>) -> Result<(), Failure> {
    let bytes = bytes.map_err(|e| Failure::fail(format!("{name}: cannot be written: {e}")))?;
    Ok(folder.write(name, &bytes)?)
}

pub(super) fn of_render(error: RenderError) -> Failure {
    match error {
        RenderError::Device { .. } | RenderError::NoAdapter { .. } => Failure::fail(error),
        _ => Failure::refuse(error),
    }
}
