//! The input of a decision besides the profile: the origin of the scan, a second scan, part and
//! tool in the machine.

use serde::{Deserialize, Serialize};

use crate::cell::TurningCell;
use crate::control::{Origin, PartAndTool};
use crate::frame::FrameMeta;
use crate::profile::DiameterProfile;

/// The data of a scan besides its diameters. A run records them, so that a resumed run decides
/// alike.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// Origin of the scan; `None` where the cell has no record of it.
    pub origin: Option<Origin>,
    /// Part and tool in the machine when the offsets were decided.
    pub in_machine: Option<PartAndTool>,
    /// The second scan, where a step was large enough to need one.
    pub repeat: Option<DiameterProfile>,
    /// Offsets as they were applied, mm of diameter, where control changed them within the pass.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub applied_mm: Option<Vec<f64>>,
}

/// Number and time of a frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stamp {
    frame_id: u64,
    t_ns: u64,
}

impl Stamp {
    pub(super) fn of(meta: &FrameMeta) -> Self {
        Self { frame_id: meta.frame_id, t_ns: meta.t_ns }
    }
}

/// A machine's state between cut and scan.
#[derive(Clone, Debug, Default)]
pub(super) struct AfterCut {
    of: Option<PartAndTool>,
    now_ns: Option<u64>,
}

impl AfterCut {
    pub(super) fn of(cell: &dyn TurningCell) -> Self {
        Self { of: cell.in_machine(), now_ns: cell.now_ns() }
    }

    /// The state at the start of a followed cut.
    pub(super) fn begun(of: Option<PartAndTool>, now_ns: Option<u64>) -> Self {
        Self { of, now_ns }
    }

    /// Origin of a scan with these first and last frames.
    pub(super) fn origin(
        self,
        cell: &dyn TurningCell,
        frames: Option<(Stamp, Stamp)>,
        master_deviation_mm: Option<f64>,
    ) -> Option<Origin> {
        let (first, last) = frames?;
        let (cut_ns, now_ns) = (self.now_ns?, cell.now_ns()?);
        let seconds = |from: u64, to: u64| (i128::from(to) - i128::from(from)) as f64 * 1e-9;
        Some(Origin {
            of: self.of?,
            scan: cell.number_among_passes(last.frame_id),
            age_s: seconds(last.t_ns, now_ns),
            since_cut_s: seconds(cut_ns, first.t_ns),
            master_deviation_mm,
        })
    }
}
