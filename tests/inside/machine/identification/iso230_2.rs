//! ISO 230-2 by a table that is computed by hand.

use crate::identification::instrument::Quantity;
use crate::identification::iso230_2::positioning;
use crate::identification::reading::{Reading, Setup};
use crate::inside::machine::close;
use crate::machine::ErrorName;
use crate::machine::conditions::Direction;

/// Deviations in µm of two positions, two runs in each direction.
fn readings(rows: &[(f64, Direction, &[f64])]) -> Vec<Reading> {
    let reading = |(p, direction, values): &(f64, Direction, &[f64])| {
        let one = |(k, value): (usize, &f64)| Reading {
            quantity: Quantity::Error(ErrorName::Ezz),
            position_mm: *p,
            direction: *direction,
            run: k as u32 + 1,
            setup: Setup::Normal,
            value: 1e-3 * value,
            rows: 1,
            line: 0,
        };
        values.iter().enumerate().map(one).collect::<Vec<_>>()
    };
    rows.iter().flat_map(reading).collect()
}

#[test]
fn parameters_of_a_table_by_hand() {
    use Direction::{Backward, Forward};
    // up: means 1, 3; s √2, 0. down: means −1, 4; s 0, √2/2
    let rows = readings(&[
        (0.0, Forward, &[0.0, 2.0]),
        (50.0, Forward, &[3.0, 3.0]),
        (50.0, Backward, &[3.5, 4.5]),
        (0.0, Backward, &[-1.0, -1.0]),
    ]);
    let found = positioning(&rows, 1e3).unwrap();
    let (s, both) = (2.0_f64.sqrt(), found.both.unwrap());
    let (up, down) = (found.forward.unwrap(), found.backward.unwrap());
    for (name, value, wanted) in [
        ("R↑", up.r, 4.0 * s),
        ("R↓", down.r, 2.0 * s),
        // position 0: 2√2 + |2| = 4.83 and 4√2 = 5.66; position 50: √2 + 1 and 2√2
        ("R", both.r, 4.0 * s),
        ("E↑", up.e, 2.0),
        ("E↓", down.e, 5.0),
        ("E", both.e, 5.0),
        ("M", both.m, 3.5),
        ("B", both.b, 2.0),
        ("mean B", both.b_mean, 0.5),
        // 1 + 2√2 = 3.83 above 3; 1 − 2√2
        ("A↑", up.a, 4.0 * s),
        ("A↓", down.a, 4.0 + s + 1.0),
        // 4 + √2 to 1 − 2√2
        ("A", both.a, 3.0 + 3.0 * s),
    ] {
        close(value, wanted, 1e-12, name);
    }
    assert_eq!((found.positions, found.runs), (2, 2));
    assert!(found.short_of_standard[0].contains("asks for 5"), "{:?}", found.short_of_standard);
}

#[test]
fn one_direction_or_one_run_say_what_they_fall_short_of() {
    let one = readings(&[(0.0, Direction::Forward, &[1.0, 1.0, 1.0, 1.0, 2.0])]);
    let found = positioning(&one, 1e3).unwrap();
    assert!(found.both.is_none() && found.backward.is_none());
    assert_eq!(found.short_of_standard, ["one direction alone; ISO 230-2 asks for both"]);
    assert!(positioning(&readings(&[(0.0, Direction::Forward, &[1.0])]), 1e3).is_none());
}
