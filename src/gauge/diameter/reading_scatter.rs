//! Standard uncertainty of the mean of successive readings, from their scatter.
//!
//! Successive readings share drift, vibration and the rotation of the part: of n autocorrelated
//! ones only n_eff count (GUM 4.2.7; N. F. Zhang, Metrologia 43 (2006) S276),
//!
//! ```text
//! n/n_eff = 1 + 2 Σ_k (1 − k/n) ρ_k        u²(mean) = s²·(n − 1)/n/(n_eff − 1)
//! ```
//!
//! the second with the bias of s² under autocorrelation taken out; for n_eff = n it is s²/n. The
//! sum runs up to the first ρ_k below 0 (Geyer's initial sequence), and only where ρ₁ lies beyond
//! what independent readings show by chance (Bartlett: 1.96/√n): of fewer than five readings
//! nothing but their number is known.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::gauge::limit::limits;
use crate::gauge::width::reused::Reused;
use crate::profile::Diameter;

limits! {
    /// When successive readings are not independent.
    SeriesLimits = "reading_scatter";
    /// Autocorrelation at lag 1, in standard deviations 1/√n of independent readings, above which
    /// it counts (Bartlett): the two-sided 95 % quantile of a normal distribution, exceeded to this
    /// side by chance in 2.5 % of series.
    beyond_chance: f64 = 1.96;
}

/// False-alarm probability of the test whether readings scatter beyond their u.
pub(crate) const FALSE_ALARM_PROBABILITY: f64 = 1e-3;

/// χ² of readings about their mean against their own standard uncertainties.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct ScatterTest {
    /// Σ (x − mean)²/u².
    pub chi2: f64,
    /// Degrees of freedom.
    pub freedom: f64,
    /// Quantile of χ² at the false-alarm probability, for readings that scatter as their u implies.
    pub chi2_limit: f64,
    /// Probability that readings which scatter as their u implies exceed the limit: 10⁻³.
    pub false_alarm_probability: f64,
    /// Whether χ² lies beyond the limit.
    pub beyond_u: bool,
}

impl ScatterTest {
    /// Of (value, random standard uncertainty) about their weighted mean; `None` for fewer than
    /// two, or for a u that is not above 0.
    #[cfg(test)]
    pub(crate) fn of(readings: &[(f64, f64)]) -> Option<Self> {
        if readings.len() < 2 || !readings.iter().all(|(_, u)| *u > 0.0) {
            return None;
        }
        let weight: f64 = readings.iter().map(|(_, u)| u.powi(-2)).sum();
        let mean = readings.iter().map(|(x, u)| x * u.powi(-2)).sum::<f64>() / weight;
        let chi2 = readings.iter().map(|(x, u)| ((x - mean) / u).powi(2)).sum();
        Self::against(chi2, readings.len() as f64 - 1.0)
    }

    /// Of a χ² with its degrees of freedom; `None` where either is no number of its kind.
    pub(crate) fn against(chi2: f64, freedom: f64) -> Option<Self> {
        let distribution = ChiSquared::new(freedom).ok()?;
        let chi2_limit = distribution.inverse_cdf(1.0 - FALSE_ALARM_PROBABILITY);
        chi2.is_finite().then_some(Self {
            chi2,
            freedom,
            chi2_limit,
            false_alarm_probability: FALSE_ALARM_PROBABILITY,
            beyond_u: chi2 > chi2_limit,
        })
    }

    /// How many times larger than stated the scatter is.
    pub(crate) fn ratio(&self) -> f64 {
        (self.chi2 / self.freedom).sqrt()
    }
}

/// Number of independent readings whose mean scatters as that of these, 1 ..= n: `departures` are
/// from the mean, or from a value known.
pub(crate) fn effective_number(departures: &[f64]) -> f64 {
    let limits = SeriesLimits::get();
    let n = departures.len() as f64;
    let square: f64 = departures.iter().map(|d| d * d).sum();
    let correlation =
        |lag: usize| departures.iter().zip(&departures[lag..]).map(|(a, b)| a * b).sum::<f64>() / square;
    if departures.len() < 3 || !(square > 0.0) || !(correlation(1) > limits.beyond_chance / n.sqrt()) {
        return n;
    }
    let correlations = (1..departures.len()).map(|lag| (lag, correlation(lag)));
    let positive = correlations.take_while(|(_, rho)| *rho > 0.0);
    let sum: f64 = positive.map(|(lag, rho)| (1.0 - lag as f64 / n) * rho).sum();
    (n / (1.0 + 2.0 * sum)).clamp(1.0, n)
}

/// Mean of successive readings with its uncertainty from their scatter and from their stated u.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SeriesMean {
    /// Mean, its random standard uncertainty (the larger one of stated and scattered) and the
    /// common one, which no mean makes smaller.
    pub mean: Diameter,
    /// Experimental standard deviation of one reading, mm; 0 for a single one.
    pub sd_mm: f64,
    /// Equivalent number of independent readings.
    pub effective_number: f64,
}

impl SeriesMean {
    /// Of readings in their order; `None` without any.
    pub(crate) fn of(series: &[Diameter]) -> Option<Self> {
        let first = series.first()?;
        let n = series.len() as f64;
        // Sums about the first reading: a diameter of 25 mm must not round its nanometres.
        let d_mm = first.d_mm + series.iter().map(|d| d.d_mm - first.d_mm).sum::<f64>() / n;
        let departures = || series.iter().map(|d| d.d_mm - d_mm);
        let stated = series.iter().map(|d| d.u_random_mm.powi(2)).sum::<f64>().sqrt() / n;
        let u_common_mm = series.iter().map(|d| d.u_common_mm).sum::<f64>() / n;
        let square: f64 = departures().map(|d| d * d).sum();
        let sd_mm = (square / (n - 1.0).max(1.0)).sqrt();
        let effective_number = effective_number(&departures().collect::<Reused<f64>>());
        let scattered = (square / n / (effective_number - 1.0).max(1.0)).sqrt();
        Some(Self {
            mean: Diameter { d_mm, u_random_mm: stated.max(scattered), u_common_mm },
            sd_mm,
            effective_number,
        })
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_distr::Normal;
    use rand_pcg::Pcg64;

    use super::*;

    /// First-order autoregression of unit variance.
    fn autoregression(n: usize, phi: f64, random: &mut Pcg64) -> Vec<f64> {
        let normal = Normal::new(0.0, 1.0).unwrap();
        let mut x: f64 = random.sample(normal);
        (0..n)
            .map(|_| {
                let now = x;
                x = phi * x + (1.0 - phi * phi).sqrt() * random.sample(normal);
                now
            })
            .collect()
    }

    fn series(values: &[f64], u: f64) -> Vec<Diameter> {
        values.iter().map(|d_mm| Diameter { d_mm: *d_mm, u_random_mm: u, u_common_mm: 0.25 }).collect()
    }

    #[test]
    fn a_mean_is_as_uncertain_as_its_readings_scatter_and_keeps_their_common_part() {
        let mean = SeriesMean::of(&series(&[1.0, 2.0, 9.0, 4.0], 0.1)).unwrap();
        let sd = (38.0_f64 / 3.0).sqrt();
        assert!((mean.sd_mm - sd).abs() < 1e-12 && mean.effective_number == 4.0);
        assert!((mean.mean.u_random_mm - 0.5 * sd).abs() < 1e-12 && mean.mean.u_common_mm == 0.25);
        // Quieter than their u: the stated u stays.
        let quiet = SeriesMean::of(&series(&[5.0; 4], 0.1)).unwrap();
        assert!((quiet.mean.u_random_mm - 0.05).abs() < 1e-15 && quiet.sd_mm == 0.0);
        let one = SeriesMean::of(&series(&[5.0], 0.1)).unwrap();
        assert_eq!((one.mean.u_random_mm, one.effective_number), (0.1, 1.0));
        assert!(SeriesMean::of(&[]).is_none());
    }

    /// The mean of readings of autocorrelation φ^k scatters by √((1 + φ)/(1 − φ)/n); as independent
    /// readings it would by 1/√n.
    #[test]
    fn autocorrelated_readings_count_as_many_as_they_are_worth() {
        let mut random = Pcg64::seed_from_u64(9);
        for (n, phi, allowed) in [(60, 0.0, 0.10), (200, 0.5, 0.15), (200, 0.8, 0.20), (400, 0.9, 0.25)] {
            let (mut square, mut u_square, runs) = (0.0, 0.0, 1500);
            for _ in 0..runs {
                let values = autoregression(n, phi, &mut random);
                let mean = SeriesMean::of(&series(&values, 1e-6)).unwrap().mean;
                square += mean.d_mm.powi(2);
                u_square += mean.u_random_mm.powi(2);
            }
            let (sd, u) = ((square / f64::from(runs)).sqrt(), (u_square / f64::from(runs)).sqrt());
            let exact = ((1.0 + phi) / (1.0 - phi) / n as f64).sqrt();
            assert!((sd / exact - 1.0).abs() < 0.1, "{phi}: {sd} {exact}");
            assert!((u / sd - 1.0).abs() < allowed, "{phi}: u {u}, sd {sd}");
        }
    }

    #[test]
    fn a_drift_is_worth_few_readings() {
        let drift: Vec<f64> = (0..40).map(f64::from).collect();
        let mean = SeriesMean::of(&series(&drift, 1e-6)).unwrap();
        assert!((2.0..6.0).contains(&mean.effective_number), "{}", mean.effective_number);
        // Anywhere along the ramp: the mean's u is a good part of its half height over √3.
        assert!(mean.mean.u_random_mm > 5.0, "{}", mean.mean.u_random_mm);
    }

    #[test]
    fn the_test_of_scatter_calls_as_often_as_it_says() {
        let mut random = Pcg64::seed_from_u64(10);
        let normal = Normal::new(0.0, 1.0).unwrap();
        let called = |scale: f64, random: &mut Pcg64| {
            let runs = 20_000;
            let beyond = |_| {
                let readings: Vec<(f64, f64)> = (0..12)
                    .map(|i| (2.0, 0.5 + 0.1 * f64::from(i)))
                    .map(|(m, u)| (m + scale * u * random.sample(normal), u))
                    .collect();
                ScatterTest::of(&readings).unwrap().beyond_u
            };
            (0..runs).map(beyond).filter(|b| *b).count() as f64 / f64::from(runs)
        };
        let false_alarms = called(1.0, &mut random);
        assert!((2e-4..2.2e-3).contains(&false_alarms), "{false_alarms}");
        assert!(called(3.0, &mut random) > 0.97);
        assert!(
            ScatterTest::of(&[(1.0, 0.0), (2.0, 0.1)]).is_none() && ScatterTest::of(&[(1.0, 0.1)]).is_none()
        );
    }
}
