//! Results of the study.

use serde::Serialize;

use super::cut::Tried;
use super::noses::NoseFound;

/// What the paper has of a workpiece, mm and %.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct OfPaper {
    /// Mean error before compensation, µm.
    pub before_um: f64,
    /// After it, µm.
    pub after_um: f64,
    /// Reduction as printed, %.
    pub reduction_percent: f64,
}

/// A workpiece cut by one program.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Row {
    /// Number of the workpiece in the paper.
    pub workpiece: usize,
    /// The program.
    pub program: Tried,
    /// Nose radius in the control's register, mm.
    pub register_mm: Option<f64>,
    /// `frames`: by the gauge.
    pub measured_by: &'static str,
    /// Error of the size on a lathe that repeats exactly, µm.
    pub error_um: Option<f64>,
    /// Its standard uncertainty by the gauge, µm.
    pub u_um: Option<f64>,
    /// Reduction of the size of the error against the first program, %.
    pub reduction_percent: Option<f64>,
    /// Mean size of the errors of several workpieces with the lathe's scatter, µm.
    pub scattered_um: Option<f64>,
    /// Its reduction against the first program, %.
    pub scattered_reduction_percent: Option<f64>,
    /// Why there is none.
    pub refused: Option<String>,
    /// Error of the size on the surface itself, on the lathe that repeats exactly, µm; for
    /// comparison only.
    pub true_error_um: Option<f64>,
    /// Calipers in all frames that lie on no line or arc of the size; none of a diameter.
    pub calipers_left_out: Option<usize>,
}

/// Everything that was found.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Study {
    /// The nose by both modes beside the truth.
    pub nose: NoseFound,
    /// Half angles of the cones, degrees.
    pub cone_deg: [f64; 2],
    /// Standard deviation of the slides along X (radial) and Z, µm.
    pub slides_um: [f64; 2],
    /// Workpieces of each kind with scatter.
    pub pieces: u32,
    /// The paper's figures, a workpiece each.
    pub paper: [OfPaper; 4],
    /// A row a workpiece and program.
    pub rows: Vec<Row>,
}
