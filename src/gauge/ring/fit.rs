//! Maximum likelihood of one whole edge: levels and blur pooled, one shift per caliper.
//!
//! Pixel i of caliper s reads m = B(x, y) + A(x, y)·E(d_i − δ_s; σ), B and A each a plane over the
//! frame (a tilt of the light, across the edge too). Weighted Gauss-Newton on all parameters at
//! once: the shifts are eliminated caliper by caliper (Schur complement), which leaves seven
//! equations. Weights are 1/variance, the variance estimated from the residuals in shadow, mid-edge
//! and light. Where light or shadow is clipped its pixels are censored, and two shape terms of the
//! edge-spread function join the pooled parameters.

use super::edge_fit::{Begun, Caliper, EdgeFit, POOLED, Variance};
use super::edge_pixels::{Band, EdgePixel};
use super::model::{Sample, square_edge};
use super::pixel_model::{Matrix, SHAPED, SIGMA, Sums, Vector, model, plain_terms};
use super::straight_edge;
use crate::gauge::edge::estimation::censored::{Censored, Ends};
use crate::gauge::edge::estimation::grey_ends::robust_mean;
use crate::gauge::edge::estimation::rounding::{noise_behind, repeated_variance};
use crate::gauge::edge::model::shape_terms::{ShapeTermLimits, ShapeTerms};
use crate::gauge::limit::limits;
use crate::numerics::robust::{MEDIAN_TO_SD, median_of as median};

limits! {
    /// When pixels and calipers of a ring show an edge.
    RingFitLimits = "ring_fit";
    /// Residual in standard deviations, beyond which it counts by its size only (Huber): a hair in
    /// the light must not lower its level. Noise loses 0.3 % of its pixels.
    huber: f64 = 3.0;
    /// Residual in standard deviations, beyond which a pixel is hot or dead, or contamination:
    /// noise reaches it once in 5·10⁸ pixels.
    stray: f64 = 6.0;
    /// Stray pixels that a caliper may have: of 2 % hot pixels, one caliper of thirty pixels in
    /// fifty has more; contamination covers more.
    most_stray: usize = 2;
    /// χ² of a caliper over the usual one, above which it does not show an edge. Of noise with ten
    /// degrees of freedom 4 is exceeded in 10⁻⁵ of the calipers.
    chi2: f64 = 4.0;
    /// Share of a pixel's square that its caliper's shift leaves of it, above which it is evaluated
    /// for the noise: a smaller share is divided by with a large error.
    least_left: f64 = 0.1;
    /// Change of a step, px and fractions of the contrast, below which the calipers of clipped
    /// light are tested: a tenth of the u that noise of 1 % of the contrast gives a caliper of
    /// thirty pixels.
    settled: f64 = 1e-3;
    /// Change of a step, px and fractions of the contrast, below which a fit that another one will
    /// follow has come near: the next one's pixels are chosen by it, of a band that reaches four
    /// blurs to either side.
    near: f64 = 5e-3;
    /// Upper bound of the contrast in the fit, as a multiple of the part of it that is seen: the
    /// flank of light clipped at a quarter shows little of its shape. Tuned: see study limits.
    most_contrast: f64 = 4.0;
    /// Distance of the samples, px, by which shape terms are made orthogonal: the least blur in the
    /// fit.
    shape_step_px: f64 = 0.25;
    /// Least blur in the fit, px: a sharper edge lies within a pixel, and where within it does not
    /// show.
    least_sigma_px: f64 = 0.25;
    /// Width of the steps in which a refused caliper is read, px: half the distance of two pixels
    /// along it.
    crossing_step_px: f64 = 0.5;
}

struct State<const P: usize> {
    pooled: Vector<P>,
    sectors: Vec<SectorFit>,
    variance: Variance,
    least_variance: f64,
    /// Where grey values are clipped, the contrast seen between the ends, and the shape terms; none
    /// where nothing is.
    clipped: Option<Clipped>,
    /// Relative standard uncertainty of the noise in the light where it is clipped.
    noise_known_to: f64,
    /// The edge in every pixel of every caliper at the present blur and shifts; empty where they
    /// have changed since. Noise, judgement and the step after them need the same ones.
    edges: Vec<Vec<Sample>>,
    /// The calipers' sums at the present parameters and noise; empty where these have changed
    /// since.
    sums: Vec<Sums<P>>,
}

/// Where the edge of one caliper stands in its sector.
#[derive(Clone, Copy, Debug)]
struct SectorFit {
    /// From the circle, px.
    shift: f64,
    /// Last change of it, px.
    step: f64,
    good: bool,
}

/// Prior data of a clipped edge.
#[derive(Clone, Copy, Debug)]
struct Clipped {
    ends: Ends,
    seen: f64,
    separated: ShapeTerms,
}

impl<const P: usize> State<P> {
    fn start(band: &Band, least_variance: f64, ends: Option<Ends>) -> Option<Self> {
        let all = || band.sectors.iter().flatten();
        let reach = all().map(|p| p.distance).fold(0.0, f64::max);
        let level = |over: &dyn Fn(&EdgePixel) -> bool| {
            median(all().filter(|p| over(p)).map(|p| p.value).collect::<Vec<f64>>())
        };
        let dark = level(&|p| p.distance < -0.7 * reach);
        let light = level(&|p| p.distance > 0.7 * reach);
        if light.is_nan() || light - dark <= 0.0 {
            return None;
        }
        let mut pooled = Vector::<P>::zeros();
        (pooled[0], pooled[3], pooled[SIGMA]) = (dark, light - dark, 1.0);
        Some(Self {
            pooled,
            sectors: band
                .sectors
                .iter()
                .map(|s| SectorFit { shift: 0.0, step: f64::INFINITY, good: s.len() >= 6 })
                .collect(),
            variance: Variance([1e-4 * (light - dark).powi(2) + least_variance; 3]),
            least_variance,
            clipped: ends.map(|ends| Clipped { ends, seen: light - dark, separated: ShapeTerms::default() }),
            noise_known_to: 0.0,
            edges: Vec::new(),
            sums: Vec::new(),
        })
    }

    /// Makes the shape terms orthogonal to position and blur of an edge seen whole, under the
    /// current noise.
    fn separate(&mut self, reach: f64) {
        let limits = RingFitLimits::get();
        let (sigma, variance) = (self.pooled[SIGMA], self.variance);
        let count = (2.0 * reach / limits.shape_step_px) as usize;
        let samples = (0..=count).map(|k| {
            let distance = k as f64 * limits.shape_step_px - reach;
            let edge = square_edge(distance, 1.0, 0.0, sigma);
            let by = [edge.by_distance, edge.by_sigma];
            (by, plain_terms(distance, sigma), variance.at(edge.value).recip())
        });
        let separated = ShapeTerms::separate(samples);
        self.clipped.iter_mut().for_each(|clipped| clipped.separated = separated);
        self.sums.clear();
    }

    /// Adds the prior of the shape terms.
    fn add_priors(&self, normal: &mut Matrix<P>, right: &mut Vector<P>) {
        let amplitude = ShapeTermLimits::get().amplitude;
        for k in POOLED..P {
            normal[(k, k)] += amplitude.powi(-2);
            right[k] -= self.pooled[k] * amplitude.powi(-2);
        }
    }

    /// Computes the edge in every pixel where blur and shifts have changed.
    fn evaluate(&mut self, band: &Band) {
        if !self.edges.is_empty() {
            return;
        }
        let (sigma, mut line) = (self.pooled[SIGMA], None);
        let of = |(pixels, at): (&Vec<EdgePixel>, &SectorFit)| {
            straight_edge::edges(pixels, at.shift, sigma, &mut line)
        };
        self.edges = band.sectors.iter().zip(&self.sectors).map(of).collect();
    }

    /// Computes the sums of every caliper where parameters or noise have changed.
    fn sum_up(&mut self, band: &Band) {
        self.evaluate(band);
        if self.sums.is_empty() {
            self.sums = (0..band.sectors.len()).map(|k| self.sums_of(&band.sectors[k], k)).collect();
        }
    }

    fn sums_of(&self, pixels: &[EdgePixel], caliper: usize) -> Sums<P> {
        let shift = self.sectors[caliper].shift;
        let limits = RingFitLimits::get();
        let mut s = Sums {
            normal: Matrix::<P>::zeros(),
            right: Vector::<P>::zeros(),
            cross: Vector::<P>::zeros(),
            own: 0.0,
            own_right: 0.0,
            chi2: 0.0,
            pixels: 0.0,
            stray: 0,
            by_noise: (Vector::<P>::zeros(), 0.0),
        };
        for (pixel, edge) in pixels.iter().zip(&self.edges[caliper]) {
            let separated = self.clipped.as_ref().map(|c| &c.separated);
            let (value, by_pooled, by_shift, light) = model(pixel, *edge, &self.pooled, shift, separated);
            let variance = self.variance.at(light);
            let deviation = variance.sqrt();
            let (mut residual, mut information, mut between, mut expected) =
                (pixel.value - value, 1.0, true, 1.0);
            if let Some(clipped) = self.clipped.as_ref().filter(|_| P == SHAPED) {
                let censored = Censored::new(pixel.value, value, deviation, clipped.ends);
                residual = censored.residual * deviation;
                (information, between, expected) =
                    (censored.information, censored.between, censored.expected);
                let by_noise = censored.by_noise / deviation;
                s.by_noise.0 += by_pooled * by_noise;
                s.by_noise.1 += by_shift * by_noise;
            }
            if residual.abs() > limits.stray * deviation {
                s.stray += 1;
            } else {
                s.chi2 += if between { residual * residual / variance } else { 0.0 };
                s.pixels += expected;
            }
            let beyond = residual.abs() > limits.huber * deviation;
            let weight = if beyond { limits.huber * deviation / residual.abs() } else { 1.0 } / variance;
            s.add(&by_pooled, by_shift, (weight * information, weight * residual));
        }
        s.normal.fill_lower_triangle_with_upper_triangle();
        s
    }

    /// One Gauss-Newton step; the change of the pooled parameters and of the mean caliper, px, or
    /// `None` if the equations are singular.
    fn step(&mut self, band: &Band) -> Option<f64> {
        let limits = RingFitLimits::get();
        self.sum_up(band);
        // they are those of the step before as soon as this one is made
        let sums = std::mem::take(&mut self.sums);
        let (mut normal, mut right) = (Matrix::<P>::zeros(), Vector::<P>::zeros());
        for (s, _) in sums.iter().zip(&self.sectors).filter(|(s, at)| at.good && s.own > 0.0) {
            normal += s.normal - s.cross * s.cross.transpose() / s.own;
            right += s.right - s.cross * (s.own_right / s.own);
        }
        self.add_priors(&mut normal, &mut right);
        let full = normal.cholesky()?.solve(&right);
        // Far from the optimum a full step of the blur or the clipped light's level can overshoot.
        let contrast = self.pooled[3];
        let tame = |step: f64, limit: f64| (limit / step.abs().max(f64::MIN_POSITIVE)).min(1.0);
        let scale = tame(full[SIGMA], 0.3 * self.pooled[SIGMA]).min(tame(full[3], 0.2 * contrast));
        let amplitude = ShapeTermLimits::get().amplitude;
        let scale = (POOLED..P).fold(scale, |scale, k| scale.min(tame(full[k], 2.0 * amplitude)));
        let change = full * scale;
        self.pooled += change;
        self.edges.clear();
        if let Some(clipped) = self.clipped.as_ref().filter(|_| P == SHAPED) {
            self.pooled[3] = self.pooled[3].clamp(0.3 * clipped.seen, limits.most_contrast * clipped.seen);
        }
        self.pooled[SIGMA] = self.pooled[SIGMA].clamp(limits.least_sigma_px, 5.0);
        let (mut moved, mut count) = (0.0, 0.0);
        for (k, s) in sums.iter().enumerate().filter(|(_, s)| s.own > 0.0) {
            let sector = &mut self.sectors[k];
            sector.step = ((s.own_right - s.cross.dot(&change)) / s.own).clamp(-0.7, 0.7);
            sector.shift += sector.step;
            if sector.good {
                moved += sector.step.abs();
                count += 1.0;
            }
        }
        Some((moved / f64::max(count, 1.0)).max(change[SIGMA].abs()).max(change[3].abs() / contrast))
    }

    /// Noise from the residuals of the good calipers, robustly. A caliper has few pixels on the
    /// flank, and its own shift takes its share of their squares: what is left of one is 1 − h of
    /// it, h = w·(∂m/∂δ)²/Σw·(∂m/∂δ)².
    fn estimate_variance(&mut self, band: &Band) {
        let limits = RingFitLimits::get();
        self.evaluate(band);
        let mut zones = [Vec::new(), Vec::new(), Vec::new()];
        let ends = self.clipped.map_or(Ends::NONE, |c| c.ends);
        let separated = self.clipped.as_ref().map(|c| &c.separated);
        let mut evaluated = Vec::new();
        let calipers = band.sectors.iter().zip(&self.sectors).zip(&self.edges);
        for ((pixels, at), edges) in calipers.filter(|((_, at), _)| at.good) {
            let shift = at.shift;
            let informed = |light: f64, by_shift: f64| by_shift * by_shift / self.variance.at(light);
            let inside = |(p, _): &(&EdgePixel, &Sample)| p.value > ends.low && p.value < ends.high;
            evaluated.clear();
            evaluated.extend(pixels.iter().zip(edges).filter(inside).map(|(pixel, edge)| {
                let (value, _, by_shift, light) = model(pixel, *edge, &self.pooled, shift, separated);
                (pixel.value - value, informed(light, by_shift), light)
            }));
            let own: f64 = evaluated.iter().map(|(_, informed, _)| informed).sum();
            for &(residual, informed, light) in &evaluated {
                let zone = match light {
                    l if l < 0.1 => 0,
                    l if l > 0.9 => 2,
                    l if (0.25..0.75).contains(&l) => 1,
                    _ => continue,
                };
                let left = 1.0 - informed / own;
                if left > limits.least_left {
                    zones[zone].push((residual.powi(2) / left) as f32);
                }
            }
        }
        let counts = zones.each_ref().map(Vec::len);
        let spread = zones.map(|mut z| robust_mean(&mut z, 0.0).unwrap_or(0.0).max(self.least_variance));
        let [dark, middle, light] = spread;
        let dark = if counts[0] >= 100 && ends.low.is_infinite() { dark } else { middle };
        // Where the light is clipped the remaining pixels are those that read too low.
        let light = if counts[2] >= 100 && ends.high.is_infinite() { light } else { 2.0 * middle - dark };
        // √(2/n) is known of the variance at mid-edge, twice of which stands in the light's; half
        // of that of its root.
        self.noise_known_to = (2.0 / counts[1].max(2) as f64).sqrt() * middle / light.max(0.5 * middle);
        self.variance = Variance([dark, middle, light.max(0.5 * middle)]);
        self.sums.clear();
    }

    /// Standard uncertainty of the mean shift by rounding that the whole of the light and of the
    /// shadow share, px: `lever` is the shift's derivative by the pooled parameters. The edge
    /// itself passes through all phases.
    fn u_rounding(&self, lever: &Vector<P>) -> f64 {
        if self.least_variance < 1.0 / 12.0 {
            return 0.0;
        }
        let repeated = |variance: f64| {
            // At the least variance the noise is not observable.
            let seen = variance > 1.01 * self.least_variance;
            repeated_variance(if seen { noise_behind(variance) } else { 0.0 })
        };
        let Variance([dark, _, light]) = self.variance;
        let by_dark = lever[0] - lever[3];
        (repeated(dark) * by_dark * by_dark + repeated(light) * lever[3] * lever[3]).sqrt()
    }

    /// Which calipers are good.
    fn goods(&self) -> Vec<bool> {
        self.sectors.iter().map(|at| at.good).collect()
    }

    /// Refuses calipers whose residuals do not look like an edge, or whose edge departs from the
    /// neighbours'.
    fn judge(&mut self, band: &Band, outlier_sigmas: f64) {
        let limits = RingFitLimits::get();
        self.sum_up(band);
        let judged: Vec<(f64, f64)> = self
            .sums
            .iter()
            .map(|s| {
                if s.pixels < 5.0 || s.own <= 0.0 || s.stray > limits.most_stray {
                    return (f64::INFINITY, f64::INFINITY);
                }
                (s.chi2 / (s.pixels - 1.0), s.own.sqrt().recip())
            })
            .collect();
        let usual =
            |f: fn(&(f64, f64)) -> f64| median(judged.iter().map(f).filter(|c| c.is_finite()).collect());
        let departure = departures(&self.sectors);
        // Along a slope most calipers are their own neighbourhood's median: the departures' scatter
        // alone would be 0.
        let scale = (MEDIAN_TO_SD * median(departure.iter().map(|d| d.abs()).collect())).max(usual(|j| j.1));
        let level = usual(|j| j.0).max(1e-3) * limits.chi2;
        for ((sector, (chi2, _)), departure) in self.sectors.iter_mut().zip(judged).zip(departure) {
            let settled = sector.step.abs() < 1e-2;
            sector.good = settled && chi2 <= level && departure.abs() <= outlier_sigmas * scale;
        }
    }
}

impl<const P: usize> State<P> {
    /// First crossing of the middle between the levels, from the shadow outwards, of the mean grey
    /// values over the distance.
    fn crossing(&self, pixels: &[EdgePixel]) -> Option<f64> {
        let limits = RingFitLimits::get();
        let reach = pixels.iter().map(|p| p.distance.abs()).fold(0.0, f64::max);
        let mut bins = vec![(0.0, 0.0, 0.0_f64); (2.0 * reach / limits.crossing_step_px) as usize + 1];
        for pixel in pixels {
            let p = &self.pooled;
            let middle = p[0] + 0.5 * p[3] + (p[1] + 0.5 * p[4]) * pixel.x + (p[2] + 0.5 * p[5]) * pixel.y;
            let bin = &mut bins[((pixel.distance + reach) / limits.crossing_step_px) as usize];
            *bin = (bin.0 + pixel.distance, bin.1 + pixel.value - middle, bin.2 + 1.0);
        }
        let profile: Vec<(f64, f64)> =
            bins.iter().filter(|b| b.2 > 0.0).map(|b| (b.0 / b.2, b.1 / b.2)).collect();
        let pair = profile.windows(2).find(|w| w[0].1 <= 0.0 && w[1].1 > 0.0)?;
        let [(from, below), (to, above)] = [pair[0], pair[1]];
        Some(from + (to - from) * below / (below - above))
    }
}

/// Each shift less the median of its neighbourhood of a fortieth of the circle.
fn departures(sectors: &[SectorFit]) -> Vec<f64> {
    let n = sectors.len();
    let shift = |k: usize| sectors[k % n].shift;
    let half = (n / 80).max(2);
    (0..n).map(|k| shift(k) - median((0..=2 * half).map(|j| shift(k + n + j - half)).collect())).collect()
}

/// How far a fit goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Until {
    /// Parameters and shifts settle, in the rounds that noise and calipers need.
    Settled,
    /// The same, of a fit that begins where one ended: a round more would change nothing.
    Alike,
    /// Near enough for another fit to begin there.
    Near,
}

/// [`fit_edge`] of an edge without clipped light, near enough for [`fit_edge_from`] to begin there.
pub(in crate::gauge) fn fit_edge_nearly(
    band: &Band,
    least_variance: f64,
    outlier_sigmas: f64,
) -> Result<EdgeFit, String> {
    settle(State::<POOLED>::start(band, least_variance, None), band, outlier_sigmas, Until::Near)
}

/// [`fit_edge`] of an edge without clipped light, from where a fit of the same pixels ended, along
/// a contour that follows it: it settles in a third of the steps, at the same place.
pub(in crate::gauge) fn fit_edge_from(
    band: &Band,
    least_variance: f64,
    outlier_sigmas: f64,
    begun: Begun,
) -> Result<EdgeFit, String> {
    let mut start = State::<POOLED>::start(band, least_variance, None);
    if let Some(state) = &mut start {
        state.pooled = Vector::from(begun.pooled);
        state.variance = begun.variance;
    }
    settle(start, band, outlier_sigmas, Until::Alike)
}

/// Fits an edge; `least_variance` is the quantisation's (1/12 for integers) and above 0; `ends`
/// where grey values are clipped. `Err` is the reason of a failure.
pub(in crate::gauge) fn fit_edge(
    band: &Band,
    least_variance: f64,
    outlier_sigmas: f64,
    ends: Option<Ends>,
) -> Result<EdgeFit, String> {
    let until = Until::Settled;
    match ends {
        None => settle(State::<POOLED>::start(band, least_variance, None), band, outlier_sigmas, until),
        Some(_) => settle(State::<SHAPED>::start(band, least_variance, ends), band, outlier_sigmas, until),
    }
}

fn settle<const P: usize>(
    start: Option<State<P>>,
    band: &Band,
    outlier_sigmas: f64,
    until: Until,
) -> Result<EdgeFit, String> {
    let limits = RingFitLimits::get();
    let mut state = start.ok_or("no light on its outer side, or no shadow on its inner")?;
    let singular = "too few pixels, or all of them clipped";
    let reach = band.sectors.iter().flatten().map(|p| p.distance).fold(0.0, f64::max);
    let mut settled = f64::INFINITY;
    // A clipped level follows from the edge's shape alone: it converges more slowly.
    let (rounds, steps) = match until {
        Until::Near => (2, 12),
        _ if P == SHAPED => (6, 40),
        _ => (4, 12),
    };
    let enough = if until == Until::Near { limits.near } else { 1e-5 };
    for round in 0..rounds {
        if P == SHAPED {
            state.separate(reach);
        }
        for _ in 0..steps {
            settled = state.step(band).ok_or(singular)?;
            if settled < enough {
                break;
            }
        }
        let before = (state.variance, state.goods());
        state.estimate_variance(band);
        // Calipers that still move are not tested: all of them do while the light beyond the end is
        // being estimated.
        if round + 1 < rounds && (P == POOLED || settled < limits.settled) {
            // Not after the last round: the equations have been solved for these calipers.
            state.judge(band, outlier_sigmas);
        }
        // a further round would solve the same equations: the same calipers, weighted alike
        let alike = state.goods() == before.1 && state.variance.is_like(&before.0);
        if until == Until::Alike && settled < enough && alike {
            break;
        }
    }
    if until == Until::Near {
        return finish(&mut state, band).ok_or_else(|| singular.to_owned());
    }
    if P == SHAPED
        && let Some(clipped) = &state.clipped
        && state.pooled[3] > 0.98 * limits.most_contrast * clipped.seen
    {
        return Err("saturated: light or shadow is clipped at the end of the grey scale, and the flank does not state how far beyond it lies; expose less".to_owned());
    }
    if settled > 1e-4 && state.pooled[SIGMA] <= limits.least_sigma_px {
        return Err(format!(
            "its edges are sharper than pixels show them (blur below {} px): the picture was made smaller, or \
             sharpened; give it as the camera took it",
            limits.least_sigma_px
        ));
    }
    if settled > 1e-4 {
        return Err(format!("the fit does not settle (last change {settled:.1e} px)"));
    }
    finish(&mut state, band).ok_or_else(|| singular.to_owned())
}

/// Variance along a lever with the shape terms fixed.
fn known_shape<const P: usize>(normal: &Matrix<P>, lever: &Vector<P>) -> Option<f64> {
    let (normal, lever) = (normal.fixed_view::<POOLED, POOLED>(0, 0), lever.fixed_rows::<POOLED>(0));
    let covariance = normal.into_owned().try_inverse()?;
    Some(lever.dot(&(covariance * lever)))
}

/// Uncertainties from the inverse of the normal equations, pooled parameters and shifts together.
fn finish<const P: usize>(state: &mut State<P>, band: &Band) -> Option<EdgeFit> {
    state.sum_up(band);
    let sums = &state.sums;
    let (mut normal, mut lever, mut own, mut count) = (Matrix::<P>::zeros(), Vector::<P>::zeros(), 0.0, 0.0);
    let mut by_noise = (Vector::<P>::zeros(), 0.0);
    for (s, _) in sums.iter().zip(&state.sectors).filter(|(_, at)| at.good) {
        normal += s.normal - s.cross * s.cross.transpose() / s.own;
        lever += s.cross / s.own;
        own += s.own.recip();
        count += 1.0;
        by_noise.0 += s.by_noise.0 - s.cross * (s.by_noise.1 / s.own);
        by_noise.1 += s.by_noise.1 / s.own;
    }
    state.add_priors(&mut normal, &mut Vector::<P>::zeros());
    let covariance: Matrix<P> = normal.try_inverse()?;
    let root = covariance.cholesky()?.l();
    let calipers = sums
        .iter()
        .zip(&state.sectors)
        .zip(&band.sectors)
        .map(|((s, at), pixels)| {
            let pooled = s.cross / s.own.max(f64::MIN_POSITIVE);
            let row = root.transpose() * pooled;
            Caliper {
                shift: at.shift,
                u_own: s.own.recip().sqrt(),
                shared: std::array::from_fn(|k| if k < P { row[k] } else { 0.0 }),
                u_shift: (s.own.recip() + pooled.dot(&(covariance * pooled))).sqrt(),
                reduced_chi2: s.chi2 / (s.pixels - 1.0).max(1.0),
                good: at.good,
                crossing: if at.good { None } else { state.crossing(pixels) },
            }
        })
        .collect();
    let all = lever.dot(&(covariance * lever));
    // A lens that departs from its edge model in the visible part departs as much in the clipped
    // one.
    let amplitude = ShapeTermLimits::get().amplitude;
    let beyond = (POOLED..P).fold(1.0, |most: f64, k| most.max(state.pooled[k].abs() / amplitude));
    let shape = match beyond > 1.0 {
        true => (all - known_shape(&normal, &lever)?).max(0.0) * (beyond * beyond - 1.0),
        false => 0.0,
    };
    let noise = state.noise_known_to * (by_noise.1 - lever.dot(&(covariance * by_noise.0)));
    let u_mean =
        ((own + all + shape + noise * noise).sqrt() / count).hypot(state.u_rounding(&(lever / count)));
    let levels = (state.pooled[0], state.pooled[0] + state.pooled[3]);
    let noise = state.variance.0[1].sqrt();
    let misfit = state.variance.beyond_noise() / state.pooled[3];
    let pooled = std::array::from_fn(|k| state.pooled[k]);
    let begun = state.clipped.is_none().then_some(Begun { pooled, variance: state.variance });
    Some(EdgeFit { calipers, sigma: state.pooled[SIGMA], levels, u_mean, noise, misfit, begun })
}
