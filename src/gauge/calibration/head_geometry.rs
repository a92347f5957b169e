//! Where the axis of a part stands before a head that rides on a machine, over z.
//!
//! A head that its machine displaces by u_y towards the camera sees the part farther away by u_y:
//! an entocentric lens at the distance ℓ then reads D·u_y/ℓ less. With û_y known, the axis stands
//! at y = −û_y from the plane of the masters, and the reading is corrected as for any stated
//! `axis_y_mm`, by the calibrated telecentricity t = −1/ℓ: D·(1 + t·y) = D·(1 + û_y/ℓ). The
//! uncertainty of û_y, common to all readings at a place, is the budget row "machine geometry". A
//! displacement û_z along the spindle moves the place of the reading, z + û_z.
//!
//! The limits of `limit_axis_y_mm` stay beside it: the errors of a machine have no offset by
//! convention (ISO 230-1), and where the masters stood to the axis of rotation is not among them.

use crate::gauge::limit::limits;
use crate::setting::{SettingError, require, within};

limits! {
    /// What a machine may do to a head.
    HeadGeometryLimits = "head_geometry";
    /// Farthest that a machine displaces a head, mm: lathes err by tens of µm; a number beyond is
    /// in another unit.
    farthest_mm: f64 = 1.0;
}

/// Where the part's axis stands before the head in one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeadPlace {
    /// Place of the middle of the field, mm.
    pub z_mm: f64,
    /// The axis nearer to the camera than the plane of the masters by what the machine does to the
    /// head, −û_y, mm.
    pub axis_y_mm: f64,
    /// Standard uncertainty of that, mm.
    pub u_axis_y_mm: f64,
    /// What the field is displaced by along the spindle, û_z, mm.
    pub axial_mm: f64,
}

/// The places of a machine's head over z: ascending, linear between.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeadGeometry {
    places: Vec<HeadPlace>,
}

impl HeadGeometry {
    /// Places in the order of z.
    ///
    /// # Errors
    /// Fewer than two places, places that do not ascend, displacements that no machine has.
    pub fn new(places: Vec<HeadPlace>) -> Result<Self, SettingError> {
        let farthest = HeadGeometryLimits::get().farthest_mm;
        let count = places.len();
        require(count >= 2, "head_geometry", format!("{count} places"), "at least 2 places along z")?;
        for place in &places {
            let right = "within ±1 mm: is the number in µm?";
            for value in [place.axis_y_mm, place.axial_mm] {
                within("head_geometry", value, -farthest, farthest, right)?;
            }
            within("head_geometry", place.u_axis_y_mm, 0.0, farthest, "between 0 and 1 mm")?;
        }
        let falls = places
            .windows(2)
            .find(|pair| pair[1].z_mm.partial_cmp(&pair[0].z_mm) != Some(std::cmp::Ordering::Greater));
        match falls {
            Some(pair) => Err(SettingError::of(
                "head_geometry",
                pair[1].z_mm,
                format!("above {} mm: places ascend", pair[0].z_mm),
            )),
            None => Ok(Self { places }),
        }
    }

    /// The places.
    pub fn places(&self) -> &[HeadPlace] {
        &self.places
    }

    /// From where to where places are known, mm.
    pub fn range_mm(&self) -> (f64, f64) {
        let z = |place: Option<&HeadPlace>| place.map_or(f64::NAN, |place| place.z_mm);
        (z(self.places.first()), z(self.places.last()))
    }

    /// The place of a field; none outside the range, where nothing is known.
    pub fn at(&self, z_mm: f64) -> Option<HeadPlace> {
        let (from, to) = self.range_mm();
        if !(from..=to).contains(&z_mm) {
            return None;
        }
        let after = self.places.partition_point(|place| place.z_mm <= z_mm).clamp(1, self.places.len() - 1);
        let (a, b) = (self.places[after - 1], self.places[after]);
        let share = (z_mm - a.z_mm) / (b.z_mm - a.z_mm);
        let between = |from: f64, to: f64| from + share * (to - from);
        Some(HeadPlace {
            z_mm,
            axis_y_mm: between(a.axis_y_mm, b.axis_y_mm),
            // of a value between two that share their errors, as of those read on one slide
            u_axis_y_mm: between(a.u_axis_y_mm, b.u_axis_y_mm),
            axial_mm: between(a.axial_mm, b.axial_mm),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(z_mm: f64, axis_y_mm: f64) -> HeadPlace {
        HeadPlace { z_mm, axis_y_mm, u_axis_y_mm: 1e-4, axial_mm: 0.5 * axis_y_mm }
    }

    #[test]
    fn places_are_linear_between_and_none_beyond() {
        let geometry =
            HeadGeometry::new(vec![place(0.0, 0.0), place(10.0, 4e-3), place(40.0, 1e-3)]).unwrap();
        assert_eq!(geometry.range_mm(), (0.0, 40.0));
        let found = geometry.at(20.0).unwrap();
        assert!((found.axis_y_mm - 3e-3).abs() < 1e-15 && (found.axial_mm - 1.5e-3).abs() < 1e-15);
        assert!((geometry.at(40.0).unwrap().axis_y_mm - 1e-3).abs() < 1e-15);
        assert_eq!((geometry.at(-0.1), geometry.at(40.1), geometry.at(f64::NAN)), (None, None, None));
    }

    #[test]
    fn places_that_cannot_be_right_are_refused() {
        let refused = |places: Vec<HeadPlace>| HeadGeometry::new(places).unwrap_err().to_string();
        assert!(refused(vec![place(0.0, 0.0)]).contains("at least 2"));
        assert!(refused(vec![place(0.0, 0.0), place(0.0, 0.0)]).contains("ascend"));
        assert!(refused(vec![place(0.0, 0.0), place(1.0, 3.0)]).contains("µm"));
    }
}
