//! The axis of a shaft along z: where it stands in the image plane, and what of it turns with the
//! part.
//!
//! The middle of both edges at z and spindle angle φ stands at
//!
//! ```text
//! m(z, φ) = x(z) + a(z)·cos φ − b(z)·sin φ      + odd lobes of the section, motion of the spindle
//! ```
//!
//! x(z) stands still (sag, force, lie of the spindle in the field), (a, b) is the offset of the
//! section's centre in the body (eccentricity, residual bow), a upwards and b towards the camera at
//! φ = 0. At φ + 90° the silhouette shows of the body what faced the camera at φ: so both
//! components of what turns are seen, and a silhouette's other plane is no secret for it. What
//! stands still towards the camera moves no telecentric edge at any angle: it is not seen, unless
//! from a second viewing direction ([`AxisLine::seen_from`]).
//!
//! Noise and levels move the middle by half of what they do to the width; a blur that is off moves
//! both edges outwards and the middle not at all; scale errors take their share of the height over
//! the optical axis alone. Over the angles the fit's residual, pooled over the stations, shows what
//! else scatters (odd lobes, asynchronous spindle motion, vibration); where it exceeds the edges'
//! own statement it counts. Lobes that run along the part are the same at every station: of what
//! the stations leave alike, one station's freedom alone is known.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::column_diameters::ColumnDiameters;
use super::station_mean::{StationColumns, StationMean};
use super::stations::{StationLimits, variance_of_mean};
use crate::frame::FrameMeta;
use crate::gauge::calibration::axis_zero::AxisZero;
use crate::gauge::edge::stream::StreamLimits;
use crate::gauge::limit::limits;
use crate::numerics::distributions::{chi2_ratio_limit, student};
use crate::profile::{Reading, Reason};

limits! {
    /// What stations show of the axis.
    AxisLimits = "axis_line";
    /// Share of a station's columns that an angle needs: less carries no line over the station
    /// (`station_mean.most_gain`), and its plain mean stands too far to one side. Tuned: see study
    /// limits.
    least_fill: f64 = 0.3;
    /// Variance of x over that of one angle, at most, where turning part and still part are
    /// separated: angles that span less of the turn leave both mixed. Four angles around the turn
    /// give 1/4.
    most_gain: f64 = 4.0;
    /// Share of a station's columns from which one frame carries it: two thirds carry a parabola
    /// (`station_mean.most_gain`); a line is extrapolated over the rest.
    whole: f64 = 2.0 / 3.0;
    /// Distance of bursts, in lengths of a station, up to which they stand at one place: nearer
    /// ones see an axis that is bent alike. Tuned: see study limits.
    same_place: f64 = 0.02;
    /// Angles for one more odd harmonic: a harmonic has two terms, and twice as many remain free;
    /// as over half a turn (`turn_scatter`).
    angles_a_harmonic: usize = 6;
    /// Most odd harmonics adjusted: 1, 3 and 5, as over half a turn; further lobes of a turned part
    /// are smaller.
    most_harmonics: usize = 3;
}

/// Probability of an interval of ± 2u of the normal distribution, 2Φ(2) − 1.
const U_PROBABILITY: f64 = 0.954_499_736;

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

    /// Radial run-out of the axis against the axis of rotation, mm: twice the amplitude (form
    /// apart).
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
    /// Height of the axis over the optical axis, what stands still of it, mm; where `turning` is
    /// none, what turns is in it as it stood.
    pub x_mm: f64,
    /// Standard uncertainty of the height by what scatters from angle to angle and station to
    /// station, mm.
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
    /// Departure of the height from the chord between the first and the last station, (z,
    /// departure, its random standard uncertainty), mm: how the shaft bends in the image plane,
    /// wherever its supports stand.
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

    /// What stands still towards the camera, where a second camera sees the same shaft with its own
    /// upward direction turned by `view_deg` from x towards y: x' = x·cos ψ + y·sin ψ. The two
    /// optical axes' distance along y stays in it as a constant. Nothing where the directions are
    /// less than 10° apart, and for stations that one of both has not seen.
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
    seen: StationColumns,
    common_mm: f64,
    /// Σ own variance of the width, mm².
    own: f64,
    /// Σ shared variance of the width, mm².
    shared: f64,
    length: f64,
    /// Whether they are readings of a line camera.
    narrow: bool,
}

impl Sums {
    fn join(&mut self, other: &Self) {
        self.columns += other.columns;
        self.seen.join(&other.seen);
        self.common_mm += other.common_mm;
        self.own += other.own;
        self.shared += other.shared;
        self.length = other.length;
        self.narrow = other.narrow;
    }

    /// Variance of the mean middle by the edges' own statements, mm²: a quarter of the width's.
    fn noise(&self, gain: f64) -> f64 {
        0.25 * gain * variance_of_mean(self.columns as f64, self.own, self.shared, self.length)
    }
}

/// Averages the middles of a scan's frames into the axis of the part.
#[derive(Clone, Debug)]
pub struct AxisAverager {
    z_mm: Vec<f64>,
    station_mm: f64,
    zero: AxisZero,
    pitch_mm: f64,
    /// Per station: what each burst of frames shows of it.
    sums: Vec<Vec<Burst>>,
}

/// Frames of different angles taken at one place of the carriage, or nearly so while it moves: sums
/// of a station by angle in microdegrees.
#[derive(Clone, Debug, Default)]
struct Burst {
    angles: BTreeMap<i64, Sums>,
    /// Places of the frames' middles: the last and their sum, mm.
    last_z_mm: f64,
    sum_z_mm: f64,
}

impl Burst {
    fn z_mm(&self) -> f64 {
        self.sum_z_mm / self.angles.len() as f64
    }

    fn insert(&mut self, angle: i64, z_mm: f64, sums: Sums) {
        self.angles.insert(angle, sums);
        self.last_z_mm = z_mm;
        self.sum_z_mm += z_mm;
    }
}

/// One station before its uncertainty is known.
struct Fit {
    x_mm: f64,
    turning: Option<(f64, f64)>,
    /// Variances of x and of the turning components over that of one angle.
    gains: [f64; 2],
    residual: f64,
    freedom: f64,
    /// What it leaves, by angle in radians, mm.
    left: Vec<(f64, f64)>,
    noise: f64,
    /// Variances of x and of the turning components by what was not seen of the station, mm².
    rest: [f64; 2],
    /// Variance of one angle by surface texture over that of a whole station.
    share: f64,
    common_mm: f64,
    angles: usize,
}

impl AxisAverager {
    /// Stations by their middles, ascending, and their common length.
    pub fn new(z_mm: Vec<f64>, station_mm: f64, zero: AxisZero) -> Self {
        let sums = vec![Vec::new(); z_mm.len()];
        Self { z_mm, station_mm, zero, pitch_mm: 0.0, sums }
    }

    /// Adds a frame's columns.
    pub fn add(&mut self, meta: &FrameMeta, diameters: &ColumnDiameters) {
        let stream_limits = StreamLimits::get();
        self.pitch_mm = diameters.pitch_mm;
        let angle = (meta.angle_deg.rem_euclid(360.0) * 1e6).round() as i64 % 360_000_000;
        let half = 0.5 * self.station_mm;
        let mut of_frame: BTreeMap<usize, Sums> = BTreeMap::new();
        for (index, column) in diameters.columns.iter().enumerate() {
            let Reading::Value(d) = column.reading else { continue };
            let z_mm = diameters.z_mm(meta, index);
            let after = self.z_mm.partition_point(|middle| *middle + half <= z_mm);
            if after >= self.z_mm.len() || z_mm < self.z_mm[after] - half {
                continue;
            }
            let sums = of_frame.entry(after).or_default();
            let shared = column.shared_mm.powi(2);
            let t = (z_mm - self.z_mm[after]) / half;
            sums.columns += 1;
            sums.seen.add(t, column.middle_mm - self.zero.height_mm);
            sums.common_mm += column.u_middle_common_mm;
            sums.own += (d.u_random_mm.powi(2) - shared).max(0.0);
            sums.shared += shared;
            sums.length = diameters.shared_length;
            sums.narrow = diameters.columns.len() < stream_limits.least_columns;
        }
        for (station, sums) in of_frame {
            self.put(station, angle, meta.z_mm, sums);
        }
    }

    /// Puts a frame's sums with those of the burst that it belongs to.
    fn put(&mut self, station: usize, angle: i64, z_mm: f64, sums: Sums) {
        let bursts = &mut self.sums[station];
        if sums.narrow {
            if bursts.is_empty() {
                bursts.push(Burst::default());
            }
            bursts[0].angles.entry(angle).or_default().join(&sums);
            return;
        }
        let off = |b: &Burst| (b.last_z_mm - z_mm).abs();
        let own =
            bursts.iter_mut().filter(|b| !b.angles.contains_key(&angle) && off(b) <= 0.5 * self.station_mm);
        match own.min_by(|a, b| off(a).total_cmp(&off(b))) {
            Some(burst) => burst.insert(angle, z_mm, sums),
            None => {
                let mut burst = Burst::default();
                burst.insert(angle, z_mm, sums);
                bursts.push(burst);
            }
        }
    }

    /// What the angles show of a station: the burst whose middle is nearest, where it carries the
    /// station, and those at its place. While the tool cuts, every field sees an axis that is bent
    /// otherwise, and two of them would mix. Bursts that show parts are put together.
    fn of_angles(&self, station_z_mm: f64, bursts: &[Burst]) -> BTreeMap<i64, Sums> {
        let limits = AxisLimits::get();
        let least = limits.whole * self.station_mm / self.pitch_mm.max(1e-12);
        let most = bursts.iter().map(|b| b.angles.len()).max().unwrap_or(0);
        let carries =
            |b: &&Burst| b.angles.len() == most && b.angles.values().all(|s| s.columns as f64 >= least);
        let off = |b: &Burst| (b.z_mm() - station_z_mm).abs();
        let nearest = bursts.iter().filter(carries).min_by(|a, b| off(a).total_cmp(&off(b)));
        let there = |b: &&Burst| {
            nearest.is_none_or(|n| (n.z_mm() - b.z_mm()).abs() < limits.same_place * self.station_mm)
        };
        let mut all: BTreeMap<i64, Sums> = BTreeMap::new();
        for (angle, sums) in bursts.iter().filter(there).flat_map(|b| &b.angles) {
            all.entry(*angle).or_default().join(sums);
        }
        all
    }

    /// Ends the scan.
    pub fn finish(&self) -> AxisLine {
        let fits: Vec<Result<Fit, Reason>> =
            self.z_mm.iter().zip(&self.sums).map(|(z, b)| self.fit(&self.of_angles(*z, b))).collect();
        let pooled = pooled_variance(fits.iter().flatten());
        let pooled = pooled.map(|variance| (variance, shared_by_stations(fits.iter().flatten(), variance)));
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
        let least = (AxisLimits::get().least_fill * self.station_mm / self.pitch_mm.max(1e-12)).max(1.0);
        let good: Vec<(f64, &Sums)> = sums
            .iter()
            .filter(|(_, s)| s.columns as f64 >= least)
            .map(|(angle, s)| ((*angle as f64 * 1e-6).to_radians(), s))
            .collect();
        if good.is_empty() {
            return Err(Reason::TooFewColumns);
        }
        let n = good.len() as f64;
        let means: Vec<StationMean> = good.iter().map(|(_, s)| s.seen.mean()).collect();
        let noise = good.iter().zip(&means).map(|((_, s), m)| s.noise(m.gain)).sum::<f64>() / n;
        // What was not seen of a sloping axis stands still or turns with the part as the axis does:
        // angles do not average it.
        let rests: Vec<(f64, f64)> =
            good.iter().zip(&means).map(|((angle, _), m)| (*angle, m.rest)).collect();
        let unseen = harmonics(&rests);
        let rest_noise =
            |(_, s): &(f64, &Sums), m: &StationMean| 0.25 * m.rest_gain * s.own / (s.columns as f64).powi(2);
        let by_noise = good.iter().zip(&means).map(|(s, m)| rest_noise(s, m)).sum::<f64>() / n;
        let turning = unseen.turning.map_or(0.0, |(x, y)| 0.5 * (x * x + y * y));
        let rest = [
            (unseen.x_mm.powi(2) - unseen.gains[0] * by_noise).max(0.0),
            (turning - unseen.gains[1] * by_noise).max(0.0),
        ];
        let common_mm = good.iter().map(|(_, s)| s.common_mm / s.columns as f64).sum::<f64>() / n;
        let middles: Vec<(f64, f64)> =
            good.iter().zip(&means).map(|((angle, _), m)| (*angle, m.mean)).collect();
        let whole = self.station_mm / self.pitch_mm.max(1e-12);
        let part = |s: &Sums, m: &StationMean| (m.gain * whole / s.columns as f64).max(1.0);
        let narrow = good.iter().any(|(_, s)| s.narrow);
        let share = good.iter().zip(&means).map(|((_, s), m)| part(s, m)).sum::<f64>() / n;
        let share = if narrow { 1.0 } else { share };
        let found = harmonics(&middles);
        Ok(Fit {
            noise,
            rest,
            share,
            common_mm,
            angles: good.len(),
            residual: found.residual / share,
            ..found
        })
    }
}

impl Fit {
    fn station(&self, z_mm: f64, pooled: Option<(f64, f64)>, u_scale: f64) -> AxisStation {
        // What one station's freedom alone shows is widened as Student's t is, so that 2u covers
        // what it should.
        let widened = few_freedom(self.freedom);
        let scatter = match pooled {
            Some((pooled, _)) if self.freedom > 0.0 && self.residual > StationLimits::get().far * pooled => {
                self.residual * widened
            }
            Some((pooled, shared)) => pooled + shared * (widened - 1.0),
            None => 0.0,
        };
        let one_angle = (scatter * self.share).max(self.noise);
        let u = |k: usize| (self.gains[k] * one_angle + self.rest[k]).sqrt();
        AxisStation {
            z_mm,
            x_mm: self.x_mm,
            u_random_mm: u(0),
            u_common_mm: self.common_mm.hypot(u_scale * self.x_mm),
            turning: self.turning.map(|(x_mm, y_mm)| TurningOffset { x_mm, y_mm, u_mm: u(1) }),
            angles: self.angles,
        }
    }
}

/// Still part and first harmonic, with as many odd harmonics beside them as the angles allow; the
/// mean alone where they span too little.
fn harmonics(middles: &[(f64, f64)]) -> Fit {
    let limits = AxisLimits::get();
    let n = middles.len();
    let start = middles[0].1;
    let most = (n.saturating_sub(3) / limits.angles_a_harmonic).clamp(1, limits.most_harmonics);
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
        if !(inverse[(0, 0)] < limits.most_gain) {
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
            left: (&observed - &design * &solution).iter().zip(middles).map(|(e, m)| (m.0, *e)).collect(),
            noise: 0.0,
            rest: [0.0; 2],
            share: 1.0,
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
        left: Vec::new(),
        noise: 0.0,
        rest: [0.0; 2],
        share: 1.0,
        common_mm: 0.0,
        angles: n,
    }
}

/// Variance of one angle's middle, mm², pooled over the stations without those far beyond the
/// median; `None` without freedom.
fn pooled_variance<'a>(fits: impl Iterator<Item = &'a Fit>) -> Option<f64> {
    let station_limits = StationLimits::get();
    let mut all: Vec<(f64, f64)> =
        fits.filter(|f| f.freedom > 0.0).map(|f| (f.residual, f.freedom)).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (median, freedom) = *all.get(all.len() / 2)?;
    let limit = station_limits.far * median / chi2_ratio_limit(freedom, 0.0).max(0.2);
    let (sum, total) = all
        .iter()
        .filter(|v| v.0 <= limit)
        .fold((0.0, 0.0), |(sum, total), (residual, freedom)| (sum + residual * freedom, total + freedom));
    (total > 0.0).then(|| sum / total)
}

/// Share of the pooled variance, mm², that all stations have in common: odd lobes run along a
/// turned part, and the more stations show them the less is learnt. It is the variance of the mean
/// of what the stations' fits leave angle by angle, less what independent scatter makes of such a
/// mean.
fn shared_by_stations<'a>(fits: impl Iterator<Item = &'a Fit>, pooled: f64) -> f64 {
    let station_limits = StationLimits::get();
    let mut by_angle: BTreeMap<i64, (f64, f64)> = BTreeMap::new();
    let (mut stations, mut freedom) = (0.0, 0.0);
    for fit in fits.filter(|f| f.freedom > 0.0 && f.residual <= station_limits.far * pooled) {
        stations += 1.0;
        freedom += fit.freedom;
        for (angle, left) in &fit.left {
            let (sum, n) = by_angle.entry((angle * 1e9).round() as i64).or_default();
            *sum += left;
            *n += 1.0;
        }
    }
    if stations < 2.0 {
        return pooled;
    }
    let of_means = by_angle.values().map(|(sum, n)| (sum / n).powi(2)).sum::<f64>() * stations / freedom;
    // Independent scatter alone makes a mean as large as this in one scan of forty.
    let by_chance = chi2_ratio_limit(freedom / stations, 2.0) * pooled / stations;
    (of_means - by_chance).clamp(0.0, pooled)
}

/// Square of (Student's t over the normal's quantile) at the probability of U = 2u.
fn few_freedom(freedom: f64) -> f64 {
    if freedom < 1.0 { 1.0 } else { (student(freedom, U_PROBABILITY) / 2.0).powi(2) }
}

#[cfg(test)]
mod tests;
