//! `shadowgauge measure`: edges and diameters of frames in files.
//!
//! In: frames (`frames`) of files, a folder that is followed or stdin (`input`), a calibration and
//! conditions, an edge-spread function (`esf_argument`). Out, as the frames come (`results`): a
//! table (`table`, `statistics`, `turn`, `words`, `legend`) or JSON (`document`), edges as CSV
//! (`edges_file`), diameters as CSV and a report (`leaves`, `csv_file`); the
//! offsets of the next part (`offsets`); times (`timing`). Values over time beside the frames are
//! tables of `time_table`, also while they grow (`growing_table`); samples of an encoder are such
//! (`encoder_samples`). This file turns arguments into settings and frames into a
//! [`Stream`](crate::measurement::Stream); what is measured is in
//! [`measurement`](crate::measurement), where a new result goes too.

pub(super) mod camera_source;
mod choice;
mod closing;
mod csv_file;
pub(super) mod document;
mod edges_file;
pub(super) mod encoder_args;
mod encoder_samples;
pub(super) mod esf_argument;
pub(super) mod frames;
pub(super) mod growing_table;
mod index_table;
pub(super) mod input;
pub(super) mod instrument_args;
mod judge_args;
mod leaves;
mod legend;
mod machine_args;
pub(super) mod offsets;
pub(super) mod reference_pin_args;
mod results;
mod ring;
pub(super) mod scale_drift_args;
mod statistics;
mod table;
pub(super) mod temperature_args;
pub(super) mod time_table;
mod timing;
mod turn;
mod warnings;
mod words;

use std::path::PathBuf;
use std::sync::atomic::Ordering;

use serde_json::Value;

use self::choice::ChoiceArgs;
use self::document::{Lines, Whole};
use self::edges_file::{EdgesFile, claim_output};
use self::encoder_args::EncoderArgs;
use self::esf_argument::esf_model;
use self::frames::{FrameArgs, FrameChecks, Frames, ScaleArgument};
use self::input::{Input, InputArgs};
use self::instrument_args::InstrumentArgs;
use self::judge_args::JudgeArgs;
use self::leaves::{Inputs, Leaves, LeavesArgs, MeasuredBy};
use self::legend::Legend;
use self::machine_args::MachineArgs;
use self::offsets::{OffsetArgs, OffsetJob};
use self::reference_pin_args::ReferencePinArgs;
use self::results::{Beside, Printed, Results, head};
use self::temperature_args::{StatedTemperatures, TemperatureArgs, take_temperature};
use self::warnings::{report_uncalibrated, report_unlearnt};
use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::terminal::output;
use crate::files::OutputFile;
use crate::frame::{Frame, FrameView};
use crate::gauge::calibration::{Conditions, HeadGeometry};
use crate::gauge::ring::RingSettings;
use crate::gauge::{Calibration, EsfModel, Gauge, GaugeSettings, Polarity};
use crate::measurement::{MeasureError, MeasureSettings, ReferencePin, Series, Stream, edge_model, prepared};
use crate::source::Arrival;

/// Arguments of `shadowgauge measure`.
#[derive(Debug, clap::Args)]
pub(crate) struct MeasureArgs {
    #[command(flatten)]
    input: InputArgs,
    #[command(flatten)]
    instrument: InstrumentArgs,
    #[command(flatten)]
    temperatures: TemperatureArgs,
    #[command(flatten)]
    encoder: EncoderArgs,
    #[command(flatten)]
    pin: ReferencePinArgs,
    #[command(flatten)]
    machine: MachineArgs,
    #[command(flatten)]
    frames: FrameArgs,
    #[command(flatten)]
    judge: JudgeArgs,
    #[command(flatten)]
    choice: ChoiceArgs,
    /// Writes both edges of every column to this CSV file; `-` is stdout, in place of the table.
    #[arg(long, value_name = "FILE.csv")]
    edges: Option<PathBuf>,
    #[command(flatten)]
    leaves: LeavesArgs,
    #[command(flatten)]
    offsets: OffsetArgs,
    /// Prints JSON: one document; of a stream (--follow, -) a line a frame and one of the series.
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
    /// upper edge first; frames of a recording by `watch --windows` state their own.
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
    /// Threads that measure, and as many that decode meanwhile (default: all cores).
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

/// Parses a size in pixels.
pub(super) fn positive_px(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("a diameter above 0 in pixels is needed, for instance 6".to_owned()),
    }
}

/// What a frame or a setting gives no measurement for: exit 2 for settings, 3 for frames.
pub(super) fn failure(error: MeasureError) -> Failure {
    if error.is_of_settings() { Failure::refuse(error) } else { Failure::fail(error) }
}

/// What a command measures with.
struct Instrument {
    gauge: Gauge,
    calibration: Option<Calibration>,
    conditions: Conditions,
    settings: MeasureSettings,
    pin: Option<ReferencePin>,
    geometry: Option<HeadGeometry>,
}

impl Instrument {
    fn stream(&self) -> Result<Stream, Failure> {
        let settings = self.settings.clone();
        match &self.calibration {
            Some(calibration) => Stream::new(&self.gauge, calibration, &self.conditions, settings),
            None => Stream::in_pixels(&self.gauge, settings),
        }
        .and_then(|stream| match self.pin {
            Some(pin) => stream.with_reference_pin(&self.gauge, pin),
            None => Ok(stream),
        })
        .map(|stream| stream.with_head_geometry(self.geometry.clone()))
        .map_err(failure)
    }
}

impl MeasureArgs {
    /// Files read beside the frames.
    fn other_inputs(&self) -> Vec<PathBuf> {
        let named = self.instrument.files().chain(self.temperatures.file()).chain(self.encoder.file());
        let named = named.chain(self.machine.file());
        named.chain(self.esf.as_ref().map(PathBuf::from)).chain(self.offsets.inputs()).collect()
    }

    /// What is asked of the frames.
    fn settings(&self) -> MeasureSettings {
        MeasureSettings {
            vertical: self.vertical,
            rows_between: self.rows_between,
            crests: self.choice.tries_crests(),
            ..self.judge.settings()
        }
    }

    /// The gauge's own settings, with an edge-spread function.
    fn gauge_settings(&self, esf: EsfModel) -> GaugeSettings {
        let polarity = if self.bright_on_dark { Polarity::BrightOnDark } else { Polarity::DarkOnBright };
        let (which, rejection) = (self.choice.which(), self.choice.rejection());
        let mut settings = GaugeSettings { polarity, esf, which, rejection, ..GaugeSettings::default() };
        if self.shape == Shape::Shaft {
            settings.min_diameter_px = self.min_diameter_px.unwrap_or(settings.min_diameter_px);
        }
        settings
    }
}

/// Runs the command.
///
/// # Errors
/// Exit 2 for settings out of range; 3 for unreadable files and where no frame can be measured.
pub(crate) fn run(args: &MeasureArgs) -> CommandResult {
    let input = Input::of(&args.input)?;
    check_stream(args, &input)?;
    check_offsets(args, &input)?;
    let calibration = args.instrument.calibration(&args.frames, input.files())?;
    let input = input.opened()?;
    let calibration = args.instrument.bound(calibration, input.bound_to())?;
    let conditions = args.instrument.conditions(calibration.as_ref())?;
    let needs_scale = args.judge.needs_scale().or(args.pin.given());
    if let (None, Some(name)) = (&calibration, needs_scale) {
        return Err(Failure::refuse(format!("{name} needs millimetres: give --calibration or --um-per-px")));
    }
    let esf = stated_edge_model(args, calibration.as_ref())?;
    let gauge = Gauge::calibrated(args.gauge_settings(esf), calibration.as_ref()).map_err(failure)?;
    // The report shows a budget.
    let budget = args.judge.shows_budgets() || args.leaves.has_report() && calibration.is_some();
    let settings = MeasureSettings { budget, ..args.settings() };
    let pin = args.pin.reference_pin;
    let geometry = args.machine.geometry()?;
    let instrument = Instrument { gauge, calibration, conditions, settings, pin, geometry };
    if args.shape == Shape::Ring {
        return rings(args, &instrument, input);
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(args.threads.map_or(0, usize::from))
        .build()
        .map_err(Failure::fail)?;
    pool.install(|| measure_all(args, &instrument, input))
}

/// Refuses what needs all frames before the first is measured, of a stream.
fn check_stream(args: &MeasureArgs, input: &Input) -> Result<(), Failure> {
    if !input.is_stream() {
        return Ok(());
    }
    if args.bench.is_some() {
        return Err(Failure::refuse("--bench measures files that are there, not a stream (--follow, -)"));
    }
    if args.instrument.scale() == Some(ScaleArgument::File) {
        return Err(Failure::refuse(
            "--um-per-px file takes the scale of the first file; of a stream (--follow, -) state it, for instance 17.4",
        ));
    }
    Ok(())
}

/// Refuses what does not go with the offsets of a part.
fn check_offsets(args: &MeasureArgs, input: &Input) -> Result<(), Failure> {
    let why = match () {
        () if !args.offsets.are_given() => return Ok(()),
        () if !args.instrument.has_calibration() => {
            "needs --calibration FILE: a scale alone has no uncertainty to decide by"
        }
        () if input.is_stream() => "decides on the frames of one part, not on a stream (--follow, -)",
        () if args.shape == Shape::Ring => "belongs to --shape shaft",
        () if args.bench.is_some() => "moves offsets, --bench takes times: give one of them",
        () if args.machine.given().is_some() => {
            "corrects its readings by the job's [machine] (correct_readings), without --machine"
        }
        () if args.vertical => "needs frames whose columns lie along the spindle's axis, without --vertical",
        () if args.bright_on_dark => "takes the polarity from the job ([gauge]), without --bright-on-dark",
        () => return Ok(()),
    };
    Err(Failure::refuse(format!("--offsets {why}")))
}

/// What is decided from the frames besides their diameters.
fn begin_offsets(
    args: &MeasureArgs,
    instrument: &Instrument,
    input: &Input,
) -> Result<Option<OffsetJob>, Failure> {
    let Some(calibration) = &instrument.calibration else { return Ok(None) };
    let conditions = args.instrument.states_conditions().then_some(instrument.conditions);
    let esf = stated_edge_model(args, Some(calibration))?;
    OffsetJob::begin(&args.offsets, input.files(), (calibration, esf), conditions)
}

/// Threads that decode: as many as measure.
fn decoding_threads(args: &MeasureArgs) -> usize {
    let all = || std::thread::available_parallelism().map_or(1, usize::from);
    args.threads.map_or_else(all, usize::from)
}

/// Measures a frame, or counts why it cannot be read; gives the frame back. A frame of a stream
/// without a time of its own has that of its arrival, to which seconds are as good.
fn measure_one(
    stream: &mut Stream,
    arrival: &Arrival,
    read: Result<Frame, String>,
    temperatures: Option<&StatedTemperatures>,
) -> Option<Frame> {
    let stem = arrival.stem.as_str();
    let timed = read.and_then(|mut frame| {
        if let (None, Some(host)) = (arrival.device_t_ns, arrival.host_t_ns) {
            frame.meta.t_ns = host;
        }
        take_temperature(stream, temperatures, frame.meta.t_ns, arrival.head_c).map(|()| frame)
    });
    match timed.and_then(|frame| stream.prepared(stem, frame).map_err(|error| error.to_string())) {
        Ok(frame) => {
            // What a refused frame is refused for stands in its measurement.
            let _ = stream.push_prepared(stem, &frame.meta, &frame.view());
            Some(frame)
        }
        Err(why) => {
            stream.push_unreadable(stem, why);
            None
        }
    }
}

/// How the frames of a stream of measurements are printed.
fn printed(args: &MeasureArgs, is_stdout_taken: bool, is_stream: bool, stream: &Stream) -> Printed {
    match (args.json, args.bench.is_some()) {
        (true, _) if is_stream => Printed::Lines(Lines::default()),
        (true, true) => Printed::Timed(Vec::new()),
        (true, false) => Printed::Whole(Whole::new(head(stream.conditions()))),
        _ if is_stdout_taken => Printed::Nothing,
        _ => {
            let settings = args.judge.settings();
            Printed::Table {
                coverage_factor: settings.coverage_factor,
                probability: settings.conformance_probability,
                averages: settings.averages(),
                has_header: false,
                legend: Legend::default(),
            }
        }
    }
}

fn measure_all(args: &MeasureArgs, instrument: &Instrument, input: Input) -> CommandResult {
    let (edges, is_stream) = (args.edges.as_deref(), input.is_stream());
    let claim = |path| claim_output("--edges", path, input.files(), args.other_inputs(), args.json);
    let edges = edges.map(claim).transpose()?;
    let mut leaves = begin_leaves(args, instrument, &input)?;
    let offsets = begin_offsets(args, instrument, &input)?;
    let mut scan = offsets.as_ref().map(OffsetJob::scan);
    let is_stdout_taken = leaves.is_stdout() || edges.as_ref().is_some_and(OutputFile::is_stdout);
    let mut stream = instrument.stream()?;
    let edges = edges.map(|file| EdgesFile::begin(file, is_stream)).transpose()?;
    let mut results = Results::new(printed(args, is_stdout_taken, is_stream, &stream), edges, is_stream);
    if is_stream {
        report_uncalibrated(&stream);
    }
    let temperatures = args.temperatures.read(is_stream)?;
    let encoder = args.encoder.of_input(input.is_stream())?;
    let opened = input.open(args.frames.channel(), encoder, decoding_threads(args))?;
    let stop = opened.stop.clone();
    let checks = FrameChecks::new(&args.frames, instrument.calibration.as_ref(), args.instrument.scale());
    let mut frames = Frames::new(opened.frames, checks);
    let mut kept = Vec::new();
    while let Some((arrival, read)) = frames.next_frame() {
        let frame = measure_one(&mut stream, &arrival, read, temperatures.as_ref());
        leaves.add(&mut stream, frame.as_ref())?;
        results.frame(&stream, &arrival)?;
        match (&mut scan, frame) {
            (Some(scan), Some(frame)) => scan.take(frame),
            (None, Some(frame)) if args.bench.is_some() => kept.push(frame),
            (None, Some(frame)) => frames.give_back(frame),
            (_, None) => {}
        }
        if is_stream && output::has_failed() {
            break;
        }
    }
    if !stop.is_some_and(|stop| stop.load(Ordering::Relaxed))
        && let Err(none) = results.check_measured().or_else(|none| frames.check_ended().and(Err(none)))
    {
        // Why every frame was refused is what these show.
        leaves.finish(&Series::default())?;
        return Err(none);
    }
    report_unlearnt(&stream);
    results.finish_edges()?;
    let bench = args.bench.map(|count| bench(args, instrument, &kept, count)).transpose()?;
    let series = stream.finish().map_err(failure)?;
    leaves.finish(&series)?;
    // What was measured is printed where the source ended too early, too; it decides nothing then.
    let ended = frames.check_ended();
    let profile = scan.filter(|_| ended.is_ok()).map(|scan| scan.finish(1).0);
    let decided = offsets.zip(profile).map(|(offsets, profile)| offsets.decide(profile)).transpose()?;
    let goes_on = decided.as_ref().is_none_or(|d| d.ended() == Outcome::Done);
    results.end(&series, Beside { bench, offsets: decided });
    ended?;
    Ok(if series.all_good() && goes_on { Outcome::Done } else { Outcome::OutOfTolerance })
}

/// The files of `--csv` and `--report`, claimed.
fn begin_leaves(args: &MeasureArgs, instrument: &Instrument, input: &Input) -> Result<Leaves, Failure> {
    let (named, others) = (args.input.named(), args.other_inputs());
    let (json, is_stream) = (args.json, input.is_stream());
    let inputs = Inputs { named: &named, images: input.files(), others, json, is_stream };
    let by = MeasuredBy {
        calibration: instrument.calibration.as_ref(),
        conditions: &instrument.conditions,
        settings: &instrument.settings,
        shows_budgets: args.judge.shows_budgets(),
    };
    Leaves::begin(&args.leaves, &inputs, &by)
}

fn view<'a>(args: &MeasureArgs, frame: &'a Frame) -> FrameView<'a> {
    if args.vertical { frame.view().transposed() } else { frame.view() }
}

/// The time to measure the frames from memory.
fn bench(
    args: &MeasureArgs,
    instrument: &Instrument,
    frames: &[Frame],
    count: u32,
) -> Result<Value, Failure> {
    let views: Vec<FrameView<'_>> = frames.iter().map(|frame| view(args, frame)).collect();
    // The views are laid level already, and frames by the thousand are no turn.
    let tolerance = instrument.settings.tolerance.filter(|t| !t.criterion.needs_turn());
    let settings = MeasureSettings { vertical: false, turn: false, tolerance, ..instrument.settings.clone() };
    let level = |c: &Calibration| if args.vertical { c.transposed() } else { c.clone() };
    let calibration = instrument.calibration.as_ref().map(level);
    let level = Instrument {
        gauge: instrument.gauge.clone(),
        calibration,
        conditions: instrument.conditions,
        settings,
        pin: instrument.pin,
        geometry: instrument.geometry.clone(),
    };
    Ok(timing::benchmark(&instrument.gauge, level.stream()?, &views, count))
}

/// Measures rings; files without a readable frame give a warning, or an error if none is left.
fn rings(args: &MeasureArgs, instrument: &Instrument, input: Input) -> CommandResult {
    if args.edges.is_some()
        || args.bench.is_some()
        || args.vertical
        || args.esf.as_deref().is_some_and(|e| e != "gaussian")
    {
        return Err(Failure::refuse("--edges, --bench, --vertical and --esf belong to --shape shaft"));
    }
    let of_shaft = args.judge.needs_scale().or(args.choice.given()).or(args.leaves.given());
    if let Some(name) = of_shaft.or(args.pin.given()).or(args.machine.given()) {
        return Err(Failure::refuse(format!("{name} belongs to --shape shaft")));
    }
    let mut settings = RingSettings { bright_on_dark: args.bright_on_dark, ..RingSettings::default() };
    settings.min_diameter_px = args.min_diameter_px.unwrap_or(settings.min_diameter_px);
    let calibration = instrument.calibration.as_ref();
    let json = args.json.then(|| if input.is_stream() { ring::Json::lines() } else { ring::Json::whole() });
    let encoder = args.encoder.of_input(input.is_stream())?;
    let opened = input.open(args.frames.channel(), encoder, decoding_threads(args))?;
    let checks = FrameChecks::new(&args.frames, calibration, args.instrument.scale());
    let mut source = Frames::new(opened.frames, checks);
    let (mut first_error, mut readable) = (None, 0_usize);
    let frames = std::iter::from_fn(|| {
        while let Some((arrival, read)) = source.next_frame() {
            let frame = read.and_then(|frame| {
                prepared(&arrival.stem, frame, calibration, args.vertical).map_err(|e| e.to_string())
            });
            match frame {
                Ok(frame) => {
                    readable += 1;
                    return Some((arrival, frame));
                }
                Err(error) => {
                    tracing::warn!("{error}");
                    first_error.get_or_insert(error);
                }
            }
        }
        None
    });
    let measured = ring::run(frames, &settings, calibration.map(|c| (c, &instrument.conditions)), json);
    source.check_ended()?;
    match first_error {
        Some(error) if readable == 0 => Err(Failure::fail(error)),
        _ => measured,
    }
}

/// The edge-spread function: the command line's, otherwise the masters', otherwise the Gaussian.
fn stated_edge_model(args: &MeasureArgs, calibration: Option<&Calibration>) -> Result<EsfModel, Failure> {
    let um_per_px = calibration.map(|c| 1e3 * c.scale_mm_per_px);
    let stated = args.esf.as_ref().map(|text| esf_model(text, um_per_px)).transpose()?;
    // A ring has Gaussian edges: the model of the calibration does not apply.
    let of_ring = (args.shape == Shape::Ring).then(EsfModel::default);
    Ok(edge_model(stated.or(of_ring), calibration))
}
