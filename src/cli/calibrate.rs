//! `shadowgauge calibrate`: an optical setup from dark and flat fields, master pins and a check
//! pin.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use indicatif::ProgressBar;
use serde_json::json;

use super::calibration_plan::{self, LoadedPlan};
use super::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::json_text;
use crate::cli::measure::esf_argument::{esf_model, needs_scale};
use crate::cli::terminal::progress;
use crate::files::OutputFile;
use crate::frame::Frame;
use crate::gauge::Calibration;
use crate::gauge::calibration::{Date, SetupCalibration};
use crate::gauge::stated::stated;
use crate::render::optics::lens_file::{CorrectedLens, LensFile};
use crate::render::{BackendChoice, Renderer};
use crate::report;
use crate::source::{Channel, FileFrames, listing};
use crate::studies::calibration::{
    CalibrateError, Calibrated, CalibrationPlan, PinPlan, Position, Recordings, SimulatedRecordings,
    calibrate, edge_model_line, parameter_table, rough_um_per_px,
};

/// Arguments of `calibrate`.
#[derive(Debug, clap::Args)]
pub(crate) struct CalibrateArgs {
    /// The calibration, as configs/calibrate.toml; or a job's config, whose bench is calibrated on
    /// its master pins, rendered.
    config: PathBuf,
    /// Where the calibration goes; its report goes beside it as .html.
    #[arg(long, value_name = "FILE.json")]
    out: PathBuf,
    /// Edge-spread function that is fitted, in place of the file's [gauge.esf]: gaussian, learnt
    /// (each frame's own), a table `distance_um,light` (.csv or .json) or the optics of a config
    /// (.toml). The calibration keeps it.
    #[arg(long, value_name = "NAME|FILE")]
    esf: Option<String>,
    /// Write the lens that was found as `lens.toml`, which a config names by `optics.lens_file`.
    #[arg(long, value_name = "FILE.toml")]
    lens: Option<PathBuf>,
    /// Day of the calibration that is made of a job's config, YYYY-MM-DD; today without it. A
    /// calibration's own file has its date.
    #[arg(long, value_name = "DATE")]
    date: Option<Date>,
    /// Where a [simulate] table's frames are rendered.
    #[arg(long, value_enum, default_value_t = BackendChoice::Auto)]
    backend: BackendChoice,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Makes the calibration. Where the check pin refutes it, only the report is written, and the exit
/// code is 1.
///
/// # Errors
/// Exit 2 for a config that is refused; 3 for frames that cannot be read or measured and for
/// failures of the disk.
pub(crate) fn run(args: &CalibrateArgs) -> CommandResult {
    if args.out.extension().is_none_or(|e| e != "json") {
        let name = args.out.display();
        return Err(Failure::refuse(format!(
            "--out {name}: must end in .json; the report goes beside it as .html"
        )));
    }
    let today = args.date.unwrap_or_else(|| Date::of(SystemTime::now()));
    let mut loaded = calibration_plan::load(&args.config, today)?;
    let claim = |path: &Path| OutputFile::claim(path, [args.config.clone()]);
    let (page_file, file) = (claim(&args.out.with_extension("html"))?, claim(&args.out)?);
    let lens_file = args.lens.as_deref().map(claim).transpose()?;
    let calibrated = make(&mut loaded, args.esf.as_deref(), args.backend)?;
    let page = report::calibration_report(&loaded.plan, &calibrated).map_err(Failure::fail)?;
    page_file.write(page.as_bytes())?;
    let accepted = check(&calibrated.calibration);
    if accepted {
        let json = json_text(&calibrated.calibration)? + "\n";
        file.write(json.as_bytes())?;
        write_lens(lens_file, &calibrated.calibration)?;
    } else {
        tracing::error!(
            "the check pin refuses this calibration; {} is not written, the report says why",
            args.out.display()
        );
    }
    say(args, &calibrated);
    Ok(if accepted { Outcome::Done } else { Outcome::OutOfTolerance })
}

/// Writes the lens of a calibration, where it is asked for.
fn write_lens(file: Option<OutputFile>, calibration: &Calibration) -> Result<(), Failure> {
    let (Some(file), Some(setup)) = (file, &calibration.setup) else { return Ok(()) };
    let lens = CorrectedLens {
        radial: setup.lens.radial,
        keystone_across: setup.lens.keystone_across,
        keystone_along: setup.lens.keystone_along,
        telecentricity_per_mm: setup.lens.telecentricity_per_mm,
    };
    let size = (setup.rows as u32, setup.columns as u32);
    let lens = LensFile::of(&lens, size, 1e3 * calibration.scale_mm_per_px);
    Ok(file.write(toml::to_string(&lens).map_err(Failure::fail)?.as_bytes())?)
}

/// Makes a plan's calibration from its folders or from rendered frames, with the edge-spread
/// function named on the command line in place of the plan's.
///
/// # Errors
/// As [`run`].
pub(crate) fn make(
    loaded: &mut LoadedPlan,
    esf: Option<&str>,
    backend: BackendChoice,
) -> Result<Calibrated, Failure> {
    let LoadedPlan { plan, text, folder } = loaded;
    plan.validate().map_err(|e| text.refuse_at(e))?;
    let failed = |e: CalibrateError| match e {
        CalibrateError::Setting(e) => text.refuse_at(e),
        other => Failure::fail(format!("{}: {other}", text.name)),
    };
    if plan.simulate.is_none() {
        let mut recordings =
            RecordedFrames { folder: folder.clone(), channel: plan.channel, said: HashSet::new() };
        choose_edge(plan, esf, |plan| rough_um_per_px(plan, &mut recordings).map_err(failed))?;
        return calibrate(plan, &mut Watched::new(plan, &mut recordings)).map_err(failed);
    }
    let renderer = Renderer::new(backend).map_err(Failure::fail)?;
    let rendered =
        |plan: &CalibrationPlan| SimulatedRecordings::new(plan, &renderer).map_err(|e| text.refuse(e));
    choose_edge(plan, esf, |plan| rough_um_per_px(plan, &mut rendered(plan)?).map_err(failed))?;
    calibrate(plan, &mut Watched::new(plan, &mut rendered(plan)?)).map_err(failed)
}

/// Puts the edge-spread function of the command line into a plan; a table in µm is converted by a
/// rough scale from the masters.
fn choose_edge(
    plan: &mut CalibrationPlan,
    esf: Option<&str>,
    um_per_px: impl FnOnce(&CalibrationPlan) -> Result<f64, Failure>,
) -> Result<(), Failure> {
    let Some(name) = esf else { return Ok(()) };
    let scale = if needs_scale(name) { Some(um_per_px(plan)?) } else { None };
    plan.gauge.esf = esf_model(name, scale)?;
    Ok(())
}

fn check(calibration: &Calibration) -> bool {
    calibration.setup.as_ref().and_then(|b| b.check).is_none_or(|c| c.accepted)
}

/// The document of `--json`.
fn summary(calibrated: &Calibrated, setup: &SetupCalibration) -> serde_json::Value {
    let calibration = &calibrated.calibration;
    let residual_um = rms(setup.residuals.iter().map(|r| 1e3 * r.residual_mm));
    json!({
        // Without a check pin only the masters support the calibration.
        "accepted": setup.check.map(|c| c.accepted),
        "optics_id": calibration.optics_id,
        "scale_mm_per_px": calibration.scale_mm_per_px,
        "offset_mm": calibration.offset_mm,
        "lens": setup.lens,
        "birge_ratio": setup.birge_ratio,
        "rms_residual_um": residual_um,
        "check": setup.check,
        "edge_model": calibration.edge_model,
        "unlearnt_frames": calibrated.unlearnt_frames,
        "misfit_chi2": calibration.systematic_residual().map(|m| m.chi2),
        "expires": setup.validity.expires(),
        "sensor": setup.sensor.as_ref().map(|s| json!({
            "gain_counts_per_electron": s.gain_counts_per_electron,
            "read_noise_electrons": s.read_noise_electrons,
            "prnu": s.prnu,
            "black_counts": s.black_counts,
        })),
        "defective_pixels": setup.flat_field.as_ref().map(|f| f.defects.len()),
        // For one version also under the name that the list has in the calibration file.
        "defects": setup.flat_field.as_ref().map(|f| f.defects.len()),
        "response": setup.flat_field.as_ref().and_then(|f| f.response),
    })
}

fn say(args: &CalibrateArgs, calibrated: &Calibrated) {
    let calibration = &calibrated.calibration;
    let Some(setup) = &calibration.setup else { return };
    if args.json {
        say_line!("{}", summary(calibrated, setup));
        return;
    }
    say_line!("{:<42} {:>14} {:>12}", calibration.optics_id, "value", "u");
    for [name, value, u] in parameter_table(calibration) {
        say_line!("{name:<42} {value:>14} {u:>12}");
    }
    say_line!("{}", edge_model_line(calibrated));
    if let Some(systematic_residual) = calibration.systematic_residual() {
        say_line!(
            "edge model misfits the masters' edges: chi2 {:.2} times the noise, {:.2} and {:.2} % of the contrast left; absorbed by the offset",
            systematic_residual.chi2,
            1e2 * systematic_residual.norm(0),
            1e2 * systematic_residual.norm(1)
        );
    }
    say_line!("Birge ratio {:.3}, valid until {}", setup.birge_ratio, setup.validity.expires());
    say_sensor(setup);
    say_check(setup);
    if let Some(budget) = &calibrated.example {
        say!("\nbudget of a part like the master of {:.3} mm\n{}", budget.diameter_mm, budget.to_table(None));
    }
}

/// Results of photon transfer and flat field for the sensor.
fn say_sensor(setup: &SetupCalibration) {
    if let Some(sensor) = &setup.sensor {
        say_line!(
            "sensor: {:.4} electrons a count, read noise {:.2} e, PRNU {:.3} %",
            1.0 / sensor.gain_counts_per_electron,
            sensor.read_noise_electrons,
            1e2 * sensor.prnu
        );
    }
    if let Some(field) = &setup.flat_field {
        say_line!(
            "flat field: {} defective pixels, light falls by {:.2} %",
            field.defects.len(),
            1e2 * field.fall_off
        );
    }
    if let Some(response) = setup.flat_field.as_ref().and_then(|f| f.response) {
        say_line!(
            "response: departs from a line by {:.1} % of full scale, undone (exponent {:.3}, curvature {:.3}, {:.2} % left)",
            1e2 * response.departure,
            response.exponent,
            response.curvature,
            1e2 * response.residual
        );
    }
}

/// Whether the check pin agrees.
fn say_check(setup: &SetupCalibration) {
    if setup.check.is_none() {
        say_line!("no check pin: nothing but the masters themselves speaks for this calibration");
    }
    if let Some(check) = setup.check {
        let [error_um, expanded_um] = stated(1e3 * check.error_mm, 1e3 * check.expanded_u_mm);
        say_line!(
            "check pin: {}{error_um} um off, U = {expanded_um} um (k = {:.2}), E_n = {:.2}: {}",
            if check.error_mm < 0.0 { "" } else { "+" },
            check.coverage_factor,
            check.e_n,
            if check.accepted { "accepted" } else { "REFUSED" }
        );
    }
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0.0_f64), |(s, n), v| (s + v * v, n + 1.0));
    (sum / n.max(1.0)).sqrt()
}

/// Recordings with a bar on a terminal that counts them.
struct Watched<'a> {
    recordings: &'a mut dyn Recordings,
    bar: ProgressBar,
}

impl<'a> Watched<'a> {
    fn new(plan: &CalibrationPlan, recordings: &'a mut dyn Recordings) -> Self {
        let positions: usize = plan.masters.iter().chain(&plan.check).map(|pin| pin.positions.len()).sum();
        let fields = plan.fields.flats.len() + usize::from(!plan.fields.flats.is_empty());
        let bar = progress::bar((positions + fields) as u64, "measuring", "recordings");
        Self { recordings, bar }
    }
}

impl Drop for Watched<'_> {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

impl Recordings for Watched<'_> {
    fn pin(
        &mut self,
        index: usize,
        pin: &PinPlan,
        position: &Position,
    ) -> Result<Vec<Frame>, CalibrateError> {
        self.recordings.pin(index, pin, position).inspect(|_| self.bar.inc(1))
    }

    fn dark(&mut self, plan: &CalibrationPlan) -> Result<Vec<Frame>, CalibrateError> {
        self.recordings.dark(plan).inspect(|_| self.bar.inc(1))
    }

    fn flat(&mut self, plan: &CalibrationPlan, index: usize) -> Result<Vec<Frame>, CalibrateError> {
        self.recordings.flat(plan, index).inspect(|_| self.bar.inc(1))
    }
}

/// Frames in the folders that a plan names.
struct RecordedFrames {
    folder: PathBuf,
    channel: Option<Channel>,
    /// Notes on the files already written.
    said: HashSet<String>,
}

impl RecordedFrames {
    fn read(&mut self, path: Option<&PathBuf>) -> Result<Vec<Frame>, CalibrateError> {
        let Some(path) = path else { return Ok(Vec::new()) };
        let frames = |e: &dyn std::fmt::Display| CalibrateError::Frames(e.to_string());
        let images = listing(&self.folder.join(path)).map_err(|e| frames(&e))?.images;
        let mut source = FileFrames::new(images).of_channel(self.channel);
        let mut all = Vec::new();
        while let Some(read) = source.next_stored() {
            let stored = read.map_err(|e| frames(&e))?;
            for said in source.take_notices().into_iter().chain(stored.changed) {
                if self.said.insert(said.clone()) {
                    tracing::warn!("{}: {said}; this is said once", path.display());
                }
            }
            all.push(stored.frame);
        }
        Ok(all)
    }
}

impl Recordings for RecordedFrames {
    fn pin(&mut self, _: usize, _: &PinPlan, position: &Position) -> Result<Vec<Frame>, CalibrateError> {
        self.read(position.frames.as_ref())
    }

    fn dark(&mut self, plan: &CalibrationPlan) -> Result<Vec<Frame>, CalibrateError> {
        self.read(plan.fields.dark.as_ref())
    }

    fn flat(&mut self, plan: &CalibrationPlan, index: usize) -> Result<Vec<Frame>, CalibrateError> {
        self.read(plan.fields.flats[index].frames.as_ref())
    }
}
