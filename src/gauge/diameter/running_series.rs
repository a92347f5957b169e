//! Mean, scatter and effective number of a series of readings of any length, in constant memory.
//!
//! The mean of a series is as uncertain as its readings scatter, counted by their autocorrelation
//! ([`SeriesMean`]). Every reading is kept up to [`MOST_BLOCKS`]; then neighbours are merged in
//! pairs, again and again: the means of blocks scatter as the series does over longer times, and
//! the variance of the mean of all is that of the blocks' mean (Flyvbjerg and Petersen, J. Chem.
//! Phys. 91 (1989) 461). χ² needs sums only.

use super::reading_scatter::{ScatterTest, SeriesMean, effective_number};
use super::reading_series::RunningStatistics;
use crate::gauge::width::reused::Reused;
use crate::profile::Diameter;

/// Blocks kept: the scatter of 2048 or more is known to 1.6 %.
const MOST_BLOCKS: usize = 4096;

/// A series in progress.
#[derive(Clone, Debug)]
pub(crate) struct RunningSeries {
    values: RunningStatistics,
    /// Random variances of the readings, mm².
    noise: RunningStatistics,
    /// Their common standard uncertainties, mm.
    common: RunningStatistics,
    weighted: Weighted,
    blocks: Blocks,
}

impl Default for RunningSeries {
    fn default() -> Self {
        Self {
            values: RunningStatistics::default(),
            noise: RunningStatistics::default(),
            common: RunningStatistics::default(),
            weighted: Weighted::default(),
            blocks: Blocks { means: Vec::with_capacity(MOST_BLOCKS), size: 1, open: (0.0, 0) },
        }
    }
}

impl RunningSeries {
    /// Takes a reading.
    pub(crate) fn push(&mut self, reading: Diameter) {
        self.values.push(reading.d_mm);
        self.noise.push(reading.u_random_mm.powi(2));
        self.common.push(reading.u_common_mm);
        self.weighted.push(reading.d_mm, reading.u_random_mm);
        self.blocks.push(reading.d_mm);
    }

    /// Diameters, mm.
    pub(crate) fn values(&self) -> &RunningStatistics {
        &self.values
    }

    /// Mean of the readings' random variances, mm².
    pub(crate) fn noise_mm2(&self) -> f64 {
        self.noise.mean()
    }

    /// χ² of the readings about their weighted mean against their own random uncertainties.
    pub(crate) fn scatter(&self) -> Option<ScatterTest> {
        let Weighted { square, usable, .. } = self.weighted;
        let count = self.values.count();
        (usable && count > 1).then(|| ScatterTest::against(square, count as f64 - 1.0)).flatten()
    }

    /// The mean with its uncertainty; `None` without a reading.
    pub(crate) fn mean(&self) -> Option<SeriesMean> {
        let n = self.values.count() as f64;
        if n == 0.0 {
            return None;
        }
        let sd_mm = if n > 1.0 { self.values.sd() } else { 0.0 };
        let variance = sd_mm * sd_mm * (n - 1.0) / n;
        let (variance_of_blocks, blocks) = self.blocks.scatter(self.values.mean());
        let scattered = variance_of_blocks / (blocks - 1.0).max(1.0);
        let effective_number = match self.blocks.size {
            1 => blocks,
            _ if scattered > 0.0 => (variance / scattered + 1.0).clamp(1.0, n),
            _ => n,
        };
        let stated = (self.noise.mean() / n).sqrt();
        let u_random_mm = stated.max(scattered.sqrt());
        let mean = Diameter { d_mm: self.values.mean(), u_random_mm, u_common_mm: self.common.mean() };
        Some(SeriesMean { mean, sd_mm, effective_number })
    }
}

/// Weighted mean and squares about it (West, Comm. ACM 22 (1979) 532).
#[derive(Clone, Copy, Debug)]
struct Weighted {
    weight: f64,
    mean: f64,
    square: f64,
    /// Whether every reading has a u above 0.
    usable: bool,
}

impl Default for Weighted {
    fn default() -> Self {
        Self { weight: 0.0, mean: 0.0, square: 0.0, usable: true }
    }
}

impl Weighted {
    fn push(&mut self, value: f64, u: f64) {
        if !(u > 0.0) {
            self.usable = false;
            return;
        }
        let weight = u.powi(-2);
        self.weight += weight;
        let off = value - self.mean;
        self.mean += off * weight / self.weight;
        self.square += weight * off * (value - self.mean);
    }
}

/// Means of blocks of successive readings.
#[derive(Clone, Debug)]
struct Blocks {
    means: Vec<f64>,
    /// Readings of a whole block.
    size: u64,
    /// Sum and number of the readings of the block in progress.
    open: (f64, u64),
}

impl Blocks {
    fn push(&mut self, value: f64) {
        self.open = (self.open.0 + value, self.open.1 + 1);
        if self.open.1 < self.size {
            return;
        }
        if self.means.len() == MOST_BLOCKS {
            for k in 0..MOST_BLOCKS / 2 {
                self.means[k] = 0.5 * (self.means[2 * k] + self.means[2 * k + 1]);
            }
            self.means.truncate(MOST_BLOCKS / 2);
            self.size *= 2;
            return;
        }
        self.means.push(self.open.0 / self.size as f64);
        self.open = (0.0, 0);
    }

    /// Mean square of the blocks about a mean, and their effective number; the block in progress is
    /// left out.
    fn scatter(&self, mean: f64) -> (f64, f64) {
        let departures: Reused<f64> = self.means.iter().map(|m| m - mean).collect();
        let square = departures.iter().map(|d| d * d).sum::<f64>();
        (square / (departures.len() as f64).max(1.0), effective_number(&departures))
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_distr::Normal;
    use rand_pcg::Pcg64;

    use super::*;

    fn series(n: usize, phi: f64, seed: u64) -> Vec<Diameter> {
        let mut random = Pcg64::seed_from_u64(seed);
        let normal = Normal::new(0.0, 1e-3).unwrap();
        let mut x = 0.0;
        (0..n)
            .map(|k| {
                x = phi * x + random.sample(normal);
                Diameter { d_mm: 25.0 + x, u_random_mm: 1e-4 * (1 + k % 3) as f64, u_common_mm: 2e-4 }
            })
            .collect()
    }

    fn running(series: &[Diameter]) -> RunningSeries {
        let mut running = RunningSeries::default();
        series.iter().for_each(|d| running.push(*d));
        running
    }

    #[test]
    fn a_short_series_is_that_of_all_its_readings() {
        for (n, phi) in [(1, 0.0), (2, 0.0), (50, 0.9), (MOST_BLOCKS, 0.5)] {
            let all = series(n, phi, 3);
            let (found, right) = (running(&all), SeriesMean::of(&all).unwrap());
            let mean = found.mean().unwrap();
            assert!((mean.mean.d_mm - right.mean.d_mm).abs() < 1e-13, "{n}");
            assert!((mean.mean.u_random_mm / right.mean.u_random_mm - 1.0).abs() < 1e-9, "{n}");
            assert!((mean.effective_number / right.effective_number - 1.0).abs() < 1e-9, "{n}");
            assert!((mean.sd_mm - right.sd_mm).abs() < 1e-13 && mean.mean.u_common_mm == 2e-4, "{n}");
            let readings: Vec<(f64, f64)> = all.iter().map(|d| (d.d_mm, d.u_random_mm)).collect();
            match (found.scatter(), ScatterTest::of(&readings)) {
                (Some(a), Some(b)) => assert!((a.chi2 / b.chi2 - 1.0).abs() < 1e-9 && a.freedom == b.freedom),
                (a, b) => assert_eq!((a, b), (None, None)),
            }
        }
        assert!(RunningSeries::default().mean().is_none());
    }

    /// Merged blocks give the u of the mean that all readings give, of independent and of
    /// correlated ones, and the memory does not grow.
    #[test]
    fn a_long_series_is_as_uncertain_in_constant_memory() {
        for phi in [0.0, 0.8, 0.99] {
            let all = series(60_000, phi, 5);
            let (found, right) = (running(&all), SeriesMean::of(&all).unwrap());
            assert!(found.blocks.means.capacity() == MOST_BLOCKS && found.blocks.size == 16);
            let mean = found.mean().unwrap();
            let ratio = mean.mean.u_random_mm / right.mean.u_random_mm;
            assert!((ratio - 1.0).abs() < 0.1, "{phi}: {ratio}");
            assert!((mean.effective_number / right.effective_number - 1.0).abs() < 0.2, "{phi}");
            assert!((mean.mean.d_mm - right.mean.d_mm).abs() < 1e-12);
        }
    }

    #[test]
    fn a_reading_without_u_has_no_test_of_scatter() {
        let mut all = series(5, 0.0, 1);
        assert!(running(&all).scatter().is_some());
        all[2].u_random_mm = 0.0;
        assert!(running(&all).scatter().is_none());
    }
}
