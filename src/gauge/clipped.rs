//! Edges whose bright field is clipped at the end of the grey scale: censored maximum likelihood.
//!
//! A pixel below the clip tells its grey value, one at the clip only that it lies above (Tobin's model). With
//! α = (clip − μ)/s the scores by the mean μ are (m − μ)/s² below and h(α)/s at the clip, h = φ/(1 − Φ) (hazard), and
//! the expected information per pixel is [Φ(α) − α φ(α) + φ(α) h(α)]/s². The true light level lies above the clip;
//! it, the blur and the dark level are estimated once a frame from many columns, the position of each column with them.

use nalgebra::{Matrix4, SMatrix, Vector4};

use super::edges::{Edge, EdgeState};
use super::model::{EdgeSample, column_sigma, edge_samples, phi_cdf, phi_pdf};
use super::table::half;
use super::window::Windows;
use crate::profile::Reason;

/// Columns that teach the frame's levels and blur.
const TEACHERS: usize = 64;
/// The light is looked for up to this multiple of the clip.
const BRIGHTEST: f64 = 4.0;

/// The frame's side as the censored fit sees it.
#[derive(Clone, Copy, Debug)]
struct Model {
    dark: f64,
    light: f64,
    sigma: f64,
    variance: f64,
    clip: f64,
}

/// Scores and information of one column for (x, dark, light, σ).
struct Score {
    gradient: Vector4<f64>,
    information: Matrix4<f64>,
    chi2: f64,
    /// Expected number of pixels that tell a grey value.
    telling: f64,
}

impl Model {
    fn score(&self, window: &[f32], x: f64, sigma: f64) -> Score {
        let used = window.len() - 1;
        let mut samples = [EdgeSample::default(); 72];
        let samples = &mut samples[..used];
        edge_samples(-(half(window.len()) as f64), x, sigma, samples);
        let s = self.variance.sqrt();
        let contrast = self.light - self.dark;
        let mut score =
            Score { gradient: Vector4::zeros(), information: Matrix4::zeros(), chi2: 0.0, telling: 0.0 };
        for (sample, m) in samples.iter().zip(window) {
            let mean = self.dark + contrast * sample.value;
            let alpha = (self.clip - 0.5 - mean) / s;
            let (cdf, pdf) = (phi_cdf(alpha), phi_pdf(alpha));
            let hazard = if cdf < 1.0 - 1e-12 { pdf / (1.0 - cdf) } else { 0.0 };
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
        let step = normal.try_inverse()? * right;
        let last = self.sigma;
        self.dark += step[0].clamp(-20.0, 20.0);
        self.light = (self.light + step[1].clamp(-0.2 * self.light, 0.2 * self.light))
            .clamp(self.clip, BRIGHTEST * self.clip);
        self.sigma = (self.sigma + step[2].clamp(-0.2 * last, 0.3 * last)).clamp(0.25, 6.0);
        self.variance *= (chi2 / telling).clamp(0.25, 4.0);
        Some((self.sigma / last - 1.0).abs())
    }
}

/// Fits all columns of a side. `dark` and `variance` are first values in counts; the light is found above the clip.
pub(crate) fn fit_side(
    windows: &Windows,
    slope: &[f32],
    dark: f64,
    variance: f64,
    clip: f32,
    line: &mut Vec<Edge>,
) {
    let columns = windows.centre.len();
    let able: Vec<usize> =
        (0..columns).filter(|c| windows.centre[*c].is_ok() && slope[*c].abs() < 0.2).collect();
    let teachers: Vec<usize> = able.iter().copied().step_by(able.len().div_ceil(TEACHERS).max(1)).collect();
    let mut starts: Vec<f64> = teachers.iter().map(|c| f64::from(windows.start[*c])).collect();
    let clip = f64::from(clip);
    let mut model = Model { dark, light: 1.2 * clip, sigma: 1.2, variance: variance.max(0.25), clip };
    for _ in 0..30 {
        match model.teach(windows, &teachers, &mut starts) {
            Some(change) if change > 1e-4 => {}
            _ => break,
        }
    }
    line.extend((0..columns).map(|column| fit_column(windows, &model, column, slope[column])));
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
