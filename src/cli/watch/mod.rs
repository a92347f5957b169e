//! `shadowgauge watch`: a source watched live.
//!
//! In: a source of frames, a scale or calibration, a tolerance, temperatures and zeros over time
//! (`condition_args`; a command: `thermometer`; taken into the
//! measurement by `live_conditions`). Out: on a terminal one line of the present diameter that is
//! written over again, on stdout a line a part, or with `--json` a line a frame and a line an event
//! (`shown`); an alarm with its command (`on_alarm`, run by `shell`); counts at the end; the frames
//! themselves (`recorded`), results and bad frames (`saved`); the newest frame for a page
//! (`picture`); a page to set the gauge up by (`setup_page`). `session` takes the events of the
//! source and measures (`frame_value`: what a frame shows, `course`: how readings run in time,
//! `session_settings`: what it is given); what is computed beside the measurement is in
//! [`measurement::watch`](crate::measurement), where one more figure goes.

mod condition_args;
mod course;
mod frame_value;
mod live_conditions;
mod on_alarm;
mod picture;
#[cfg(feature = "mcap")]
mod recorded;
mod saved;
mod session;
mod session_settings;
mod setup_page;
mod shell;
mod shown;
mod thermometer;

use std::path::{Path, PathBuf};
use std::time::Duration;

use self::condition_args::ConditionArgs;
use self::live_conditions::LiveConditions;
use self::on_alarm::OnAlarm;
use self::picture::Picture;
#[cfg(feature = "mcap")]
use self::recorded::Recording;
use self::saved::Saved;
use self::session::{Ended, Session};
use self::session_settings::{Beside, SessionSettings};
use self::setup_page::{SetupOf, SetupPage};
use self::shown::{Shown, ShownAs};
use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::measure::encoder_args::{EncoderArgs, bound};
use crate::cli::measure::frames::{FrameArgs, FrameChecks, ScaleArgument, paths};
use crate::cli::measure::input::{Reading, StreamArgs, StreamSource, check_untimed, seconds};
use crate::cli::measure::instrument_args::InstrumentArgs;
use crate::cli::measure::reference_pin_args::ReferencePinArgs;
use crate::cli::measure::{failure, positive_px};
use crate::cli::process::interrupt;
use crate::conformity::Tolerance;
use crate::frame::{BoundSource, CameraBinding};
use crate::gauge::{Calibration, Gauge, GaugeSettings, Polarity};
use crate::measurement::{MeasureSettings, Stream, edge_model};
use crate::source::live::{
    Binding, Live, LiveSettings, LiveSource as _, Policy, Producer, StoredProducer, TwoWindows, Windowed,
};

/// Frames that wait where every one is measured: some are decoded while one is measured.
const WAITING: usize = 4;
/// Frames that wait where they come turn by turn: those of two turns of 32, as many as are held in
/// frames of 2048 × 2048.
const OF_A_TURN: usize = 64;

/// Arguments of `shadowgauge watch`.
#[derive(Debug, clap::Args)]
pub(crate) struct WatchArgs {
    /// Where frames come from: a folder that a camera drops images into, image files, `-` (images
    /// or Y4M on stdin), FILE.y4m, `raw:-` or `raw:FILE` (with --raw), `sim:CONFIG.toml` (the
    /// simulated head, at its camera's rate), `replay:FILE.mcap` (a recording), `gige:IP` or
    /// `gige:NAME` (a GigE Vision camera by its address, serial number or user-defined name; one
    /// that is gone is looked for until it is back). Of a folder, stdin, a camera and the simulated
    /// head the newest frame is measured and those before it are counted as left out; of files and
    /// recordings every frame.
    #[arg(value_name = "SOURCE")]
    source: PathBuf,
    #[command(flatten)]
    stream: StreamArgs,
    #[command(flatten)]
    instrument: InstrumentArgs,
    #[command(flatten)]
    frames: FrameArgs,
    /// Tolerance of the part as on its drawing: "25 h6", "Ø25 ±0.01", "24.987..25". A frame that is
    /// proven outside raises the alarm, and so does a part that is not proven good.
    #[arg(long, value_name = "T")]
    tolerance: Option<Tolerance>,
    /// Probability of conformity to both limits behind GO (ISO 14253-1).
    #[arg(long, value_name = "P", default_value_t = 0.95)]
    conformance_probability: f64,
    /// Seconds over which readings must agree before a diameter is good. Until then the reading is
    /// invalid and nothing is proven; a trend (coolant that runs off, a part that cools) is named,
    /// and what cannot be seen of it is in U.
    #[arg(long, value_name = "S", value_parser = seconds)]
    settle_s: Option<Duration>,
    /// The part turns: the readings that must agree are means of whole turns, by the spindle angle
    /// that the source gives of every frame.
    #[arg(long, requires = "settle_s")]
    turning: bool,
    #[command(flatten)]
    encoder: EncoderArgs,
    #[command(flatten)]
    pin: ReferencePinArgs,
    #[command(flatten)]
    conditions: ConditionArgs,
    /// Gives diameters of frames, too, that are blurred otherwise than the masters were (out of
    /// focus, moving), with a warning.
    #[arg(long)]
    accept_blur: bool,
    /// The shaft's axis stands upright in the images.
    #[arg(long)]
    vertical: bool,
    /// The part is lit before a dark ground.
    #[arg(long)]
    bright_on_dark: bool,
    /// Smallest shadow taken for a part, px across; anything smaller is dirt. 24 unless given.
    #[arg(long, value_name = "PX", value_parser = positive_px)]
    min_diameter_px: Option<f64>,
    /// Prints JSON: a line a frame with the keys of `measure --json`, and a line an event (part,
    /// gap, invalid, alarm, end) with the key `event`.
    #[arg(long)]
    json: bool,
    /// Adds the uncertainty budget of the largest diameter to the line of every frame.
    #[arg(long)]
    budget: bool,
    /// Shows a page a second of focus along the field, tilt of the axis, contrast, gradient of the
    /// edges, use of the grey scale with the exposure that suits it, and evenness of the light
    /// against the calibrated flat; with --json an event. Frames need no part yet.
    #[arg(long)]
    setup: bool,
    /// Saves all results as JSON lines in this new folder (results.jsonl), and the frames that are
    /// invalid or not good as 16-bit PNG in frames/, as the source gave them, with frames.csv.
    #[arg(long, value_name = "DIR")]
    save: Option<PathBuf>,
    /// Frames that may wait while one is measured, 1 to 64; of a source that does not wait the
    /// oldest is left out beyond them. More lose none while the machine is busy for a moment, and a
    /// result is older by as many frames where the gauge is slower than the camera. Unless given 1
    /// where the newest frame is measured, 4 where every one is, 64 with --encoder.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=64))]
    waiting: Option<u8>,
    /// Keeps the newest frame with its edges in this file, five times a second, for a page that
    /// shows it (docs/serve.md).
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// Most frames that are saved; further ones are counted.
    #[arg(long, value_name = "N", requires = "save", default_value_t = 200)]
    save_frames: u32,
    /// Ends after S seconds without a frame.
    #[arg(long, value_name = "S", value_parser = seconds)]
    idle_s: Option<Duration>,
    /// Time after which the last frame is no reading of now any more, s: it then reads invalid.
    #[arg(long, value_name = "S", default_value = "1", value_parser = seconds)]
    stale_s: Duration,
    /// Runs this command of the shell once, when the alarm is raised; its cause is in
    /// SHADOWGAUGE_ALARM. The alarm is no safety function.
    #[arg(long, value_name = "CMD")]
    on_alarm: Option<String>,
    /// Records every frame of the source with its times, angle and z in a new MCAP file, also those
    /// that are left out of the measurement; `replay:FILE.mcap` measures them again. A process that
    /// is killed leaves all but the last quarter of a second.
    #[cfg(feature = "mcap")]
    #[arg(long, value_name = "FILE.mcap")]
    record: Option<PathBuf>,
    /// Reads two windows of every frame, as a camera with two regions does: ROWS rows from row
    /// UPPER on, which show the upper edge, and from row LOWER on the lower one. They alone are
    /// measured and recorded, and a recording states them.
    #[arg(long, value_name = "UPPER,LOWER,ROWS", conflicts_with = "vertical")]
    windows: Option<TwoWindows>,
    /// Threads that decode images (default: all cores).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

/// A source, not yet started, with the policy that it is watched by.
struct Watched {
    producer: Box<dyn Producer>,
    policy: Policy,
    /// Whether a calibration is bound to it.
    of: Option<BoundSource>,
}

impl Watched {
    /// The camera of a camera or a recording, where it is known; `None` for other sources.
    fn bound_to(&self) -> Option<(BoundSource, Option<&CameraBinding>)> {
        self.of.map(|of| (of, self.producer.camera()))
    }

    /// Its frames cut to two windows, where these are given.
    fn windowed(self, windows: Option<TwoWindows>) -> Self {
        match windows {
            Some(windows) => Self { producer: Box::new(Windowed::new(self.producer, windows)), ..self },
            None => self,
        }
    }
}

/// Frames that wait while one is measured.
fn waiting(args: &WatchArgs, policy: Policy) -> usize {
    let most = match policy {
        Policy::Block => WAITING,
        // a bound source delivers the frames of a turn together
        _ if args.encoder.is_given() => OF_A_TURN,
        _ => 1,
    };
    args.waiting.map_or(most, usize::from)
}

/// Runs the command.
///
/// # Errors
/// Exit 2 for arguments that are refused; 3 for a source that cannot be opened or that fails, and
/// where no frame can be measured.
pub(crate) fn run(args: &WatchArgs) -> CommandResult {
    if args.instrument.scale() == Some(ScaleArgument::File) {
        return Err(Failure::refuse(
            "--um-per-px file takes the scale of the first file; of a source that is watched state it, for instance 17.4",
        ));
    }
    let calibration = args.instrument.calibration(&args.frames, &[])?;
    check(args, calibration.as_ref())?;
    let encoder = args.encoder.binding()?;
    let watched = opened(args, encoder.as_ref())?.windowed(args.windows);
    let calibration = args.instrument.bound(calibration, watched.bound_to())?;
    let stream = measuring(args, calibration.as_ref())?;
    if watched.policy == Policy::Block && args.conditions.temperature_cmd.is_some() {
        return Err(Failure::refuse(
            "--temperature-cmd reads the temperature of now: of files and recordings give --temperatures FILE.csv",
        ));
    }
    let beside = beside(args, calibration.as_ref())?;
    let um_per_px = calibration.as_ref().map(|c| 1e3 * c.scale_mm_per_px);
    let begun = |path: &PathBuf| Saved::begin(path, args.save_frames, um_per_px);
    let shown = Shown::new(shown_as(args, calibration.as_ref()), args.save.as_ref().map(begun).transpose()?);
    #[cfg(feature = "mcap")]
    let (watched, recording) = recorded(watched, args.record.as_deref())?;
    let stop = interrupt::requested();
    let settings = LiveSettings { policy: watched.policy, waiting: waiting(args, watched.policy), held: 1 };
    // what is recorded are the frames as the source gives them
    let producer = bound(watched.producer, encoder, watched.policy != Policy::Block);
    let mut live = Live::new(producer, settings).map_err(Failure::fail)?;
    let checks = FrameChecks::new(&args.frames, calibration.as_ref(), args.instrument.scale());
    let settings = session_settings(args, calibration.as_ref());
    let mut session = Session::new(stream, checks, shown, settings, beside);
    let ended = session.watch(&mut live, &stop);
    live.stop();
    let is_alarmed = session.finish(&live.counters());
    let saved = session.end_saving();
    // The producer ends with the source, and with it the recording.
    drop(live);
    #[cfg(feature = "mcap")]
    let saved = recording.map_or(Ok(()), Recording::finish).and(saved);
    match ended {
        Ended::Failed(why) | Ended::Unmeasured(why) => Err(Failure::fail(why)),
        Ended::Done if saved.is_err() => saved.map(|()| Outcome::Done),
        Ended::Done if is_alarmed => Ok(Outcome::OutOfTolerance),
        Ended::Done => Ok(Outcome::Done),
    }
}

/// Refuses arguments that do not go together.
fn check(args: &WatchArgs, calibration: Option<&Calibration>) -> Result<(), Failure> {
    let of_millimetres = [
        args.tolerance.map(|_| "--tolerance"),
        args.settle_s.map(|_| "--settle-s"),
        args.budget.then_some("--budget"),
        args.conditions.needs_scale(),
        args.pin.given(),
    ];
    if let (None, Some(name)) = (calibration, of_millimetres.into_iter().flatten().next()) {
        return Err(Failure::refuse(format!("{name} needs millimetres: give --calibration or --um-per-px")));
    }
    if args.conditions.limits_no_age() {
        return Err(Failure::refuse(
            "--temperature-max-age-s limits the age of temperatures: give --temperatures or --temperature-cmd",
        ));
    }
    Ok(())
}

/// What stands beside the measurement.
fn beside(args: &WatchArgs, calibration: Option<&Calibration>) -> Result<Beside, Failure> {
    let flat = calibration.and_then(|c| c.setup.as_ref()).and_then(|setup| setup.flat_field.as_ref());
    let of = SetupOf {
        black: flat.map_or(0.0, |flat| flat.black_counts),
        has_flat: flat.is_some(),
        is_backlit: !args.bright_on_dark,
        vertical: args.vertical,
    };
    Ok(Beside {
        on_alarm: OnAlarm::new(args.on_alarm.clone()),
        conditions: LiveConditions::open(&args.conditions)?,
        setup: args.setup.then(|| SetupPage::new(of)),
        picture: args.picture.as_deref().map(Picture::begin).transpose()?,
    })
}

fn shown_as(args: &WatchArgs, calibration: Option<&Calibration>) -> ShownAs {
    ShownAs {
        json: args.json,
        judges: args.tolerance.is_some(),
        limits_mm: args.tolerance.map(|tolerance| <[f64; 2]>::from(tolerance.limits_mm())),
        settles: args.settle_s.is_some(),
        unit: if calibration.is_some() { "mm" } else { "px" },
    }
}

fn session_settings(args: &WatchArgs, calibration: Option<&Calibration>) -> SessionSettings {
    let setup = calibration.and_then(|c| c.setup.as_ref());
    SessionSettings {
        idle: args.idle_s,
        stale: args.stale_s,
        name: shown_name(args),
        turning: args.turning,
        vertical: args.vertical,
        scale: calibration.map_or(1.0, |c| c.scale_mm_per_px),
        corrects: setup.is_some_and(|setup| setup.flat_field.is_some()),
    }
}

/// The source with its frames recorded, where that is wanted.
#[cfg(feature = "mcap")]
fn recorded(watched: Watched, path: Option<&Path>) -> Result<(Watched, Option<Recording>), Failure> {
    let Some(path) = path else { return Ok((watched, None)) };
    let Watched { producer, policy, of } = watched;
    let (producer, recording) = Recording::begin(producer, path, policy == Policy::Block)?;
    Ok((Watched { producer, policy, of }, Some(recording)))
}

fn shown_name(args: &WatchArgs) -> String {
    match args.source.to_string_lossy().as_ref() {
        "-" | "raw:-" => "stdin".to_owned(),
        other => other.to_owned(),
    }
}

/// What measures the frames.
fn measuring(args: &WatchArgs, calibration: Option<&Calibration>) -> Result<Stream, Failure> {
    let polarity = if args.bright_on_dark { Polarity::BrightOnDark } else { Polarity::DarkOnBright };
    let esf = edge_model(None, calibration);
    let mut settings = GaugeSettings { polarity, esf, ..GaugeSettings::default() };
    settings.min_diameter_px = args.min_diameter_px.unwrap_or(settings.min_diameter_px);
    let gauge = Gauge::calibrated(settings, calibration).map_err(failure)?;
    let conditions = args.instrument.conditions(calibration)?;
    let settings = MeasureSettings {
        vertical: args.vertical,
        tolerance: args.tolerance,
        conformance_probability: args.conformance_probability,
        accept_blur: args.accept_blur,
        settle_s: args.settle_s.map(|settle| settle.as_secs_f64()),
        budget: args.budget,
        ..MeasureSettings::default()
    };
    let stream = match calibration {
        Some(calibration) => Stream::new(&gauge, calibration, &conditions, settings),
        None => Stream::in_pixels(&gauge, settings),
    };
    let mut stream = stream.map_err(failure)?;
    if let Some(pin) = args.pin.reference_pin {
        stream = stream.with_reference_pin(&gauge, pin).map_err(failure)?;
    }
    if args.turning {
        stream.settle_by_turns();
    }
    Ok(stream)
}

/// Opens the source. Files and pipes from files wait; what comes by itself does not.
fn opened(args: &WatchArgs, encoder: Option<&Binding>) -> Result<Watched, Failure> {
    let all = || std::thread::available_parallelism().map_or(1, usize::from);
    let threads = args.threads.map_or_else(all, usize::from);
    let read = Reading::new(args.frames.channel(), threads, true);
    let Some(stream) = StreamSource::of(&args.source, &args.stream)? else {
        return opened_path(args, &read);
    };
    args.encoder.in_table(true)?;
    if !stream.has_times() {
        check_untimed(encoder)?;
    }
    let policy = if stream.is_file() { Policy::Block } else { Policy::DropOldest };
    let of = stream.bound_source();
    Ok(Watched { producer: stream.producer(&read)?, policy, of })
}

fn opened_path(args: &WatchArgs, read: &Reading) -> Result<Watched, Failure> {
    let path = &args.source;
    let in_table = args.encoder.in_table(path.is_dir())?;
    let (frames, policy) = if path.is_dir() {
        (read.followed(path.to_owned(), None)?, Policy::DropOldest)
    } else {
        (read.files(paths(&[path.to_owned()])?, in_table)?, Policy::Block)
    };
    Ok(Watched { producer: Box::new(StoredProducer::new(frames)), policy, of: None })
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use super::*;

    #[derive(clap::Parser)]
    struct Command {
        #[command(flatten)]
        args: WatchArgs,
    }

    #[test]
    fn as_many_frames_wait_as_are_stated_or_as_suits_the_source() {
        let of = |more: &[&str], policy: Policy| {
            let all = ["watch", "incoming"].iter().chain(more);
            waiting(&Command::try_parse_from(all).unwrap_or_else(|e| panic!("{e}")).args, policy)
        };
        assert_eq!(of(&[], Policy::DropOldest), 1);
        assert_eq!(of(&[], Policy::Block), WAITING);
        for policy in [Policy::DropOldest, Policy::Block] {
            assert_eq!(of(&["--waiting", "3"], policy), 3);
        }
    }
}
