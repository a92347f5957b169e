//! Two-point diameters: the touches that they need, and their evaluation.

use super::settings::{ProbeSettings, Sides};
use super::touch::{Side, Touch, TouchOrder};

/// Both touches of a two-point diameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pair {
    /// Place, mm.
    pub z_mm: f64,
    /// Spindle angle of the first touch, degrees.
    pub angle_deg: f64,
    /// Number of the first touch.
    pub id: u64,
    /// Time of the first touch, ns.
    pub t_ns: u64,
    /// Sum of both indicated distances from the axis, ball included, mm; none where a touch is
    /// missing.
    pub read_mm: Option<f64>,
}

/// Touches of `count` two-point diameters at every place, pair after pair.
pub(crate) fn orders(
    settings: &ProbeSettings,
    z_mm: &[f64],
    count: usize,
    expected_mm: f64,
) -> Vec<TouchOrder> {
    let one = |z_mm: f64, i: usize| {
        let angle_deg = 180.0 * i as f64 / count.max(1) as f64;
        let first = TouchOrder { z_mm, angle_deg, side: Side::Carrier, expected_mm };
        let second = match settings.sides {
            Sides::One => TouchOrder { angle_deg: angle_deg + 180.0, ..first },
            Sides::Two => TouchOrder { side: Side::Opposite, ..first },
        };
        [first, second]
    };
    z_mm.iter().flat_map(|&z| (0..count).flat_map(move |i| one(z, i))).collect()
}

/// Touches in the order of [`orders`] as two-point diameters.
pub(crate) fn pairs(touches: &[Touch]) -> Vec<Pair> {
    let out = |t: &Touch| t.x_mm.map(|x| t.order.side.sign() * x);
    touches
        .chunks_exact(2)
        .map(|both| Pair {
            z_mm: both[0].order.z_mm,
            angle_deg: both[0].order.angle_deg,
            id: both[0].id,
            t_ns: both[0].t_ns,
            read_mm: out(&both[0]).zip(out(&both[1])).map(|(a, b)| a + b),
        })
        .collect()
}

/// Mean and variance (n − 1) of values; none for fewer than two.
pub(super) fn mean_and_scatter(values: &[f64]) -> Option<(f64, f64)> {
    let n = values.len() as f64;
    if values.len() < 2 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / n;
    Some((mean, values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)))
}
