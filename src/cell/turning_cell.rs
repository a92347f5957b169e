//! The interface of a turning cell for the closed loop: cut a pass, take frames of the part, touch
//! it with a probe.

use thiserror::Error;

use crate::control::{PartAndTool, PartEvent};
use crate::frame::FrameSource;
use crate::plan::{CutSummary, DiameterOffset, FollowPlan, PassPlan, ScanPlan};
use crate::probe::{Touch, TouchOrder};
use crate::shaft::AxisKnot;

/// Why a cell cannot carry out a command.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CellError {
    /// Machine or camera refuse, with their own reason.
    #[error(transparent)]
    Refused(Box<dyn std::error::Error + Send + Sync>),
    /// The cell does not change parts.
    #[error("this cell turns one part only")]
    OnePart,
    /// The cell has no probe.
    #[error("this cell has no touch probe")]
    NoProbe,
    /// The cell has no gauge that follows the tool.
    #[error("this cell cannot be looked at while it cuts: scan.when must be after_pass")]
    NotFollowed,
}

/// A pass in progress with the gauge behind the tool: frames, and the command for the length that
/// is still to be cut.
pub trait FollowedCut: FrameSource {
    /// Machine z of the tool when the last frame was taken, mm.
    fn tool_z_mm(&self) -> f64;

    /// The clock that frames are stamped with, ns; `None` where the cell has none.
    fn now_ns(&self) -> Option<u64> {
        None
    }

    /// Changes the offsets of stations that the tool has not reached; those behind it stay as they
    /// are.
    ///
    /// # Errors
    /// Where the machine refuses.
    fn command(&mut self, offset: &DiameterOffset) -> Result<(), CellError>;

    /// Lets the tool finish the pass.
    ///
    /// # Errors
    /// Where the machine refuses; the workpiece is then as before.
    fn finish(self: Box<Self>) -> Result<(), CellError>;
}

/// A station whose axis is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenStation {
    /// Its chuck end, mm.
    pub from_mm: f64,
    /// Its tailstock end, mm.
    pub to_mm: f64,
    /// Where the middle of the gauge's field stood when it took the station's axis, mm; the
    /// station's middle where it took none.
    pub field_z_mm: f64,
}

/// The axis of a part for comparison only, as it was when it was looked at (tool clear, or bent by
/// the force while it was cut): what stands still and what turns with it, mm. Of a pass that was
/// followed every station is as the burst of frames saw it whose field stood nearest to
/// [`SeenStation::field_z_mm`], its mean over the burst; two knots at one place are a step between
/// two instants.
#[derive(Clone, Debug, PartialEq)]
pub struct TrueAxis {
    /// In the machine's frame.
    pub still: Vec<AxisKnot>,
    /// In the body's frame: bow and eccentricity.
    pub turning: Vec<AxisKnot>,
}

/// A lathe with a gauge on its carriage, real or simulated.
pub trait TurningCell {
    /// Cuts a pass.
    ///
    /// # Errors
    /// Where the machine refuses; the workpiece is then as before.
    fn cut(&mut self, plan: &PassPlan) -> Result<(), CellError>;

    /// Frames of the part in its present state, field after field, angle after angle, tool clear.
    ///
    /// # Errors
    /// Where no frame can be taken at all.
    fn scan(&mut self, plan: &ScanPlan) -> Result<Box<dyn FrameSource + '_>, CellError>;

    /// Whether the part can be scanned once more as it is: a recording may hold one scan alone.
    fn can_scan_again(&self) -> bool {
        true
    }

    /// Frames of master pin `index` of the job.
    ///
    /// # Errors
    /// Where no frame can be taken at all.
    fn scan_master(&mut self, index: usize, frames: usize) -> Result<Box<dyn FrameSource + '_>, CellError>;

    /// Touches of the part in its present state, or of master pin `master` of the job, in the order
    /// requested, spindle at rest.
    ///
    /// # Errors
    /// Where the cell has no probe.
    fn touch(&mut self, _master: Option<usize>, _orders: &[TouchOrder]) -> Result<Vec<Touch>, CellError> {
        Err(CellError::NoProbe)
    }

    /// Cuts a pass while the gauge follows the tool; `FollowedCut::finish` ends it.
    ///
    /// # Errors
    /// Where the machine refuses, or has no such gauge.
    fn cut_followed(
        &mut self,
        _plan: &PassPlan,
        _follow: &FollowPlan,
    ) -> Result<Box<dyn FollowedCut + '_>, CellError> {
        Err(CellError::NotFollowed)
    }

    /// Forces and deflections of the last pass, where the cell has them. For reports only.
    fn last_cut(&self) -> Option<CutSummary> {
        None
    }

    /// The part's axis as the last pass was looked at, stations ascending; `None` where the cell
    /// has no record of it. For comparison only.
    fn true_axis(&self, _seen: &[SeenStation]) -> Option<TrueAxis> {
        None
    }

    /// Clamps the next blank of a batch; `part` counts from 0, the one the cell began with.
    ///
    /// # Errors
    /// Where the cell has no other blank.
    fn next_part(&mut self, _part: u64, _event: PartEvent) -> Result<(), CellError> {
        Err(CellError::OnePart)
    }

    /// Part and tool in the machine; `None` where the cell has no record of them.
    fn in_machine(&self) -> Option<PartAndTool> {
        None
    }

    /// The clock that frames are stamped with, ns; `None` where the cell has none.
    fn now_ns(&self) -> Option<u64> {
        None
    }

    /// Number of a frame of this pass among those of all passes, from its own: the same where the
    /// cell numbers its frames on from pass to pass.
    fn number_among_passes(&self, frame_id: u64) -> u64 {
        frame_id
    }

    /// True mean caliper diameter of stations (z from, z to), mm; `None` for a real part. For
    /// comparison only.
    fn true_stations_mm(&self, stations_mm: &[(f64, f64)]) -> Option<Vec<f64>>;
}
