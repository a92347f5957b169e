//! Runs a job pass by pass and writes each pass into its folder as soon as it is finished.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::cell::SimulatedCell;
use crate::closed_loop::{Calibrated, ClosedLoop, LoopError, PassResult, Sample, part_verdict};
use crate::conformity::part_verdict::Verdict;
use crate::control::OnAlarm;
use crate::gauge::diameter::sections::PartForm;
use crate::job::Job;
use crate::plan::Decision;
use crate::process::bending::axis_at;
use crate::profile::Reading;
use crate::render::Renderer;
use crate::run_folder::{
    AxisRow, ControlRecord, DiameterRow, FormRow, OffsetRow, PartFormRow, PassRecord, PassRow, RunFolder,
    StationRow, TrueAxisRow, TruthRow, profile_of, read_diameters,
};

use crate::cli::failure::{Failure, folder_failure};

/// The results of a recorded run in memory.
pub struct Recorded {
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
    /// Why not all passes were cut: an alarm.
    pub stopped: Option<String>,
}

/// A run being written.
pub struct Recorder<'a> {
    job: &'a Job,
    folder: &'a RunFolder,
    chain: ClosedLoop<'a>,
    run_id: String,
    passes: Vec<PassRow>,
    stations: Vec<StationRow>,
    offsets: Vec<OffsetRow>,
    diameters: Vec<DiameterRow>,
    control: ControlRecord,
    form: (Vec<FormRow>, Vec<PartFormRow>),
    axis: Vec<AxisRow>,
    true_axis: Vec<TrueAxisRow>,
}

impl<'a> Recorder<'a> {
    /// Calibrates the gauge, or resumes an unfinished run.
    ///
    /// # Errors
    /// Where the job, the device or the folder fails.
    pub fn new(job: &'a Job, folder: &'a RunFolder, renderer: &'a Renderer) -> Result<Self, Failure> {
        let cell = SimulatedCell::new(job, renderer).map_err(Failure::fail)?;
        let passes = folder.passes().map_err(folder_failure)?;
        let done = |pass: u32| passes.iter().any(|p| p.pass == pass);
        let mut stations = folder.stations().map_err(folder_failure)?;
        let mut diameters = read_diameters(folder).map_err(folder_failure)?;
        stations.retain(|s| done(s.pass));
        diameters.retain(|d| done(d.pass));
        let mut form = folder.form().map_err(folder_failure)?;
        form.0.retain(|f| done(f.pass));
        form.1.retain(|f| done(f.pass));
        let mut axis = folder.axis().map_err(folder_failure)?;
        axis.retain(|a| done(a.pass));
        let mut true_axis = folder.true_axis().map_err(folder_failure)?;
        true_axis.retain(|a| done(a.pass));
        let calibration = match passes.is_empty() {
            true => None,
            false => Some(read_calibration(folder)?),
        };
        let mut chain = ClosedLoop::start(job, Box::new(cell), calibration).map_err(loop_failure)?;
        let json = serde_json::to_string_pretty(chain.calibration()).map_err(Failure::fail)?;
        folder.write("calibration.json", json.as_bytes()).map_err(folder_failure)?;
        let mut offsets = Vec::new();
        let mut control = match passes.is_empty() {
            true => ControlRecord::default(),
            false => folder.control().map_err(folder_failure)?,
        };
        control.passes.retain(|p| done(p.pass));
        if !passes.is_empty() {
            chain.resume_stock(control.stock.clone());
        }
        for row in &passes {
            offsets.extend(offset_rows(&chain));
            let evidence = control.evidence(row.pass);
            chain.replay(&profile_of(row.pass, &stations), &evidence).map_err(loop_failure)?;
        }
        let run_id = crate::config::hash(job).map_err(Failure::fail)?.chars().take(12).collect();
        Ok(Self {
            job,
            folder,
            chain,
            run_id,
            passes,
            stations,
            offsets,
            diameters,
            control,
            form,
            axis,
            true_axis,
        })
    }

    /// Runs the remaining passes; `progress` shows a bar on a terminal.
    ///
    /// # Errors
    /// Where a cut, a frame or the disk fails; finished passes stay readable.
    pub fn run(mut self, progress: bool) -> Result<Recorded, Failure> {
        let mut seconds = vec![(0.0, 0.0); self.passes.len()];
        let (mut sample, mut form) = (None, None);
        let mut stopped = None;
        while let Some(pass) = self.chain.next_pass() {
            if let Some(alarm) = self.chain.alarm().filter(|_| self.stops()) {
                tracing::error!("stopped before pass {pass}: {alarm}");
                stopped = Some(format!("stopped before pass {pass}: {alarm}"));
                break;
            }
            self.chain.begin().map_err(loop_failure)?;
            let bar = progress_bar(progress, &format!("pass {pass} of {}", self.job.passes()));
            self.offsets.extend(offset_rows(&self.chain));
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
            if progress {
                log_decision(&result);
            }
            seconds.push((result.render.as_secs_f64(), result.gauge.as_secs_f64()));
            self.write(&result)?;
            self.write_timings(&seconds)?;
            form = Some(result.form);
            sample = result.sample.or(sample);
        }
        let verdict = self.verdict();
        Ok(Recorded { passes: self.passes, seconds, sample, form, axis: self.axis, verdict, stopped })
    }

    fn stops(&self) -> bool {
        self.job.control.guards.on_alarm == OnAlarm::Stop
    }

    /// All tables, `passes.csv` last: a pass listed there has all its data.
    fn write(&mut self, result: &PassResult) -> Result<(), Failure> {
        let unknown = vec![f64::NAN; result.profile.stations.len()];
        let truth = result.truth_mm.as_ref().unwrap_or(&unknown);
        let pass = result.plan.pass;
        self.stations
            .extend(result.profile.stations.iter().zip(truth).map(|(s, &t)| StationRow::new(pass, s, t)));
        self.diameters.extend(diameter_rows(result));
        let stations = &result.profile.stations;
        self.form.0.extend(result.form.sections.iter().map(|s| FormRow::new(pass, s, stations)));
        self.form.1.push(PartFormRow::new(pass, &result.form));
        self.axis.extend(AxisRow::of(pass, &result.axis));
        self.true_axis.extend(true_axis_rows(result));
        self.passes.push(pass_row(result, truth));
        self.control.stock = self.chain.stock().cloned();
        self.control.passes.push(pass_record(result));
        let truth_rows: Vec<TruthRow> = self
            .stations
            .iter()
            .map(|s| TruthRow { pass: s.pass, z_mm: s.z_mm, d_mm: s.true_d_mm })
            .collect();
        let folder = self.folder;
        folder
            .write_stations(&self.stations)
            .and_then(|()| folder.write_offsets(&self.offsets))
            .and_then(|()| folder.write_form(&self.form.0, &self.form.1))
            .and_then(|()| folder.write_axis(&self.axis))
            .and_then(|()| folder.write_diameters(&self.run_id, &self.diameters))
            .and_then(|()| folder.write_truth(&self.run_id, &truth_rows))
            .and_then(|()| folder.write_true_axis(&self.true_axis))
            .and_then(|()| folder.write_control(&self.control))
            .and_then(|()| folder.write_passes(&self.passes))
            .map_err(folder_failure)
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
        let finished = self.passes.len() == last;
        finished.then(|| part_verdict(self.job, &profile_of(last as u32, &self.stations))).flatten()
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

fn pass_record(result: &PassResult) -> PassRecord {
    let reason = match &result.decision {
        Some(Decision::Held(reason)) => Some(reason.to_string()),
        _ => None,
    };
    PassRecord {
        pass: result.plan.pass,
        decision: decision_word(result).to_owned(),
        reason,
        alarm: result.alarm.clone(),
        notes: result.notes.clone(),
        evidence: result.evidence.clone(),
    }
}

fn decision_word(result: &PassResult) -> &'static str {
    match &result.decision {
        None => "last",
        Some(Decision::Offset(_)) => "released",
        Some(Decision::Held(_)) => "held",
    }
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

fn offset_rows(chain: &ClosedLoop<'_>) -> Vec<OffsetRow> {
    let plan = chain.plan();
    let commanded = plan.commanded_mm();
    let (status, reason) = match chain.held() {
        Some(reason) => ("held", reason.to_string()),
        None => ("released", String::new()),
    };
    plan.station_z_mm
        .iter()
        .zip(&plan.offset.o_mm)
        .zip(&chain.asked().o_mm)
        .zip(commanded)
        .map(|(((&z_mm, &offset_mm), &asked_mm), commanded_mm)| OffsetRow {
            pass: plan.pass,
            z_mm,
            offset_mm,
            asked_mm: Some(asked_mm),
            commanded_mm,
            status: status.to_owned(),
            reason: reason.clone(),
        })
        .collect()
}

fn diameter_rows(result: &PassResult) -> impl Iterator<Item = DiameterRow> + '_ {
    result.readings.iter().map(|r| {
        let value = r.reading.value();
        let number = |f: &dyn Fn(crate::profile::Diameter) -> f64| value.map_or(f64::NAN, f);
        DiameterRow {
            pass: result.plan.pass,
            frame_id: r.frame_id,
            t_ns: r.t_ns,
            z_mm: r.z_mm,
            angle_deg: r.angle_deg,
            d_mm: number(&|d| d.d_mm),
            u_random_mm: number(&|d| d.u_random_mm),
            u_common_mm: number(&|d| d.u_common_mm),
            flag: match r.reading {
                Reading::Gap(reason) => reason.to_string(),
                Reading::Value(_) => String::new(),
            },
        }
    })
}

fn pass_row(result: &PassResult, truth: &[f64]) -> PassRow {
    let nominal_mm = result.plan.nominal_mm;
    let measured: Vec<(crate::profile::Diameter, f64)> = result
        .profile
        .stations
        .iter()
        .zip(truth)
        .filter_map(|(s, &t)| Some((s.reading.value()?, t)))
        .collect();
    let largest = |values: &mut dyn Iterator<Item = f64>| values.map(f64::abs).fold(0.0, f64::max);
    let rms = |values: &mut dyn Iterator<Item = f64>| {
        let (sum, count) = values.fold((0.0, 0usize), |(s, n), v| (s + v * v, n + 1));
        (sum / count.max(1) as f64).sqrt()
    };
    PassRow {
        pass: result.plan.pass,
        nominal_mm,
        max_abs_error_mm: largest(&mut measured.iter().map(|(d, _)| d.d_mm - nominal_mm)),
        rms_error_mm: rms(&mut measured.iter().map(|(d, _)| d.d_mm - nominal_mm)),
        true_max_abs_error_mm: largest(&mut truth.iter().map(|t| t - nominal_mm)),
        worst_measured_minus_true_mm: largest(&mut measured.iter().map(|(d, t)| d.d_mm - t)),
        rms_error_over_u: rms(&mut measured.iter().map(|(d, t)| (d.d_mm - t) / d.u_mm())),
        stations_measured: measured.len(),
        frames: result.frames,
        decision: decision_word(result).to_owned(),
        radial_force_n: result.cut.as_ref().map(|c| c.max_force_n),
        tangential_force_n: result.cut.as_ref().map(|c| c.max_cutting_n),
        feed_force_n: result.cut.as_ref().map(|c| c.max_feed_n),
        deflection_um: result.cut.as_ref().map(|c| 1e3 * c.max_deflection_mm),
        tangential_error_um: result.cut.as_ref().map(|c| c.tangential_error_um),
        feed_mark_um: result.cut.as_ref().map(|c| c.feed_mark_um),
    }
}

fn true_axis_rows(result: &PassResult) -> impl Iterator<Item = TrueAxisRow> + '_ {
    result.true_axis.iter().flat_map(|axis| {
        result.plan.station_z_mm.iter().map(|&z_mm| {
            let [still_x_mm, still_y_mm] = axis_at(&axis.still, z_mm);
            let [turning_x_mm, turning_y_mm] = axis_at(&axis.turning, z_mm);
            TrueAxisRow { pass: result.plan.pass, z_mm, still_x_mm, still_y_mm, turning_x_mm, turning_y_mm }
        })
    })
}

/// A bar on a terminal, nothing elsewhere.
fn progress_bar(shown: bool, what: &str) -> ProgressBar {
    let target = if shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some(0), target);
    if let Ok(style) =
        ProgressStyle::with_template("{msg} {bar:32} {pos}/{len} frames, {per_sec}, {eta} left")
    {
        bar.set_style(style);
    }
    bar.set_message(what.to_owned());
    bar
}
