//! The axis of a shaft along z: where it stands in the image plane, and what of it turns with the part.
//!
//! The middle of both edges at z and spindle angle φ stands at
//!
//! ```text
//! m(z, φ) = x(z) + a(z)·cos φ − b(z)·sin φ      + odd lobes of the section, motion of the spindle
//! ```
//!
//! x(z) stands still (sag, force, lie of the spindle in the field), (a, b) is the offset of the section's centre in the body (eccentricity,
//! residual bow), a upwards and b towards the camera at φ = 0. At φ + 90° the silhouette shows of the body what faced the camera at
//! φ: so both components of what turns are seen, and a silhouette's other plane is no secret for it. What stands still towards the
//! camera moves no telecentric edge at any angle: it is not seen, unless from a second viewing direction ([`AxisLine::seen_from`]).
//!
//! Noise and levels move the middle by half of what they do to the width; a blur that is off moves both edges outwards and the middle
//! not at all; scale errors take their share of the height over the optical axis alone. Over the angles the fit's residual, pooled over the
//! stations, shows what else scatters (asynchronous spindle motion, vibration); where it exceeds the edges' own statement it counts.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use serde::Serialize;

use super::column_diameters::ColumnDiameters;
use super::stations::variance_of_mean;
use crate::frame::FrameMeta;
use crate::gauge::calibration::axis_zero::AxisZero;
use crate::profile::{Reading, Reason};

/// Share of a station's columns that an angle needs.
const LEAST_FILL: f64 = 0.3;
/// Variance of x over that of one angle, at most, where turning part and still part are separated: angles that span less of the turn
/// leave both mixed.
const MOST_GAIN: f64 = 4.0;
/// Variance of a station's middle over that of its columns' mean, at most, by the slope and bend that are adjusted within it.
const MOST_STATION_GAIN: f64 = 4.0;
/// Residual variance over the pooled one from which a station keeps its own (below 0.1 % of good ones with three degrees of freedom).
const FAR: f64 = 7.0;
/// Angles for one more odd harmonic; as over half a turn (`turn_scatter`), three at most.
const ANGLES_A_HARMONIC: usize = 6;
const MOST_HARMONICS: usize = 3;

/// The offset of a section's centre in the body: what turns with the part.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TurningOffset {
    /// Along x (upwards) at spindle angle 0, mm.
    pub x_mm: f64,
    /// Along y (towards the camera) at spindle angle 0, mm.
    pub y_mm: f64,
    /// Standard uncertainty of each, mm.
    pub u_mm: f64,
}

impl TurningOffset {
    /// Distance of the section's centre from the axis of rotation, mm.
    pub fn amplitude_mm(&self) -> f64 {
        self.x_mm.hypot(self.y_mm)
    }

    /// Body angle of the offset, degrees from x towards y.
    pub fn phase_deg(&self) -> f64 {
        self.y_mm.atan2(self.x_mm).to_degrees()
    }

    /// Radial run-out of the axis against the axis of rotation, mm: twice the amplitude (form apart).
    pub fn run_out_mm(&self) -> f64 {
        2.0 * self.amplitude_mm()
    }

    /// Offset (upwards, towards the camera) at a spindle angle, mm.
    pub fn at(&self, angle_deg: f64) -> (f64, f64) {
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        (self.x_mm * cos - self.y_mm * sin, self.x_mm * sin + self.y_mm * cos)
    }
}

/// The axis at a station.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AxisStation {
    /// Middle of the station, mm.
    pub z_mm: f64,
    /// Height of the axis over the optical axis, what stands still of it, mm; where `turning` is none, what turns is in it as it stood.
    pub x_mm: f64,
    /// Standard uncertainty of the height by what scatters from angle to angle and station to station, mm.
    pub u_random_mm: f64,
    /// Standard uncertainty by what all stations share (scale, edge model), mm.
    pub u_common_mm: f64,
    /// What turns with the part; `None` where the angles do not span enough of a turn to show it.
    pub turning: Option<TurningOffset>,
    /// Spindle angles seen.
    pub angles: usize,
}

impl AxisStation {
    /// Combined standard uncertainty of the height, mm.
    pub fn u_mm(&self) -> f64 {
        self.u_random_mm.hypot(self.u_common_mm)
    }
}

/// What is known of the axis' part that stands still towards the camera.
pub const STILL_TOWARDS_CAMERA: &str = "not seen: needs a second viewing direction";

/// The axis of a part along z.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct AxisLine {
    /// Stations that were seen, by z.
    pub stations: Vec<AxisStation>,
    /// Stations that were not, with the reason.
    pub gaps: Vec<(f64, Reason)>,
}

/// What stands still towards the camera, from a second viewing direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StillTowardsCamera {
    /// Middle of the station, mm.
    pub z_mm: f64,
    /// Offset towards the first camera, mm.
    pub y_mm: f64,
    /// Standard uncertainty, mm.
    pub u_mm: f64,
}

impl AxisLine {
    /// Departure of the height from the chord between the first and the last station, (z, departure, its random standard uncertainty),
    /// mm: how the shaft bends in the image plane, wherever its supports stand.
    pub fn bend_mm(&self) -> Vec<(f64, f64, f64)> {
        let (Some(first), Some(last)) = (self.stations.first(), self.stations.last()) else {
            return Vec::new();
        };
        let length = last.z_mm - first.z_mm;
        self.stations
            .iter()
            .map(|s| {
                let share = if length > 0.0 { (s.z_mm - first.z_mm) / length } else { 0.0 };
                let chord = first.x_mm + share * (last.x_mm - first.x_mm);
                let ends = ((1.0 - share) * first.u_random_mm).hypot(share * last.u_random_mm);
                (s.z_mm, s.x_mm - chord, s.u_random_mm.hypot(ends))
            })
            .collect()
    }

    /// The station with the largest run-out of the axis.
    pub fn largest_run_out(&self) -> Option<(f64, TurningOffset)> {
        let turning = self.stations.iter().filter_map(|s| Some((s.z_mm, s.turning?)));
        turning.max_by(|a, b| a.1.amplitude_mm().total_cmp(&b.1.amplitude_mm()))
    }

    /// What stands still towards the camera, where a second camera sees the same shaft with its own upward direction turned by
    /// `view_deg` from x towards y: x' = x·cos ψ + y·sin ψ. The two optical axes' distance along y stays in it as a constant.
    /// Nothing where the directions are less than 10° apart, and for stations that one of both has not seen.
    pub fn seen_from(&self, second: &Self, view_deg: f64) -> Vec<StillTowardsCamera> {
        let (sin, cos) = view_deg.to_radians().sin_cos();
        if sin.abs() < 10.0_f64.to_radians().sin() {
            return Vec::new();
        }
        let both = self.stations.iter().filter_map(|a| {
            let b = second.stations.iter().find(|b| (b.z_mm - a.z_mm).abs() < 1e-6)?;
            (a.turning.is_some() && b.turning.is_some()).then_some((a, b))
        });
        both.map(|(a, b)| StillTowardsCamera {
            z_mm: a.z_mm,
            y_mm: (b.x_mm - a.x_mm * cos) / sin,
            u_mm: b.u_mm().hypot(a.u_mm() * cos) / sin.abs(),
        })
        .collect()
    }
}

/// Sums of one station at one angle.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    columns: usize,
    /// Σ tᵏ for k = 0 to 4 and Σ tᵏ·m for k = 0 to 2, t the distance from the station's middle over half its length.
    powers: [f64; 5],
    middle_mm: [f64; 3],
    common_mm: f64,
    /// Σ own variance of the width, mm².
    own: f64,
    /// Σ shared variance of the width, mm².
    shared: f64,
    length: f64,
}

impl Sums {
    fn add(&mut self, t: f64, middle_mm: f64) {
        self.columns += 1;
        let mut power = 1.0;
        for k in 0..5 {
            self.powers[k] += power;
            if k < 3 {
                self.middle_mm[k] += power * middle_mm;
            }
            power *= t;
        }
    }

    /// Mean middle over the whole station and the variance of it over that of a plain mean. Fields that overlap show a part of the station
    /// twice, and an axis slopes: a parabola through the columns is averaged over the station, a line where they do not show one, their
    /// mean where they do not show that.
    fn mean_mm(&self) -> (f64, f64) {
        let n = self.powers[0];
        let start = self.middle_mm[0] / n;
        for terms in [3, 2] {
            let normal = Matrix3::from_fn(|i, j| match (i < terms && j < terms, i == j) {
                (true, _) => self.powers[i + j],
                (false, same) => f64::from(u8::from(same)),
            });
            let right =
                Vector3::from_fn(
                    |i, _| if i < terms { self.middle_mm[i] - start * self.powers[i] } else { 0.0 },
                );
            // Over the station the mean of t² is a third.
            let mean = Vector3::new(1.0, 0.0, if terms == 3 { 1.0 / 3.0 } else { 0.0 });
            let Some(inverse) = normal.try_inverse() else { continue };
            let gain = n * mean.dot(&(inverse * mean));
            if gain < MOST_STATION_GAIN {
                return (start + mean.dot(&(inverse * right)), gain.max(1.0));
            }
        }
        (start, 1.0)
    }

    /// Variance of the mean middle by the edges' own statements, mm²: a quarter of the width's.
    fn noise(&self) -> f64 {
        0.25 * self.mean_mm().1 * variance_of_mean(self.columns as f64, self.own, self.shared, self.length)
    }
}

/// Averages the middles of a scan's frames into the axis of the part.
#[derive(Clone, Debug)]
pub struct AxisAverager {
    z_mm: Vec<f64>,
    station_mm: f64,
    zero: AxisZero,
    pitch_mm: f64,
    /// Per station: sums by angle in microdegrees.
    sums: Vec<BTreeMap<i64, Sums>>,
}

/// One station before its uncertainty is known.
struct Fit {
    x_mm: f64,
    turning: Option<(f64, f64)>,
    /// Variances of x and of the turning components over that of one angle.
    gains: [f64; 2],
    residual: f64,
    freedom: f64,
    noise: f64,
    common_mm: f64,
    angles: usize,
}

impl AxisAverager {
    /// Stations by their middles, ascending, and their common length.
    pub fn new(z_mm: Vec<f64>, station_mm: f64, zero: AxisZero) -> Self {
        let sums = vec![BTreeMap::new(); z_mm.len()];
        Self { z_mm, station_mm, zero, pitch_mm: 0.0, sums }
    }

    /// Adds a frame's columns.
    pub fn add(&mut self, meta: &FrameMeta, diameters: &ColumnDiameters) {
        self.pitch_mm = diameters.pitch_mm;
        let angle = (meta.angle_deg.rem_euclid(360.0) * 1e6).round() as i64 % 360_000_000;
        let half = 0.5 * self.station_mm;
        for (column, reading) in diameters.readings.iter().enumerate() {
            let Reading::Value(d) = reading else { continue };
            let z_mm = diameters.z_mm(meta, column);
            let after = self.z_mm.partition_point(|middle| *middle + half <= z_mm);
            if after >= self.z_mm.len() || z_mm < self.z_mm[after] - half {
                continue;
            }
            let sums = self.sums[after].entry(angle).or_default();
            let shared = diameters.shared_mm[column].powi(2);
            let t = (z_mm - self.z_mm[after]) / half;
            sums.add(t, diameters.middle_mm[column] - self.zero.height_mm);
            sums.common_mm += diameters.u_middle_common_mm[column];
            sums.own += (d.u_random_mm.powi(2) - shared).max(0.0);
            sums.shared += shared;
            sums.length = diameters.shared_length;
        }
    }

    /// Ends the scan.
    pub fn finish(&self) -> AxisLine {
        let fits: Vec<Result<Fit, Reason>> = self.sums.iter().map(|sums| self.fit(sums)).collect();
        let pooled = pooled_variance(fits.iter().flatten());
        let mut line = AxisLine::default();
        for (z_mm, fit) in self.z_mm.iter().zip(&fits) {
            match fit {
                Ok(fit) => line.stations.push(fit.station(*z_mm, pooled, self.zero.u_scale)),
                Err(reason) => line.gaps.push((*z_mm, *reason)),
            }
        }
        line
    }

    fn fit(&self, sums: &BTreeMap<i64, Sums>) -> Result<Fit, Reason> {
        if sums.is_empty() {
            return Err(Reason::NotScanned);
        }
        let least = (LEAST_FILL * self.station_mm / self.pitch_mm.max(1e-12)).max(1.0);
        let good: Vec<(f64, &Sums)> = sums
            .iter()
            .filter(|(_, s)| s.columns as f64 >= least)
            .map(|(angle, s)| ((*angle as f64 * 1e-6).to_radians(), s))
            .collect();
        if good.is_empty() {
            return Err(Reason::TooFewColumns);
        }
        let n = good.len() as f64;
        let noise = good.iter().map(|(_, s)| s.noise()).sum::<f64>() / n;
        let common_mm = good.iter().map(|(_, s)| s.common_mm / s.columns as f64).sum::<f64>() / n;
        let middles: Vec<(f64, f64)> = good.iter().map(|(angle, s)| (*angle, s.mean_mm().0)).collect();
        Ok(Fit { noise, common_mm, angles: good.len(), ..harmonics(&middles) })
    }
}

impl Fit {
    fn station(&self, z_mm: f64, pooled: Option<f64>, u_scale: f64) -> AxisStation {
        let scatter = match pooled {
            Some(pooled) if self.freedom > 0.0 && self.residual > FAR * pooled => self.residual,
            pooled => pooled.unwrap_or(0.0),
        };
        let one_angle = scatter.max(self.noise);
        let u = |gain: f64| (gain * one_angle).sqrt();
        AxisStation {
            z_mm,
            x_mm: self.x_mm,
            u_random_mm: u(self.gains[0]),
            u_common_mm: self.common_mm.hypot(u_scale * self.x_mm),
            turning: self.turning.map(|(x_mm, y_mm)| TurningOffset { x_mm, y_mm, u_mm: u(self.gains[1]) }),
            angles: self.angles,
        }
    }
}

/// Still part and first harmonic, with as many odd harmonics beside them as the angles allow; the mean alone where they span too little.
fn harmonics(middles: &[(f64, f64)]) -> Fit {
    let n = middles.len();
    let start = middles[0].1;
    let most = (n.saturating_sub(3) / ANGLES_A_HARMONIC).clamp(1, MOST_HARMONICS);
    for orders in (1..=most).rev() {
        let columns = 1 + 2 * orders;
        if n < columns {
            continue;
        }
        let design = DMatrix::from_fn(n, columns, |row, column| {
            let turned = (2.0 * column.div_ceil(2) as f64 - 1.0) * middles[row].0;
            match column {
                0 => 1.0,
                c if c % 2 == 1 => turned.cos(),
                _ => -turned.sin(),
            }
        });
        let Some(inverse) = (design.transpose() * &design).try_inverse() else { continue };
        if !(inverse[(0, 0)] < MOST_GAIN) {
            continue;
        }
        let observed = DVector::from_iterator(n, middles.iter().map(|m| m.1 - start));
        let solution = &inverse * design.transpose() * &observed;
        let freedom = (n - columns) as f64;
        let square = (&observed - &design * &solution).norm_squared();
        return Fit {
            x_mm: start + solution[0],
            turning: Some((solution[1], solution[2])),
            gains: [inverse[(0, 0)], inverse[(1, 1)].max(inverse[(2, 2)])],
            residual: if freedom > 0.0 { square / freedom } else { 0.0 },
            freedom,
            noise: 0.0,
            common_mm: 0.0,
            angles: n,
        };
    }
    let mean = middles.iter().map(|m| m.1).sum::<f64>() / n as f64;
    Fit {
        x_mm: mean,
        turning: None,
        gains: [1.0 / n as f64; 2],
        residual: 0.0,
        freedom: 0.0,
        noise: 0.0,
        common_mm: 0.0,
        angles: n,
    }
}

/// Variance of one angle's middle, mm², pooled over the stations without those far beyond the median; `None` without freedom.
fn pooled_variance<'a>(fits: impl Iterator<Item = &'a Fit>) -> Option<f64> {
    let mut all: Vec<(f64, f64)> =
        fits.filter(|f| f.freedom > 0.0).map(|f| (f.residual, f.freedom)).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (median, freedom) = *all.get(all.len() / 2)?;
    let limit = FAR * median / crate::numerics::distributions::chi2_ratio_limit(freedom, 0.0).max(0.2);
    let (sum, total) = all
        .iter()
        .filter(|v| v.0 <= limit)
        .fold((0.0, 0.0), |(sum, total), (residual, freedom)| (sum + residual * freedom, total + freedom));
    (total > 0.0).then(|| sum / total)
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::profile::Diameter;

    /// A scan whose axis stands at x(z) and turns about it by (a, b), with noise of one station and angle.
    fn line(angles: &[f64], x: impl Fn(f64) -> f64, turning: (f64, f64), noise: f64, seed: u64) -> AxisLine {
        let stations: Vec<f64> = (0..60).map(|k| 2.5 + 5.0 * f64::from(k)).collect();
        let mut averager =
            AxisAverager::new(stations.clone(), 5.0, AxisZero { height_mm: -7.0, u_scale: 0.0 });
        let mut rng = Pcg64::seed_from_u64(seed);
        let normal = Normal::new(0.0, noise).unwrap();
        for z_mm in stations {
            for angle_deg in angles {
                let (sin, cos) = angle_deg.to_radians().sin_cos();
                let middle = -7.0 + x(z_mm) + turning.0 * cos - turning.1 * sin + normal.sample(&mut rng);
                let value = Reading::Value(Diameter { d_mm: 20.0, u_random_mm: 2e-5, u_common_mm: 0.0 });
                let diameters = ColumnDiameters {
                    readings: vec![value; 51],
                    shared_mm: vec![0.0; 51],
                    shared_length: 1.0,
                    pitch_mm: 0.05,
                    width_px: vec![1.0; 51],
                    middle_mm: vec![middle; 51],
                    u_middle_common_mm: vec![1e-6; 51],
                };
                let meta = FrameMeta { angle_deg: *angle_deg, z_mm, ..FrameMeta::default() };
                averager.add(&meta, &diameters);
            }
        }
        averager.finish()
    }

    #[test]
    fn still_and_turning_parts_are_told_apart_and_u_is_what_they_scatter_by() {
        let sag = |z: f64| -0.2 * (z / 300.0 * std::f64::consts::PI).sin();
        let half: Vec<f64> = (0..8).map(|k| 22.5 * f64::from(k)).collect();
        let whole: Vec<f64> = (0..4).map(|k| 90.0 * f64::from(k)).collect();
        for (angles, noise) in [(&half, 3e-5), (&whole, 3e-5), (&half, 1e-6)] {
            let (mut square, mut turned, mut n) = (0.0, 0.0, 0.0);
            for seed in 0..20 {
                for s in line(angles, sag, (0.03, -0.05), noise, seed).stations {
                    let t = s.turning.unwrap();
                    square += ((s.x_mm - sag(s.z_mm)) / s.u_random_mm).powi(2);
                    turned += 0.5 * (((t.x_mm - 0.03) / t.u_mm).powi(2) + ((t.y_mm + 0.05) / t.u_mm).powi(2));
                    n += 1.0;
                }
            }
            let (x, t) = (f64::sqrt(square / n), f64::sqrt(turned / n));
            if noise > 1e-5 {
                // Over half a turn one of both components is better known than the other one's u.
                assert!((0.9..1.1).contains(&x) && (0.65..1.1).contains(&t), "{x} {t}");
            } else {
                assert!(x < 0.8 && t < 0.8, "the edges' own u is the least: {x} {t}");
            }
        }
    }

    #[test]
    fn a_sloping_axis_seen_twice_in_a_part_of_a_station_is_not_pulled_there() {
        let axis = |t: f64| 0.3 + 0.01 * t - 0.002 * t * t;
        let mut sums = Sums::default();
        for (from, to) in [(-1.0, 1.0), (0.2, 1.0)] {
            (0..400)
                .map(|k| from + (to - from) * (f64::from(k) + 0.5) / 400.0)
                .for_each(|t| sums.add(t, axis(t)));
        }
        let (mean, gain) = sums.mean_mm();
        assert!((mean - (0.3 - 0.002 / 3.0)).abs() < 1e-12 && (1.0..1.5).contains(&gain), "{mean} {gain}");
        let mut piece = Sums::default();
        (0..100).map(|k| 0.5 + f64::from(k) * 0.005).for_each(|t| piece.add(t, axis(t)));
        assert!((piece.mean_mm().0 - axis(0.75)).abs() < 1e-3, "too little is seen to go beyond it");
    }

    #[test]
    fn too_few_angles_are_not_split_and_a_second_view_shows_what_stands_still() {
        for angles in [vec![0.0], vec![0.0, 10.0], vec![0.0, 5.0, 10.0]] {
            let s = line(&angles, |_| 0.1, (0.02, 0.0), 0.0, 1).stations[0];
            assert!(s.turning.is_none() && (s.x_mm - 0.12).abs() < 1e-3, "{s:?}");
        }
        let angles: Vec<f64> = (0..8).map(|k| 22.5 * f64::from(k)).collect();
        let (x, y) = (|z: f64| 1e-3 * z, |z: f64| 0.3 - 2e-3 * z);
        let first = line(&angles, x, (0.01, 0.02), 0.0, 1);
        for view_deg in [90.0_f64, 60.0, -45.0] {
            let (sin, cos) = view_deg.to_radians().sin_cos();
            let second = line(&angles, |z| x(z) * cos + y(z) * sin, (0.01, 0.02), 0.0, 2);
            let still = first.seen_from(&second, view_deg);
            assert_eq!(still.len(), 60);
            assert!(still.iter().all(|s| (s.y_mm - y(s.z_mm)).abs() < 1e-12 && s.u_mm > 0.0));
        }
        assert!(first.seen_from(&first, 3.0).is_empty());
        let bend = first.bend_mm();
        assert!(bend.iter().all(|(_, b, _)| b.abs() < 1e-12));
        let (_, t) = first.largest_run_out().unwrap();
        assert!((t.run_out_mm() - 2.0 * 0.01_f64.hypot(0.02)).abs() < 1e-12);
        assert!((t.at(90.0).0 + 0.02).abs() < 1e-12 && (t.phase_deg() - 63.434_95).abs() < 1e-4);
    }
}
