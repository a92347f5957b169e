//! `shadowgauge run`: cut, render, measure, correct, pass after pass, into a run folder; and the
//! same without control beside it.
//!
//! In: a job. Out: a run folder with its report; the exit code is that of the finished part.
//! Arguments → job → `recorder` (cell and controller, pass after pass) → `tables` (what each pass
//! leaves, read back when a run is resumed) → report → `finished` (what is printed). `frames_from`
//! is a renderer, a recording or a `wire_head`: a job that names a `source` takes its frames from
//! there and, of a recording, ends `waiting` where the next pass is not there yet; `recording`
//! writes such a folder. `model` makes a job of a part's STL file.

mod finished;
pub(super) mod frames_from;
pub(super) mod model;
mod recorder;
mod recording;
mod tables;
mod waiting;
mod wire_head;

use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::config;
use crate::control::{ControllerName, OnAlarm};
use crate::files::OutputFolder;
use crate::job::Job;
use crate::job::ScanWhen;
use crate::render::BackendChoice;
use crate::report::{self, RunView};
use crate::run_folder::RunFolder;
use crate::studies::head::limb::limb_of_run;

use self::finished::Finished;
use self::frames_from::FramesFrom;
use self::recorder::{Recorded, Recorder};
use crate::cli::failure::{CommandResult, Failure, folder_failure};
use crate::cli::process::interrupt;
use crate::cli::store::args::StoreArgs;

/// Folder of the uncontrolled run below the controlled one.
pub(crate) const REFERENCE_FOLDER: &str = "without_control";

/// Arguments of `run`.
#[derive(Debug, clap::Args)]
pub(crate) struct RunArgs {
    /// The job; or a model of a part (.stl), of which a job with default cutting and camera is
    /// made.
    config: PathBuf,
    /// Run folder: absent, empty, or an unfinished run of the same config, which is resumed.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Cut only the first N passes.
    #[arg(long, value_name = "N")]
    passes: Option<usize>,
    /// none, pid, lsq, …: in place of the config's.
    #[arg(long, value_name = "NAME")]
    controller: Option<ControllerName>,
    /// In place of the config's.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Where frames are rendered; auto takes a hardware adapter, else the CPU path (a software
    /// adapter only by name).
    #[arg(long, value_enum, default_value_t = BackendChoice::Auto)]
    backend: BackendChoice,
    /// Write the frames of the run into this folder (absent or empty), where `source` of a config
    /// finds them.
    #[arg(long, value_name = "DIR")]
    record: Option<PathBuf>,
    /// Leave out the second run without control that the report shows beside.
    #[arg(long)]
    no_reference: bool,
    /// Print the passes as JSON on stdout.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    model: model::ModelArgs,
    #[command(flatten)]
    store: StoreArgs,
}

/// Runs the job of a config file.
///
/// # Errors
/// Exit 2 for a config, a command line or an output folder that is refused; 3 for a device or a
/// disk that fails.
pub(crate) fn run(args: &RunArgs) -> CommandResult {
    let job = job_of(args)?;
    interrupt::end_with(format!(
        "interrupted: finished passes are kept in {}. The same command line resumes the run:\n    {}",
        args.out.display(),
        interrupt::command_line()
    ));
    let from = FramesFrom::source(&job, &args.config, &|e| refused(args, e))?;
    let from = from.map_or_else(|| FramesFrom::simulation(args.backend), Ok)?;
    let record = args.record.as_deref().map(|path| claim_record(&job, &from, path)).transpose()?;
    let how =
        Execution { from: &from, reference: !args.no_reference, record: record.as_ref(), store: &args.store };
    let finished = execute(&job, &args.out, &how)?;
    if let Some(record) = record {
        record.finish()?;
    }
    if args.json {
        say_line!("{}", finished.to_json());
    } else {
        say!("{}", finished.to_table());
        if !finished.is_waiting() {
            say_line!("report: {}", args.out.join("report.html").display());
        }
    }
    Ok(finished.outcome())
}

/// A refusal of a key of the config.
fn refused(args: &RunArgs, error: crate::setting::SettingError) -> Failure {
    let name = args.config.display().to_string();
    match text_of(args) {
        Ok(text) => Failure::refused(config::value_error(&text, &name, error)),
        Err(unread) => unread,
    }
}

/// The folder of `--record`, claimed.
fn claim_record(job: &Job, from: &FramesFrom, path: &Path) -> Result<OutputFolder, Failure> {
    let is_followed = job.scan.when == ScanWhen::DuringCut;
    let why = match () {
        () if from.is_recorded() => "the frames of this run are recorded already (source)",
        () if job.probe.is_some() => "a run with [probe] takes no frames",
        () if is_followed => {
            "scan.when = \"during_cut\": frames are recorded of a part that was cut (after_pass)"
        }
        () if job.camera.windows.is_some() => "camera.windows: frames of two windows are not recorded",
        () => return Ok(OutputFolder::claim(path)?),
    };
    Err(Failure::refuse(format!("--record: {why}")))
}

/// The text of a config, or that of the job that a model makes.
fn text_of(args: &RunArgs) -> Result<String, Failure> {
    if model::is_model(&args.config) {
        return model::job_text(&args.config, &args.model);
    }
    args.model.only_for_models(&args.config)?;
    config::read_text(&args.config).map_err(Failure::refused)
}

/// The checked job of a command line.
fn job_of(args: &RunArgs) -> Result<Job, Failure> {
    let text = text_of(args)?;
    let name = args.config.display().to_string();
    let mut job = if model::is_model(&args.config) {
        // files of the command line are named from where it was given
        config::load_text(&text, &name, Path::new("")).map_err(Failure::refused)?
    } else {
        config::load(&args.config).map_err(Failure::refused)?
    };
    job.passes = args.passes.or(job.passes);
    job.control.controller = args.controller.unwrap_or(job.control.controller);
    job.seed = args.seed.unwrap_or(job.seed);
    job.check()
        .and_then(|()| job.check_coverage())
        .and_then(|()| job.check_control())
        .map_err(|e| Failure::refused(config::value_error(&text, &name, e)))?;
    job.cautions().iter().for_each(|word| tracing::warn!("{name}: {word}"));
    if let Some(limb) = limb_of_run(&job).map_err(|e| Failure::refuse(format!("{name}: {e}")))? {
        tracing::info!("{name}: the limbs of the part are corrected against the masters' ([scan.limb])");
        job.scan.limb = Some(limb);
    }
    Ok(job)
}

/// How a job is run.
pub(crate) struct Execution<'a> {
    /// Where its frames come from.
    pub(crate) from: &'a FramesFrom,
    /// Whether the same is run without control beside it, where that is simulated.
    pub(crate) reference: bool,
    /// Where its frames are written.
    pub(crate) record: Option<&'a OutputFolder>,
    /// Where its passes are stored.
    pub(crate) store: &'a StoreArgs,
}

/// Writes what the displacement probe of `[machine]` indicates of the passes whose truth is known.
fn write_probe(job: &Job, folder: &RunFolder) -> Result<(), Failure> {
    if job.machine.as_ref().is_none_or(|machine| machine.probe.is_none()) {
        return Ok(());
    }
    let stations = folder.stations().map_err(folder_failure)?;
    let mut rows = Vec::new();
    for of_pass in stations.chunk_by(|a, b| a.pass == b.pass) {
        let truth: Option<Vec<f64>> = of_pass.iter().map(|station| station.true_d_mm).collect();
        if let (Some(truth), Some(first)) = (truth, of_pass.first()) {
            rows.extend(job.probe_rows(first.pass, &truth).map_err(Failure::refuse)?);
        }
    }
    if rows.is_empty() { Ok(()) } else { folder.write_machine_probe(&rows).map_err(folder_failure) }
}

/// Runs a checked job into `out`, and the same without control into a folder below it. A run that
/// waits for frames has no report yet: its folder is unfinished, and the same command resumes it.
///
/// # Errors
/// As [`run`].
pub(crate) fn execute(job: &Job, out: &Path, how: &Execution<'_>) -> Result<Finished, Failure> {
    let folder = claim(job, out)?;
    let start = Instant::now();
    let controlled = job.control.controller != ControllerName::None;
    let reference = how.reference && controlled && how.from.is_simulated();
    let (main, reference) = run_both(job, &folder, how, reference)?;
    if main.waits.is_none() {
        let machine = job.machine_rows(main.passes.len()).map_err(Failure::refuse)?;
        if !machine.is_empty() {
            folder.write_machine(&machine).map_err(folder_failure)?;
        }
        write_probe(job, &folder)?;
        let adapter = how.from.adapter();
        let page = report::run_report(&main.view(job, (&folder, reference.as_ref()), (how.from, &adapter)));
        let page = page.map_err(Failure::fail)?;
        for (name, bytes) in &page.files {
            folder.write(name, bytes).map_err(folder_failure)?;
        }
        folder.write("report.html", page.html.as_bytes()).map_err(folder_failure)?;
    }
    tracing::info!(seconds = start.elapsed().as_secs_f64(), "finished");
    Ok(Finished {
        job: job.clone(),
        backend: how.from.backend().to_owned(),
        adapter: how.from.adapter(),
        verdict: main.verdict,
        stopped: main.stopped,
        waits: main.waits,
        seconds: main.seconds,
        passes: main.passes,
        axis: main.axis,
        sections: main.sections,
        reference: reference.map(|r| r.passes().unwrap_or_default()),
    })
}

/// The run and, in parallel, the one without control: while one waits for the device, the other
/// computes silhouettes, measures and writes.
fn run_both(
    job: &Job,
    folder: &RunFolder,
    how: &Execution<'_>,
    reference: bool,
) -> Result<(Recorded, Option<RunFolder>), Failure> {
    std::thread::scope(|scope| {
        let beside = reference.then(|| scope.spawn(|| run_reference(job, folder.path(), how.from)));
        let main = Recorder::new(job, folder, how.from, how.record)
            .and_then(|recorder| recorder.with_store(how.store.open()?))
            .and_then(|recorder| recorder.run(true));
        let beside = beside.map(|thread| {
            thread.join().unwrap_or_else(|_| Err(Failure::fail("the run without control broke off")))
        });
        Ok((main?, beside.transpose()?))
    })
}

/// The same job without control, in a folder of its own: a second real run.
fn run_reference(job: &Job, out: &Path, from: &FramesFrom) -> Result<RunFolder, Failure> {
    let mut uncontrolled = job.clone();
    uncontrolled.control.controller = ControllerName::None;
    uncontrolled.control.guards.on_alarm = OnAlarm::GoOn;
    let path = out.join(REFERENCE_FOLDER);
    let folder = match claim(&uncontrolled, &path) {
        Err(_) if RunFolder::is_run(&path) => return RunFolder::open(&path).map_err(folder_failure),
        claimed => claimed?,
    };
    let done = Recorder::new(&uncontrolled, &folder, from, None)?.run(false)?;
    let adapter = from.adapter();
    let page = report::run_report(&done.view(&uncontrolled, (&folder, None), (from, &adapter)));
    let page = page.map_err(Failure::fail)?;
    folder.write("report.html", page.html.as_bytes()).map_err(folder_failure)?;
    Ok(folder)
}

impl Recorded {
    /// What its report is made from; `folders`: its own and, where there is one, that of the run
    /// without control.
    fn view<'a>(
        &'a self,
        job: &'a Job,
        folders: (&'a RunFolder, Option<&'a RunFolder>),
        (from, adapter): (&'a FramesFrom, &'a str),
    ) -> RunView<'a> {
        RunView {
            job,
            folder: folders.0,
            reference: folders.1,
            backend: from.backend(),
            adapter,
            sample: self.sample.as_ref(),
            form: self.form.as_ref(),
        }
    }
}

fn claim(job: &Job, out: &Path) -> Result<RunFolder, Failure> {
    let resolved = config::resolved(job).map_err(Failure::fail)?;
    let hash = config::hash(job).map_err(Failure::fail)?;
    RunFolder::claim(out, &hash, &resolved).map_err(folder_failure)
}
