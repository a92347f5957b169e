//! What a report of `measure` keeps of the frames: the numbers of those that it shows, running
//! values of all (`measured_values`), small pictures of the first refused ones, the budget of the
//! worst. However long the series is, no frame is kept, and the memory does not grow any more.

use std::collections::BTreeSet;

use super::measured_values::{MeasuredValues, Value};
use super::picture::{encode, thumbnail};
use crate::frame::Frame;
use crate::gauge::Budget;
use crate::measurement::{Flags, Judged, Measurement, StationResult, Verdict};
use crate::profile::Reason;

/// Most rows of the table of frames and of that of stations: some ten pages of A4.
pub(super) const MOST_ROWS: usize = 400;
/// Most refused frames that are shown: a report of some megabytes can still be sent.
pub(super) const MOST_PICTURES: usize = 20;
/// Longest side of their pictures, px: half a page of A4 at 120 px an inch.
const SIDE_PX: usize = 480;
/// Most stations kept: a chart of more shows no more.
const MOST_STATIONS: usize = 20_000;

/// The numbers of a frame.
#[derive(Clone, Debug)]
pub(super) struct FrameRow {
    /// Its number in the series, from 0.
    pub index: usize,
    pub frame: String,
    /// z of the largest diameter, mm.
    pub z_mm: Option<f64>,
    pub largest: Option<Value>,
    pub mean: Option<Value>,
    pub average: Option<Value>,
    pub verdict: Verdict,
    pub judged: Option<Judged>,
    pub valid: usize,
    pub columns: usize,
    pub flags: Flags,
    /// Why the frame has no diameter at all.
    pub refused: Option<Reason>,
    pub warnings: Vec<String>,
}

/// A station with the number of its frame among [`MeasuredFrames::station_frames`].
#[derive(Clone, Copy, Debug)]
pub(super) struct StationRow {
    pub frame: usize,
    pub station: StationResult,
}

/// A refused frame.
#[derive(Clone, Debug)]
pub(super) struct RefusedFrame {
    pub frame: String,
    pub why: String,
    /// Its picture, where it could be read.
    pub png: Option<Vec<u8>>,
}

/// The budget of one frame's largest diameter.
#[derive(Clone, Debug)]
pub(super) struct FrameBudget {
    pub frame: String,
    severity: u8,
    pub budget: Budget,
    pub k: f64,
}

/// The frames of a series as far as they were added.
#[derive(Clone, Debug, Default)]
pub(super) struct MeasuredFrames {
    /// All frames.
    pub count: usize,
    /// Those without a diameter.
    pub refused_count: usize,
    /// The first [`MOST_ROWS`] frames that are not good or were refused.
    odd: Vec<FrameRow>,
    /// The first [`MOST_ROWS`] others.
    good: Vec<FrameRow>,
    /// Largest diameters of all frames.
    pub values: MeasuredValues,
    /// Words that stand in the rows of all frames.
    pub words: WordsSeen,
    pub stations: Vec<StationRow>,
    /// Names of the frames of these stations.
    pub station_frames: Vec<String>,
    /// Stations beyond those kept.
    pub stations_left_out: usize,
    /// The first [`MOST_PICTURES`] refused frames.
    pub refused: Vec<RefusedFrame>,
    /// The budget of the worst frame, of equally bad ones the first.
    pub budget: Option<FrameBudget>,
}

/// What a legend explains: each kind once.
#[derive(Clone, Debug, Default)]
pub(super) struct WordsSeen {
    verdicts: Vec<Verdict>,
    pub reasons: BTreeSet<Reason>,
    /// Least and greatest coverage factor of the largest diameters.
    pub factors: Option<(f64, f64)>,
}

impl WordsSeen {
    fn add(&mut self, measured: &Measurement) {
        if !self.has(measured.judgement) {
            self.verdicts.push(measured.judgement);
        }
        self.reasons.extend(measured.flags.iter().map(|(reason, _)| reason));
        if let Some(k) = measured.diameter.as_ref().map(|d| d.coverage_factor) {
            let (low, high) = self.factors.unwrap_or((k, k));
            self.factors = Some((low.min(k), high.max(k)));
        }
    }

    /// Whether a frame has this verdict.
    pub(super) fn has(&self, verdict: Verdict) -> bool {
        self.verdicts.contains(&verdict)
    }
}

impl MeasuredFrames {
    /// Adds a frame; `k` is the coverage factor of its means, `frame` its picture, which is read
    /// where it was refused.
    pub(super) fn add(&mut self, measured: &Measurement, k: f64, frame: Option<&Frame>) {
        self.add_refused(measured, frame);
        self.add_budget(measured);
        self.add_stations(measured);
        self.words.add(measured);
        self.values.add(largest(measured), measured.judgement);
        let is_odd = measured.refusal.is_some() || measured.judgement.severity() > 0;
        let index = self.count;
        let rows = if is_odd { &mut self.odd } else { &mut self.good };
        if rows.len() < MOST_ROWS {
            rows.push(row(index, measured, k));
        }
        self.refused_count += usize::from(measured.refusal.is_some());
        self.count += 1;
    }

    /// The rows that are shown: all, or of many those that are not good, then the first good ones.
    pub(super) fn shown(&self) -> Vec<&FrameRow> {
        let mut rows: Vec<&FrameRow> = self.odd.iter().chain(&self.good).take(MOST_ROWS).collect();
        if self.count <= MOST_ROWS {
            rows.sort_by_key(|row| row.index);
        }
        rows
    }

    fn add_stations(&mut self, measured: &Measurement) {
        let stations = measured.stations.as_deref().unwrap_or_default();
        let kept = stations.len().min(MOST_STATIONS - self.stations.len());
        self.stations_left_out += stations.len() - kept;
        if kept > 0 {
            let frame = self.station_frames.len();
            self.station_frames.push(measured.frame.clone());
            self.stations.extend(stations[..kept].iter().map(|s| StationRow { frame, station: *s }));
        }
    }

    fn add_refused(&mut self, measured: &Measurement, frame: Option<&Frame>) {
        let Some(refusal) = measured.refusal.as_ref().filter(|_| self.refused.len() < MOST_PICTURES) else {
            return;
        };
        // A picture that cannot be encoded is left out; the reason stands without it.
        let png = frame.and_then(|frame| encode(&thumbnail(&frame.view(), SIDE_PX)).ok());
        self.refused.push(RefusedFrame { frame: measured.frame.clone(), why: refusal.why.clone(), png });
    }

    fn add_budget(&mut self, measured: &Measurement) {
        let (Some(budget), Some(largest)) = (&measured.budget, &measured.diameter) else { return };
        let severity = measured.judgement.severity();
        if self.budget.as_ref().is_none_or(|known| severity > known.severity) {
            let (frame, k) = (measured.frame.clone(), largest.coverage_factor);
            self.budget = Some(FrameBudget { frame, severity, budget: budget.clone(), k });
        }
    }
}

/// The largest diameter with its expanded uncertainty.
fn largest(measured: &Measurement) -> Option<Value> {
    measured.diameter.as_ref().map(|d| Value { d_mm: d.diameter.d_mm, expanded_mm: d.expanded_u_mm })
}

fn row(index: usize, measured: &Measurement, k: f64) -> FrameRow {
    let largest = largest(measured);
    FrameRow {
        index,
        frame: measured.frame.clone(),
        z_mm: measured.place.filter(|_| largest.is_some()).map(|place| place.z_mm),
        largest,
        mean: measured.mean.map(|d| Value::of(d, k)),
        average: measured.average.map(|d| Value::of(d, k)),
        verdict: measured.judgement,
        judged: measured.judged,
        valid: measured.valid,
        columns: measured.columns,
        flags: measured.flags.clone(),
        refused: measured.refusal.as_ref().map(|refusal| refusal.reason),
        warnings: measured.warnings.iter().map(ToString::to_string).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::FrameMeta;
    use crate::measurement::Refusal;
    use crate::profile::Reading;

    #[test]
    fn of_many_refused_frames_some_pictures_are_kept() {
        let frame = Frame::linear(vec![1.0; 600 * 800], 600, 800, None, FrameMeta::default());
        let refusal = Some(Refusal { reason: Reason::LowContrast, why: "dark".to_owned() });
        let measured = Measurement { frame: "a".to_owned(), refusal, ..Measurement::default() };
        let mut frames = MeasuredFrames::default();
        (0..25).for_each(|_| frames.add(&measured, 2.0, Some(&frame)));
        frames.add(&measured, 2.0, None);
        assert_eq!((frames.count, frames.refused_count, frames.shown().len()), (26, 26, 26));
        assert_eq!(frames.refused.len(), MOST_PICTURES);
        assert!(frames.refused.iter().all(|f| f.png.as_ref().is_some_and(|png| png.len() > 8)));
    }
    #[test]
    fn a_long_series_keeps_no_more_than_is_shown() {
        let stations =
            Some(vec![StationResult { z_mm: 0.0, reading: Reading::Gap(Reason::NoEdge), judged: None }]);
        let mut measured = Measurement { stations, ..Measurement::default() };
        let mut frames = MeasuredFrames::default();
        for index in 0..30_000 {
            measured.frame = index.to_string();
            measured.judgement = if index % 7 == 0 { Verdict::NotProven } else { Verdict::NotJudged };
            frames.add(&measured, 2.0, None);
        }
        assert_eq!((frames.count, frames.odd.len(), frames.good.len()), (30_000, MOST_ROWS, MOST_ROWS));
        assert_eq!((frames.stations.len(), frames.stations_left_out), (MOST_STATIONS, 10_000));
        let last = frames.stations.last().unwrap();
        assert_eq!(frames.station_frames[last.frame], "19999");
        let shown = frames.shown();
        assert!(shown.len() == MOST_ROWS && shown.iter().all(|row| row.index % 7 == 0));
    }
}
