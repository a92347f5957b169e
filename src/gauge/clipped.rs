//! Edges whose bright field is clipped at the end of the grey scale: censored maximum likelihood.
//!
//! A pixel below the clip tells its grey value, one at the clip only that it lies above (Tobin's model). With
//! α = (clip − μ)/s the scores by the mean μ are (m − μ)/s² below and h(α)/s at the clip, h = φ/(1 − Φ) (hazard), and
//! the expected information per pixel is [Φ(α) − α φ(α) + φ(α) h(α)]/s². The true light level lies above the clip;
//! it, the blur and the dark level are estimated once a frame from many columns, the position of each column with them.
//!
//! Where most of the light is clipped, the flank alone cannot tell a higher light from a wider blur (real edges
//! are not Gaussian in their feet, and the fit would wander by half a pixel between frames). Then the light is taken at
//! 1.05 times the clip, and what the edge would move by at 1.5 times goes into the shared uncertainty. The light is the same at both edges,
//! so that their errors add up in a width: each states √2 of its own, whose root sum of squares is that sum. Light beyond that range moves
//! widths by more than is stated (by 2.0 u at 1.6 times the clip, 2.5 u at 1.75, 3 u at 2, 4 u at 2.5, 5 to 7 u at 4, for blurs from 0.6 to
//! 2 px): where light of 1.75, 2.5 or 4 times the clip explains the edges significantly better than 1.5 times does, the side is
//! refused as saturated, and so it is where its flank seems sharper than a lens makes one. Then U (k = 2) of an accepted width holds up to 1.5
//! times the clip (2.05 u at 1.6), and next to nothing beyond is accepted.

use nalgebra::{Matrix4, SMatrix, Vector4};

use super::edges::{Edge, EdgeState};
use super::model::{EdgeSample, column_sigma, edge_samples, phi_cdf, phi_pdf};
use super::table::half;
use super::window::Windows;
use crate::profile::Reason;

/// Columns that teach the frame's levels and blur.
const TEACHERS: usize = 64;
/// The light is looked for up to this multiple of the clip.
const BRIGHTEST: f64 = 1.5;
/// Light, as multiples of the clip, that must not explain the edges better than [`BRIGHTEST`] does.
const TOO_BRIGHT: [f64; 3] = [1.75, 2.5, 4.0];
/// Blur under the light assumed below which the flank is too steep for a lens, px: light of 1.6 times the clip makes so much of a blur of
/// 0.6 px, twice the clip of 0.8 px.
const SHARP_PX: f64 = 0.4;
/// Logarithm of the likelihood ratio from which it does: five standard deviations.
const BETTER: f64 = 12.5;
/// Light taken where the frame does not tell, as a multiple of the clip.
const ASSUMED: f64 = 1.05;
/// Fraction of clipped flat light pixels above which the frame does not tell the light: what is not clipped then is a
/// darker corner, not the light beside the edge.
const BLIND: f64 = 0.5;

/// The frame's side as the censored fit sees it.
#[derive(Clone, Copy, Debug)]
struct Model {
    dark: f64,
    light: f64,
    sigma: f64,
    /// Variance of the residuals, counts², the same for all pixels: real feet and flanks miss the Gaussian model by more
    /// than their noise, and photon weights would let the dark foot place the edge.
    variance: f64,
    clip: f64,
    /// Whether the light is fitted.
    free_light: bool,
}

/// Scores and information of one column for (x, dark, light, σ).
struct Score {
    gradient: Vector4<f64>,
    information: Matrix4<f64>,
    chi2: f64,
    /// Expected number of pixels that tell a grey value.
    telling: f64,
    /// Logarithm of the likelihood.
    log_likelihood: f64,
}

impl Model {
    fn score(&self, window: &[f32], x: f64, sigma: f64) -> Score {
        let used = window.len() - 1;
        let mut samples = [EdgeSample::default(); 72];
        let samples = &mut samples[..used];
        edge_samples(-(half(window.len()) as f64), x, sigma, samples);
        let s = self.variance.sqrt();
        let contrast = self.light - self.dark;
        let mut score = Score {
            gradient: Vector4::zeros(),
            information: Matrix4::zeros(),
            chi2: 0.0,
            telling: 0.0,
            log_likelihood: 0.0,
        };
        for (sample, m) in samples.iter().zip(window) {
            let mean = self.dark + contrast * sample.value;
            let alpha = (self.clip - 0.5 - mean) / s;
            let (cdf, pdf) = (phi_cdf(alpha), phi_pdf(alpha));
            // Far below the clip the hazard is α (Mills' ratio).
            let hazard = if alpha < 6.0 { pdf / (1.0 - cdf) } else { alpha };
            let residual = if f64::from(*m) >= self.clip { hazard } else { (f64::from(*m) - mean) / s };
            let information = (cdf - alpha * pdf + pdf * hazard).clamp(0.0, 1.0);
            let by = Vector4::new(
                contrast * sample.by_position,
                1.0 - sample.value,
                sample.value,
                contrast * sample.by_sigma,
            ) / s;
            score.gradient += by * residual;
            score.information += by * by.transpose() * information;
            if f64::from(*m) < self.clip {
                score.chi2 += residual * residual;
                score.log_likelihood -= 0.5 * residual * residual + s.ln();
            } else {
                // P(above the clip) = φ/h.
                score.log_likelihood += pdf.max(1e-300).ln() - hazard.max(1e-300).ln();
            }
            score.telling += cdf;
        }
        score
    }

    /// Position of a column by Fisher scoring; `None` where it does not settle.
    fn position(&self, window: &[f32], start: f64, sigma: f64) -> Option<(f64, Score)> {
        let mut x = start;
        for _ in 0..20 {
            let score = self.score(window, x, sigma);
            let step = score.gradient[0] / score.information[(0, 0)];
            if !step.is_finite() {
                return None;
            }
            x += step.clamp(-0.5, 0.5);
            if x.abs() > 6.0 {
                return None;
            }
            if step.abs() < 1e-4 {
                return Some((x, score));
            }
        }
        None
    }

    /// Levels, blur and noise from the teachers; their places, px from the central pixel.
    fn learn(&mut self, windows: &Windows, teachers: &[usize]) -> Vec<f64> {
        let mut starts: Vec<f64> = teachers.iter().map(|c| f64::from(windows.start[*c])).collect();
        for _ in 0..30 {
            match self.teach(windows, teachers, &mut starts) {
                Some(change) if change > 1e-4 => {}
                _ => break,
            }
        }
        starts
    }

    /// Logarithm of the likelihood of the teachers' grey values, clipped ones by their probability, at their places in `starts`.
    fn log_likelihood(&self, windows: &Windows, teachers: &[usize], starts: &[f64]) -> f64 {
        let of = |(column, x): (&usize, &f64)| self.score(windows.of(*column), *x, self.sigma).log_likelihood;
        teachers.iter().zip(starts).map(of).sum()
    }

    /// One Gauss-Newton step of (dark, light, σ) over the teachers, their positions profiled out. The relative change of σ.
    fn teach(&mut self, windows: &Windows, teachers: &[usize], starts: &mut [f64]) -> Option<f64> {
        let mut normal = SMatrix::<f64, 3, 3>::zeros();
        let mut right = SMatrix::<f64, 3, 1>::zeros();
        let (mut chi2, mut telling) = (0.0, 0.0);
        for (column, start) in teachers.iter().zip(starts.iter_mut()) {
            let Some((x, score)) = self.position(windows.of(*column), *start, self.sigma) else { continue };
            *start = x;
            let cross = score.information.fixed_view::<3, 1>(1, 0).into_owned();
            let own = score.information[(0, 0)];
            normal += score.information.fixed_view::<3, 3>(1, 1) - cross * cross.transpose() / own;
            right += score.gradient.fixed_rows::<3>(1) - cross * (score.gradient[0] / own);
            chi2 += score.chi2;
            telling += score.telling - 1.0;
        }
        if telling < 1.0 {
            return None;
        }
        for k in 0..3 {
            normal[(k, k)] *= 1.001;
        }
        if !self.free_light {
            normal.fill_column(1, 0.0);
            normal.fill_row(1, 0.0);
            (normal[(1, 1)], right[1]) = (1.0, 0.0);
        }
        let step = normal.try_inverse()? * right;
        let last = self.sigma;
        self.dark += step[0].clamp(-20.0, 20.0);
        if self.free_light {
            self.light = (self.light + step[1].clamp(-0.2 * self.light, 0.2 * self.light))
                .clamp(self.clip, BRIGHTEST * self.clip);
        }
        self.sigma = (self.sigma + step[2].clamp(-0.2 * last, 0.3 * last)).clamp(0.25, 6.0);
        self.variance = (self.variance * (chi2 / telling).clamp(0.25, 4.0)).max(0.1);
        Some((self.sigma / last - 1.0).abs())
    }
}

/// What a side's frame tells before the fit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClippedStart {
    /// Dark level, counts.
    pub(crate) dark: f64,
    /// Noise variance in the dark, counts².
    pub(crate) variance: f64,
    /// End of the grey scale, counts.
    pub(crate) clip: f64,
    /// Fraction of flat light pixels at the clip.
    pub(crate) fraction: f64,
}

/// Fits all columns of a side; gives the degrees of freedom to test their residuals with.
pub(crate) fn fit_side(windows: &Windows, slope: &[f32], start: ClippedStart, line: &mut Vec<Edge>) -> f64 {
    let columns = windows.centre.len();
    let able: Vec<usize> =
        (0..columns).filter(|c| windows.centre[*c].is_ok() && slope[*c].abs() < 0.2).collect();
    let teachers: Vec<usize> = able.iter().copied().step_by(able.len().div_ceil(TEACHERS).max(1)).collect();
    let mut model = Model {
        dark: start.dark,
        light: ASSUMED * start.clip,
        sigma: 1.2,
        variance: start.variance.max(0.25),
        clip: start.clip,
        free_light: start.fraction < BLIND,
    };
    let places = model.learn(windows, &teachers);
    let mut shared = 0.0;
    if !model.free_light {
        let mut brighter = Model { light: BRIGHTEST * start.clip, ..model };
        let moved = brighter.learn(windows, &teachers);
        let said = brighter.log_likelihood(windows, &teachers, &moved);
        let too_bright = TOO_BRIGHT.iter().any(|beyond| {
            let mut model = Model { light: beyond * start.clip, ..brighter };
            let places = model.learn(windows, &teachers);
            model.log_likelihood(windows, &teachers, &places) > said + BETTER
        });
        // A flank that seems sharper than any lens makes it tells nothing: the light is far beyond.
        if too_bright || model.sigma < SHARP_PX {
            let gap = |column: usize| windows.centre[column].err().unwrap_or(Reason::Saturated);
            line.extend((0..columns).map(|column| Edge::gap(gap(column))));
            return 4.0;
        }
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len().max(1) as f64;
        // The light is anywhere between, and the value taken stands at one end of the range; both edges err alike.
        shared = (mean(&moved) - mean(&places)).abs() * (2.0_f64 / 3.0).sqrt();
    }
    line.extend((0..columns).map(|column| {
        let mut edge = fit_column(windows, &model, column, slope[column]);
        edge.u_shared_px = if edge.is_usable() { shared as f32 } else { f32::NAN };
        edge
    }));
    // The flank's noise is larger than the mean over flank and dark foot: as if only the flank had freedom.
    4.0
}

fn fit_column(windows: &Windows, model: &Model, column: usize, slope: f32) -> Edge {
    if let Err(reason) = windows.centre[column] {
        return Edge::gap(reason);
    }
    let sigma = column_sigma(model.sigma, f64::from(slope));
    let Some((x, score)) = model.position(windows.of(column), f64::from(windows.start[column]), sigma) else {
        return Edge::gap(Reason::Residual);
    };
    // Fewer than two telling pixels on the flank: nothing but the clip is seen.
    let own = score.information[(0, 0)];
    if !(own > 0.0) || score.telling < 2.0 {
        return Edge::gap(Reason::Saturated);
    }
    let freedom = (score.telling - 1.0).max(1.0);
    Edge {
        row_px: windows.row(column, x as f32),
        u_own_px: (1.0 / own).sqrt() as f32,
        u_shared_px: 0.0,
        chi2: (score.chi2 / freedom) as f32,
        state: EdgeState::Impaired(Reason::Clipped),
    }
}
