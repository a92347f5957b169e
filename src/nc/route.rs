//! Where a program moves: the change position, the way down to the part, and the ends of the cut.
//!
//! ```text
//!      change position  x . . . . . . . . . . . . . . . . x
//!                                                         .   rapid, one axis at a time
//!        clear diameter  ------------------------- v . . .
//!                                                  |          feed, radially
//!   jaws | least_z  <=============================='  | gap | centre
//!        0                                            L
//! ```
//!
//! The programmed point is the leading side of the nose: the one towards the chuck where the tool
//! travels towards the chuck, the other one where it travels to the tailstock. So no part of the
//! nose passes `least_z_mm`, and its lowest point passes the end face, in both directions.

use super::error::NcError;
use super::machine::{ChangePosition, Direction, Tailstock};
use super::settings::NcSettings;
use crate::plan::{Contour, Side};

/// Nose radius where none is stated, mm: the largest that is usual for finishing (ISO 1832 corner
/// codes 04 and 08).
pub(super) const NOSE_RADIUS_MM: f64 = 0.8;
/// Path beyond the end face where a centre stands, mm: long enough to clear the nose, short enough
/// to stay off the cone.
const GAP_AT_CENTRE_MM: f64 = 0.5;
/// Quill that is assumed where none is stated, mm of diameter: larger than on lathes for parts of
/// these sizes.
pub(super) const QUILL_MM: f64 = 80.0;
/// Distance between the change position and everything that stands around the part, mm of diameter
/// or of Z.
const ROOM_AT_CHANGE_MM: f64 = 20.0;

/// The part as it stands in the machine before the pass.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Workpiece {
    /// Length from the face that clamps it to its end face, mm.
    pub length_mm: f64,
    /// Diameter of the blank, mm, which remains where no pass cuts.
    pub stock_mm: f64,
    /// Diameter before the pass, mm.
    pub before_mm: f64,
    /// The way the tool travels.
    pub direction: Direction,
    /// Middles of steady rests that the run states, mm.
    pub steady_z_mm: Vec<f64>,
    /// Places that a probe touches, Z ascending, mm; the six of paper 000 where none are listed.
    pub probe_z_mm: Vec<f64>,
    /// The contour of a stepped shaft; diameters are those of its largest section.
    pub contour: Option<Contour>,
    /// Lower and upper limit of the finished part, mm, whichever pass is written; `None` where no
    /// tolerance is stated.
    pub tolerance_mm: Option<(f64, f64)>,
}

impl Workpiece {
    /// A part without steady rests, cut towards the chuck.
    pub(crate) fn new(length_mm: f64, stock_mm: f64, before_mm: f64) -> Self {
        Self {
            length_mm,
            stock_mm,
            before_mm,
            direction: Direction::default(),
            steady_z_mm: Vec::new(),
            probe_z_mm: Vec::new(),
            contour: None,
            tolerance_mm: None,
        }
    }

    pub(super) fn check(&self, nominal_mm: f64) -> Result<(), NcError> {
        let lengths = [self.length_mm, self.stock_mm, self.before_mm];
        if lengths.iter().any(|l| !(*l > 0.0 && l.is_finite())) {
            return Err(NcError::Plan("length and diameters of the part must be positive".into()));
        }
        if self.before_mm < nominal_mm {
            return Err(NcError::Plan(format!(
                "the diameter before the pass, {} mm, must not be below the nominal {nominal_mm} mm",
                self.before_mm
            )));
        }
        Ok(())
    }

    /// Solids that make up the part before the pass: (Z from, Z to, diameter at both), mm. A piece
    /// of a stepped shaft that is no taper is as wide as its widest point, fillets included.
    pub(super) fn solids_before(&self) -> Vec<[(f64, f64); 2]> {
        let Some(contour) = &self.contour else {
            return vec![[(0.0, self.before_mm), (self.length_mm, self.before_mm)]];
        };
        let mut places = vec![0.0, self.length_mm];
        for s in &contour.sections {
            places.extend([s.ends_mm.0, s.clear_mm.0, s.clear_mm.1, s.ends_mm.1]);
        }
        places.extend(contour.tapers.iter().flat_map(|t| [t.ends_mm.0, t.ends_mm.1]));
        places.sort_by(f64::total_cmp);
        places.dedup();
        let piece = |w: &[f64]| {
            let (from, to) = (w[0], w[1]);
            let ends = [contour.relative_mm(from, Side::Tailstock), contour.relative_mm(to, Side::Chuck)];
            let is_taper = contour.tapers.iter().any(|t| t.ends_mm.0 <= from && to <= t.ends_mm.1);
            let inside = contour.knots.iter().filter(|k| k.z_mm > from && k.z_mm < to).map(|k| k.relative_mm);
            let widest = inside.chain(ends).fold(f64::NEG_INFINITY, f64::max);
            let [a, b] = if is_taper { ends } else { [widest; 2] };
            [(from, self.before_mm + a), (to, self.before_mm + b)]
        };
        places.windows(2).map(piece).collect()
    }

    /// Largest diameter of the turned part, mm.
    pub(super) fn largest_mm(&self) -> f64 {
        self.stock_mm.max(self.before_mm)
    }
}

/// The places of a program, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Route {
    pub(super) change: ChangePosition,
    /// Diameter at which the tool travels above the part, mm.
    pub(super) clear_mm: f64,
    /// Programmed Z of the first and the last point of the cut, mm.
    pub(super) z_first: f64,
    pub(super) z_last: f64,
    /// Nose radius, stated or assumed, mm.
    pub(super) nose_mm: f64,
    /// Z from which, up to the end face, the nose's lowest point reaches the programmed diameter,
    /// mm.
    pub(super) full_from_mm: f64,
}

impl Route {
    pub(super) fn new(piece: &Workpiece, settings: &NcSettings) -> Result<Self, NcError> {
        let nose_mm = settings.nose_radius_mm.unwrap_or(NOSE_RADIUS_MM);
        let clear_mm = piece.largest_mm() + settings.clearance_mm;
        let gap = match settings.tailstock {
            Some(Tailstock::Absent) => settings.lead_in_mm,
            _ => settings.lead_in_mm.min(GAP_AT_CENTRE_MM),
        };
        let (least, end) = (settings.least_z_mm, piece.length_mm);
        let (z_first, z_last) = match piece.direction {
            Direction::TowardsChuck => (end + gap, least),
            Direction::TowardsTailstock => (least + 2.0 * nose_mm, end + nose_mm + gap),
        };
        let full_from_mm = least + nose_mm;
        if full_from_mm >= end {
            return Err(NcError::Plan(format!(
                "nothing would be cut: nc.least_z_mm = {least} and a nose radius of {nose_mm} mm leave nothing of a part \
                 of {end} mm"
            )));
        }
        let change = settings.change_position.unwrap_or_else(|| assumed_change(piece, settings, clear_mm));
        if change.x_mm <= clear_mm {
            return Err(NcError::Plan(format!(
                "nc.change_position.x_mm = {}: must lie above {clear_mm} mm, the stock and nc.clearance_mm",
                change.x_mm
            )));
        }
        Ok(Self { change, clear_mm, z_first: round3(z_first), z_last: round3(z_last), nose_mm, full_from_mm })
    }
}

pub(super) fn round3(value: f64) -> f64 {
    (value * 1e3).round() / 1e3
}

/// A change position above all stated and assumed solids, beyond the end face.
fn assumed_change(piece: &Workpiece, settings: &NcSettings, clear_mm: f64) -> ChangePosition {
    let quill = match settings.tailstock {
        Some(Tailstock::Absent) => 0.0,
        Some(Tailstock::Centre(c)) => c.quill_mm.max(c.body_mm),
        None => QUILL_MM.max(piece.largest_mm()),
    };
    let chuck = settings.chuck.map_or(0.0, |c| c.jaws_diameter_mm.unwrap_or(0.0).max(c.diameter_mm));
    let around = settings.steady_rests.iter().flatten().chain(settings.gauge_head.as_ref());
    let widest = around.map(|o| o.diameter_mm).fold(quill.max(chuck).max(clear_mm), f64::max);
    ChangePosition {
        x_mm: (widest + ROOM_AT_CHANGE_MM).ceil(),
        z_mm: (piece.length_mm + 2.0 * ROOM_AT_CHANGE_MM).ceil(),
    }
}
