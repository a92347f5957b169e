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
//!
//! While a pass is cut the axis is another one at every instant, bent by the force where the tool
//! then stands. The value of a station is the axis of one burst of frames, its mean over the burst:
//! of the burst whose field stands nearest to the station's middle, where it carries the station
//! (`bursts`), and never of two. [`AxisStation::field_z_mm`] states which. As the tool goes on
//! within the burst, the middle drifts: a steady drift is adjusted with the harmonics, which the
//! job's order of the angles keeps nearly apart; from fewer than six angles it is in the residual.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::bursts::{AtOnePlace, Bursts, Shown, Whole};
use super::column_diameters::ColumnDiameters;
use super::station_mean::{StationColumns, StationMean};
use super::station_row::{Gathered, StationRow};
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
    pub(crate) fn amplitude_mm(&self) -> f64 {
        self.x_mm.hypot(self.y_mm)
    }

    /// Body angle of the offset, degrees from x towards y.
    #[cfg(test)]
    pub(crate) fn phase_deg(&self) -> f64 {
        self.y_mm.atan2(self.x_mm).to_degrees()
    }

    /// Radial run-out of the axis against the axis of rotation, mm: twice the amplitude (form
    /// apart).
    pub(crate) fn run_out_mm(&self) -> f64 {
        2.0 * self.amplitude_mm()
    }

    /// Offset (upwards, towards the camera) at a spindle angle, mm.
    pub(crate) fn at(&self, angle_deg: f64) -> (f64, f64) {
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
    /// Where the middle of the field stood in the frames that it was read from, their mean, mm: in
    /// a pass that is measured while it is cut, the instants whose axis it is.
    #[serde(skip)]
    pub field_z_mm: f64,
}

impl AxisStation {
    /// Combined standard uncertainty of the height, mm.
    pub(crate) fn u_mm(&self) -> f64 {
        self.u_random_mm.hypot(self.u_common_mm)
    }
}

/// What is known of the axis' part that stands still towards the camera.
pub(crate) const STILL_TOWARDS_CAMERA: &str = "not seen: needs a second viewing direction";

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
#[cfg(test)]
pub(crate) struct StillTowardsCamera {
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
    pub(crate) fn bend_mm(&self) -> Vec<(f64, f64, f64)> {
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

    /// What stands still towards the camera, where a second camera sees the same shaft with its own
    /// upward direction turned by `view_deg` from x towards y: x' = x·cos ψ + y·sin ψ. The two
    /// optical axes' distance along y stays in it as a constant. Nothing where the directions are
    /// less than 10° apart, and for stations that one of both has not seen.
    #[cfg(test)]
    pub(crate) fn seen_from(&self, second: &Self, view_deg: f64) -> Vec<StillTowardsCamera> {
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

impl Shown for Sums {
    fn columns(&self) -> usize {
        self.columns
    }

    fn join(&mut self, other: &Self) {
        self.columns += other.columns;
        self.seen.join(&other.seen);
        self.common_mm += other.common_mm;
        self.own += other.own;
        self.shared += other.shared;
        self.length = other.length;
        self.narrow = other.narrow;
    }
}

impl Sums {
    /// Variance of the mean middle by the edges' own statements, mm²: a quarter of the width's.
    fn noise(&self, gain: f64) -> f64 {
        0.25 * gain * variance_of_mean(self.columns as f64, self.own, self.shared, self.length)
    }
}

/// Averages the middles of a scan's frames into the axis of the part.
#[derive(Clone, Debug)]
pub(crate) struct AxisAverager {
    /// What each burst of frames shows of a station.
    row: StationRow<Bursts<Sums>>,
    zero: AxisZero,
    stands: bool,
}

/// What a station's middles show over the angles.
struct Harmonics {
    x_mm: f64,
    turning: Option<(f64, f64)>,
    /// Variances of x and of the turning components over that of one angle.
    gains: [f64; 2],
    residual: f64,
    freedom: f64,
    /// What it leaves, by angle in radians, mm.
    left: Vec<(f64, f64)>,
    /// Of the middle over the carriage's way, mm a mm.
    drift: f64,
}

/// One station before its uncertainty is known.
struct Fit {
    over_angles: Harmonics,
    noise: f64,
    /// Variances of x and of the turning components by what was not seen of the station, mm².
    rest: [f64; 2],
    /// Variance of one angle by surface texture over that of a whole station.
    share: f64,
    common_mm: f64,
    field_z_mm: f64,
    angles: usize,
}

impl AxisAverager {
    /// Stations by their middles, ascending, and their common length.
    pub(crate) fn new(z_mm: Vec<f64>, station_mm: f64, zero: AxisZero) -> Self {
        Self { row: StationRow::new(z_mm, station_mm), zero, stands: false }
    }

    /// For frames that are all taken at one place: what they show is summed up angle by angle, in
    /// memory that does not grow with their number. The result is the same.
    pub(crate) fn standing(self) -> Self {
        Self { stands: true, ..self }
    }

    /// Adds a frame's columns.
    pub(crate) fn add(&mut self, meta: &FrameMeta, diameters: &ColumnDiameters) {
        let stream_limits = StreamLimits::get();
        self.row.pitch_mm = diameters.pitch_mm;
        let angle = (meta.angle_deg.rem_euclid(360.0) * 1e6).round() as i64 % 360_000_000;
        let mut of_frame: BTreeMap<usize, Sums> = BTreeMap::new();
        for (index, column) in diameters.columns.iter().enumerate() {
            let Reading::Value(d) = column.reading else { continue };
            let Some((station, t)) = self.row.place(diameters.z_mm(meta, index)) else { continue };
            let sums = of_frame.entry(station).or_default();
            let shared = column.shared_mm.powi(2);
            sums.columns += 1;
            sums.seen.add(t, column.middle_mm - self.zero.height_mm);
            sums.common_mm += column.u_middle_common_mm;
            sums.own += (d.u_random_mm.powi(2) - shared).max(0.0);
            sums.shared += shared;
            sums.length = diameters.shared_length;
            sums.narrow = diameters.columns.len() < stream_limits.least_columns;
        }
        let half = 0.5 * self.row.station_mm();
        for (station, sums) in of_frame {
            let bursts = self.row.sums(station);
            match sums.narrow || self.stands {
                true => bursts.join(angle, meta.z_mm, &sums),
                false => bursts.add(angle, meta.z_mm, &sums, half),
            }
        }
    }

    /// Ends the scan.
    pub(crate) fn finish(&self) -> AxisLine {
        let (station_mm, columns) = (self.row.station_mm(), self.row.columns());
        let taken = |station: &Gathered<Bursts<Sums>>| {
            station.sums.at_one_place(&Whole { z_mm: station.z_mm, station_mm, columns })
        };
        let fits: Vec<Result<Fit, Reason>> = self.row.iter().map(|s| self.fit(&taken(s))).collect();
        let found = || fits.iter().flatten().map(|f| &f.over_angles);
        let pooled = pooled_variance(found());
        let pooled = pooled.map(|variance| (variance, shared_by_stations(found(), variance)));
        let mut line = AxisLine::default();
        for (Gathered { z_mm, .. }, fit) in self.row.iter().zip(&fits) {
            match fit {
                Ok(fit) => line.stations.push(fit.station(*z_mm, pooled, self.zero.u_scale)),
                Err(reason) => line.gaps.push((*z_mm, *reason)),
            }
        }
        line
    }

    fn fit(&self, taken: &AtOnePlace<Sums>) -> Result<Fit, Reason> {
        let sums = &taken.angles;
        if sums.is_empty() {
            return Err(Reason::NotScanned);
        }
        let least =
            (AxisLimits::get().least_fill * self.row.station_mm() / self.row.pitch_mm.max(1e-12)).max(1.0);
        let good: Vec<(Middle, &Sums)> = sums
            .iter()
            .filter(|(_, s)| s.columns as f64 >= least)
            .map(|(angle, s)| (Middle::at(*angle, taken.way_mm(*angle)), s))
            .collect();
        if good.is_empty() {
            return Err(Reason::TooFewColumns);
        }
        let n = good.len() as f64;
        let means: Vec<StationMean> = good.iter().map(|(_, s)| s.seen.mean()).collect();
        let noise = good.iter().zip(&means).map(|((_, s), m)| s.noise(m.gain)).sum::<f64>() / n;
        // What was not seen of a sloping axis stands still or turns with the part as the axis does:
        // angles do not average it.
        let rests: Vec<Middle> = good.iter().zip(&means).map(|(s, m)| s.0.reads(m.rest)).collect();
        let unseen = harmonics(&rests);
        let rest_noise = |(_, s): &(Middle, &Sums), m: &StationMean| {
            0.25 * m.rest_gain * s.own / (s.columns as f64).powi(2)
        };
        let by_noise = good.iter().zip(&means).map(|(s, m)| rest_noise(s, m)).sum::<f64>() / n;
        let turning = unseen.turning.map_or(0.0, |(x, y)| 0.5 * (x * x + y * y));
        let rest = [
            (unseen.x_mm.powi(2) - unseen.gains[0] * by_noise).max(0.0),
            (turning - unseen.gains[1] * by_noise).max(0.0),
        ];
        let common_mm = good.iter().map(|(_, s)| s.common_mm / s.columns as f64).sum::<f64>() / n;
        let middles: Vec<Middle> = good.iter().zip(&means).map(|(s, m)| s.0.reads(m.mean)).collect();
        let whole = self.row.columns();
        let part = |s: &Sums, m: &StationMean| (m.gain * whole / s.columns as f64).max(1.0);
        let narrow = good.iter().any(|(_, s)| s.narrow);
        let share = good.iter().zip(&means).map(|((_, s), m)| part(s, m)).sum::<f64>() / n;
        let share = if narrow { 1.0 } else { share };
        let mut over_angles = harmonics(&middles);
        over_angles.residual /= share;
        let (field_z_mm, angles) = (taken.field_z_mm, good.len());
        Ok(Fit { over_angles, noise, rest, share, common_mm, field_z_mm, angles })
    }
}

impl Harmonics {
    /// The mean over `angles` alone.
    fn of_mean(x_mm: f64, angles: usize) -> Self {
        let gains = [1.0 / angles as f64; 2];
        Self { x_mm, turning: None, gains, residual: 0.0, freedom: 0.0, left: Vec::new(), drift: 0.0 }
    }
}

impl Fit {
    fn station(&self, z_mm: f64, pooled: Option<(f64, f64)>, u_scale: f64) -> AxisStation {
        let Harmonics { x_mm, turning, gains, residual, freedom, .. } = self.over_angles;
        // What one station's freedom alone shows is widened as Student's t is, so that 2u covers
        // what it should.
        let widened = few_freedom(freedom);
        let scatter = match pooled {
            Some((pooled, _)) if freedom > 0.0 && residual > StationLimits::get().far * pooled => {
                residual * widened
            }
            Some((pooled, shared)) => pooled + shared * (widened - 1.0),
            None => 0.0,
        };
        let one_angle = (scatter * self.share).max(self.noise);
        let u = |k: usize| (gains[k] * one_angle + self.rest[k]).sqrt();
        AxisStation {
            z_mm,
            x_mm,
            u_random_mm: u(0),
            u_common_mm: self.common_mm.hypot(u_scale * x_mm),
            turning: turning.map(|(x_mm, y_mm)| TurningOffset { x_mm, y_mm, u_mm: u(1) }),
            angles: self.angles,
            field_z_mm: self.field_z_mm,
        }
    }
}

/// A middle of both edges at a spindle angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Middle {
    /// Spindle angle, radians.
    angle: f64,
    /// How far from its mean place in the burst the field stood, mm.
    way_mm: f64,
    /// Height, mm.
    mm: f64,
}

impl Middle {
    /// At an angle in microdegrees.
    pub(super) fn at(angle: i64, way_mm: f64) -> Self {
        Self { angle: (angle as f64 * 1e-6).to_radians(), way_mm, mm: 0.0 }
    }

    pub(super) fn reads(self, mm: f64) -> Self {
        Self { mm, ..self }
    }
}

/// Drift of the middle over the way of a carriage that moves, mm a mm: what bends the shaft goes on
/// while a burst is taken.
pub(super) fn drift(middles: &[Middle]) -> f64 {
    if middles.is_empty() { 0.0 } else { harmonics(middles).drift }
}

/// Still part and first harmonic, with as many odd harmonics beside them as the angles allow, and
/// where the carriage moved a steady drift if it leaves two degrees of freedom; the mean alone
/// where the angles span too little.
fn harmonics(middles: &[Middle]) -> Harmonics {
    let limits = AxisLimits::get();
    let n = middles.len();
    let start = middles[0].mm;
    let most = (n.saturating_sub(3) / limits.angles_a_harmonic).clamp(1, limits.most_harmonics);
    let moved = usize::from(middles.iter().any(|m| m.way_mm != 0.0));
    let terms = (1..=most).rev().flat_map(|orders| (0..=moved).rev().map(move |drifts| (orders, drifts)));
    for (orders, drifts) in terms {
        let columns = 1 + 2 * orders + drifts;
        if n < columns + 2 * drifts {
            continue;
        }
        let design = DMatrix::from_fn(n, columns, |row, column| term(&middles[row], orders, column));
        let Some(inverse) = (design.transpose() * &design).try_inverse() else { continue };
        if !(inverse[(0, 0)] < limits.most_gain) {
            continue;
        }
        let observed = DVector::from_iterator(n, middles.iter().map(|m| m.mm - start));
        let solution = &inverse * design.transpose() * &observed;
        let freedom = (n - columns) as f64;
        let square = (&observed - &design * &solution).norm_squared();
        return Harmonics {
            x_mm: start + solution[0],
            turning: Some((solution[1], solution[2])),
            gains: [inverse[(0, 0)], inverse[(1, 1)].max(inverse[(2, 2)])],
            residual: if freedom > 0.0 { square / freedom } else { 0.0 },
            freedom,
            left: (&observed - &design * &solution).iter().zip(middles).map(|(e, m)| (m.angle, *e)).collect(),
            drift: if drifts > 0 { solution[columns - 1] } else { 0.0 },
        };
    }
    Harmonics::of_mean(middles.iter().map(|m| m.mm).sum::<f64>() / n as f64, n)
}

/// Column `column` of the design at a middle: 1, cosine and sine of each odd harmonic, the way.
fn term(at: &Middle, orders: usize, column: usize) -> f64 {
    let turned = (2.0 * column.div_ceil(2) as f64 - 1.0) * at.angle;
    match column {
        0 => 1.0,
        c if c > 2 * orders => at.way_mm,
        c if c % 2 == 1 => turned.cos(),
        _ => -turned.sin(),
    }
}

/// Variance of one angle's middle, mm², pooled over the stations without those far beyond the
/// median; `None` without freedom.
fn pooled_variance<'a>(fits: impl Iterator<Item = &'a Harmonics>) -> Option<f64> {
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
fn shared_by_stations<'a>(fits: impl Iterator<Item = &'a Harmonics>, pooled: f64) -> f64 {
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
