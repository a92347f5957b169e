//! A recorded run: the frames of its scans in folders.
//!
//! ```text
//! SOURCE/
//!   calibration.json       of the camera, or masters/pin_1/, masters/pin_2/, … in the job's order
//!   stock/                 where the stock is scanned before the first pass
//!   pass_1/                frames, and frames.csv with frame, z_mm, angle_deg
//!     again/               a second scan of the same pass, where a guard needs one
//!     master/              frames of the first pin after the pass (masters.check_frames)
//!   pass_2/ …
//! ```
//!
//! A folder that has images of its own holds the scan of the first pass alone. Place and angle of a
//! frame of the part come from the `frames.csv` beside it: without one every frame would stand at
//! z = 0, so that a scan without it is refused.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::folder::{FileFrames, images_in, listing};
use super::frame_table::FrameTable;
use super::read_error::ReadError;
use crate::plan::ScanPlan;
use crate::position::EncoderSettings;

/// A scan of a recorded run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RecordedScan {
    /// The stock, before the first pass.
    Stock,
    /// The part after a pass, from 1.
    Pass(u32),
    /// A second scan of the same pass.
    Again(u32),
}

/// The folder of a recorded run.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Recording {
    root: PathBuf,
    encoder: Option<EncoderSettings>,
}

/// Kinds of sources that are named `KIND:…` or `-`, and what each is.
const OTHER_KINDS: [(&str, &str); 5] = [
    ("gige:", "a GigE Vision camera"),
    ("usb:", "a USB3 Vision camera"),
    ("sim:", "a simulated camera"),
    ("replay:", "a recording in MCAP"),
    ("raw:", "raw pixels"),
];

/// The path that a source names.
///
/// # Errors
/// A source of another kind than a folder or files, by its name.
fn path_of(source: &str) -> Result<&str, String> {
    let other = OTHER_KINDS.iter().find(|(kind, _)| source.starts_with(kind));
    match (source, other) {
        (_, Some((kind, what))) => Err(format!(
            "{source:?}: {what} ({kind}) is not read by a run yet; give the folder with the frames of its passes"
        )),
        ("-", None) => {
            Err("\"-\": a run reads its frames pass by pass; give the folder with them".to_owned())
        }
        ("", None) => Err("is empty; give the folder with the frames of the passes".to_owned()),
        (path, None) => Ok(path),
    }
}

impl Recording {
    /// The recording that a source names; a relative path starts from `folder`.
    ///
    /// # Errors
    /// A source of another kind, or a path that is not there.
    pub(crate) fn open(source: &str, folder: &Path) -> Result<Self, String> {
        let root = folder.join(path_of(source)?);
        match root.exists() {
            true => Ok(Self { root, encoder: None }),
            false => {
                Err(format!("{}: there is no such folder; give the one with the frames", root.display()))
            }
        }
    }

    /// Takes the spindle angles from encoder counts.
    #[must_use]
    pub(crate) fn by_encoder(self, encoder: Option<EncoderSettings>) -> Self {
        Self { encoder, ..self }
    }

    /// Frames of the part, whose stops are paired with those of a plan.
    ///
    /// # Errors
    /// A stop without its frames; see [`FrameTable::check_stops`].
    pub(crate) fn frames(&self, images: Vec<PathBuf>, plan: &ScanPlan) -> Result<FileFrames, ReadError> {
        let folders: BTreeSet<&Path> = images.iter().filter_map(|image| image.parent()).collect();
        for folder in folders {
            let Some(table) = table_beside(folder) else { continue };
            FrameTable::read(&table)?.check_stops(plan.frames(), plan.field_z_mm.len())?;
        }
        Ok(FileFrames::new(images).by_encoder(self.encoder))
    }

    /// The folder.
    pub(crate) fn root(&self) -> &Path {
        &self.root
    }

    /// Where the frames of a scan lie, or would lie.
    pub(crate) fn place(&self, scan: RecordedScan) -> PathBuf {
        match scan {
            RecordedScan::Stock => self.root.join("stock"),
            RecordedScan::Pass(1) if self.is_one_scan() => self.root.clone(),
            RecordedScan::Pass(pass) => self.root.join(format!("pass_{pass}")),
            RecordedScan::Again(pass) => self.place(RecordedScan::Pass(pass)).join("again"),
        }
    }

    /// Where the frames of a master pin (from 1) lie, or would lie.
    pub(crate) fn pin_place(&self, pin: usize) -> PathBuf {
        self.root.join("masters").join(format!("pin_{pin}"))
    }

    /// Where the frames of the first pin after a pass lie, or would lie.
    pub(crate) fn check_place(&self, pass: u32) -> PathBuf {
        self.place(RecordedScan::Pass(pass)).join("master")
    }

    /// The calibration of the camera, where it lies in the folder.
    pub(crate) fn calibration(&self) -> Option<PathBuf> {
        Some(self.root.join("calibration.json")).filter(|path| path.is_file())
    }

    /// Whether the folder itself holds the frames of the only pass.
    fn is_one_scan(&self) -> bool {
        let own = |folder: &Path| images_in(folder).is_ok_and(|images| !images.is_empty());
        self.root.is_file() || own(&self.root) || own(&self.root.join("frames"))
    }

    /// Whether the frames of a scan are there.
    pub(crate) fn has(&self, scan: RecordedScan) -> bool {
        listing(&self.place(scan)).is_ok()
    }

    /// Images of a scan, in the order of the numbers in their names, with their table.
    ///
    /// # Errors
    /// Images or a table that are not there, a table without place or angle.
    pub(crate) fn images(&self, scan: RecordedScan) -> Result<Vec<PathBuf>, ReadError> {
        let images = listing(&self.place(scan))?.images;
        check_places(&images)?;
        Ok(images)
    }

    /// Frames in a folder without place and angle: those of a pin.
    ///
    /// # Errors
    /// A folder that cannot be read or has no image.
    pub(crate) fn frames_in(folder: &Path) -> Result<FileFrames, ReadError> {
        listing(folder).map(|listed| FileFrames::new(listed.images))
    }
}

/// Whether a `frames.csv` beside every image, or above its `frames` folder, gives place and angle.
///
/// # Errors
/// A table that is not there or lacks a column.
pub(crate) fn check_places(images: &[PathBuf]) -> Result<(), ReadError> {
    let folders: BTreeSet<&Path> = images.iter().filter_map(|image| image.parent()).collect();
    folders.into_iter().try_for_each(check_table)
}

/// The table beside the images of a folder, or above a folder `frames`.
fn table_beside(folder: &Path) -> Option<PathBuf> {
    let above = folder.parent().filter(|_| folder.ends_with("frames"));
    let tables = [Some(folder), above].into_iter().flatten().map(|folder| folder.join("frames.csv"));
    tables.into_iter().find(|path| path.is_file())
}

fn check_table(folder: &Path) -> Result<(), ReadError> {
    let Some(table) = table_beside(folder) else {
        return Err(ReadError::NoPlaces {
            path: folder.join("frames.csv").display().to_string(),
            missing: "",
        });
    };
    match FrameTable::missing_place(&table)? {
        None => Ok(()),
        Some(missing) => Err(ReadError::NoPlaces { path: table.display().to_string(), missing }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_kinds_of_sources_are_refused_by_their_names() {
        for source in ["gige:10.0.0.7", "sim:job.toml", "replay:day.mcap", "raw:-", "-", ""] {
            let refused = Recording::open(source, Path::new(".")).expect_err(source);
            assert!(refused.contains("folder"), "{source}: {refused}");
        }
        let refused = Recording::open("no such folder", Path::new(".")).expect_err("it is not there");
        assert!(refused.contains("no such folder"), "{refused}");
    }
}
