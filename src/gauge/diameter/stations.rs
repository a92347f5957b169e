//! From the frames of a scan to one diameter a station.
//!
//! Every column lies at z = z_frame + (column − c0)·p. For each spindle angle the columns of a
//! station are averaged, over overlapping fields too, to its mean along z ([`StationColumns`]);
//! over the angles φ_i a least-squares fit of
//!
//! ```text
//! D_i = D + Σ_{k = 2, 4} a_k cos kφ_i + b_k sin kφ_i
//! ```
//!
//! takes the even lobes out of the mean (odd ones hardly show in a width). What remains is surface
//! texture and noise; its variance is pooled over the stations of the scan, robustly, and gives
//! u_random of the mean. Where a station scatters far more than the others and one angle alone
//! explains it, by a diameter larger than the others, that angle shows contamination that turns
//! with the part (a film, a smeared chip) and is left out: the same z is measured at other angles.
//! Otherwise the station keeps its own, larger value.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use super::column_diameters::ColumnDiameters;
use super::station_mean::{StationColumns, StationMean};
use super::station_row::StationRow;
use crate::frame::FrameMeta;
use crate::gauge::edge::stream::StreamLimits;
use crate::gauge::limit::limits;
use crate::gauge::settings::StationSettings;
use crate::profile::{Diameter, DiameterProfile, Reading, Reason, Station};

limits! {
    /// When the angles of a station scatter too much.
    StationLimits = "stations";
    /// Residual variance over the pooled one, above which a station scatters too much and keeps its
    /// own: below 0.1 % of good ones with three degrees of freedom.
    far: f64 = 7.0;
    /// Degrees of freedom from which on Student's t is taken for the normal distribution: it is, to
    /// a thousandth of u at 95 %.
    many_freedom: f64 = 1000.0;
}

/// Sums of one station at one angle.
#[derive(Clone, Copy, Debug, Default)]
struct AngleSums {
    seen: StationColumns,
    columns: usize,
    gaps: usize,
    common_mm: f64,
    /// Σ own variance, mm².
    own: f64,
    /// Σ shared variance, mm².
    shared: f64,
    length: f64,
}

impl AngleSums {
    /// Variance of the mean from the edges' own statements, mm².
    fn noise(&self, mean: &StationMean) -> f64 {
        variance_of_mean(self.columns as f64, mean.gain * self.own, self.shared, self.length)
    }

    /// Variance by noise of what the mean states was not seen, mm².
    fn rest_noise(&self, mean: &StationMean) -> f64 {
        mean.rest_gain * self.own / (self.columns as f64).powi(2)
    }
}

/// Variance of a mean over `n` columns from the sums of their own and of their shared variances;
/// what is shared falls off linearly over `length` columns and half of it again.
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
pub(crate) struct StationAverager {
    /// Sums by angle in microdegrees.
    row: StationRow<BTreeMap<i64, AngleSums>>,
    settings: StationSettings,
    /// Whether the frames are single readings of a line camera: how many a station has is the
    /// scan's affair.
    readings: bool,
}

/// Mean and even lobes over the angles.
struct LobeFit {
    mean_mm: f64,
    /// Variance of the mean over variance of one angle.
    gain: f64,
    /// Residual variance of one angle of a whole station, mm², and its degrees of freedom.
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
    /// Variance of the mean by what was not seen of the station at any angle, mm².
    rest: f64,
    /// Variance of one angle by surface texture over that of a whole station: a part of it, carried
    /// on by a line, has less.
    share: f64,
    common_mm: f64,
}

impl StationAverager {
    /// Stations by their middles, ascending, and their common length.
    pub(crate) fn new(settings: &StationSettings, z_mm: Vec<f64>, station_mm: f64) -> Self {
        Self { row: StationRow::new(z_mm, station_mm), settings: *settings, readings: false }
    }

    /// Adds a frame's diameters.
    pub(crate) fn add(&mut self, meta: &FrameMeta, diameters: &ColumnDiameters) {
        self.row.pitch_mm = diameters.pitch_mm;
        self.readings = diameters.columns.len() < StreamLimits::get().least_columns;
        let angle = (meta.angle_deg * 1e6).round() as i64;
        for (index, column) in diameters.columns.iter().enumerate() {
            let Some((station, t)) = self.row.place(diameters.z_mm(meta, index)) else { continue };
            let sums = self.row.sums(station).entry(angle).or_default();
            match column.reading {
                Reading::Gap(_) => sums.gaps += 1,
                Reading::Value(d) => {
                    let shared = column.shared_mm.powi(2);
                    sums.columns += 1;
                    sums.seen.add(t, d.d_mm);
                    sums.common_mm += d.u_common_mm;
                    sums.own += (d.u_random_mm.powi(2) - shared).max(0.0);
                    sums.shared += shared;
                    sums.length = diameters.shared_length;
                }
            }
        }
    }

    /// Ends the scan: one reading a station.
    pub(crate) fn finish(&self, pass: u32) -> DiameterProfile {
        let limits = StationLimits::get();
        let mut fits: Vec<Result<AngleFit, Reason>> =
            self.row.iter().map(|s| self.fit(&s.sums, None)).collect();
        let pooled = pooled_variance(fits.iter().flatten());
        if let Some((pooled, _)) = pooled {
            for (fit, station) in fits.iter_mut().zip(self.row.iter()) {
                let far = fit.as_ref().is_ok_and(|f| f.lobes.residual > limits.far * pooled);
                if let Some(better) =
                    far.then(|| self.without_outlying_angle(&station.sums, pooled)).flatten()
                {
                    *fit = Ok(better);
                }
            }
        }
        let stations = self.row.iter().zip(&fits).map(|(s, fit)| station(s.z_mm, fit, pooled)).collect();
        DiameterProfile { pass, stations }
    }

    /// Angles with enough columns, by their means, but for one.
    fn angles(&self, sums: &BTreeMap<i64, AngleSums>, but: Option<i64>) -> Vec<(i64, AngleSums)> {
        let least = (self.settings.min_fill * self.whole()).max(1.0);
        let enough = |(angle, s): &(&i64, &AngleSums)| s.columns as f64 >= least && Some(**angle) != but;
        sums.iter().filter(enough).map(|(angle, s)| (*angle, *s)).collect()
    }

    /// Columns of a whole station; 0 where a scan's readings make them.
    fn whole(&self) -> f64 {
        if self.readings { 0.0 } else { self.row.columns() }
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
        let means: Vec<StationMean> = good.iter().map(|(_, s)| s.seen.mean()).collect();
        let each = || good.iter().map(|(_, s)| s).zip(&means);
        let noise = each().map(|(s, m)| s.noise(m)).sum::<f64>() / (n * n);
        // What was not seen is the part's and not the angle's: its mean over the angles counts,
        // less what noise makes of it.
        let unseen = means.iter().map(|m| m.rest).sum::<f64>() / n;
        let by_noise = each().map(|(s, m)| s.rest_noise(m)).sum::<f64>() / (n * n);
        let rest = (unseen * unseen - by_noise).max(0.0);
        let part = |s: &AngleSums, m: &StationMean| (m.gain * self.whole() / s.columns as f64).max(1.0);
        let share = each().map(|(s, m)| part(s, m)).sum::<f64>() / n;
        let common_mm = good.iter().map(|(_, s)| s.common_mm / s.columns as f64).sum::<f64>() / n;
        let angles: Vec<(f64, f64)> =
            good.iter().zip(&means).map(|((a, _), m)| (radians(*a), m.mean)).collect();
        let mut lobes = fit_lobes(&angles);
        lobes.residual /= share;
        Ok(AngleFit { lobes, noise, rest, share, common_mm })
    }

    /// The fit without the one angle that lies above what the others state, where that explains the
    /// station's scatter.
    fn without_outlying_angle(&self, sums: &BTreeMap<i64, AngleSums>, pooled: f64) -> Option<AngleFit> {
        let limits = StationLimits::get();
        let mut best: Option<AngleFit> = None;
        for (angle, s) in self.angles(sums, None) {
            let Ok(fit) = self.fit(sums, Some(angle)) else { continue };
            let above = s.seen.mean().mean - fit.lobes.at(radians(angle));
            let explains = fit.lobes.freedom >= 2.0 && fit.lobes.residual <= limits.far * pooled;
            let outlying = above > 5.0 * pooled.sqrt();
            let better = best.as_ref().is_none_or(|b| fit.lobes.residual < b.lobes.residual);
            if explains && outlying && better {
                best = Some(fit);
            }
        }
        best
    }
}

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

/// Variance of one angle, mm², pooled over the stations, and its degrees of freedom: those beyond
/// seven times the median's estimate are left out (below 0.1 % of good ones with three degrees of
/// freedom). `None` without freedom.
fn pooled_variance<'a>(fits: impl Iterator<Item = &'a AngleFit>) -> Option<(f64, f64)> {
    let limits = StationLimits::get();
    let mut all: Vec<(f64, f64)> =
        fits.map(|f| &f.lobes).filter(|f| f.freedom > 0.0).map(|f| (f.residual, f.freedom)).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (median, freedom) = *all.get(all.len() / 2)?;
    let limit = limits.far * median / crate::numerics::distributions::chi2_ratio_limit(freedom, 0.0).max(0.2);
    let kept = || all.iter().filter(|v| v.0 <= limit);
    let total: f64 = kept().map(|v| v.1).sum();
    (total > 0.0).then(|| (kept().map(|v| v.0 * v.1).sum::<f64>() / total, total))
}

fn station(z_mm: f64, fit: &Result<AngleFit, Reason>, pooled: Option<(f64, f64)>) -> Station {
    let limits = StationLimits::get();
    let gap = |reason| Station { z_mm, reading: Reading::Gap(reason), freedom: None };
    let fit = match fit {
        Ok(fit) => fit,
        Err(reason) => return gap(*reason),
    };
    let (one_angle, freedom) = match pooled {
        Some((pooled, _)) if fit.lobes.residual > limits.far * pooled => {
            (fit.lobes.residual, fit.lobes.freedom)
        }
        Some(pooled) => pooled,
        // One angle a station: what form and texture do to it is unknown, and so is its
        // uncertainty.
        None => return gap(Reason::TooFewColumns),
    };
    let scatter = fit.lobes.gain * one_angle * fit.share;
    let diameter = Diameter {
        d_mm: fit.lobes.mean_mm,
        u_random_mm: (scatter.max(fit.noise) + fit.rest).sqrt(),
        u_common_mm: fit.common_mm,
    };
    // Welch-Satterthwaite (GUM G.4.1): of scatter alone the degrees of freedom are counted, noise
    // is known.
    let freedom = (scatter >= fit.noise && scatter > 0.0)
        .then(|| freedom.max(1.0) * (diameter.u_mm().powi(2) / scatter).powi(2))
        .filter(|freedom| *freedom < limits.many_freedom);
    Station { z_mm, reading: Reading::Value(diameter), freedom }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauge::diameter::column_diameters::ColumnDiameter;
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};
    use rand_pcg::Pcg64;

    fn frame(angle_deg: f64, z_mm: f64, d: impl Fn(f64) -> f64) -> (FrameMeta, ColumnDiameters) {
        let (columns, pitch_mm) = (400, 0.05);
        let columns = (0..columns)
            .map(|c| {
                let z = z_mm + (f64::from(c) - 199.5) * pitch_mm;
                let value = Diameter { d_mm: d(z), u_random_mm: 1e-4, u_common_mm: 2e-4 };
                ColumnDiameter {
                    reading: Reading::Value(value),
                    shared_mm: 0.0,
                    width_px: 500.0,
                    middle_mm: 0.0,
                    u_middle_common_mm: 0.0,
                }
            })
            .collect();
        let meta = FrameMeta { angle_deg, z_mm, ..FrameMeta::default() };
        let diameters = ColumnDiameters { columns, shared_length: 400.0, pitch_mm };
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

    /// A field that ends inside stations, over another one, on a taper of 12 µm a station that
    /// bends: the mean is that of the whole station.
    #[test]
    fn fields_that_overlap_do_not_pull_a_taper() {
        let mut rng = Pcg64::seed_from_u64(9);
        let noise = Normal::new(0.0, 1e-4).unwrap();
        let taper = |z: f64| 25.0 + 2.4e-3 * z + 2e-5 * z * z;
        let z: Vec<f64> = (0..8).map(|k| 2.5 + 5.0 * f64::from(k)).collect();
        let mut averager = StationAverager::new(&StationSettings::default(), z, 5.0);
        for field in [8.0, 24.5, 33.0] {
            for i in 0..8 {
                let draws: Vec<f64> = (0..1000).map(|_| noise.sample(&mut rng)).collect();
                let d = |z: f64| taper(z) + draws[((z + 5.0) * 20.0) as usize];
                let (meta, diameters) = frame(22.5 * f64::from(i), field, d);
                averager.add(&meta, &diameters);
            }
        }
        for station in averager.finish(1).stations {
            let mean = taper(station.z_mm) + 2e-5 * 25.0 / 12.0;
            let d = station.reading.value().unwrap();
            assert!(
                (d.d_mm - mean).abs() < 4.0 * d.u_random_mm && d.u_random_mm < 1e-4,
                "{station:?} {mean}"
            );
        }
    }

    /// The end of a taper is not seen by a third: its slope carries the mean there, and what a bend
    /// might do is in u. What is missing at every angle alike is not averaged over the angles.
    #[test]
    fn what_no_angle_shows_of_a_station_is_not_averaged_over_the_angles() {
        let taper = |z: f64| 25.0 + 2.4e-3 * z;
        let mut averager = StationAverager::new(&StationSettings::default(), vec![2.5, 7.5, 12.5], 5.0);
        for i in 0..8 {
            let (meta, diameters) = frame(22.5 * f64::from(i), 21.0, taper);
            averager.add(&meta, &diameters);
        }
        let stations = averager.finish(1).stations;
        let end = stations[2].reading.value().unwrap();
        assert!((end.d_mm - taper(12.5)).abs() < 1e-9, "{end:?}");
        // From 8.6 mm on, 1.4 mm of 5 are seen: 1.8 mm off the middle, 4.3 µm.
        let mut short = StationAverager::new(&StationSettings::default(), vec![7.5, 12.5], 5.0);
        for i in 0..8 {
            let (meta, diameters) = frame(22.5 * f64::from(i), 18.6, taper);
            short.add(&meta, &diameters);
        }
        let piece = short.finish(1).stations[0].reading.value().unwrap();
        let off = piece.d_mm - taper(7.5);
        assert!(off > 4e-3 && (off / piece.u_random_mm - 1.0).abs() < 0.02, "{off} {piece:?}");
    }

    #[test]
    fn stations_without_frames_or_columns_are_gaps() {
        let mut averager = StationAverager::new(&StationSettings::default(), vec![5.0, 500.0], 5.0);
        let (meta, mut diameters) = frame(0.0, 5.0, |_| 25.0);
        diameters.columns.iter_mut().for_each(|c| c.reading = Reading::Gap(Reason::Outlier));
        averager.add(&meta, &diameters);
        let profile = averager.finish(1);
        assert_eq!(profile.stations[0].reading, Reading::Gap(Reason::TooFewColumns));
        assert_eq!(profile.stations[1].reading, Reading::Gap(Reason::NotScanned));
    }
}
