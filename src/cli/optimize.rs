//! `shadowgauge optimize`: cutting data of shortest time under limits of size error and roughness.

use std::path::PathBuf;

use super::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::{ConfigText, StudyFolder, csv_text, json_text};
use crate::cli::terminal::progress;
use crate::report::html::Page;
use crate::report::plot::{Chart, Mark, Series};
use crate::studies::optimize::{self, Constraint, OptimizeConfig, Problem, Solution, Study};

/// Arguments of `optimize`.
#[derive(Debug, clap::Args)]
pub(crate) struct OptimizeArgs {
    /// The problem, as configs/optimize_003.toml.
    config: PathBuf,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// In place of the config's seed of the genetic algorithm.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Write front.csv, front.svg and report.html into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Solves the problem. An infeasible one is reported with the limits that exclude each other, and
/// ends with exit 1.
///
/// # Errors
/// Exit 2 for a config that is refused, 3 for a disk that fails.
pub(crate) fn run(args: &OptimizeArgs) -> CommandResult {
    let text = ConfigText::read(&args.config)?;
    let mut config: OptimizeConfig = text.parse()?;
    config.genetic.seed = args.seed.unwrap_or(config.genetic.seed);
    let problem = Problem::new(&config).map_err(|e| text.refuse(e))?;
    let folder = StudyFolder::claim(args.out.as_deref())?;
    let bar = progress::bar(optimize::searches(&config) as u64, "searching", "optima");
    let study = optimize::study(&problem, &config, &|| bar.inc(1));
    bar.finish_and_clear();
    StudyFolder::fill(folder, |folder| write(folder, &config, &problem, &study))?;
    if args.json {
        say_line!("{}", json_text(&study)?);
    } else {
        say!("{}", in_words(&study));
    }
    Ok(if study.feasible { Outcome::Done } else { Outcome::OutOfTolerance })
}

fn line(name: &str, s: &Solution) -> String {
    format!(
        "{name:<12} v {:8.4} m/min  f {:.6} mm/r  a_p {:.5} mm  t {:.5} min  error {:.2} µm  roughness {:.3} µm\n",
        s.point.speed_m_per_min,
        s.point.feed_mm_per_rev,
        s.point.depth_mm,
        s.time_min,
        1e3 * s.size_error_mm,
        s.roughness_um
    )
}

fn in_words(study: &Study) -> String {
    let mut text = String::new();
    if let Some(conflict) = &study.conflict {
        text += &format!("infeasible ({}): {}\n", names(&conflict.constraints), conflict.explanation);
        text += &line("nearest", &conflict.nearest);
    }
    if let Some(optimum) = &study.optimum {
        text += &line("optimum", optimum);
        let gap = study.proven_gap.unwrap_or(f64::NAN);
        text += &format!(
            "             held by {}; no point is shorter by more than {gap:.1e}\n",
            names(&optimum.active)
        );
    }
    if let Some(genetic) = &study.genetic {
        text += &line("genetic", &genetic.solution);
        text += &format!(
            "             {:.4} % longer, {} evaluations\n",
            100.0 * genetic.gap,
            genetic.evaluations
        );
    }
    for reference in &study.references {
        text += &line(&reference.name, &reference.solution);
        let gap = reference.gap.map_or(String::new(), |gap| format!("{:.2} % longer, ", 100.0 * gap));
        text += &format!("             {gap}breaks {}\n", names(&reference.violated));
    }
    study.notes.iter().for_each(|note| text += &format!("note: {note}\n"));
    text
}

fn names(constraints: &[Constraint]) -> String {
    let name = |c: &Constraint| match c {
        Constraint::SizeError => "size error",
        Constraint::Roughness => "roughness",
        Constraint::Speed => "speed",
        Constraint::Feed => "feed",
        Constraint::Depth => "depth",
    };
    let names: Vec<&str> = constraints.iter().map(name).collect();
    if names.is_empty() { "nothing".to_owned() } else { names.join(", ") }
}

/// The points of a study, as cells.
fn points(study: &Study) -> Vec<Vec<String>> {
    let cells = |name: &str, s: &Solution, gap: Option<f64>, broken: &[Constraint]| {
        vec![
            name.to_owned(),
            format!("{:.3}", s.point.speed_m_per_min),
            format!("{:.5}", s.point.feed_mm_per_rev),
            format!("{:.5}", s.point.depth_mm),
            format!("{:.4}", s.time_min),
            gap.map_or("-".to_owned(), |gap| format!("{:.3} %", 100.0 * gap)),
            format!("{:.2}", 1e3 * s.size_error_mm),
            names(broken),
        ]
    };
    let optimum = study.optimum.iter().map(|s| cells("optimum", s, None, &[]));
    let nearest = study.conflict.iter().map(|c| cells("nearest", &c.nearest, None, &c.constraints));
    let genetic = study.genetic.iter().map(|g| cells("genetic algorithm", &g.solution, Some(g.gap), &[]));
    let references = study.references.iter().map(|r| cells(&r.name, &r.solution, r.gap, &r.violated));
    optimum.chain(nearest).chain(genetic).chain(references).collect()
}

/// A row of front.csv.
#[derive(serde::Serialize)]
struct FrontRow {
    size_error_mm: f64,
    time_min: f64,
    speed_m_per_min: f64,
    feed_mm_per_rev: f64,
    depth_mm: f64,
}

fn front_rows(study: &Study) -> Vec<FrontRow> {
    study
        .front
        .iter()
        .map(|s| FrontRow {
            size_error_mm: s.size_error_mm,
            time_min: s.time_min,
            speed_m_per_min: s.point.speed_m_per_min,
            feed_mm_per_rev: s.point.feed_mm_per_rev,
            depth_mm: s.point.depth_mm,
        })
        .collect()
}

/// The result in words.
fn verdict(page: &mut Page, study: &Study) {
    match (&study.conflict, &study.optimum) {
        (Some(conflict), _) => {
            page.text(&format!("Infeasible: {}.", conflict.explanation));
        }
        (None, Some(optimum)) => {
            page.text(&format!(
                "The optimum is held by {}; no feasible point is shorter by more than {:.0e} (branch and bound).",
                names(&optimum.active),
                study.proven_gap.unwrap_or(f64::NAN)
            ));
        }
        (None, None) => {}
    }
    study.notes.iter().for_each(|note| {
        page.text(note);
    });
}

fn write(
    folder: &StudyFolder,
    config: &OptimizeConfig,
    problem: &Problem,
    study: &Study,
) -> Result<(), Failure> {
    let rows = front_rows(study);
    let svg = front_chart(problem, study).to_svg().map_err(Failure::fail)?;
    let mut page = Page::new(format!("Cutting data: {}", config.name));
    verdict(&mut page, study);
    page.table(
        &[
            "point",
            "v / (m/min)",
            "f / (mm/r)",
            "a_p / mm",
            "time / min",
            "longer",
            "size error / µm",
            "breaks",
        ],
        &points(study),
    );
    page.figure(
        &svg,
        "Shortest time at every limit of the size error; the vertical line is the limit asked for.",
    );
    let cells = |s: &FrontRow| {
        vec![
            format!("{:.3}", 1e3 * s.size_error_mm),
            format!("{:.4}", s.time_min),
            format!("{:.3}", s.speed_m_per_min),
            format!("{:.5}", s.feed_mm_per_rev),
            format!("{:.5}", s.depth_mm),
        ]
    };
    page.table(
        &["size error / µm", "time / min", "v / (m/min)", "f / (mm/r)", "a_p / mm"],
        &rows.iter().map(cells).collect::<Vec<_>>(),
    );
    if let Some(chart) = generations_chart(study) {
        let svg = chart.to_svg().map_err(Failure::fail)?;
        page.figure(&svg, "Genetic algorithm: time of the best of every generation that keeps the limits; dashed: the optimum.");
        folder.write("generations.svg", svg.as_bytes())?;
    }
    if !study.passes.is_empty() {
        let svg = passes_chart(study).to_svg().map_err(Failure::fail)?;
        page.figure(&svg, "Time over the number of passes at the optimum: eq. 5 gives the last pass alone.");
        folder.write("passes.svg", svg.as_bytes())?;
    }
    folder.write("front.csv", &csv_text(&rows)?)?;
    folder.write("front.svg", svg.as_bytes())?;
    folder.write("report.html", page.finish().as_bytes())
}

fn front_chart(problem: &Problem, study: &Study) -> Chart {
    let of = |s: &Solution| (1e3 * s.size_error_mm, s.time_min);
    let front: Vec<(f64, f64)> = study.front.iter().map(of).collect();
    let times = front.iter().map(|p| p.1);
    let (low, high) = times.fold((f64::INFINITY, 0.0), |(l, h), t| (f64::min(l, t), f64::max(h, t)));
    let limit = 1e3 * problem.size_limit_mm;
    let mut series = vec![
        Series::new("shortest time", Mark::LineDots, 0, front),
        Series::new("limit", Mark::Dashed, 6, vec![(limit, low), (limit, high)]),
    ];
    if let Some(optimum) = &study.optimum {
        series.push(Series::new("optimum", Mark::Dots, 1, vec![of(optimum)]));
    }
    if let Some(genetic) = &study.genetic {
        series.push(Series::new("genetic algorithm", Mark::Dots, 2, vec![of(&genetic.solution)]));
    }
    for (index, reference) in study.references.iter().enumerate() {
        series.push(Series::new(&reference.name, Mark::Dots, 3 + index, vec![of(&reference.solution)]));
    }
    Chart {
        x_label: "size error / µm of diameter".to_owned(),
        y_label: "machining time / min".to_owned(),
        series,
        ..Chart::default()
    }
}

fn generations_chart(study: &Study) -> Option<Chart> {
    let (genetic, optimum) = (study.genetic.as_ref()?, study.optimum.as_ref()?);
    let feasible = genetic.generations.iter().filter(|g| g.violation == 0.0);
    let points: Vec<(f64, f64)> = feasible.map(|g| (g.generation as f64, g.time_min)).collect();
    let ends = vec![(0.0, optimum.time_min), (points.last()?.0, optimum.time_min)];
    Some(Chart {
        x_label: "generation".to_owned(),
        y_label: "machining time / min".to_owned(),
        series: vec![
            Series::new("best of the generation", Mark::Line, 2, points),
            Series::new("optimum", Mark::Dashed, 1, ends),
        ],
        ..Chart::default()
    })
}

fn passes_chart(study: &Study) -> Chart {
    let of = |value: fn(&optimize::PassTime) -> f64| -> Vec<(f64, f64)> {
        study.passes.iter().map(|t| (f64::from(t.passes), value(t))).collect()
    };
    Chart {
        x_label: "passes n".to_owned(),
        y_label: "time / min".to_owned(),
        series: vec![
            Series::new("all passes", Mark::LineDots, 0, of(|t| t.total_min)),
            Series::new("eq. 5, the last pass", Mark::LineDots, 1, of(|t| t.equation_5_min)),
        ],
        x_labels: Some(study.passes.len()),
        ..Chart::default()
    }
}
