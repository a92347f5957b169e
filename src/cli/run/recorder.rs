//! Runs a job pass by pass and writes each pass into its folder as soon as it is finished: cell and
//! controller in a closed loop → passes → tables → files.

use std::path::PathBuf;

use indicatif::ProgressBar;

use crate::closed_loop::{Calibrated, ClosedLoop, LoopError, PassResult, Sample, part_verdict};
use crate::conformity::part_verdict::Verdict;
use crate::control::OnAlarm;
use crate::files::OutputFolder;
use crate::gauge::diameter::sections::PartForm;
use crate::job::Job;
use crate::plan::Decision;
use crate::run_folder::{AxisRow, PassRow, RunFolder, SectionResults, profile_of};
use crate::store::Store;

use super::frames_from::FramesFrom;
use super::recording::RecordingCell;
use super::tables::RunTables;
use super::waiting::Waiting;
use crate::cli::failure::{Failure, folder_failure};
use crate::cli::store::of_run::{PassTables, RunStore};
use crate::cli::terminal::progress;

/// The results of a recorded run in memory.
pub(crate) struct Recorded {
    /// One row per pass.
    pub passes: Vec<PassRow>,
    /// Rendering and measuring time of the passes of this process, s.
    pub seconds: Vec<(f64, f64)>,
    /// The frame kept from the last pass.
    pub sample: Option<Sample>,
    /// Form of the part after the last pass of this process.
    pub form: Option<PartForm>,
    /// Axis of the part after every pass.
    pub axis: Vec<AxisRow>,
    /// Verdict over all stations of the last pass, where a tolerance is given and the last pass was
    /// cut.
    pub verdict: Option<Verdict>,
    /// Results of the last pass by section, of a stepped shaft.
    pub sections: Option<SectionResults>,
    /// Why not all passes were cut: an alarm.
    pub stopped: Option<String>,
    /// The pass whose frames are missing, of a recorded run.
    pub waits: Option<Waiting>,
}

/// A run being written.
pub(crate) struct Recorder<'a> {
    job: &'a Job,
    folder: &'a RunFolder,
    from: &'a FramesFrom,
    chain: ClosedLoop<'a>,
    run_id: String,
    tables: RunTables,
    store: Option<RunStore>,
}

impl<'a> Recorder<'a> {
    /// Calibrates the gauge, or resumes an unfinished run.
    ///
    /// # Errors
    /// Where the job, the device or the folder fails.
    pub(crate) fn new(
        job: &'a Job,
        folder: &'a RunFolder,
        from: &'a FramesFrom,
        record: Option<&'a OutputFolder>,
    ) -> Result<Self, Failure> {
        let mut tables = RunTables::read(folder)?;
        let is_resumed = !tables.passes.is_empty();
        let mut cell = from.cell(job)?;
        if let Some(record) = record {
            if is_resumed {
                return Err(Failure::refuse(
                    "--record: this run is resumed, the frames of its first passes are gone",
                ));
            }
            let um_per_px = job.setup_settings().nominal_pixel_mm() * 1e3;
            cell = Box::new(RecordingCell::new(cell, record, um_per_px));
        }
        let calibration = if is_resumed { Some(read_calibration(folder)?) } else { from.calibration()? };
        from.check_bound(calibration.as_ref()).map_err(|why| {
            let name = folder.path().join("calibration.json");
            Failure::fail(format!("{} (of this unfinished run): {why}", name.display()))
        })?;
        let settings = job.checked_loop().map_err(|e| loop_failure(e.into()))?;
        let settings = from.with_edge_model(settings, calibration.as_ref());
        let mut chain = ClosedLoop::start(settings, cell, calibration).map_err(loop_failure)?;
        let json = serde_json::to_string_pretty(&from.bound(chain.calibration())).map_err(Failure::fail)?;
        folder.write("calibration.json", json.as_bytes()).map_err(folder_failure)?;
        resume(&mut chain, &mut tables)?;
        let run_id = crate::config::hash(job).map_err(Failure::fail)?.chars().take(12).collect();
        Ok(Self { job, folder, from, chain, run_id, tables, store: None })
    }

    /// Stores the passes, too: those of an unfinished run at once.
    ///
    /// # Errors
    /// As the store refuses.
    pub(crate) fn with_store(mut self, store: Option<Store>) -> Result<Self, Failure> {
        let begin = |store| {
            let calibration =
                serde_json::to_string(&self.from.bound(self.chain.calibration())).map_err(Failure::fail)?;
            RunStore::begin(store, self.job, &calibration)
        };
        self.store = store.map(begin).transpose()?;
        self.acknowledge()?;
        Ok(self)
    }

    /// Stores what the tables hold and the store does not.
    fn acknowledge(&mut self) -> Result<(), Failure> {
        let tables = PassTables {
            passes: &self.tables.passes,
            stations: &self.tables.stations,
            offsets: &self.tables.offsets,
            control: &self.tables.control,
        };
        self.store.as_mut().map_or(Ok(0), |store| store.acknowledge(&tables)).map(|_| ())
    }

    /// Runs the remaining passes; `shown` shows a bar on a terminal.
    ///
    /// # Errors
    /// Where a cut, a frame or the disk fails; finished passes stay readable.
    pub(crate) fn run(mut self, shown: bool) -> Result<Recorded, Failure> {
        let mut seconds = vec![(0.0, 0.0); self.tables.passes.len()];
        let (mut sample, mut form) = (None, None);
        let (mut stopped, mut waits) = (None, None);
        while let Some(pass) = self.chain.next_pass() {
            if let Some(alarm) = self.chain.alarm().filter(|_| self.stops()) {
                tracing::error!("stopped before pass {pass}: {alarm}");
                stopped = Some(format!("stopped before pass {pass}: {alarm}"));
                break;
            }
            if let Some(missing) = self.from.missing(pass) {
                waits = Some(self.wait_for(pass, missing)?);
                break;
            }
            self.chain.begin().map_err(loop_failure)?;
            let bar = progress_bar(shown, &format!("pass {pass} of {}", self.job.loop_job().passes()));
            self.tables.add_offsets(&self.chain);
            let result = self
                .chain
                .run_pass(&mut |done, of| {
                    bar.set_length(of as u64);
                    bar.set_position(done as u64);
                })
                .map_err(loop_failure)?;
            bar.finish_and_clear();
            for refused in &result.refused {
                tracing::warn!("pass {pass}: {refused}");
            }
            // The run without correction is expected to be out of tolerance.
            if shown {
                log_decision(&result);
            }
            seconds.push((result.render.as_secs_f64(), result.gauge.as_secs_f64()));
            self.tables.add(&result, &self.chain);
            self.tables.write(self.folder, &self.run_id)?;
            self.acknowledge()?;
            self.write_timings(&seconds)?;
            form = Some(result.form);
            sample = result.sample.or(sample);
        }
        let verdict = self.verdict();
        let sections = self.tables.sections(&self.job.loop_job());
        let RunTables { passes, axis, .. } = self.tables;
        Ok(Recorded { passes, seconds, sample, form, axis, verdict, sections, stopped, waits })
    }

    /// Writes the offsets of a pass that is still to be cut; the stock is scanned first, where the
    /// job requires it.
    fn wait_for(&mut self, pass: u32, folder: PathBuf) -> Result<Waiting, Failure> {
        self.chain.begin().map_err(loop_failure)?;
        self.tables.add_offsets(&self.chain);
        self.tables.write(self.folder, &self.run_id)?;
        let offsets = self.tables.offsets.iter().filter(|row| row.pass == pass).cloned().collect();
        Ok(Waiting { pass, folder, offsets })
    }

    fn stops(&self) -> bool {
        self.job.control.guards.on_alarm == OnAlarm::Stop
    }

    fn write_timings(&self, seconds: &[(f64, f64)]) -> Result<(), Failure> {
        let passes: Vec<_> = seconds
            .iter()
            .enumerate()
            .map(|(i, (render_s, gauge_s))| serde_json::json!({"pass": i + 1, "render_s": render_s, "gauge_s": gauge_s}))
            .collect();
        let json = serde_json::json!({ "passes": passes });
        self.folder.write("timings.json", format!("{json:#}\n").as_bytes()).map_err(folder_failure)
    }

    fn verdict(&self) -> Option<Verdict> {
        let last = self.job.part.passes();
        let finished = self.tables.passes.len() == last;
        finished
            .then(|| part_verdict(&self.job.loop_job(), &profile_of(last as u32, &self.tables.stations)))
            .flatten()
    }
}

fn log_decision(result: &PassResult) {
    let pass = result.plan.pass;
    if let Some(Decision::Held(reason)) = &result.decision {
        tracing::warn!("pass {pass}: the last offsets hold: {reason}");
    }
    if let Some(alarm) = &result.alarm {
        tracing::error!("pass {pass}: alarm: {alarm}");
    }
    for note in &result.notes {
        tracing::info!("pass {pass}: {note}");
    }
}

/// Takes the passes that are finished up into the loop.
fn resume(chain: &mut ClosedLoop<'_>, tables: &mut RunTables) -> Result<(), Failure> {
    if !tables.passes.is_empty() {
        chain.resume_stock(tables.control.stock.clone());
    }
    let finished: Vec<u32> = tables.passes.iter().map(|row| row.pass).collect();
    for pass in finished {
        tables.add_offsets(chain);
        let evidence = tables.control.evidence(pass);
        chain.replay(&profile_of(pass, &tables.stations), &evidence).map_err(loop_failure)?;
    }
    Ok(())
}

fn read_calibration(folder: &RunFolder) -> Result<Calibrated, Failure> {
    let text = folder.read_text("calibration.json").map_err(folder_failure)?;
    serde_json::from_str(&text)
        .map_err(|e| Failure::fail(format!("{}: {e}", folder.path().join("calibration.json").display())))
}

/// Exit 2 for a job or a controller that is refused, 3 for everything else.
fn loop_failure(error: LoopError) -> Failure {
    match error {
        LoopError::Setting(_) | LoopError::Control(_) => Failure::refuse(error),
        other => Failure::fail(chain_text(&other)),
    }
}

fn chain_text(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(inner) = cause {
        let more = inner.to_string();
        if !text.contains(&more) {
            text = format!("{text}: {more}");
        }
        cause = inner.source();
    }
    text
}

/// A bar on a terminal, nothing elsewhere; its length is that of the scan, known once it has begun.
fn progress_bar(shown: bool, what: &str) -> ProgressBar {
    if shown { progress::bar(0, what, "frames") } else { ProgressBar::hidden() }
}
