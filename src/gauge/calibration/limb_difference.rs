//! How far the limbs of a part stand from where the masters' calibration places them: diameter,
//! material, film, texture, depth, and what a contact instrument certified.
//!
//! The image of a round, opaque limb lies δ(D, surface, focus) outside it (0.5 to 1.8 µm at NA
//! 0.02), by diffraction along the limb. Masters take off the line through their own δ, so that a
//! part reads too large by
//!
//! ```text
//! ΔD = 2·[δ_D(D) + δ_material + δ_film + δ_texture + δ'·y + δ″·y² + δ_peaks]
//! δ_D(D) = c₀ + c₁x + c₂x² + c₃x³,   x = (D/mm)^⅓
//! ```
//!
//! all in µm an edge, outwards, the masters' line taken off. δ goes by (λ²R)^⅓ at small apertures
//! (Rubinow and Wu, J. Appl. Phys. 27 (1956) 1032), hence the polynomial in the cube root; the line
//! in D is its cubic term. What each is not known to is a rectangular distribution of its own row
//! in the budget. `shadowgauge optics limb` computes the table for a head, its masters and a part.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::unstated::UnstatedLimits;
use crate::gauge::limit::limits;
use crate::setting::{SettingError, within};

limits! {
    /// What the parts of a limb's difference are known to.
    LimbLimits = "limb";
    /// Share of the correction by diameter that may be wrong: a ratio of apertures that is off by
    /// 0.1 moves it by 10 %, a numerical aperture off by 10 % by 15 %, together 18 %.
    by_diameter: f64 = 0.2;
    /// Limits of a material like the masters', ± µm an edge: iron and chromium lie 0.008 and 0.011
    /// µm beside steel at Ø18.
    like_masters_um: f64 = 0.015;
    /// Share of the difference of two materials that are named: their published indices differ by
    /// as much from author to author.
    named_material: f64 = 0.2;
    /// Limits of a material that is not stated, ± µm an edge: aluminium lies 0.09 µm outside steel,
    /// ceramics and opaque glass 0.12 µm inside, and no residual shows which it is.
    unknown_material_um: f64 = 0.11;
}

/// What is known of the part's material.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum KnownMaterial {
    /// Nothing.
    #[default]
    Unknown,
    /// It is the masters'.
    LikeMasters,
    /// It is named, and so is the masters': `by_material_um` is their difference.
    Named,
}

/// Shifts of a part's edges against the masters' line, µm an edge, outwards (a shadow too large).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LimbDifference {
    /// Smallest diameter for which it was computed, mm.
    pub from_mm: f64,
    /// Largest diameter for which it was computed, mm.
    pub to_mm: f64,
    /// By the diameter: coefficients of the powers 0 to 3 of the cube root of D in mm, µm.
    pub by_diameter_um: [f64; 4],
    /// What is known of the part's material.
    #[serde(default)]
    pub material: KnownMaterial,
    /// By the material, µm.
    #[serde(default)]
    pub by_material_um: f64,
    /// By a film on the part, its thickness included, µm.
    #[serde(default)]
    pub by_film_um: f64,
    /// Limits of that, ± µm.
    #[serde(default)]
    pub limit_film_um: f64,
    /// By the roughness around the part, µm.
    #[serde(default)]
    pub by_texture_um: f64,
    /// Limits of that, ± µm.
    #[serde(default)]
    pub limit_texture_um: f64,
    /// By each millimetre that the axis stands nearer to the camera than the masters', µm/mm.
    #[serde(default)]
    pub by_depth_um_per_mm: f64,
    /// By the square of that distance, µm/mm².
    #[serde(default)]
    pub by_depth_um_per_mm2: f64,
    /// By masters that were certified by contact, on their peaks, where a silhouette follows the
    /// mean line: the mean of what it may be, µm.
    #[serde(default)]
    pub by_peaks_um: f64,
    /// Limits of that, ± µm.
    #[serde(default)]
    pub limit_peaks_um: f64,
}

/// Rows of a limb's difference in a budget.
pub(crate) const OF_LIMB: [&str; 6] = [
    "limb: diameter against the masters'",
    "limb: material against the masters'",
    "limb: film on the part",
    "limb: texture around the part",
    "limb: depth of the axis",
    "masters certified on their peaks",
];

/// One row: what was taken off an edge, and its limits, µm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LimbRow {
    /// One of [`OF_LIMB`].
    pub(crate) source: &'static str,
    /// Shift that is taken off an edge, µm.
    pub(crate) shift_um: f64,
    /// Its limits, ± µm an edge.
    pub(crate) limit_um: f64,
}

impl LimbRow {
    /// Standard uncertainty that it gives the diameter, mm: both edges err alike.
    pub(crate) fn u_mm(&self) -> f64 {
        2e-3 * self.limit_um / 3.0_f64.sqrt()
    }
}

impl LimbDifference {
    /// Checks every value.
    ///
    /// # Errors
    /// Names the key.
    pub(crate) fn validate(&self) -> Result<(), SettingError> {
        let at = |key: &str, value, low, high, right| {
            within(&format!("conditions.limb.{key}"), value, low, high, right)
        };
        at("from_mm", self.from_mm, 0.01, 1e4, "a diameter of 0.01 to 10 000 mm")?;
        at("to_mm", self.to_mm, self.from_mm, 1e4, "a diameter from from_mm to 10 000 mm")?;
        for c in self.by_diameter_um {
            at("by_diameter_um", c, -1e3, 1e3, "four coefficients within ± 1000 µm")?;
        }
        for (key, value) in [
            ("by_material_um", self.by_material_um),
            ("by_film_um", self.by_film_um),
            ("by_texture_um", self.by_texture_um),
            ("by_depth_um_per_mm", self.by_depth_um_per_mm),
            ("by_depth_um_per_mm2", self.by_depth_um_per_mm2),
            ("by_peaks_um", self.by_peaks_um),
        ] {
            at(key, value, -100.0, 100.0, "-100 to 100 µm")?;
        }
        for (key, value) in [
            ("limit_film_um", self.limit_film_um),
            ("limit_texture_um", self.limit_texture_um),
            ("limit_peaks_um", self.limit_peaks_um),
        ] {
            at(key, value, 0.0, 100.0, "0 to 100 µm")?;
        }
        Ok(())
    }

    /// Shift by the diameter, µm an edge; beyond the diameters it was computed for, that of the
    /// nearest one.
    pub(crate) fn by_diameter_um(&self, diameter_mm: f64) -> f64 {
        let x = diameter_mm.clamp(self.from_mm, self.to_mm).cbrt();
        let [c0, c1, c2, c3] = self.by_diameter_um;
        c0 + x * (c1 + x * (c2 + x * c3))
    }

    /// Mean shift of depths that are even within `y_mm` ± `limit_mm`, and the limits of the
    /// rectangle that is as wide as its distribution, µm; the lens's own scale moves an edge by
    /// `lens_um_per_mm` with the same distance. With off = ± L even, (a + 2by)·off + b·off² has the
    /// mean bL²/3 and the variance (a + 2by)²L²/3 + 4b²L⁴/45 (JCGM 101, 5.2; GUM 5.1.2, note):
    /// the change towards the farther end would claim a width that depths do not have.
    fn by_depth(&self, y_mm: f64, limit_mm: f64, lens_um_per_mm: f64) -> (f64, f64) {
        let (a, b) = (self.by_depth_um_per_mm, self.by_depth_um_per_mm2);
        let here = y_mm * (a + y_mm * b);
        let slope = a + 2.0 * b * y_mm + lens_um_per_mm;
        let bent = 2.0 * b * limit_mm / 15.0_f64.sqrt();
        (here + b * limit_mm * limit_mm / 3.0, limit_mm * slope.hypot(bent))
    }

    /// The rows for a part of this diameter, its axis `axis_y_mm` ± `limit_y_mm` nearer to the
    /// camera than the masters'. One and the same distance moves the limb and, by the
    /// telecentricity `t_per_mm`, the scale: the row of the depth holds both.
    pub(crate) fn rows(
        &self,
        diameter_mm: f64,
        (axis_y_mm, limit_y_mm): (f64, f64),
        t_per_mm: f64,
    ) -> [LimbRow; 6] {
        let limits = LimbLimits::get();
        let by_diameter = self.by_diameter_um(diameter_mm);
        let computed = (self.from_mm..=self.to_mm).contains(&diameter_mm);
        // A limb that was not computed may stand off by as much as one that is not stated.
        let of_diameter =
            if computed { limits.by_diameter * by_diameter.abs() } else { UnstatedLimits::get().edge_um };
        let (by_material, of_material) = match self.material {
            KnownMaterial::Unknown => (0.0, limits.unknown_material_um),
            KnownMaterial::LikeMasters => (0.0, limits.like_masters_um),
            KnownMaterial::Named => {
                let share = limits.named_material * self.by_material_um.abs();
                (self.by_material_um, share.max(limits.like_masters_um))
            }
        };
        let shifts = [
            (by_diameter, of_diameter),
            (by_material, of_material),
            (self.by_film_um, self.limit_film_um),
            (self.by_texture_um, self.limit_texture_um),
            self.by_depth(axis_y_mm, limit_y_mm, 0.5e3 * diameter_mm * t_per_mm),
            (self.by_peaks_um, self.limit_peaks_um),
        ];
        std::array::from_fn(|k| LimbRow { source: OF_LIMB[k], shift_um: shifts[k].0, limit_um: shifts[k].1 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// c(λ²R)^⅓ of a soft cylinder at 525 nm, C = 0.14628, less nothing: 1.13 µm at Ø18.
    fn soft() -> LimbDifference {
        let per_root_mm = 0.146_28 * (0.525_f64.powi(2) * 500.0).cbrt();
        LimbDifference {
            from_mm: 2.0,
            to_mm: 40.0,
            by_diameter_um: [0.0, per_root_mm, 0.0, 0.0],
            material: KnownMaterial::Unknown,
            by_material_um: 0.09,
            by_film_um: 0.0,
            limit_film_um: 0.0,
            by_texture_um: 0.0,
            limit_texture_um: 0.0,
            by_depth_um_per_mm: 1.8,
            by_depth_um_per_mm2: 0.0,
            by_peaks_um: 0.0,
            limit_peaks_um: 0.0,
        }
    }

    /// Mean and √3 standard deviations of a shift whose depth is even within limits, by quadrature.
    fn of_even_depths(shift: impl Fn(f64) -> f64, (middle, limit): (f64, f64)) -> (f64, f64) {
        let n = 20_000;
        let at = |k: i32| shift(middle + limit * (2.0 * (f64::from(k) + 0.5) / f64::from(n) - 1.0));
        let mean = (0..n).map(at).sum::<f64>() / f64::from(n);
        let variance = (0..n).map(|k| (at(k) - mean).powi(2)).sum::<f64>() / f64::from(n);
        (mean, (3.0 * variance).sqrt())
    }

    #[test]
    fn the_shift_by_diameter_is_the_law_it_was_given() {
        let wanted = 0.146_28 * (0.525_f64.powi(2) * 9000.0).cbrt();
        assert!((soft().by_diameter_um(18.0) - wanted).abs() < 1e-12);
        assert_eq!(soft().by_diameter_um(60.0), soft().by_diameter_um(40.0));
    }

    #[test]
    fn each_row_has_the_limits_of_what_is_known() {
        let rows = soft().rows(18.0, (-0.2, 0.5), 0.0);
        assert!((rows[0].limit_um - 0.2 * rows[0].shift_um).abs() < 1e-12);
        assert_eq!((rows[1].shift_um, rows[1].limit_um), (0.0, 0.11));
        assert!((rows[4].shift_um + 0.36).abs() < 1e-12 && (rows[4].limit_um - 0.9).abs() < 1e-12);
        let bent = LimbDifference { by_depth_um_per_mm2: 1.0, ..soft() }.rows(18.0, (0.1, 0.3), 0.0);
        let (mean, width) = of_even_depths(|y| y * (1.8 + y), (0.1, 0.3));
        assert!((bent[4].shift_um - mean).abs() < 1e-6 && (bent[4].limit_um - width).abs() < 1e-6);
        assert!((bent[4].shift_um - 0.22).abs() < 1e-12);
        let named = LimbDifference { material: KnownMaterial::Named, ..soft() }.rows(18.0, (0.0, 0.0), 0.0);
        assert_eq!((named[1].shift_um, named[1].limit_um), (0.09, 0.018));
        let alike =
            LimbDifference { material: KnownMaterial::LikeMasters, ..soft() }.rows(18.0, (0.0, 0.0), 0.0);
        assert_eq!((alike[1].shift_um, alike[1].limit_um, alike[4].limit_um), (0.0, 0.015, 0.0));
        // Not computed there: as wide as what is not stated.
        assert_eq!(soft().rows(60.0, (0.0, 0.0), 0.0)[0].limit_um, UnstatedLimits::get().edge_um);
    }

    /// The limb grows by 1.8 µm an edge and millimetre, the image by 18 mm · 2e-4 of diameter, that
    /// is 1.8 µm an edge, too: together, not as two independent causes; a lens that shrinks takes
    /// it back.
    #[test]
    fn one_distance_moves_limb_and_scale_together() {
        let depth = |t_per_mm: f64| soft().rows(18.0, (0.1, 0.5), t_per_mm)[4];
        assert!((depth(2e-4).limit_um - 1.8).abs() < 1e-12 && depth(-2e-4).limit_um < 1e-12);
        assert_eq!(depth(2e-4).shift_um, depth(0.0).shift_um);
    }

    #[test]
    fn impossible_values_are_named() {
        let wrong = LimbDifference { to_mm: 1.0, ..soft() };
        assert_eq!(wrong.validate().unwrap_err().key, "conditions.limb.to_mm");
        let wrong = LimbDifference { limit_film_um: -1.0, ..soft() };
        assert_eq!(wrong.validate().unwrap_err().key, "conditions.limb.limit_film_um");
        let wrong = LimbDifference { by_diameter_um: [0.0, f64::NAN, 0.0, 0.0], ..soft() };
        assert_eq!(wrong.validate().unwrap_err().key, "conditions.limb.by_diameter_um");
        assert!(soft().validate().is_ok());
    }
}
