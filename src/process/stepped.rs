//! A shaft of constant pieces under a load anywhere: exact, without a mesh.

use super::beam::{Part, Supports, compliance_at_joint};
use super::section::Section;

/// A piece of constant diameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Piece {
    /// Length, mm.
    pub length_mm: f64,
    /// Section ahead of the tool.
    pub ahead: Section,
    /// Section behind the tool (which travels towards the chuck).
    pub behind: Section,
}

/// A shaft of pieces from chuck to tailstock, and its supports.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SteppedShaft {
    /// Pieces, in the order of z.
    pub pieces: Vec<Piece>,
    /// Supports.
    pub supports: Supports,
}

/// The highest compliance under a travelling load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Softest {
    /// Where, mm.
    pub z_mm: f64,
    /// Radial deflection at the load per newton, mm/N.
    pub compliance_mm_per_n: f64,
}

/// Positions at which the search for the maximum starts.
const SCAN: usize = 1000;

impl SteppedShaft {
    /// Length from chuck to tailstock, mm.
    pub(crate) fn length_mm(&self) -> f64 {
        self.pieces.iter().map(|piece| piece.length_mm).sum()
    }

    /// Radial deflection at a load at `z_mm` per newton, mm/N. Positions outside the shaft are
    /// moved to its ends.
    pub(crate) fn compliance_mm_per_n(&self, z_mm: f64) -> f64 {
        let length = self.length_mm();
        let z = z_mm.clamp(0.0, length);
        let mut rests: Vec<(f64, f64)> =
            self.supports.steady_rests.iter().map(|rest| (rest.z_mm, rest.compliance_mm_per_n)).collect();
        rests.sort_by(|a, b| a.0.total_cmp(&b.0));
        let near: Vec<(f64, f64)> = rests.iter().copied().filter(|rest| rest.0 <= z).collect();
        let far: Vec<(f64, f64)> =
            rests.iter().rev().filter(|rest| rest.0 > z).map(|rest| (length - rest.0, rest.1)).collect();
        let ahead = self.pieces.iter().map(|piece| (piece.length_mm, piece.ahead));
        let behind = self.pieces.iter().rev().map(|piece| (piece.length_mm, piece.behind));
        let left = grown(self.supports.chuck, ahead, &near, z);
        let right = grown(self.supports.tailstock, behind, &far, length - z);
        compliance_at_joint(&left, &right)
    }

    /// Where the shaft yields most, by a scan and a golden section search around its best position.
    pub(crate) fn softest(&self) -> Softest {
        let step = self.length_mm() / SCAN as f64;
        let at = |z: f64| self.compliance_mm_per_n(z);
        let best =
            (0..=SCAN).map(|i| i as f64 * step).max_by(|a, b| at(*a).total_cmp(&at(*b))).unwrap_or(0.0);
        let (mut low, mut high) = ((best - step).max(0.0), (best + step).min(self.length_mm()));
        let golden = 0.5 * (5f64.sqrt() - 1.0);
        for _ in 0..60 {
            let (a, b) = (high - golden * (high - low), low + golden * (high - low));
            (low, high) = if at(a) > at(b) { (low, b) } else { (a, high) };
        }
        let z_mm = 0.5 * (low + high);
        Softest { z_mm, compliance_mm_per_n: at(z_mm) }
    }
}

/// The part from its support over `pieces` to `reach_mm`, with its steady rests (ascending, at most
/// `reach_mm` away).
fn grown(
    support: Part,
    pieces: impl Iterator<Item = (f64, Section)>,
    rests: &[(f64, f64)],
    reach_mm: f64,
) -> Part {
    let (mut part, mut at, mut boundary) = (support, 0.0, 0.0);
    let mut rests = rests.iter().peekable();
    for (length, section) in pieces {
        boundary += length;
        let end = f64::min(boundary, reach_mm);
        while let Some((z, compliance)) = rests.next_if(|rest| rest.0 <= end) {
            part.extend(z - at, &section);
            part.support(*compliance);
            at = *z;
        }
        part.extend((end - at).max(0.0), &section);
        at = at.max(end);
    }
    part
}
