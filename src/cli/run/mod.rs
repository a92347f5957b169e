//! `shadowgauge run`: cut, render, measure, correct, pass after pass, into a run folder; and the
//! same without control beside it.
//!
//! In: a job. Out: a run folder with its report; the exit code is that of the finished part.
//! `recorder` writes the results of each pass and reads them back when a run is resumed.

mod recorder;

use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::config;
use crate::conformity::part_verdict::{PartConformity, Verdict};
use crate::control::{ControllerName, OnAlarm};
use crate::job::Job;
use crate::render::{BackendChoice, Renderer};
use crate::report;
use crate::run_folder::{AxisRow, PassRow, RunFolder, axis_json};

use self::recorder::{Recorded, Recorder};
use crate::cli::failure::{CommandResult, Failure, Outcome, folder_failure};

/// Folder of the uncontrolled run below the controlled one.
pub const REFERENCE_FOLDER: &str = "without_control";

/// Arguments of `run`.
#[derive(Debug, clap::Args)]
pub struct RunArgs {
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
pub fn run(args: &RunArgs) -> CommandResult {
    let text = std::fs::read_to_string(&args.config)
        .map_err(|cause| Failure::refused(config::ConfigError::Read { path: args.config.clone(), cause }))?;
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
    let finished = execute(&job, &args.out, args.backend, !args.no_reference)?;
    if args.json {
        say_line!("{}", finished.to_json());
    } else {
        say!("{}", finished.to_table());
        say_line!("report: {}", args.out.join("report.html").display());
    }
    Ok(finished.outcome())
}

/// Result of a finished run.
pub struct Finished {
    job: Job,
    backend: String,
    adapter: String,
    passes: Vec<PassRow>,
    axis: Vec<AxisRow>,
    reference: Option<Vec<PassRow>>,
    seconds: Vec<(f64, f64)>,
    verdict: Option<Verdict>,
    stopped: Option<String>,
}

/// Runs a checked job into `out`; with `reference`, the same without control into a folder below
/// it.
///
/// # Errors
/// As [`run`].
pub fn execute(job: &Job, out: &Path, backend: BackendChoice, reference: bool) -> Result<Finished, Failure> {
    let folder = claim(job, out)?;
    let renderer = Renderer::new(backend).map_err(Failure::fail)?;
    tracing::info!(backend = renderer.backend_name(), adapter = renderer.adapter_name(), "rendering");
    let start = Instant::now();
    let reference = reference && job.control.controller != ControllerName::None;
    let (main, reference) = run_both(job, &folder, &renderer, reference)?;
    let page = report::run_report(&report::RunView {
        job,
        folder: &folder,
        reference: reference.as_ref(),
        backend: renderer.backend_name(),
        adapter: renderer.adapter_name(),
        sample: main.sample.as_ref(),
        form: main.form.as_ref(),
    })
    .map_err(Failure::fail)?;
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
    let page = report::run_report(&report::RunView {
        job: &uncontrolled,
        folder: &folder,
        reference: None,
        backend: renderer.backend_name(),
        adapter: renderer.adapter_name(),
        sample: done.sample.as_ref(),
        form: done.form.as_ref(),
    })
    .map_err(Failure::fail)?;
    folder.write("report.html", page.html.as_bytes()).map_err(folder_failure)?;
    Ok(folder)
}

fn claim(job: &Job, out: &Path) -> Result<RunFolder, Failure> {
    let resolved = config::resolved(job).map_err(Failure::fail)?;
    let hash = config::hash(job).map_err(Failure::fail)?;
    RunFolder::claim(out, &hash, &resolved).map_err(folder_failure)
}

impl Finished {
    fn outcome(&self) -> Outcome {
        let proven = self.verdict.as_ref().is_none_or(|v| v.part() == PartConformity::Conforms);
        if !proven || self.stopped.is_some() { Outcome::OutOfTolerance } else { Outcome::Done }
    }

    fn to_json(&self) -> serde_json::Value {
        let rows = |rows: &[PassRow], seconds: &[(f64, f64)]| -> Vec<serde_json::Value> {
            rows.iter()
                .enumerate()
                .map(|(i, p)| {
                    let (render_s, gauge_s) = seconds.get(i).copied().unwrap_or((0.0, 0.0));
                    serde_json::json!({
                        "pass": p.pass, "nominal_mm": p.nominal_mm, "max_abs_error_mm": p.max_abs_error_mm,
                        "rms_error_mm": p.rms_error_mm, "true_max_abs_error_mm": p.true_max_abs_error_mm,
                        "worst_measured_minus_true_mm": p.worst_measured_minus_true_mm,
                        "rms_error_over_u": p.rms_error_over_u, "frames": p.frames, "decision": p.decision,
                        "radial_force_n": p.radial_force_n, "tangential_force_n": p.tangential_force_n,
                        "feed_force_n": p.feed_force_n, "deflection_um": p.deflection_um,
                        "tangential_error_um": p.tangential_error_um, "feed_mark_um": p.feed_mark_um,
                        "render_s": render_s, "gauge_s": gauge_s,
                    })
                })
                .collect()
        };
        let mut passes = rows(&self.passes, &self.seconds);
        for (json, row) in passes.iter_mut().zip(&self.passes) {
            json["axis"] = axis_json(&self.axis, row.pass);
        }
        let mut json = serde_json::json!({
            "controller": self.job.control.controller.as_str(),
            "backend": self.backend,
            "adapter": self.adapter,
            "passes": passes,
            "in_tolerance": self.verdict.as_ref().map(|v| v.part() == PartConformity::Conforms),
            "conformity": self.verdict.as_ref().map(Verdict::part),
            // For one version also under the name that `measure` uses for GO, HI, …
            "judgement": self.verdict.as_ref().map(Verdict::part),
            "alarm": self.verdict.as_ref().and_then(|v| v.alarm.clone()),
            "stopped": self.stopped,
        });
        if let Some(reference) = &self.reference {
            json["without_control"] = serde_json::json!({ "passes": rows(reference, &[]) });
        }
        json
    }

    /// The passes as a table for a terminal.
    pub fn to_table(&self) -> String {
        let um = |mm: f64| format!("{:.2}", mm * 1e3);
        let mut text = format!(
            "{}: controller {}, {} ({})\n\n pass  nominal/mm  max |e|/µm  true max |e|/µm  measured-true/µm  rms(error/u)  none: true max |e|/µm\n",
            self.job.name,
            self.job.control.controller.as_str(),
            self.backend,
            self.adapter
        );
        for (i, p) in self.passes.iter().enumerate() {
            let beside = self
                .reference
                .as_ref()
                .and_then(|r| r.get(i))
                .map_or("-".to_owned(), |r| um(r.true_max_abs_error_mm));
            text += &format!(
                " {:>4}  {:>10.4}  {:>10}  {:>15}  {:>16}  {:>12.2}  {beside:>21}\n",
                p.pass,
                p.nominal_mm,
                um(p.max_abs_error_mm),
                um(p.true_max_abs_error_mm),
                um(p.worst_measured_minus_true_mm),
                p.rms_error_over_u
            );
        }
        if let Some(stopped) = &self.stopped {
            text += &format!("\nALARM, {stopped}\n");
        }
        if let Some(verdict) = &self.verdict {
            text += &format!("\n{}\n", verdict.words());
        }
        text
    }
}
