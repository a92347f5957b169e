//! What the paper prints.

/// Figures of the paper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Inputs {
    /// Errors in its list, and those of moving axes among them.
    pub errors: usize,
    pub errors_of_motion: usize,
    /// Terms of eqs 1 and 4.
    pub terms_x: usize,
    pub terms_z: usize,
    /// Side of the working space and distance of the sampling points, mm.
    pub side_mm: f64,
    pub step_mm: f64,
    /// Training samples.
    pub samples: usize,
    /// Accuracy of the probe, µm.
    pub probe_um: f64,
    /// Length of the generatrix, mm.
    pub generatrix_mm: f64,
    /// Straightness, before and after compensation, µm.
    pub straightness_um: [f64; 2],
    /// Cylindricity, before and after, and by the other instrument, µm.
    pub cylindricity_um: [f64; 2],
    pub cylindrimeter_um: f64,
    /// Flatness, before and after, µm; diameter of the face, mm.
    pub flatness_um: [f64; 2],
    pub face_mm: f64,
    /// Spiral: duration and interval, s; turns a second; points.
    pub spiral_s: f64,
    pub interval_s: f64,
    pub turns_per_s: f64,
    pub spiral_points: usize,
    /// Limits of the temperature, K.
    pub limit_k: f64,
}

impl Default for Inputs {
    fn default() -> Self {
        Self {
            errors: 21,
            errors_of_motion: 18,
            terms_x: 6,
            terms_z: 6,
            side_mm: 100.0,
            step_mm: 2.0,
            samples: 2601,
            probe_um: 0.01,
            generatrix_mm: 100.0,
            straightness_um: [0.26, 0.10],
            cylindricity_um: [0.38, 0.21],
            cylindrimeter_um: 0.40,
            flatness_um: [0.80, 0.12],
            face_mm: 100.0,
            spiral_s: 48.0,
            interval_s: 0.1,
            turns_per_s: 1.0,
            spiral_points: 481,
            limit_k: 0.1,
        }
    }
}

impl Inputs {
    /// Positions along a side.
    pub(super) fn positions(&self) -> usize {
        (self.side_mm / self.step_mm).round() as usize + 1
    }

    /// Points on the generatrix: the paper gives none; those of its samples.
    pub(super) fn generatrix_points(&self) -> usize {
        (self.generatrix_mm / self.step_mm).round() as usize + 1
    }

    /// Points of a turn of the spiral.
    pub(super) fn points_per_turn(&self) -> usize {
        (1.0 / (self.turns_per_s * self.interval_s)).round() as usize
    }
}
