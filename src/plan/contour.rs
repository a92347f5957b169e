//! The contour that every pass of a stepped shaft leaves: cylinders, tapers and shoulders, and the
//! cylinders of it that are measured, corrected and judged, its sections.
//!
//! Diameters are relative to the largest one: a pass of nominal diameter r leaves r + c(z), c ≤ 0
//! up to the sections' aims, so that the allowance of a pass is the same all along the part. At a
//! shoulder everything has two values, one on each side.

use std::ops::Range;

use super::feed_direction::FeedDirection;
use crate::numerics::neighbours::{linear_between, neighbours};

/// The side from which a place is approached; the two differ at a shoulder alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// From the chuck.
    Chuck,
    /// From the tailstock.
    Tailstock,
}

/// A point of the contour; linear between points, level beyond the ends, two points at one z are a
/// shoulder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ContourKnot {
    /// Machine z, mm.
    pub z_mm: f64,
    /// Nominal diameter less that of the pass, mm of diameter.
    pub relative_mm: f64,
}

/// A cylinder of the contour.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Section {
    /// Its name in reports.
    pub name: String,
    /// Its corners along z, chamfers and fillets included, mm.
    pub ends_mm: (f64, f64),
    /// Between these z stations may lie: clear of chamfers, fillets and the blurred shoulders, mm.
    pub clear_mm: (f64, f64),
    /// Its diameter on the drawing, mm.
    pub drawn_mm: f64,
    /// Diameter that the last pass aims at, less the drawn one, mm.
    pub aim_mm: f64,
    /// Its diameter less the nominal one of the pass, mm.
    pub relative_mm: f64,
    /// Lower and upper limit of size, mm; none where it has no tolerance.
    pub limits_mm: Option<(f64, f64)>,
}

/// A taper of the contour: it has values of its own and judges nothing.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Taper {
    /// Its name in reports.
    pub name: String,
    /// Its corners along z, mm.
    pub ends_mm: (f64, f64),
    /// Between these z its diameters are evaluated, mm.
    pub clear_mm: (f64, f64),
    /// Its diameters there on the drawing, mm.
    pub drawn_mm: (f64, f64),
}

/// A piece of a contour with one diameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Piece {
    /// Its ends, mm.
    pub from_mm: f64,
    pub to_mm: f64,
    /// Its diameter less that of the largest section, mm.
    pub relative_mm: f64,
}

/// Pieces in which a taper is taken as cylinders: by the midpoint rule 1/d⁴ errs by 20/24 of the
/// square of a piece's relative change, a thousandth where the taper changes by a third.
const TAPER_PIECES: usize = 8;

/// A contour to be turned.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Contour {
    /// Points along z, ascending.
    pub knots: Vec<ContourKnot>,
    /// Sections along z, ascending, without overlap.
    pub sections: Vec<Section>,
    /// Tapers along z.
    pub tapers: Vec<Taper>,
    /// The way the tool travels along it.
    pub direction: FeedDirection,
}

impl Contour {
    /// Nominal diameter at z less that of the pass, mm of diameter.
    pub(crate) fn relative_mm(&self, z_mm: f64, side: Side) -> f64 {
        value_at(&self.knots, z_mm, side, |k| (k.z_mm, k.relative_mm))
    }

    /// Pieces of one diameter, for a beam.
    pub(crate) fn pieces(&self) -> Vec<Piece> {
        let of = |pair: &[ContourKnot]| {
            let (a, b) = (pair[0], pair[1]);
            let level = (a.relative_mm - b.relative_mm).abs() < 1e-9;
            let most = if level { 1 } else { TAPER_PIECES };
            let count = if b.z_mm > a.z_mm { most } else { 0 };
            // the last one ends where the next line begins, to the last digit
            let at = move |i: usize| {
                let share = i as f64 / count as f64;
                if i == count { b.z_mm } else { a.z_mm + (b.z_mm - a.z_mm) * share }
            };
            (0..count).map(move |i| Piece {
                from_mm: at(i),
                to_mm: at(i + 1),
                relative_mm: a.relative_mm
                    + (b.relative_mm - a.relative_mm) * (i as f64 + 0.5) / count as f64,
            })
        };
        self.knots.windows(2).flat_map(of).collect()
    }

    /// The section whose ends a place lies between.
    pub(crate) fn section_at(&self, z_mm: f64) -> Option<&Section> {
        self.sections.iter().find(|s| (s.ends_mm.0..=s.ends_mm.1).contains(&z_mm))
    }

    /// The stations of every section, by their middles (mm, ascending); sections without any are
    /// left out.
    pub(crate) fn stations_of_sections(&self, station_z_mm: &[f64]) -> Vec<Range<usize>> {
        let before = |z: f64| station_z_mm.partition_point(|s| *s < z);
        let of = |s: &Section| before(s.ends_mm.0)..station_z_mm.partition_point(|z| *z <= s.ends_mm.1);
        self.sections.iter().map(of).filter(|range| !range.is_empty()).collect()
    }

    /// Knots of the offsets (z, o): linear between the stations of a section and level to its
    /// ends, which step at a shoulder and are joined linearly over whatever lies between two
    /// sections.
    pub(crate) fn offset_knots(&self, station_z_mm: &[f64], o_mm: &[f64]) -> Vec<(f64, f64)> {
        let mut knots = Vec::new();
        for range in self.stations_of_sections(station_z_mm) {
            let Some(section) = self.section_at(station_z_mm[range.start]) else { continue };
            let own = || station_z_mm[range.clone()].iter().zip(&o_mm[range.clone()]).map(|(z, o)| (*z, *o));
            knots.extend(own().next().map(|first| (section.ends_mm.0, first.1)));
            knots.extend(own());
            knots.extend(own().next_back().map(|last| (section.ends_mm.1, last.1)));
        }
        knots
    }
}

/// Value at z of points along it: linear between, level beyond, at a step the value of the side.
pub(crate) fn value_at<T>(points: &[T], z_mm: f64, side: Side, of: impl Fn(&T) -> (f64, f64)) -> f64 {
    let pair = match side {
        Side::Chuck => neighbours(points, |p| of(p).0 < z_mm),
        Side::Tailstock => neighbours(points, |p| of(p).0 <= z_mm),
    };
    linear_between(pair, z_mm, of).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn section(from: f64, to: f64, drawn_mm: f64) -> Section {
        Section {
            name: format!("Ø{drawn_mm}"),
            ends_mm: (from, to),
            clear_mm: (from + 0.5, to - 0.5),
            drawn_mm,
            aim_mm: 0.0,
            relative_mm: drawn_mm - 30.0,
            limits_mm: None,
        }
    }

    /// Ø30 to 40, a shoulder, Ø20 to 60, a taper to Ø18 at 80, Ø18 to 100.
    fn contour() -> Contour {
        let knot = |(z_mm, d): (f64, f64)| ContourKnot { z_mm, relative_mm: d - 30.0 };
        let points = [(0.0, 30.0), (40.0, 30.0), (40.0, 20.0), (60.0, 20.0), (80.0, 18.0), (100.0, 18.0)];
        Contour {
            knots: points.map(knot).to_vec(),
            sections: vec![section(0.0, 40.0, 30.0), section(40.0, 60.0, 20.0), section(80.0, 100.0, 18.0)],
            tapers: Vec::new(),
            direction: FeedDirection::TowardsChuck,
        }
    }

    #[test]
    fn a_shoulder_has_two_diameters_and_a_taper_its_line() {
        let c = contour();
        assert_eq!([Side::Chuck, Side::Tailstock].map(|s| c.relative_mm(40.0, s)), [0.0, -10.0]);
        assert_eq!(c.relative_mm(70.0, Side::Chuck), -11.0);
        assert_eq!([-1.0, 101.0].map(|z| c.relative_mm(z, Side::Chuck)), [0.0, -12.0]);
    }

    #[test]
    fn offsets_step_at_a_shoulder_and_run_along_a_taper() {
        let (z, o) = ([10.0, 30.0, 45.0, 55.0, 90.0], [1.0, 2.0, 5.0, 6.0, 8.0]);
        assert_eq!(contour().stations_of_sections(&z), [0..2, 2..4, 4..5]);
        let knots = contour().offset_knots(&z, &o);
        let at = |z: f64, side| value_at(&knots, z, side, |k| *k);
        let sides = |z: f64| [at(z, Side::Chuck), at(z, Side::Tailstock)];
        assert_eq!(sides(0.0), [1.0, 1.0]);
        assert_eq!(sides(20.0), [1.5, 1.5]);
        assert_eq!(sides(40.0), [2.0, 5.0]);
        assert_eq!(sides(70.0), [7.0, 7.0]);
        assert_eq!(sides(100.0), [8.0, 8.0]);
    }
}
