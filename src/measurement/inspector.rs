//! Millimetres of the frames of a series: means and averages, stations, comparison with earlier
//! turns, judgement.

use super::error::MeasureError;
use super::judged::{Deciding, Judged, StationJudgement, StationResult, Verdict};
use super::reference_pin::PinCorrection;
use super::result::{LargestDiameter, Measurement};
use super::settings::MeasureSettings;
use super::settled_part::{SettledPart, widen, widened};
use super::stated::{correct_by_pin, drift_row, stated_budget};
use super::statistics::FrameMeans;
use super::turn_frames::{Asked, TurnFrames};
use super::turn_sizes::needs_envelope;
use super::warning::Warning;
use crate::conformity::{Judge, Judgement, MANY, SizeCriterion, Tolerance};
use crate::frame::FrameMeta;
use crate::gauge::budget::{Budget, Texts, WidthReading};
use crate::gauge::calibration::{Conditions, HeadGeometry};
use crate::gauge::diameter::reading_series::Average;
use crate::gauge::form::Cutoff;
use crate::gauge::plausibility::{Jump, PlausibilitySettings, TurnHistory};
use crate::gauge::{Calibration, ColumnDiameters, FieldMidline, FrameEdges};
use crate::profile::{Diameter, Reading, Reason};

/// Columns of a local size without stations: as many as in the median of the largest diameter.
const LOCAL_COLUMNS: f64 = 65.0;
/// Length along z of what is compared from turn to turn without stations, mm: some columns of any
/// lens.
const TURN_STRETCH_MM: f64 = 1.0;
/// Most jumps that a series lists beside those of its frames: half a megabyte.
const MOST_JUMPS: usize = 10_000;

/// About [`LOCAL_COLUMNS`], such that no remainder of a few columns is left at the end of a frame.
fn local_columns(columns: usize) -> f64 {
    let places = (columns as f64 / LOCAL_COLUMNS).round().max(1.0);
    (columns as f64 / places).ceil()
}

/// A value that must lie within the limits.
#[derive(Clone, Copy)]
struct Candidate {
    what: &'static str,
    z_mm: f64,
    reading: Reading,
    /// Effective degrees of freedom of its u.
    freedom: f64,
}

/// Frames of a part that turns.
pub(super) struct FollowedTurn {
    pub(super) frames: TurnFrames,
    history: TurnHistory,
    pub(super) jumps: Vec<Jump>,
    /// Jumps beyond those kept.
    pub(super) jumps_left_out: usize,
}

/// What the frames of a series amount to so far.
pub(super) struct SeriesSoFar {
    /// Mean diameters of its frames.
    pub(super) means: FrameMeans,
    /// The worst judgement.
    pub(super) worst: Judgement,
    /// Frames, refused ones with them.
    frames: usize,
}

/// What has changed in the head since it was calibrated, as far as something states it.
#[derive(Default)]
pub(super) struct HeadChange {
    /// Standard uncertainty by the drift since the last zero, mm, and what it is of.
    pub(super) drift: Option<(f64, String)>,
    /// What the reference pin of the frame makes of its diameters.
    pub(super) pin: Option<PinCorrection>,
}

/// Follows the frames of one series.
pub(super) struct Inspector {
    pub(super) settings: MeasureSettings,
    pub(super) calibration: Calibration,
    pub(super) conditions: Conditions,
    /// Where a machine carries the head, over z.
    pub(super) geometry: Option<HeadGeometry>,
    pub(super) judge: Option<(Judge, (f64, f64))>,
    average: Average,
    pub(super) so_far: SeriesSoFar,
    pub(super) turn: FollowedTurn,
    pub(super) settled: Option<SettledPart>,
    pub(super) change: HeadChange,
    buffers: Buffers,
}

/// Memory of a frame's results that the next frame's are written to.
#[derive(Default)]
struct Buffers {
    diameters: ColumnDiameters,
    budget: Budget,
    stations: Vec<StationResult>,
    candidates: Vec<Candidate>,
}

/// Sizes of a whole frame that are judged beside its places.
#[derive(Clone, Copy)]
struct FrameSizes {
    /// The mean diameter.
    mean: Reading,
    /// The largest diameter with its place, mm.
    largest: Option<(f64, LargestDiameter)>,
    /// Whether the largest diameter is the only size: of a part seen end-on, and of crests.
    alone: bool,
}

impl Inspector {
    /// Checks the settings; `calibration` is that of level shafts.
    ///
    /// # Errors
    /// Limits and probabilities out of range, settings that exclude each other.
    pub(super) fn new(
        settings: MeasureSettings,
        calibration: Calibration,
        conditions: Conditions,
    ) -> Result<Self, MeasureError> {
        let of_tolerance = |t: Tolerance| {
            Judge::new(t.limits(), settings.conformance_probability).map(|judge| (judge, t.limits_mm()))
        };
        let judge = settings.tolerance.map(of_tolerance).transpose()?;
        if let Some(t) = settings.tolerance.filter(|t| t.criterion.needs_turn() && !settings.turn) {
            return Err(MeasureError::NeedsTurn { criterion: t.criterion.as_str() });
        }
        if settings.averages() && settings.station_mm.is_some() {
            return Err(MeasureError::AverageOfStations);
        }
        Cutoff::upr(settings.cutoff_upr)?;
        let turn_limit_mm = 1e-3 * settings.turn_limit_um;
        let plausibility = PlausibilitySettings { turn_limit_mm, ..PlausibilitySettings::default() };
        plausibility.validate()?;
        Ok(Self {
            calibration,
            conditions,
            geometry: None,
            judge,
            average: Average::new(settings.average)?,
            so_far: SeriesSoFar { means: FrameMeans::default(), worst: Judgement::GO, frames: 0 },
            turn: FollowedTurn {
                frames: TurnFrames::default(),
                history: TurnHistory::new(&plausibility, settings.station_mm.unwrap_or(TURN_STRETCH_MM)),
                jumps: Vec::new(),
                jumps_left_out: 0,
            },
            settled: settings.settle_s.map(|s| SettledPart::new(s, settings.turn)),
            change: HeadChange::default(),
            buffers: Buffers::default(),
            settings,
        })
    }

    /// Takes where the machine carries the head in the next frame; its metadata at the place that
    /// it then shows, none where no machine is given.
    ///
    /// # Errors
    /// A frame outside the range in which the machine is known.
    pub(super) fn take_place(
        &mut self,
        name: &str,
        meta: &FrameMeta,
    ) -> Result<Option<FrameMeta>, MeasureError> {
        let Some(geometry) = &self.geometry else { return Ok(None) };
        let Some(place) = geometry.at(meta.z_mm) else {
            let ((from_mm, to_mm), z_mm) = (geometry.range_mm(), meta.z_mm);
            return Err(MeasureError::BeyondMachine { frame: name.to_owned(), z_mm, from_mm, to_mm });
        };
        self.conditions.machine = Some(place);
        Ok(Some(FrameMeta { z_mm: meta.z_mm + place.axial_mm, ..meta.clone() }))
    }

    /// Takes back the memory of a frame's results.
    pub(super) fn take_back(&mut self, last: &mut Measurement) {
        if let Some(stations) = last.stations.take() {
            self.buffers.stations = stations;
        }
        if let Some(budget) = last.budget.take() {
            self.buffers.budget = budget;
        }
    }

    /// A frame without edges.
    pub(super) fn add_refused(&mut self, out: &mut Measurement) {
        self.so_far.frames += 1;
        self.not_proven(out);
    }

    /// Adds the results of a frame to its measurement.
    ///
    /// # Errors
    /// A diameter or uncertainty that is no number: the frame then has none.
    pub(super) fn add(
        &mut self,
        meta: &FrameMeta,
        edges: &FrameEdges,
        out: &mut Measurement,
    ) -> Result<(), MeasureError> {
        let index = self.so_far.frames;
        self.so_far.frames += 1;
        out.take_place(meta, &self.calibration);
        let reading = self.add_largest(edges, out)?;
        let mut meta = meta.clone();
        if let Some(step) = self.settings.angle_step_deg {
            meta.angle_deg = step * index as f64;
        }
        self.warn_of_blur(edges, out);
        let mut diameters = std::mem::take(&mut self.buffers.diameters);
        self.take_diameters(edges, &mut diameters);
        if self.settings.turn {
            self.compare_with_turns(&meta, &mut diameters, out);
        }
        let mean = diameters.mean(0..diameters.columns.len());
        out.mean = mean.value();
        out.midline = FieldMidline::of(&diameters);
        out.mean.into_iter().for_each(|d| self.so_far.means.push(d));
        let averaged = self.average.push(mean);
        out.average = averaged.value().filter(|_| self.settings.averages());
        let settled = self.settled.as_mut().map(|part| part.push(&meta, out.mean));
        // 0 where nothing was asked, none where the diameter is not good yet
        let trend_mm = settled.map_or(Some(0.0), |s| s.u_trend_mm());
        out.settled = settled;
        self.add_stations(&meta, &diameters, trend_mm, out);
        if self.judges_frames() && trend_mm.is_none() {
            out.judgement = Verdict::NotProven;
        } else if self.judges_frames() {
            let largest = reading.map(|r| diameters.z_mm(&meta, 0) + r.column_px * diameters.pitch_mm);
            let alone = out.largest.is_some_and(|l| l.end_on || l.tangents);
            let sizes = FrameSizes { mean: averaged, largest: largest.zip(out.diameter), alone };
            let mut values = std::mem::take(&mut self.buffers.candidates);
            self.take_judged(&meta, &diameters, sizes, &mut values);
            if let Some(u_mm) = trend_mm.filter(|u| *u > 0.0) {
                values.iter_mut().for_each(|value| value.reading = widened(value.reading, u_mm));
            }
            self.judge_frame(&values, out);
            self.buffers.candidates = values;
        }
        if let Some(u_mm) = trend_mm.filter(|u| *u > 0.0) {
            widen(out, u_mm);
        }
        if self.settings.turn {
            let mut frames = std::mem::take(&mut self.turn.frames);
            frames.add(&meta, &diameters, &self.asked_of_turn()?);
            self.turn.frames = frames;
        }
        self.buffers.diameters = diameters;
        Ok(())
    }

    /// Diameters of the columns, corrected by the reference pin, with the drift since the last zero
    /// in them.
    fn take_diameters(&self, edges: &FrameEdges, diameters: &mut ColumnDiameters) {
        self.calibration.diameters_into(edges, &self.conditions, diameters);
        if let Some(pin) = &self.change.pin {
            pin.correct(diameters);
        }
        if let Some((u_mm, _)) = &self.change.drift {
            diameters.widen(*u_mm);
        }
    }

    /// What is asked of the frames of a revolution.
    ///
    /// # Errors
    /// A filter out of range.
    pub(super) fn asked_of_turn(&self) -> Result<Asked<'_>, MeasureError> {
        let Self { settings, calibration, .. } = self;
        let cutoff = Cutoff::upr(settings.cutoff_upr)?;
        let envelope = settings.tolerance.is_some_and(|tolerance| needs_envelope(&tolerance));
        Ok(Asked { station_mm: settings.station_mm, cutoff, envelope, calibration })
    }

    /// Adds the largest diameter and its budget.
    fn add_largest(
        &mut self,
        edges: &FrameEdges,
        out: &mut Measurement,
    ) -> Result<Option<WidthReading>, MeasureError> {
        let least = self.settings.least_stretch(Some(&self.calibration));
        let reading = match (&self.calibration.setup, &out.largest) {
            // Without a lens the widest place of the image is that of the part.
            (None, Some(largest)) => WidthReading::of_caliper(edges, largest),
            _ => WidthReading::of_largest(edges, &self.calibration, least),
        };
        let Some(reading) = reading else { return Ok(None) };
        let mut budget = std::mem::take(&mut self.buffers.budget);
        let texts = if self.settings.budget { Texts::Written } else { Texts::LeftOut };
        stated_budget(&reading, &self.calibration, &self.conditions, texts, &mut budget);
        if let Some(pin) = &self.change.pin {
            correct_by_pin(&mut budget, pin, texts);
        }
        if let Some((u_mm, since)) = &self.change.drift {
            budget.contributions.extend(drift_row(*u_mm, since, texts));
        }
        if !(budget.diameter_mm.is_finite() && budget.u_mm().is_finite()) {
            out.warnings.push(Warning::NoNumber);
            self.give_no_diameter(Reason::Implausible, edges, out);
            return Err(MeasureError::NoNumber { frame: out.frame.clone() });
        }
        out.diameter = Some(LargestDiameter::of(&budget, self.settings.coverage_factor));
        if self.settings.budget {
            out.budget = Some(budget);
        } else {
            self.buffers.budget = budget;
        }
        Ok(Some(reading))
    }

    /// Warns of a frame that is measured although its blur differs from the masters'.
    fn warn_of_blur(&self, edges: &FrameEdges, out: &mut Measurement) {
        let setup = self.calibration.setup.as_ref();
        if let Some(Err(error)) = setup.map(|b| b.check_focus(edges.figures.sigma_px, &self.conditions)) {
            out.warnings.push(Warning::Blur(error));
        }
    }

    /// Turns every column of a frame into a gap.
    fn give_no_diameter(&mut self, reason: Reason, edges: &FrameEdges, out: &mut Measurement) {
        if let Some(largest) = &mut out.largest {
            (largest.diameter_px, largest.u_px) = (f64::NAN, f64::NAN);
        }
        out.valid = 0;
        out.flags.clear();
        out.flags.add(reason, edges.columns());
        self.not_proven(out);
    }

    /// Whether the tolerance applies to sizes of single frames, not to those of the revolution.
    fn judges_frames(&self) -> bool {
        let two_point =
            |t: Tolerance| matches!(t.criterion, SizeCriterion::TwoPoint | SizeCriterion::Envelope);
        self.settings.tolerance.is_some_and(two_point)
    }

    /// A size that was not measured, or that may be another part's, is not proven good.
    pub(super) fn not_proven(&mut self, out: &mut Measurement) {
        if self.judge.is_some() {
            out.judgement = Verdict::NotProven;
            self.so_far.worst = worse(self.so_far.worst, Judgement::HI);
        }
    }

    /// Turns diameters that contradict earlier revolutions into gaps, counted in the frame's flags.
    fn compare_with_turns(
        &mut self,
        meta: &FrameMeta,
        diameters: &mut ColumnDiameters,
        out: &mut Measurement,
    ) {
        let valid = |d: &ColumnDiameters| d.columns.iter().filter(|c| c.reading.value().is_some()).count();
        let before = valid(diameters);
        let jumps = self.turn.history.check(meta, diameters);
        if jumps.is_empty() {
            return;
        }
        let refused = before - valid(diameters);
        out.flags.set(Reason::Implausible, refused);
        out.valid = out.valid.saturating_sub(refused);
        let room = MOST_JUMPS.saturating_sub(self.turn.jumps.len()).min(jumps.len());
        self.turn.jumps.extend(&jumps[..room]);
        self.turn.jumps_left_out += jumps.len() - room;
        out.jumps = jumps;
    }

    /// Adds the stations of a frame, each with its own judgement.
    fn add_stations(
        &mut self,
        meta: &FrameMeta,
        diameters: &ColumnDiameters,
        trend_mm: Option<f64>,
        out: &mut Measurement,
    ) {
        let Some(length_mm) = self.settings.station_mm else { return };
        let judge = self.judge.filter(|_| self.judges_frames() && trend_mm.is_some());
        let own_mm = trend_mm.unwrap_or(0.0);
        let judged = |reading: &Reading| {
            judge.map(|(judge, _)| StationJudgement {
                judgement: judge.judge_reading(reading, MANY).ok(),
                guard_mm: reading.value().and_then(|d| judge.guard_mm(&d, MANY)),
            })
        };
        let mut stations = std::mem::take(&mut self.buffers.stations);
        stations.clear();
        let record = diameters.record(meta, length_mm);
        let wide = |reading: Reading| if own_mm > 0.0 { widened(reading, own_mm) } else { reading };
        stations.extend(record.map(|(z_mm, reading)| StationResult {
            z_mm,
            reading: wide(reading),
            judged: judged(&wide(reading)),
        }));
        out.stations = Some(stations);
    }

    /// Takes all values of a frame that must lie within the limits. A disc's chords are no sizes;
    /// that of crests opposite roots is the distance of tangents.
    fn take_judged(
        &self,
        meta: &FrameMeta,
        diameters: &ColumnDiameters,
        sizes: FrameSizes,
        values: &mut Vec<Candidate>,
    ) {
        values.clear();
        let largest = sizes.largest.map(|(z_mm, d)| Candidate {
            what: "largest",
            z_mm,
            reading: Reading::Value(d.diameter),
            freedom: d.freedom,
        });
        values.extend(largest);
        if largest.is_some() && sizes.alone {
            return;
        }
        let (what, length) = match self.settings.station_mm {
            Some(length) => ("station", length),
            None => ("local", local_columns(diameters.columns.len()) * diameters.pitch_mm),
        };
        // Their u comes from the noise of very many pixels, and from the calibration.
        let of = |what, z_mm, reading| Candidate { what, z_mm, reading, freedom: MANY };
        values.extend(diameters.record(meta, length).map(|(z_mm, reading)| of(what, z_mm, reading)));
        let mean_word = if self.settings.averages() { "average" } else { "mean" };
        values.push(of(mean_word, meta.z_mm, sizes.mean));
    }

    /// Judges a frame by its worst value, of equal ones that closest to a limit.
    fn judge_frame(&mut self, values: &[Candidate], out: &mut Measurement) {
        let Some((judge, limits)) = self.judge else { return };
        let decisive = decisive(values, &judge, limits);
        let gap = values.iter().find_map(|value| match value.reading {
            Reading::Gap(reason) => Some((value, reason)),
            Reading::Value(_) => None,
        });
        let good = decisive.is_none_or(|(judgement, ..)| judgement == Judgement::GO);
        if let (true, Some((Candidate { what, z_mm, .. }, reason))) = (good, gap) {
            out.judged = Some(Judged { what, z_mm: Some(*z_mm), by: Deciding::Gap(reason) });
            return self.not_proven(out);
        }
        let Some((judgement, value, diameter)) = decisive else { return self.not_proven(out) };
        self.so_far.worst = worse(self.so_far.worst, judgement);
        out.acceptance_zone = judge.check_uncertainty(diameter.u_mm(), value.freedom).err();
        out.judgement = Verdict::Is(judgement);
        let guard_mm = judge.guard_mm(&diameter, value.freedom);
        let by = Deciding::Value { diameter, freedom: value.freedom, guard_mm };
        out.judged = Some(Judged { what: value.what, z_mm: Some(value.z_mm), by });
    }
}

/// The worst value, of equal ones that closest to a limit.
fn decisive(
    values: &[Candidate],
    judge: &Judge,
    (lower, upper): (f64, f64),
) -> Option<(Judgement, Candidate, Diameter)> {
    let margin = |d: &Diameter| (d.d_mm - lower).min(upper - d.d_mm);
    let mut decisive: Option<(Judgement, Candidate, Diameter)> = None;
    for value in values {
        let Some(d) = value.reading.value() else { continue };
        let judgement = judge.judge(&d, value.freedom);
        let worst = decisive.is_none_or(|(known, _, by)| {
            (judgement.severity(), margin(&by)) > (known.severity(), margin(&d))
        });
        if worst {
            decisive = Some((judgement, *value, d));
        }
    }
    decisive
}

/// The judgement that is farther from good.
pub(super) fn worse(a: Judgement, b: Judgement) -> Judgement {
    if b.severity() > a.severity() { b } else { a }
}
