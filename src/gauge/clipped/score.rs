//! Likelihood of one column whose grey values are censored at the ends of the scale.

use nalgebra::{Matrix6, Vector6};

use super::super::censored::{Censored, Ends};
use super::super::esf::EdgeShape;
use super::super::model::EdgeSample;
use super::super::shape_terms::{ShapeTerms, TERMS, term_border};
use super::super::table::half;

/// Most pixels of a window.
const MOST: usize = 80;
/// Residual beyond which a pixel is no sample of its model, standard deviations: hot and dead pixels, dirt. Noise reaches it once in
/// 5·10⁸ pixels.
const STRAY: f64 = 6.0;
/// x, dark, light, σ, and the amplitudes of the shape terms.
pub(super) type Gradient = Vector6<f64>;
/// Information of [`Gradient`].
pub(super) type Information = Matrix6<f64>;

/// Noise variance over the grey level: a straight line, and what a misfit of the model adds everywhere.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noise {
    /// Level at which `variance` holds, counts.
    pub(super) level: f64,
    /// Variance there, counts².
    pub(super) variance: f64,
    /// Growth with the level, counts.
    pub(super) gain: f64,
    /// Least variance, counts².
    pub(super) floor: f64,
    /// Variance of the misfit, counts².
    pub(super) misfit: f64,
}

impl Noise {
    pub(super) fn at(&self, level: f64) -> f64 {
        (self.variance + self.gain * (level - self.level)).max(self.floor)
    }
}

/// Levels and blur of one column.
#[derive(Clone, Copy, Debug)]
pub(super) struct Column {
    pub(super) dark: f64,
    pub(super) light: f64,
    pub(super) sigma: f64,
}

/// What all columns of a side share but levels and blur.
#[derive(Clone, Debug)]
pub(super) struct Likelihood<'a> {
    pub(super) shape: &'a EdgeShape,
    pub(super) ends: Ends,
    pub(super) noise: Noise,
    /// Amplitudes of the shape terms.
    pub(super) terms: [f64; TERMS],
    separated: ShapeTerms,
    /// Whether stray pixels are left out; before the fit has settled they only count less.
    pub(super) strict: bool,
}

/// Scores and information of one column.
#[derive(Clone, Copy, Debug)]
pub(super) struct Score {
    pub(super) gradient: Gradient,
    pub(super) information: Information,
    /// Σ of squared residuals over the noise variance (no misfit) of the pixels between the ends.
    pub(super) chi2: f64,
    /// What that sum is expected to be.
    pub(super) telling: f64,
    pub(super) log_likelihood: f64,
    /// Σ(m − μ)² less the noise at the dark level, and Σ(μ − dark), over pixels on the flank: their ratio is the noise's gain. What the
    /// column's own place has taken of the squares is added.
    pub(super) flank: [f64; 2],
    /// Pixels left out.
    pub(super) stray: usize,
}

impl<'a> Likelihood<'a> {
    pub(super) fn new(shape: &'a EdgeShape, ends: Ends, noise: Noise) -> Self {
        Self { shape, ends, noise, terms: [0.0; TERMS], separated: ShapeTerms::default(), strict: false }
    }

    /// Edge and shape terms in the pixels of a window of `width`, the edge at `x` from its central pixel.
    fn samples(&self, width: usize, x: f64, sigma: f64, edge: &mut [EdgeSample], terms: &mut [[f64; TERMS]]) {
        let first = -(half(width) as f64);
        self.shape.samples(first, x, sigma, edge);
        let border = |k: usize| term_border(first + k as f64 - 0.5 - x, sigma);
        let mut left = border(0);
        for (k, (terms, edge)) in terms.iter_mut().zip(edge.iter()).enumerate() {
            let right = border(k + 1);
            let plain = [right[0] - left[0], right[1] - left[1]];
            *terms = self.separated.at([edge.by_position, edge.by_sigma], plain);
            left = right;
        }
    }

    /// Makes the shape terms such that an edge seen whole, with place and blur free, does not feel them.
    pub(super) fn separate(&mut self, width: usize, column: Column) {
        const PHASES: u32 = 8;
        self.separated = ShapeTerms::default();
        let used = (width - 1).min(MOST);
        let mut samples = Vec::with_capacity(PHASES as usize * used);
        let (mut edge, mut terms) = ([EdgeSample::default(); MOST], [[0.0; TERMS]; MOST]);
        for phase in 0..PHASES {
            let x = (f64::from(phase) + 0.5) / f64::from(PHASES) - 0.5;
            self.samples(width, x, column.sigma, &mut edge[..used], &mut terms[..used]);
            samples.extend(edge[..used].iter().zip(&terms[..used]).map(|(edge, terms)| {
                let mean = column.dark + (column.light - column.dark) * edge.value;
                let weight = (self.noise.at(mean) + self.noise.misfit).recip();
                ([edge.by_position, edge.by_sigma], *terms, weight)
            }));
        }
        self.separated = ShapeTerms::separate(samples.into_iter());
    }

    /// Scores a column's window with its edge at `x` px from the central pixel.
    pub(super) fn score(&self, window: &[f32], x: f64, column: Column) -> Score {
        self.score_as(window, x, column, self.strict)
    }

    fn score_as(&self, window: &[f32], x: f64, column: Column, strict: bool) -> Score {
        let used = (window.len() - 1).min(MOST);
        let (mut edge, mut terms) = ([EdgeSample::default(); MOST], [[0.0; TERMS]; MOST]);
        self.samples(window.len(), x, column.sigma, &mut edge[..used], &mut terms[..used]);
        let contrast = column.light - column.dark;
        let mut taken = 0.0;
        let mut score = Score {
            gradient: Gradient::zeros(),
            information: Information::zeros(),
            chi2: 0.0,
            telling: 0.0,
            log_likelihood: 0.0,
            flank: [0.0; 2],
            stray: 0,
        };
        for ((edge, terms), m) in edge[..used].iter().zip(&terms[..used]).zip(window) {
            let value = edge.value + self.terms[0] * terms[0] + self.terms[1] * terms[1];
            let mean = column.dark + contrast * value;
            let noise = self.noise.at(mean);
            let s = (noise + self.noise.misfit).sqrt();
            let sampled = Censored::new(f64::from(*m), mean, s, self.ends);
            let mut weight = 1.0;
            if sampled.residual.abs() > STRAY {
                score.stray += 1;
                if strict {
                    continue;
                }
                weight = STRAY / sampled.residual.abs();
            }
            let by = Gradient::new(
                contrast * edge.by_position,
                1.0 - value,
                value,
                contrast * edge.by_sigma,
                contrast * terms[0],
                contrast * terms[1],
            ) / s;
            score.gradient += by * (sampled.residual * weight);
            score.information += by * by.transpose() * (sampled.information * weight);
            score.log_likelihood += sampled.log_likelihood;
            score.telling += sampled.expected;
            if sampled.between {
                let square = (f64::from(*m) - mean).powi(2);
                score.chi2 += square / noise;
                if (0.25..0.9).contains(&value) && sampled.expected > 0.999 {
                    score.flank[0] += square - self.noise.at(column.dark);
                    score.flank[1] += mean - column.dark;
                    taken += noise * by[0] * by[0] * weight;
                }
            }
        }
        score.flank[0] += taken / score.information[(0, 0)].max(f64::MIN_POSITIVE);
        score
    }

    /// Place of a column, px from its central pixel, by Fisher scoring from `start`; `None` where it does not settle.
    pub(super) fn place(&self, window: &[f32], start: f64, column: Column) -> Option<(f64, Score)> {
        let mut x = start;
        // From afar the flank itself looks stray.
        let mut strict = false;
        for _ in 0..40 {
            let score = self.score_as(window, x, column, strict);
            let step = score.gradient[0] / score.information[(0, 0)];
            if !step.is_finite() {
                return None;
            }
            x += step.clamp(-0.5, 0.5);
            if x.abs() > 8.0 {
                return None;
            }
            if step.abs() < 1e-4 {
                if strict == self.strict {
                    return Some((x, score));
                }
                strict = self.strict;
            }
        }
        None
    }
}
