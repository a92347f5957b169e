//! `shadowgauge calibrate CONFIG`: an optical setup from dark and flat fields, master pins and a
//! check pin.
//!
//! In: a plan. Its frames are rendered, lie in folders (`recorded_frames`) or are taken with a
//! camera (`camera_frames`), before which an operator lays the pins (`asked_camera`, who is `asked`
//! on the terminal) or which places them itself. Out: a calibration, bound to its camera, with a
//! report; what is printed is in `said`.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::camera_args::CameraArgs;
#[cfg(feature = "camera")]
use super::camera_frames::CameraFrames;
use super::fit_esf;
use super::recorded_frames::{RecordedFrames, Watched};
use super::said::say;
use crate::cli::calibration_plan::{self, LoadedPlan};
use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::{ConfigText, json_text};
use crate::cli::measure::esf_argument::{esf_model, needs_scale};
use crate::files::OutputFile;
use crate::gauge::Calibration;
use crate::gauge::calibration::Date;
use crate::render::optics::lens_file::{CorrectedLens, LensFile};
use crate::render::{BackendChoice, Renderer};
use crate::report;
use crate::setting::SettingError;
use crate::studies::calibration::{
    CalibrateError, Calibrated, CalibrationPlan, Recordings, SimulatedRecordings, calibrate, rough_um_per_px,
};

/// Arguments of `calibrate CONFIG`.
#[derive(Debug, clap::Args)]
pub(crate) struct OpticalSetupArgs {
    /// The calibration, as configs/calibrate.toml; or a job's config, whose bench is calibrated on
    /// its master pins, rendered.
    // An option, since a subcommand stands in its place; required where none does. So is `out`.
    #[arg(required = true)]
    config: Option<PathBuf>,
    /// Where the calibration goes; its report goes beside it as .html.
    #[arg(long, value_name = "FILE.json", required = true)]
    out: Option<PathBuf>,
    /// Edge-spread function that is fitted, in place of the file's [gauge.esf]: gaussian, learnt
    /// (each frame's own), a table `distance_um,light` (.csv or .json) or the optics of a config
    /// (.toml). The calibration keeps it.
    #[arg(long, value_name = "NAME|FILE")]
    esf: Option<String>,
    /// Fit aperture, ratio of coherence, blur and focus of the optics that --esf names to the
    /// masters' frames, write them as [optics.esf.cylinder], and fit edges by them.
    #[arg(long, value_name = "FILE.toml", requires = "esf")]
    fit_esf: Option<PathBuf>,
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
    #[command(flatten)]
    camera: CameraArgs,
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
pub(crate) fn run(args: &OpticalSetupArgs) -> CommandResult {
    let (Some(config), Some(out)) = (&args.config, &args.out) else {
        return Err(Failure::refuse("calibrate needs a config and --out FILE.json, or: calibrate machine"));
    };
    if out.extension().is_none_or(|e| e != "json") {
        let name = out.display();
        return Err(Failure::refuse(format!(
            "--out {name}: must end in .json; the report goes beside it as .html"
        )));
    }
    let today = args.date.unwrap_or_else(|| Date::of(SystemTime::now()));
    let mut loaded = calibration_plan::load(config, today)?;
    if let (None, Some(option)) = (&loaded.plan.source, args.camera.given()) {
        let name = config.display();
        return Err(Failure::refuse(format!("{option} is of a camera, and {name} names none (source)")));
    }
    let claim = |path: &Path| OutputFile::claim(path, [config.clone()]);
    let (page_file, file) = (claim(&out.with_extension("html"))?, claim(out)?);
    let lens_file = args.lens.as_deref().map(claim).transpose()?;
    let esf_file = args.fit_esf.as_deref().map(claim).transpose()?;
    let found = match &esf_file {
        Some(_) => Some(fit_edge(&mut loaded, args.esf.as_deref(), args.backend)?),
        None => None,
    };
    let esf = if found.is_some() { None } else { args.esf.as_deref() };
    let calibrated = made(&mut loaded, esf, args.backend, &args.camera)?;
    let page = report::calibration_report(&loaded.plan, &calibrated).map_err(Failure::fail)?;
    page_file.write(page.as_bytes())?;
    let accepted = check(&calibrated.calibration);
    if accepted {
        let json = json_text(&calibrated.calibration)? + "\n";
        file.write(json.as_bytes())?;
        write_lens(lens_file, &calibrated.calibration)?;
        if let (Some(file), Some(text)) = (esf_file, found) {
            file.write(text.as_bytes())?;
        }
    } else {
        tracing::error!(
            "the check pin refuses this calibration; {} is not written, the report says why",
            out.display()
        );
    }
    say(args.json, &calibrated);
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
    made(loaded, esf, backend, &CameraArgs::default())
}

/// As [`make`], with a camera set so.
fn made(
    loaded: &mut LoadedPlan,
    esf: Option<&str>,
    backend: BackendChoice,
    camera: &CameraArgs,
) -> Result<Calibrated, Failure> {
    let LoadedPlan { plan, text, folder } = loaded;
    plan.validate().map_err(|e| text.refuse_at(e))?;
    if let Some(source) = plan.source.clone() {
        return with_camera(plan, (text, &source), esf, camera);
    }
    let failed = |e: CalibrateError| refused_or_failed(text, e);
    if plan.simulate.is_none() {
        let mut recordings = RecordedFrames::new(folder.clone(), plan.channel);
        choose_edge(plan, esf, |plan| rough_um_per_px(plan, &mut recordings).map_err(failed))?;
        return calibrate(plan, &mut Watched::new(plan, &mut recordings)).map_err(failed);
    }
    let renderer = Renderer::new(backend).map_err(Failure::fail)?;
    let rendered =
        |plan: &CalibrationPlan| SimulatedRecordings::new(plan, &renderer).map_err(|e| text.refuse(e));
    choose_edge(plan, esf, |plan| rough_um_per_px(plan, &mut rendered(plan)?).map_err(failed))?;
    calibrate(plan, &mut Watched::new(plan, &mut rendered(plan)?)).map_err(failed)
}

/// Fits lens and light to the masters, puts their edge into the plan, and returns the table that
/// states them.
///
/// # Errors
/// Exit 2 for masters before a camera, which are recorded first, and for optics that are refused;
/// 3 for frames that cannot be read.
fn fit_edge(loaded: &mut LoadedPlan, esf: Option<&str>, backend: BackendChoice) -> Result<String, Failure> {
    let LoadedPlan { plan, text, folder } = loaded;
    plan.validate().map_err(|e| text.refuse_at(e))?;
    if plan.source.is_some() {
        let why = "looks at the masters twice: record their frames, and name the folders";
        return Err(text.refuse(format!("--fit-esf: {why}")));
    }
    let stated = fit_esf::stated(esf)?;
    let failed = |e: CalibrateError| refused_or_failed(text, e);
    let renderer = Renderer::new(backend).map_err(Failure::fail)?;
    let mut recordings: Box<dyn Recordings + '_> = if plan.simulate.is_none() {
        Box::new(RecordedFrames::new(folder.clone(), plan.channel))
    } else {
        Box::new(SimulatedRecordings::new(plan, &renderer).map_err(|e| text.refuse(e))?)
    };
    let um_per_px = rough_um_per_px(plan, &mut *recordings).map_err(failed)?;
    let found = fit_esf::fitted(plan, &mut *recordings, &stated, um_per_px).map_err(failed)?;
    drop(recordings);
    plan.gauge.esf = found.model;
    fit_esf::in_toml(&found.fit)
}

/// Exit 2 for a key of the plan, 3 for everything else.
fn refused_or_failed(text: &ConfigText, error: CalibrateError) -> Failure {
    match error {
        CalibrateError::Setting(e) => text.refuse_at(e),
        other => Failure::fail(format!("{}: {other}", text.name)),
    }
}

/// Makes a plan's calibration with the camera that it names, to which it is then bound.
#[cfg(feature = "camera")]
fn with_camera(
    plan: &mut CalibrationPlan,
    (text, source): (&ConfigText, &str),
    esf: Option<&str>,
    args: &CameraArgs,
) -> Result<Calibrated, Failure> {
    if plan.channel.is_some() {
        let why = "is of colour frames, and cameras are measured in grey: leave it out";
        return Err(text.refuse_at(SettingError::at("channel", why)));
    }
    let mut frames = CameraFrames::open(plan, source, args)?;
    let made = choose_edge(plan, esf, |plan| {
        rough_um_per_px(plan, &mut frames).map_err(|e| refused_or_failed(text, e))
    })
    .and_then(|()| calibrate(plan, &mut frames).map_err(|e| refused_or_failed(text, e)));
    let mut made = made.map_err(|why| frames.interrupted().unwrap_or(why))?;
    made.calibration = made.calibration.with_camera(frames.binding());
    Ok(made)
}

/// Refuses: there is no client in this build.
#[cfg(not(feature = "camera"))]
fn with_camera(
    _plan: &mut CalibrationPlan,
    (text, source): (&ConfigText, &str),
    _esf: Option<&str>,
    _args: &CameraArgs,
) -> Result<Calibrated, Failure> {
    let right = "build it with it, or record the frames and name their folders (frames)";
    let why = format!("{source}: this program was built without the feature camera; {right}");
    Err(text.refuse_at(SettingError::at("source", why)))
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
