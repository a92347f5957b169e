//! Light past the limb of a cylinder: Fock's integral over the half shadow (the Pekeris function).
//!
//! With w = Ai - iBi, w̄ = Ai + iBi and a(t) = (Ai' + q Ai)/(w' + q w) of a surface ∂u/∂ν = q u,
//!
//! ```text
//! P(s) = ∫₀^∞ a e^(-ist) dt + ∫₋∞⁰ (a - 1/2) e^(-ist) dt,   a - 1/2 = 1/2 (w̄' + q w̄)/(w' + q w)
//! ```
//!
//! (V. A. Fock, Electromagnetic Diffraction and Propagation Problems, 1965; P. H. Pathak, Radio
//! Sci. 14 (1979) 419.) Right of 0 the integrand falls like e^(-4/3 t^(3/2)). Left of it a - 1/2
//! only oscillates: the path leaves the axis at -T for -T - x e^(-iπ/3), where it falls faster than
//! e^(-ist) grows as long as 2√T > s. The nodes and their weights hold for every s up to the
//! largest, so that a table of P costs one exponential a node.

use std::f64::consts::FRAC_PI_3;

use super::airy::{C, airy, unit};
use super::surface::Boundary;
use crate::render::optics::edge_spread::quadrature::{kept_rule, panels};

/// End of the path right of 0: |a| is e^(-36) of its start there.
const RIGHT: f64 = 9.0;

/// End of the rotated path: e^(-11 √3) or less of its start.
const LEFT: f64 = 11.0;

/// Nodes of a panel, and its largest phase.
const NODES: usize = 16;
const PANEL_PHASE: f64 = 6.0;

/// Longest panel: the Airy functions have the scale 1.
const PANEL: f64 = 1.0;

/// P's phase over a step of the table, and points of the polynomial through it, which errs by
/// .06⁶·(.5·1.5·2.5)²/6! = 2e-10.
const STEP_PHASE: f64 = 0.06;
const POINTS: usize = 6;

/// P(s) over an even grid.
#[derive(Clone, Debug)]
pub(crate) struct HalfShadow {
    from: f64,
    per_step: f64,
    values: Vec<C>,
}

impl HalfShadow {
    /// P of a surface (in the limb's own lengths) for |s| ≤ `largest`.
    pub(crate) fn new(surface: Boundary, largest: f64) -> Self {
        let turn = 0.25 * largest * largest + 1.0;
        let nodes = path(surface, largest, turn);
        let step = STEP_PHASE / (turn + 1.0);
        let margin = POINTS as f64 * step;
        let count = (2.0 * (largest + margin) / step).ceil() as usize + 1;
        let from = -0.5 * step * (count - 1) as f64;
        let mut values = vec![C::new(0.0, 0.0); count];
        for (t, weight) in nodes {
            let along = -C::i() * t;
            let (mut term, factor) = (weight * (along * from).exp(), (along * step).exp());
            for value in &mut values {
                *value += term;
                term *= factor;
            }
        }
        Self { from, per_step: 1.0 / step, values }
    }

    /// No half shadow: a thin screen's.
    pub(crate) fn none(largest: f64) -> Self {
        let values = vec![C::new(0.0, 0.0); POINTS];
        Self { from: -largest, per_step: (POINTS - 1) as f64 / (2.0 * largest), values }
    }

    /// The mean of several, which reach equally far.
    pub(crate) fn mean(all: &[Self]) -> Self {
        let share = 1.0 / all.len() as f64;
        let mut mean = all[0].clone();
        for (i, value) in mean.values.iter_mut().enumerate() {
            *value = all.iter().map(|p| p.values[i]).sum::<C>() * share;
        }
        mean
    }

    /// P(s).
    pub(crate) fn at(&self, s: f64) -> C {
        let place = (s - self.from) * self.per_step;
        let first = (place as usize).saturating_sub(POINTS / 2 - 1).min(self.values.len() - POINTS);
        let weights: [f64; POINTS] = lagrange(place - first as f64);
        let window = &self.values[first..first + POINTS];
        window.iter().zip(weights).map(|(v, w)| v * w).sum()
    }
}

/// Weights of the polynomial through the values at 0..N-1, at a place between them.
pub(crate) fn lagrange<const N: usize>(place: f64) -> [f64; N] {
    let mut weights = [1.0; N];
    let (mut before, mut after) = (1.0, 1.0);
    for i in 0..N {
        let back = N - 1 - i;
        weights[i] *= before;
        weights[back] *= after;
        // Π (place - j)/(i - j) over j < i, and over j > i as Π (j - place)/(j - i).
        before *= (place - i as f64) / (i + 1) as f64;
        after *= (back as f64 - place) / (i + 1) as f64;
    }
    weights
}

/// Nodes t of the path and a(t), or a(t) - 1/2 left of 0, times their weights.
fn path(surface: Boundary, largest: f64, turn: f64) -> Vec<(C, C)> {
    let rule = kept_rule(NODES);
    let [right, level, rotated] = [
        panels(0.0, RIGHT, &[], PANEL.min(PANEL_PHASE / largest), &rule),
        panels(-turn, 0.0, &[], PANEL.min(PANEL_PHASE / (largest + 2.0 * turn.sqrt())), &rule),
        panels(0.0, LEFT, &[], PANEL.min(PANEL_PHASE / (largest + 2.0 * (turn + LEFT).sqrt())), &rule),
    ];
    let out = unit(-FRAC_PI_3);
    let ahead = right.into_iter().map(|(t, w)| {
        let t = C::new(t, 0.0);
        (t, passed(surface, t, airy(t)) * w)
    });
    let behind = level.into_iter().map(|(t, w)| (C::new(t, 0.0), C::new(w, 0.0)));
    let away = rotated.into_iter().map(|(x, w)| (-turn - out * x, out * w));
    let left = behind.chain(away).map(|(t, w)| (t, passed(surface, t, conjugate_wave(t)) * w * 0.5));
    ahead.chain(left).collect()
}

/// (α v' + β v)/(α w' + β w) of a wave v.
fn passed(surface: Boundary, t: C, [value, slope]: [C; 2]) -> C {
    let turn = unit(2.0 * FRAC_PI_3);
    // w = 2e^(-iπ/3) Ai(te^(2πi/3)), w' gains e^(2πi/3).
    let [outgoing, along] = airy(t * turn);
    let front = unit(-FRAC_PI_3) * 2.0;
    let below = front * (surface.slope * along * turn + surface.value * outgoing);
    (surface.slope * slope + surface.value * value) / below
}

/// w̄ = 2e^(iπ/3) Ai(te^(-2πi/3)) and its derivative.
fn conjugate_wave(t: C) -> [C; 2] {
    let turn = unit(-2.0 * FRAC_PI_3);
    let [value, slope] = airy(t * turn);
    let front = unit(FRAC_PI_3) * 2.0;
    [front * value, front * slope * turn]
}
