//! What a report of `measure` keeps of the frames: numbers of every frame, small pictures of the
//! first refused ones, the budget of the worst. However long the series is, no frame is kept.

use super::picture::{encode, thumbnail};
use crate::frame::Frame;
use crate::gauge::Budget;
use crate::measurement::{Flags, Judged, Measurement, StationResult, Verdict};
use crate::profile::{Diameter, Reason};

/// Most refused frames that are shown: a report of some megabytes can still be sent.
pub(super) const MOST_PICTURES: usize = 20;
/// Longest side of their pictures, px: half a page of A4 at 120 px an inch.
const SIDE_PX: usize = 480;
/// Most stations kept: a chart of more shows no more.
const MOST_STATIONS: usize = 20_000;

/// A diameter with its expanded uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Value {
    pub d_mm: f64,
    pub expanded_mm: f64,
}

impl Value {
    /// Of a diameter, with U = k·u.
    pub(super) fn of(diameter: Diameter, k: f64) -> Self {
        Self { d_mm: diameter.d_mm, expanded_mm: k * diameter.u_mm() }
    }
}

/// The numbers of a frame.
#[derive(Clone, Debug)]
pub(super) struct FrameRow {
    pub frame: String,
    /// z of the largest diameter, mm.
    pub z_mm: Option<f64>,
    pub largest: Option<Value>,
    /// Coverage factor of the largest diameter's U.
    pub k: Option<f64>,
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

/// A station with the number of its frame, from 0.
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
    pub rows: Vec<FrameRow>,
    pub stations: Vec<StationRow>,
    /// Stations beyond those kept.
    pub stations_left_out: usize,
    /// The first [`MOST_PICTURES`] refused frames.
    pub refused: Vec<RefusedFrame>,
    /// The budget of the worst frame, of equally bad ones the first.
    pub budget: Option<FrameBudget>,
}

impl MeasuredFrames {
    /// Adds a frame; `k` is the coverage factor of its means, `frame` its picture, which is read
    /// where it was refused.
    pub(super) fn add(&mut self, measured: &Measurement, k: f64, frame: Option<&Frame>) {
        self.add_refused(measured, frame);
        self.add_budget(measured);
        let stations = measured.stations.as_deref().unwrap_or_default();
        let kept = stations.len().min(MOST_STATIONS.saturating_sub(self.stations.len()));
        let index = self.rows.len();
        self.stations.extend(stations[..kept].iter().map(|s| StationRow { frame: index, station: *s }));
        self.stations_left_out += stations.len() - kept;
        let largest = measured.diameter.as_ref();
        self.rows.push(FrameRow {
            frame: measured.frame.clone(),
            z_mm: measured.place.filter(|_| largest.is_some()).map(|place| place.z_mm),
            largest: largest.map(|d| Value { d_mm: d.diameter.d_mm, expanded_mm: d.expanded_u_mm }),
            k: largest.map(|d| d.coverage_factor),
            mean: measured.mean.map(|d| Value::of(d, k)),
            average: measured.average.map(|d| Value::of(d, k)),
            verdict: measured.judgement,
            judged: measured.judged,
            valid: measured.valid,
            columns: measured.columns,
            flags: measured.flags.clone(),
            refused: measured.refusal.as_ref().map(|refusal| refusal.reason),
            warnings: measured.warnings.iter().map(ToString::to_string).collect(),
        });
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

    /// Frames without a diameter.
    pub(super) fn refused_count(&self) -> usize {
        self.rows.iter().filter(|row| row.refused.is_some()).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::FrameMeta;
    use crate::measurement::Refusal;

    #[test]
    fn of_many_refused_frames_some_pictures_are_kept() {
        let frame = Frame::linear(vec![1.0; 600 * 800], 600, 800, None, FrameMeta::default());
        let refusal = Some(Refusal { reason: Reason::LowContrast, why: "dark".to_owned() });
        let measured = Measurement { frame: "a".to_owned(), refusal, ..Measurement::default() };
        let mut frames = MeasuredFrames::default();
        (0..25).for_each(|_| frames.add(&measured, 2.0, Some(&frame)));
        frames.add(&measured, 2.0, None);
        assert_eq!((frames.rows.len(), frames.refused_count()), (26, 26));
        assert_eq!(frames.refused.len(), MOST_PICTURES);
        assert!(frames.refused.iter().all(|f| f.png.as_ref().is_some_and(|png| png.len() > 8)));
    }
}
