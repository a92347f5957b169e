//! The measurement of one frame.

use serde::{Serialize, Serializer};

use super::by_key::by_key;
use super::flags::Flags;
use super::judged::{Judged, StationResult, Verdict};
use super::settling::Settled;
use super::warning::Warning;
use crate::conformity::JudgementError;
use crate::frame::FrameMeta;
use crate::gauge::budget::{Budget, Contribution};
use crate::gauge::plausibility::Jump;
use crate::gauge::{Calibration, Edge, FieldMidline, FrameEdges, LargestCaliper, ShadowsSeen};
use crate::profile::{Diameter, Reason};

/// The measurement of one frame. Its JSON is an element of `frames` of `shadowgauge measure
/// --json`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measurement {
    /// Name of the frame: a file's without its ending.
    pub frame: String,
    /// Number of the frame, as its source counts.
    pub frame_id: u64,
    /// Columns of the frame; 0 where it could not be read.
    pub columns: usize,
    /// Columns with both edges.
    pub valid: usize,
    /// Columns by the reason that they are gaps or impaired.
    pub flags: Flags,
    /// Why the frame has no diameter at all.
    pub refusal: Option<Refusal>,
    /// What else is to be looked at.
    pub warnings: Vec<Warning>,
    /// Other shadows; `None` for a refused frame.
    pub shadows: Option<ShadowsSeen>,
    /// Pitch of crests and roots, px, where the frame was measured as such.
    pub crest_pitch_px: Option<f64>,
    /// The largest caliper diameter, px; NaN where its value in mm is no number.
    pub largest: Option<LargestCaliper>,
    /// Where it is, mm; with a calibration.
    pub place: Option<Place>,
    /// The largest caliper diameter, mm; with a calibration.
    pub diameter: Option<LargestDiameter>,
    /// Its budget, where that was asked for.
    pub budget: Option<Budget>,
    /// Mean diameter of the frame, mm; with a calibration.
    pub mean: Option<Diameter>,
    /// Midline of both edges at the middle of the field; with a calibration.
    pub midline: Option<FieldMidline>,
    /// Average over this and earlier frames, mm, where that was asked for.
    pub average: Option<Diameter>,
    /// Stations along z, where these were asked for.
    pub stations: Option<Vec<StationResult>>,
    /// Diameters that contradict earlier turns.
    pub jumps: Vec<Jump>,
    /// Whether the diameter has settled by this frame, where that was asked for.
    pub settled: Option<Settled>,
    /// Whether it lies in the tolerance.
    pub judgement: Verdict,
    /// The value that decided it.
    pub judged: Option<Judged>,
    /// Why no uncertainty like this frame's proves conformity to the tolerance.
    pub acceptance_zone: Option<JudgementError>,
}

/// Why a frame has no diameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// The reason that all its columns have.
    pub reason: Reason,
    /// What was seen and what would be right.
    pub why: String,
}

/// The place of a largest diameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// z of its column, mm.
    pub z_mm: f64,
    /// Length of the stretch that it stands for, mm.
    pub stretch_mm: f64,
}

/// The largest diameter of a frame at 20 °C.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LargestDiameter {
    /// Diameter with its random and common standard uncertainty, mm.
    pub diameter: Diameter,
    /// Combined standard uncertainty, mm.
    pub u_mm: f64,
    /// Effective degrees of freedom of it; infinite for many.
    pub freedom: f64,
    /// Coverage factor k.
    pub coverage_factor: f64,
    /// Expanded uncertainty U = k·u, mm.
    pub expanded_u_mm: f64,
}

impl LargestDiameter {
    /// Of a budget; k is the one given, otherwise that of 95.45 %.
    pub(super) fn of(budget: &Budget, given: Option<f64>) -> Self {
        let coverage_factor = budget.factor_or(given);
        Self {
            diameter: Diameter {
                d_mm: budget.diameter_mm,
                u_random_mm: budget.u_random_mm(),
                u_common_mm: budget.u_common_mm(),
            },
            u_mm: budget.u_mm(),
            freedom: budget.effective_freedom(),
            coverage_factor,
            expanded_u_mm: coverage_factor * budget.u_mm(),
        }
    }
}

impl LargestDiameter {
    /// Takes in another common standard uncertainty, mm.
    pub(super) fn widen(&mut self, u_mm: f64) {
        self.diameter.u_common_mm = self.diameter.u_common_mm.hypot(u_mm);
        self.u_mm = self.u_mm.hypot(u_mm);
        self.expanded_u_mm = self.coverage_factor * self.u_mm;
    }
}

impl Measurement {
    /// Starts another frame; keeps the memory.
    pub(super) fn begin(&mut self, frame: &str, frame_id: u64, columns: usize) {
        let mut old = std::mem::take(self);
        old.frame.clear();
        old.frame.push_str(frame);
        old.flags.clear();
        old.warnings.clear();
        old.jumps.clear();
        let (frame, flags, warnings, jumps) = (old.frame, old.flags, old.warnings, old.jumps);
        *self = Self { frame, frame_id, columns, flags, warnings, jumps, ..Self::default() };
    }

    /// Turns every column into a gap.
    pub(super) fn refuse(&mut self, reason: Reason, why: String) {
        self.flags.clear();
        self.flags.add(reason, self.columns.max(1));
        self.refusal = Some(Refusal { reason, why });
    }

    /// Takes what the edges show, in pixels.
    pub(super) fn take_edges(&mut self, edges: &FrameEdges, largest: Option<LargestCaliper>) {
        self.valid = edges.valid();
        self.largest = largest;
        self.shadows = Some(edges.figures.shadows);
        for (top, bottom) in edges.top.iter().zip(&edges.bottom) {
            if let Some(reason) = Edge::reason_of_both(top, bottom) {
                self.flags.add(reason, 1);
            }
        }
    }

    /// Takes the place of the largest diameter.
    pub(super) fn take_place(&mut self, meta: &FrameMeta, calibration: &Calibration) {
        let Some(largest) = &self.largest else { return };
        let pitch_mm = calibration.scale_mm_per_px;
        let off = largest.column_px - 0.5 * (self.columns as f64 - 1.0);
        self.place = Some(Place {
            z_mm: meta.z_mm + off * pitch_mm,
            stretch_mm: largest.stretch_columns() as f64 * pitch_mm,
        });
    }
}

/// The keys of a frame.
#[derive(Serialize)]
struct Keys<'a> {
    frame: &'a str,
    columns: usize,
    valid: usize,
    flags: &'a Flags,
    #[serde(skip_serializing_if = "Option::is_none")]
    warnings: Option<Warnings<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    shadows: Option<ShadowsSeen>,
    #[serde(skip_serializing_if = "Option::is_none")]
    crest_pitch_px: Option<f64>,
    max_diameter_px: Option<f64>,
    u_max_px: Option<f64>,
    #[serde(flatten)]
    stretch: Option<StretchKeys>,
    #[serde(flatten)]
    place: Option<PlaceKeys>,
    max_diameter_mm: Option<f64>,
    u_max_mm: Option<f64>,
    #[serde(flatten)]
    largest: Option<LargestKeys>,
    #[serde(flatten)]
    budget: Option<BudgetKeys<'a>>,
    #[serde(flatten)]
    mean: Option<MeanKeys>,
    #[serde(flatten)]
    average: Option<AverageKeys>,
    #[serde(skip_serializing_if = "Option::is_none")]
    stations: Option<&'a [StationResult]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    settled: Option<Settled>,
    #[serde(skip_serializing_if = "Verdict::is_absent")]
    judgement: Verdict,
    #[serde(skip_serializing_if = "Option::is_none")]
    judged: Option<Judged>,
    #[serde(skip_serializing_if = "Option::is_none")]
    acceptance_zone: Option<String>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Warnings<'a> {
    Refused([&'a str; 1]),
    Seen(&'a [Warning]),
}

#[derive(Serialize)]
struct StretchKeys {
    max_column_px: f64,
    max_stretch_columns: usize,
    max_stretch_px: [usize; 2],
    max_of: &'static str,
}

#[derive(Serialize)]
struct PlaceKeys {
    max_z_mm: f64,
    max_stretch_mm: f64,
}

/// `u_random_mm` and `u_common_mm`, elsewhere those of `d_mm`, were the largest diameter's: for one
/// version it has them under both names.
#[derive(Serialize)]
struct LargestKeys {
    u_max_random_mm: f64,
    u_random_mm: f64,
    u_max_common_mm: f64,
    u_common_mm: f64,
    expanded_u_max_mm: f64,
    coverage_factor: f64,
}

#[derive(Serialize)]
struct BudgetKeys<'a> {
    budget: &'a [Contribution],
    effective_freedom: Option<f64>,
}

/// For one version the u also under its old name, which the u of the frames' mean has too.
#[derive(Serialize)]
struct MeanKeys {
    mean_diameter_mm: f64,
    u_mean_diameter_mm: f64,
    u_mean_mm: f64,
}

#[derive(Serialize)]
struct AverageKeys {
    average_mm: f64,
    u_average_mm: f64,
}

impl StretchKeys {
    fn of(largest: &LargestCaliper) -> Self {
        Self {
            max_column_px: largest.column_px,
            max_stretch_columns: largest.stretch_columns(),
            max_stretch_px: [largest.stretch.0, largest.stretch.1],
            max_of: match (largest.end_on, largest.tangents) {
                (true, _) => "disc",
                (_, true) => "tangents",
                _ => "widths",
            },
        }
    }
}

impl LargestKeys {
    fn of(largest: &LargestDiameter) -> Self {
        let Diameter { u_random_mm, u_common_mm, .. } = largest.diameter;
        Self {
            u_max_random_mm: u_random_mm,
            u_random_mm,
            u_max_common_mm: u_common_mm,
            u_common_mm,
            expanded_u_max_mm: largest.expanded_u_mm,
            coverage_factor: largest.coverage_factor,
        }
    }
}

impl<'a> Keys<'a> {
    fn of(m: &'a Measurement) -> Self {
        let seen = (!m.warnings.is_empty()).then_some(Warnings::Seen(&m.warnings));
        let refused = m.refusal.as_ref().map(|r| Warnings::Refused([&r.why]));
        let mean = |d: Diameter| MeanKeys {
            mean_diameter_mm: d.d_mm,
            u_mean_diameter_mm: d.u_mm(),
            u_mean_mm: d.u_mm(),
        };
        let budget = |b: &'a Budget| BudgetKeys {
            budget: &b.contributions,
            effective_freedom: Some(b.effective_freedom()).filter(|n| n.is_finite()),
        };
        Self {
            frame: &m.frame,
            columns: m.columns,
            valid: m.valid,
            flags: &m.flags,
            warnings: refused.or(seen),
            shadows: m.shadows,
            crest_pitch_px: m.crest_pitch_px,
            max_diameter_px: m.largest.map(|l| l.diameter_px),
            u_max_px: m.largest.map(|l| l.u_px),
            stretch: m.largest.as_ref().map(StretchKeys::of),
            place: m.place.map(|p| PlaceKeys { max_z_mm: p.z_mm, max_stretch_mm: p.stretch_mm }),
            max_diameter_mm: m.diameter.map(|l| l.diameter.d_mm),
            u_max_mm: m.diameter.map(|l| l.u_mm),
            largest: m.diameter.as_ref().map(LargestKeys::of),
            budget: m.budget.as_ref().map(budget),
            mean: m.mean.map(mean),
            average: m.average.map(|d| AverageKeys { average_mm: d.d_mm, u_average_mm: d.u_mm() }),
            stations: m.stations.as_deref(),
            settled: m.settled,
            judgement: m.judgement,
            judged: m.judged,
            acceptance_zone: m.acceptance_zone.as_ref().map(ToString::to_string),
        }
    }
}

impl Serialize for Measurement {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        by_key(&Keys::of(self), serializer)
    }
}
