//! The chains against displacements derived by hand, against products of 4 by 4 matrices that are
//! coded apart, and against their first order.

use nalgebra::Vector3;

use super::{Draws, close, machine};
use crate::machine::topology::Topology;
use crate::machine::{Chain, ErrorName, ErrorValues, MachineSettings, Station, first_order};

/// The levers of [`super::MACHINE`]: tool t and carriage w, mm.
const T: [f64; 3] = [110.0, 90.0, 70.0];
const W: [f64; 3] = [40.0, 80.0, 120.0];
/// A position of the slides, mm.
const X: f64 = 30.0;
const Z: f64 = 70.0;

fn both() -> [MachineSettings; 2] {
    [machine(&[], ""), machine(&[("t_shaped", "carriage")], "")]
}

/// Tool relative to part for a unit of each error, derived on paper: [chain T, chain L], each
/// [x, y, z].
fn by_hand(name: ErrorName) -> [[f64; 3]; 2] {
    let ([tx, ty, tz], [wx, wy, wz]) = (T, W);
    let same = |e: [f64; 3]| [e, e];
    match name {
        ErrorName::Exx => same([1.0, 0.0, 0.0]),
        ErrorName::Eyx => same([0.0, 1.0, 0.0]),
        ErrorName::Ezx => same([0.0, 0.0, 1.0]),
        ErrorName::Eax => same([0.0, -tz, ty]),
        ErrorName::Ebx => same([tz, 0.0, -tx]),
        ErrorName::Ecx => same([-ty, tx, 0.0]),
        ErrorName::Exz => [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
        ErrorName::Eyz => [[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]],
        ErrorName::Ezz => [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]],
        ErrorName::Eaz => [[0.0, wz + Z, -wy], [0.0, -wz, wy]],
        ErrorName::Ebz => [[-(wz + Z), 0.0, wx + X], [wz, 0.0, -(wx + X)]],
        ErrorName::Ecz => [[wy, -(wx + X), 0.0], [-wy, wx + X, 0.0]],
        ErrorName::Exc => same([-1.0, 0.0, 0.0]),
        ErrorName::Eyc => same([0.0, -1.0, 0.0]),
        ErrorName::Ezc => same([0.0, 0.0, -1.0]),
        ErrorName::Eac | ErrorName::A0c => same([0.0, Z, 0.0]),
        ErrorName::Ebc | ErrorName::B0c => same([-Z, 0.0, X]),
        ErrorName::Ecc => same([0.0, -X, 0.0]),
        ErrorName::B0x => same([0.0, 0.0, -X]),
    }
}

#[test]
fn each_error_alone_has_the_sign_and_lever_derived_by_hand() {
    // 1e-7 mm or rad: the second order, 1e-14 times 200 mm, stays below rounding's 1e-12.
    const SIZE: f64 = 1e-7;
    for (settings, chain) in both().iter().zip([0, 1]) {
        let station = settings.tool(X, Z);
        for name in ErrorName::ALL {
            let right = Vector3::from(by_hand(name)[chain]);
            let values = ErrorValues::only(name, SIZE);
            let exact = Chain { topology: settings.chain, values }.pose(&station).shift_mm;
            let off = (exact - SIZE * right).norm();
            assert!(off < 5e-12, "{name:?} of {:?}: {exact:?}, not {right:?}", settings.chain);
            let one = first_order::contribution(settings.chain, &station, name).shift_mm;
            assert!((one - right).norm() < 1e-12, "{name:?}: {one:?}, not {right:?}");
        }
    }
}

type Matrix = [[f64; 4]; 4];

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
}

fn chain_of(matrices: &[Matrix]) -> Matrix {
    matrices.iter().skip(1).fold(matrices[0], |all, next| product(&all, next))
}

fn shift(v: [f64; 3]) -> Matrix {
    [[1.0, 0.0, 0.0, v[0]], [0.0, 1.0, 0.0, v[1]], [0.0, 0.0, 1.0, v[2]], [0.0, 0.0, 0.0, 1.0]]
}

/// Rz·Ry·Rx as three matrices of their own.
fn turn(v: [f64; 3]) -> Matrix {
    let [(sa, ca), (sb, cb), (sc, cc)] = v.map(f64::sin_cos);
    let x = [[1.0, 0.0, 0.0, 0.0], [0.0, ca, -sa, 0.0], [0.0, sa, ca, 0.0], [0.0, 0.0, 0.0, 1.0]];
    let y = [[cb, 0.0, sb, 0.0], [0.0, 1.0, 0.0, 0.0], [-sb, 0.0, cb, 0.0], [0.0, 0.0, 0.0, 1.0]];
    let z = [[cc, -sc, 0.0, 0.0], [sc, cc, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    chain_of(&[z, y, x])
}

/// The inverse by elimination, which knows nothing of rotations.
fn inverse(m: &Matrix) -> Matrix {
    let mut left = *m;
    let mut right = shift([0.0; 3]);
    for k in 0..4 {
        let pivot = (k..4).max_by(|a, b| left[*a][k].abs().total_cmp(&left[*b][k].abs())).unwrap();
        left.swap(k, pivot);
        right.swap(k, pivot);
        let scale = left[k][k];
        left[k] = left[k].map(|v| v / scale);
        right[k] = right[k].map(|v| v / scale);
        for i in (0..4).filter(|i| *i != k) {
            let f = left[i][k];
            left[i] = std::array::from_fn(|j| left[i][j] - f * left[k][j]);
            right[i] = std::array::from_fn(|j| right[i][j] - f * right[k][j]);
        }
    }
    right
}

/// Tool relative to part by whole products from the base, X first and then the part's point.
fn by_matrices(topology: Topology, v: &[f64; 21], levers: [[f64; 3]; 2]) -> [f64; 3] {
    let [t, w] = levers;
    let three = |k: usize| [v[k], v[k + 1], v[k + 2]];
    let body = |k: usize| product(&shift(three(k)), &turn(three(k + 3)));
    let spindle = product(&turn([v[19], v[20], 0.0]), &body(12));
    let (sin, cos) = v[18].sin_cos();
    let along = [X * cos, 0.0, -X * sin];
    let back = t.map(|v| -v);
    let (part, tool) = match topology {
        Topology::TShaped => {
            // The base's origin lies where the Z slide's reference stands with Z at 0.
            let part = chain_of(&[shift([0.0, 0.0, -Z]), body(6), shift(w), spindle]);
            let tool = chain_of(&[shift(w), shift(back), shift(along), body(0), shift(t)]);
            (part, tool)
        }
        Topology::Carriage => {
            let reference = [-w[0], -w[1], Z - w[2]];
            let tool = chain_of(&[
                shift(reference),
                body(6),
                shift(w),
                shift(back),
                shift(along),
                body(0),
                shift(t),
            ]);
            (spindle, tool)
        }
    };
    let relative = product(&inverse(&part), &tool);
    let nominal = [X, 0.0, Z];
    std::array::from_fn(|k| relative[k][3] - nominal[k])
}

/// Errors drawn: lengths within ±`mm`, angles within ±`rad`.
fn drawn(draws: &mut Draws, mm: f64, rad: f64) -> ErrorValues {
    let size = |name: ErrorName| if name.is_length() { mm } else { rad };
    let mut values = ErrorValues::default();
    ErrorName::ALL.into_iter().for_each(|name| values.0[name as usize] = size(name) * draws.next());
    values
}

#[test]
fn chains_equal_products_of_matrices() {
    let mut draws = Draws(7);
    for settings in both() {
        let topology = settings.chain;
        for size in [5e-6, 1e-3, 0.05] {
            let values = drawn(&mut draws, 0.01, size);
            let found = Chain { topology, values }.pose(&settings.tool(X, Z)).shift_mm;
            let right = by_matrices(topology, &values.0, [T, W]);
            for (k, right) in right.into_iter().enumerate() {
                close(found[k], right, 1e-12, &format!("{topology:?} at {size}, {k}"));
            }
        }
    }
}

#[test]
fn the_first_order_is_off_by_no_more_than_products_of_angles() {
    let mut draws = Draws(11);
    // Levers up to 200 mm: wz + z = 190 mm.
    for (size, most_mm) in [(5e-6, 0.05e-6), (50e-6, 5e-6)] {
        let mut largest = 0.0_f64;
        for settings in both() {
            for _ in 0..200 {
                // Lengths as long as the angles reach at 100 mm.
                let values = drawn(&mut draws, 100.0 * size, size);
                let station = settings.tool(X, Z);
                let exact = Chain { topology: settings.chain, values }.pose(&station);
                let linear = first_order::pose(settings.chain, &station, &values);
                largest = largest.max((exact.shift_mm - linear.shift_mm).amax());
                assert!((exact.turn_rad - linear.turn_rad).amax() < 20.0 * size * size);
            }
        }
        println!("{size:e} rad: {:.4} nm", 1e6 * largest);
        assert!(largest < most_mm, "{largest} mm at {size} rad");
        assert!(largest > 1e-4 * most_mm, "the first order must not be the chain itself: {largest}");
    }
}

#[test]
fn a_head_that_does_not_ride_on_x_ignores_x() {
    for chain in ["t_shaped", "carriage"] {
        let changes = [
            ("t_shaped", chain),
            ("head_mm = [60.0, 90.0, 130.0]", "head_mm = [110.0, 90.0, 130.0]\nhead_on = \"x_carrier\""),
        ];
        let settings = machine(&changes, "");
        let station: Station = settings.head(20.0);
        assert_eq!(station.point_mm, Vector3::new(0.0, 0.0, 80.0));
        for name in ErrorName::ALL {
            let values = ErrorValues::only(name, 1e-5);
            let pose = Chain { topology: settings.chain, values }.pose(&station);
            let one = first_order::contribution(settings.chain, &station, name);
            let is_of_x = name.axis() == crate::machine::Axis::X;
            assert!(!is_of_x || pose.shift_mm.norm() + pose.turn_rad.norm() < 1e-13, "{name:?}");
            assert!((pose.shift_mm - 1e-5 * one.shift_mm).norm() < 5e-8, "{name:?}");
            assert!((pose.turn_rad - 1e-5 * one.turn_rad).norm() < 1e-13, "{name:?}");
        }
    }
}

#[test]
fn the_head_on_the_x_slide_stands_where_its_lever_puts_it() {
    // On a carriage lathe EBZ about the Z slide's reference: the head at w + head - tool along z.
    let settings = machine(&[("t_shaped", "carriage")], "");
    let station = settings.head(20.0);
    close(station.x_mm, 50.0, 1e-12, "X of the head on the axis");
    let one = first_order::contribution(settings.chain, &station, ErrorName::Ebz);
    close(one.shift_mm.x, 120.0 + 60.0, 1e-12, "EBZ by wz + head - tool");
    close(one.shift_mm.z, -40.0, 1e-12, "EBZ by wx");
    let one = first_order::contribution(settings.chain, &station, ErrorName::Ebx);
    close(one.shift_mm.x, 130.0, 1e-12, "EBX by the head's z");
    close(one.shift_mm.z, -60.0, 1e-12, "EBX by the head's x");
}
