//! `control.json`: the input of the controller besides the diameters, and its output. A resumed run
//! replays it.

use serde::{Deserialize, Serialize};

use super::folder::{RunFolder, RunFolderError};
use crate::closed_loop::Evidence;
use crate::profile::DiameterProfile;

/// The record of a run's control.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct ControlRecord {
    /// Diameters of the stock, where it was scanned.
    pub stock: Option<DiameterProfile>,
    /// By pass.
    pub passes: Vec<PassRecord>,
}

/// One pass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PassRecord {
    /// Pass, from 1.
    pub pass: u32,
    /// `released`, `held` or `last`.
    pub decision: String,
    /// Why the offsets were held.
    pub reason: Option<String>,
    /// Why the next pass should not be cut before an inspection.
    pub alarm: Option<String>,
    /// Remarks on estimates, fits, interpolation and rounding.
    pub notes: Vec<String>,
    /// Input of the decision besides the profile.
    pub evidence: Evidence,
}

impl ControlRecord {
    /// Input of the decision on a pass; the default where the record does not contain it.
    pub(crate) fn evidence(&self, pass: u32) -> Evidence {
        self.passes.iter().find(|p| p.pass == pass).map_or_else(Evidence::default, |p| p.evidence.clone())
    }
}

const NAME: &str = "control.json";

impl RunFolder {
    /// Writes `control.json`.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub(crate) fn write_control(&self, record: &ControlRecord) -> Result<(), RunFolderError> {
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
    pub(crate) fn control(&self) -> Result<ControlRecord, RunFolderError> {
        if !self.path().join(NAME).exists() {
            return Ok(ControlRecord::default());
        }
        let text = self.read_text(NAME)?;
        serde_json::from_str(&text)
            .map_err(|e| RunFolderError::Read { path: self.path().join(NAME), cause: e.to_string() })
    }
}
