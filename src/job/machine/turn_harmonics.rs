//! What repeats over a turn of the spindle, as undulations.

use std::f64::consts::TAU;

/// Angles of a turn at which errors of the spindle are taken: undulations below half of them are
/// separable.
pub(super) const ANGLES: usize = 720;
/// Amplitude below which an undulation is left out, mm: .01 nm, far below the rounding of an edge's
/// row to f32 (6e-5 px at row 1000).
const LEAST_MM: f64 = 1e-8;

/// An undulation a·cos(kφ + p) of a spindle angle φ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Undulation {
    /// k, undulations a turn.
    pub order: u32,
    /// a, in the unit of the values.
    pub amplitude: f64,
    /// p, degrees.
    pub phase_deg: f64,
}

/// The spindle angles of [`ANGLES`], degrees.
pub(super) fn angles_deg() -> impl Iterator<Item = f64> {
    (0..ANGLES).map(|k| 360.0 * k as f64 / ANGLES as f64)
}

/// The undulations of order 2 and above of values (mm) at [`angles_deg`], by the discrete Fourier
/// transform. Order 0 is a shift; order 1 along one direction only moves the axis of the part.
pub(super) fn undulations(values_mm: &[f64]) -> Vec<Undulation> {
    let count = values_mm.len();
    let turn: Vec<(f64, f64)> = (0..count).map(|k| (TAU * k as f64 / count as f64).sin_cos()).collect();
    let of = |order: usize| {
        let (mut cos, mut sin) = (0.0, 0.0);
        for (k, value) in values_mm.iter().enumerate() {
            let (sin_k, cos_k) = turn[(order * k) % count];
            cos += value * cos_k;
            sin += value * sin_k;
        }
        let (cos, sin) = (2.0 * cos / count as f64, 2.0 * sin / count as f64);
        Undulation {
            order: order as u32,
            amplitude: cos.hypot(sin),
            phase_deg: (-sin).atan2(cos).to_degrees(),
        }
    };
    (2..count.div_ceil(2)).map(of).filter(|u| u.amplitude > LEAST_MM).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn undulations_come_back_with_their_phase() {
        let wave = |a: f64, order: f64, p: f64, deg: f64| a * (order * deg + p).to_radians().cos();
        let values: Vec<f64> = angles_deg()
            .map(|d| 0.5 + wave(1.0, 1.0, 3.0, d) + wave(2e-4, 3.0, 40.0, d) + wave(1e-5, 300.0, -70.0, d))
            .collect();
        let found = undulations(&values);
        assert_eq!(found.iter().map(|u| u.order).collect::<Vec<_>>(), [3, 300]);
        for (u, (a, p)) in found.iter().zip([(2e-4, 40.0), (1e-5, -70.0)]) {
            assert!((u.amplitude - a).abs() < 1e-15 && (u.phase_deg - p).abs() < 1e-7, "{u:?}");
        }
    }
}
