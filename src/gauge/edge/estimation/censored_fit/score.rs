//! Likelihood of one column whose grey values are censored at the ends of the scale.

use nalgebra::{Matrix6, Vector6};

use super::super::censored::{Censored, Ends};
use crate::gauge::edge::image::window_layout::half;
use crate::gauge::edge::model::edge_spread::{EdgeSpreadFunction, EdgeSpreadLimits};
use crate::gauge::edge::model::gaussian::EdgeSample;
use crate::gauge::edge::model::shape_terms::{ShapeTerms, TERMS, term_border};
use crate::gauge::limit::limits;
use crate::numerics::normal_table::NormalTable;

limits! {
    /// Which pixels place a column's edge, and when it is placed.
    ScoreLimits = "censored_score";
    /// Residual beyond which a pixel is no sample of its model, standard deviations: hot and dead
    /// pixels, contamination. Noise reaches it once in 5·10⁸ pixels.
    stray: f64 = 6.0;
    /// Slope of the edge per px below which a pixel does not move its position: its information is
    /// 10⁻⁸ of that of a steep one.
    flat_slope: f64 = 1e-4;
    /// Share of the light up to which a pixel lies in the flat shadow: its noise is then that of
    /// the shadow to 1 % of what the light adds.
    flat_share: f64 = 0.01;
    /// Step of the position below which the flank no longer counts as stray, px: it moves a pixel
    /// by 0.05·0.4/σ of the contrast at most, 2 % at σ = 1 px, less than `stray` standard
    /// deviations of a noise of 0.3 %.
    near_px: f64 = 0.05;
    /// Step of the position below which it has converged, px: a hundredth of the noise of a single
    /// edge.
    settled_px: f64 = 1e-4;
}

/// Most pixels of a window.
const MOST: usize = 80;
/// x, dark, light, σ, and the amplitudes of the shape terms.
pub(crate) type Gradient = Vector6<f64>;
/// Information of [`Gradient`].
pub(super) type Information = Matrix6<f64>;

/// Noise variance over the grey level: a straight line, plus the unexplained variance of the model
/// everywhere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Noise {
    /// Level at which `variance` holds, counts.
    pub(crate) level: f64,
    /// Variance there, counts².
    pub(crate) variance: f64,
    /// Growth with the level, counts.
    pub(crate) gain: f64,
    /// Least variance, counts².
    pub(crate) floor: f64,
    /// Variance of the systematic residual, counts².
    pub(crate) unexplained: f64,
}

impl Noise {
    pub(crate) fn at(&self, level: f64) -> f64 {
        (self.variance + self.gain * (level - self.level)).max(self.floor)
    }
}

/// Levels and blur of one column.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Column {
    pub(crate) dark: f64,
    pub(crate) light: f64,
    pub(crate) sigma: f64,
}

/// What all columns of a side share but levels and blur.
#[derive(Clone, Debug)]
pub(super) struct Likelihood<'a> {
    pub(crate) shape: &'a EdgeSpreadFunction,
    pub(crate) ends: Ends,
    pub(crate) noise: Noise,
    /// Amplitudes of the shape terms.
    pub(crate) terms: [f64; TERMS],
    separated: ShapeTerms,
    /// Whether stray pixels are left out; before the fit has settled they only count less.
    pub(crate) strict: bool,
    limits: &'static ScoreLimits,
}

/// Scores and information of one column.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Score {
    pub(crate) gradient: Gradient,
    pub(crate) information: Information,
    /// Σ of squared residuals over the noise variance (without the unexplained one) of the pixels
    /// between the ends.
    pub(crate) chi2: f64,
    /// What that sum is expected to be.
    pub(super) informative: f64,
    /// Σ(m − μ)² less the noise at its known level, and Σ(μ − that level), over pixels on the
    /// flank: their ratio is the noise's gain. What the column's own place has taken of the squares
    /// is added.
    pub(crate) flank: [f64; 2],
    /// Pixels on the flank.
    pub(super) on_flank: f64,
    /// The same as `chi2` and `informative` over the flat shadow alone, and its pixels.
    pub(crate) in_dark: [f64; 3],
    /// Change of the gradient by a relative change of the noise.
    pub(crate) by_noise: Gradient,
    /// Pixels left out.
    pub(crate) stray: usize,
    /// Those of them that stand at the upper end in the flat shadow: hot ones.
    pub(crate) hot: usize,
}

impl<'a> Likelihood<'a> {
    pub(crate) fn new(shape: &'a EdgeSpreadFunction, ends: Ends, noise: Noise) -> Self {
        let (separated, limits) = (ShapeTerms::default(), ScoreLimits::get());
        Self { shape, ends, noise, terms: [0.0; TERMS], separated, strict: false, limits }
    }

    /// Edge and shape terms in the pixels of a window of `width`, the edge at `x` from its central
    /// pixel.
    fn samples(&self, width: usize, x: f64, sigma: f64, out: &mut [Sample]) {
        let table = NormalTable::get();
        let first = -(half(width) as f64);
        let border = |k: usize| {
            let u = first + k as f64 - 0.5 - x;
            let normal = table.at(u / sigma);
            (self.shape.border(u, sigma, normal), term_border(u, sigma, normal[1]))
        };
        let mut left = border(0);
        for (k, Sample { edge, terms }) in out.iter_mut().enumerate() {
            let right = border(k + 1);
            *edge = EdgeSample::between(&left.0, &right.0);
            let plain = [right.1[0] - left.1[0], right.1[1] - left.1[1]];
            *terms = self.separated.at([edge.by_position, edge.by_sigma], plain);
            left = right;
        }
    }

    /// Makes the shape terms orthogonal to position and blur of an edge seen whole.
    pub(crate) fn separate(&mut self, width: usize, column: Column) {
        let phases = EdgeSpreadLimits::get().phases;
        self.separated = ShapeTerms::default();
        let used = (width - 1).min(MOST);
        let mut samples = Vec::with_capacity(phases as usize * used);
        let mut of_window = [Sample::default(); MOST];
        for phase in 0..phases {
            let x = (f64::from(phase) + 0.5) / f64::from(phases) - 0.5;
            self.samples(width, x, column.sigma, &mut of_window[..used]);
            samples.extend(of_window[..used].iter().map(|Sample { edge, terms }| {
                let mean = column.dark + (column.light - column.dark) * edge.value;
                let weight = (self.noise.at(mean) + self.noise.unexplained).recip();
                ([edge.by_position, edge.by_sigma], *terms, weight)
            }));
        }
        self.separated = ShapeTerms::separate(samples.into_iter());
    }

    /// What the pixels of a column's window state, those left out not; their number, and that of
    /// hot ones.
    fn pixels(
        &self,
        Placed { window, x, column }: Placed<'_>,
        Taken { strict, flank }: Taken,
        mut each: impl FnMut(&Pixel),
    ) -> [usize; 2] {
        let used = (window.len() - 1).min(MOST);
        let mut samples = [Sample::default(); MOST];
        self.samples(window.len(), x, column.sigma, &mut samples[..used]);
        let contrast = column.light - column.dark;
        let ScoreLimits { stray: most, flat_slope, flat_share, .. } = *self.limits;
        let (mut stray, mut hot) = (0, 0);
        let least = if flank { flat_slope } else { 0.0 };
        let all = samples[..used].iter().zip(window);
        for (Sample { edge, terms }, m) in all.filter(|(s, _)| s.edge.by_position.abs() >= least) {
            let value = edge.value + self.terms[0] * terms[0] + self.terms[1] * terms[1];
            let mean = column.dark + contrast * value;
            let noise = self.noise.at(mean);
            let s = (noise + self.noise.unexplained).sqrt();
            let sampled = Censored::new(f64::from(*m), mean, s, self.ends);
            let mut weight = 1.0;
            if sampled.residual.abs() > most {
                stray += 1;
                hot += usize::from(value < flat_share && f64::from(*m) >= self.ends.high);
                if strict {
                    continue;
                }
                weight = most / sampled.residual.abs();
            }
            each(&Pixel {
                m: f64::from(*m),
                edge: *edge,
                terms: *terms,
                value,
                mean,
                noise,
                s,
                sampled,
                weight,
            });
        }
        [stray, hot]
    }

    /// Scores a column's window with its edge at `x` px from the central pixel.
    pub(crate) fn score(&self, window: &[f32], x: f64, column: Column) -> Score {
        let contrast = column.light - column.dark;
        let flat_share = self.limits.flat_share;
        let mut taken = 0.0;
        let mut score = Score::default();
        [score.stray, score.hot] = self.pixels(Placed { window, x, column }, self.all(), |pixel| {
            let Pixel { edge, terms, value, s, sampled, weight, .. } = pixel;
            let by = Gradient::new(
                contrast * edge.by_position,
                1.0 - value,
                *value,
                contrast * edge.by_sigma,
                contrast * terms[0],
                contrast * terms[1],
            ) / *s;
            score.gradient += by * (sampled.residual * weight);
            score.information += by * by.transpose() * (sampled.information * weight);
            score.by_noise += by * (sampled.by_noise * weight);
            score.informative += sampled.expected;
            if *value < flat_share {
                let square = if sampled.between { (pixel.m - pixel.mean).powi(2) } else { 0.0 };
                score.in_dark[0] += square / pixel.noise;
                score.in_dark[1] += sampled.expected;
                score.in_dark[2] += 1.0;
            }
            if sampled.between {
                let square = (pixel.m - pixel.mean).powi(2);
                score.chi2 += square / pixel.noise;
                if (0.25..0.9).contains(value) && sampled.expected > 0.999 {
                    score.flank[0] += square - self.noise.variance;
                    score.flank[1] += pixel.mean - self.noise.level;
                    score.on_flank += 1.0;
                    taken += pixel.noise * by[0] * by[0] * weight;
                }
            }
        });
        score.flank[0] += taken / score.information[(0, 0)].max(f64::MIN_POSITIVE);
        score
    }

    fn all(&self) -> Taken {
        Taken { strict: self.strict, flank: false }
    }

    /// Logarithm of the likelihood of a column's window.
    pub(crate) fn log_likelihood(&self, window: &[f32], x: f64, column: Column) -> f64 {
        let mut sum = 0.0;
        self.pixels(Placed { window, x, column }, self.all(), |pixel| {
            sum += Censored::log_likelihood(pixel.m, pixel.mean, pixel.s, self.ends);
        });
        sum
    }

    /// A step of Fisher scoring of the place alone, px.
    fn step(&self, window: &[f32], x: f64, column: Column, strict: bool) -> f64 {
        let contrast = column.light - column.dark;
        let (mut gradient, mut information) = (0.0, 0.0);
        self.pixels(Placed { window, x, column }, Taken { strict, flank: true }, |pixel| {
            let by = contrast * pixel.edge.by_position / pixel.s;
            gradient += by * pixel.sampled.residual * pixel.weight;
            information += by * by * pixel.sampled.information * pixel.weight;
        });
        gradient / information
    }

    /// Position of a column, px from its central pixel, by Fisher scoring from `start`; `None`
    /// where it does not converge.
    pub(crate) fn place(&self, window: &[f32], start: f64, column: Column) -> Option<f64> {
        let mut x = start;
        // Far from the position the flank itself would count as stray.
        let mut strict = false;
        for _ in 0..40 {
            let step = self.step(window, x, column, strict);
            if !step.is_finite() {
                return None;
            }
            x += step.clamp(-0.5, 0.5);
            if x.abs() > 8.0 {
                return None;
            }
            if strict == self.strict && step.abs() < self.limits.settled_px {
                return Some(x);
            }
            strict |= self.strict && step.abs() < self.limits.near_px;
        }
        None
    }
}

/// A column's window with its edge at `x` px from the central pixel.
#[derive(Clone, Copy)]
struct Placed<'a> {
    window: &'a [f32],
    x: f64,
    column: Column,
}

/// The light that an edge puts into one pixel, and the shape terms in it.
#[derive(Clone, Copy, Debug, Default)]
struct Sample {
    edge: EdgeSample,
    terms: [f64; TERMS],
}

/// Which pixels of a window are taken.
#[derive(Clone, Copy, Debug)]
struct Taken {
    /// Whether stray ones are left out; else they count less.
    strict: bool,
    /// Only those on the flank: the others do not move the place.
    flank: bool,
}

/// Contribution of a pixel beside its model.
struct Pixel {
    m: f64,
    edge: EdgeSample,
    terms: [f64; TERMS],
    value: f64,
    mean: f64,
    noise: f64,
    s: f64,
    sampled: Censored,
    weight: f64,
}
