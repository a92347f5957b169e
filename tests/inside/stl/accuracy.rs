//! What is read of good models: axis, vertices and radii of the paper's parts, coarse and fine.

use glam::DVec2;

use super::body::{Body, ascii, binary, outline, papers_part, placed, pose, profile};
use crate::outline::Outline;
use crate::stl::{ReadSettings, TOLERANCE_MM, TurnedPart, Unit, read_part};

pub const SETTINGS: ReadSettings =
    ReadSettings { unit: Unit::Millimetre, stock_mm: 45.0, tolerance_mm: TOLERANCE_MM, turn_round: false };

/// Largest difference of the ends of two outlines' pieces, µm.
fn ends_apart_um(found: &Outline, right: &Outline) -> f64 {
    assert_eq!(found.pieces.len(), right.pieces.len(), "{:#?}", found.pieces);
    let pairs = found.pieces.iter().zip(&right.pieces);
    let apart = |a: DVec2, b: DVec2| 1e3 * a.distance(b);
    pairs.map(|(f, r)| apart(f.from, r.from).max(apart(f.to, r.to))).fold(0.0, f64::max)
}

fn radii_apart_um(found: &Outline, right: &Outline) -> f64 {
    let pairs = found.pieces.iter().zip(&right.pieces);
    let apart = pairs.map(|(f, r)| match (f.arc, r.arc) {
        (Some(f), Some(r)) => 1e3 * (f.radius_mm - r.radius_mm).abs(),
        (None, None) => 0.0,
        _ => f64::INFINITY,
    });
    apart.fold(0.0, f64::max)
}

fn read(bytes: &[u8]) -> TurnedPart {
    read_part(bytes, &SETTINGS).unwrap_or_else(|fault| panic!("{fault}"))
}

#[test]
fn the_papers_parts_are_read_to_a_tenth_of_a_micrometre_coarse_and_fine() {
    for number in 1..=4 {
        let right = outline(&papers_part(number));
        for (step_deg, n) in [(30.0, 24), (15.0, 48), (0.3, 180)] {
            let made = Body::turned(&profile(&right, step_deg), n).triangles();
            let (turn, shift) = pose();
            let triangles = placed(&made, (turn, shift));
            for (form, bytes) in [("binary", binary(&triangles)), ("ascii", ascii(&triangles, 8))] {
                let part = read(&bytes);
                let direction = turn.z_axis;
                let tilt = part.axis.direction.cross(direction).length();
                // a plain bar has no heavier end: either may come to the chuck
                let is_turned_round = number == 4 && part.axis.direction.dot(direction) < 0.0;
                let end = if is_turned_round { shift + right.z_mm().1 * direction } else { shift };
                let beside = 1e3 * (part.axis.point - end).length();
                let (ends, radii) =
                    (ends_apart_um(&part.outline, &right), radii_apart_um(&part.outline, &right));
                println!(
                    "part {number}, {n} a turn, {form}: axis {tilt:.1e} rad, {beside:.4} µm; ends {ends:.4} µm, radii {radii:.4} µm"
                );
                assert!(tilt < 1e-7 && beside < 0.1 && ends < 0.1 && radii < 0.1, "part {number}");
                assert_eq!(part.facets, triangles.len());
                assert!(is_turned_round || part.axis.direction.dot(direction) > 0.0);
            }
        }
    }
}

#[test]
fn lines_and_arcs_that_are_tangent_stay_so() {
    let right = outline(&papers_part(3));
    let made = Body::turned(&profile(&right, 30.0), 24).triangles();
    let part = read(&binary(&placed(&made, pose())));
    let arcs = part.outline.pieces.iter().filter(|p| p.arc.is_some()).count();
    assert_eq!(arcs, 2);
    for pair in part.outline.pieces.windows(2).filter(|w| w[0].arc.is_some() || w[1].arc.is_some()) {
        let turn = (pair[1].from_rad - pair[0].to_rad).abs();
        // the end face joins the convex arc, the cylinders and the shoulder both
        assert!(!(1e-12..=0.1).contains(&turn), "{turn}");
        assert!(pair[0].to == pair[1].from);
    }
}

#[test]
fn cylinders_and_faces_are_square_to_the_axis() {
    let made = Body::turned(&profile(&outline(&papers_part(1)), 30.0), 36).triangles();
    let part = read(&binary(&placed(&made, pose())));
    let lines = part.outline.pieces.iter().map(|p| p.from_rad.to_degrees());
    let square: Vec<f64> = lines.filter(|a| a.abs() < 1e-3 || (a.abs() - 90.0).abs() < 1e-3).collect();
    assert_eq!(square.len(), 6);
    assert!(square.iter().all(|a| *a == 0.0 || a.abs() == 90.0), "{square:?}");
}

/// A quarter of two chords and tangent lines is an arc, one chord is a chamfer; a trapezoid and a
/// groove, whose corners lie on circles, stay lines.
#[test]
fn corners_on_a_circle_are_no_arc() {
    use super::body::corner;
    let with = |inner: &[crate::shaft::ContourPoint]| {
        let mut corners = vec![corner(0.0, 0.0, 0.0), corner(0.0, 30.0, 0.0)];
        corners.extend(inner);
        corners.extend([corner(40.0, 20.0, 0.0), corner(40.0, 0.0, 0.0)]);
        outline(&corners)
    };
    let collar = [(10.0, 30.0), (10.0, 20.0), (20.0, 20.0), (22.0, 24.0), (24.0, 24.0), (26.0, 20.0)];
    let collar: Vec<_> = collar.iter().map(|(z, d)| corner(*z, *d, 0.0)).collect();
    let groove = [(10.0, 30.0), (10.0, 20.0), (20.0, 20.0), (20.0, 16.0), (24.0, 16.0), (24.0, 20.0)];
    let groove: Vec<_> = groove.iter().map(|(z, d)| corner(*z, *d, 0.0)).collect();
    for right in [with(&collar), with(&groove)] {
        let part = read(&binary(&Body::turned(&profile(&right, 30.0), 32).triangles()));
        assert!(part.outline.pieces.iter().all(|p| p.arc.is_none()), "{:#?}", part.outline);
        assert!(ends_apart_um(&part.outline, &right) < 0.1);
    }
    let fillet = [corner(15.0, 30.0, 0.0), corner(15.0, 20.0, 1.5)];
    let right = with(&fillet);
    for (step_deg, arcs) in [(45.0, 1), (90.0, 0)] {
        let part = read(&binary(&Body::turned(&profile(&right, step_deg), 32).triangles()));
        assert_eq!(part.outline.pieces.iter().filter(|p| p.arc.is_some()).count(), arcs, "{step_deg}");
    }
}

/// A tube's outside is read, its bore named; the same of a centre drilled into an end face.
#[test]
fn bores_are_left_out_and_named() {
    let points =
        |list: &[(f64, f64)]| -> Vec<DVec2> { list.iter().map(|(r, z)| DVec2::new(*r, *z)).collect() };
    let mut tube = Body::turned(
        &points(&[(5.0, 0.0), (15.0, 0.0), (15.0, 12.0), (12.0, 12.0), (12.0, 20.0), (5.0, 20.0)]),
        40,
    );
    let first = tube.rows[0].clone();
    tube.rows.push(first);
    let part = read(&binary(&placed(&tube.triangles(), pose())));
    assert_eq!(part.recesses.len(), 2);
    assert!(
        part.recesses.iter().all(|r| (r.diameter_mm - 10.0).abs() < 1e-4 && (r.depth_mm - 20.0).abs() < 1e-4)
    );
    assert_eq!(part.outline.pieces.len(), 5);
    let centre =
        Body::turned(&points(&[(0.0, 0.0), (15.0, 0.0), (15.0, 20.0), (2.0, 20.0), (0.0, 18.0)]), 40);
    let part = read(&binary(&centre.triangles()));
    assert_eq!(part.recesses.len(), 1);
    assert!((part.recesses[0].z_mm - 20.0).abs() < 1e-4 && (part.recesses[0].depth_mm - 2.0).abs() < 1e-4);
    assert_eq!(part.outline.pieces.len(), 3);
}

/// The heavier half comes to the chuck however the model points, unless it is turned round.
#[test]
fn the_heavier_half_comes_to_the_chuck() {
    let right = outline(&papers_part(1));
    let body = Body::turned(&profile(&right, 30.0), 30);
    // turned by half a turn about x: the outsides of the facets stay outside
    let round = body.clone().mapped(|v| glam::DVec3::new(v.x, -v.y, -v.z));
    for body in [body, round] {
        let bytes = binary(&body.triangles());
        assert!(ends_apart_um(&read(&bytes).outline, &right) < 0.1);
        let other = read_part(&bytes, &ReadSettings { turn_round: true, ..SETTINGS }).unwrap();
        assert!((2.0 * other.outline.pieces[0].to.x - 20.0).abs() < 1e-4);
    }
}

/// Turns along a cylinder and a cone, as meshers put them there, are lines; an ellipse becomes arcs
/// within the tolerance.
#[test]
fn turns_along_lines_are_lines_and_a_curve_keeps_to_its_tolerance() {
    let mut points = vec![DVec2::ZERO];
    points.extend((0..=200).map(|k| DVec2::new(15.0, 0.2 * f64::from(k))));
    points.extend((1..=100).map(|k| DVec2::new(15.0 - 0.05 * f64::from(k), 40.0 + 0.2 * f64::from(k))));
    points.push(DVec2::new(0.0, 60.0));
    let part = read(&binary(&placed(&Body::turned(&points, 40).triangles(), pose())));
    assert_eq!(part.outline.pieces.len(), 4, "{:?}", part.outline.pieces);
    let ellipse = |k: u32| {
        let t = std::f64::consts::FRAC_PI_2 * f64::from(k) / 200.0;
        if k == 200 { DVec2::new(0.0, 30.0) } else { DVec2::new(15.0 * t.cos(), 5.0 + 25.0 * t.sin()) }
    };
    let points: Vec<DVec2> =
        [DVec2::ZERO, DVec2::new(15.0, 0.0)].into_iter().chain((0..=200).map(ellipse)).collect();
    let bytes = binary(&Body::turned(&points, 60).triangles());
    let counts = [2e-3, 2e-2].map(|tolerance_mm| {
        let part = read_part(&bytes, &ReadSettings { tolerance_mm, ..SETTINGS }).unwrap();
        assert!(part.departure_mm <= 2.0 * tolerance_mm, "{}", part.departure_mm);
        part.outline.pieces.len()
    });
    println!("pieces of an ellipse: {counts:?}");
    assert!(counts[0] < 60 && counts[1] < counts[0]);
}

/// A ball is turned about the axis of its vertices: one arc.
#[test]
fn a_ball_is_one_arc() {
    let at = |k: u32| {
        let a = std::f64::consts::PI * f64::from(k) / 24.0;
        DVec2::new(if k.is_multiple_of(24) { 0.0 } else { 15.0 * a.sin() }, 15.0 - 15.0 * a.cos())
    };
    let part =
        read(&binary(&placed(&Body::turned(&(0..=24).map(at).collect::<Vec<_>>(), 48).triangles(), pose())));
    let [piece] = part.outline.pieces[..] else { panic!("{:?}", part.outline) };
    assert!((piece.arc.unwrap().radius_mm - 15.0).abs() < 1e-4);
}

/// A million facets within the second that the design allows; `--nocapture` prints the time.
#[test]
#[ignore = "a second of work, more on a busy machine: run by name"]
fn a_million_facets_are_read() {
    let right = outline(&papers_part(3));
    let bytes = binary(&placed(&Body::turned(&profile(&right, 0.4), 1100).triangles(), pose()));
    let start = std::time::Instant::now();
    let part = read(&bytes);
    println!("{} facets: {:.2} s", part.facets, start.elapsed().as_secs_f64());
    assert!(part.facets > 900_000 && ends_apart_um(&part.outline, &right) < 0.1);
}
