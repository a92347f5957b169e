//! `shadowgauge measure`: edges and diameters of frames in files.
//!
//! In: frames (`frames`), a calibration and conditions, an edge-spread function (`esf_argument`).
//! Out: a table (`table`) or JSON, edges as CSV (`edges_file`). This file measures frame by frame;
//! results over several frames are in the files beside it: `judge` (budgets, decisions on a
//! tolerance), `size` and `turn` (a part over its angles), `statistics` (series), `crests` (largest
//! diameters of a stretch), `ring` (parts seen end-on), `timing`. A new result of a frame is a key
//! of its JSON object, added here; a result over a series has a file of its own.

mod choice;
mod crests;
mod edges_file;
pub(super) mod esf_argument;
mod frames;
mod judge;
mod judge_args;
pub mod ring;
mod size;
mod statistics;
mod table;
mod timing;
mod turn;
mod words;

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use serde_json::{Value, json};

use self::choice::ChoiceArgs;
use self::crests::CrestStream;
use self::edges_file::{FrameRows, claim_edges, column_reason, write_rows};
use self::esf_argument::esf_model;
use self::frames::{FrameArgs, Frames, ScaleArgument, paths, scale_argument, scale_of_files};
use self::judge::{InspectionReport, stated_budget};
use self::judge_args::JudgeArgs;
use self::table::{print_series, print_table};
use self::words::place;
use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::ConfigText;
use crate::files::OutputFile;
use crate::frame::{Frame, FrameMeta, FrameView};
use crate::gauge::budget::WidthReading;
use crate::gauge::calibration::{Conditions, Date, GivenConditions};
use crate::gauge::ring::RingSettings;
use crate::gauge::sensor::ShaftRuns;
use crate::gauge::{
    Calibration, EdgeStream, EsfModel, FrameEdges, Gauge, GaugeSettings, LargestCaliper, Polarity,
    largest_caliper_over,
};
use crate::profile::Reason;

/// Arguments of `shadowgauge measure`.
#[derive(Debug, clap::Args)]
pub struct MeasureArgs {
    /// Images, stacks or folders of images (grey PNG, TIFF, JPEG, BMP, PGM), in this order; a
    /// folder's by the numbers in their names.
    #[arg(required = true)]
    input: Vec<PathBuf>,
    /// Scale, µm per pixel, when there is no calibration; `file` takes that of frames.csv or of the
    /// files' own tags.
    #[arg(long, value_name = "S|file", conflicts_with = "calibration", value_parser = scale_argument)]
    um_per_px: Option<ScaleArgument>,
    /// Calibration file (JSON) with scale, edge offset and their uncertainty.
    #[arg(long, value_name = "FILE")]
    calibration: Option<PathBuf>,
    /// Refuses a calibration of other optics than these.
    #[arg(long, value_name = "ID", requires = "calibration")]
    optics_id: Option<String>,
    /// Uses a calibration whose time is over, with a warning.
    #[arg(long, requires = "calibration")]
    accept_expired: bool,
    /// Judges the calibration's validity on this day instead of today, YYYY-MM-DD.
    #[arg(long, value_name = "DATE", requires = "calibration")]
    as_of: Option<Date>,
    /// Conditions of the part (TOML): temperature, expansion, place, with their limits; what it
    /// leaves out is the calibration's.
    #[arg(long, value_name = "FILE.toml")]
    conditions: Option<PathBuf>,
    /// Temperature of the part, °C, in place of the conditions' one.
    #[arg(long, value_name = "C", allow_negative_numbers = true)]
    part_temperature: Option<f64>,
    #[command(flatten)]
    frames: FrameArgs,
    #[command(flatten)]
    judge: JudgeArgs,
    #[command(flatten)]
    choice: ChoiceArgs,
    /// Writes both edges of every column to this CSV file; `-` is stdout, in place of the table.
    #[arg(long, value_name = "FILE.csv")]
    edges: Option<PathBuf>,
    /// Prints JSON.
    #[arg(long)]
    json: bool,
    /// What the part looks like: a shaft from the side, or a ring or disc seen end-on (radial
    /// calipers).
    #[arg(long, value_enum, default_value_t = Shape::Shaft)]
    shape: Shape,
    /// The shaft's axis stands upright in the images.
    #[arg(long)]
    vertical: bool,
    /// Rows of the sensor between two windows that each frame was read out as, the one around the
    /// upper edge first.
    #[arg(long, value_name = "ROWS", default_value_t = 0)]
    rows_between: u32,
    /// The part is lit before a dark ground.
    #[arg(long)]
    bright_on_dark: bool,
    /// Smallest shadow taken for a part, px across; anything smaller is dirt. 24 for a shaft and 20
    /// for a ring unless given; 4 at least for a shaft (a wire), 16 for a ring.
    #[arg(long, value_name = "PX", value_parser = positive_px)]
    min_diameter_px: Option<f64>,
    /// Edge-spread function that is fitted: gaussian, learnt (from the first frame), a table
    /// `distance_um,light` (.csv or .json, as `optics esf` prints it) or the optics of a config
    /// (.toml). Without it the calibration's, else gaussian.
    #[arg(long, value_name = "NAME|FILE")]
    esf: Option<String>,
    /// Threads (default: all cores).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Measures N frames from memory, cycling through those given, and reports the time; with
    /// several threads also what they gain, beside what streams gain that share nothing.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    bench: Option<u32>,
}

/// Shapes of parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Shape {
    /// A shaft from the side: an upper and a lower edge in every column.
    Shaft,
    /// A ring or disc seen end-on.
    Ring,
}

fn positive_px(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("a diameter above 0 in pixels is needed, for instance 6".to_owned()),
    }
}

/// One frame's result.
struct Measured {
    stem: String,
    meta: FrameMeta,
    columns: usize,
    /// Pitch of crests and roots, px, where the frame was measured as such.
    pitch_px: Option<f64>,
    result: Result<FrameEdges, (Reason, String)>,
}

impl Measured {
    fn rows(&self) -> FrameRows<'_> {
        let result = self.result.as_ref().map_err(|(reason, _)| *reason);
        FrameRows { stem: &self.stem, columns: self.columns, result }
    }
}

impl MeasureArgs {
    /// Files read beside the frames.
    fn other_inputs(&self) -> Vec<PathBuf> {
        let named = [&self.calibration, &self.conditions].into_iter().flatten().cloned();
        named.chain(self.esf.as_ref().map(PathBuf::from)).collect()
    }
}

/// Runs the command.
///
/// # Errors
/// Exit 2 for settings out of range; 3 for unreadable files and where no frame can be measured.
pub fn run(args: &MeasureArgs) -> CommandResult {
    let paths = paths(&args.input)?;
    let calibration = calibration(args, &paths)?;
    let conditions = conditions(args, calibration.as_ref())?;
    if let (None, Some(name)) = (&calibration, args.judge.needs_scale()) {
        return Err(Failure::refuse(format!("{name} needs millimetres: give --calibration or --um-per-px")));
    }
    let polarity = if args.bright_on_dark { Polarity::BrightOnDark } else { Polarity::DarkOnBright };
    let esf = edge_model(args, calibration.as_ref())?;
    calibration.as_ref().map_or(Ok(()), |c| c.check_edge_model(&esf)).map_err(Failure::refuse)?;
    let (which, rejection) = (args.choice.which(), args.choice.rejection());
    let mut settings = GaugeSettings { polarity, esf, which, rejection, ..GaugeSettings::default() };
    if args.shape == Shape::Shaft {
        settings.min_diameter_px = args.min_diameter_px.unwrap_or(settings.min_diameter_px);
    }
    let gauge = Gauge::new(settings).map_err(Failure::refuse)?;
    let gauge =
        gauge.with_systematic_residual(calibration.as_ref().and_then(Calibration::systematic_residual));
    if args.shape == Shape::Ring {
        return rings(args, calibration.as_ref(), &conditions, paths);
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(args.threads.map_or(0, usize::from))
        .build()
        .map_err(Failure::fail)?;
    pool.install(|| measure_all(args, &gauge, calibration.as_ref(), conditions, paths))
}

/// Measures rings; files without a readable frame give a warning, or an error if none is left.
fn rings(
    args: &MeasureArgs,
    calibration: Option<&Calibration>,
    conditions: &Conditions,
    paths: Vec<PathBuf>,
) -> CommandResult {
    if args.edges.is_some()
        || args.bench.is_some()
        || args.vertical
        || args.esf.as_deref().is_some_and(|e| e != "gaussian")
    {
        return Err(Failure::refuse("--edges, --bench, --vertical and --esf belong to --shape shaft"));
    }
    if let Some(name) = args.judge.needs_scale().or(args.choice.given()) {
        return Err(Failure::refuse(format!("{name} belongs to --shape shaft")));
    }
    let mut settings = RingSettings { bright_on_dark: args.bright_on_dark, ..RingSettings::default() };
    settings.min_diameter_px = args.min_diameter_px.unwrap_or(settings.min_diameter_px);
    let mut source = Frames::new(paths, &args.frames, calibration, args.um_per_px);
    let (mut frames, mut first_error) = (Vec::new(), None);
    while let Some((stem, read)) = source.next_frame() {
        let frame = read.and_then(|frame| {
            let frame = prepared(args, frame, calibration).map_err(|e| format!("frame {stem}: {e}"))?;
            Ok((stem, frame))
        });
        match frame {
            Ok(frame) => frames.push(frame),
            Err(error) => {
                tracing::warn!("{error}");
                first_error.get_or_insert(error);
            }
        }
    }
    match first_error {
        Some(error) if frames.is_empty() => Err(Failure::fail(error)),
        _ => ring::run(frames, &settings, calibration.map(|c| (c, conditions)), args.json),
    }
}

/// The edge-spread function: the command line's, otherwise the masters', otherwise the Gaussian.
fn edge_model(args: &MeasureArgs, calibration: Option<&Calibration>) -> Result<EsfModel, Failure> {
    match &args.esf {
        Some(text) => esf_model(text, calibration.map(|c| 1e3 * c.scale_mm_per_px)),
        // A ring has Gaussian edges: the model of the calibration does not apply.
        None if args.shape == Shape::Ring => Ok(EsfModel::default()),
        None => Ok(calibration.and_then(Calibration::edge_model).unwrap_or_default()),
    }
}

fn calibration(args: &MeasureArgs, paths: &[PathBuf]) -> Result<Option<Calibration>, Failure> {
    let Some(path) = &args.calibration else {
        return Ok(match args.um_per_px {
            None => None,
            Some(ScaleArgument::Given(um_per_px)) => Some(Calibration::from_scale(um_per_px)),
            Some(ScaleArgument::File) => Some(Calibration::from_scale(scale_of_files(&args.frames, paths)?)),
        });
    };
    let named = |e: &dyn std::fmt::Display| Failure::fail(format!("{}: {e}", path.display()));
    let file = fs::File::open(path).map_err(|e| named(&e))?;
    let calibration = Calibration::read(std::io::BufReader::new(file)).map_err(|e| named(&e))?;
    if let Some(id) = &args.optics_id {
        calibration.check_optics(id).map_err(|e| named(&e))?;
    }
    let today = args.as_of.unwrap_or_else(|| Date::of(std::time::SystemTime::now()));
    if let Some(Err(error)) = calibration.setup.as_ref().map(|b| b.check_date(today)) {
        if !args.accept_expired {
            return Err(named(&error));
        }
        tracing::warn!("{}: {error}; used with consent", path.display());
    }
    Ok(Some(if args.vertical { calibration.transposed() } else { calibration }))
}

/// The part's conditions: the file's, otherwise the calibration's; `--part-temperature` overrides.
fn conditions(args: &MeasureArgs, calibration: Option<&Calibration>) -> Result<Conditions, Failure> {
    let known = match calibration {
        Some(c) if c.leaves_conditions_open() => Conditions::unstated(),
        Some(c) => c.conditions(),
        None => Conditions::default(),
    };
    let mut conditions = match &args.conditions {
        Some(path) => merged(&ConfigText::read(path)?, &known)?,
        None => known,
    };
    if let Some(temperature_c) = args.part_temperature {
        conditions = conditions.at(temperature_c);
    }
    conditions.validate().map_err(Failure::refuse)?;
    Ok(conditions)
}

/// The calibration's conditions, overridden by the keys in a file.
fn merged(text: &ConfigText, known: &Conditions) -> Result<Conditions, Failure> {
    let given: GivenConditions = text.parse()?;
    let named: toml::Table = text.parse()?;
    let all = toml::Table::try_from(known).map_err(|e| text.refuse(e))?;
    let kept: Vec<String> = all
        .iter()
        .filter(|(key, _)| !named.contains_key(*key))
        .map(|(key, v)| format!("{key} = {v}"))
        .collect();
    tracing::info!("{}: kept of the calibration's conditions: {}", text.name, kept.join(", "));
    Ok(given.over(known))
}

/// A frame with the calibration's corrections of sensor and light; another size is refused.
fn prepared(args: &MeasureArgs, frame: Frame, calibration: Option<&Calibration>) -> Result<Frame, String> {
    let Some(setup) = calibration.and_then(|c| c.setup.as_ref()) else { return Ok(frame) };
    let view = view(args, &frame);
    setup.check_size(view.rows(), view.columns()).map_err(|e| e.to_string())?;
    Ok(match &setup.flat_field {
        Some(field) => {
            let shaft = if args.vertical { ShaftRuns::AlongColumns } else { ShaftRuns::AlongRows };
            field.corrected_along(frame, shaft)
        }
        None => frame,
    })
}

/// Measures every frame of the source; also returns the frames where they are to be timed.
fn measure_each(
    args: &MeasureArgs,
    gauge: &Gauge,
    calibration: Option<&Calibration>,
    conditions: &Conditions,
    source: &mut Frames<'_>,
) -> (Vec<Measured>, Vec<Frame>) {
    let mut stream = (gauge.stream(), CrestStream::new(gauge.settings()));
    let (mut results, mut frames) = (Vec::new(), Vec::new());
    while let Some((stem, read)) = source.next_frame() {
        let frame = read
            .and_then(|frame| prepared(args, frame, calibration).map_err(|e| format!("frame {stem}: {e}")));
        match frame {
            Ok(frame) => {
                let meta = frame.meta.clone();
                let measured = measure_one(args, &mut stream, stem, meta, &view(args, &frame));
                let accepted = args.judge.accepts_blur();
                results.push(if accepted { measured } else { sharp(measured, calibration, conditions) });
                if args.bench.is_some() {
                    frames.push(frame);
                }
            }
            Err(error) => {
                let result = Err((Reason::Unreadable, error));
                results.push(Measured {
                    stem,
                    meta: FrameMeta::default(),
                    columns: 0,
                    pitch_px: None,
                    result,
                });
            }
        }
    }
    (results, frames)
}

/// Adds the remarks on the choice of the shadow and the results over the series to a frame's row.
fn add_follower(
    args: &MeasureArgs,
    measured: &Measured,
    follower: &mut Option<InspectionReport<'_>>,
    row: &mut Value,
) {
    let edges = measured.result.as_ref().ok();
    let Some(row) = row.as_object_mut() else { return };
    if let Some(edges) = edges {
        args.choice.report(&measured.stem, edges, row);
        if let Some(pitch_px) = measured.pitch_px {
            crests::report(&measured.stem, pitch_px, row);
        }
    }
    if let Some(follower) = follower {
        follower.add(&measured.meta, edges, row);
        if edges.is_some_and(|edges| args.choice.is_ambiguous(edges)) {
            follower.not_proven(row);
            if row.contains_key("judged") {
                row.insert("judged".to_owned(), json!({ "what": "frame", "flag": "several_shadows" }));
            }
        }
    }
}

fn measure_all(
    args: &MeasureArgs,
    gauge: &Gauge,
    calibration: Option<&Calibration>,
    conditions: Conditions,
    paths: Vec<PathBuf>,
) -> CommandResult {
    let edges = args.edges.as_deref();
    let edges = edges.map(|path| claim_edges(path, &paths, args.other_inputs(), args.json)).transpose()?;
    let edges_on_stdout = edges.as_ref().is_some_and(OutputFile::is_stdout);
    let mut source = Frames::new(paths, &args.frames, calibration, args.um_per_px);
    let (results, frames) = measure_each(args, gauge, calibration, &conditions, &mut source);
    report_refusals(&results)?;
    report_unlearnt(gauge, &results);
    if let Some(file) = edges {
        file.write_with(|out| {
            write_rows(out, results.iter().map(Measured::rows)).map_err(|e| match e.into_kind() {
                csv::ErrorKind::Io(cause) => cause,
                other => std::io::Error::other(format!("{other:?}")),
            })
        })?;
    }
    let benchmark = args.bench.map(|count| {
        let views: Vec<FrameView<'_>> = frames.iter().map(|frame| view(args, frame)).collect();
        timing::benchmark(gauge, &views, count)
    });
    let mut follower = calibration.map(|c| InspectionReport::new(&args.judge, c, conditions)).transpose()?;
    let mut out = serde_json::Map::new();
    let mut figures = Vec::new();
    for measured in &results {
        let mut row = frame_figures(args, measured, calibration, &conditions);
        add_follower(args, measured, &mut follower, &mut row);
        figures.push(row);
    }
    if let Some(follower) = &mut follower {
        follower.finish(&mut out)?;
        out.insert("conditions".to_owned(), json!(conditions));
    }
    out.extend(benchmark.map(|b| ("bench".to_owned(), b)));
    if args.json {
        out.insert("frames".to_owned(), figures.into());
        say_line!("{}", Value::Object(out));
    } else if !edges_on_stdout {
        print_table(&figures, out.get("bench"));
        if args.judge.budget() {
            print_budgets(args, &results, calibration, &conditions);
        }
        print_series(&out);
    }
    Ok(if follower.is_none_or(|f| f.all_good()) { Outcome::Done } else { Outcome::OutOfTolerance })
}

/// Budgets of the frames' largest diameters.
fn print_budgets(
    args: &MeasureArgs,
    results: &[Measured],
    calibration: Option<&Calibration>,
    conditions: &Conditions,
) {
    for measured in results {
        let (Ok(edges), Some(calibration)) = (&measured.result, calibration) else { continue };
        let least = args.judge.least_stretch(Some(calibration));
        if let Some(reading) = WidthReading::of_largest(edges, calibration, least) {
            say_line!("\nbudget of the largest diameter of frame {}", measured.stem);
            say!(
                "{}",
                stated_budget(&reading, calibration, conditions).to_table(args.judge.coverage_factor())
            );
        }
    }
}

fn view<'a>(args: &MeasureArgs, frame: &'a Frame) -> FrameView<'a> {
    if args.vertical { frame.view().transposed() } else { frame.view() }
}

fn measure_one(
    args: &MeasureArgs,
    (stream, crests): &mut (EdgeStream, CrestStream),
    stem: String,
    meta: FrameMeta,
    view: &FrameView<'_>,
) -> Measured {
    let mut edges = FrameEdges::default();
    let mut first = stream.measure(view, &mut edges).map(|()| edges);
    let mut pitch_px = None;
    if args.choice.tries_crests()
        && let Some((edges, pitch)) = crests.measure(&first, view)
    {
        (first, pitch_px) = (Ok(edges), Some(pitch));
    }
    let result = match first {
        Ok(mut edges) => {
            edges.place_windows(0.0, f64::from(args.rows_between));
            Ok(edges)
        }
        Err(refused) => Err((refused.reason, format!("frame {stem}: {refused}"))),
    };
    Measured { stem, meta, columns: view.columns(), pitch_px, result }
}

/// Warns where an edge-spread function could not be determined from the frame.
fn report_unlearnt(gauge: &Gauge, results: &[Measured]) {
    let unlearnt =
        |m: &&Measured| m.result.as_ref().is_ok_and(|e| e.figures.position_ambiguity_px == [0.0; 2]);
    let count = results.iter().filter(unlearnt).count();
    if gauge.settings().esf == (EsfModel::Learnt {}) && count > 0 {
        tracing::warn!(
            "{count} frames measured with a Gaussian: their edges show too few sub-pixel phases to learn from; tilt the part by a pixel or more over the field"
        );
    }
}

/// Refuses a frame whose blur differs from the masters', because its edges are displaced.
fn sharp(mut measured: Measured, calibration: Option<&Calibration>, conditions: &Conditions) -> Measured {
    if let (Ok(edges), Some(setup)) = (&measured.result, calibration.and_then(|c| c.setup.as_ref()))
        && let Err(error) = setup.check_focus(edges.figures.sigma_px, conditions)
    {
        measured.result = Err((Reason::Blurred, format!("frame {}: {error}", measured.stem)));
    }
    measured
}

/// Warns of refused frames; fails with the first one's reason where none could be measured.
fn report_refusals(results: &[Measured]) -> Result<(), Failure> {
    let refusals: Vec<&String> =
        results.iter().filter_map(|m| m.result.as_ref().err()).map(|(_, text)| text).collect();
    if refusals.len() == results.len() {
        let first = refusals.first().map_or("no frame", |text| text.as_str());
        return Err(match refusals.len() {
            0 | 1 => Failure::fail(first),
            n => Failure::fail(format!("none of {n} frames can be measured; the first: {first}")),
        });
    }
    for text in refusals {
        tracing::warn!("{text}");
    }
    Ok(())
}

fn frame_figures(
    args: &MeasureArgs,
    measured: &Measured,
    calibration: Option<&Calibration>,
    conditions: &Conditions,
) -> Value {
    let least = args.judge.least_stretch(calibration);
    let mut flags = BTreeMap::<&str, usize>::new();
    let mut largest: Option<LargestCaliper> = None;
    let mut valid = 0;
    match &measured.result {
        Ok(edges) => {
            valid = edges.valid();
            largest = largest_caliper_over(edges, least);
            for reason in (0..edges.columns()).filter_map(|c| column_reason(&edges.top[c], &edges.bottom[c]))
            {
                *flags.entry(reason.as_str()).or_default() += 1;
            }
        }
        Err((reason, _)) => {
            flags.insert(reason.as_str(), measured.columns.max(1));
        }
    }
    let in_mm = calibration.zip(measured.result.as_ref().ok()).and_then(|(calibration, edges)| {
        let budget = WidthReading::of_largest(edges, calibration, least)?.budget(calibration, conditions);
        Some((budget.diameter_mm, budget.u_mm()))
    });
    let mut figures = json!({
        "frame": measured.stem,
        "columns": measured.columns,
        "valid": valid,
        "max_diameter_px": largest.map(|l| l.diameter_px),
        "u_max_px": largest.map(|l| l.u_px),
        "max_diameter_mm": in_mm.map(|v| v.0),
        "u_max_mm": in_mm.map(|v| v.1),
        "flags": flags,
    });
    if let Some(largest) = largest {
        place((&measured.meta, measured.columns), &largest, calibration, &mut figures);
    }
    if let Err((_, why)) = &measured.result {
        figures["warnings"] = json!([why]);
    }
    figures
}
