//! Levels, blur and shape of a side's edges from many columns at once, the position of each column
//! eliminated.

use nalgebra::{DMatrix, DVector};

use super::level::Level;
use super::score::{Column, Likelihood, Score};
use crate::gauge::edge::image::scan_windows::Windows;
use crate::gauge::edge::model::gaussian::column_sigma;
use crate::gauge::edge::model::shape_terms::{ShapeTermLimits, TERMS};
use crate::gauge::limit::limits;

limits! {
    /// What the joint fit may assume, and what determines the noise of a clipped level.
    JointLimits = "censored_joint";
    /// Upper bound of the light above dark in the fit, as a multiple of the part of it that is
    /// seen: where three quarters of an edge are hidden, the flank hardly determines its height.
    /// Tuned: see study limits.
    brightest: f64 = 4.0;
    /// Reduced χ² that is still explained by noise: its variance is known to a few per cent. Tuned:
    /// see study limits.
    explained: f64 = 1.1;
    /// Least expected sum of squares over the shadow's pixels between the ends from which their
    /// noise is estimated: its relative standard uncertainty is then √(2/50)/2, a tenth.
    own_noise: f64 = 50.0;
    /// Least expected square of one of these pixels, in units of the noise variance, zφ(z) + 1 −
    /// Φ(z): it is .40 for a shadow z = 1 standard deviation below the border of the end and .26 at
    /// one and a half; where only the tail is seen, level and noise cannot be separated.
    own_share: f64 = 0.35;
    /// Excess of their squares above which the noise is estimated from them nevertheless: the noise
    /// line is wrong by a quarter (√1.5).
    contradicts: f64 = 1.5;
    /// The noise is estimated from columns free of stray pixels where at least one of so many
    /// columns is free; stray pixels are hot pixels where one of so many is hot in the flat shadow,
    /// which fills a third of a window.
    one_free_of: usize = 4;
    /// Fewest columns that levels are estimated from: four for each of nine knots.
    least_free: usize = 36;
    /// Relative uncertainty of the noise in the dark from a straight line through light and flank:
    /// a sensor's non-uniformity of 1 % grows with the square of the level, and lowers the dark end
    /// of the line by a quarter of an 8-bit camera's dark noise.
    of_line: f64 = 0.25;
    /// Largest relative standard uncertainty of a noise: at 1 its interval reaches 0, and it is
    /// unknown.
    most_unknown: f64 = 1.0;
}

/// The joint fit.
#[derive(Clone, Debug)]
pub(super) struct Joint<'a> {
    pub(super) likelihood: Likelihood<'a>,
    pub(crate) dark: Level,
    pub(crate) light: Level,
    pub(crate) sigma: f64,
    /// Standard uncertainty of a blur that is given, px.
    pub(super) sigma_prior: Option<(f64, f64)>,
    /// Columns fitted.
    pub(crate) columns: Vec<FittedColumn>,
}

/// A column of the joint fit.
#[derive(Clone, Copy, Debug)]
pub(super) struct FittedColumn {
    /// Column of the frame.
    pub(crate) index: usize,
    /// Place of its edge, px from the central pixel.
    pub(crate) place: f64,
}

/// Sums over the columns.
struct Sums {
    normal: DMatrix<f64>,
    right: DVector<f64>,
    chi2: f64,
    informative: f64,
    flank: [f64; 2],
    on_flank: f64,
    in_dark: [f64; 3],
    /// Change of `right` by a relative change of the noise.
    by_noise: DVector<f64>,
}

impl Sums {
    fn add_noise(&mut self, score: &Score) {
        self.on_flank += score.on_flank;
        self.in_dark.iter_mut().zip(score.in_dark).for_each(|(sum, one)| *sum += one);
        self.flank = [self.flank[0] + score.flank[0], self.flank[1] + score.flank[1]];
    }
}

/// Result of a converged fit.
#[derive(Clone, Debug)]
pub(super) struct Settled {
    /// Covariance of dark, light, blur and shape terms.
    covariance: DMatrix<f64>,
    /// The same with the shape terms fixed.
    known_shape: DMatrix<f64>,
    /// Their sensitivity to the noise in the light times its uncertainty.
    by_noise: DVector<f64>,
    /// Relative standard uncertainty of that noise.
    noise_known_to: f64,
    /// χ² over its expectation.
    pub(crate) reduced_chi2: f64,
    /// Logarithm of the likelihood.
    pub(crate) log_likelihood: f64,
    /// Number of columns fitted.
    pub(crate) columns: usize,
    /// Mean number of pixels of a column that state a grey value.
    pub(super) informative: f64,
}

/// Entries of a column's parameters among all: (index of all, index in the column's score, weight).
type Entries = [(usize, usize, f64); 4 + 1 + TERMS];

impl Joint<'_> {
    /// The column in the middle of those fitted.
    pub(super) fn middle(&self) -> usize {
        self.columns[self.columns.len() / 2].index
    }

    fn count(&self) -> usize {
        self.dark.knots.len() + self.light.knots.len() + 1 + TERMS
    }

    fn entries(&self, column: usize) -> Entries {
        let (dark, light) = (self.dark.around(column), self.light.around(column));
        let first = self.dark.knots.len();
        let sigma = first + self.light.knots.len();
        [
            (dark.0, 1, 1.0 - dark.2),
            (dark.1, 1, dark.2),
            (first + light.0, 2, 1.0 - light.2),
            (first + light.1, 2, light.2),
            (sigma, 3, 1.0),
            (sigma + 1, 4, 1.0),
            (sigma + 2, 5, 1.0),
        ]
    }

    pub(crate) fn column(&self, column: usize, slope: f32) -> Column {
        Column {
            dark: self.dark.at(column),
            light: self.light.at(column),
            sigma: column_sigma(self.sigma, f64::from(slope)),
        }
    }

    fn sums(&self, windows: &Windows, slope: &[f32]) -> (Sums, Vec<Score>) {
        let n = self.count();
        let mut sums = Sums {
            normal: DMatrix::zeros(n, n),
            right: DVector::zeros(n),
            chi2: 0.0,
            informative: 0.0,
            flank: [0.0; 2],
            on_flank: 0.0,
            in_dark: [0.0; 3],
            by_noise: DVector::zeros(n),
        };
        let mut scores = Vec::with_capacity(self.columns.len());
        for &FittedColumn { index: column, place } in &self.columns {
            let at = self.column(column, slope[column]);
            let score = self.likelihood.score(windows.of(column), place, at);
            let own = score.information[(0, 0)];
            scores.push(score);
            if !(own > 0.0) {
                continue;
            }
            let entries = self.entries(column);
            for (i, a, wa) in entries {
                let cross = score.information[(a, 0)];
                sums.right[i] += wa * (score.gradient[a] - cross * score.gradient[0] / own);
                sums.by_noise[i] += wa * (score.by_noise[a] - cross * score.by_noise[0] / own);
                for (j, b, wb) in entries {
                    let eliminated = cross * score.information[(b, 0)] / own;
                    sums.normal[(i, j)] += wa * wb * (score.information[(a, b)] - eliminated);
                }
            }
        }
        // A hot pixel moves its column's place and so its other residuals, which show no noise.
        // Where strays are no hot pixels but a systematic residual,
        // or few columns are free of them, all count.
        let total = |of: fn(&Score) -> usize| scores.iter().map(of).sum::<usize>();
        let one_of = JointLimits::get().one_free_of;
        let hot = one_of * total(|score| score.hot) > total(|score| score.stray);
        let free = scores.iter().filter(|score| score.stray == 0).count();
        let all = !hot || one_of * free < scores.len();
        for score in scores.iter().filter(|score| score.information[(0, 0)] > 0.0) {
            sums.chi2 += score.chi2;
            sums.informative += (score.informative - 1.0).max(0.0);
            if all || score.stray == 0 {
                sums.add_noise(score);
            }
        }
        self.add_priors(&mut sums);
        (sums, scores)
    }

    fn log_likelihood(&self, windows: &Windows, slope: &[f32]) -> f64 {
        let of = |&FittedColumn { index: column, place }: &FittedColumn| {
            let at = self.column(column, slope[column]);
            self.likelihood.log_likelihood(windows.of(column), place, at)
        };
        self.columns.iter().map(of).sum()
    }

    fn add_priors(&self, sums: &mut Sums) {
        let sigma = self.dark.knots.len() + self.light.knots.len();
        let mut add = |index: usize, off: f64, u: f64| {
            sums.normal[(index, index)] += u.powi(-2);
            sums.right[index] -= off / (u * u);
        };
        for (first, level) in [(0, &self.dark), (self.dark.knots.len(), &self.light)] {
            if let Some(u) = level.prior {
                add(first, level.knots[0], u);
            }
        }
        if let Some((given, u)) = self.sigma_prior {
            add(sigma, self.sigma - given, u);
        }
        for (k, amplitude) in self.likelihood.terms.iter().enumerate() {
            add(sigma + 1 + k, *amplitude, ShapeTermLimits::get().amplitude);
        }
        // Knots without data are tied to their neighbours.
        for (first, level) in [(0, &self.dark), (self.dark.knots.len(), &self.light)] {
            for k in first..first + level.knots.len() - 1 {
                let lean = 1e-6 * (sums.normal[(k, k)] + sums.normal[(k + 1, k + 1)]) + 1e-12;
                let apart = level.knots[k + 1 - first] - level.knots[k - first];
                for (i, sign) in [(k, 1.0), (k + 1, -1.0)] {
                    sums.normal[(i, i)] += lean;
                    sums.right[i] += sign * lean * apart;
                }
                sums.normal[(k, k + 1)] -= lean;
                sums.normal[(k + 1, k)] -= lean;
            }
        }
    }

    /// One step of Fisher scoring; the largest change as a share of contrast or blur. `None` where
    /// the equations are singular.
    fn step(&mut self, windows: &Windows, slope: &[f32], seen: f64) -> Option<f64> {
        let (sums, scores) = self.sums(windows, slope);
        let step = sums.normal.cholesky()?.solve(&sums.right);
        let (kd, kl) = (self.dark.knots.len(), self.light.knots.len());
        let middle = self.middle();
        let contrast = self.light.at(middle) - self.dark.at(middle);
        let levels = step.rows(0, kd + kl).amax();
        let terms = step.rows(kd + kl + 1, TERMS).amax();
        let tame = |step: f64, limit: f64| (limit / step.abs().max(f64::MIN_POSITIVE)).min(1.0);
        let scale = tame(levels, 0.2 * contrast)
            .min(tame(step[kd + kl], 0.25 * self.sigma))
            .min(tame(terms, 2.0 * ShapeTermLimits::get().amplitude));
        let step = step * scale;
        for k in 0..kd {
            self.dark.knots[k] += step[k];
        }
        for k in 0..kl {
            self.light.knots[k] += step[kd + k];
        }
        self.sigma = (self.sigma + step[kd + kl]).clamp(0.15, 8.0);
        for k in 0..TERMS {
            self.likelihood.terms[k] += step[kd + kl + 1 + k];
        }
        for (k, score) in scores.iter().enumerate() {
            let own = score.information[(0, 0)];
            if !(own > 0.0) {
                continue;
            }
            let FittedColumn { index: column, place } = self.columns[k];
            let mut gradient = score.gradient[0];
            for (index, local, weight) in self.entries(column) {
                gradient -= score.information[(local, 0)] * weight * step[index];
            }
            self.columns[k].place = (place + (gradient / own).clamp(-0.5, 0.5)).clamp(-9.0, 9.0);
        }
        self.keep_in_bounds(seen);
        Some((levels / contrast).max(step[kd + kl].abs() / self.sigma))
    }

    /// The darkest shadow and the brightest light that free levels may have, counts:
    /// [`JointLimits::brightest`] times what is seen of the contrast.
    fn farthest(&self, seen: f64) -> [f64; 2] {
        let (ends, beyond) = (self.likelihood.ends, (JointLimits::get().brightest - 1.0) * seen);
        [ends.low - beyond, ends.high + beyond]
    }

    /// Keeps free levels between that and the middle of what is seen.
    fn keep_in_bounds(&mut self, seen: f64) {
        let (ends, [darkest, brightest]) = (self.likelihood.ends, self.farthest(seen));
        if self.light.prior.is_none() && ends.high.is_finite() {
            let low = ends.high - 0.7 * seen;
            self.light.knots.iter_mut().for_each(|knot| *knot = knot.clamp(low, brightest));
        }
        if self.dark.prior.is_none() && ends.low.is_finite() {
            let high = ends.low + 0.7 * seen;
            self.dark.knots.iter_mut().for_each(|knot| *knot = knot.clamp(darkest, high));
        }
    }

    /// Whether a free level has stopped at its bound.
    pub(super) fn is_at_bound(&self, seen: f64) -> bool {
        let [darkest, brightest] = self.farthest(seen);
        let stopped = |level: &Level, bound: f64| level.prior.is_none() && level.knots.contains(&bound);
        stopped(&self.dark, darkest) || stopped(&self.light, brightest)
    }

    /// Fits until nothing changes; `seen` is the contrast between the ends of what is seen, counts.
    /// `None` where the columns do not determine it.
    pub(crate) fn settle(&mut self, windows: &Windows, slope: &[f32], seen: f64) -> Option<Settled> {
        for round in 0..3 {
            let middle = self.middle();
            self.likelihood.separate(windows.width, self.column(middle, 0.0));
            self.likelihood.strict = round > 1;
            for _ in 0..40 {
                if self.step(windows, slope, seen)? < 1e-5 {
                    break;
                }
            }
            self.learn_noise(windows, slope);
        }
        let (sums, _) = self.sums(windows, slope);
        let n = self.count();
        let fixed = sums.normal.view((0, 0), (n - TERMS, n - TERMS)).into_owned().try_inverse()?;
        let mut known_shape = DMatrix::zeros(n, n);
        known_shape.view_mut((0, 0), (n - TERMS, n - TERMS)).copy_from(&fixed);
        let noise_known_to = self.noise_known_to(&sums);
        let covariance = sums.normal.try_inverse()?;
        Some(Settled {
            by_noise: &covariance * sums.by_noise * noise_known_to,
            noise_known_to,
            covariance,
            known_shape,
            reduced_chi2: sums.chi2 / sums.informative.max(1.0),
            log_likelihood: self.log_likelihood(windows, slope),
            columns: self.columns.len(),
            informative: sums.informative / self.columns.len() as f64,
        })
    }

    /// Leaves the columns out that show a stray pixel, a hot one of the sensor as a rule, where as
    /// many as state the noise are free of them: the remaining influence of a stray pixel moves the
    /// levels, and those move all edges alike.
    pub(super) fn leave_out_strays(&mut self, windows: &Windows, slope: &[f32]) {
        let (_, scores) = self.sums(windows, slope);
        let free = scores.iter().filter(|score| score.stray == 0).count();
        let JointLimits { least_free, one_free_of, .. } = *JointLimits::get();
        if free < least_free || one_free_of * free < scores.len() {
            return;
        }
        let mut is_free = scores.iter().map(|score| score.stray == 0);
        self.columns.retain(|_| is_free.next().unwrap_or(true));
    }

    /// The gain from the scatter on the flank, the unexplained variance from what the noise leaves
    /// of χ².
    fn learn_noise(&mut self, windows: &Windows, slope: &[f32]) {
        let (sums, _) = self.sums(windows, slope);
        let [square, level] = sums.flank;
        let middle = self.middle();
        let (dark, light) = (self.dark.at(middle), self.light.at(middle));
        let own = self.own_noise(&sums);
        let noise = &mut self.likelihood.noise;
        if let Some(ratio) = own {
            noise.gain = ((noise.variance - ratio * noise.at(dark)) / (light - dark)).max(0.0);
        } else if level != 0.0 {
            noise.gain = (square / level).max(0.0);
        }
        let (sums, _) = self.sums(windows, slope);
        let reduced_chi2 = sums.chi2 / sums.informative.max(1.0);
        let mid = self.likelihood.noise.at(0.5 * (dark + light));
        self.likelihood.noise.unexplained = (reduced_chi2 - JointLimits::get().explained).max(0.0) * mid;
    }

    /// Excess scatter of the flat shadow's own pixels, where it is clipped in part, over the noise
    /// assumed; `None` of too few.
    fn own_noise(&self, sums: &Sums) -> Option<f64> {
        let [chi2, expected, pixels] = sums.in_dark;
        let JointLimits { contradicts, own_noise, own_share, .. } = *JointLimits::get();
        let contradicted = chi2 > contradicts * expected;
        let enough = expected > own_noise && (expected > own_share * pixels || contradicted);
        (self.likelihood.ends.low.is_finite() && enough).then(|| chi2 / expected)
    }

    /// Relative standard uncertainty of the noise of a clipped level. The variance on the flank is
    /// known to √(2/n); its departure from that of the known level is extrapolated about twice as
    /// far; the root has half of it.
    fn noise_known_to(&self, sums: &Sums) -> f64 {
        let middle = self.middle();
        let (dark, light) = (self.dark.at(middle), self.light.at(middle));
        if self.own_noise(sums).is_some() {
            return (0.5 / sums.in_dark[1]).sqrt();
        }
        let limits = JointLimits::get();
        let noise = &self.likelihood.noise;
        let (clipped, of_line) =
            if self.likelihood.ends.low.is_finite() { (dark, limits.of_line) } else { (light, 0.0) };
        let known_to =
            (2.0 / sums.on_flank.max(2.0)).sqrt() * noise.at(0.5 * (dark + light)) / noise.at(clipped);
        known_to.hypot(of_line).min(limits.most_unknown)
    }

    /// The amplitudes of the shape terms over their assumed standard uncertainty, at least 1: a
    /// lens that departs from its edge model in the visible part departs as much in the clipped
    /// one.
    pub(super) fn beyond_presumed(&self) -> f64 {
        let amplitude = ShapeTermLimits::get().amplitude;
        self.likelihood.terms.iter().fold(1.0, |most: f64, a| most.max(a.abs() / amplitude))
    }

    /// Variance of a column's position by the common parameters: in all, and with the shape fixed;
    /// px².
    pub(crate) fn shared(&self, settled: &Settled, column: usize, score: &Score) -> (f64, f64) {
        let own = score.information[(0, 0)];
        let mut lever = DVector::zeros(self.count());
        for (index, local, weight) in self.entries(column) {
            lever[index] -= weight * score.information[(local, 0)] / own;
        }
        let along = |covariance: &DMatrix<f64>| lever.dot(&(covariance * &lever)).max(0.0);
        let by_noise =
            (lever.dot(&settled.by_noise) + settled.noise_known_to * score.by_noise[0] / own).powi(2);
        (along(&settled.covariance) + by_noise, along(&settled.known_shape) + by_noise)
    }
}

#[cfg(test)]
mod tests;
