//! Models to programs from the bar, in every dialect: what they leave, what they refuse.

use glam::DVec2;

use super::accuracy::SETTINGS;
use super::body::{Body, binary, corner, outline, papers_part, placed, pose, profile};
use crate::inside::linuxcnc::{canonical, interpret};
use crate::nc::{ChangePosition, Chuck, Dialect, GeometryOffset, NcSettings, Spindle, Tailstock, WearX};
use crate::outline::Outline;
use crate::part_program::{Cuts, PartPlan, PartProgram, PartProgramError, Placed, Reason, shaft_corners};
use crate::plan::CuttingData;
use crate::shaft::ContourPoint;
use crate::stl::{ReadSettings, read_part};
use crate::tool::{OutOfReach, Reachable, ToolFile, Way};

const CUTS: Cuts = Cuts { depth_mm: 1.5, allowance_mm: 0.2, facing_mm: 1.0 };

fn tool() -> ToolFile {
    toml::from_str(include_str!("../../../configs/tool/tool.toml")).unwrap()
}

fn machine() -> NcSettings {
    NcSettings {
        tailstock: Some(Tailstock::Absent),
        chuck: Some(Chuck { diameter_mm: 160.0, jaws_to_z_mm: 14.0, jaws_diameter_mm: None }),
        change_position: Some(ChangePosition { x_mm: 200.0, z_mm: 120.0 }),
        wear_x: Some(WearX::Diameter),
        geometry_offset: Some(GeometryOffset::ByTool),
        spindle: Some(Spindle::M03),
        least_z_mm: 15.0,
        nose_radius_mm: Some(0.4),
        ..NcSettings::default()
    }
}

/// The outline of a model of these corners.
fn read(corners: &[ContourPoint]) -> Outline {
    let triangles = Body::turned(&profile(&outline(corners), 15.0), 36).triangles();
    let settings = ReadSettings { stock_mm: 42.0, ..SETTINGS };
    read_part(&binary(&placed(&triangles, pose())), &settings).unwrap().outline
}

fn written(
    outline: &Outline,
    (from_z_mm, stock_mm): (f64, f64),
    way: Way,
    dialect: Dialect,
) -> Result<PartProgram, PartProgramError> {
    let (tool, machine) = (tool(), machine());
    let plan = PartPlan {
        outline,
        from_z_mm,
        stock_mm,
        tool: &tool,
        nose: None,
        way,
        machine: &machine,
        cutting: CuttingData { speed_m_per_min: 180.0, feed_mm_per_rev: 0.1 },
        cuts: CUTS,
    };
    plan.write(dialect)
}

#[test]
fn the_papers_parts_are_cut_from_the_bar_in_every_dialect() {
    for number in 1..=4 {
        let part = read(&papers_part(number));
        for dialect in Dialect::ALL {
            let way = if dialect == Dialect::Gsk { Way::Path } else { Way::Register };
            let stock = if number == 1 { 42.0 } else { 32.0 };
            let program = written(&part, (20.0, stock), way, dialect)
                .unwrap_or_else(|e| panic!("part {number}, {}: {e}", dialect.as_str()));
            // half an increment of X, Z and R, as for finishing cuts
            let most = if dialect == Dialect::Linuxcnc { 0.2 } else { 1.5 };
            let largest = program.largest.unwrap();
            println!("part {number}, {}: {:+.3} µm, {:?}", dialect.as_str(), largest.left_um, program.places);
            assert!(largest.left_um.abs() < most, "part {number}, {}: {largest:?}", dialect.as_str());
            // sharp inner corners keep the nose's fillet, nothing else stays
            assert!(program.places.iter().all(|p| p.reason == Reason::NoseRadius && p.most_mm < 0.45));
            let roughing = program.moves.iter().filter(|m| m.roughing && !m.rapid).count();
            assert!(roughing > 6, "{roughing}");
        }
    }
}

/// What moves of the gauge point leave of points along a normal, mm: the nearest place of the
/// nose's middle less its radius. Tip direction 3 has the middle a radius further out along X and
/// Z.
fn left_mm(at: DVec2, moves: &[(DVec2, DVec2)]) -> f64 {
    let beside = |(from, to): &(DVec2, DVec2)| {
        let (way, at) = (*to - *from, at - DVec2::splat(0.4));
        let share = ((at - *from).dot(way) / way.length_squared().max(1e-18)).clamp(0.0, 1.0);
        at.distance(*from + share * way)
    };
    moves.iter().map(beside).fold(f64::INFINITY, f64::min) - 0.4
}

/// LinuxCNC's own interpreter takes every program and leaves of the part what the replay leaves.
#[test]
fn linuxcnc_leaves_what_the_replay_leaves() {
    for number in 1..=4 {
        let part = read(&papers_part(number));
        for way in [Way::Register, Way::Path] {
            let program = written(&part, (20.0, 42.0), way, Dialect::Linuxcnc).unwrap();
            let Some((_, printed)) = interpret(&program.text) else { return };
            let theirs = canonical(&printed);
            let ours: Vec<(DVec2, DVec2)> = program.moves.iter().map(|m| (m.from, m.to)).collect();
            let pieces = &program.reachable.outline.pieces;
            let points = pieces.iter().flat_map(|p| (0..=40).map(|k| p.at(f64::from(k) / 40.0)));
            let (mut apart, mut cut, mut left) = (0.0_f64, 0.0_f64, 0.0_f64);
            for at in points.filter(|at| at.x > 0.1) {
                let (a, b) = (1e3 * left_mm(at, &ours), 1e3 * left_mm(at, &theirs));
                (apart, cut, left) = (apart.max((a - b).abs()), cut.min(b), left.max(b));
            }
            println!("rs274, part {number}, {}: {apart:.4} µm apart, {cut:.4} to {left:.4} µm", way.as_str());
            assert!(apart < 0.1 && cut > -0.1, "part {number}: {apart} {cut}\n{printed}\n{}", program.text);
            // two walls of a sharp inner corner keep the nose's fillet
            assert!(left < 1e3 * 0.4 * (std::f64::consts::SQRT_2 - 1.0) + 0.1, "part {number}: {left}");
        }
    }
}

/// A groove whose wall towards the chuck is too steep for the trailing edge, and a fillet below the
/// nose: both are listed with their place, and the program cuts the rest.
#[test]
fn what_the_tool_does_not_reach_is_listed() {
    let corners = [
        corner(0.0, 0.0, 0.0),
        corner(0.0, 30.0, 0.0),
        corner(10.0, 30.0, 0.0),
        corner(10.0, 20.0, 0.2),
        corner(22.0, 20.0, 0.0),
        corner(22.0, 26.0, 0.0),
        corner(30.0, 26.0, 0.0),
        corner(30.0, 0.0, 0.0),
    ];
    let part = read(&corners);
    let program = written(&part, (20.0, 32.0), Way::Register, Dialect::Linuxcnc).unwrap();
    let [edge, nose] = program.left_out()[..] else { panic!("{:?}", program.left_out()) };
    assert!(edge.why == OutOfReach::TrailingEdge && nose.why == OutOfReach::NoseRadius);
    // from the collar's edge at Z 42, 3 mm down at 27°: 5.888 mm long
    assert!(
        (edge.z_mm.1 - 42.0).abs() < 1e-3
            && (edge.z_mm.0 - (42.0 - 3.0 / 27f64.to_radians().tan())).abs() < 1e-3
    );
    assert!((nose.value - 0.2).abs() < 1e-4);
    let wedge = program.places.iter().find(|p| p.reason == Reason::OutOfReach).unwrap();
    assert!((wedge.most_mm - 3.0).abs() < 0.05, "{wedge:?}");
    // the wedge turned: its section's area on the circle of its middle, by Pappus
    let (length, height) = (3.0 / 27f64.to_radians().tan(), 3.0);
    let volume = std::f64::consts::TAU * (10.0 + height / 3.0) * 0.5 * length * height;
    assert!((wedge.volume_mm3 / volume - 1.0).abs() < 0.02, "{} {volume}", wedge.volume_mm3);
}

#[test]
fn what_lies_in_the_grip_stays_bar() {
    let part = read(&papers_part(1));
    let program = written(&part, (0.0, 42.0), Way::Register, Dialect::Linuxcnc).unwrap();
    let grip: Vec<_> = program.places.iter().filter(|p| p.reason == Reason::Grip).collect();
    assert!(!grip.is_empty() && grip.iter().all(|p| p.z_mm[1] <= 15.03), "{grip:?}");
    assert!((grip.iter().map(|p| p.most_mm).fold(0.0, f64::max) - 6.0).abs() < 0.05);
    let refused = Placed::new(&part, 0.0, 90.0).unwrap_err();
    assert!(matches!(refused, PartProgramError::InGrip { .. }), "{refused}");
}

/// Reach of a leading edge below 90°: a shoulder keeps the edge's line in front of it.
#[test]
fn a_leading_edge_leaves_its_line_in_front_of_a_shoulder() {
    let part = read(&papers_part(1));
    let placed = Placed::new(&part, 20.0, 15.0).unwrap();
    let geometry = ToolFile { kappa_r_deg: 75.0, epsilon_r_deg: 80.0, ..tool() }.geometry().unwrap();
    let reachable = Reachable::of(&placed.free, &geometry);
    let shoulder = reachable.left_out.iter().find(|o| o.z_mm.0 < 31.0).unwrap();
    assert_eq!(shoulder.why, OutOfReach::LeadingEdge);
    // 5 mm high at 75°
    assert!(
        (shoulder.z_mm.1 - shoulder.z_mm.0 - 5.0 / 75f64.to_radians().tan()).abs() < 1e-3,
        "{shoulder:?}"
    );
    let pieces = &reachable.outline.pieces;
    assert!(pieces.windows(2).all(|w| w[0].to.distance(w[1].from) < 1e-6), "{pieces:#?}");
}

#[test]
fn a_model_becomes_the_corners_of_its_drawing() {
    for number in 1..=4 {
        let found = shaft_corners(&read(&papers_part(number))).unwrap();
        let again = Outline::from_corners(&found, crate::outline::Side::External).unwrap();
        let drawn = papers_part(number);
        let largest = drawn.iter().map(|c| c.diameter_mm).fold(0.0, f64::max);
        assert!((2.0 * again.largest_radius_mm() - largest).abs() < 1e-4);
        let radii = |corners: &[ContourPoint]| {
            corners.iter().filter(|c| c.radius_mm > 0.0).map(|c| c.radius_mm).collect::<Vec<_>>()
        };
        let (found, drawn) = (radii(&found), radii(&drawn));
        assert!(found.len() == drawn.len() && found.iter().zip(&drawn).all(|(a, b)| (a - b).abs() < 1e-4));
    }
}
