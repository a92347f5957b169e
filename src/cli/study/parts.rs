//! `shadowgauge study parts`: a batch, with and without learning from part to part, through
//! rendered and measured frames.

use std::path::PathBuf;

use crate::cli::failure::{CommandResult, Failure};
use crate::cli::input_output::{ConfigText, StudyFolder, csv_text, say_study};
use crate::cli::terminal::progress;
use crate::config;
use crate::control::{ControllerName, PartEvent};
use crate::job::Job;
use crate::render::{BackendChoice, Renderer};
use crate::report::html::Page;
use crate::report::plot::{Chart, Mark, Series};
use crate::studies::parts::{self, Batch, BatchSummary, PartPass, PartsStudy};

const CONFIG: &str = include_str!("../../../configs/parts.toml");

/// Arguments of `study parts`.
#[derive(Debug, clap::Args)]
pub(crate) struct StudyPartsArgs {
    /// The job; by default the preset's shaft with a wearing edge and a warming machine
    /// (configs/parts.toml).
    config: Option<PathBuf>,
    /// Parts of the batch.
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u32).range(2..=1000))]
    parts: u32,
    /// A new insert every N parts; 0 for never.
    #[arg(long, value_name = "N", default_value_t = 4)]
    insert_every: u32,
    /// Parts before which the machine cools down.
    #[arg(long, value_name = "PARTS", value_delimiter = ',', default_value = "11")]
    cold_at: Vec<u32>,
    /// none, pid, lsq, …: in place of the config's.
    #[arg(long, value_name = "NAME")]
    controller: Option<ControllerName>,
    /// Where frames are rendered.
    #[arg(long, value_enum, default_value_t = BackendChoice::Auto)]
    backend: BackendChoice,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write parts.csv, charts and report.html into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Runs the study.
///
/// # Errors
/// Exit 2 for a config or a controller that is refused, 3 for a device or a disk that fails.
pub(crate) fn run(args: &StudyPartsArgs) -> CommandResult {
    let text = ConfigText::read_or(args.config.as_deref(), "configs/parts.toml", CONFIG)?;
    let mut job = config::parse(&text.text, &text.name).map_err(Failure::refused)?;
    job.control.controller = args.controller.unwrap_or(job.control.controller);
    job.check_coverage().and_then(|()| job.check_control()).map_err(|e| text.refuse_at(e))?;
    let folder = StudyFolder::claim(args.out.as_deref())?;
    let renderer = Renderer::new(args.backend).map_err(Failure::fail)?;
    let batch = Batch { parts: args.parts, insert_every: args.insert_every, cold_at: args.cold_at.clone() };
    let bar = progress::bar(2 * u64::from(args.parts), "turning", "parts");
    let study = parts::run(&job, &batch, &renderer, &mut |learning, part| {
        tracing::info!(learning, part, "turned");
        bar.inc(1);
    })
    .map_err(Failure::fail)?;
    bar.finish_and_clear();
    StudyFolder::fill(folder, |folder| write(folder, &job, &study))?;
    say_study(&study, args.json, print)
}

fn way(learning: bool) -> &'static str {
    if learning { "learning from part to part" } else { "each part by itself" }
}

fn event(event: PartEvent) -> &'static str {
    match event {
        PartEvent::Continued => "",
        PartEvent::InsertChanged => "new insert",
        PartEvent::ColdStart => "cold start",
    }
}

fn print(study: &PartsStudy) {
    say_line!("controller {}, {} parts; largest true error, µm:", study.controller, study.batch.parts);
    for learning in [false, true] {
        say_line!("{}", way(learning));
        for part in 1..=study.batch.parts {
            let of: Vec<&PartPass> =
                study.passes.iter().filter(|p| p.learning == learning && p.part == part).collect();
            let errors: String = of.iter().map(|p| format!("{:8.2}", p.true_worst_mm * 1e3)).collect();
            let held = of.iter().filter(|p| !p.held.is_empty()).count();
            let held = if held > 0 { format!("held {held} times") } else { String::new() };
            say_line!("  part {part:>3} {errors}  {} {held}", event(study.batch.event(part)));
        }
    }
    for s in &study.summaries {
        say_line!("{}", sentence(s));
    }
}

fn sentence(s: &BatchSummary) -> String {
    let ppk = s.chart.ppk.map_or_else(String::new, |p| format!(", Ppk {p:.2}"));
    format!(
        "{}: first pass {:.2} µm (mean of parts 2 and later), finished part {:.2} µm (worst {:.2}); mean deviation {:+.2} ± \
         {:.2} µm (individuals chart, 3σ){ppk}",
        way(s.learning),
        s.first_pass_mm * 1e3,
        s.last_pass_mm * 1e3,
        s.last_pass_worst_mm * 1e3,
        s.chart.centre_mm * 1e3,
        s.chart.limit_mm * 1e3
    )
}

fn write(folder: &StudyFolder, job: &Job, study: &PartsStudy) -> Result<(), Failure> {
    let mut page = Page::new("Two loops: pass to pass within a part, part to part over a batch");
    page.text(&format!(
        "{} parts by controller {}, every pass cut, rendered, measured and corrected from the pixels; the batch is turned once \
         without and once with what earlier parts taught. The blanks, the machine and the noise are the same.",
        study.batch.parts, study.controller
    ));
    for s in &study.summaries {
        page.text(&sentence(s));
    }
    let passes = study.passes.iter().map(|p| p.pass).max().unwrap_or(1);
    for (pass, title, name) in
        [(1, "After the first pass", "first_pass.svg"), (passes, "Finished parts", "last_pass.svg")]
    {
        let svg = errors(study, pass)?;
        page.heading(title).figure(&svg, "Largest true error of every part, without and with learning.");
        folder.write(name, svg.as_bytes())?;
    }
    page.heading("Individuals charts");
    for s in &study.summaries {
        let svg = chart(job, study, s, passes)?;
        page.figure(
            &svg,
            &format!(
                "{}: mean deviation of the finished part from its aim, as measured; dashed: centre and 3σ limits from the mean \
                 moving range.{}",
                way(s.learning),
                if job.part.tolerance.is_some() { " Shaded: tolerance." } else { "" }
            ),
        );
        let name = if s.learning { "individuals_learning.svg" } else { "individuals_alone.svg" };
        folder.write(name, svg.as_bytes())?;
    }
    let held: Vec<Vec<String>> = study
        .passes
        .iter()
        .filter(|p| !p.held.is_empty())
        .map(|p| vec![way(p.learning).into(), p.part.to_string(), p.pass.to_string(), p.held.clone()])
        .collect();
    if !held.is_empty() {
        page.heading("Offsets held").table(&["batch", "part", "after pass", "reason"], &held);
    }
    folder.write("parts.csv", &csv_text(&study.passes)?)?;
    folder.write("report.html", page.finish().as_bytes())
}

fn errors(study: &PartsStudy, pass: u32) -> Result<String, Failure> {
    let series = [false, true]
        .into_iter()
        .enumerate()
        .map(|(i, learning)| {
            let of = study.passes.iter().filter(|p| p.learning == learning && p.pass == pass);
            let points = of.map(|p| (f64::from(p.part), p.true_worst_mm * 1e3)).collect();
            Series::new(way(learning), Mark::LineDots, i, points)
        })
        .collect();
    Chart {
        x_label: "part".to_owned(),
        y_label: "largest true error / µm".to_owned(),
        series,
        ..Chart::default()
    }
    .to_svg()
    .map_err(Failure::fail)
}

fn chart(job: &Job, study: &PartsStudy, s: &BatchSummary, pass: u32) -> Result<String, Failure> {
    let of = study.passes.iter().filter(|p| p.learning == s.learning && p.pass == pass);
    let points = of.map(|p| (f64::from(p.part), p.measured_mean_mm * 1e3)).collect();
    let level = |mm: f64| vec![(1.0, mm * 1e3), (f64::from(study.batch.parts), mm * 1e3)];
    let (centre, limit) = (s.chart.centre_mm, s.chart.limit_mm);
    let aim = job.part.target_mm(pass);
    let band = job
        .part
        .tolerance
        .map(|t| ((t.nominal_mm + t.lower_mm - aim) * 1e3, (t.nominal_mm + t.upper_mm - aim) * 1e3));
    Chart {
        x_label: "part".to_owned(),
        y_label: "mean deviation / µm".to_owned(),
        series: vec![
            Series::new("finished part", Mark::LineDots, 0, points),
            Series::new("centre", Mark::Dashed, 6, level(centre)),
            Series::new("limits", Mark::Dashed, 1, level(centre + limit)),
            Series::new("", Mark::Dashed, 1, level(centre - limit)),
        ],
        band,
        ..Chart::default()
    }
    .to_svg()
    .map_err(Failure::fail)
}
