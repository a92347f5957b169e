//! The surface that the process cuts with a nose against e(a), against what the tool room measures
//! by half-planes, and against a circle's closed form.

use glam::DVec2;

use super::parts::{compensator, flat_support, nose, papers, round, shaft};
use crate::nose::NoseProfile;
use crate::outline::{Outline, Side};
use crate::process::NosePath;
use crate::tool::{Compensator, Tool, Way, moves_of, remainders};

/// Bound of the design on e(a) against the envelope, mm.
const BOUND_MM: f64 = 3e-5;

fn cut(c: &Compensator<'_>, way: Way) -> NosePath {
    NosePath::new(c.setting.nose, &moves_of(&c.carry_out(way).unwrap().path))
}

/// How far the surface lies from a place along the normal, mm.
fn away(path: &NosePath, at: DVec2, a: f64) -> f64 {
    let n = DVec2::from_angle(a);
    let over = |l: f64| at.x + l * n.x - path.radius_mm(at.y + l * n.y).unwrap();
    let (mut low, mut high) = (-0.1, 0.1);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if over(middle) < 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[test]
fn a_round_nose_leaves_the_circles_closed_form() {
    let (r, register) = (0.37, 0.4);
    let (part, nose) = (shaft(), round(r));
    let path = cut(&compensator(&part, &nose, register), Way::Register);
    let mut worst: f64 = 0.0;
    for piece in part.pieces.iter().filter(|p| p.from_rad.max(p.to_rad) < 1.5) {
        let (at, a) = (piece.at(0.5), piece.angle_at(0.5));
        worst = worst.max((away(&path, at, a) - (register - r) * (1.0 - a.cos() - a.sin())).abs());
    }
    println!("a circle on cylinders and cones: {:.4} µm at most", 1e3 * worst);
    assert!(worst < BOUND_MM, "{worst:e}");
    // the shoulder, by the knots of the whole surface
    let knots = path.surface((-39.9, -0.1)).unwrap();
    let steps: Vec<f64> = knots.windows(2).filter(|k| k[0].0 == k[1].0).map(|k| k[0].0).collect();
    assert!(steps.len() == 1 && (steps[0] + 32.0).abs() < 1e-5, "{steps:?}");
    println!("{} knots", knots.len());
    assert!(knots.len() < 6000, "{}", knots.len());
}

/// Every place of the outline that the tool touches, by two methods that share nothing but the
/// path: half-planes along the normal, and curves over z.
fn against_half_planes(part: &Outline, nose: &NoseProfile, way: Way) -> f64 {
    let c = compensator(part, nose, 0.4);
    let done = c.carry_out(way).unwrap();
    let moves = moves_of(&done.path);
    let path = NosePath::new(nose, &moves);
    let left = remainders(part, &done.path, &moves, &Tool::new(nose));
    let seen = left.iter().filter(|l| l.reached && l.a_rad.to_degrees() < 80.0);
    let worst = seen.map(|l| (away(&path, l.at, l.a_rad) - l.left_mm).abs());
    worst.fold(0.0, f64::max)
}

#[test]
fn arcs_and_gouges_come_out_as_half_planes_measure_them() {
    for nose in [papers(), nose(0.25, |a| 0.385 - 0.01 * (2.0 * a).sin()), nose(0.25, flat_support)] {
        for way in Way::ALL {
            let worst = against_half_planes(&shaft(), &nose, way);
            println!("{}: {:.4} µm at most", way.as_str(), 1e3 * worst);
            assert!(worst < BOUND_MM, "{way:?}: {worst:e}");
        }
    }
}

#[test]
fn a_flat_nose_gouges_a_concave_arc_by_its_sagitta() {
    let flat = nose(0.25, flat_support);
    let part = shaft();
    let path = cut(&compensator(&part, &flat, 0.4), Way::Register);
    let arc = part.pieces.iter().find(|p| p.arc.is_some_and(|a| a.radius_mm < 0.0)).unwrap();
    // at 45° the flat of .217 mm stands on two corners; e(45°) alone leaves what is ground off
    let e = compensator(&part, &flat, 0.4).setting.left_mm(45f64.to_radians(), 0.4);
    let deepest = (1..40)
        .map(|k| 20.0 + 1.25 * f64::from(k))
        .map(|deg| away(&path, arc.at(share(arc, deg)), deg.to_radians()))
        .fold(f64::INFINITY, f64::min);
    assert!(e > 0.01 && deepest < 0.2 * e, "e(45°) {e}, least left {deepest}");
}

fn share(arc: &crate::outline::Piece, deg: f64) -> f64 {
    (deg.to_radians() - arc.from_rad) / (arc.to_rad - arc.from_rad)
}

#[test]
fn a_z_without_the_nose_is_named() {
    let part = Outline::from_corners(
        &[super::parts::corner(0.0, 20.0, 0.0), super::parts::corner(30.0, 20.0, 0.0)],
        Side::External,
    )
    .unwrap();
    let nose = papers();
    let path = cut(&compensator(&part, &nose, 0.4), Way::Path);
    assert_eq!(path.surface((0.0, 30.0)).unwrap(), [(0.0, 10.0), (30.0, 10.0)]);
    assert!(path.surface((0.0, 31.0)).unwrap_err() > 30.0);
}
