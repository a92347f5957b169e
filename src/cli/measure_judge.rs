//! What `measure` says beyond edges: stations, judgement, averages, statistics.

use serde_json::{Map, Value, json};

use super::Failure;
use super::measure_turn::turn_json;
use crate::frame::FrameMeta;
use crate::gauge::bench::Conditions;
use crate::gauge::budget::{Budget, Contribution, Shape, Share, WidthReading};
use crate::gauge::form::Cutoff;
use crate::gauge::judgement::{Judge, Judgement, Limits};
use crate::gauge::plausibility::{Jump, PlausibilitySettings, TurnHistory};
use crate::gauge::statistics::{Average, Averaging, RunningStatistics};
use crate::gauge::tolerance::parse_tolerance;
use crate::gauge::turn_form::{PartForm, TurnAverager};
use crate::gauge::{Calibration, ColumnDiameters, FrameEdges, largest_caliper};
use crate::profile::{Diameter, Reading, Reason};

/// Columns of a local size that is judged where no stations are given: as many as the largest diameter is the median of.
const LOCAL_COLUMNS: f64 = 65.0;
/// Stretches along z that are compared from turn to turn where no stations are given, mm.
const TURN_STRETCH_MM: f64 = 1.0;

/// What to say of diameters.
#[derive(Debug, clap::Args)]
pub struct JudgeArgs {
    /// Tolerance of the part: "25 h6", "25 0/-0.013" or "24.987..25"; exit code 1 unless every value is proven good: each frame's
    /// largest diameter, its local sizes (means over about 65 columns, or over the stations of --station-mm) and its mean.
    #[arg(long, value_name = "T", value_parser = parse_tolerance)]
    tolerance: Option<Limits>,
    /// Probability of conformance behind GO (ISO 14253-1); 0.5 leaves the guard bands out.
    #[arg(long, value_name = "P", default_value_t = 0.95)]
    conformance_probability: f64,
    /// Length of the stations that are given and judged, mm; without it 65 columns, as the largest diameter is found.
    #[arg(long, value_name = "MM", value_parser = length)]
    station_mm: Option<f64>,
    /// Averages successive frames: moving:N, median:N or recursive:W.
    #[arg(long, value_name = "HOW", value_parser = averaging)]
    average: Option<Averaging>,
    /// Coverage factor k of the expanded uncertainties; without it that of 95.45 % at the effective degrees of freedom: 2 where
    /// there are many.
    #[arg(long, value_name = "K", value_parser = length)]
    coverage_factor: Option<f64>,
    /// Uncertainty budget of every frame's largest diameter.
    #[arg(long)]
    budget: bool,
    /// Takes the frames as one turn (angles from frames.csv) and adds sizes, roundness, run-out and harmonics.
    #[arg(long)]
    turn: bool,
    /// Spindle angles of the frames of a turn in their order, degrees from one to the next.
    #[arg(long, value_name = "DEG", value_parser = length, requires = "turn")]
    angle_step: Option<f64>,
    /// Largest change of a diameter from one turn to the next that is believed, µm; more (and more than noise explains) is a gap
    /// with the flag `implausible`.
    #[arg(long, value_name = "UM", default_value_t = 5.0, value_parser = length, requires = "turn")]
    turn_limit_um: f64,
    /// Gives diameters of frames, too, that are blurred otherwise than the masters were (out of focus, moving), with a warning.
    #[arg(long)]
    accept_blur: bool,
    /// Gaussian filter of roundness, undulations per revolution (15, 50, 150).
    #[arg(long, value_name = "UPR", default_value_t = 50.0, value_parser = length)]
    cutoff_upr: f64,
}

fn length(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("a number above 0 is needed".to_owned()),
    }
}

fn averaging(text: &str) -> Result<Averaging, String> {
    let right = || "right would be moving:8, median:5 or recursive:0.2".to_owned();
    let (how, number) = text.split_once(':').ok_or_else(right)?;
    let averaging = match how {
        "moving" => Averaging::Moving { readings: number.parse().map_err(|_| right())? },
        "median" => Averaging::Median { readings: number.parse().map_err(|_| right())? },
        "recursive" => Averaging::Recursive { weight: number.parse().map_err(|_| right())? },
        _ => return Err(right()),
    };
    Average::new(averaging).map(|_| averaging).map_err(|e| e.to_string())
}

impl JudgeArgs {
    /// Whether anything here needs millimetres.
    pub fn needs_scale(&self) -> Option<&'static str> {
        [
            (self.tolerance.is_some(), "--tolerance"),
            (self.station_mm.is_some(), "--station-mm"),
            (self.average.is_some(), "--average"),
            (self.budget, "--budget"),
            (self.turn, "--turn"),
        ]
        .into_iter()
        .find_map(|(given, name)| given.then_some(name))
    }

    /// Whether budgets were asked for.
    pub fn budget(&self) -> bool {
        self.budget
    }

    /// Whether blurred frames give diameters.
    pub fn accepts_blur(&self) -> bool {
        self.accept_blur
    }

    /// k, where it is given.
    pub fn coverage_factor(&self) -> Option<f64> {
        self.coverage_factor
    }
}

/// About [`LOCAL_COLUMNS`], so that no rest of a few columns stays at the end of a frame.
fn local_columns(columns: usize) -> f64 {
    let places = (columns as f64 / LOCAL_COLUMNS).round().max(1.0);
    (columns as f64 / places).ceil()
}

/// The budget of a reading; where scale and edge offset were given without an uncertainty, a row says so.
pub fn stated_budget(reading: &WidthReading, calibration: &Calibration, conditions: &Conditions) -> Budget {
    let mut budget = reading.budget(calibration, conditions);
    if is_uncalibrated(calibration) {
        // Without masters there is nothing that the part's edges or temperature could differ from: U is the image's alone.
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

/// Whether all there is is a scale: no masters, no uncertainty.
fn is_uncalibrated(calibration: &Calibration) -> bool {
    calibration.bench.is_none() && calibration.masters.is_empty() && calibration.covariance == [0.0; 3]
}

/// A frame's largest diameter.
#[derive(Clone, Copy)]
struct Largest {
    end_on: bool,
    z_mm: f64,
    diameter: Diameter,
}

/// Follows the frames of one command.
pub struct Follower<'a> {
    args: &'a JudgeArgs,
    calibration: &'a Calibration,
    conditions: Conditions,
    judge: Option<(Judge, (f64, f64))>,
    average: Average,
    statistics: RunningStatistics,
    worst: Judgement,
    turn: Vec<(FrameMeta, ColumnDiameters)>,
    history: TurnHistory,
    jumps: Vec<Jump>,
    frames: usize,
    no_zone_told: bool,
}

impl<'a> Follower<'a> {
    /// Checks the arguments.
    ///
    /// # Errors
    /// Exit 2 for limits and probabilities that judge nothing.
    pub fn new(
        args: &'a JudgeArgs,
        calibration: &'a Calibration,
        conditions: Conditions,
    ) -> Result<Self, Failure> {
        let judge = args
            .tolerance
            .map(|limits| {
                let ends = match limits {
                    Limits::Tolerance { lower_mm, upper_mm } => (lower_mm, upper_mm),
                    Limits::Four { ll_mm, hh_mm, .. } => (ll_mm, hh_mm),
                };
                Judge::new(limits, args.conformance_probability).map(|j| (j, ends))
            })
            .transpose()
            .map_err(Failure::refuse)?;
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
            statistics: RunningStatistics::default(),
            worst: Judgement::GO,
            turn: Vec::new(),
            history: TurnHistory::new(&plausibility, args.station_mm.unwrap_or(TURN_STRETCH_MM)),
            jumps: Vec::new(),
            frames: 0,
            no_zone_told: false,
        })
    }

    /// What a frame adds to its JSON object.
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
        let reading = WidthReading::of_largest(edges, self.calibration);
        let budget = reading.as_ref().map(|r| stated_budget(r, self.calibration, &self.conditions));
        if budget.as_ref().is_some_and(|b| !(b.diameter_mm.is_finite() && b.u_mm().is_finite())) {
            let why = "its diameter or uncertainty is no number: it has no diameter";
            tracing::warn!("frame {}: {why}", meta.frame_id);
            out.insert("warnings".to_owned(), json!([why]));
            self.give_no_diameter(Reason::Implausible, edges, out);
            return;
        }
        self.warn_of_blur(&meta, edges, out);
        if self.args.turn {
            self.compare_with_turns(&meta, &mut diameters, out);
        }
        let mean = diameters.mean(0..diameters.readings.len());
        if let Some(d) = mean.value() {
            put(out, "mean_diameter_mm", d.d_mm);
            put(out, "u_mean_mm", d.u_mm());
            self.statistics.push(d.d_mm);
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
            end_on: largest_caliper(edges).is_some_and(|largest| largest.end_on),
            z_mm: diameters.z_mm(&meta, 0) + reading.column_px * diameters.pitch_mm,
            diameter: Diameter {
                d_mm: budget.diameter_mm,
                u_random_mm: budget.u_random_mm(),
                u_common_mm: budget.u_common_mm(),
            },
        });
        self.add_stations(&meta, &diameters, out);
        let values = self.to_be_judged(&meta, &diameters, averaged, largest);
        self.judge_frame(&values, out);
        if self.args.turn {
            self.turn.push((meta, diameters));
        }
    }

    /// A frame that is blurred otherwise than the masters were and is measured all the same carries a warning.
    fn warn_of_blur(&self, meta: &FrameMeta, edges: &FrameEdges, out: &mut Map<String, Value>) {
        let bench = self.calibration.bench.as_ref();
        if let Some(Err(error)) = bench.map(|b| b.check_focus(edges.figures.sigma_px, &self.conditions)) {
            tracing::warn!("frame {}: {error}", meta.frame_id);
            out.insert("warnings".to_owned(), json!([error.to_string()]));
        }
    }

    /// Makes a gap of every column of a frame.
    fn give_no_diameter(&mut self, reason: Reason, edges: &FrameEdges, out: &mut Map<String, Value>) {
        for key in ["max_diameter_px", "u_max_px", "max_diameter_mm", "u_max_mm"] {
            out.insert(key.to_owned(), Value::Null);
        }
        out.insert("valid".to_owned(), json!(0));
        out.insert("flags".to_owned(), json!({ reason.as_str(): edges.columns() }));
        self.not_proven(out);
    }

    /// What was not measured is not proven good.
    fn not_proven(&mut self, out: &mut Map<String, Value>) {
        if self.judge.is_some() {
            out.insert("judgement".to_owned(), Value::Null);
            self.worst = worse(self.worst, Judgement::HI);
        }
    }

    /// Makes gaps of what contradicts earlier turns, and counts them among the frame's flags.
    fn compare_with_turns(
        &mut self,
        meta: &FrameMeta,
        diameters: &mut ColumnDiameters,
        out: &mut Map<String, Value>,
    ) {
        let valid = |d: &ColumnDiameters| d.readings.iter().filter(|r| r.value().is_some()).count();
        let before = valid(diameters);
        let jumps = self.history.check(meta, diameters);
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
        self.jumps.extend(jumps);
    }

    fn add_budget(&self, budget: &Budget, out: &mut Map<String, Value>) {
        let k = budget.factor_or(self.args.coverage_factor);
        put(out, "u_random_mm", budget.u_random_mm());
        put(out, "u_common_mm", budget.u_common_mm());
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
            if let Some((judge, _)) = &self.judge {
                row["judgement"] = json!(judge.judge_reading(reading).ok());
                row["guard_mm"] = json!(reading.value().map(|d| judge.guard_mm(&d)));
            }
            row
        };
        let rows: Vec<Value> = diameters.record(meta, length).iter().map(row).collect();
        out.insert("stations".to_owned(), rows.into());
    }

    /// All of a frame that must lie within the limits. A disc seen end-on has one size, its chords are none.
    fn to_be_judged(
        &self,
        meta: &FrameMeta,
        diameters: &ColumnDiameters,
        mean: Reading,
        largest: Option<Largest>,
    ) -> Vec<(&'static str, f64, Reading)> {
        let largest_value = largest.map(|l| ("largest", l.z_mm, Reading::Value(l.diameter)));
        if largest.is_some_and(|l| l.end_on) {
            return Vec::from_iter(largest_value);
        }
        let (word, length) = match self.args.station_mm {
            Some(length) => ("station", length),
            None => ("local", local_columns(diameters.readings.len()) * diameters.pitch_mm),
        };
        let places = diameters.record(meta, length).into_iter().map(|(z_mm, reading)| (word, z_mm, reading));
        let mean_word = if self.args.average.is_some() { "average" } else { "mean" };
        largest_value.into_iter().chain(places).chain([(mean_word, meta.z_mm, mean)]).collect()
    }

    /// Judges a frame by the worst of its values (of equal ones by that closest to a limit) and says which it was.
    fn judge_frame(&mut self, values: &[(&'static str, f64, Reading)], out: &mut Map<String, Value>) {
        let Some((judge, (lower, upper))) = self.judge else { return };
        let margin = |d: &Diameter| (d.d_mm - lower).min(upper - d.d_mm);
        let mut decisive: Option<(Judgement, &str, f64, Diameter)> = None;
        for (word, z_mm, reading) in values {
            let Some(d) = reading.value() else { continue };
            let judgement = judge.judge(&d);
            let worst = decisive
                .is_none_or(|(known, _, _, by)| (rank(judgement), margin(&by)) > (rank(known), margin(&d)));
            if worst {
                decisive = Some((judgement, word, z_mm.to_owned(), d));
            }
        }
        let gap = values.iter().find_map(|(word, z_mm, reading)| match reading {
            Reading::Gap(reason) => Some((word, z_mm, reason)),
            Reading::Value(_) => None,
        });
        let good = decisive.is_none_or(|(judgement, ..)| judgement == Judgement::GO);
        if let (true, Some((word, z_mm, reason))) = (good, gap) {
            out.insert("judged".to_owned(), json!({ "what": word, "z_mm": z_mm, "flag": reason.as_str() }));
            return self.not_proven(out);
        }
        let Some((judgement, word, z_mm, d)) = decisive else { return self.not_proven(out) };
        self.worst = worse(self.worst, judgement);
        if let Err(error) = judge.check_uncertainty(d.u_mm()) {
            if !self.no_zone_told {
                tracing::warn!("{error}");
            }
            self.no_zone_told = true;
            out.insert("acceptance_zone".to_owned(), json!(error.to_string()));
        }
        out.insert("judgement".to_owned(), json!(judgement));
        let judged = json!({
            "what": word, "z_mm": z_mm, "d_mm": d.d_mm, "u_mm": d.u_mm(), "guard_mm": judge.guard_mm(&d),
        });
        out.insert("judged".to_owned(), judged);
    }

    /// Whether every value is proven good; true where nothing is judged.
    pub fn all_good(&self) -> bool {
        self.worst == Judgement::GO
    }

    /// What all frames together add to the document.
    ///
    /// # Errors
    /// Exit 3 for frames that make no turn.
    pub fn finish(&self, out: &mut Map<String, Value>) -> Result<(), Failure> {
        if self.statistics.count() > 0 {
            out.insert("statistics".to_owned(), self.statistics_json());
        }
        if self.args.turn {
            let form = self.part_form()?;
            let length = self.args.station_mm.unwrap_or(f64::INFINITY);
            let mut turn = turn_json(&form, |z_mm| self.common_mm(z_mm, length));
            turn["implausible"] = json!(self.jumps);
            out.insert("turn".to_owned(), turn);
        }
        Ok(())
    }

    fn statistics_json(&self) -> Value {
        let s = &self.statistics;
        let (min, max) = s.extremes().unwrap_or_default();
        // One value says nothing of the scatter.
        let scatter = |value: f64| (s.count() > 1).then_some(value);
        let mut all = json!({
            "count": s.count(), "mean_mm": s.mean(), "sd_mm": scatter(s.sd()), "u_mean_mm": scatter(s.u_mean()),
            "min_mm": min, "max_mm": max, "range_mm": max - min,
        });
        if let Some((_, (lower, upper))) = self.judge {
            all["cp"] = json!(s.cp(lower, upper, 0.95).ok());
            all["cpk"] = json!(s.cpk(lower, upper, 0.95).ok());
        }
        all
    }

    /// Common standard uncertainty of the sizes of the section at `z_mm`, mm: that of its columns, which they share.
    fn common_mm(&self, z_mm: f64, length_mm: f64) -> Option<f64> {
        let (mut sum, mut n) = (0.0, 0.0);
        for (meta, diameters) in &self.turn {
            for (column, reading) in diameters.readings.iter().enumerate() {
                if let (Some(d), true) =
                    (reading.value(), (diameters.z_mm(meta, column) - z_mm).abs() <= 0.5 * length_mm)
                {
                    (sum, n) = (sum + d.u_common_mm, n + 1.0);
                }
            }
        }
        (n > 0.0).then(|| sum / n)
    }

    fn part_form(&self) -> Result<PartForm, Failure> {
        let cutoff = Cutoff::upr(self.args.cutoff_upr).map_err(Failure::refuse)?;
        let ends = self
            .turn
            .iter()
            .filter(|(_, d)| !d.readings.is_empty())
            .map(|(meta, d)| (d.z_mm(meta, 0), d.z_mm(meta, d.readings.len() - 1)));
        let (low, high) =
            ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), (a, b)| (l.min(a), h.max(b)));
        if !(high > low) {
            return Err(Failure::fail("no frame of the turn could be measured"));
        }
        let length = self.args.station_mm.unwrap_or(high - low + 1e-9).min(high - low + 1e-9);
        let count = ((high - low) / length + 1e-6).floor().clamp(1.0, 1e5) as usize;
        let z_mm = (0..count).map(|i| low + (i as f64 + 0.5) * length).collect();
        let mut averager = TurnAverager::new(z_mm, length);
        self.turn.iter().for_each(|(meta, diameters)| averager.add(meta, diameters));
        let form = averager.finish(cutoff);
        match form.refused.first() {
            Some((z, why)) if form.sections.is_empty() => {
                Err(Failure::fail(format!("the frames make no turn at z = {z:.3} mm: {why}")))
            }
            _ => Ok(form),
        }
    }
}

/// Statistics for people.
pub fn statistics_line(s: &Value) -> String {
    let number = |v: &Value, digits: usize| v.as_f64().map_or("-".to_owned(), |x| format!("{x:.digits$}"));
    let mut text = format!(
        "mean diameters of {} frames: mean {} mm (u {}), sd {}, from {} to {}",
        s["count"],
        number(&s["mean_mm"], 5),
        number(&s["u_mean_mm"], 6),
        number(&s["sd_mm"], 6),
        number(&s["min_mm"], 5),
        number(&s["max_mm"], 5)
    );
    for (key, name) in [("cp", "Cp"), ("cpk", "Cpk")] {
        if let Some(index) = s.get(key).filter(|c| c.is_object()) {
            let [value, lower, upper] = ["index", "lower", "upper"].map(|k| number(&index[k], 2));
            text += &format!(", {name} {value} (95 %: {lower} to {upper})");
        }
    }
    text
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

/// The one that is farther from good.
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
