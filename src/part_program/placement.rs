//! The part in the machine: where it stands, and what of it lies in the grip.

use glam::DVec2;

use super::error::PartProgramError;
use crate::outline::{Outline, Piece, Side, meetings};

/// A part in the machine.
#[derive(Clone, Debug)]
pub(crate) struct Placed {
    /// The outside as drawn, from the axis to the axis.
    pub drawn: Outline,
    /// What of it stands out of the grip, without the end at the chuck.
    pub free: Outline,
    /// Z up to which it lies in the grip and stays bar; none where all of it stands out.
    pub gripped_to_mm: Option<f64>,
}

/// Angle of an end face towards the chuck, rad, that counts as one.
const FACE_RAD: f64 = -89.9 * std::f64::consts::PI / 180.0;
/// Length below which a piece is none, mm.
const NO_LENGTH_MM: f64 = 1e-7;

impl Placed {
    /// An outline whose end at the chuck comes to `from_z_mm`; no tool passes `least_z_mm`.
    ///
    /// # Errors
    /// A part that lies in the grip as a whole.
    pub(crate) fn new(outline: &Outline, from_z_mm: f64, least_z_mm: f64) -> Result<Self, PartProgramError> {
        let by = DVec2::new(0.0, from_z_mm - outline.z_mm().0);
        let drawn =
            Outline { pieces: outline.pieces.iter().map(|p| p.moved(by)).collect(), side: Side::External };
        let (start, end) = drawn.z_mm();
        if end <= least_z_mm + NO_LENGTH_MM {
            return Err(PartProgramError::InGrip { end_mm: end, least_mm: least_z_mm });
        }
        let mut pieces = beyond(&drawn.pieces, least_z_mm);
        let faces = pieces.iter().take_while(|p| p.from_rad <= FACE_RAD && p.to_rad <= FACE_RAD).count();
        pieces.drain(..faces);
        let gripped_to_mm = (start < least_z_mm - NO_LENGTH_MM).then_some(least_z_mm);
        Ok(Self { drawn, free: Outline { pieces, side: Side::External }, gripped_to_mm })
    }
}

/// The pieces from the last place on at which an outline passes a plane across the axis.
fn beyond(pieces: &[Piece], z_mm: f64) -> Vec<Piece> {
    let mut kept = Vec::new();
    for piece in pieces.iter().rev() {
        let low = piece.points(0.01).iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
        if low >= z_mm - NO_LENGTH_MM {
            kept.push(*piece);
            continue;
        }
        let plane = Piece::line(DVec2::new(0.0, z_mm), DVec2::new(1.0, z_mm), std::f64::consts::FRAC_PI_2);
        let on = |share: &f64| (0.0..=1.0).contains(share);
        let shares = meetings(&plane, piece).into_iter().map(|at| piece.share_of(at)).filter(on);
        if let Some(share) =
            shares.max_by(f64::total_cmp).filter(|share| (1.0 - share) * piece.length_mm() > NO_LENGTH_MM)
        {
            kept.push(piece.between(share, 1.0));
        }
        break;
    }
    kept.reverse();
    kept
}
