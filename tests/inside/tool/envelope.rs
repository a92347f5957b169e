//! e(a) against the envelope of the moved nose, by brute force: the nose as a polygon of its edge
//! points, carried along the control's path in small steps, and every edge of every position
//! intersected with the normal of the surface.

use glam::DVec2;

use super::parts::*;
use crate::nose::{NoseProfile, TipDirection};
use crate::outline::{Outline, Piece};
use crate::tool::{Setting, Stated};

/// Points of the nose's edge about the tool point.
fn edge(nose: &NoseProfile) -> Vec<DVec2> {
    let (low, high) = nose.range_rad();
    (0..=3000).map(|k| -nose.contact(low + (high - low) * f64::from(k) / 3000.0)).collect()
}

/// Where the normal at `at` first meets the nose at any of the places.
fn envelope(edge: &[DVec2], places: &[DVec2], at: DVec2, n: DVec2) -> f64 {
    let t = n.perp();
    let mut nearest = f64::INFINITY;
    for place in places {
        let from_surface = |p: DVec2| (*place + p - at).dot(t);
        // the edge's points run along −t or +t throughout: halve to the one across the normal
        let (mut a, mut b) = (0, edge.len() - 1);
        let sign = from_surface(edge[a]).signum();
        if sign == from_surface(edge[b]).signum() {
            continue;
        }
        while b - a > 1 {
            let middle = (a + b) / 2;
            if from_surface(edge[middle]).signum() == sign { a = middle } else { b = middle }
        }
        let (p, q) = (*place + edge[a] - at, *place + edge[b] - at);
        let share = p.dot(t) / (p.dot(t) - q.dot(t));
        nearest = nearest.min(p.lerp(q, share).dot(n));
    }
    nearest
}

/// Half of the places of the tool point beside a surface point: steps of .1 µm leave ridges of
/// s²/8r = .003 nm.
const HALF: i32 = 500;

/// Places of the tool point while a control with the radius `r` drives its circle along a piece.
fn places(piece: &Piece, middle: f64, reach: f64, of: impl Fn(f64) -> DVec2) -> Vec<DVec2> {
    let share = reach / piece.length_mm();
    let at = |k: i32| middle + share * f64::from(k) / f64::from(HALF);
    (-HALF..=HALF).map(at).map(|s| piece.at(s) + of(piece.angle_at(s))).collect()
}

/// Largest distance of e(a) from the envelope over an outline, mm. Of a flat nose 45° on the arcs
/// is left out: there the flat touches with its two corners, and e has a kink.
fn away(setting: &Setting<'_>, part: &Outline, register: f64, flat: bool) -> f64 {
    let edge = edge(setting.nose);
    let (sx, sz) = setting.tip.signs();
    let shift = register * DVec2::new(sx, sz) - setting.gauge_point();
    let mut worst: f64 = 0.0;
    for piece in &part.pieces {
        for k in 1..8 {
            let share = f64::from(k) / 8.0;
            let (a, at) = (piece.angle_at(share), piece.at(share));
            if flat && piece.arc.is_some() && (a.to_degrees() - 45.0).abs() < 1.0 {
                continue;
            }
            let places = places(piece, share, 0.05, |a| register * DVec2::from_angle(a) + shift);
            let brute = envelope(&edge, &places, at, DVec2::from_angle(a));
            // e(a) is how far the tangent moves; it touches e'(a) further along, and at the place
            // itself a surface of the radius ρ lies e'²/2ρ inside its tangent
            let e = |a: f64| setting.left_mm(a, register);
            let slope = (e(a + 1e-4) - e(a - 1e-4)) / 2e-4;
            let inside = piece.arc.map_or(0.0, |arc| 0.5 * slope * slope / arc.radius_mm);
            worst = worst.max((brute - e(a) + inside).abs());
        }
    }
    worst
}

#[test]
fn what_is_left_is_the_envelope_of_the_moved_nose() {
    let shaft = shaft();
    let mut worst: f64 = 0.0;
    let noses = [papers(), nose(0.25, |a| 0.385 - 0.01 * (2.0 * a).sin()), nose(0.25, flat_support)];
    for (flat, nose) in [false, false, true].into_iter().zip(noses) {
        for register in [0.4, 0.3865] {
            worst = worst.max(away(&compensator(&shaft, &nose, register).setting, &shaft, register, flat));
        }
    }
    println!("e(a) against the envelope: {:.4} µm at most", 1e3 * worst);
    assert!(worst < 3e-5, "{worst:e}");
}

#[test]
fn every_tip_direction_leaves_its_envelope_on_shafts_and_in_bores() {
    let mut numbers = std::collections::BTreeSet::new();
    for (side, feed) in TURNED {
        let part = turned(&shaft_corners(), (side, feed), 80.0);
        let seen = carried(&papers(), side, feed);
        let full = full_tip(side, feed);
        for (x, z) in [(full.x, full.z), (0, full.z), (full.x, 0), (0, 0)] {
            let geometry = tool(side, feed, TipDirection { x, z });
            let setting = Setting::new(&seen, &geometry, &Stated::default()).unwrap();
            let worst = away(&setting, &part, 0.4, false);
            println!("{side:?} {feed:?} ({x}, {z}): {:.4} µm at most", 1e3 * worst);
            assert!(worst < 3e-5, "{side:?} {feed:?} ({x}, {z}): {worst:e}");
            numbers.insert((x, z));
        }
    }
    assert_eq!(numbers.len(), 9, "all tip directions");
}
