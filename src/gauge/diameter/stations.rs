//! From the frames of a scan to one diameter a station.
//!
//! Every column lies at z = z_frame + (column − c0)·p. For each spindle angle the columns of a station are averaged, over
//! overlapping fields too; over the angles φ_i a least-squares fit of
//!
//! ```text
//! D_i = D + Σ_{k = 2, 4} a_k cos kφ_i + b_k sin kφ_i
//! ```
//!
//! takes the even lobes out of the mean (odd ones hardly show in a width). What remains is surface texture and noise; its
//! variance is pooled over the stations of the scan, robustly, and gives u_random of the mean. Where a station scatters far more than
//! the others and one angle alone explains it, by a diameter larger than the others, that angle
//! shows contamination that turns with the part (a film, a
//! smeared chip) and is left out: the same z is measured at other angles. Otherwise the station
//! keeps its own, larger value.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use super::column_diameters::ColumnDiameters;
use crate::frame::FrameMeta;
use crate::gauge::settings::StationSettings;
use crate::profile::{Diameter, DiameterProfile, Reading, Reason, Station};

/// Columns of a station and their diameters, from which the uncertainty of its unobserved part is
/// estimated.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct StationColumns {
    n: f64,
    x: f64,
    xx: f64,
    d: f64,
    xd: f64,
}

impl StationColumns {
    /// Adds a column at `x` from the station's middle.
    pub(crate) fn add(&mut self, x: f64, d: f64) {
        self.n += 1.0;
        self.x += x;
        self.xx += x * x;
        self.d += d;
        self.xd += x * d;
    }

    /// What the mean of the columns seen may be off the station's: their own slope times the distance of their centroid from its
    /// middle. That the unobserved part continues with this slope is not certain, so the mean is
    /// left and the difference is its uncertainty.
    pub(crate) fn u_unobserved(&self) -> f64 {
        let spread = self.xx - self.x * self.x / self.n;
        if self.n < 3.0 || !(spread > 0.0) {
            return 0.0;
        }
        ((self.xd - self.x * self.d / self.n) / spread * self.x / self.n).abs()
    }
}

/// Sums of one station at one angle.
#[derive(Clone, Copy, Debug, Default)]
struct AngleSums {
    seen: StationColumns,
    columns: usize,
    gaps: usize,
    d_mm: f64,
    common_mm: f64,
    /// Σ own variance, mm².
    own: f64,
    /// Σ shared variance, mm².
    shared: f64,
    length: f64,
}

impl AngleSums {
    fn mean_mm(&self) -> f64 {
        self.d_mm / self.columns as f64
    }

    /// Variance of the mean from the edges' own statements and from what was not seen of the station, mm².
    fn noise(&self) -> f64 {
        variance_of_mean(self.columns as f64, self.own, self.shared, self.length)
            + self.seen.u_unobserved().powi(2)
    }
}

/// Variance of a mean over `n` columns from the sums of their own and of their shared variances; what is shared falls off linearly over
/// `length` columns and half of it again.
pub(crate) fn variance_of_mean(n: f64, own: f64, shared: f64, length: f64) -> f64 {
    let span_over_reach = n / (1.5 * length.max(1.0));
    let correlation = if span_over_reach <= 1.0 {
        1.0 - span_over_reach / 3.0
    } else {
        1.0 / span_over_reach - 1.0 / (3.0 * span_over_reach * span_over_reach)
    };
    own / (n * n) + correlation * shared / n
}

/// Averages a scan's frames into stations.
#[derive(Clone, Debug)]
pub struct StationAverager {
    z_mm: Vec<f64>,
    station_mm: f64,
    settings: StationSettings,
    /// Per station: sums by angle in microdegrees.
    sums: Vec<BTreeMap<i64, AngleSums>>,
    pitch_mm: f64,
    /// Whether the frames are single readings of a line camera: how many a station has is the scan's affair.
    readings: bool,
}

/// Mean and even lobes over the angles.
struct LobeFit {
    mean_mm: f64,
    /// Variance of the mean over variance of one angle.
    gain: f64,
    /// Residual variance of one angle, mm², and its degrees of freedom.
    residual: f64,
    freedom: f64,
    /// Mean, then cosine and sine of each lobe, mm.
    solution: Vec<f64>,
}

impl LobeFit {
    /// Diameter at an angle, mm.
    fn at(&self, angle: f64) -> f64 {
        self.solution.iter().enumerate().map(|(j, a)| a * lobe(j, angle)).sum()
    }
}

/// Column `j` of the design: 1, cos 2φ, sin 2φ, cos 4φ, sin 4φ.
fn lobe(j: usize, angle: f64) -> f64 {
    match j {
        0 => 1.0,
        j if j % 2 == 1 => (f64::from(j as u32 + 1) * angle).cos(),
        j => (f64::from(j as u32) * angle).sin(),
    }
}

/// One station before its uncertainty is known.
struct AngleFit {
    lobes: LobeFit,
    /// Variance of the mean by noise alone, mm².
    noise: f64,
    common_mm: f64,
}

impl StationAverager {
    /// Stations by their middles, ascending, and their common length.
    pub fn new(settings: &StationSettings, z_mm: Vec<f64>, station_mm: f64) -> Self {
        let sums = vec![BTreeMap::new(); z_mm.len()];
        Self { z_mm, station_mm, settings: *settings, sums, pitch_mm: 0.0, readings: false }
    }

    /// Adds a frame's diameters.
    pub fn add(&mut self, meta: &FrameMeta, diameters: &ColumnDiameters) {
        self.pitch_mm = diameters.pitch_mm;
        self.readings = diameters.readings.len() < NARROW;
        let angle = (meta.angle_deg * 1e6).round() as i64;
        for (column, reading) in diameters.readings.iter().enumerate() {
            let z_mm = diameters.z_mm(meta, column);
            let Some(station) = self.station_at(z_mm) else { continue };
            let sums = self.sums[station].entry(angle).or_default();
            match reading {
                Reading::Gap(_) => sums.gaps += 1,
                Reading::Value(d) => {
                    let shared = diameters.shared_mm[column].powi(2);
                    sums.columns += 1;
                    sums.seen.add(z_mm - self.z_mm[station], d.d_mm);
                    sums.d_mm += d.d_mm;
                    sums.common_mm += d.u_common_mm;
                    sums.own += (d.u_random_mm.powi(2) - shared).max(0.0);
                    sums.shared += shared;
                    sums.length = diameters.shared_length;
                }
            }
        }
    }

    fn station_at(&self, z_mm: f64) -> Option<usize> {
        let half = 0.5 * self.station_mm;
        let after = self.z_mm.partition_point(|middle| *middle + half <= z_mm);
        (after < self.z_mm.len() && z_mm >= self.z_mm[after] - half).then_some(after)
    }

    /// Ends the scan: one reading a station.
    pub fn finish(&self, pass: u32) -> DiameterProfile {
        let mut fits: Vec<Result<AngleFit, Reason>> =
            self.sums.iter().map(|sums| self.fit(sums, None)).collect();
        let pooled = pooled_variance(fits.iter().flatten());
        if let Some((pooled, _)) = pooled {
            for (fit, sums) in fits.iter_mut().zip(&self.sums) {
                let far = fit.as_ref().is_ok_and(|f| f.lobes.residual > FAR * pooled);
                if let Some(better) = far.then(|| self.without_outlying_angle(sums, pooled)).flatten() {
                    *fit = Ok(better);
                }
            }
        }
        let stations = self.z_mm.iter().zip(&fits).map(|(z_mm, fit)| station(*z_mm, fit, pooled)).collect();
        DiameterProfile { pass, stations }
    }

    /// Angles with enough columns, by their means, but for one.
    fn angles(&self, sums: &BTreeMap<i64, AngleSums>, but: Option<i64>) -> Vec<(i64, AngleSums)> {
        let whole = if self.readings { 0.0 } else { self.station_mm / self.pitch_mm.max(1e-12) };
        let least = (self.settings.min_fill * whole).max(1.0);
        let enough = |(angle, s): &(&i64, &AngleSums)| s.columns as f64 >= least && Some(**angle) != but;
        sums.iter().filter(enough).map(|(angle, s)| (*angle, *s)).collect()
    }

    fn fit(&self, sums: &BTreeMap<i64, AngleSums>, but: Option<i64>) -> Result<AngleFit, Reason> {
        if sums.is_empty() {
            return Err(Reason::NotScanned);
        }
        let good = self.angles(sums, but);
        if good.len() < self.settings.min_angles.max(1) {
            return Err(Reason::TooFewColumns);
        }
        let n = good.len() as f64;
        let noise = good.iter().map(|(_, s)| s.noise()).sum::<f64>() / (n * n);
        let common_mm = good.iter().map(|(_, s)| s.common_mm / s.columns as f64).sum::<f64>() / n;
        let angles: Vec<(f64, f64)> = good.iter().map(|(a, s)| (radians(*a), s.mean_mm())).collect();
        Ok(AngleFit { lobes: fit_lobes(&angles), noise, common_mm })
    }

    /// The fit without the one angle that lies above the others, where that explains the station's
    /// scatter.
    fn without_outlying_angle(&self, sums: &BTreeMap<i64, AngleSums>, pooled: f64) -> Option<AngleFit> {
        let mut best: Option<AngleFit> = None;
        for (angle, s) in self.angles(sums, None) {
            let Ok(fit) = self.fit(sums, Some(angle)) else { continue };
            let above = s.mean_mm() - fit.lobes.at(radians(angle));
            let explains = fit.lobes.freedom >= 2.0 && fit.lobes.residual <= FAR * pooled;
            let outlying = above > 5.0 * pooled.sqrt();
            let better = best.as_ref().is_none_or(|b| fit.lobes.residual < b.lobes.residual);
            if explains && outlying && better {
                best = Some(fit);
            }
        }
        best
    }
}

/// Columns below which a frame is a reading of a line camera.
const NARROW: usize = 16;

/// Residual variance over the pooled one from which a station scatters too much (below 0.1 % of good ones with three degrees of freedom).
const FAR: f64 = 7.0;

fn radians(microdegrees: i64) -> f64 {
    (microdegrees as f64 * 1e-6).to_radians()
}

/// Mean with the even lobes 2 and 4 taken out as far as the angles allow.
fn fit_lobes(angles: &[(f64, f64)]) -> LobeFit {
    let n = angles.len();
    let lobes = n.saturating_sub(2).min(4) / 2;
    for lobes in (0..=lobes).rev() {
        let parameters = 1 + 2 * lobes;
        let design = DMatrix::from_fn(n, parameters, |i, j| lobe(j, angles[i].0));
        let observed = DVector::from_iterator(n, angles.iter().map(|a| a.1));
        let Some(inverse) = (design.transpose() * &design).try_inverse() else { continue };
        // Badly spread angles would buy the lobes with the mean's variance.
        if inverse[(0, 0)] > 1.5 / n as f64 {
            continue;
        }
        let solution = &inverse * design.transpose() * &observed;
        let square = (&observed - &design * &solution).norm_squared();
        let freedom = (n - parameters) as f64;
        let residual = if freedom > 0.0 { square / freedom } else { 0.0 };
        let (mean_mm, gain) = (solution[0], inverse[(0, 0)]);
        return LobeFit { mean_mm, gain, residual, freedom, solution: solution.iter().copied().collect() };
    }
    let mean_mm = angles.iter().map(|a| a.1).sum::<f64>() / n as f64;
    LobeFit { mean_mm, gain: 1.0 / n as f64, residual: 0.0, freedom: 0.0, solution: vec![mean_mm] }
}

/// Variance of one angle, mm², pooled over the stations, and its degrees of freedom: those beyond seven times the median's estimate are left out (below 0.1 % of
/// good ones with three degrees of freedom). `None` without freedom.
fn pooled_variance<'a>(fits: impl Iterator<Item = &'a AngleFit>) -> Option<(f64, f64)> {
    let mut all: Vec<(f64, f64)> =
        fits.map(|f| &f.lobes).filter(|f| f.freedom > 0.0).map(|f| (f.residual, f.freedom)).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (median, freedom) = *all.get(all.len() / 2)?;
    let limit = FAR * median / crate::numerics::distributions::chi2_ratio_limit(freedom, 0.0).max(0.2);
    let kept = || all.iter().filter(|v| v.0 <= limit);
    let total: f64 = kept().map(|v| v.1).sum();
    (total > 0.0).then(|| (kept().map(|v| v.0 * v.1).sum::<f64>() / total, total))
}

fn station(z_mm: f64, fit: &Result<AngleFit, Reason>, pooled: Option<(f64, f64)>) -> Station {
    let gap = |reason| Station { z_mm, reading: Reading::Gap(reason), freedom: None };
    let fit = match fit {
        Ok(fit) => fit,
        Err(reason) => return gap(*reason),
    };
    let (one_angle, freedom) = match pooled {
        Some((pooled, _)) if fit.lobes.residual > FAR * pooled => (fit.lobes.residual, fit.lobes.freedom),
        Some(pooled) => pooled,
        // One angle a station: what form and texture do to it is unknown, and so is its uncertainty.
        None => return gap(Reason::TooFewColumns),
    };
    let scatter = fit.lobes.gain * one_angle;
    let diameter = Diameter {
        d_mm: fit.lobes.mean_mm,
        u_random_mm: scatter.max(fit.noise).sqrt(),
        u_common_mm: fit.common_mm,
    };
    // Welch-Satterthwaite (GUM G.4.1): of scatter alone the degrees of freedom are counted, noise is known.
    let freedom = (scatter >= fit.noise && scatter > 0.0)
        .then(|| freedom.max(1.0) * (diameter.u_mm().powi(2) / scatter).powi(2))
        .filter(|freedom| *freedom < MANY_FREEDOM);
    Station { z_mm, reading: Reading::Value(diameter), freedom }
}

/// Degrees of freedom from which Student's t is the normal distribution to a thousandth of u at 95 %.
const MANY_FREEDOM: f64 = 1000.0;

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};
    use rand_pcg::Pcg64;

    fn frame(angle_deg: f64, z_mm: f64, d: impl Fn(f64) -> f64) -> (FrameMeta, ColumnDiameters) {
        let (columns, pitch_mm) = (400, 0.05);
        let readings = (0..columns)
            .map(|c| {
                let z = z_mm + (f64::from(c) - 199.5) * pitch_mm;
                Reading::Value(Diameter { d_mm: d(z), u_random_mm: 1e-4, u_common_mm: 2e-4 })
            })
            .collect();
        let meta = FrameMeta { angle_deg, z_mm, ..FrameMeta::default() };
        let diameters = ColumnDiameters {
            readings,
            shared_mm: vec![0.0; 400],
            shared_length: 400.0,
            pitch_mm,
            width_px: vec![500.0; 400],
            middle_mm: vec![0.0; 400],
            u_middle_common_mm: vec![0.0; 400],
        };
        (meta, diameters)
    }

    #[test]
    fn lobes_cancel_and_uncertainty_is_that_of_the_texture() {
        let mut rng = Pcg64::seed_from_u64(5);
        let texture = Normal::new(0.0, 1e-3).unwrap();
        let z: Vec<f64> = (0..400).map(|k| 2.5 + 5.0 * f64::from(k)).collect();
        let mut averager = StationAverager::new(&StationSettings::default(), z, 5.0);
        for field in 0..101 {
            for i in 0..8 {
                let angle = 22.5 * f64::from(i);
                let lobe = 5e-3 * (2.0 * angle.to_radians() + 0.3).cos();
                let draws: Vec<f64> = (0..600).map(|_| texture.sample(&mut rng)).collect();
                let d = |z: f64| 25.0 + 1e-4 * z + lobe + draws[(z / 5.0).clamp(0.0, 599.0) as usize];
                let (meta, diameters) = frame(angle, 20.0 * f64::from(field), d);
                averager.add(&meta, &diameters);
            }
        }
        let profile = averager.finish(1);
        let (mut square, mut u_square) = (0.0, 0.0);
        for station in &profile.stations {
            let d = station.reading.value().unwrap();
            square += (d.d_mm - 25.0 - 1e-4 * station.z_mm).powi(2);
            u_square += d.u_random_mm.powi(2);
        }
        let ratio: f64 = (square / u_square).sqrt();
        assert!((0.9..1.1).contains(&ratio), "{ratio}");
    }

    #[test]
    fn a_film_seen_at_one_angle_does_not_move_the_mean() {
        let mut rng = Pcg64::seed_from_u64(6);
        let texture = Normal::new(0.0, 2e-4).unwrap();
        let z: Vec<f64> = (0..20).map(|k| 1.0 + f64::from(k)).collect();
        let mut averager = StationAverager::new(&StationSettings::default(), z, 1.0);
        for i in 0..8 {
            let angle = 22.5 * f64::from(i);
            let lobe = 5e-3 * (2.0 * angle.to_radians() + 0.3).cos();
            let draws: Vec<f64> = (0..40).map(|_| texture.sample(&mut rng)).collect();
            // 20 µm of coolant at z = 7 and one angle.
            let film = |z: f64| if i == 3 && (z - 7.0).abs() < 0.5 { 0.02 } else { 0.0 };
            let d = |z: f64| 25.0 + lobe + draws[z.clamp(0.0, 39.0) as usize] + film(z);
            let (meta, diameters) = frame(angle, 10.0, d);
            averager.add(&meta, &diameters);
        }
        let profile = averager.finish(1);
        for station in &profile.stations {
            let d = station.reading.value().unwrap();
            assert!((d.d_mm - 25.0).abs() < 5e-4, "z {}: {d:?}", station.z_mm);
        }
    }

    #[test]
    fn what_was_not_seen_of_a_taper_is_stated() {
        let mean_and_u = |columns: std::ops::Range<i32>| {
            let mut seen = StationColumns::default();
            columns.for_each(|c| seen.add(f64::from(c) - 31.5, 25.0 + 1e-4 * f64::from(c)));
            (seen.d / seen.n - 25.0 - 1e-4 * 31.5, seen.u_unobserved())
        };
        assert!(mean_and_u(0..64).1 < 1e-12);
        for part in [0..20, 40..64, 10..50] {
            let (off, u) = mean_and_u(part);
            assert!((off.abs() - u).abs() < 1e-9, "{off} {u}");
        }
        let mut two = StationColumns::default();
        [1.0, 2.0].into_iter().for_each(|x| two.add(x, x));
        assert_eq!(two.u_unobserved(), 0.0);
    }

    #[test]
    fn stations_without_frames_or_columns_are_gaps() {
        let mut averager = StationAverager::new(&StationSettings::default(), vec![5.0, 500.0], 5.0);
        let (meta, mut diameters) = frame(0.0, 5.0, |_| 25.0);
        diameters.readings.iter_mut().for_each(|r| *r = Reading::Gap(Reason::Outlier));
        averager.add(&meta, &diameters);
        let profile = averager.finish(1);
        assert_eq!(profile.stations[0].reading, Reading::Gap(Reason::TooFewColumns));
        assert_eq!(profile.stations[1].reading, Reading::Gap(Reason::NotScanned));
    }
}
