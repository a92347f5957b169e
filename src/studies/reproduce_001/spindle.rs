//! What would separate the spindle's error motion, which the paper leaves in its readings: three
//! probes.

use std::f64::consts::TAU;

use crate::machine::spindle::{three_probe, three_probe_weights};
use crate::studies::reproduction::Row;

/// Angles of the second and third probe to the first, degrees, and the readings a turn.
const ANGLES_DEG: [usize; 2] = [47, 146];
const READINGS: usize = 360;
/// Orders that a form is asked for.
const ORDERS: std::ops::RangeInclusive<usize> = 2..=50;
/// Angles of thirds of a turn, which many use.
const THIRDS_DEG: [usize; 2] = [120, 240];
/// Weight below which an order drowns: ten times the noise.
const SMALL: f64 = 0.1;

pub(super) fn rows() -> Vec<Row> {
    let weights = |angles: [usize; 2]| -> Vec<(usize, f64)> {
        ORDERS.filter_map(|order| Some((order, three_probe_weights(angles, READINGS, order)?))).collect()
    };
    let (own, thirds) = (weights(ANGLES_DEG), weights(THIRDS_DEG));
    let (order, least) = own.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, f64::NAN));
    let lost: Vec<String> =
        thirds.iter().filter(|(_, w)| *w < SMALL).map(|(order, _)| order.to_string()).collect();
    let turns = [0, ANGLES_DEG[0], ANGLES_DEG[1]].map(reading);
    let found = three_probe([&turns[0], &turns[1], &turns[2]], ANGLES_DEG);
    let off = found.as_ref().map_or(f64::NAN, |found| {
        (0..READINGS).map(|i| (found.separation.motion[i] - motion(i)[0]).abs()).fold(0.0, f64::max)
    });
    let hidden = found.map_or(0, |found| found.hidden.len());
    vec![
        Row::ours(
            ("spindle.off", "largest error of the motion that three probes without noise separate", "µm"),
            off,
            format!("form and motion of orders 2 to 12, up to .05 µm; {hidden} order is in no reading"),
        ),
        Row::ours(
            (
                "spindle.three_probes",
                "least weight of the orders 2 to 50 of three probes at 0°, 47° and 146°",
                "",
            ),
            least,
            format!(
                "order {order}; the form of that order has the probe's noise over it. The first order is in none: eccentricity"
            ),
        ),
        Row::ours(
            ("spindle.thirds", "orders of 2 to 50 that three probes at thirds of a turn do not hold", ""),
            lost.len() as f64,
            format!("orders {}", lost.join(", ")),
        ),
    ]
}

/// Waves of a form, µm: order, amplitude, phase. No first order: no method holds it.
const FORM: [(usize, f64, f64); 3] = [(2, 0.05, 0.4), (3, 0.03, 1.1), (12, 0.01, 2.0)];

/// Motion of the axis along and across the first probe at a reading, µm: orders 2 and 7.
fn motion(reading: usize) -> [f64; 2] {
    let angle = |order: usize| TAU * ((order * reading) % READINGS) as f64 / READINGS as f64;
    [0.04 * angle(2).cos() + 0.01 * (angle(7) + 0.3).cos(), 0.03 * (angle(2) + 1.0).sin()]
}

/// Readings of a turn by a probe some readings round the part, µm.
fn reading(steps: usize) -> Vec<f64> {
    let alpha = TAU * steps as f64 / READINGS as f64;
    let form = |i: usize| {
        let angle = |order: usize| TAU * ((order * (i + steps)) % READINGS) as f64 / READINGS as f64;
        FORM.iter().map(|(order, size, phase)| size * (angle(*order) + phase).cos()).sum::<f64>()
    };
    let at = |i: usize| {
        let [along, across] = motion(i);
        form(i) + along * alpha.cos() + across * alpha.sin()
    };
    (0..READINGS).map(at).collect()
}
