//! What would separate the spindle's error motion, which the paper leaves in its readings: three
//! probes.

use crate::machine::spindle::three_probe_weights;
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
    let (order, least) =
        own.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, f64::NAN));
    let lost: Vec<String> =
        thirds.iter().filter(|(_, w)| *w < SMALL).map(|(order, _)| order.to_string()).collect();
    vec![
        Row::ours(
            ("spindle.three_probes", "least weight of the orders 2 to 50 of three probes at 0°, 47° and 146°", ""),
            least,
            format!("order {order}; the form of that order has the probe's noise over it. The first order is in none: eccentricity"),
        ),
        Row::ours(
            ("spindle.thirds", "orders of 2 to 50 that three probes at thirds of a turn do not hold", ""),
            lost.len() as f64,
            format!("orders {}", lost.join(", ")),
        ),
    ]
}
