//! What heads make of a pose, against silhouettes computed ray by ray and the published figures.

use nalgebra::{Rotation3, Vector3};

use super::{Draws, close};
use crate::machine::Pose;
use crate::machine::response::{Part, Side, TwoSided, cut_mm, probe_mm};

fn pose(shift_mm: [f64; 3], turn_rad: [f64; 3]) -> Pose {
    Pose { shift_mm: Vector3::from(shift_mm), turn_rad: Vector3::from(turn_rad) }
}

fn head(pupil_mm: f64) -> TwoSided {
    TwoSided { pupil_mm, keystone_per_mm: 0.0, pair_mm: [0.0, 0.0] }
}

/// Width of a cone's image in the central column of a head in a pose: bisection for the ray that
/// touches, by the discriminant of its quadratic with x² + y² = (R + z·D′/2)².
fn silhouette(part: &Part, pupil_mm: f64, pose: &Pose) -> f64 {
    let turn = Rotation3::new(pose.turn_rad);
    let (across, along) = (turn * Vector3::x(), turn * Vector3::y());
    let (r, slope) = (0.5 * part.diameter_mm, 0.5 * part.taper);
    let hits = |v: f64| {
        let o = pose.shift_mm + v * across;
        let d = (v / pupil_mm) * across - along;
        let (ro, rd) = (r + slope * o.z, slope * d.z);
        let a = d.x * d.x + d.y * d.y - rd * rd;
        let b = o.x * d.x + o.y * d.y - ro * rd;
        let c = o.x * o.x + o.y * o.y - ro * ro;
        b * b > a * c
    };
    let edge = |sign: f64| {
        let (mut inside, mut outside) = (0.0, 3.0 * r);
        while outside - inside > 1e-15 * r && 0.5 * (inside + outside) > inside {
            let middle = 0.5 * (inside + outside);
            if middle >= outside {
                break;
            }
            *(if hits(sign * middle) { &mut inside } else { &mut outside }) = middle;
        }
        inside
    };
    edge(1.0) + edge(-1.0)
}

#[test]
fn two_sided_heads_read_what_rays_that_touch_enclose() {
    let mut draws = Draws(3);
    for pupil_mm in [46_600.0, 300.0, 120.0] {
        for taper in [0.0, 0.1, -0.2] {
            let part = Part { diameter_mm: 25.0, taper };
            let still = silhouette(&part, pupil_mm, &pose([0.0; 3], [0.0; 3]));
            for _ in 0..20 {
                let shift = [0, 1, 2].map(|_| 2e-3 * draws.next());
                let turn = [2e-5, 2e-5, 2e-5].map(|size| size * draws.next());
                let pose = pose(shift, turn);
                let right = part.diameter_mm * (silhouette(&part, pupil_mm, &pose) - still) / still;
                let found = head(pupil_mm).read_mm(&part, &pose);
                close(
                    found,
                    right,
                    (0.01 * right.abs()).max(0.02e-6),
                    &format!("l {pupil_mm}, D' {taper}, {pose:?}"),
                );
            }
        }
    }
}

#[test]
fn a_turn_towards_the_camera_reads_a_cone_at_the_touching_points() {
    // D′ = .1, a = 5 µrad, l = 300: D′·a·R²/l = .26 nm, .3 as published.
    let part = Part { diameter_mm: 25.0, taper: 0.1 };
    let found = head(300.0).read_mm(&part, &pose([0.0; 3], [5e-6, 0.0, 0.0]));
    close(1e6 * found, 0.26, 0.005, "nm");
    let plain = Part { taper: 0.0, ..part };
    close(head(300.0).read_mm(&plain, &pose([0.0; 3], [5e-6, 0.0, 0.0])), 0.0, 1e-15, "a cylinder");
}

#[test]
fn figures_of_the_comparison_are_those_published() {
    // D 25, 1 µm and 5 µrad at levers of 100 mm, tip .05 mm above the axis.
    let part = Part { diameter_mm: 25.0, taper: 0.0 };
    let x = pose([1e-3, 0.0, 0.0], [0.0; 3]);
    let y = pose([0.0, 1e-3, 0.0], [0.0; 3]);
    close(1e3 * cut_mm(&part, 0.05, &x), 2.0, 1e-4, "cut, u_x");
    close(1e3 * probe_mm(&part, 0.05, Side::Tool, &x), -2.0, 1e-4, "probe, u_x");
    close(1e3 * probe_mm(&part, 0.05, Side::Opposite, &x), 2.0, 1e-4, "probe opposite, u_x");
    close(1e6 * cut_mm(&part, 0.05, &y), 8.0, 0.1, "cut, u_y");
    close(1e6 * probe_mm(&part, 0.05, Side::Tool, &y), -8.0, 0.1, "probe, u_y");
    close(1e6 * head(46_600.0).read_mm(&part, &y), -0.54, 0.005, "telecentric, u_y");
    close(1e6 * head(300.0).read_mm(&part, &y), -83.4, 0.2, "entocentric, u_y");
    close(head(f64::INFINITY).read_mm(&part, &y), 0.0, 0.0, "without remainder");
    close(1e6 * head(46_600.0).read_mm(&part, &pose([0.0; 3], [0.0, 1e-3, 0.0])), 12.5, 0.01, "1 mrad");
    let keystone = TwoSided { keystone_per_mm: 8e-6, ..head(f64::INFINITY) };
    close(1e6 * keystone.read_mm(&part, &x), 0.4, 1e-6, "keystone");
    let pair = TwoSided { pair_mm: [0.0, 1.0], ..head(f64::INFINITY) };
    close(1e6 * pair.read_mm(&part, &pose([0.0; 3], [0.0, 5e-6, 0.0])), -5.0, 1e-3, "a pair 1 mm apart");
    let cone = Part { taper: 0.1, ..part };
    let z = pose([0.0, 0.0, 1e-3], [0.0; 3]);
    close(1e6 * cut_mm(&cone, 0.05, &z), -100.0, 1e-6, "cut, u_z");
    close(1e6 * probe_mm(&cone, 0.05, Side::Tool, &z), 100.0, 1e-6, "probe, u_z");
    close(1e6 * head(46_600.0).read_mm(&cone, &z), 100.0, 1e-4, "head, u_z");
}

#[test]
fn a_pair_of_edges_turns_with_its_frame() {
    // Upper edge's head at [y, z] = [2, 3] from the lower one's: its own displacement by ω × r.
    let part = Part { diameter_mm: 25.0, taper: 0.0 };
    let pair = TwoSided { pair_mm: [2.0, 3.0], ..head(f64::INFINITY) };
    let turn = Vector3::new(7e-6, -4e-6, 9e-6);
    let moved = |sign: f64| turn.cross(&Vector3::new(0.0, sign, sign * 1.5)).x;
    let right = -(moved(1.0) - moved(-1.0));
    close(pair.read_mm(&part, &pose([0.0; 3], turn.into())), right, 1e-9, "mm");
}

#[test]
fn a_probe_in_the_tools_pose_reads_the_cut_as_nominal() {
    let mut draws = Draws(5);
    for _ in 0..50 {
        let part = Part { diameter_mm: 10.0 + 8.0 * draws.next(), taper: 0.3 * draws.next() };
        let pose = pose([0, 1, 2].map(|_| 5e-3 * draws.next()), [0.0; 3]);
        let tip = 0.2 * draws.next();
        let sum = cut_mm(&part, tip, &pose) + probe_mm(&part, tip, Side::Tool, &pose);
        // Second order in u: the two agree to u²/R.
        assert!(sum.abs() < 4.0 * pose.shift_mm.norm_squared() / part.diameter_mm, "{sum}");
    }
}
