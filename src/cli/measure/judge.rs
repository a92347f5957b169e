//! Results of `measure` beyond edges: stations, judgement, averages, statistics.

use serde_json::{Map, Value, json};

use super::choice::add_warning;
use super::judge_args::JudgeArgs;
use super::size::{common_mm, corrected_by_axis, envelope, judge_turn, part_form};
use super::statistics::FrameMeans;
use super::turn::{axis_json, scatter_word, turn_json};
use crate::cli::failure::Failure;
use crate::conformity::{Judge, Judgement, MANY, SizeCriterion, Tolerance};
use crate::frame::FrameMeta;
use crate::gauge::budget::{Budget, Contribution, Shape, Share, WidthReading};
use crate::gauge::calibration::Conditions;
use crate::gauge::diameter::reading_series::{Average, Capability, RunningStatistics};
use crate::gauge::form::Cutoff;
use crate::gauge::plausibility::{Jump, PlausibilitySettings, TurnHistory};
use crate::gauge::{Calibration, ColumnDiameters, FrameEdges, LargestCaliper, largest_caliper_over};
use crate::profile::{Diameter, Reading, Reason};

/// Columns of a local size without stations: as many as in the median of the largest diameter.
const LOCAL_COLUMNS: f64 = 65.0;
/// Length along z of what is compared from turn to turn without stations, mm.
const TURN_STRETCH_MM: f64 = 1.0;

/// Probability that the scatter of identical parts is taken for scatter of the process.
const SCATTER_RISK: f64 = 0.05;

/// About [`LOCAL_COLUMNS`], such that no remainder of a few columns is left at the end of a frame.
fn local_columns(columns: usize) -> f64 {
    let places = (columns as f64 / LOCAL_COLUMNS).round().max(1.0);
    (columns as f64 / places).ceil()
}

/// The budget of a reading, with a row for scale and edge offset without an uncertainty.
pub fn stated_budget(reading: &WidthReading, calibration: &Calibration, conditions: &Conditions) -> Budget {
    let mut budget = reading.budget(calibration, conditions);
    if is_uncalibrated(calibration) {
        // Without masters the part's edges and temperature have no reference: U is the image's
        // alone.
        let temperature = (conditions.limit_temperature_k == 0.0).then_some("temperature of the part");
        budget.contributions.extend(temperature.into_iter().chain(["scale and edge offset"]).map(|source| {
            Contribution {
                source: source.to_owned(),
                input: "not stated".to_owned(),
                shape: Shape::Normal,
                share: Share::Common,
                freedom: None,
                u_mm: 0.0,
            }
        }));
    }
    budget
}

/// Whether the calibration is a scale only: no masters, no uncertainty.
fn is_uncalibrated(calibration: &Calibration) -> bool {
    calibration.setup.is_none() && calibration.masters.is_empty() && calibration.covariance == [0.0; 3]
}

/// A frame's largest diameter.
#[derive(Clone, Copy)]
struct Largest {
    /// Whether it is the part's only size: a disc's chords and roots beneath crests are none.
    alone: bool,
    z_mm: f64,
    diameter: Diameter,
    freedom: f64,
}

/// A value that must lie within the limits.
#[derive(Clone, Copy)]
struct Judged {
    what: &'static str,
    z_mm: f64,
    reading: Reading,
    /// Effective degrees of freedom of its u.
    freedom: f64,
}

/// Frames of a part that turns.
struct FollowedTurn {
    frames: Vec<(FrameMeta, ColumnDiameters)>,
    history: TurnHistory,
    jumps: Vec<Jump>,
}

/// Follows the frames of one command.
pub struct InspectionReport<'a> {
    args: &'a JudgeArgs,
    calibration: &'a Calibration,
    conditions: Conditions,
    judge: Option<(Judge, (f64, f64))>,
    average: Average,
    means: FrameMeans,
    /// Random variances of the values in the statistics, mm².
    noise: RunningStatistics,
    worst: Judgement,
    turn: FollowedTurn,
    frames: usize,
    no_zone_told: bool,
}

impl<'a> InspectionReport<'a> {
    /// Checks the arguments.
    ///
    /// # Errors
    /// Exit 2 for limits and probabilities out of range.
    pub fn new(
        args: &'a JudgeArgs,
        calibration: &'a Calibration,
        conditions: Conditions,
    ) -> Result<Self, Failure> {
        let judge = args
            .tolerance
            .map(|t| Judge::new(t.limits(), args.conformance_probability).map(|judge| (judge, t.limits_mm())))
            .transpose()
            .map_err(Failure::refuse)?;
        if let Some(t) = args.tolerance.filter(|t| t.criterion.needs_turn() && !args.turn) {
            return Err(Failure::refuse(format!(
                "{} is judged over the length and all around: give the frames of a turn and --turn",
                t.criterion.as_str()
            )));
        }
        if judge.is_some() && is_uncalibrated(calibration) {
            tracing::warn!(
                "scale and edge offset are not calibrated: U does not hold their uncertainty, and what is judged with it is \
                 only as good as they are; --calibration states both"
            );
        }
        if args.average.is_some() && args.station_mm.is_some() {
            return Err(Failure::refuse(
                "--average averages the mean of whole frames and --station-mm gives parts of each: one of them at a time",
            ));
        }
        Cutoff::upr(args.cutoff_upr).map_err(Failure::refuse)?;
        let plausibility = PlausibilitySettings {
            turn_limit_mm: 1e-3 * args.turn_limit_um,
            ..PlausibilitySettings::default()
        };
        plausibility.validate().map_err(Failure::refuse)?;
        Ok(Self {
            args,
            calibration,
            conditions,
            judge,
            average: Average::new(args.average.unwrap_or_default()).map_err(Failure::refuse)?,
            means: FrameMeans::default(),
            noise: RunningStatistics::default(),
            worst: Judgement::GO,
            turn: FollowedTurn {
                frames: Vec::new(),
                history: TurnHistory::new(&plausibility, args.station_mm.unwrap_or(TURN_STRETCH_MM)),
                jumps: Vec::new(),
            },
            frames: 0,
            no_zone_told: false,
        })
    }

    /// Adds the results of a frame to its JSON object.
    pub fn add(&mut self, meta: &FrameMeta, edges: Option<&FrameEdges>, out: &mut Map<String, Value>) {
        let index = self.frames;
        self.frames += 1;
        let Some(edges) = edges else {
            self.not_proven(out);
            return;
        };
        let mut diameters = self.calibration.diameters_under(edges, &self.conditions);
        let mut meta = meta.clone();
        if let Some(step) = self.args.angle_step {
            meta.angle_deg = step * index as f64;
        }
        let least = self.args.least_stretch(Some(self.calibration));
        let reading = WidthReading::of_largest(edges, self.calibration, least);
        let budget = reading.as_ref().map(|r| stated_budget(r, self.calibration, &self.conditions));
        if budget.as_ref().is_some_and(|b| !(b.diameter_mm.is_finite() && b.u_mm().is_finite())) {
            let why = "its diameter or uncertainty is no number: it has no diameter";
            tracing::warn!("frame {}: {why}", meta.frame_id);
            add_warning(out, why);
            self.give_no_diameter(Reason::Implausible, edges, out);
            return;
        }
        self.warn_of_blur(&meta, edges, out);
        if self.args.turn {
            self.compare_with_turns(&meta, &mut diameters, out);
        }
        let mean = diameters.mean(0..diameters.columns.len());
        if let Some(d) = mean.value() {
            put(out, "mean_diameter_mm", d.d_mm);
            put(out, "u_mean_diameter_mm", d.u_mm());
            // For one version also under its old name, which the u of the frames' mean has too.
            put(out, "u_mean_mm", d.u_mm());
            self.means.push(d);
            self.noise.push(d.u_random_mm.powi(2));
        }
        if let Some(budget) = &budget {
            self.add_budget(budget, out);
        }
        let averaged = self.average.push(mean);
        if let (Some(d), true) = (averaged.value(), self.args.average.is_some()) {
            put(out, "average_mm", d.d_mm);
            put(out, "u_average_mm", d.u_mm());
        }
        let largest = reading.zip(budget).map(|(reading, budget)| Largest {
            alone: largest_caliper_over(edges, least).is_some_and(|l: LargestCaliper| l.end_on || l.tangents),
            z_mm: diameters.z_mm(&meta, 0) + reading.column_px * diameters.pitch_mm,
            diameter: Diameter {
                d_mm: budget.diameter_mm,
                u_random_mm: budget.u_random_mm(),
                u_common_mm: budget.u_common_mm(),
            },
            freedom: budget.effective_freedom(),
        });
        self.add_stations(&meta, &diameters, out);
        let values = self.to_be_judged(&meta, &diameters, averaged, largest);
        self.judge_frame(&values, out);
        if self.args.turn {
            self.turn.frames.push((meta, diameters));
        }
    }

    /// Warns of a frame that is measured although its blur differs from the masters'.
    fn warn_of_blur(&self, meta: &FrameMeta, edges: &FrameEdges, out: &mut Map<String, Value>) {
        let setup = self.calibration.setup.as_ref();
        if let Some(Err(error)) = setup.map(|b| b.check_focus(edges.figures.sigma_px, &self.conditions)) {
            tracing::warn!("frame {}: {error}", meta.frame_id);
            add_warning(out, &error.to_string());
        }
    }

    /// Turns every column of a frame into a gap.
    fn give_no_diameter(&mut self, reason: Reason, edges: &FrameEdges, out: &mut Map<String, Value>) {
        for key in ["max_diameter_px", "u_max_px", "max_diameter_mm", "u_max_mm"] {
            out.insert(key.to_owned(), Value::Null);
        }
        out.insert("valid".to_owned(), json!(0));
        out.insert("flags".to_owned(), json!({ reason.as_str(): edges.columns() }));
        self.not_proven(out);
    }

    /// Whether the tolerance applies to sizes of single frames, not to those of the revolution.
    fn judges_frames(&self) -> bool {
        let two_point =
            |t: Tolerance| matches!(t.criterion, SizeCriterion::TwoPoint | SizeCriterion::Envelope);
        self.args.tolerance.is_some_and(two_point)
    }

    /// A size that was not measured, or that may be another part's, is not proven good.
    pub fn not_proven(&mut self, out: &mut Map<String, Value>) {
        if self.judge.is_some() {
            out.insert("judgement".to_owned(), Value::Null);
            self.worst = worse(self.worst, Judgement::HI);
        }
    }

    /// Turns diameters that contradict earlier revolutions into gaps, counted in the frame's flags.
    fn compare_with_turns(
        &mut self,
        meta: &FrameMeta,
        diameters: &mut ColumnDiameters,
        out: &mut Map<String, Value>,
    ) {
        let valid = |d: &ColumnDiameters| d.columns.iter().filter(|c| c.reading.value().is_some()).count();
        let before = valid(diameters);
        let jumps = self.turn.history.check(meta, diameters);
        if jumps.is_empty() {
            return;
        }
        jumps.iter().for_each(|j| tracing::warn!("frame {}: {j}", meta.frame_id));
        let refused = before - valid(diameters);
        if let Some(flags) = out.get_mut("flags").and_then(Value::as_object_mut) {
            flags.insert(Reason::Implausible.as_str().to_owned(), json!(refused));
        }
        if let Some(count) = out.get("valid").and_then(Value::as_u64) {
            out.insert("valid".to_owned(), json!(count.saturating_sub(refused as u64)));
        }
        self.turn.jumps.extend(jumps);
    }

    fn add_budget(&self, budget: &Budget, out: &mut Map<String, Value>) {
        let k = budget.factor_or(self.args.coverage_factor);
        // `u_random_mm` and `u_common_mm`, elsewhere those of `d_mm`, were the largest diameter's.
        for (name, old, u) in [
            ("u_max_random_mm", "u_random_mm", budget.u_random_mm()),
            ("u_max_common_mm", "u_common_mm", budget.u_common_mm()),
        ] {
            put(out, name, u);
            put(out, old, u);
        }
        put(out, "expanded_u_max_mm", k * budget.u_mm());
        put(out, "coverage_factor", k);
        if self.args.budget {
            out.insert("budget".to_owned(), json!(budget.contributions));
            out.insert("effective_freedom".to_owned(), json!(finite(budget.effective_freedom())));
        }
    }

    /// The stations of a frame, each with its own judgement.
    fn add_stations(&self, meta: &FrameMeta, diameters: &ColumnDiameters, out: &mut Map<String, Value>) {
        let Some(length) = self.args.station_mm else { return };
        let row = |(z_mm, reading): &(f64, Reading)| {
            let mut row = station_row(*z_mm, reading);
            if let (Some((judge, _)), true) = (&self.judge, self.judges_frames()) {
                row["judgement"] = json!(judge.judge_reading(reading, MANY).ok());
                row["guard_mm"] = json!(reading.value().and_then(|d| judge.guard_mm(&d, MANY)));
            }
            row
        };
        let rows: Vec<Value> = diameters.record(meta, length).iter().map(row).collect();
        out.insert("stations".to_owned(), rows.into());
    }

    /// All values of a frame that must lie within the limits. A disc's chords are no sizes; that of
    /// crests opposite roots is the distance of tangents.
    fn to_be_judged(
        &self,
        meta: &FrameMeta,
        diameters: &ColumnDiameters,
        mean: Reading,
        largest: Option<Largest>,
    ) -> Vec<Judged> {
        let largest_value = largest.map(|l| Judged {
            what: "largest",
            z_mm: l.z_mm,
            reading: Reading::Value(l.diameter),
            freedom: l.freedom,
        });
        if largest.is_some_and(|l| l.alone) {
            return Vec::from_iter(largest_value);
        }
        let (what, length) = match self.args.station_mm {
            Some(length) => ("station", length),
            None => ("local", local_columns(diameters.columns.len()) * diameters.pitch_mm),
        };
        // Their u comes from the noise of very many pixels, and from the calibration.
        let of = |what, z_mm, reading| Judged { what, z_mm, reading, freedom: MANY };
        let places =
            diameters.record(meta, length).into_iter().map(|(z_mm, reading)| of(what, z_mm, reading));
        let mean_word = if self.args.average.is_some() { "average" } else { "mean" };
        largest_value.into_iter().chain(places).chain([of(mean_word, meta.z_mm, mean)]).collect()
    }

    /// Judges a frame by its worst value, of equal ones that closest to a limit, and reports it.
    fn judge_frame(&mut self, values: &[Judged], out: &mut Map<String, Value>) {
        if !self.judges_frames() {
            return;
        }
        let Some((judge, (lower, upper))) = self.judge else { return };
        let margin = |d: &Diameter| (d.d_mm - lower).min(upper - d.d_mm);
        let mut decisive: Option<(Judgement, Judged, Diameter)> = None;
        for value in values {
            let Some(d) = value.reading.value() else { continue };
            let judgement = judge.judge(&d, value.freedom);
            let worst = decisive
                .is_none_or(|(known, _, by)| (rank(judgement), margin(&by)) > (rank(known), margin(&d)));
            if worst {
                decisive = Some((judgement, *value, d));
            }
        }
        let gap = values.iter().find_map(|value| match value.reading {
            Reading::Gap(reason) => Some((value, reason)),
            Reading::Value(_) => None,
        });
        let good = decisive.is_none_or(|(judgement, ..)| judgement == Judgement::GO);
        if let (true, Some((Judged { what, z_mm, .. }, reason))) = (good, gap) {
            out.insert("judged".to_owned(), json!({ "what": what, "z_mm": z_mm, "flag": reason.as_str() }));
            return self.not_proven(out);
        }
        let Some((judgement, value, d)) = decisive else { return self.not_proven(out) };
        self.worst = worse(self.worst, judgement);
        if let Err(error) = judge.check_uncertainty(d.u_mm(), value.freedom) {
            if !self.no_zone_told {
                tracing::warn!("{error}");
            }
            self.no_zone_told = true;
            out.insert("acceptance_zone".to_owned(), json!(error.to_string()));
        }
        out.insert("judgement".to_owned(), json!(judgement));
        let judged = json!({
            "what": value.what, "z_mm": value.z_mm, "d_mm": d.d_mm, "u_mm": d.u_mm(),
            "effective_freedom": finite(value.freedom), "guard_mm": judge.guard_mm(&d, value.freedom),
        });
        out.insert("judged".to_owned(), judged);
    }

    /// Whether every value is proven good; true where nothing is judged.
    pub fn all_good(&self) -> bool {
        self.worst == Judgement::GO
    }

    /// Adds the results over all frames to the document.
    ///
    /// # Errors
    /// Exit 3 for frames that do not form a turn.
    pub fn finish(&mut self, out: &mut Map<String, Value>) -> Result<(), Failure> {
        out.extend(self.statistics_json().map(|statistics| ("statistics".to_owned(), statistics)));
        let mut words = Vec::new();
        // Over a revolution the means differ by the form error of the part.
        words.extend(if self.args.turn { None } else { self.means.word() });
        if self.args.turn {
            let axis = corrected_by_axis(&mut self.turn.frames, self.args.station_mm, self.calibration);
            let form = part_form(&self.turn.frames, self.args.station_mm, self.args.cutoff_upr)?;
            words.extend(scatter_word(&form));
            let length = self.args.station_mm.unwrap_or(f64::INFINITY);
            let mut turn = turn_json(&form, |z_mm| common_mm(&self.turn.frames, z_mm, length));
            turn["implausible"] = json!(self.turn.jumps);
            turn["axis"] = axis_json(&axis);
            if let (Some((judge, _)), Some(tolerance)) = (&self.judge, &self.args.tolerance) {
                let envelope = envelope(&self.turn.frames, self.args.cutoff_upr);
                let common = |z_mm: f64| common_mm(&self.turn.frames, z_mm, length);
                if let Some(judged) = judge_turn(tolerance, judge.rule(), &form, &envelope, &common) {
                    self.worst = worse(self.worst, judged.judgement);
                    turn["judged"] = judged.json;
                }
            }
            out.insert("turn".to_owned(), turn);
        }
        if !words.is_empty() {
            words.iter().for_each(|word| tracing::warn!("{word}"));
            out.insert("warnings".to_owned(), json!(words));
        }
        Ok(())
    }

    fn statistics_json(&self) -> Option<Value> {
        let mut all = self.means.to_json()?;
        if let Some((_, (lower, upper))) = self.judge {
            let (cp, cpk, none) = match self.capability(lower, upper) {
                Ok((cp, cpk)) => (json!(cp), json!(cpk), Value::Null),
                Err(why) => (Value::Null, Value::Null, json!(why)),
            };
            (all["cp"], all["cpk"], all["capability_none"]) = (cp, cpk, none);
        }
        Some(all)
    }

    /// Cp and Cpk of the batch with intervals of 95 %.
    ///
    /// # Errors
    /// Why there are none: a single part has no capability, nor has scatter of the gauge alone.
    fn capability(&self, lower: f64, upper: f64) -> Result<(Capability, Capability), String> {
        if !self.args.parts {
            return Err("one part has none; --parts takes every frame as another part".to_owned());
        }
        let s = self.means.running();
        s.exceeds_noise(self.noise.mean(), SCATTER_RISK).map_err(|e| e.to_string())?;
        let both = s.cp(lower, upper, 0.95).and_then(|cp| Ok((cp, s.cpk(lower, upper, 0.95)?)));
        both.map_err(|e| e.to_string())
    }
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

fn put(out: &mut Map<String, Value>, key: &str, value: f64) {
    out.insert(key.to_owned(), json!(value));
}

fn station_row(z_mm: f64, reading: &Reading) -> Value {
    match reading {
        Reading::Value(Diameter { d_mm, u_random_mm, u_common_mm }) => {
            json!({ "z_mm": z_mm, "d_mm": d_mm, "u_random_mm": u_random_mm, "u_common_mm": u_common_mm })
        }
        Reading::Gap(reason) => json!({ "z_mm": z_mm, "flag": reason.as_str() }),
    }
}

/// The judgement that is farther from good.
fn worse(a: Judgement, b: Judgement) -> Judgement {
    if rank(b) > rank(a) { b } else { a }
}

fn rank(judgement: Judgement) -> u8 {
    match judgement {
        Judgement::GO => 0,
        Judgement::LO | Judgement::HI => 1,
        Judgement::LL | Judgement::HH => 2,
    }
}
