//! How the part is scanned, and the master pins that the gauge is calibrated on at the start of a
//! run.

use crate::gauge::MasterCertificate;
use crate::gauge::calibration::LimbDifference;
use crate::position::EncoderSettings;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the camera scans the part after a pass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Scan {
    /// Positions of the carriage along z; together their fields must cover the part.
    pub fields: usize,
    /// Spindle angles of every field, equally spaced over half a turn (a caliper diameter repeats
    /// after 180°).
    pub angles: usize,
    /// Whether the stock is scanned before the first pass. Its form is copied into the first pass
    /// in part: a controller that has seen it need not guess what was copied and what is the
    /// shaft's own yielding.
    pub stock: StockScan,
    /// Whether the part is scanned after the pass, tool clear, or by a gauge that follows the tool
    /// while it cuts.
    pub when: ScanWhen,
    /// Distance of the field's centre behind the tool while it cuts, mm.
    pub behind_tool_mm: f64,
    /// Temperature of the part above 20 °C while it is scanned, K, as a thermometer shows:
    /// diameters are given at 20 °C (ISO 1).
    pub part_rise_k: f64,
    /// Limits of its error, ± K.
    pub limit_part_rise_k: f64,
    /// How far the part's limbs stand from the line through the masters', as `optics limb` prints
    /// it; `run` computes it where `[optics.esf.cylinder]` images limbs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limb: Option<LimbDifference>,
    /// The spindle's encoder, whose counts stand in the `frames.csv` of a recorded run in place of
    /// angles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub encoder: Option<EncoderSettings>,
}

/// When the part is scanned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ScanWhen {
    /// After the pass, at standstill at every angle.
    #[default]
    AfterPass,
    /// While it is cut: bent by the force of that moment, turning at cutting speed.
    DuringCut,
}

/// Whether the stock is scanned before the first pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum StockScan {
    /// Where the controller makes use of it: the model-based one.
    #[default]
    Auto,
    /// Before every part.
    Always,
    /// Not at all.
    Never,
}

impl Default for Scan {
    fn default() -> Self {
        Self {
            fields: 14,
            angles: 8,
            stock: StockScan::default(),
            when: ScanWhen::default(),
            behind_tool_mm: 30.0,
            part_rise_k: 0.0,
            limit_part_rise_k: 0.0,
            limb: None,
            encoder: None,
        }
    }
}

/// How the gauge is calibrated at the start of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Masters {
    /// Two or more pins of different diameter.
    pub pins: Vec<MasterCertificate>,
    /// Frames taken of each pin.
    pub frames_each: usize,
    /// Frames taken of the first pin after every scan, for the guard against a gauge that drifts; 0
    /// for none.
    pub check_frames: usize,
}

impl Default for Masters {
    fn default() -> Self {
        let pin =
            |diameter_mm| MasterCertificate { diameter_mm, expanded_u_mm: 1.0e-4, coverage_factor: 2.0 };
        Self { pins: vec![pin(24.0), pin(28.0)], frames_each: 8, check_frames: 1 }
    }
}
