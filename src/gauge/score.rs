//! One edge by maximum likelihood: Fisher scoring with tabulated weights.

use super::table::{PHASE_REACH, Phase, Table};

/// Steps after which an edge that still moves is given up.
const MOST_STEPS: usize = 10;

/// Pixels by which a window may be off its edge: its flat ends stand in for what the move would have to read.
const MOST_SHIFT: i32 = 3;

/// A located edge in window coordinates and normalised grey values.
#[derive(Clone, Copy)]
pub(crate) struct Located<'a> {
    /// Place, px from the central pixel.
    pub(crate) x: f32,
    /// Last step, px from the tabulated phase.
    pub(crate) step: f32,
    /// The phase of the last step.
    pub(crate) phase: Phase<'a>,
    /// Residual Σ r²·v_mid/v, in units of contrast².
    pub(crate) residual: f32,
}

/// Sum of products in eight lanes: the same order of additions on every machine.
pub(crate) fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut lanes = [0.0_f32; 8];
    for (a, b) in a.chunks_exact(8).zip(b.chunks_exact(8)) {
        for lane in 0..8 {
            lanes[lane] += a[lane] * b[lane];
        }
    }
    sum_lanes(&lanes)
}

fn sum_lanes(l: &[f32; 8]) -> f32 {
    ((l[0] + l[4]) + (l[2] + l[6])) + ((l[1] + l[5]) + (l[3] + l[7]))
}

/// Σ (a − b)²·w in eight lanes.
fn weighted_square(a: &[f32], b: &[f32], w: &[f32]) -> f32 {
    let mut lanes = [0.0_f32; 8];
    for ((a, b), w) in a.chunks_exact(8).zip(b.chunks_exact(8)).zip(w.chunks_exact(8)) {
        for lane in 0..8 {
            let r = a[lane] - b[lane];
            lanes[lane] += r * r * w[lane];
        }
    }
    sum_lanes(&lanes)
}

/// Grey values to shadow 0, light 1.
pub(crate) fn normalise(window: &[f32], dark: f32, contrast: f32, out: &mut [f32]) {
    let scale = 1.0 / contrast;
    for (n, m) in out.iter_mut().zip(window) {
        *n = (m - dark) * scale;
    }
}

/// Moves the window one pixel along, repeating the flat pixel at its end.
fn shift_window(normalised: &mut [f32], shift: i32) {
    let last = normalised.len() - 1;
    if shift > 0 {
        normalised.copy_within(1.., 0);
    } else {
        normalised.copy_within(..last, 1);
    }
}

/// Scores until the edge stays at its phase; `None` where it leaves the window's middle or never settles.
pub(crate) fn locate<'a>(normalised: &mut [f32], table: &'a Table, start: f32) -> Option<Located<'a>> {
    let mut x = start.clamp(-PHASE_REACH, PHASE_REACH);
    let mut moved = 0_i32;
    for count in 0..MOST_STEPS {
        let phase = table.phase(x);
        let full = dot(phase.weights, normalised) - phase.scalars.offset;
        if !full.is_finite() {
            return None;
        }
        // Far from the edge the step is not to be trusted in full.
        let step = full.clamp(-0.5, 0.5);
        x = phase.scalars.phase + step;
        // Scoring converges by a factor of ρ = |1 − observed/expected information| a step (0.3 at the lowest SNR), so an
        // edge on the border of two cells may hop between them: then a step of a cell is as good as none.
        let settled = if count < 3 { 0.0080 } else { 0.0235 };
        if step.abs() <= settled {
            let square = weighted_square(normalised, phase.values, phase.inverse_variances);
            let residual = (square - step * step * phase.scalars.information).max(0.0);
            return Some(Located { x: x + moved as f32, step, phase, residual });
        }
        if x.abs() > PHASE_REACH {
            let shift = if x > 0.0 { 1 } else { -1 };
            moved += shift;
            if moved.abs() > MOST_SHIFT {
                return None;
            }
            shift_window(normalised, shift);
            x = (x - shift as f32).clamp(-PHASE_REACH, PHASE_REACH);
        }
    }
    None
}
