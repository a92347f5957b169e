//! Noses and parts that the tests share.

use std::f64::consts::PI;

use crate::nose::{Feed, NoseProfile, Support, TipDirection, ToolGeometry};
use crate::outline::{Outline, Side};
use crate::shaft::ContourPoint;
use crate::tool::{Compensator, Setting, Stated};

/// A tool of 93°, 60°, for shafts cut towards the chuck.
pub fn geometry() -> ToolGeometry {
    ToolGeometry {
        nose_radius_mm: 0.4,
        kappa_r_rad: 93f64.to_radians(),
        epsilon_r_rad: 60f64.to_radians(),
        clearance_rad: 0.0,
        tip: TipDirection { x: -1, z: -1 },
        side: Side::External,
        feed: Feed::TowardsChuck,
    }
}

/// A nose from its support function of the angle in degrees, every `step_deg` from −27° to 93°.
pub fn nose(step_deg: f64, h_mm: impl Fn(f64) -> f64) -> NoseProfile {
    let steps = (120.0 / step_deg).round() as usize;
    let at = |k: usize| -27.0 + 120.0 * k as f64 / steps as f64;
    let support =
        |k: usize| Support { a_rad: at(k).to_radians(), h_mm: h_mm(at(k).to_radians()), u_mm: 5e-5 };
    NoseProfile::new(&(0..=steps).map(support).collect::<Vec<_>>(), None, 0.0).unwrap()
}

/// A round nose about the tool point.
pub fn round(radius_mm: f64) -> NoseProfile {
    nose(1.0, |_| radius_mm)
}

/// The paper's nose: .3865 mm where X and Z are touched, .3743 at 45°, unworn edges beside.
pub fn papers() -> NoseProfile {
    nose(1.0, papers_support)
}

/// Its support: worn by .0122·sin²(2a) between the two extremes.
pub fn papers_support(a: f64) -> f64 {
    let worn = if (0.0..std::f64::consts::FRAC_PI_2).contains(&a) { (2.0 * a).sin().powi(2) } else { 0.0 };
    0.3865 - 0.0122 * worn
}

/// A round nose of .4 mm ground flat over .217 mm at 45°.
pub fn flat_support(a: f64) -> f64 {
    let (r, half, turn) = (0.4_f64, 0.1085_f64, a - std::f64::consts::FRAC_PI_4);
    let depth = (r * r - half * half).sqrt();
    if turn.abs() >= (half / r).asin() { r } else { depth * turn.cos() + half * turn.sin().abs() }
}

pub fn corner(z_mm: f64, diameter_mm: f64, radius_mm: f64) -> ContourPoint {
    ContourPoint { z_mm, diameter_mm, chamfer_mm: 0.0, radius_mm }
}

/// Cylinder, concave R4, shoulder, cylinder, a 24° cone, cylinder, convex R5, end face.
pub fn shaft_corners() -> [ContourPoint; 7] {
    let run = 6.0 / 24f64.to_radians().tan();
    [
        corner(-40.0, 60.0, 0.0),
        corner(-32.0, 60.0, 0.0),
        corner(-32.0, 46.0, 4.0),
        corner(-22.0, 46.0, 0.0),
        corner(-22.0 + run, 34.0, 0.0),
        corner(0.0, 34.0, 5.0),
        corner(0.0, 10.0, 0.0),
    ]
}

/// The shaft with these corners.
pub fn shaft() -> Outline {
    Outline::from_corners(&shaft_corners(), Side::External).unwrap()
}

/// A tool by its side, its feed and its tip direction.
pub fn tool(side: Side, feed: Feed, tip: TipDirection) -> ToolGeometry {
    ToolGeometry { tip, side, feed, ..geometry() }
}

/// The tip direction of a tool set in X and Z.
pub fn full_tip(side: Side, feed: Feed) -> TipDirection {
    TipDirection {
        x: if side == Side::External { -1 } else { 1 },
        z: if feed == Feed::TowardsChuck { -1 } else { 1 },
    }
}

/// A normal's angle as a tool of another side and feed sees it.
pub fn flipped(side: Side, feed: Feed, a: f64) -> f64 {
    match (side, feed) {
        (Side::External, Feed::TowardsChuck) => a,
        (Side::External, Feed::TowardsTailstock) => -a,
        (Side::Internal, Feed::TowardsChuck) => PI - a,
        (Side::Internal, Feed::TowardsTailstock) => PI + a,
    }
}

/// A nose as a tool of another side and feed carries it, its support every quarter of a degree.
pub fn carried(nose: &NoseProfile, side: Side, feed: Feed) -> NoseProfile {
    let mut values: Vec<Support> = (0..=480)
        .map(|k| (-27.0 + 0.25 * f64::from(k)).to_radians())
        .map(|a| Support { a_rad: flipped(side, feed, a), h_mm: nose.support_mm(a), u_mm: 5e-5 })
        .collect();
    values.sort_by(|a, b| a.a_rad.total_cmp(&b.a_rad));
    NoseProfile::new(&values, None, 0.0).unwrap()
}

/// Corners of a shaft for a tool of another side and feed: mirrored in Z about the middle of both
/// ends, and into a bore about half of `sum_mm`.
pub fn turned(corners: &[ContourPoint], (side, feed): (Side, Feed), sum_mm: f64) -> Outline {
    let (first, last) = (corners[0].z_mm, corners[corners.len() - 1].z_mm);
    let mut made = corners.to_vec();
    if feed == Feed::TowardsTailstock {
        made.iter_mut().for_each(|c| c.z_mm = first + last - c.z_mm);
        made.reverse();
    }
    if side == Side::Internal {
        made.iter_mut().for_each(|c| c.diameter_mm = sum_mm - c.diameter_mm);
    }
    Outline::from_corners(&made, side).unwrap()
}

/// Both sides with both feeds.
pub const TURNED: [(Side, Feed); 4] = [
    (Side::External, Feed::TowardsChuck),
    (Side::External, Feed::TowardsTailstock),
    (Side::Internal, Feed::TowardsChuck),
    (Side::Internal, Feed::TowardsTailstock),
];

/// A part with a nose set by touching, R in 0.001 to 9.999 mm.
pub fn compensator<'a>(outline: &'a Outline, nose: &'a NoseProfile, register_mm: f64) -> Compensator<'a> {
    let setting = Setting::new(nose, &geometry(), &Stated::default()).unwrap();
    Compensator { outline, setting, register_mm, register_range_mm: (0.001, 9.999), increment_mm: 1e-4 }
}
