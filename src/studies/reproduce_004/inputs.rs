//! What the paper prints, and what it leaves out.

use crate::numerics::distributions::student;
use crate::setting::{SettingError, within};
use crate::studies::reproduction::Accept;

/// Half of the last digit of a figure printed in whole micrometres, mm.
pub(super) const MICROMETRE_MM: f64 = 0.5e-3;
/// Half of the last digit of a figure printed in hundredths of a millimetre, mm.
pub(super) const HUNDREDTH_MM: f64 = 0.5e-2;
/// Half of the last digit of a radius printed to a tenth of a micrometre, mm.
pub(super) const TENTH_UM_MM: f64 = 0.5e-4;
/// Rounding error of sums of readings, mm: means that end in a 5 are rounded up.
pub(super) const ROUNDING_MM: f64 = 1e-9;

/// A workpiece of Table 4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PrintedPart {
    /// Errors before compensation, mm.
    pub before_mm: [f64; 4],
    /// Errors after it, mm.
    pub after_mm: [f64; 4],
    /// Mean error before as the text prints it, mm.
    pub mean_before_mm: f64,
    /// Mean error after, mm.
    pub mean_after_mm: f64,
    /// Reduction of the mean error as printed, %.
    pub rate_percent: f64,
}

/// A land of Table 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PrintedLand {
    /// Mean width VB, mm.
    pub vb_mm: f64,
    /// Largest width, mm.
    pub vb_max_mm: f64,
}

impl PrintedPart {
    /// Mean of four readings, mm.
    pub(crate) fn mean_mm(readings: &[f64; 4]) -> f64 {
        readings.iter().sum::<f64>() / 4.0
    }

    /// Standard deviation of four readings, mm.
    fn spread_mm(readings: &[f64; 4]) -> f64 {
        let mean = Self::mean_mm(readings);
        (readings.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / 3.0).sqrt()
    }

    /// What agrees with the mean error before compensation: its digits and, at 95 %, the scatter of
    /// four readings.
    pub(super) fn accepts(&self) -> Accept {
        // the standard deviation of a mean of four is half of a reading's
        Accept::Absolute(MICROMETRE_MM + student(3.0, 0.95) * 0.5 * Self::spread_mm(&self.before_mm))
    }

    /// Reduction of the mean of the raw readings, %.
    pub(crate) fn raw_percent(&self) -> f64 {
        percent(Self::mean_mm(&self.before_mm), Self::mean_mm(&self.after_mm))
    }

    /// Reduction of the printed means, %.
    pub(super) fn printed_means_percent(&self) -> f64 {
        percent(self.mean_before_mm, self.mean_after_mm)
    }

    /// Standard uncertainty of [`Self::raw_percent`], %: of the ratio of two means of four.
    pub(super) fn u_percent(&self) -> f64 {
        let (before, after) = (Self::mean_mm(&self.before_mm), Self::mean_mm(&self.after_mm));
        let (u_before, u_after) =
            (0.5 * Self::spread_mm(&self.before_mm), 0.5 * Self::spread_mm(&self.after_mm));
        100.0 * (u_after / before).hypot(after * u_before / (before * before))
    }
}

fn percent(before: f64, after: f64) -> f64 {
    100.0 * (before - after) / before
}

/// Inputs of the rows: the printed figures, and the cone angles that are not printed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Inputs {
    /// Scale S, µm per pixel.
    pub scale_um_per_px: f64,
    /// Mean radius of the worn nose, px.
    pub mean_radius_px: f64,
    /// Mean gap between the worn nose and the tangents along X and Z, px.
    pub gap_px: f64,
    /// Radius of the unworn nose R0, mm.
    pub nominal_mm: f64,
    /// Mean radius r, mm.
    pub radius_mm: f64,
    /// Gap, mm.
    pub gap_mm: f64,
    /// Radius after setting R1, mm.
    pub set_radius_mm: f64,
    /// Designation of the insert (ISO 1832).
    pub designation: &'static str,
    /// Included angle ε_r, degrees.
    pub epsilon_r_deg: f64,
    /// Cutting edge angle κ_r, degrees.
    pub kappa_r_deg: f64,
    /// Bound q of the error of a grey value, in the threshold of the gradient.
    pub grey_error: f64,
    /// Tolerance τ of the gradient's direction, degrees.
    pub tolerance_deg: f64,
    /// Factor γ of the number of tests.
    pub gamma: f64,
    /// Exponent of the number of pixels in the number of tests, as printed.
    pub exponent: f64,
    /// Axial compensation dz of parts 1 and 2, mm.
    pub dz_mm: [f64; 2],
    /// Correction e of the arc's radius of part 3, mm.
    pub e_mm: f64,
    /// Corrections dx2 and dz2 of part 3, mm.
    pub dx2_dz2_mm: [f64; 2],
    /// Radial compensation dx of part 4, mm.
    pub dx_mm: f64,
    /// Table 1: slight, uniform and non-uniform wear of the flank.
    pub lands: [PrintedLand; 3],
    /// Table 4.
    pub parts: [PrintedPart; 4],
    /// Repeatability along X and Z, mm.
    pub repeatability_mm: [f64; 2],
    /// Half angles of the cones of parts 1 and 2, degrees; not printed.
    pub cone_deg: Option<[f64; 2]>,
}

impl Default for Inputs {
    fn default() -> Self {
        Self {
            scale_um_per_px: 2.415,
            mean_radius_px: 154.9826,
            gap_px: 5.5901,
            nominal_mm: 0.4,
            radius_mm: 0.3743,
            gap_mm: 0.0135,
            set_radius_mm: 0.3865,
            designation: "TNMG160404TSBB60",
            epsilon_r_deg: 60.0,
            kappa_r_deg: 93.0,
            grey_error: 2.0,
            tolerance_deg: 22.5,
            gamma: 2.0,
            exponent: 0.4,
            dz_mm: [0.03, 0.02],
            e_mm: 0.015,
            dx2_dz2_mm: [0.011, 0.011],
            dx_mm: 0.016,
            lands: [(0.048, 0.079), (0.156, 0.241), (0.190, 0.429)]
                .map(|(vb_mm, vb_max_mm)| PrintedLand { vb_mm, vb_max_mm }),
            parts: table_4(),
            repeatability_mm: [0.004, 0.005],
            cone_deg: None,
        }
    }
}

fn table_4() -> [PrintedPart; 4] {
    let part = |before_mm, after_mm, (mean_before_mm, mean_after_mm), rate_percent| PrintedPart {
        before_mm,
        after_mm,
        mean_before_mm,
        mean_after_mm,
        rate_percent,
    };
    [
        part([0.034, 0.036, 0.020, 0.026], [0.005, 0.009, 0.008, 0.007], (0.029, 0.007), 75.8),
        part([0.022, 0.026, 0.028, 0.019], [0.005, 0.004, 0.007, 0.002], (0.024, 0.005), 79.2),
        part([0.02, 0.01, 0.02, 0.03], [0.01, 0.01, 0.01, 0.02], (0.02, 0.013), 37.5),
        part([0.014, 0.020, 0.016, 0.019], [0.006, 0.008, 0.005, 0.002], (0.017, 0.005), 69.6),
    ]
}

impl Inputs {
    /// Refuses cone angles between which d/sin θ and d/cos θ mean nothing.
    ///
    /// # Errors
    /// A half angle outside of 1° to 89°.
    pub(crate) fn check(&self) -> Result<(), SettingError> {
        for (k, angle) in self.cone_deg.into_iter().flatten().enumerate() {
            let key = format!("--cone-deg, part {}", k + 1);
            within(
                &key,
                angle,
                1.0,
                89.0,
                "a half angle of 1 to 89 degrees, from the axis to the cone's side",
            )?;
        }
        Ok(())
    }

    /// d = R1 − r of the printed radii, mm.
    pub(super) fn d_mm(&self) -> f64 {
        self.set_radius_mm - self.radius_mm
    }

    /// d of the figures in pixels, mm.
    pub(super) fn d_of_pixels_mm(&self) -> f64 {
        self.nominal_mm - 1e-3 * self.scale_um_per_px * (self.gap_px + self.mean_radius_px)
    }

    /// The half angle at which an axial compensation is d/sin θ, rad.
    pub(super) fn needed_rad(&self, dz_mm: f64) -> f64 {
        (self.d_mm() / dz_mm).asin()
    }

    /// The half angle of part 1 or 2 (0 or 1), rad: as stated, or the one that its compensation
    /// needs.
    pub(super) fn cone_rad(&self, part: usize) -> f64 {
        self.cone_deg.map_or_else(|| self.needed_rad(self.dz_mm[part]), |deg| deg[part].to_radians())
    }

    /// The cone angle as data that the paper has or lacks.
    pub(super) fn theta(&self) -> (&'static str, bool) {
        ("the cone's half angle θ (--cone-deg)", self.cone_deg.is_some())
    }
}
