//! What is programmed or driven for a surface point: the point moved by what touches there.
//!
//! For a surface point S with the normal n(a) the tool point stands at S + q(a). A control that
//! compensates moves its circle's centre to S + R·n, and with it the tool point to
//! S + R·n + R·σ − g. The contour that makes such a control drive the tool point where it belongs is
//! S + q − R·n + g − R·σ. All three are S + c(a), and c'(a) is along t(a): the moved curve keeps
//! the surface's tangent.

use glam::DVec2;

use super::biarc;
use super::register::Setting;
use crate::nose::NoseProfile;
use crate::outline::{Arc, Piece};

/// The vector c(a) from a surface point to what is programmed for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Contact<'a> {
    nose: Option<&'a NoseProfile>,
    radius_mm: f64,
    shift: DVec2,
}

impl<'a> Contact<'a> {
    /// To the tool point.
    pub(crate) fn of_nose(nose: &'a NoseProfile) -> Self {
        Self { nose: Some(nose), radius_mm: 0.0, shift: DVec2::ZERO }
    }

    /// To the tool point of a control that compensates for the radius R.
    pub(crate) fn of_register(setting: &Setting<'_>, radius_mm: f64) -> Self {
        Self { nose: None, radius_mm, shift: centre_to_gauge(setting, radius_mm) - setting.gauge_point() }
    }

    /// To the contour for a control that compensates for the radius R.
    pub(crate) fn of_contour(setting: &Setting<'a>, radius_mm: f64) -> Self {
        let shift = setting.gauge_point() - centre_to_gauge(setting, radius_mm);
        Self { nose: Some(setting.nose), radius_mm: -radius_mm, shift }
    }

    /// c(a).
    pub(crate) fn at(&self, a: f64) -> DVec2 {
        let nose = self.nose.map_or(DVec2::ZERO, |nose| nose.contact(a));
        nose + self.radius_mm * DVec2::from_angle(a) + self.shift
    }

    /// A piece moved, in runs: where a run ends the moved curve turns back, since what touches is
    /// flatter than the concave surface.
    pub(crate) fn moved(&self, piece: &Piece) -> Vec<Vec<Piece>> {
        let Some(arc) = piece.arc else { return vec![vec![piece.moved(self.at(piece.from_rad))]] };
        let (from, to) = (piece.from_rad, piece.to_rad);
        if self.nose.is_none() {
            let radius_mm = arc.radius_mm + self.radius_mm;
            let moved = Arc { centre: arc.centre + self.shift, radius_mm };
            let forward = radius_mm * (to - from) > 0.0;
            return if forward { vec![vec![Piece::arc(moved, from, to)]] } else { vec![Vec::new(), Vec::new()] };
        }
        biarc::fitted(&|a| arc.centre + arc.radius_mm * DVec2::from_angle(a) + self.at(a), (from, to))
    }

    /// The way about a convex corner from the angle `from` to `to`.
    pub(crate) fn about(&self, corner: DVec2, from: f64, to: f64) -> Vec<Vec<Piece>> {
        let arc = Arc { centre: corner, radius_mm: 0.0 };
        self.moved(&Piece { from: corner, to: corner, from_rad: from, to_rad: to, arc: Some(arc) })
    }
}

/// The gauge point about the centre of the register's circle, R·(σx, σz).
fn centre_to_gauge(setting: &Setting<'_>, radius_mm: f64) -> DVec2 {
    let (sx, sz) = setting.tip.signs();
    radius_mm * DVec2::new(sx, sz)
}
