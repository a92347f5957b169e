//! What a program is given of a part before its first pass.

use crate::plan::CuttingData;

/// What a program is given of a part before its first pass: the order, nothing of the truth.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub(crate) struct PartFacts {
    /// For the program's own random numbers, so that a study can be repeated.
    pub seed: u64,
    /// Middles of the stations, mm from the chuck face, ascending.
    pub station_z_mm: Vec<f64>,
    /// Target diameter r of every pass, mm.
    pub nominal_mm: Vec<f64>,
    /// Of a stepped shaft the nominal diameter of every station less that of the pass, mm; left out
    /// of a plain one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub station_relative_mm: Vec<f64>,
    /// Of a stepped shaft lower and upper limit of every station, mm, none where its section has no
    /// tolerance; left out of a plain one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub station_limits_mm: Vec<Option<(f64, f64)>>,
    /// Lower and upper limit of the finished diameter, mm; none without a tolerance.
    pub tolerance_mm: Option<(f64, f64)>,
    /// Cutting data of the passes.
    pub cutting: CuttingData,
}
