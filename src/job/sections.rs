//! The contour of a part that is turned: its cylinders become sections with stations, a tolerance
//! and an aim each, its tapers keep values of their own, everything else is excluded with a reason.
//!
//! `[shaft] contour` is the drawing, `[[part.sections]]` what the drawing states of a section.

use super::part::Part;
use super::part_section::PartSection;
use crate::conformity::{SizeCriterion, Tolerance};
use crate::plan::{Contour, ContourKnot, FeedDirection, Section, Taper};
use crate::setting::{SettingError, positive, require};
use crate::shaft::{ContourPoint, contour};

/// Largest sagitta of a chord of a fillet, mm: a tenth of a micrometre, below every tolerance.
const SAGITTA_MM: f64 = 1e-4;
/// Lengths and diameters that agree to this are the same, mm: rounding of decimals.
const SAME_MM: f64 = 1e-6;
/// Columns beside a shoulder that show its blur, pixels: six standard deviations of the usual
/// blur of 1.5 px on the edge of a column, the ten columns over which a column is compared with
/// its neighbours, and one for the magnification.
const EDGE_PX: f64 = 20.0;
/// Steepest line that a tool can follow down along its feed, degrees: a 55° insert at an approach
/// angle of 93° has 180° − 93° − 55° = 32° behind its nose, of which 5° are clearance.
const MOST_FALL_DEG: f64 = 27.0;

/// A line of the drawing between two of its points.
#[derive(Clone, Copy, Debug)]
struct Piece {
    /// Indices of its first and last point.
    first: usize,
    last: usize,
    from_mm: f64,
    to_mm: f64,
    /// Diameters at both ends, mm.
    diameter_mm: (f64, f64),
}

impl Piece {
    fn is_cylinder(&self) -> bool {
        (self.diameter_mm.0 - self.diameter_mm.1).abs() <= SAME_MM
    }

    fn holds(&self, z_mm: f64) -> bool {
        z_mm > self.from_mm + SAME_MM && z_mm < self.to_mm - SAME_MM
    }

    fn name(&self) -> String {
        let (a, b) = self.diameter_mm;
        let d = if self.is_cylinder() { format!("Ø{a}") } else { format!("taper Ø{a} to Ø{b}") };
        format!("{d}, {} to {} mm", self.from_mm, self.to_mm)
    }
}

/// The drawing's lines along z; neighbouring cylinders of one diameter are one.
fn pieces(points: &[ContourPoint]) -> Vec<Piece> {
    let mut found: Vec<Piece> = Vec::new();
    for (i, pair) in points.windows(2).enumerate() {
        let (a, b) = (pair[0], pair[1]);
        if b.z_mm - a.z_mm <= SAME_MM {
            continue;
        }
        let next = Piece {
            first: i,
            last: i + 1,
            from_mm: a.z_mm,
            to_mm: b.z_mm,
            diameter_mm: (a.diameter_mm, b.diameter_mm),
        };
        let joined = |p: &Piece| p.last == i && p.is_cylinder() && next.is_cylinder();
        match found.last_mut().filter(|p| joined(p)) {
            Some(p) => (p.last, p.to_mm) = (i + 1, b.z_mm),
            None => found.push(next),
        }
    }
    found
}

/// What a contour is made from.
pub(super) struct Drawing<'a> {
    pub points: &'a [ContourPoint],
    pub part: &'a Part,
    pub mm_per_px: f64,
    pub direction: FeedDirection,
}

impl Drawing<'_> {
    /// The contour to be turned.
    ///
    /// # Errors
    /// Names the point of the contour or the entry of `[[part.sections]]`.
    pub(super) fn contour(&self) -> Result<Contour, SettingError> {
        let profile = contour::profile(self.points, SAGITTA_MM)?;
        self.check_ends()?;
        let pieces = pieces(self.points);
        self.check_feed(&pieces)?;
        let entries = self.entries(&pieces)?;
        let largest = self.points.iter().map(|p| p.diameter_mm).fold(0.0, f64::max);
        self.check_nominal(largest)?;
        let cuts = contour::cut_lengths_mm(self.points);
        let mut made = Contour { direction: self.direction, ..Contour::default() };
        for (piece, entry) in pieces.iter().zip(&entries) {
            let clear_mm = self.clear(piece, &cuts);
            let name = entry.and_then(|e| e.name.clone()).unwrap_or_else(|| piece.name());
            if !piece.is_cylinder() {
                let at = |z: f64| line(piece, z);
                let drawn_mm = (at(clear_mm.0), at(clear_mm.1));
                made.tapers.push(Taper { name, ends_mm: (piece.from_mm, piece.to_mm), clear_mm, drawn_mm });
                continue;
            }
            if entry.is_some_and(|e| !e.measured) {
                continue;
            }
            self.check_length(piece, clear_mm)?;
            let aim_mm = entry.map_or(0.0, |e| aim(e, piece.diameter_mm.0));
            made.sections.push(Section {
                name,
                ends_mm: (piece.from_mm, piece.to_mm),
                clear_mm,
                drawn_mm: piece.diameter_mm.0,
                aim_mm,
                relative_mm: piece.diameter_mm.0 + aim_mm - largest,
                limits_mm: entry.and_then(|e| e.tolerance).map(|t| t.limits_mm()),
            });
        }
        if made.sections.is_empty() {
            let why = "has no cylinder: only cylinders are measured and corrected";
            return Err(SettingError::at("shaft.contour", why));
        }
        let knot = |k: &crate::shaft::ProfileKnot| 2.0 * k.radius_mm - largest;
        made.knots = profile.iter().map(|k| ContourKnot { z_mm: k.z_mm, relative_mm: knot(k) }).collect();
        raise_by_aims(&mut made);
        Ok(made)
    }

    /// The contour runs over the whole part.
    fn check_ends(&self) -> Result<(), SettingError> {
        let (first, last) = (self.points.first(), self.points.last());
        let (from, to) = (first.map_or(f64::NAN, |p| p.z_mm), last.map_or(f64::NAN, |p| p.z_mm));
        let length = self.part.length_mm;
        if from.abs() <= SAME_MM && (to - length).abs() <= SAME_MM {
            return Ok(());
        }
        let why = format!(
            "runs from {from} to {to} mm: a run turns the whole part, from 0 to part.length_mm = {length} mm"
        );
        Err(SettingError::at("shaft.contour", why))
    }

    /// The passes are those of the largest diameter.
    fn check_nominal(&self, largest_mm: f64) -> Result<(), SettingError> {
        let last = self.part.nominal_diameter_mm.last().copied().unwrap_or(f64::NAN);
        if (last - largest_mm).abs() <= SAME_MM {
            return Ok(());
        }
        let key = format!("part.nominal_diameter_mm[{}]", self.part.passes().saturating_sub(1));
        let why = format!(
            "{last} mm: the passes of a contour are those of its largest diameter, the last one leaves {largest_mm} mm; \
             everything else has the same allowance"
        );
        Err(SettingError::at(key, why))
    }

    /// A tool reaches every line of the contour along its feed.
    fn check_feed(&self, pieces: &[Piece]) -> Result<(), SettingError> {
        let sign = match self.direction {
            FeedDirection::TowardsChuck => -1.0,
            FeedDirection::TowardsTailstock => 1.0,
        };
        let way = if sign < 0.0 { "chuck" } else { "tailstock" };
        for (i, pair) in self.points.windows(2).enumerate() {
            let rise = sign * 0.5 * (pair[1].diameter_mm - pair[0].diameter_mm);
            let fall_deg = (-rise).atan2(pair[1].z_mm - pair[0].z_mm).to_degrees();
            if fall_deg <= MOST_FALL_DEG {
                continue;
            }
            let (a, b) = (pair[0].diameter_mm, pair[1].diameter_mm);
            let key = format!("shaft.contour[{}]", i + 1);
            if pieces.iter().any(|p| p.first <= i && i < p.last) {
                let why = format!(
                    "falls by {fall_deg:.1}° along the feed (towards the {way}): the tool's flank follows {MOST_FALL_DEG}° \
                     at most"
                );
                return Err(SettingError::at(key, why));
            }
            let why = format!(
                "the shoulder from Ø{a} to Ø{b} at z = {} mm falls along the feed (towards the {way}): a turning tool \
                 cannot reach behind it; turn the part round, or set process.pass.feed_direction",
                pair[1].z_mm
            );
            return Err(SettingError::at(key, why));
        }
        Ok(())
    }

    /// The entry of every piece.
    fn entries(&self, pieces: &[Piece]) -> Result<Vec<Option<&PartSection>>, SettingError> {
        let mut entries: Vec<Option<&PartSection>> = vec![None; pieces.len()];
        for (i, entry) in self.part.sections.iter().enumerate() {
            let key = |name: &str| format!("part.sections[{i}].{name}");
            let z = entry.z_mm;
            let Some(at) = pieces.iter().position(|p| p.holds(z)) else {
                let why = format!(
                    "{z} mm: no section is there; a place inside one of {}",
                    pieces.iter().map(Piece::name).collect::<Vec<_>>().join("; ")
                );
                return Err(SettingError::at(key("z_mm"), why));
            };
            if let Some(other) = entries[at] {
                let why = format!(
                    "{z} mm lies on the section of {} mm ({}): one entry each",
                    other.z_mm,
                    pieces[at].name()
                );
                return Err(SettingError::at(key("z_mm"), why));
            }
            check_entry(entry, &pieces[at], &key)?;
            entries[at] = Some(entry);
        }
        Ok(entries)
    }

    /// Where stations may lie, mm: beyond chamfers, fillets, and the blur of a shoulder or of the
    /// end of a taper. The ends of the part have none.
    fn clear(&self, piece: &Piece, cuts: &[f64]) -> (f64, f64) {
        let last = self.points.len() - 1;
        let edge = |point: usize| if point == 0 || point == last { 0.0 } else { EDGE_PX * self.mm_per_px };
        (
            piece.from_mm + cuts[piece.first] + edge(piece.first),
            piece.to_mm - cuts[piece.last] - edge(piece.last),
        )
    }

    fn check_length(&self, piece: &Piece, (from, to): (f64, f64)) -> Result<(), SettingError> {
        let station = self.part.station_mm;
        if to - from >= station - SAME_MM {
            return Ok(());
        }
        let why = format!(
            "{station} mm: a station is longer than the section {} ({:.3} mm of it are clear of chamfers, fillets and \
             blurred shoulders): a shorter station, or an entry of [[part.sections]] with z_mm = {} and measured = false",
            piece.name(),
            (to - from).max(0.0),
            0.5 * (piece.from_mm + piece.to_mm)
        );
        Err(SettingError::at("part.station_mm", why))
    }
}

fn line(piece: &Piece, z_mm: f64) -> f64 {
    let (a, b) = piece.diameter_mm;
    a + (b - a) * (z_mm - piece.from_mm) / (piece.to_mm - piece.from_mm)
}

/// Where a section aims: its own aim, otherwise the middle of its tolerance.
fn aim(entry: &PartSection, drawn_mm: f64) -> f64 {
    let middle = |t: Tolerance| 0.5 * (t.limits_mm().0 + t.limits_mm().1) - drawn_mm;
    entry.aim_mm.or_else(|| entry.tolerance.map(middle)).unwrap_or(0.0)
}

fn check_entry(entry: &PartSection, piece: &Piece, key: &dyn Fn(&str) -> String) -> Result<(), SettingError> {
    let finite = |name: &str, v: f64| require(v.is_finite(), &key(name), v, "a length in mm");
    entry.aim_mm.map_or(Ok(()), |aim| finite("aim_mm", aim))?;
    let Some(tolerance) = entry.tolerance else { return Ok(()) };
    let refuse = |why: String| Err(SettingError::at(key("tolerance"), why));
    if !piece.is_cylinder() {
        return refuse(format!(
            "the section at {} mm is a {}: its values are reported, a tolerance of size is one of a cylinder",
            entry.z_mm,
            piece.name()
        ));
    }
    if !entry.measured {
        return refuse("stands beside measured = false: nothing would be judged".to_owned());
    }
    if tolerance.criterion != SizeCriterion::TwoPoint {
        return refuse(format!(
            "{} is judged by measure --turn: a run judges the stations' mean two-point sizes",
            tolerance.criterion.as_str()
        ));
    }
    let (lower, upper) = tolerance.limits_mm();
    if !(lower < upper) {
        return refuse(format!("the lower limit, {lower} mm, must lie below the upper one, {upper} mm"));
    }
    if (tolerance.nominal_mm - piece.diameter_mm.0).abs() > SAME_MM {
        return refuse(format!(
            "is one of {} mm, and the contour has Ø{} there: the nominal size of both must agree",
            tolerance.nominal_mm, piece.diameter_mm.0
        ));
    }
    let aimed = piece.diameter_mm.0 + aim(entry, piece.diameter_mm.0);
    if (lower..=upper).contains(&aimed) {
        return Ok(());
    }
    refuse(format!(
        "the last pass aims at {aimed:.4} mm (the contour's Ø{} and aim_mm), outside {lower:.4} to {upper:.4} mm",
        piece.diameter_mm.0
    ))
}

/// A contour whose surface is another one than the drawn one, given by knots (z, radius) in mm of
/// the drawing without its aims. Beside a shoulder that is moved the aims step where the drawn one
/// stands, some micrometres away.
#[cfg(feature = "render")]
pub(super) fn with_surface(drawn: &Contour, points: &[ContourPoint], knots: &[(f64, f64)]) -> Contour {
    let largest = points.iter().map(|p| p.diameter_mm).fold(0.0, f64::max);
    let knot = |&(z_mm, radius): &(f64, f64)| ContourKnot { z_mm, relative_mm: 2.0 * radius - largest };
    let mut made = Contour { knots: knots.iter().map(knot).collect(), ..drawn.clone() };
    raise_by_aims(&mut made);
    made
}

/// Raises the contour by the aims: constant over a section, linear from one to the next.
fn raise_by_aims(contour: &mut Contour) {
    let mut aims = Vec::new();
    for s in &contour.sections {
        aims.extend([(s.ends_mm.0, s.aim_mm), (s.ends_mm.1, s.aim_mm)]);
    }
    // Of two points at a shoulder the first belongs to the side of the chuck.
    let mut before = f64::NEG_INFINITY;
    for knot in &mut contour.knots {
        let side = if knot.z_mm == before { crate::plan::Side::Tailstock } else { crate::plan::Side::Chuck };
        before = knot.z_mm;
        knot.relative_mm += crate::plan::value_at(&aims, knot.z_mm, side, |a| *a);
    }
}

/// Middles of the stations of all sections, mm, ascending: side by side, in the middle of what is
/// clear of a section.
pub(super) fn station_z_mm(contour: &Contour, station_mm: f64) -> Vec<f64> {
    let of = |s: &Section| {
        let (from, to) = s.clear_mm;
        let count = ((to - from) / station_mm + 1e-9).floor() as usize;
        let first = 0.5 * (from + to) - 0.5 * station_mm * count as f64;
        (0..count).map(move |i| first + (i as f64 + 0.5) * station_mm)
    };
    contour.sections.iter().flat_map(of).collect()
}

/// Listed stations lie inside what is clear of a section.
pub(super) fn check_listed(contour: &Contour, listed: &[f64], station_mm: f64) -> Result<(), SettingError> {
    let half = 0.5 * station_mm - SAME_MM;
    let inside =
        |z: f64| contour.sections.iter().any(|s| z - half >= s.clear_mm.0 && z + half <= s.clear_mm.1);
    let Some(i) = listed.iter().position(|z| !inside(*z)) else { return Ok(()) };
    let clear = |s: &Section| format!("{:.3} to {:.3} mm ({})", s.clear_mm.0, s.clear_mm.1, s.name);
    let why = format!(
        "{} mm: a station of {station_mm} mm would span a shoulder or a taper, or lie in the blur beside one; stations lie inside {}",
        listed[i],
        contour.sections.iter().map(clear).collect::<Vec<_>>().join(", ")
    );
    Err(SettingError::at(format!("part.station_z_mm[{i}]"), why))
}

/// A steady rest stands on a cylinder, clear of its ends.
pub(super) fn check_steady(
    contour: &Contour,
    points: &[ContourPoint],
    z_mm: &[f64],
) -> Result<(), SettingError> {
    for (i, z) in z_mm.iter().enumerate() {
        let key = format!("process.support.steady_rests[{i}].z_mm");
        positive(&key, *z)?;
        let on = pieces(points).into_iter().find(|p| p.holds(*z));
        match on {
            Some(p) if p.is_cylinder() => {}
            Some(p) => {
                let why = format!("{z} mm lies on the {}: a steady rest needs a cylinder", p.name());
                return Err(SettingError::at(key, why));
            }
            None => {
                let cylinders =
                    contour.sections.iter().map(|s| s.name.clone()).collect::<Vec<_>>().join("; ");
                let why =
                    format!("{z} mm lies on a shoulder: a steady rest needs a cylinder, one of {cylinders}");
                return Err(SettingError::at(key, why));
            }
        }
    }
    Ok(())
}
