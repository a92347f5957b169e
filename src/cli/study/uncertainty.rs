//! `shadowgauge study uncertainty`: Monte Carlo (JCGM 101) beside the GUM's law of propagation, for
//! an optical setup and a part.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::SystemTime;

use crate::cli::calibrate::make;
use crate::cli::calibration_plan::{self, LoadedPlan};
use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::{ConfigText, StudyFolder, json_text};
use crate::cli::terminal::progress;
use crate::gauge::calibration::Date;
use crate::gauge::monte_carlo::BLOCK;
use crate::gauge::stated::stated;
use crate::render::{BackendChoice, Renderer};
use crate::report::html::Page;
use crate::report::plot::{Chart, Mark, Series};
use crate::studies::coverage::{Class, ClassFigures, class_figures};
use crate::studies::uncertainty::{Draws, PartView, Trials, Uncertainty, uncertainty};

/// The preset.
const PRESET: &str = include_str!("../../../configs/calibrate.toml");

/// Arguments of `study uncertainty`.
#[derive(Debug, clap::Args)]
pub(crate) struct StudyUncertaintyArgs {
    /// A calibration, as configs/calibrate.toml; the built-in one without it.
    config: Option<PathBuf>,
    /// Trials; without it blocks of 10 000 are added until the figures are stable.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(20_000..=100_000_000))]
    trials: Option<u64>,
    /// Diameter of the part, mm; in the middle between the smallest and the largest master without
    /// it.
    #[arg(long, value_name = "D")]
    diameter_mm: Option<f64>,
    /// Rendered and measured scenes beside it (small frames, class "mixed" of `study coverage`).
    #[arg(long, value_name = "N", default_value_t = 0)]
    scenes: usize,
    /// Seed of the draws.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write uncertainty.json and report.html into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Where frames are rendered.
    #[arg(long, value_enum, default_value_t = BackendChoice::Auto)]
    backend: BackendChoice,
}

/// Runs the study.
///
/// # Errors
/// Exit 2 for a config that is refused; 3 for frames and disks that fail.
pub(crate) fn run(args: &StudyUncertaintyArgs) -> CommandResult {
    let mut loaded = match &args.config {
        Some(path) => calibration_plan::load(path, Date::of(SystemTime::now()))?,
        None => {
            let name = "built-in configs/calibrate.toml".to_owned();
            calibration_plan::of_text(ConfigText { text: PRESET.to_owned(), name }, PathBuf::new())?
        }
    };
    let folder = StudyFolder::claim(args.out.as_deref())?;
    let calibrated = make(&mut loaded, None, args.backend)?;
    let LoadedPlan { plan, .. } = &loaded;
    let calibration = &calibrated.calibration;
    let ends = plan.masters.iter().map(|m| m.diameter_mm);
    let (low, high) = ends.fold((f64::INFINITY, 0.0_f64), |(l, h), d| (l.min(d), h.max(d)));
    let diameter_mm = args.diameter_mm.unwrap_or(0.5 * (low + high));
    let part = calibrated
        .reading
        .as_ref()
        .and_then(|like| PartView::of_diameter(diameter_mm, like, calibration, &plan.conditions))
        .ok_or_else(|| {
            Failure::refuse(format!(
                "--diameter-mm {diameter_mm}: must be above 0 and fit the calibrated field"
            ))
        })?;
    let result = with_bar(args, |draws| {
        uncertainty(calibration, &calibrated.adjustment, &part, &plan.conditions, draws)
    })
    .ok_or_else(|| Failure::fail("the masters determine no bench"))?;
    let scenes = match args.scenes {
        0 => None,
        n => {
            let renderer = Renderer::new(BackendChoice::Cpu).map_err(Failure::fail)?;
            let bar = progress::bar(n as u64, "drawing and measuring", "scenes");
            let found = class_figures(Class::Mixed, n, args.seed, &renderer, &|| bar.inc(1));
            bar.finish_and_clear();
            Some(found.map_err(Failure::fail)?)
        }
    };
    StudyFolder::fill(folder, |folder| {
        folder.write("uncertainty.json", json_text(&result)?.as_bytes())?;
        let page = page(&result, scenes.as_ref()).map_err(Failure::fail)?;
        folder.write("report.html", page.as_bytes())
    })?;
    if args.json {
        say_line!("{}", serde_json::json!({ "uncertainty": result, "rendered": scenes }));
    } else {
        say!("{}", in_words(&result, scenes.as_ref()));
    }
    Ok(Outcome::Done)
}

/// Trials after which an adaptive Monte Carlo ends in any case.
const MOST_TRIALS: u64 = 2_000_000;

/// Draws the trials of the command line with a bar that counts them, a block at a time: a trial
/// takes less than drawing a bar. An adaptive Monte Carlo ends as soon as its figures are stable.
fn with_bar<T>(args: &StudyUncertaintyArgs, draw: impl FnOnce(Draws<'_>) -> T) -> T {
    let trials = args.trials.map_or(Trials::Adaptive(MOST_TRIALS as usize), |n| Trials::Fixed(n as usize));
    let bar = progress::bar(args.trials.unwrap_or(MOST_TRIALS), "drawing", "trials at most");
    let (drawn, block) = (AtomicU64::new(0), BLOCK as u64);
    let done = || {
        if (drawn.fetch_add(1, Ordering::Relaxed) + 1).is_multiple_of(block) {
            bar.inc(block);
        }
    };
    let result = draw(Draws { trials, seed: args.seed, done: &done });
    bar.finish_and_clear();
    result
}

fn rows(r: &Uncertainty) -> Vec<Vec<String>> {
    let row = |name: &str, y: f64, u: f64, ends: (f64, f64)| {
        let [value, _] = stated(y, u);
        let um = |end_mm: f64| stated(1e3 * (end_mm - r.y_mm), 1e3 * u)[0].clone();
        vec![name.to_owned(), value, stated(0.0, 1e3 * u)[1].clone(), um(ends.0), um(ends.1)]
    };
    vec![
        row("law of propagation (GUM)", r.y_mm, r.u_mm, r.interval_mm),
        row("Monte Carlo, symmetric", r.monte_carlo.y, r.monte_carlo.u, r.monte_carlo.symmetric),
        row("Monte Carlo, shortest", r.monte_carlo.y, r.monte_carlo.u, r.monte_carlo.shortest),
    ]
}

const HEADER: [&str; 5] = ["", "D / mm", "u / µm", "95 % from / µm", "to / µm"];

fn verdicts(r: &Uncertainty) -> Vec<String> {
    r.validation
        .iter()
        .zip([2, 1])
        .map(|(v, digits)| {
            format!(
                "GUM's interval {} at {digits} significant digit(s) of u: ends differ by {:.4} and {:.4} µm, tolerance {:.4} µm",
                if v.validated { "validated" } else { "NOT validated" },
                1e3 * v.d_low,
                1e3 * v.d_high,
                1e3 * v.tolerance
            )
        })
        .collect()
}

fn scenes_text(s: &ClassFigures) -> String {
    format!(
        "{} scenes rendered and measured (small frames): {:.1} % covered, rms error/u {:.3}, mean 95 % half width {:.3} µm, {:.1} % flagged",
        s.scenes,
        1e2 * s.covered,
        s.rms_error_over_u,
        s.mean_half_um,
        1e2 * s.flagged
    )
}

fn in_words(r: &Uncertainty, scenes: Option<&ClassFigures>) -> String {
    let mut text =
        format!("{:<28} {:>12} {:>9} {:>15} {:>9}\n", HEADER[0], HEADER[1], HEADER[2], HEADER[3], HEADER[4]);
    for row in rows(r) {
        text += &format!("{:<28} {:>12} {:>9} {:>15} {:>9}\n", row[0], row[1], row[2], row[3], row[4]);
    }
    text += &format!("{} trials\n", r.monte_carlo.trials);
    for verdict in verdicts(r) {
        text += &format!("{verdict}\n");
    }
    text += &format!("\n{:<36} {:>7} {:>10}\n", "source", "inputs", "u / µm");
    for s in &r.sources {
        text += &format!("{:<36} {:>7} {:>10.5}\n", s.name, s.inputs, s.u_um);
    }
    if let Some(scenes) = scenes {
        text += &format!("\n{}\n", scenes_text(scenes));
    }
    text
}

fn page(r: &Uncertainty, scenes: Option<&ClassFigures>) -> Result<String, String> {
    let mut page = Page::new(format!("Uncertainty of a diameter of {:.3} mm", r.y_mm));
    page.text(&format!(
        "{} trials through the whole measurement, masters and adjustment included.",
        r.monte_carlo.trials
    ));
    page.heading("Results").table(&HEADER, &rows(r));
    verdicts(r).iter().for_each(|v| {
        page.text(v);
    });
    page.figure(
        &histogram(r)?,
        "Density of the diameter by Monte Carlo and the normal density that the law of propagation implies.",
    );
    let rows: Vec<Vec<String>> = r
        .sources
        .iter()
        .map(|s| vec![s.name.clone(), s.inputs.to_string(), format!("{:.5}", s.u_um)])
        .collect();
    page.heading("Sources").table(&["source", "inputs", "u / µm"], &rows);
    if let Some(scenes) = scenes {
        page.heading("Rendered and measured").text(&scenes_text(scenes));
    }
    Ok(page.finish())
}

fn histogram(r: &Uncertainty) -> Result<String, String> {
    const BINS: usize = 80;
    let (half, n) = (4.0 * r.u_mm, r.monte_carlo.values.len() as f64);
    let width_um = 2e3 * half / BINS as f64;
    let mut counts = [0.0; BINS];
    for v in &r.monte_carlo.values {
        let at = ((v - r.y_mm + half) / (2.0 * half) * BINS as f64).floor();
        if (0.0..BINS as f64).contains(&at) {
            counts[at as usize] += 1.0 / n / width_um;
        }
    }
    let x = |i: usize| 1e3 * (-half) + (i as f64 + 0.5) * width_um;
    let u = 1e3 * r.u_mm;
    let normal = |x: f64| (-0.5 * (x / u).powi(2)).exp() / (u * (2.0 * std::f64::consts::PI).sqrt());
    Chart {
        x_label: "D − y / µm".into(),
        y_label: "density / µm⁻¹".into(),
        series: vec![
            Series::new("Monte Carlo", Mark::Line, 0, (0..BINS).map(|i| (x(i), counts[i])).collect()),
            Series::new(
                "law of propagation",
                Mark::Dashed,
                1,
                (0..BINS).map(|i| (x(i), normal(x(i)))).collect(),
            ),
        ],
        ..Chart::default()
    }
    .to_svg()
}
