//! The tool's angles in the reference plane (ISO 3002-1) and its nominal nose.

use std::f64::consts::PI;

use super::tip::TipDirection;
use crate::outline::Side;

/// The way in which the leading edge cuts.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Feed {
    /// From the tailstock to the chuck.
    #[default]
    TowardsChuck,
    /// From the chuck to the tailstock.
    TowardsTailstock,
}

/// A turning tool as its maker and the setter state it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ToolGeometry {
    /// Nominal nose radius, mm.
    pub nose_radius_mm: f64,
    /// Cutting edge angle κ_r, rad.
    pub kappa_r_rad: f64,
    /// Included angle ε_r, rad.
    pub epsilon_r_rad: f64,
    /// Angle that the trailing edge keeps from a falling surface, rad.
    pub clearance_rad: f64,
    /// Imaginary tip.
    pub tip: TipDirection,
    /// Shafts or bores.
    pub side: Side,
    /// The way its leading edge cuts.
    pub feed: Feed,
}

impl ToolGeometry {
    /// Angle κ_r' of the trailing edge, rad: κ_r + κ_r' + ε_r = 180°.
    pub(crate) fn kappa_prime_rad(&self) -> f64 {
        PI - self.kappa_r_rad - self.epsilon_r_rad
    }

    /// Least and largest angle of a surface's normal that the nose can cut, rad: −κ_r' to κ_r for
    /// a shaft cut towards the chuck, mirrored in Z and in X for the others.
    pub(crate) fn range_rad(&self) -> (f64, f64) {
        let (low, high) = (self.clearance_rad - self.kappa_prime_rad(), self.kappa_r_rad);
        let (low, high) = match self.feed {
            Feed::TowardsChuck => (low, high),
            Feed::TowardsTailstock => (-high, -low),
        };
        match self.side {
            Side::External => (low, high),
            Side::Internal => (PI - high, PI - low),
        }
    }
}
