//! What a control's circle leaves of a nose that is none: e(a), its uncertainty, and the register
//! that leaves least.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec2;

use super::error::ToolError;
use crate::nose::{NoseProfile, TipDirection, ToolGeometry};
use crate::setting::SettingError;

/// How far the gauge point lies from the tool point along an axis, when the tool was set.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Extent {
    /// The gauge point lies at the register circle's centre: the tool point's own coordinate.
    Centre,
    /// Touched with this nose: its support in this direction, rad.
    Touched(f64),
    /// Set before: a length and its standard uncertainty, mm.
    Given(f64, f64),
}

/// Extents stated with the tool: of the nose with which it was set.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Stated {
    /// Distance of the extreme along X from the tool point, mm.
    pub x_mm: Option<f64>,
    /// Distance of the extreme along Z, mm.
    pub z_mm: Option<f64>,
    /// Standard uncertainty of either, mm.
    pub u_mm: f64,
}

/// A nose as the control takes it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Setting<'a> {
    /// The nose.
    pub nose: &'a NoseProfile,
    /// Its imaginary tip.
    pub tip: TipDirection,
    x: Extent,
    z: Extent,
}

impl<'a> Setting<'a> {
    /// A nose set by touching with itself, but for the extents that are stated.
    ///
    /// # Errors
    /// An extreme that the nose's support does not reach: it must be stated.
    pub(crate) fn new(
        nose: &'a NoseProfile,
        geometry: &ToolGeometry,
        stated: &Stated,
    ) -> Result<Self, ToolError> {
        let extent = |sign: i8, stated_mm: Option<f64>, towards: f64, away: f64, key: &str| {
            let at = match (sign, stated_mm) {
                (0, _) => return Ok(Extent::Centre),
                (_, Some(mm)) => return Ok(Extent::Given(mm, stated.u_mm)),
                (-1, None) => towards,
                _ => away,
            };
            let (low, high) = nose.range_rad();
            let turns = [at, at - 2.0 * PI, at + 2.0 * PI];
            turns.into_iter().find(|a| (low..=high).contains(a)).map(Extent::Touched).ok_or_else(|| {
                let right = format!(
                    "is needed: the nose was measured from {:.2}° to {:.2}° and does not reach the direction {:.0}° in \
                     which it would be touched",
                    low.to_degrees(),
                    high.to_degrees(),
                    at.to_degrees()
                );
                ToolError::Setting(SettingError::at(key, right))
            })
        };
        let tip = geometry.tip;
        Ok(Self {
            nose,
            tip,
            x: extent(tip.x, stated.x_mm, 0.0, PI, "setting.x_extent_mm")?,
            z: extent(tip.z, stated.z_mm, FRAC_PI_2, -FRAC_PI_2, "setting.z_extent_mm")?,
        })
    }

    /// The gauge point about the tool point, g = (σx·Hx, σz·Hz), mm.
    pub(crate) fn gauge_point(&self) -> DVec2 {
        let of = |extent: Extent| match extent {
            Extent::Centre => 0.0,
            Extent::Touched(a) => self.nose.support_mm(a),
            Extent::Given(mm, _) => mm,
        };
        let (sx, sz) = self.tip.signs();
        DVec2::new(sx * of(self.x), sz * of(self.z))
    }

    /// From the tool point of this nose to that of another one on the same path of the gauge point,
    /// mm.
    pub(crate) fn to_tool_point_of(&self, other: &Setting<'_>) -> DVec2 {
        self.gauge_point() - other.gauge_point()
    }

    /// Factor of R in e(a): 1 + σx·cos a + σz·sin a.
    pub(crate) fn factor(&self, a: f64) -> f64 {
        let (sx, sz) = self.tip.signs();
        1.0 + sx * a.cos() + sz * a.sin()
    }

    /// What is left at the normal angle `a`, e(a), mm along the normal.
    pub(crate) fn left_mm(&self, a: f64, radius_mm: f64) -> f64 {
        radius_mm * self.factor(a) - self.gauge_point().dot(DVec2::from_angle(a)) - self.nose.support_mm(a)
    }

    /// Standard uncertainty of e(a), mm: u² = gᵀ·C·g with the weights g of the extents and of h.
    pub(crate) fn u_left_mm(&self, a: f64) -> f64 {
        let (sx, sz) = self.tip.signs();
        let mut weights: Vec<(usize, f64)> = self.nose.weights(a).map(|(i, w)| (i, -w)).to_vec();
        let mut stated = 0.0;
        for (extent, sign, share) in [(self.x, sx, a.cos()), (self.z, sz, a.sin())] {
            match extent {
                Extent::Centre => {}
                Extent::Touched(at) => {
                    weights.extend(self.nose.weights(at).map(|(i, w)| (i, -sign * share * w)));
                }
                Extent::Given(_, u) => stated += (share * u).powi(2),
            }
        }
        (self.nose.u_of(&weights).powi(2) + stated).sqrt()
    }

    /// The register radius in `low ..= high` that leaves least at the largest of `angles`; the one
    /// nearest to `now_mm` where several do.
    pub(crate) fn best_radius_mm(&self, angles: &[f64], now_mm: f64, (low, high): (f64, f64)) -> f64 {
        let terms: Vec<(f64, f64)> = angles.iter().map(|&a| (self.factor(a), self.left_mm(a, 0.0))).collect();
        let largest = |r: f64| terms.iter().map(|(k, m)| (r * k + m).abs()).fold(0.0, f64::max);
        // the largest of straight lines is convex in R: the golden section halves the interval
        // every 1.44 steps, 100 of them reach the rounding of a number
        let (mut a, mut b) = (low, high);
        let golden = 0.5 * (5f64.sqrt() - 1.0);
        for _ in 0..100 {
            let (c, d) = (b - golden * (b - a), a + golden * (b - a));
            if largest(c) <= largest(d) { b = d } else { a = c }
        }
        let least = largest(0.5 * (a + b)) + ROUNDING_MM;
        let within =
            terms.iter().filter(|(k, _)| k.abs() > ROUNDING_MM).fold((low, high), |(from, to), (k, m)| {
                let (one, other) = ((-least - m) / k, (least - m) / k);
                (from.max(one.min(other)), to.min(one.max(other)))
            });
        if within.0 <= within.1 { now_mm.clamp(within.0, within.1) } else { 0.5 * (a + b) }
    }
}

/// Lengths below this are rounding errors, mm.
const ROUNDING_MM: f64 = 1e-9;
