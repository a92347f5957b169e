//! `shadowgauge study optics`: what moves the edge of a round part before one head.

use std::path::PathBuf;
use std::time::SystemTime;

use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::{StudyFolder, csv_text, json_text};
use crate::cli::optics::{fitted_by, head_failure, load_head};
use crate::files::OutputFile;
use crate::gauge::calibration::Date;
use crate::report::optics_page;
use crate::studies::head::limb::{Effect, EffectPoint, LimbEffects, effects};
use crate::studies::head::{HeadSettings, HeadSetup};

/// Arguments of `study optics`.
#[derive(Debug, clap::Args)]
pub(crate) struct StudyOpticsArgs {
    /// A job's config with [camera] and [optics]: the head.
    config: PathBuf,
    /// Diameter of the part, mm; the config's without it.
    #[arg(long, value_name = "D", value_parser = above_zero)]
    diameter_mm: Option<f64>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write the values to this CSV file, a row each.
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
    /// Write the page to this HTML file.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Write optics.json, optics.csv and report.html into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

fn above_zero(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("a diameter above 0 in mm is needed".to_owned()),
    }
}

/// Runs the study.
///
/// # Errors
/// Exit 2 for a config or a diameter that is refused, 3 for a disk that fails.
pub(crate) fn run(args: &StudyOpticsArgs) -> CommandResult {
    let config = load_head(&args.config)?;
    let settings = HeadSettings::plain(args.diameter_mm, Date::of(SystemTime::now()));
    let failed = |e| head_failure(&config.file, &e);
    let head = HeadSetup::new(&config, &settings).map_err(failed)?;
    let claim = |path: &Option<PathBuf>| {
        path.as_deref().map(|path| OutputFile::claim(path, vec![args.config.clone()])).transpose()
    };
    let (csv_file, page_file) = (claim(&args.csv)?, claim(&args.report)?);
    let folder = StudyFolder::claim(args.out.as_deref())?;
    let found = effects(&head, fitted_by(&config)).map_err(failed)?;
    let csv = csv_text(&rows(&found))?;
    let page = optics_page(&found).map_err(Failure::fail)?;
    csv_file.map_or(Ok(()), |file| file.write(&csv))?;
    page_file.map_or(Ok(()), |file| file.write(page.as_bytes()))?;
    StudyFolder::fill(folder, |folder| {
        folder.write("optics.json", json_text(&found)?.as_bytes())?;
        folder.write("optics.csv", &csv)?;
        folder.write("report.html", page.as_bytes())
    })?;
    if args.json {
        say_line!("{}", json_text(&found)?);
    } else {
        in_words(&found);
    }
    Ok(Outcome::Done)
}

/// A row of optics.csv.
#[derive(serde::Serialize)]
struct Row {
    cause: &'static str,
    value: f64,
    name: &'static str,
    unit: &'static str,
    shift_um: f64,
    diameter_um: f64,
}

fn rows(found: &LimbEffects) -> Vec<Row> {
    let of = |effect: &Effect| {
        let (cause, unit) = (effect.kind.words(), effect.unit);
        let row = |p: &EffectPoint| Row {
            cause,
            value: p.value,
            name: p.name.unwrap_or_default(),
            unit,
            shift_um: p.shift_um,
            diameter_um: 2.0 * p.shift_um,
        };
        effect.points.iter().map(row).collect::<Vec<_>>()
    };
    found.effects.iter().flat_map(of).collect()
}

fn in_words(found: &LimbEffects) {
    say_line!(
        "Ø{} mm before {} (NA {}, S {}, {} nm): the edge lies {:+.3} µm outside the part",
        found.diameter_mm,
        found.name,
        found.numerical_aperture,
        found.coherence_ratio,
        found.wavelength_nm,
        found.shift_um
    );
    say_line!("{:<40} {:<64} {:>13}", "cause", "within", "diameter / µm");
    for effect in &found.effects {
        let cause = effect.kind.words();
        say_line!("{cause:<40} {:<64} {:>13.3}", effect.tolerance, effect.diameter_um);
    }
    say_line!("{:>6} {:>22} {:>36}", "S", "by depth / (µm/mm)", "by diameter, half to 1.5 times / µm");
    for r in &found.by_ratio {
        say_line!("{:6.2} {:22.3} {:36.3}", r.coherence_ratio, r.by_depth_um_per_mm, r.by_diameter_um);
    }
    say_line!("{}", found.advice.words);
}
