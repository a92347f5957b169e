//! The mean over a whole station from the columns that were seen of it.
//!
//! Fields that overlap show a part of a station twice, and a gap leaves a part out; on a taper the
//! plain mean of the columns is then pulled by slope · (their centroid − the station's middle). A
//! parabola through the columns is averaged over the whole station instead, a line where they do
//! not carry one, their plain mean where they do not carry that. By how much the next better
//! description differs from the one taken is what was not seen of the station: it is the same at
//! every angle, so that angles do not average it.

use crate::gauge::limit::limits;
use nalgebra::{Matrix3, Vector3};

use super::bursts::Shown;

limits! {
    /// Which polynomial the columns of a station carry.
    StationMeanLimits = "station_mean";
    /// Variance of a station's mean over that of its columns' plain mean, below which a slope or
    /// bend is adjusted within it: half a station carries a line (exactly 4), two thirds a
    /// parabola.
    most_gain: f64 = 4.0;
    /// Fewest columns whose line states what was not seen: two lie on any line.
    least_columns: f64 = 3.0;
}

/// Sums over the columns seen of a station.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct StationColumns {
    /// Σ tᵏ for k = 0 to 4, t the distance from the station's middle over half its length.
    powers: [f64; 5],
    /// Σ tᵏ·value for k = 0 to 2.
    values: [f64; 3],
}

/// A station's mean and what it rests on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct StationMean {
    /// Mean over the station.
    pub(crate) mean: f64,
    /// Variance of it over that of the columns' plain mean, by what each column has for itself; 1
    /// at least.
    pub(crate) gain: f64,
    /// Mean by the next better description less this one.
    pub(crate) rest: f64,
    /// Variance of that difference by noise over that of the columns' plain mean.
    pub(crate) rest_gain: f64,
}

impl Shown for StationColumns {
    fn columns(&self) -> usize {
        self.powers[0] as usize
    }

    fn join(&mut self, other: &Self) {
        self.powers.iter_mut().zip(other.powers).for_each(|(sum, more)| *sum += more);
        self.values.iter_mut().zip(other.values).for_each(|(sum, more)| *sum += more);
    }
}

impl StationColumns {
    /// Adds a column at `t` from the station's middle (1: its end).
    pub(crate) fn add(&mut self, t: f64, value: f64) {
        let mut power = 1.0;
        for k in 0..5 {
            self.powers[k] += power;
            if k < 3 {
                self.values[k] += power * value;
            }
            power *= t;
        }
    }

    /// Mean over the whole station.
    pub(crate) fn mean(&self) -> StationMean {
        let limits = StationMeanLimits::get();
        let plain = (self.values[0] / self.powers[0], 1.0);
        let (line, parabola) = (self.fitted(2), self.fitted(3));
        let carried = |fit: Option<(f64, f64)>| fit.filter(|f| f.1 < limits.most_gain);
        let known = self.powers[0] >= limits.least_columns;
        let (taken, better) = match (carried(parabola), carried(line)) {
            (Some(parabola), _) => (parabola, None),
            (None, Some(line)) => (line, parabola.filter(|_| known)),
            (None, None) => (plain, line.filter(|_| known)),
        };
        // The descriptions are nested least squares: the variance of their difference is the
        // difference of their variances.
        let (rest, rest_gain) = better.map_or((0.0, 0.0), |b| (b.0 - taken.0, (b.1 - taken.1).max(0.0)));
        StationMean { mean: taken.0, gain: taken.1.max(1.0), rest, rest_gain }
    }

    /// Mean over the station of the least-squares polynomial of `terms` terms, and its variance
    /// over that of the plain mean.
    fn fitted(&self, terms: usize) -> Option<(f64, f64)> {
        let n = self.powers[0];
        if n < terms as f64 {
            return None;
        }
        let start = self.values[0] / n;
        let normal = Matrix3::from_fn(|i, j| match (i < terms && j < terms, i == j) {
            (true, _) => self.powers[i + j],
            (false, same) => f64::from(u8::from(same)),
        });
        let right =
            Vector3::from_fn(|i, _| if i < terms { self.values[i] - start * self.powers[i] } else { 0.0 });
        // Over the station the mean of t² is a third.
        let over = Vector3::new(1.0, 0.0, if terms == 3 { 1.0 / 3.0 } else { 0.0 });
        let inverse = normal.try_inverse()?;
        let (mean, gain) = (start + over.dot(&(inverse * right)), n * over.dot(&(inverse * over)));
        (mean.is_finite() && gain.is_finite() && gain > 0.0).then_some((mean, gain))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(pieces: &[(f64, f64)], value: impl Fn(f64) -> f64) -> StationMean {
        let mut columns = StationColumns::default();
        for (from, to) in pieces {
            let n = ((to - from) * 200.0).round();
            (0..n as u32)
                .map(|k| from + (to - from) * (f64::from(k) + 0.5) / n)
                .for_each(|t| columns.add(t, value(t)));
        }
        columns.mean()
    }

    #[test]
    fn a_sloping_line_seen_twice_in_a_part_of_a_station_is_not_pulled_there() {
        let bent = |t: f64| 0.3 + 0.01 * t - 0.002 * t * t;
        let both = seen(&[(-1.0, 1.0), (0.2, 1.0)], bent);
        assert!((both.mean - (0.3 - 0.002 / 3.0)).abs() < 1e-12, "{both:?}");
        assert!((1.0..1.5).contains(&both.gain) && both.rest.abs() < 1e-12, "{both:?}");
        let piece = seen(&[(0.5, 1.0)], bent);
        assert!((piece.mean - bent(0.75)).abs() < 1e-3, "too little is seen to go beyond it: {piece:?}");
    }

    #[test]
    fn what_was_not_seen_of_a_taper_is_taken_off_or_stated() {
        let taper = |t: f64| 25.0 + 0.01 * t;
        // More than half of it carries a line.
        for part in [(-1.0, 0.2), (-0.3, 1.0), (-0.6, 0.6)] {
            let found = seen(&[part], taper);
            assert!((found.mean - 25.0).abs() < 1e-10 && found.rest.abs() < 1e-10, "{found:?}");
            // What such a line misses of a bend is stated, to a tenth.
            let bent = seen(&[part], |t| taper(t) + 0.003 * t * t);
            let off = 25.001 - bent.mean;
            assert!((off - bent.rest).abs() < 1e-10, "{off} {bent:?}");
        }
        for part in [(-1.0, -0.4), (0.1, 0.9)] {
            let found = seen(&[part], taper);
            assert!((found.mean - taper(0.5 * (part.0 + part.1))).abs() < 1e-10, "{found:?}");
            assert!((25.0 - found.mean - found.rest).abs() < 1e-10, "{found:?}");
        }
        let mut two = StationColumns::default();
        [0.7, 0.8].into_iter().for_each(|t| two.add(t, t));
        assert!(two.mean().rest == 0.0 && (two.mean().mean - 0.75).abs() < 1e-12);
        let mut one = StationColumns::default();
        one.add(0.4, 7.0);
        assert_eq!(one.mean(), StationMean { mean: 7.0, gain: 1.0, rest: 0.0, rest_gain: 0.0 });
    }

    #[test]
    fn gains_are_what_noise_does() {
        use rand::SeedableRng;
        use rand_distr::{Distribution, StandardNormal};
        let mut rng = rand_pcg::Pcg64::seed_from_u64(11);
        for part in [(-1.0, 0.2), (-1.0, 0.7), (0.2, 1.0)] {
            let (mut square, mut rests, mut stated) = (0.0, 0.0, StationMean::default());
            let columns = 200.0 * (part.1 - part.0);
            for _ in 0..2000 {
                let draws: Vec<f64> = (0..1000).map(|_| StandardNormal.sample(&mut rng)).collect();
                stated = seen(&[part], |t| draws[((t + 1.0) * 400.0) as usize]);
                square += stated.mean.powi(2) * columns / 2000.0;
                rests += stated.rest.powi(2) * columns / 2000.0;
            }
            // 2000 draws show a variance to 3 %.
            assert!((square / stated.gain - 1.0).abs() < 0.1, "{square} {stated:?}");
            assert!((rests - stated.rest_gain).abs() < 0.1 * rests + 1e-9, "{rests} {stated:?}");
        }
    }
}
