//! What the frames of a scan show of a station, burst by burst.
//!
//! A burst is the frames of different spindle angles that were taken at one place of the carriage,
//! or nearly so while it moves. While a pass is cut every burst sees an axis bent by the force of
//! its own instants, so that a mean over two bursts would be the axis of no instant:
//! [`Bursts::at_one_place`] takes one.

use std::collections::BTreeMap;

use crate::gauge::limit::limits;

limits! {
    /// Which frames show a station together.
    BurstLimits = "bursts";
    /// Share of a station's columns from which one frame carries it: two thirds carry a parabola
    /// (`station_mean.most_gain`); a line is extrapolated over the rest (gain 4 at a half, 1.9
    /// here).
    whole: f64 = 2.0 / 3.0;
    /// Distance of bursts, in lengths of a station, up to which they stand at one place: nearer
    /// ones see an axis that is bent alike. Tuned: see study limits.
    same_place: f64 = 0.02;
    /// Way of the field over the frames of a burst from which the carriage moved, mm: scales of
    /// carriages read to a micrometre, and a tool feeds more than a hundredth of a millimetre a
    /// revolution.
    stands_mm: f64 = 5e-3;
}

/// Sums of what one frame or more show of a station.
pub(super) trait Shown: Clone + Default {
    /// Columns in them.
    fn columns(&self) -> usize;
    /// Adds the sums of another frame.
    fn join(&mut self, other: &Self);
}

/// Sums of a station by burst.
#[derive(Clone, Debug, Default)]
pub(super) struct Bursts<S>(Vec<Burst<S>>);

/// Sums by angle in microdegrees, and where the field's middle stood, mm: by angle (not of a line
/// camera's readings, each of which shows another piece of the station), in the last frame, at
/// the ends of its way, and the sum over the frames.
#[derive(Clone, Debug)]
struct Burst<S> {
    angles: BTreeMap<i64, S>,
    places_mm: BTreeMap<i64, f64>,
    frames: f64,
    last_z_mm: f64,
    way_mm: (f64, f64),
    sum_z_mm: f64,
}

/// The station that is asked for.
pub(super) struct Whole {
    /// Its middle, mm.
    pub(super) z_mm: f64,
    /// Its length, mm.
    pub(super) station_mm: f64,
    /// Columns of a frame that shows all of it.
    pub(super) columns: f64,
}

/// What was taken of a station.
pub(super) struct AtOnePlace<S> {
    /// Sums by angle in microdegrees.
    pub(super) angles: BTreeMap<i64, S>,
    /// Mean place of the field's middle, mm.
    pub(super) field_z_mm: f64,
    /// How far from there it stood at every angle, mm, where the carriage moved.
    ways_mm: BTreeMap<i64, f64>,
}

impl<S> AtOnePlace<S> {
    /// How far from its mean place the field stood at an angle, mm; 0 where the carriage stood.
    pub(super) fn way_mm(&self, angle: i64) -> f64 {
        self.ways_mm.get(&angle).copied().unwrap_or(0.0)
    }
}

impl<S: Shown> Burst<S> {
    fn begun(z_mm: f64) -> Self {
        Self {
            angles: BTreeMap::new(),
            places_mm: BTreeMap::new(),
            frames: 0.0,
            last_z_mm: z_mm,
            way_mm: (z_mm, z_mm),
            sum_z_mm: 0.0,
        }
    }

    fn add(&mut self, angle: i64, z_mm: f64, sums: &S) {
        self.angles.entry(angle).or_default().join(sums);
        self.frames += 1.0;
        self.last_z_mm = z_mm;
        self.way_mm = (self.way_mm.0.min(z_mm), self.way_mm.1.max(z_mm));
        self.sum_z_mm += z_mm;
    }

    fn add_placed(&mut self, angle: i64, z_mm: f64, sums: &S) {
        self.add(angle, z_mm, sums);
        self.places_mm.insert(angle, z_mm);
    }

    fn z_mm(&self) -> f64 {
        self.sum_z_mm / self.frames
    }

    fn moves(&self) -> bool {
        self.way_mm.1 - self.way_mm.0 > BurstLimits::get().stands_mm
    }

    /// Columns of the angle that shows least of the station.
    fn least_columns(&self) -> usize {
        self.angles.values().map(S::columns).min().unwrap_or(0)
    }
}

impl<S: Shown> Bursts<S> {
    /// Puts a frame's sums with those of the burst that it belongs to: the nearest at most `reach`
    /// mm away in which its angle is missing.
    pub(super) fn add(&mut self, angle: i64, z_mm: f64, sums: &S, reach: f64) {
        let off = |b: &Burst<S>| (b.last_z_mm - z_mm).abs();
        let own = self.0.iter_mut().filter(|b| !b.angles.contains_key(&angle) && off(b) <= reach);
        match own.min_by(|a, b| off(a).total_cmp(&off(b))) {
            Some(burst) => burst.add_placed(angle, z_mm, sums),
            None => {
                let mut burst = Burst::begun(z_mm);
                burst.add_placed(angle, z_mm, sums);
                self.0.push(burst);
            }
        }
    }

    /// Puts a frame's sums with those of all frames before it: readings of a line camera, none of
    /// which shows a station by itself.
    pub(super) fn join(&mut self, angle: i64, z_mm: f64, sums: &S) {
        if self.0.is_empty() {
            self.0.push(Burst::begun(z_mm));
        }
        self.0[0].add(angle, z_mm, sums);
    }

    /// Whether the carriage moved while the frames of a burst were taken, so that each burst may
    /// have seen another axis.
    pub(super) fn moved(&self) -> bool {
        self.0.iter().any(Burst::moves)
    }

    /// What shows the station: the burst whose field stands nearest, where it carries the station,
    /// and those at its place. Where none carries it, all together if the carriage stood still, as
    /// the shaft then did; else the one that shows most.
    pub(super) fn at_one_place(&self, whole: &Whole) -> AtOnePlace<S> {
        let limits = BurstLimits::get();
        let most = self.0.iter().map(|b| b.angles.len()).max().unwrap_or(0);
        let carries = |b: &&Burst<S>| {
            b.angles.len() == most && b.least_columns() as f64 >= limits.whole * whole.columns
        };
        let off = |b: &Burst<S>| (b.z_mm() - whole.z_mm).abs();
        let nearest = self.0.iter().filter(carries).min_by(|a, b| off(a).total_cmp(&off(b)));
        let shows = |b: &Burst<S>| (b.angles.len(), b.least_columns());
        let fullest = || self.0.iter().filter(|_| self.moved()).max_by_key(|b| shows(b));
        let taken = nearest.or_else(fullest);
        let there = |b: &&Burst<S>| {
            taken.is_none_or(|t| (t.z_mm() - b.z_mm()).abs() < limits.same_place * whole.station_mm)
        };
        together(self.0.iter().filter(there))
    }

    /// All frames together.
    pub(super) fn all(&self) -> AtOnePlace<S> {
        together(self.0.iter())
    }
}

fn together<'b, S: Shown + 'b>(bursts: impl Iterator<Item = &'b Burst<S>>) -> AtOnePlace<S> {
    let mut angles: BTreeMap<i64, S> = BTreeMap::new();
    let (mut sum, mut frames) = (0.0, 0.0);
    let mut ways_mm = BTreeMap::new();
    for burst in bursts {
        if burst.moves() {
            ways_mm.extend(burst.places_mm.iter().map(|(angle, z_mm)| (*angle, z_mm - burst.z_mm())));
        }
        sum += burst.sum_z_mm;
        frames += burst.frames;
        for (angle, sums) in &burst.angles {
            angles.entry(*angle).or_default().join(sums);
        }
    }
    AtOnePlace { angles, field_z_mm: sum / frames, ways_mm }
}
