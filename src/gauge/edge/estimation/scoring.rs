//! One edge by maximum likelihood: Fisher scoring with tabulated weights.

use wide::f32x4;

use super::scoring_table::{CorePhase, Phase, Table};
use crate::gauge::edge::image::window_layout::{PHASE_REACH, half};

/// A step below this many phases ends the scoring: the remainder is of second order, below 7e-5 px
/// at σ = 0.5 px.
const SETTLED: f32 = 0.75;

/// Result of scoring an edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// Place, px from the central pixel.
    pub(crate) x: f32,
    /// Residual Σ r²·v_mid/v, in units of contrast².
    pub(crate) residual: f32,
    /// Index of the phase of the last step.
    pub(crate) index: usize,
}

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

/// Sums in eight lanes, the same order of additions on every machine.
#[derive(Clone, Copy)]
struct Lanes(f32x4, f32x4);

impl Lanes {
    const ZERO: Self = Self(f32x4::ZERO, f32x4::ZERO);

    #[inline(always)]
    fn load(values: &[f32; 8]) -> Self {
        let [a, b, c, d, e, f, g, h] = *values;
        Self(f32x4::from([a, b, c, d]), f32x4::from([e, f, g, h]))
    }

    #[inline(always)]
    fn with(self, other: Self, f: impl Fn(f32x4, f32x4) -> f32x4) -> Self {
        Self(f(self.0, other.0), f(self.1, other.1))
    }

    /// Sums of the lanes i and i + 4.
    #[inline(always)]
    fn halves(self) -> f32x4 {
        self.0 + self.1
    }

    #[inline(always)]
    fn total(self) -> f32 {
        total(self.halves())
    }
}

/// Sum of four parts.
#[inline(always)]
fn total(parts: f32x4) -> f32 {
    let four = parts.to_array();
    (four[0] + four[2]) + (four[1] + four[3])
}

/// [`total`] of four at once.
#[inline(always)]
fn totals(parts: [f32x4; 4]) -> f32x4 {
    let [a, b, c, d] = f32x4::transpose(parts);
    (a + c) + (b + d)
}

/// Sum of products.
#[inline(always)]
pub(crate) fn dot(a: &[f32], b: &[f32]) -> f32 {
    dot_above(a, 0.0, b)
}

/// Σ (a − level)·b.
#[inline(always)]
pub(crate) fn dot_above(a: &[f32], level: f32, b: &[f32]) -> f32 {
    let (mut sums, level) = (Lanes::ZERO, Lanes(f32x4::splat(level), f32x4::splat(level)));
    // Where the caller's length is a constant the loop unrolls.
    let (a, b) = (a[..b.len()].as_chunks::<8>().0, b.as_chunks::<8>().0);
    for (a, b) in a.iter().zip(b) {
        let above = Lanes::load(a).with(level, |a, level| a - level);
        sums = sums.with(above.with(Lanes::load(b), |a, b| a * b), |s, p| s + p);
    }
    sums.total()
}

/// Σ (a − b)²·w.
#[inline(always)]
fn weighted_square(a: &[f32], b: &[f32], w: &[f32]) -> f32 {
    let length = a.len();
    let (b, w) = (b[..length].as_chunks::<8>().0, w[..length].as_chunks::<8>().0);
    let mut sums = Lanes::ZERO;
    for ((a, b), w) in a.as_chunks::<8>().0.iter().zip(b).zip(w) {
        let r = Lanes::load(a).with(Lanes::load(b), |a, b| a - b);
        sums = sums.with(r.with(Lanes::load(w), |r, w| r * r * w), |s, p| s + p);
    }
    sums.total()
}

/// Grey values to shadow 0, light 1; gives the edge by the area of the light, px from the central
/// pixel.
#[inline(always)]
pub(crate) fn normalise(window: &[f32], dark: f32, contrast: f32, out: &mut [f32]) -> f32 {
    let (scale, dark) = (f32x4::splat(1.0 / contrast), f32x4::splat(dark));
    let length = out.len();
    let mut sums = Lanes::ZERO;
    for (n, m) in out.as_chunks_mut::<8>().0.iter_mut().zip(window[..length].as_chunks::<8>().0) {
        let m = Lanes::load(m);
        let part = Lanes((m.0 - dark) * scale, (m.1 - dark) * scale);
        let ([a, b, c, d], [e, f, g, h]) = (part.0.to_array(), part.1.to_array());
        *n = [a, b, c, d, e, f, g, h];
        sums = sums.with(part, |s, p| s + p);
    }
    (length - half(length)) as f32 - 0.5 - sums.total()
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

/// Grey values of a core to shadow 0, light 1; and the edge by the area of the light, in four
/// parts.
#[inline(always)]
fn normalise_core<const C: usize>(window: &[[f32; 8]; C], dark: f32, scale: f32) -> ([Lanes; C], f32x4) {
    let (dark, scale) = (f32x4::splat(dark), f32x4::splat(scale));
    let (mut core, mut area) = ([Lanes::ZERO; C], Lanes::ZERO);
    for (n, m) in core.iter_mut().zip(window) {
        let m = Lanes::load(m);
        *n = Lanes((m.0 - dark) * scale, (m.1 - dark) * scale);
        area = area.with(*n, |s, n| s + n);
    }
    (core, area.halves())
}

/// Σ n·w over a core, in four parts.
#[inline(always)]
fn core_dot<const C: usize>(core: &[Lanes; C], weights: &[[f32; 8]; C]) -> f32x4 {
    let mut sums = Lanes::ZERO;
    for (n, w) in core.iter().zip(weights) {
        sums = sums.with(n.with(Lanes::load(w), |n, w| n * w), |s, p| s + p);
    }
    sums.halves()
}

/// Σ (n − E)²·v_mid/v over a core, in four parts.
#[inline(always)]
fn core_square<const C: usize>(core: &[Lanes; C], phase: &CorePhase<C>) -> f32x4 {
    let mut sums = Lanes::ZERO;
    for ((n, e), v) in core.iter().zip(&phase.values).zip(&phase.inverse_variances) {
        let r = n.with(Lanes::load(e), |n, e| n - e);
        sums = sums.with(r.with(Lanes::load(v), |r, v| r * r * v), |s, p| s + p);
    }
    sums.halves()
}

/// Position of an edge by the area of a core without light, px.
const fn empty_core<const C: usize>() -> f32 {
    (4 * C + 1) as f32 - 0.5
}

/// Scores the core of a window, `C` eights of it, until the edge stays at its phase; `None` where
/// it leaves the middle or does not converge at once: then [`locate`] takes the whole window.
#[inline(always)]
pub(crate) fn locate_core<const C: usize>(
    window: &[f32],
    dark: f32,
    contrast: f32,
    table: &Table,
    phases: &[CorePhase<C>],
) -> Option<Place> {
    let window = window.as_chunks::<8>().0.first_chunk::<C>()?;
    let (core, area) = normalise_core(window, dark, 1.0 / contrast);
    let mut x = empty_core::<C>() - total(area) - table.centroid;
    for count in 0..4 {
        if !(x.abs() <= PHASE_REACH) {
            return None;
        }
        let index = table.index(x);
        let phase = phases.get(index)?;
        let step = total(core_dot(&core, &phase.weights)) - phase.scalars.offset;
        x = phase.scalars.phase + step;
        if count > 0 && step.abs() * table.per_px <= SETTLED {
            let square = total(core_square(&core, phase));
            let residual = (square - step * step * phase.scalars.information).max(0.0);
            return Some(Place { x, residual, index });
        }
    }
    None
}

/// Four located edges.
pub(crate) struct Four<'a, const C: usize> {
    /// Places, px from the central pixels.
    pub(crate) x: f32x4,
    /// Residuals Σ r²·v_mid/v, in units of contrast².
    pub(crate) residual: f32x4,
    /// The phases of the last step.
    pub(crate) phases: [&'a CorePhase<C>; 4],
}

/// Four neighbouring windows, a lane each.
pub(crate) struct FourWindows<'a> {
    /// Pixels from the first window on.
    pub(crate) pixels: &'a [f32],
    /// Pixels of a window before its core.
    pub(crate) skip: usize,
    /// Pixels of a window.
    pub(crate) width: usize,
    /// Levels of the shadow, counts.
    pub(crate) dark: f32x4,
    /// Light less shadow, counts.
    pub(crate) contrast: f32x4,
}

/// [`locate_core`] of four neighbouring windows with the same operations a lane; `None` unless all
/// of them settle.
#[inline(always)]
pub(crate) fn locate_four<'a, const C: usize>(
    windows: &FourWindows<'_>,
    table: &Table,
    phases: &'a [CorePhase<C>],
) -> Option<Four<'a, C>> {
    let FourWindows { pixels, skip, width, dark, contrast } = *windows;
    let (dark, scale) = (dark.to_array(), (f32x4::ONE / contrast).to_array());
    let mut cores = [[Lanes::ZERO; C]; 4];
    let mut parts = [f32x4::ZERO; 4];
    for k in 0..4 {
        let window = pixels.get(k * width + skip..)?.as_chunks::<8>().0.first_chunk::<C>()?;
        (cores[k], parts[k]) = normalise_core(window, dark[k], scale[k]);
    }
    let mut x = f32x4::splat(empty_core::<C>()) - totals(parts) - f32x4::splat(table.centroid);
    let (mut step, mut phase, mut settled) = (f32x4::ZERO, f32x4::ZERO, f32x4::ZERO);
    let mut chosen = [phases.first()?; 4];
    for count in 0..4 {
        if !x.abs().simd_le(f32x4::splat(PHASE_REACH)).all() {
            return None;
        }
        // A settled lane stays at its phase, and so at its place.
        let at = settled.select(phase, x);
        let place = (at + f32x4::splat(PHASE_REACH)) * f32x4::splat(table.per_px) + f32x4::splat(0.5);
        for (k, index) in place.fast_trunc_int().to_array().into_iter().enumerate() {
            chosen[k] = phases.get(index as usize)?;
            parts[k] = core_dot(&cores[k], &chosen[k].weights);
        }
        let [a, b, c, d] = chosen;
        let (a, b, c, d) = (&a.scalars, &b.scalars, &c.scalars, &d.scalars);
        step = totals(parts) - f32x4::from([a.offset, b.offset, c.offset, d.offset]);
        phase = f32x4::from([a.phase, b.phase, c.phase, d.phase]);
        x = phase + step;
        if count > 0 {
            settled = (step.abs() * f32x4::splat(table.per_px)).simd_le(f32x4::splat(SETTLED));
            if settled.all() {
                break;
            }
        }
    }
    if !settled.all() {
        return None;
    }
    for k in 0..4 {
        parts[k] = core_square(&cores[k], chosen[k]);
    }
    let [a, b, c, d] = chosen;
    let (a, b, c, d) = (&a.scalars, &b.scalars, &c.scalars, &d.scalars);
    let information = f32x4::from([a.information, b.information, c.information, d.information]);
    let residual = (totals(parts) - step * step * information).fast_max(f32x4::ZERO);
    Some(Four { x, residual, phases: chosen })
}

/// Scores until the edge stays at its phase; `None` where it leaves the window's middle or never
/// settles.
#[inline(always)]
pub(crate) fn locate<'a>(normalised: &mut [f32], table: &'a Table, start: f32) -> Option<Located<'a>> {
    let mut x = start.clamp(-PHASE_REACH, PHASE_REACH);
    let mut moved = 0_i32;
    for count in 0..table.limits.most_steps {
        let phase = table.phase(x);
        let full = dot(phase.weights, normalised) - phase.scalars.offset;
        if !full.is_finite() {
            return None;
        }
        // Far from the edge the full step may diverge.
        let step = full.clamp(-0.5, 0.5);
        x = phase.scalars.phase + step;
        // Scoring converges by a factor of ρ = |1 − observed/expected information| a step (0.3 at
        // the lowest SNR), so an edge on the border of two cells may hop between them: then a step
        // of a cell is as good as none.
        let settled = if count < 4 { SETTLED } else { 2.0 * SETTLED } / table.per_px;
        if count > 0 && step.abs() <= settled {
            let square = weighted_square(normalised, phase.values, phase.inverse_variances);
            let residual = (square - step * step * phase.scalars.information).max(0.0);
            return Some(Located { x: x + moved as f32, step, phase, residual });
        }
        if x.abs() > PHASE_REACH {
            let shift = if x > 0.0 { 1 } else { -1 };
            moved += shift;
            if moved.abs() > table.limits.most_shift_px {
                return None;
            }
            shift_window(normalised, shift);
            x = (x - shift as f32).clamp(-PHASE_REACH, PHASE_REACH);
        }
    }
    None
}
