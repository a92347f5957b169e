//! Finishes of masters and parts, and how far the edges of two of them may differ.
//!
//! Light grazes the limb of a cylinder over some R/M (M = (kR/2)^⅓). Roughness about the mean line,
//! of correlation length L along the light, acts as a change of the surface's admittance and moves
//! the limb outwards by
//!
//! ```text
//! δ = 1.4 · 0.489 · Rq² · √(2k/L),   k = 2π/λ
//! ```
//!
//! (perturbation of the impedance boundary condition; marching the parabolic equation past rough
//! limbs gives the same for Rq = 0.2 and 0.4 µm: 0.06 and 0.24 µm; larger Rq are extrapolated).
//! Edges of two finishes then differ by at most the larger δ.

use crate::gauge::limit::limits;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

limits! {
    /// What the shift of a rough limb is computed for.
    FinishLimits = "finish";
    /// Wavelength of the light, µm: green, as most telecentric lights have; blue moves the limb by
    /// 8 % more.
    wavelength_um: f64 = 0.525;
    /// Correlation length of the roughness along the light, µm: that of the limbs that were
    /// marched. The shift goes by its inverse root.
    correlation_um: f64 = 5.0;
    /// Rp over Ra of the parabolic grooves that turning leaves: their peaks stand ⅔ of the depth
    /// above the mean line, Ra is 4/(9√3) of it.
    grooves_rp_over_ra: f64 = 2.598;
    /// Rp over Rq of heights that are normally distributed, as lapping and grinding leave them: the
    /// highest of some hundred summits of a sampling length.
    summits_rp_over_rq: f64 = 3.0;
}

/// Rq over Ra of heights that are normally distributed, √(π/2).
const RQ_OVER_RA: f64 = 1.2533;

/// Outward shift of a limb by roughness around it, of Rq and correlation length in µm, µm.
pub(crate) fn texture_shift_um(rq_um: f64, correlation_um: f64, wavelength_um: f64) -> f64 {
    let k = std::f64::consts::TAU / wavelength_um;
    1.4 * 0.489 * rq_um * rq_um * (2.0 * k / correlation_um).sqrt()
}

/// How a surface was finished, with the roughness it stands for; what is rougher has to state
/// `limit_edge_um`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Finish {
    /// Lapped or polished: Ra up to 0.05 µm.
    Lapped,
    /// Ground: Ra up to 0.4 µm.
    Ground,
    /// Finely turned: Ra up to 0.8 µm.
    Turned,
}

impl Finish {
    /// Largest Ra of the class, µm.
    pub(crate) fn ra_um(self) -> f64 {
        match self {
            Self::Lapped => 0.05,
            Self::Ground => 0.4,
            Self::Turned => 0.8,
        }
    }

    /// Largest outward shift of an edge of this finish, µm.
    fn shift_um(self) -> f64 {
        let limits = FinishLimits::get();
        texture_shift_um(RQ_OVER_RA * self.ra_um(), limits.correlation_um, limits.wavelength_um)
    }

    /// The same in light of another wavelength, µm.
    pub(crate) fn shift_in_um(self, wavelength_um: f64) -> f64 {
        let correlation_um = FinishLimits::get().correlation_um;
        texture_shift_um(RQ_OVER_RA * self.ra_um(), correlation_um, wavelength_um)
    }

    /// Largest height of its peaks above the mean line, Rp, µm.
    pub(crate) fn peaks_um(self) -> f64 {
        let limits = FinishLimits::get();
        match self {
            Self::Turned => limits.grooves_rp_over_ra * self.ra_um(),
            Self::Lapped | Self::Ground => limits.summits_rp_over_rq * RQ_OVER_RA * self.ra_um(),
        }
    }

    /// Limits within which edges of two finishes differ, ± µm an edge: either may be anything from
    /// smooth to its class' roughest.
    pub(crate) fn limit_um(self, other: Self) -> f64 {
        self.shift_um().max(other.shift_um())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The two values that marching past rough limbs gave.
    #[test]
    fn the_shift_is_that_of_marched_limbs() {
        let shift = |rq: f64| texture_shift_um(rq, 5.0, 0.525);
        assert!((shift(0.2) - 0.06).abs() < 0.005 && (shift(0.4) - 0.24).abs() < 0.005);
        assert!((Finish::Turned.limit_um(Finish::Lapped) - 1.5).abs() < 0.05);
        assert_eq!(Finish::Lapped.limit_um(Finish::Ground), Finish::Ground.limit_um(Finish::Lapped));
    }
}
