//! `shadowgauge run`: cut, render, measure, correct, pass after pass, into a run folder; and the
//! same without control beside it.
//!
//! In: a job. Out: a run folder with its report; the exit code is that of the finished part.
//! Arguments → job → `recorder` (cell and controller, pass after pass) → `tables` (what each pass
//! leaves, read back when a run is resumed) → report → `finished` (what is printed).

mod finished;
mod recorder;
mod tables;

use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::config;
use crate::control::{ControllerName, OnAlarm};
use crate::job::Job;
use crate::render::{BackendChoice, Renderer};
use crate::report::{self, RunView};
use crate::run_folder::RunFolder;

use self::finished::Finished;
use self::recorder::{Recorded, Recorder};
use crate::cli::failure::{CommandResult, Failure, folder_failure};
use crate::cli::process::interrupt;

/// Folder of the uncontrolled run below the controlled one.
pub(crate) const REFERENCE_FOLDER: &str = "without_control";

/// Arguments of `run`.
#[derive(Debug, clap::Args)]
pub(crate) struct RunArgs {
    /// The job.
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
    /// Leave out the second run without control that the report shows beside.
    #[arg(long)]
    no_reference: bool,
    /// Print the passes as JSON on stdout.
    #[arg(long)]
    json: bool,
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
    let finished = execute(&job, &args.out, args.backend, !args.no_reference)?;
    if args.json {
        say_line!("{}", finished.to_json());
    } else {
        say!("{}", finished.to_table());
        say_line!("report: {}", args.out.join("report.html").display());
    }
    Ok(finished.outcome())
}

/// The checked job of a command line.
fn job_of(args: &RunArgs) -> Result<Job, Failure> {
    let text = config::read_text(&args.config).map_err(Failure::refused)?;
    let name = args.config.display().to_string();
    let mut job = config::load(&args.config).map_err(Failure::refused)?;
    job.passes = args.passes.or(job.passes);
    job.control.controller = args.controller.unwrap_or(job.control.controller);
    job.seed = args.seed.unwrap_or(job.seed);
    job.check()
        .and_then(|()| job.check_coverage())
        .and_then(|()| job.check_control())
        .map_err(|e| Failure::refused(config::value_error(&text, &name, e)))?;
    job.cautions().iter().for_each(|word| tracing::warn!("{name}: {word}"));
    Ok(job)
}

/// Runs a checked job into `out`; with `reference`, the same without control into a folder below
/// it.
///
/// # Errors
/// As [`run`].
pub(crate) fn execute(
    job: &Job,
    out: &Path,
    backend: BackendChoice,
    reference: bool,
) -> Result<Finished, Failure> {
    let folder = claim(job, out)?;
    let renderer = Renderer::new(backend).map_err(Failure::fail)?;
    tracing::info!(backend = renderer.backend_name(), adapter = renderer.adapter_name(), "rendering");
    let start = Instant::now();
    let reference = reference && job.control.controller != ControllerName::None;
    let (main, reference) = run_both(job, &folder, &renderer, reference)?;
    let page = report::run_report(&main.view(job, (&folder, reference.as_ref()), &renderer));
    let page = page.map_err(Failure::fail)?;
    tracing::info!(seconds = start.elapsed().as_secs_f64(), "finished");
    for (name, bytes) in &page.files {
        folder.write(name, bytes).map_err(folder_failure)?;
    }
    folder.write("report.html", page.html.as_bytes()).map_err(folder_failure)?;
    Ok(Finished {
        job: job.clone(),
        backend: renderer.backend_name().to_owned(),
        adapter: renderer.adapter_name().to_owned(),
        verdict: main.verdict,
        stopped: main.stopped,
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
    renderer: &Renderer,
    reference: bool,
) -> Result<(Recorded, Option<RunFolder>), Failure> {
    std::thread::scope(|scope| {
        let beside = reference.then(|| scope.spawn(|| run_reference(job, folder.path(), renderer)));
        let main = Recorder::new(job, folder, renderer).and_then(|recorder| recorder.run(true));
        let beside = beside.map(|thread| {
            thread.join().unwrap_or_else(|_| Err(Failure::fail("the run without control broke off")))
        });
        Ok((main?, beside.transpose()?))
    })
}

/// The same job without control, in a folder of its own: a second real run.
fn run_reference(job: &Job, out: &Path, renderer: &Renderer) -> Result<RunFolder, Failure> {
    let mut uncontrolled = job.clone();
    uncontrolled.control.controller = ControllerName::None;
    uncontrolled.control.guards.on_alarm = OnAlarm::GoOn;
    let path = out.join(REFERENCE_FOLDER);
    let folder = match claim(&uncontrolled, &path) {
        Err(_) if RunFolder::is_run(&path) => return RunFolder::open(&path).map_err(folder_failure),
        claimed => claimed?,
    };
    let done = Recorder::new(&uncontrolled, &folder, renderer)?.run(false)?;
    let page = report::run_report(&done.view(&uncontrolled, (&folder, None), renderer));
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
        renderer: &'a Renderer,
    ) -> RunView<'a> {
        RunView {
            job,
            folder: folders.0,
            reference: folders.1,
            backend: renderer.backend_name(),
            adapter: renderer.adapter_name(),
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
