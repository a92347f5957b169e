//! Maximum-likelihood scoring, tabulated over the sub-pixel phase.
//!
//! At phase p one Fisher-scoring step is linear in the pixels n_k = (m_k − dark)/(light − dark):
//!
//! ```text
//! x̂ = p + Σ w_k(p)·(n_k − E_k(p))      w = e_xᵀ F⁻¹ Jᵀ V⁻¹,   F = Jᵀ V⁻¹ J,   V = diag v(E_k)
//! v(E) = v_mid·[1 + κ (E − 1/2)]        noise variance, linear in the level (photon noise)
//! ```
//!
//! with J = ∂E/∂x0 alone where the levels are known (pooled along the shaft), or [∂E/∂x0, 1, E]
//! where each column has its own. So the weights and Σ w_k E_k are tabulated once and a step costs
//! one multiply-add a pixel. Phases lie 1/64 px apart; what a step leaves is at most
//! |w·E''|/2·(1/128)² < 3e-5 px at σ ≥ 0.5 px.

use crate::gauge::edge::image::window_layout::{MOST_WIDTH, PHASE_REACH, core_width, half};
use crate::gauge::edge::model::edge_spread::EdgeSpreadFunction;
use crate::gauge::edge::model::gaussian::EdgeSample;
use crate::gauge::limit::limits;

limits! {
    /// How dense the tables are, and how long an edge is followed through them.
    ScoringTableLimits = "scoring_table";
    /// Phases per pixel of the tables that place edges: what a step leaves is at most
    /// |w·E″|/2·(1/128)² < 3e-5 px at σ ≥ 0.5 px.
    fine: u32 = 64;
    /// Phases per pixel of the tables that are used only to find the blur: a step leaves
    /// (1/32)²/(1/128)² = 16 times as much of the place as in the fine ones, 5e-4 px.
    coarse: u32 = 16;
    /// Steps after which an edge that still moves is abandoned: scoring converges by a factor of
    /// 0.3 a step at the lowest SNR, so that ten take a pixel to 6e-6 px.
    most_steps: usize = 10;
    /// Pixels by which a window may be off its edge: its flat ends, five pixels and more, then
    /// replace the pixels not read.
    most_shift_px: i32 = 3;
}

/// Arrays of a phase: weights, model values, inverse variances, blur scores.
const ARRAYS: usize = 4;

/// One phase of a table.
#[derive(Clone, Copy)]
pub(crate) struct Phase<'a> {
    /// Scoring weights, px.
    pub(crate) weights: &'a [f32],
    /// Model values E_k.
    pub(crate) values: &'a [f32],
    /// v_mid/v(E_k), zero outside the fitted pixels.
    pub(crate) inverse_variances: &'a [f32],
    /// ∂E/∂σ·v_mid/v(E_k).
    pub(crate) blur_scores: &'a [f32],
    /// Scalars of the phase.
    pub(crate) scalars: &'a PhaseScalars,
    /// Sums for the blur.
    pub(crate) blur: &'a BlurScalars,
}

/// Sums that belong to a phase.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PhaseScalars {
    /// The phase p itself, px from the central pixel.
    pub(crate) phase: f32,
    /// Σ w_k E_k, px.
    pub(crate) offset: f32,
    /// Σ w_k, px: minus the sensitivity to a common level error.
    pub(crate) weight_sum: f32,
    /// Standard uncertainty for √v_mid/contrast = 1, px.
    pub(crate) unit_uncertainty: f32,
    /// Σ (∂E/∂x0)² v_mid/v, per px².
    pub(crate) information: f32,
    /// I_xσ/I_xx: what an edge moves by, against the blur fitted.
    pub(crate) lever: f32,
    /// Degrees of freedom of the residual: how many pixels lie within reach of the edge changes
    /// with the phase.
    pub(crate) freedom: f32,
}

/// Sums of a phase that only the blur needs.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BlurScalars {
    /// Σ ∂E/∂σ ∂E/∂x0 v_mid/v, per px².
    pub(crate) position: f32,
    /// Σ (∂E/∂σ)² v_mid/v, per px².
    pub(crate) own: f32,
    /// Σ ∂E/∂σ E v_mid/v, per px.
    pub(crate) offset: f32,
}

impl BlurScalars {
    /// Information on the blur where the place is not known, per px².
    pub(crate) fn information(&self, scalars: &PhaseScalars) -> f32 {
        self.own - self.position * self.position / scalars.information.max(1e-9)
    }
}

/// One phase of a window's core, `C` eights of pixels, all in one place.
#[derive(Clone, Debug)]
pub(crate) struct CorePhase<const C: usize> {
    /// Sums of the phase.
    pub(crate) scalars: PhaseScalars,
    /// Scoring weights, px.
    pub(crate) weights: [[f32; 8]; C],
    /// Model values E_k.
    pub(crate) values: [[f32; 8]; C],
    /// v_mid/v(E_k), zero outside the fitted pixels.
    pub(crate) inverse_variances: [[f32; 8]; C],
}

/// The phases of the core in its constant length, which lets the compiler unroll: 16 pixels up
/// to σ = 1.2 px, 24 up to 2.5 px.
#[derive(Clone, Debug)]
pub(crate) enum Cores {
    /// 16 pixels.
    Two(Vec<CorePhase<2>>),
    /// 24 pixels.
    Three(Vec<CorePhase<3>>),
    /// Longer ones: the whole window is used.
    Whole,
}

/// What a table is made for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tabulation {
    /// Blur, px.
    pub(crate) sigma: f64,
    /// Noise slope κ, −2 < κ < 2.
    pub(crate) kappa: f64,
    /// Pixels of the window, a multiple of 8.
    pub(crate) width: usize,
    /// Whether each column has levels of its own.
    pub(crate) free_levels: bool,
    /// Phases per pixel.
    pub(crate) per_px: u32,
}

/// All phases, one after another. Arrays apart: placing an edge reads the rows in lanes and the
/// scalars alone, the blur's only where it is fitted. [`Table::fill`] alone makes them longer, by
/// one phase each.
#[derive(Clone, Debug, Default)]
struct Phases {
    /// [`ARRAYS`] rows of the window's width a phase.
    rows: Vec<f32>,
    scalars: Vec<PhaseScalars>,
    blur: Vec<BlurScalars>,
}

/// Scoring weights for one blur and one noise slope.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    /// Blur, px.
    pub(crate) sigma: f64,
    /// Noise slope κ, −2 < κ < 2.
    pub(crate) kappa: f64,
    /// Pixels of the window, a multiple of 8; the central one is `half`.
    pub(crate) width: usize,
    /// Degrees of freedom of the residual, on the mean over the phases.
    pub(crate) freedom: f32,
    /// Phases per pixel.
    pub(crate) per_px: f32,
    /// Position of the edge by the area of the light relative to the fitted one, px into the light.
    pub(crate) centroid: f32,
    core: usize,
    cores: Cores,
    phases: Phases,
    borders: Vec<[f64; 3]>,
    /// How long an edge is followed.
    pub(crate) limits: &'static ScoringTableLimits,
}

impl Table {
    /// First pixel and number of pixels of the window's part that carries the weights.
    pub(crate) fn core(&self) -> (usize, usize) {
        if self.core >= self.width {
            (0, self.width)
        } else {
            (half(self.width) - half(self.core), self.core)
        }
    }

    /// Tabulates the weights.
    pub(crate) fn new(shape: &EdgeSpreadFunction, of: Tabulation) -> Self {
        let mut table = Self::empty();
        table.fill(shape, of);
        table.fill_core();
        // Arrays needed for the filling alone.
        table.borders = Vec::new();
        table
    }

    /// Memory held, bytes.
    pub(crate) fn bytes(&self) -> usize {
        let cores = match &self.cores {
            Cores::Two(phases) => size_of_val(&phases[..]),
            Cores::Three(phases) => size_of_val(&phases[..]),
            Cores::Whole => 0,
        };
        let Phases { rows, scalars, blur } = &self.phases;
        cores + size_of_val(&rows[..]) + size_of_val(&scalars[..]) + size_of_val(&blur[..])
    }

    /// An empty table, to be filled.
    pub(crate) fn empty() -> Self {
        Self {
            sigma: 1.0,
            kappa: 0.0,
            width: 0,
            freedom: 0.0,
            per_px: 0.0,
            centroid: 0.0,
            core: 0,
            cores: Cores::Whole,
            phases: Phases::default(),
            borders: Vec::new(),
            limits: ScoringTableLimits::get(),
        }
    }

    /// Fills all but the core, which only the placing of edges needs.
    pub(crate) fn fill(&mut self, shape: &EdgeSpreadFunction, of: Tabulation) {
        let Tabulation { sigma, kappa, width, free_levels, per_px } = of;
        let steps = (PHASE_REACH * per_px as f32) as usize;
        let count = 2 * steps + 1;
        (self.sigma, self.kappa, self.width, self.per_px) = (sigma, kappa, width, per_px as f32);
        self.core = if free_levels { width } else { core_width(shape, sigma) };
        self.centroid = match shape.is_ringed() {
            true => (width - half(width)) as f32 - 0.5 - shape.window_sum(sigma, width, half(width)) as f32,
            false => shape.centroid(sigma) as f32,
        };
        self.phases.rows.clear();
        self.phases.rows.resize(count * ARRAYS * width, 0.0);
        self.phases.scalars.clear();
        self.phases.blur.clear();
        // Every border of every pixel at every phase lies on one grid.
        let (pixel, reach) = (per_px as usize, if free_levels { width as f64 } else { shape.reach(sigma) });
        let side = half(width) * pixel + pixel / 2 + steps;
        let borders = &mut self.borders;
        shape.borders(sigma, per_px, 2 * side + 1, borders);
        let mut samples = [EdgeSample::default(); MOST_WIDTH];
        let samples = &mut samples[..width - 1];
        for index in 0..count {
            let phase = (index as f64 - steps as f64) / f64::from(per_px);
            let first = 2 * steps - index;
            for (k, sample) in samples.iter_mut().enumerate() {
                let left = first + k * pixel;
                *sample = EdgeSample::between(&borders[left], &borders[left + pixel]);
            }
            let rows = &mut self.phases.rows[index * ARRAYS * width..(index + 1) * ARRAYS * width];
            let (scalars, blur) = fill_phase(samples, phase, reach, of, rows);
            self.phases.scalars.push(scalars);
            self.phases.blur.push(blur);
        }
        self.freedom = self.mean_freedom();
    }

    /// Mean freedom over the phases of one pixel.
    fn mean_freedom(&self) -> f32 {
        let pixel = self.phases.scalars.iter().filter(|s| s.phase > -0.5 && s.phase <= 0.5);
        let (sum, count) = pixel.fold((0.0, 0.0_f32), |(sum, count), s| (sum + s.freedom, count + 1.0));
        sum / count.max(1.0)
    }

    fn fill_core(&mut self) {
        self.cores = match self.core().1 {
            16 => Cores::Two(self.core_phases()),
            24 => Cores::Three(self.core_phases()),
            _ => Cores::Whole,
        };
    }

    fn core_phases<const C: usize>(&self) -> Vec<CorePhase<C>> {
        let first = self.core().0;
        let row = |index: usize, array: usize| {
            let row = &self.phases.rows[(index * ARRAYS + array) * self.width..][..self.width];
            row[first..].as_chunks::<8>().0.first_chunk::<C>().copied().unwrap_or([[0.0; 8]; C])
        };
        let phase = |(index, scalars): (usize, &PhaseScalars)| CorePhase {
            scalars: *scalars,
            weights: row(index, 0),
            values: row(index, 1),
            inverse_variances: row(index, 2),
        };
        self.phases.scalars.iter().enumerate().map(phase).collect()
    }

    /// The phases of the core.
    pub(crate) fn cores(&self) -> &Cores {
        &self.cores
    }

    /// Index of the phase nearest to `x` px from the central pixel.
    #[inline(always)]
    pub(crate) fn index(&self, x: f32) -> usize {
        // Rounding by truncation: the argument is never negative.
        let index = ((x + PHASE_REACH) * self.per_px + 0.5).max(0.0) as usize;
        index.min(self.phases.scalars.len() - 1)
    }

    /// Scalars of a phase.
    #[inline(always)]
    pub(crate) fn scalars(&self, index: usize) -> &PhaseScalars {
        &self.phases.scalars[index]
    }

    /// The phase nearest to `x` px from the central pixel.
    pub(crate) fn phase(&self, x: f32) -> Phase<'_> {
        let index = self.index(x);
        let width = self.width;
        let rows = &self.phases.rows[index * ARRAYS * width..(index + 1) * ARRAYS * width];
        let (weights, rows) = rows.split_at(width);
        let (values, rows) = rows.split_at(width);
        let (inverse_variances, blur_scores) = rows.split_at(width);
        Phase {
            weights,
            values,
            inverse_variances,
            blur_scores,
            scalars: &self.phases.scalars[index],
            blur: &self.phases.blur[index],
        }
    }
}

fn fill_phase(
    samples: &[EdgeSample],
    phase: f64,
    reach: f64,
    of: Tabulation,
    rows: &mut [f32],
) -> (PhaseScalars, BlurScalars) {
    let Tabulation { kappa, width, free_levels, .. } = of;
    let centre = half(width) as f64;
    let inverse_variance = |k: usize| {
        let inside = (k as f64 - centre - phase).abs() <= reach;
        if inside { 1.0 / (1.0 + kappa * (samples[k].value - 0.5)).max(1e-3) } else { 0.0 }
    };
    let mut fisher = nalgebra::Matrix3::<f64>::zeros();
    let mut scalars = PhaseScalars { phase: phase as f32, ..PhaseScalars::default() };
    let (mut information, mut blur) = (0.0, [0.0; 3]);
    let mut fitted = 0.0;
    for (k, sample) in samples.iter().enumerate() {
        let iv = inverse_variance(k);
        fitted += if iv > 0.0 { 1.0 } else { 0.0 };
        if free_levels {
            let gradient = nalgebra::Vector3::new(sample.by_position, 1.0, sample.value);
            fisher += gradient * gradient.transpose() * iv;
        }
        information += iv * sample.by_position * sample.by_position;
        blur[0] += iv * sample.by_position * sample.by_sigma;
        blur[1] += iv * sample.by_sigma * sample.by_sigma;
        blur[2] += iv * sample.by_sigma * sample.value;
        rows[width + k] = sample.value as f32;
        rows[2 * width + k] = iv as f32;
        rows[3 * width + k] = (iv * sample.by_sigma) as f32;
    }
    fisher[(0, 0)] = information;
    let row = position_row(&fisher, free_levels);
    let (mut offset, mut sum) = (0.0, 0.0);
    for (k, sample) in samples.iter().enumerate() {
        let weight = (row[0] * sample.by_position + row[1] + row[2] * sample.value) * inverse_variance(k);
        offset += weight * sample.value;
        sum += weight;
        rows[k] = weight as f32;
    }
    scalars.offset = offset as f32;
    scalars.weight_sum = sum as f32;
    scalars.unit_uncertainty = row[0].max(0.0).sqrt() as f32;
    scalars.information = information as f32;
    scalars.lever = (blur[0] / information) as f32;
    scalars.freedom = fitted - if free_levels { 3.0 } else { 1.0 };
    let [position, own, offset] = blur.map(|sum| sum as f32);
    (scalars, BlurScalars { position, own, offset })
}

/// First row of the inverse Fisher matrix, of the position alone or of position and both levels.
fn position_row(fisher: &nalgebra::Matrix3<f64>, free_levels: bool) -> nalgebra::Vector3<f64> {
    let alone = nalgebra::Vector3::new(1.0 / fisher[(0, 0)], 0.0, 0.0);
    if !free_levels {
        return alone;
    }
    fisher.try_inverse().map_or(alone, |inverse| inverse.row(0).transpose())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauge::edge::image::window_layout::window_width;

    #[test]
    fn one_step_lands_on_a_noise_free_edge() {
        for free in [false, true] {
            let width = window_width(&EdgeSpreadFunction::Gaussian, 0.8);
            let of = Tabulation { sigma: 0.8, kappa: 1.2, width, free_levels: free, per_px: 64 };
            let table = Table::new(&EdgeSpreadFunction::Gaussian, of);
            for x0 in [-0.5, -0.123, 0.301] {
                let mut samples = vec![EdgeSample::default(); table.width - 1];
                EdgeSpreadFunction::Gaussian.samples(-(half(table.width) as f64), x0, 0.8, &mut samples);
                let phase = table.phase(x0 as f32);
                let step: f64 =
                    samples.iter().zip(phase.weights).map(|(s, w)| f64::from(*w) * s.value).sum::<f64>()
                        - f64::from(phase.scalars.offset);
                let found = f64::from(phase.scalars.phase) + step;
                assert!((found - x0).abs() < 3e-5, "{found} {x0}");
            }
        }
    }

    #[test]
    fn information_matches_the_closed_form() {
        // physics.md: J = erf(1/2σ) − (2σ/√π)(1 − exp(−1/4σ²)), additive noise, all pixels.
        let sigma: f64 = 0.9;
        let j = libm::erf(0.5 / sigma)
            - 2.0 * sigma / std::f64::consts::PI.sqrt() * (1.0 - (-0.25 / sigma / sigma).exp());
        let of = Tabulation { sigma, kappa: 0.0, width: 32, free_levels: false, per_px: 64 };
        let table = Table::new(&EdgeSpreadFunction::Gaussian, of);
        let mean: f32 =
            (0..64).map(|i| table.phase((i as f32 - 32.0) / 64.0).scalars.information).sum::<f32>() / 64.0;
        assert!((f64::from(mean) / j - 1.0).abs() < 1e-3, "{mean} {j}");
    }
}
