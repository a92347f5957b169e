//! The finished solid of a stepped shaft: no feed may cut into it, and feeds reach all of it.
//!
//! The nose is a disc that travels with the programmed point; its distance from the commanded
//! surface is that of its centre less its radius.

use super::event::Point;

/// A sharper inner corner than this keeps the nose out of it, as the cosine of the turn: 30°.
const SHARP_COS: f64 = 0.866;
/// Distance of the places at which coverage is tested, mm.
const PLACES_MM: f64 = 0.5;

/// (Z, radius), mm.
type Place = (f64, f64);

/// The commanded surface and the nose that cuts it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FinishedSolid {
    /// (Z, radius), Z ascending; two points at one Z are a shoulder.
    pub surface: Vec<Place>,
    /// Nose radius, mm.
    pub nose_mm: f64,
    /// Z of the nose's centre less that of the programmed point, mm.
    pub centre_z_mm: f64,
}

impl FinishedSolid {
    fn centre(&self, p: Point) -> Place {
        (p.z + self.centre_z_mm, 0.5 * p.x + self.nose_mm)
    }

    /// Refuses a move whose nose comes closer to the axis than the surface by more than
    /// `tolerance_mm` of radius.
    ///
    /// # Errors
    /// Names the place and the depth.
    pub(super) fn not_too_deep(&self, from: Point, to: Point, tolerance_mm: f64) -> Result<(), String> {
        let (a, b) = (self.centre(from), self.centre(to));
        for line in self.surface.windows(2) {
            let depth = self.nose_mm - between_lines((a, b), (line[0], line[1]));
            if depth > tolerance_mm {
                return Err(format!(
                    "near Z {:.3} the nose cuts {depth:.4} mm into the commanded surface",
                    line[0].0
                ));
            }
        }
        Ok(())
    }

    /// Refuses feeds that leave more than `tolerance_mm` of radius on the surface between two Z;
    /// what the nose leaves in a sharp inner corner is the drawing's.
    ///
    /// # Errors
    /// Names the place and what is left.
    pub(super) fn covered(
        &self,
        feeds: &[(Point, Point)],
        between: (f64, f64),
        tolerance_mm: f64,
    ) -> Result<(), String> {
        let ways: Vec<(Place, Place)> = feeds.iter().map(|f| (self.centre(f.0), self.centre(f.1))).collect();
        let corners = self.sharp_corners();
        for place in self.places() {
            let in_corner = corners.iter().any(|c| length(*c, place) < self.nose_mm + PLACES_MM);
            if place.0 < between.0 || place.0 > between.1 || in_corner {
                continue;
            }
            let nearest = ways.iter().map(|w| to_line(place, *w)).fold(f64::INFINITY, f64::min);
            if nearest - self.nose_mm > tolerance_mm {
                return Err(format!(
                    "at Z {:.3} X {:.3} the cut leaves {:.4} mm on the commanded surface",
                    place.0,
                    2.0 * place.1,
                    nearest - self.nose_mm
                ));
            }
        }
        Ok(())
    }

    fn places(&self) -> Vec<Place> {
        let of = |w: &[Place]| {
            let count = (length(w[0], w[1]) / PLACES_MM).ceil().max(1.0) as usize;
            let (a, b) = (w[0], w[1]);
            (0..=count).map(move |i| {
                let t = i as f64 / count as f64;
                (a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1))
            })
        };
        self.surface.windows(2).flat_map(of).collect()
    }

    /// Inner corners without a fillet.
    fn sharp_corners(&self) -> Vec<Place> {
        let sharp = |w: &&[Place]| {
            let (p, q) = ((w[1].0 - w[0].0, w[1].1 - w[0].1), (w[2].0 - w[1].0, w[2].1 - w[1].1));
            let inner = p.0 * q.1 - p.1 * q.0 > 0.0;
            let cos = (p.0 * q.0 + p.1 * q.1) / (p.0.hypot(p.1) * q.0.hypot(q.1));
            inner && cos < SHARP_COS
        };
        self.surface.windows(3).filter(sharp).map(|w| w[1]).collect()
    }
}

fn length(a: Place, b: Place) -> f64 {
    (a.0 - b.0).hypot(a.1 - b.1)
}

/// Distance of a point from a line between two.
fn to_line(p: Place, (a, b): (Place, Place)) -> f64 {
    let (dz, dr) = (b.0 - a.0, b.1 - a.1);
    let square = dz * dz + dr * dr;
    let t = if square > 0.0 { ((p.0 - a.0) * dz + (p.1 - a.1) * dr) / square } else { 0.0 };
    let t = t.clamp(0.0, 1.0);
    length(p, (a.0 + t * dz, a.1 + t * dr))
}

/// Distance of two lines between points: 0 where they cross, otherwise that of an end.
fn between_lines(w: (Place, Place), v: (Place, Place)) -> f64 {
    let side =
        |l: (Place, Place), p: Place| (l.1.0 - l.0.0) * (p.1 - l.0.1) - (l.1.1 - l.0.1) * (p.0 - l.0.0);
    if side(w, v.0) * side(w, v.1) < 0.0 && side(v, w.0) * side(v, w.1) < 0.0 {
        return 0.0;
    }
    to_line(w.0, v).min(to_line(w.1, v)).min(to_line(v.0, w)).min(to_line(v.1, w))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ø30 to Z 20, a sharp shoulder, Ø20 to Z 60; a nose of 0.8 mm led by its side to the chuck.
    fn solid() -> FinishedSolid {
        let surface = vec![(0.0, 15.0), (20.0, 15.0), (20.0, 10.0), (60.0, 10.0)];
        FinishedSolid { surface, nose_mm: 0.8, centre_z_mm: 0.8 }
    }

    fn feeds(path: &[(f64, f64)]) -> Vec<(Point, Point)> {
        path.windows(2).map(|w| (Point { x: w[0].1, z: w[0].0 }, Point { x: w[1].1, z: w[1].0 })).collect()
    }

    #[test]
    fn a_cut_along_the_contour_is_neither_too_deep_nor_short() {
        let cut = feeds(&[(61.0, 20.0), (20.0, 20.0), (20.0, 30.0), (-1.0, 30.0)]);
        let s = solid();
        assert!(cut.iter().all(|f| s.not_too_deep(f.0, f.1, 1e-6).is_ok()));
        assert_eq!(s.covered(&cut, (0.0, 60.0), 1e-6), Ok(()));
    }

    #[test]
    fn a_gouge_and_what_is_left_are_found() {
        let s = solid();
        let into_the_wall = feeds(&[(61.0, 20.0), (19.9, 20.0)]);
        assert!(s.not_too_deep(into_the_wall[0].0, into_the_wall[0].1, 0.01).is_err());
        let below = feeds(&[(61.0, 19.9), (30.0, 19.9)]);
        assert!(s.not_too_deep(below[0].0, below[0].1, 0.01).unwrap_err().contains("0.05"));
        let short = feeds(&[(61.0, 20.0), (25.0, 20.0), (20.0, 30.0), (-1.0, 30.0)]);
        assert!(s.covered(&short, (0.0, 60.0), 0.01).is_err());
    }
}
