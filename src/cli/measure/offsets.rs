//! `measure --offsets`: the part that was measured decides the offsets of the next one.
//!
//! In: a job, a state file, the frames as they are measured. Out: a table or the JSON key
//! `offsets`, and the state for the next part. The stations are those of the job, measured as a run
//! measures them; what is decided is in [`part_offsets`](crate::part_offsets).

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::cli::failure::{Failure, Outcome as Ended};
use crate::cli::input_output::ConfigText;
use crate::closed_loop::StationScan;
use crate::config;
use crate::conformity::part_verdict::PartConformity;
use crate::control::ControlError;
use crate::files::OutputFile;
use crate::gauge::{Calibration, EsfModel, Gauge, GaugeSettings};
use crate::job::{Job, LoopJob};
use crate::part_offsets::{Decided, Labels, OffsetState, Outcome, Seen, decide};
use crate::source::{check_places, digest_of_all, image_digests};

/// Arguments of the offsets.
#[derive(Debug, Default, clap::Args)]
pub(crate) struct OffsetArgs {
    /// Decides the offsets of the next part by the job in this file, with its controller and its
    /// guards; the frames show one part just turned, and need --calibration and a frames.csv with
    /// z_mm and angle_deg. The first use is a trial cut that proves sign and unit.
    #[arg(long, value_name = "JOB.toml")]
    offsets: Option<PathBuf>,
    /// Keeps offsets, tool, insert and the parts measured from one part to the next; made where it
    /// is not there yet.
    #[arg(long, value_name = "FILE.toml", requires = "offsets")]
    state: Option<PathBuf>,
    /// Pass whose result the frames show; the job's last one by default.
    #[arg(long, value_name = "N", requires = "offsets")]
    pass: Option<u32>,
    /// Name of the part that was measured.
    #[arg(long, value_name = "NAME", requires = "offsets")]
    part: Option<String>,
    /// Name of the tool that cuts the next part; another one than before resets offsets and proof.
    #[arg(long, value_name = "NAME", requires = "offsets")]
    tool: Option<String>,
    /// Name of the insert that cuts the next part; another one than before resets the offsets to
    /// those of a new insert.
    #[arg(long, value_name = "NAME", requires = "offsets")]
    insert: Option<String>,
}

impl OffsetArgs {
    /// Whether offsets are decided.
    pub(super) fn are_given(&self) -> bool {
        self.offsets.is_some()
    }

    /// Files read beside the frames.
    pub(super) fn inputs(&self) -> impl Iterator<Item = PathBuf> {
        self.offsets.clone().into_iter()
    }

    fn labels(&self) -> Labels {
        let named = |name: &Option<String>| name.clone().unwrap_or_default();
        Labels { part: named(&self.part), tool: named(&self.tool), insert: named(&self.insert) }
    }
}

/// What the decision is made from, read before the first frame.
pub(super) struct OffsetJob {
    job: LoopJob,
    gauge: Gauge,
    calibration: Calibration,
    state: OffsetState,
    /// The state file, claimed.
    file: Option<OutputFile>,
    labels: Labels,
    images: Vec<String>,
}

impl OffsetJob {
    /// Reads job and state; `esf` is the edge model of the calibration, `conditions` are those of
    /// the part where they were given beside the job.
    ///
    /// # Errors
    /// Exit 2 for a job or a state that is refused, 3 for images without places.
    pub(super) fn begin(
        args: &OffsetArgs,
        images: &[PathBuf],
        (calibration, esf): (&Calibration, EsfModel),
        conditions: Option<crate::gauge::calibration::Conditions>,
    ) -> Result<Option<Self>, Failure> {
        let Some(path) = &args.offsets else { return Ok(None) };
        let text = ConfigText::read(path)?;
        let job = checked(path, &text)?;
        let passes = job.part.passes() as u32;
        let pass = args.pass.unwrap_or(passes);
        if !(1..=passes).contains(&pass) {
            return Err(Failure::refuse(format!("--pass {pass}: the job has passes 1 to {passes}")));
        }
        check_places(images).map_err(Failure::fail)?;
        let labels = args.labels();
        let inputs = images.iter().cloned().chain(args.inputs());
        let file = args.state.as_ref().map(|state| OutputFile::claim(state, inputs)).transpose()?;
        let state = match &args.state {
            Some(path) if path.exists() => read_state(path, &job, pass)?,
            _ => OffsetState::new(&job, pass, Labels::default()),
        };
        let gauge = Gauge::calibrated(GaugeSettings { esf, ..job.gauge.clone() }, Some(calibration));
        let gauge =
            gauge.map_err(|e| if e.is_of_settings() { Failure::refuse(e) } else { Failure::fail(e) })?;
        let conditions = conditions.unwrap_or_else(|| job.part_conditions());
        let calibration = calibration.clone().with_conditions(conditions);
        let images = image_digests(images).map_err(Failure::fail)?;
        Ok(Some(Self { job, gauge, calibration, state, file, labels, images }))
    }

    /// The stations, before the first frame.
    pub(super) fn scan(&self) -> StationScan<'_> {
        StationScan::new(&self.job, &self.gauge, &self.calibration)
    }

    /// Decides by the stations and writes the state.
    ///
    /// # Errors
    /// Exit 2 for a controller that cannot be built, 3 for a state that cannot be written.
    pub(super) fn decide(self, profile: crate::profile::DiameterProfile) -> Result<OffsetResult, Failure> {
        let all_images = digest_of_all(&self.images);
        let seen = Seen { profile, images: self.images, all_images, labels: self.labels };
        let decided = decide(&self.job, self.state, &seen).map_err(|error| match error {
            ControlError::Setting(at) => Failure::refuse(at),
            other => Failure::refuse(other),
        })?;
        match self.file {
            Some(file) => file.write(state_text(&decided.state)?.as_bytes())?,
            None => tracing::warn!("without --state FILE nothing of this decision is kept for the next part"),
        }
        Ok(OffsetResult(decided))
    }
}

/// The loop's job of a file, checked as a run checks it.
fn checked(path: &Path, text: &ConfigText) -> Result<LoopJob, Failure> {
    let job: Job = config::load(path).map_err(Failure::refused)?;
    job.check_coverage().and_then(|()| job.check_control()).map_err(|e| text.refuse_at(e))?;
    if job.probe.is_some() {
        let at = crate::setting::SettingError::at(
            "probe",
            "offsets are decided by frames: leave the touch probe out",
        );
        return Err(text.refuse_at(at));
    }
    job.cautions().iter().for_each(|word| tracing::warn!("{}: {word}", text.name));
    Ok(job.loop_job())
}

/// Reads a state and checks that it is the job's.
///
/// # Errors
/// Exit 2 for a file that is none or of another job.
pub(crate) fn read_state(path: &Path, job: &LoopJob, pass: u32) -> Result<OffsetState, Failure> {
    let text = ConfigText::read(path)?;
    let state: OffsetState = text.parse()?;
    state.check(job, pass).map_err(|other| text.refuse(other))?;
    Ok(state)
}

fn state_text(state: &OffsetState) -> Result<String, Failure> {
    let body = toml::to_string(state).map_err(Failure::fail)?;
    Ok(format!(
        "# Offsets between two parts, written by `shadowgauge measure --offsets`; its keys: `shadowgauge schema offsets`.\n{body}"
    ))
}

/// The decision, to be printed.
pub(super) struct OffsetResult(Decided);

impl OffsetResult {
    /// Exit 1 unless new offsets, a trial cut or a reset came of it, and where the part is not in
    /// tolerance.
    pub(super) fn ended(&self) -> Ended {
        let decided = &self.0;
        let is_good = decided.verdict.as_ref().is_none_or(|v| v.part() == PartConformity::Conforms);
        let goes_on = matches!(decided.outcome, Outcome::FirstUse | Outcome::Released | Outcome::Reset);
        if is_good && goes_on && decided.alarm.is_none() { Ended::Done } else { Ended::OutOfTolerance }
    }

    /// The key `offsets`.
    pub(super) fn to_json(&self) -> Value {
        let decided = &self.0;
        let mut json = json!(decided);
        let state = &decided.state;
        json["stage"] = json!(state.stage);
        json["measurement"] = state.measurements.into();
        json["pass"] = state.pass.into();
        json["labels"] = json!(state.labels);
        json["conformity"] =
            json!(decided.verdict.as_ref().map(crate::conformity::part_verdict::Verdict::part));
        json
    }

    /// The table.
    pub(super) fn to_table(&self) -> String {
        let d = &self.0;
        let mut text = format!(
            "\noffsets of the next part (pass {}, measurement {})\n       z/mm  nominal/mm  measured/mm    U/µm  judgement     old/µm    new/µm  reason\n",
            d.state.pass, d.state.measurements
        );
        for s in &d.stations {
            let value = s.d_mm.map_or_else(|| "-".to_owned(), |v| format!("{v:.5}"));
            let u = s.expanded_u_mm.map_or_else(|| "-".to_owned(), |u| format!("{:.2}", 1e3 * u));
            let judged =
                s.judgement.map_or_else(|| "-".to_owned(), |j| json!(j).as_str().unwrap_or("-").to_owned());
            let _ = writeln!(
                text,
                "{:11.3} {:11.4} {value:>12} {u:>7}  {judged:<10} {:>10.2} {:>9.2}  {}",
                s.z_mm,
                s.nominal_mm,
                1e3 * s.old_offset_mm,
                1e3 * s.new_offset_mm,
                s.reason
            );
        }
        let _ = writeln!(text, "{}: {}", json!(d.outcome).as_str().unwrap_or_default(), d.reason);
        if let Some(ratio) = d.observed_over_commanded {
            let _ = writeln!(text, "observed over commanded change: {ratio:.3}");
        }
        d.notes.iter().for_each(|note| {
            let _ = writeln!(text, "{note}");
        });
        if let Some(alarm) = &d.alarm {
            let _ = writeln!(text, "ALARM: {alarm}");
        }
        if let Some(verdict) = &d.verdict {
            let _ = writeln!(text, "{}", verdict.words());
        }
        text
    }
}
