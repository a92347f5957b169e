//! `shadowgauge study stability`: poles, limits of the plant gain and transients of every
//! controller.

use std::path::PathBuf;

use crate::cli::failure::{CommandResult, Failure};
use crate::cli::input_output::{ConfigText, StudyFolder, csv_text, say_study};
use crate::config;
use crate::control::stability::StabilityReport;
use crate::report::html::Page;
use crate::report::plot::{Chart, Mark, Series};
use crate::studies::stability::{self, StabilityStudy};

/// Arguments of `study stability`.
#[derive(Debug, clap::Args)]
pub(crate) struct StudyStabilityArgs {
    /// A job whose [control] table is judged; the built-in preset by default.
    config: Option<PathBuf>,
    /// Plant gain g in place of the config's.
    #[arg(long, value_name = "G")]
    gain: Option<f64>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write stability.csv, stability.svg and report.html into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// One loop as a row of `stability.csv`.
#[derive(serde::Serialize)]
struct Row {
    controller: String,
    plant: String,
    plant_gain: f64,
    stable: bool,
    spectral_radius: f64,
    stable_gains: String,
    gain_margin: Option<f64>,
    peak_error: f64,
    transient_growth: f64,
}

/// Runs the study.
///
/// # Errors
/// Exit 2 for a config or a gain that is refused, 3 for a disk that fails.
pub(crate) fn run(args: &StudyStabilityArgs) -> CommandResult {
    let text = ConfigText::read_or(args.config.as_deref(), "slender_shaft.toml", config::SLENDER_SHAFT)?;
    let job = config::parse(&text.text, &text.name).map_err(Failure::refused)?;
    let mut settings = job.loop_job().run_control();
    settings.plant_gain = args.gain.unwrap_or(settings.plant_gain);
    settings.validate().map_err(|e| text.refuse(e))?;
    let study = stability::run(&settings, &job.loop_job().station_z_mm());
    StudyFolder::fill(StudyFolder::claim(args.out.as_deref())?, |folder| write(folder, &study))?;
    say_study(&study, args.json, print)
}

fn rows(study: &StabilityStudy) -> Vec<Row> {
    let row = |r: &StabilityReport| Row {
        controller: r.controller.clone(),
        plant: r.plant.clone(),
        plant_gain: r.plant_gain,
        stable: r.stable,
        spectral_radius: r.spectral_radius,
        stable_gains: r.range_text(),
        gain_margin: r.gain_margin,
        peak_error: r.peak_error,
        transient_growth: r.transient_growth,
    };
    study.loops.iter().map(row).collect()
}

fn print(study: &StabilityStudy) {
    for r in rows(study) {
        let verdict = if r.stable { "stable  " } else { "UNSTABLE" };
        let margin = r.gain_margin.map_or_else(|| "-".to_owned(), |m| format!("{m:.2}"));
        say_line!(
            "{verdict} at g = {:<5} radius {:.4}  margin {margin:>5}  peak {:>7}  {}  {}: {}",
            r.plant_gain,
            r.spectral_radius,
            peak_text(&r),
            r.controller,
            r.plant,
            r.stable_gains
        );
    }
    for d in &study.delays {
        say_line!(
            "run to run, delay {}: stable for 0 < λb/b̂ < {:.4} (closed form {:.4})",
            d.delay,
            d.limit,
            d.closed_form
        );
    }
    let l = &study.learning;
    say_line!(
        "iterative learning along the shaft: spectral radius {:.4}, norm {:.4}{}",
        l.spectral_radius,
        l.norm,
        if l.norm < 1.0 { ": the error never grows on the way" } else { "" }
    );
}

fn write(folder: &StudyFolder, study: &StabilityStudy) -> Result<(), Failure> {
    let mut series = vec![Series::new("limit", Mark::Dashed, 6, vec![(0.0, 1.0), (2.4, 1.0)])];
    for (i, locus) in study.loci.iter().enumerate() {
        series.push(Series::new(locus.controller.clone(), Mark::Line, i, locus.points.clone()));
    }
    let svg = Chart {
        x_label: "plant gain g".to_owned(),
        y_label: "spectral radius, error copying".to_owned(),
        series,
        y_range: Some((0.0, 2.0)),
        ..Chart::default()
    }
    .to_svg()
    .map_err(Failure::fail)?;
    let rows = rows(study);
    let locus = root_locus(study)?;
    let mut page = Page::new("Stability of the loop from pass to pass");
    page.text(
        "e(k+1) = α e(k) − g o(k+1): α = 0 with a constant disturbance, 1 − g with error copying, 1.3566 for the \
         error-transfer plant of paper 003. Stable where every pole lies inside the unit circle.",
    );
    page.figure(&svg, "Spectral radius over the plant gain, drawn up to 2; below 1 errors die out.");
    page.figure(
        &locus,
        "Root locus: every pole of every loop with error copying as the plant gain goes from 0.01 to 2.4; dashed: unit circle.",
    );
    table(&mut page, &rows);
    folder.write("stability.csv", &csv_text(&rows)?)?;
    folder.write("stability.svg", svg.as_bytes())?;
    folder.write("root_locus.svg", locus.as_bytes())?;
    folder.write("report.html", page.finish().as_bytes())
}

/// Poles inside |z| ≤ 2.2 (those further out are unstable in any case and would compress the
/// scale).
fn root_locus(study: &StabilityStudy) -> Result<String, Failure> {
    let circle = (0..=120).map(|i| f64::from(i) * std::f64::consts::TAU / 120.0).map(|a| (a.cos(), a.sin()));
    let mut series = vec![Series::new("unit circle", Mark::Dashed, 6, circle.collect())];
    for (i, locus) in study.loci.iter().enumerate() {
        let near = locus.poles.iter().copied().filter(|p| p.0.hypot(p.1) <= 2.2);
        series.push(Series::new(locus.controller.clone(), Mark::Dots, i, near.collect()));
    }
    Chart {
        x_label: "real part".to_owned(),
        y_label: "imaginary part".to_owned(),
        series,
        equal_axes: true,
        ..Chart::default()
    }
    .to_svg()
    .map_err(Failure::fail)
}

/// The largest error of a loop whose errors die out.
fn peak_text(row: &Row) -> String {
    if row.stable { format!("{:.3}", row.peak_error) } else { "grows".to_owned() }
}

fn table(page: &mut Page, rows: &[Row]) {
    let cells: Vec<Vec<String>> = rows
        .iter()
        .map(|r| {
            vec![
                r.controller.clone(),
                r.plant.clone(),
                if r.stable { "stable".into() } else { "unstable".into() },
                format!("{:.4}", r.spectral_radius),
                r.stable_gains.clone(),
                r.gain_margin.map_or_else(String::new, |m| format!("{m:.2}")),
                peak_text(r),
            ]
        })
        .collect();
    page.table(&["controller", "plant", "verdict", "radius", "stable for", "margin", "peak"], &cells);
}
