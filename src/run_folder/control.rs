//! `control.json`: what the controller received besides the diameters, and what it returned. A
//! resumed run gives it the same again.

use serde::{Deserialize, Serialize};

use super::folder::{RunFolder, RunFolderError};
use crate::closed_loop::Evidence;
use crate::profile::DiameterProfile;

/// The record of a run's control.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ControlRecord {
    /// Diameters of the stock, where it was scanned.
    pub stock: Option<DiameterProfile>,
    /// By pass.
    pub passes: Vec<PassRecord>,
}

/// One pass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PassRecord {
    /// Pass, from 1.
    pub pass: u32,
    /// `released`, `held` or `last`.
    pub decision: String,
    /// Why the offsets were held.
    pub reason: Option<String>,
    /// Why the next pass should not be cut until someone has looked.
    pub alarm: Option<String>,
    /// Remarks: what was estimated, fitted, interpolated, rounded.
    pub notes: Vec<String>,
    /// What the decision was made by besides the profile.
    pub evidence: Evidence,
}

impl ControlRecord {
    /// What a pass was judged by; nothing where the record does not have it.
    pub fn evidence(&self, pass: u32) -> Evidence {
        self.passes.iter().find(|p| p.pass == pass).map_or_else(Evidence::default, |p| p.evidence.clone())
    }
}

const NAME: &str = "control.json";

impl RunFolder {
    /// Writes `control.json`.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn write_control(&self, record: &ControlRecord) -> Result<(), RunFolderError> {
        let text = serde_json::to_string_pretty(record).map_err(|e| RunFolderError::Write {
            path: self.path().join(NAME),
            cause: std::io::Error::other(e),
        })?;
        self.write(NAME, (text + "\n").as_bytes())
    }

    /// Reads `control.json`; empty where there is none.
    ///
    /// # Errors
    /// Where it cannot be read or parsed.
    pub fn control(&self) -> Result<ControlRecord, RunFolderError> {
        if !self.path().join(NAME).exists() {
            return Ok(ControlRecord::default());
        }
        let text = self.read_text(NAME)?;
        serde_json::from_str(&text)
            .map_err(|e| RunFolderError::Read { path: self.path().join(NAME), cause: e.to_string() })
    }
}
