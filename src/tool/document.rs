//! What `tool compensate --json` prints.

use serde::Serialize;

use super::error::{Place, ToolError};
use super::left::{self, Remainder, Tool};
use super::nose_file::MeasuredNose;
use super::sizes::{self, CornerChange, PieceChange};
use super::ways::{Compensated, Compensator, Way};

/// e(a) in a direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct LeftByAngle {
    /// Angle a of the surface's normal, degrees.
    pub a_deg: f64,
    /// Left along the normal with the register as it is, µm.
    pub e_um: f64,
    /// Its standard uncertainty, µm.
    pub u_um: f64,
}

/// The largest remainder of a way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct LargestLeft {
    /// Left along the normal, µm, below 0 where the nose cuts too deep.
    pub left_um: f64,
    /// Where: Z, mm.
    pub z_mm: f64,
    /// Where: diameter, mm.
    pub diameter_mm: f64,
    /// Angle of the normal there, degrees.
    pub a_deg: f64,
}

/// What a way leaves, or why it is refused.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct WayResult {
    /// The way.
    pub way: Way,
    /// R in the register, mm; absent where the way is refused.
    pub register_mm: Option<f64>,
    /// Its largest remainder.
    pub largest: Option<LargestLeft>,
    /// Why it is refused.
    pub refused: Option<String>,
}

/// The whole result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Document {
    /// Image of the nose.
    pub image: String,
    /// Flags of its measurement.
    pub flags: Vec<String>,
    /// Mean radius of its sectors, mm.
    pub mean_radius_mm: Option<f64>,
    /// Normals that the tool can cut, degrees.
    pub range_deg: [f64; 2],
    /// Gauge point about the tool point (X radial, Z), mm.
    pub gauge_point_mm: [f64; 2],
    /// R in the register today, mm.
    pub register_mm: f64,
    /// e(a) over the normals of the part.
    pub e: Vec<LeftByAngle>,
    /// All ways.
    pub ways: Vec<WayResult>,
    /// The way that is written.
    pub way: Way,
    /// What it leaves of every piece: of the program where there is one.
    pub pieces: Vec<PieceChange>,
    /// How corners move.
    pub corners: Vec<CornerChange>,
    /// Control of the program; absent where none is written.
    pub dialect: Option<&'static str>,
    /// Why no program is written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_program: Option<String>,
    /// What was not checked.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub cautions: Vec<String>,
    /// The largest remainder of the program as written, with its rounding.
    pub program_largest: Option<LargestLeft>,
}

/// Distance of the angles of the document, degrees.
const STEP_DEG: f64 = 1.0;

impl LargestLeft {
    /// Of all places that the tool touches.
    pub(crate) fn of(left: &[Remainder]) -> Option<Self> {
        left::largest(left).map(|r| Self {
            left_um: 1e3 * r.left_mm,
            z_mm: r.at.y,
            diameter_mm: 2.0 * r.at.x,
            a_deg: r.a_rad.to_degrees(),
        })
    }
}

/// e(a) from the least to the largest normal of the part.
pub(crate) fn by_angle(compensator: &Compensator<'_>) -> Vec<LeftByAngle> {
    let angles = compensator.angles();
    let (low, high) =
        angles.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), a| (l.min(*a), h.max(*a)));
    let steps = ((high - low).to_degrees() / STEP_DEG).ceil() as usize;
    let at = |k: usize| if steps == 0 { low } else { low + (high - low) * k as f64 / steps as f64 };
    let of = |a: f64| LeftByAngle {
        a_deg: a.to_degrees(),
        e_um: 1e3 * compensator.setting.left_mm(a, compensator.register_mm),
        u_um: 1e3 * compensator.setting.u_left_mm(a),
    };
    (0..=steps).map(|k| of(at(k))).collect()
}

/// A way carried out, with what its path leaves.
pub(crate) type Measured = (Compensated, Vec<Remainder>);

/// Depth to which a path that follows the measured nose may cut into the part, mm: the increment of
/// most controls, far above what its arcs depart by.
const DEPTH_MM: f64 = 0.001;

/// Carries a way out and measures its path.
///
/// # Errors
/// As [`Compensator::carry_out`]; a path of the measured nose that cuts into the part
/// elsewhere than where it touches.
pub(crate) fn measured(
    compensator: &Compensator<'_>,
    tool: &Tool<'_>,
    way: Way,
) -> Result<Measured, ToolError> {
    let done = compensator.carry_out(way)?;
    let left = left::remainders(compensator.outline, &done.path, &left::moves_of(&done.path), tool);
    let follows = matches!(way, Way::EditedContour | Way::Path);
    let deepest = left.iter().min_by(|a, b| a.left_mm.total_cmp(&b.left_mm));
    match deepest.filter(|r| follows && r.left_mm < -DEPTH_MM) {
        None => Ok((done, left)),
        Some(r) => {
            let why = format!(
                "the nose would cut {:.1} µm too deep while it touches elsewhere; a narrower nose or a wider gap would be \
                 right",
                -1e3 * r.left_mm
            );
            Err(ToolError::Gouge { place: Place(r.at), why })
        }
    }
}

impl Document {
    /// Collects the result of a nose on a part; `left` is what the way written leaves.
    pub(crate) fn new(
        nose: &MeasuredNose,
        compensator: &Compensator<'_>,
        ways: Vec<WayResult>,
        (way, left): (Way, &[Remainder]),
        range_rad: (f64, f64),
    ) -> Self {
        let gauge = compensator.setting.gauge_point();
        let (pieces, corners) = sizes::changes(compensator.outline, left);
        Self {
            image: nose.image.clone(),
            flags: nose.flags.clone(),
            mean_radius_mm: nose.mean_radius_mm,
            range_deg: [range_rad.0.to_degrees(), range_rad.1.to_degrees()],
            gauge_point_mm: [gauge.x, gauge.y],
            register_mm: compensator.register_mm,
            e: by_angle(compensator),
            ways,
            way,
            pieces,
            corners,
            dialect: None,
            no_program: None,
            cautions: Vec::new(),
            program_largest: None,
        }
    }
}
