//! Plans of passes and scans: the commands from control to the machine.

mod contour;
mod feed_direction;

use std::fmt;
use std::ops::Range;

pub(crate) use self::contour::{Contour, ContourKnot, Piece, Section, Side, Taper, value_at};
pub use self::feed_direction::FeedDirection;

/// Cutting data of a pass.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CuttingData {
    /// Cutting speed v, m/min.
    pub speed_m_per_min: f64,
    /// Feed f, mm per revolution.
    pub feed_mm_per_rev: f64,
}

/// Corrections along z, subtracted from the nominal when commanding: b = r - o, in mm of diameter.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct DiameterOffset {
    /// Offset per station, mm of diameter; same length and order as the job's stations.
    pub o_mm: Vec<f64>,
}

impl DiameterOffset {
    /// No correction.
    pub fn zero(stations: usize) -> Self {
        Self { o_mm: vec![0.0; stations] }
    }
}

/// One pass to cut.
#[derive(Clone, Debug, PartialEq)]
pub struct PassPlan {
    /// Number of the pass, from 1.
    pub pass: u32,
    /// Nominal diameter r of the pass, mm: its target; of a stepped shaft that of its largest
    /// diameter.
    pub nominal_mm: f64,
    /// Cutting data.
    pub cutting: CuttingData,
    /// Stations' middles, mm, ascending.
    pub station_z_mm: Vec<f64>,
    /// Correction per station.
    pub offset: DiameterOffset,
    /// The part's form.
    pub form: PlannedForm,
}

/// The form that a pass leaves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlannedForm(Option<Contour>);

impl PlannedForm {
    /// A plain cylinder.
    pub const PLAIN: Self = Self(None);

    /// A stepped shaft.
    pub(crate) fn stepped(contour: Contour) -> Self {
        Self(Some(contour))
    }

    /// The contour of a stepped shaft; none for a plain one.
    pub(crate) fn contour(&self) -> Option<&Contour> {
        self.0.as_ref()
    }
}

impl PassPlan {
    /// Nominal diameter of every station, mm.
    pub fn station_nominal_mm(&self) -> impl Iterator<Item = f64> + '_ {
        self.station_z_mm.iter().map(|z| self.nominal_at_mm(*z))
    }

    /// Nominal diameter at z, mm; at a shoulder that of the side of the chuck.
    pub fn nominal_at_mm(&self, z_mm: f64) -> f64 {
        let relative = self.form.contour().map_or(0.0, |c| c.relative_mm(z_mm, Side::Chuck));
        self.nominal_mm + relative
    }

    /// Commanded diameter b = r - o of every station, mm.
    pub fn commanded_mm(&self) -> impl Iterator<Item = f64> + '_ {
        self.station_nominal_mm().zip(&self.offset.o_mm).map(|(r, o)| r - o)
    }

    /// The stations of every cylinder: all of a plain shaft. What is fitted, filled or compared
    /// along z stays within one.
    pub(crate) fn sections(&self) -> Vec<Range<usize>> {
        sections(self.form.contour(), &self.station_z_mm)
    }
}

/// The stations of a part as a controller needs them before the first pass.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct StationLayout {
    /// Their middles, mm, ascending.
    pub z_mm: Vec<f64>,
    /// The contour of a stepped shaft.
    pub contour: Option<Contour>,
    /// Where steady rests stand, mm from the chuck face.
    pub steady_z_mm: Vec<f64>,
}

/// Stations of a plain shaft without steady rests.
impl<T: AsRef<[f64]> + ?Sized> From<&T> for StationLayout {
    fn from(station_z_mm: &T) -> Self {
        Self { z_mm: station_z_mm.as_ref().to_vec(), ..Self::default() }
    }
}

impl StationLayout {
    /// Nominal diameter of every station less that of the pass, mm of diameter.
    pub(crate) fn relative_mm(&self) -> Vec<f64> {
        let at = |z: &f64| self.contour.as_ref().map_or(0.0, |c| c.relative_mm(*z, Side::Chuck));
        self.z_mm.iter().map(at).collect()
    }

    /// The stations of every section; all in one for a plain shaft.
    pub(crate) fn sections(&self) -> Vec<Range<usize>> {
        sections(self.contour.as_ref(), &self.z_mm)
    }
}

/// The stations of every section of a contour; all in one for a plain shaft.
pub(crate) fn sections(contour: Option<&Contour>, station_z_mm: &[f64]) -> Vec<Range<usize>> {
    let whole = 0..station_z_mm.len();
    contour.map_or_else(|| vec![whole], |c| c.stations_of_sections(station_z_mm))
}

/// Extremes of depth, force and deflection in a pass, and its notes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CutSummary {
    /// Number of the pass.
    pub pass: u32,
    /// Smallest actual depth of cut, mm.
    pub min_depth_mm: f64,
    /// Largest actual depth of cut, mm.
    pub max_depth_mm: f64,
    /// Largest radial force, N.
    pub max_force_n: f64,
    /// Largest tangential force, N.
    pub max_cutting_n: f64,
    /// Largest feed force, N.
    pub max_feed_n: f64,
    /// Largest radial deflection at the tool, mm.
    pub max_deflection_mm: f64,
    /// Upper bound of the diameter error of the tangential deflection (equation 3), µm: neglected
    /// in the pass unless `process.bending.tangential_error` is set.
    pub tangential_error_um: f64,
    /// Height of the feed marks f²/8r, µm.
    pub feed_mark_um: f64,
    /// Where the models were used outside their range; empty if nowhere.
    pub notes: Vec<String>,
}

/// Why the last offsets are held.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum HeldReason {
    /// Too many stations without a reading.
    Gaps {
        /// Stations without a value.
        missing: usize,
        /// Stations in all.
        of: usize,
    },
    /// An offset step is larger than the limit.
    StepLimit {
        /// Largest step requested, mm of diameter.
        step_mm: f64,
        /// The limit, mm of diameter.
        limit_mm: f64,
    },
    /// A guard refused; the text names it, its limit and the value found.
    Guard(String),
}

impl fmt::Display for HeldReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Gaps { missing, of } => write!(f, "{missing} of {of} stations have no reading"),
            Self::StepLimit { step_mm, limit_mm } => {
                write!(f, "an offset step of {step_mm:.4} mm exceeds the limit of {limit_mm:.4} mm")
            }
            Self::Guard(text) => f.write_str(text),
        }
    }
}

/// Decision of the controller after a pass.
#[derive(Clone, Debug, PartialEq)]
pub enum Decision {
    /// New offsets for the next pass.
    Offset(DiameterOffset),
    /// The last offsets are held.
    Held(HeldReason),
}

/// Positions of the carriage and spindle angles at which frames are taken.
#[derive(Clone, Debug, PartialEq)]
pub struct ScanPlan {
    /// Machine z of the field centres, mm, ascending.
    pub field_z_mm: Vec<f64>,
    /// Spindle angles of every field, degrees.
    pub angle_deg: Vec<f64>,
}

impl ScanPlan {
    /// Frames in the scan.
    pub fn frames(&self) -> usize {
        self.field_z_mm.len() * self.angle_deg.len()
    }
}

/// A frame taken while a pass is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FollowFrame {
    /// Turns of the spindle since the feed began.
    pub turns: f64,
    /// Machine z of the tool then, mm.
    pub tool_z_mm: f64,
    /// Machine z of the field's centre, mm.
    pub field_z_mm: f64,
    /// Spindle angle, degrees.
    pub angle_deg: f64,
}

/// How the gauge on the carriage follows the tool through a pass.
#[derive(Clone, Debug, PartialEq)]
pub struct FollowPlan {
    /// Speed of the spindle, rev/min.
    pub spindle_rpm: f64,
    /// Feed of the carriage along z, mm/s; below 0 towards the chuck.
    pub carriage_mm_s: f64,
    /// Frames in the order in which they are taken, one burst of `burst` frames per field.
    pub frames: Vec<FollowFrame>,
    /// Frames of a burst.
    pub burst: usize,
    /// Fields that the tool's end position hides, scanned after the pass with the tool clear.
    pub rest: ScanPlan,
}

impl FollowPlan {
    /// Frames in all, those after the pass included.
    pub fn all_frames(&self) -> usize {
        self.frames.len() + self.rest.frames()
    }
}
