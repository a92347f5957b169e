//! Where the tool point stands for a surface point: moved by what touches there.
//!
//! For a surface point S with the normal n(a) the nose touches with the tool point at S + q(a). A
//! control that compensates moves its circle's centre to S + R·n, and with it the tool point to S +
//! R·n + R·σ − g. Both are S + c(a), and c'(a) is along t(a): the moved curve keeps the surface's
//! tangent. So the contour that makes such a control drive the tool point where the nose touches is
//! the nose's path moved back by R·n + R·σ − g.

use glam::DVec2;

use super::biarc;
use super::register::Setting;
use crate::nose::NoseProfile;
use crate::outline::{Arc, Piece};

/// The vector c(a) from a surface point to the tool point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Contact<'a> {
    /// The nose's own, q(a).
    Nose(&'a NoseProfile),
    /// Of a control that compensates: R·n(a) and a vector.
    Circle {
        /// R, mm.
        radius_mm: f64,
        /// R·σ − g, mm.
        shift: DVec2,
    },
}

impl<'a> Contact<'a> {
    /// Of a control that compensates for the radius R.
    pub(crate) fn of_register(setting: &Setting<'a>, radius_mm: f64) -> Self {
        Self::Circle { radius_mm, shift: shift(setting, radius_mm) }
    }

    /// A piece moved, in runs: where a run ends the moved curve turns back, since what touches is
    /// flatter than the concave surface.
    pub(crate) fn moved(&self, piece: &Piece) -> Vec<Vec<Piece>> {
        let (from, to) = (piece.from_rad, piece.to_rad);
        match (self, piece.arc) {
            (Self::Nose(nose), None) => vec![vec![piece.moved(nose.contact(from))]],
            (Self::Nose(nose), Some(arc)) => biarc::fitted(
                &|a| arc.centre + arc.radius_mm * DVec2::from_angle(a) + nose.contact(a),
                (from, to),
            ),
            (Self::Circle { radius_mm, shift }, None) => {
                vec![vec![piece.moved(*radius_mm * DVec2::from_angle(from) + *shift)]]
            }
            (Self::Circle { radius_mm, shift }, Some(arc)) => {
                let moved = Arc { centre: arc.centre + *shift, radius_mm: arc.radius_mm + radius_mm };
                let forward = moved.radius_mm * (to - from) > 0.0;
                if forward { vec![vec![Piece::arc(moved, from, to)]] } else { vec![Vec::new(), Vec::new()] }
            }
        }
    }

    /// The way about a convex corner from the angle `from` to `to`.
    pub(crate) fn about(&self, corner: DVec2, from: f64, to: f64) -> Vec<Vec<Piece>> {
        let arc = Arc { centre: corner, radius_mm: 0.0 };
        self.moved(&Piece { from: corner, to: corner, from_rad: from, to_rad: to, arc: Some(arc) })
    }
}

/// From the centre of the register's circle to the tool point, R·σ − g.
pub(crate) fn shift(setting: &Setting<'_>, radius_mm: f64) -> DVec2 {
    let (sx, sz) = setting.tip.signs();
    radius_mm * DVec2::new(sx, sz) - setting.gauge_point()
}
