//! A recorded run whose next pass is not there yet: what it waits for, and the offsets to cut it
//! with.

use std::fmt;
use std::path::PathBuf;

use serde_json::{Value, json};

use crate::run_folder::OffsetRow;

/// What an unfinished recorded run waits for.
#[derive(Clone, Debug)]
pub(crate) struct Waiting {
    /// The pass whose frames are missing, from 1.
    pub(super) pass: u32,
    /// Where they are looked for.
    pub(super) folder: PathBuf,
    /// The offsets that the pass must be cut with.
    pub(super) offsets: Vec<OffsetRow>,
}

impl Waiting {
    pub(super) fn to_json(&self) -> Value {
        json!({ "pass": self.pass, "folder": self.folder.display().to_string(), "offsets": self.offsets })
    }
}

impl fmt::Display for Waiting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { pass, folder, offsets } = self;
        writeln!(f, "waits for the frames of pass {pass}, cut with these offsets, in {}", folder.display())?;
        write!(f, "       z/mm  offset/mm  commanded/mm")?;
        for row in offsets {
            write!(f, "\n{:11.3} {:10.5}  {:12.5}", row.z_mm, row.offset_mm, row.commanded_mm)?;
        }
        let reason = offsets.first().filter(|row| !row.reason.is_empty());
        reason.map_or(Ok(()), |row| write!(f, "\nheld: {}", row.reason))
    }
}
