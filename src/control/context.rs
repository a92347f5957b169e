//! The context of a pass besides its diameters: the origin of the measurement and the next pass.
//!
//! A guard whose input is missing does not run.

use crate::plan::CuttingData;
use crate::profile::DiameterProfile;

/// A part and a tool, by the names that the cell gives them.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct PartAndTool {
    /// Identity of the part.
    pub part: String,
    /// Identity of the tool, with its insert.
    pub tool: String,
}

/// The origin of a measurement.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Origin {
    /// Part and tool that were measured.
    pub of: PartAndTool,
    /// Running number of the scan; every scan is used once.
    pub scan: u64,
    /// Time since the scan ended, s.
    pub age_s: f64,
    /// From the end of the cut to the start of the scan, s: below zero for a scan taken before the
    /// pass was cut.
    pub since_cut_s: f64,
    /// Reading of a master of known diameter in the same scan, minus that diameter, mm.
    pub master_deviation_mm: Option<f64>,
}

/// The pass that the offsets are for.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct NextPass {
    /// Nominal diameter r(k+1), mm.
    pub nominal_mm: f64,
    /// Cutting data.
    pub cutting: CuttingData,
    /// Whether it is the last pass.
    pub finishing: bool,
}

/// The context of a pass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassContext<'a> {
    /// Origin of the measurement.
    pub origin: Option<&'a Origin>,
    /// Part and tool that are in the machine now.
    pub in_machine: Option<&'a PartAndTool>,
    /// A second scan of the same pass.
    pub repeat: Option<&'a DiameterProfile>,
    /// The next pass.
    pub next: Option<NextPass>,
    /// Diameter before the next pass where that is cut from another blank than the one measured,
    /// mm; `None` where it is cut from the part as it was measured.
    pub blank_mm: Option<f64>,
}

/// The start of a part.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PartStart<'a> {
    /// What changed since the last part.
    pub event: PartEvent,
    /// Diameters of the stock, where it was measured before the first pass.
    pub stock: Option<&'a DiameterProfile>,
}

/// What changed since the last part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PartEvent {
    /// Nothing: wear and warming continue.
    #[default]
    Continued,
    /// A new insert: wear starts again.
    InsertChanged,
    /// The machine has cooled down: warming starts again.
    ColdStart,
}
