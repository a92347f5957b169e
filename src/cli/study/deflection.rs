//! `shadowgauge study deflection`: compliance of a supported shaft over the position of a radial
//! load.

use std::path::PathBuf;

use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::{ConfigText, StudyFolder, csv_text, json_text};
use crate::config;
use crate::job::Job;
use crate::plan::Piece;
use crate::process::{BaseForm, Stock};
use crate::report::html::Page;
use crate::report::plot::{Chart, Mark, Series};
use crate::studies::deflection::{BeamPart, DeflectionConfig, DeflectionStudy, Step};
use crate::studies::deflection_line::{LineCase, LineRow, LineStudy};

/// Arguments of `study deflection`.
#[derive(Debug, clap::Args)]
pub(crate) struct StudyDeflectionArgs {
    /// A beam ([part] and [process], as configs/beam_003.toml) or a whole job.
    config: PathBuf,
    /// Positions of the load, mm from the chuck face; eleven equally spaced ones by default.
    #[arg(long, value_name = "MM", num_args = 1.., value_delimiter = ',', allow_negative_numbers = true)]
    at: Vec<f64>,
    /// The axis in both planes besides: self weight, tailstock, cutting force, chuck and bow, with
    /// the tool at --tool.
    #[arg(long)]
    line: bool,
    /// Machine z of the tool for --line, mm; by default where the shaft yields most.
    #[arg(
        long,
        value_name = "MM",
        requires = "line",
        conflicts_with = "clear",
        allow_negative_numbers = true
    )]
    tool: Option<f64>,
    /// The tool clear after the first pass, for --line.
    #[arg(long, requires = "line")]
    clear: bool,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write deflection.csv, deflection.svg and report.html (--line: axis.csv, axis.svg) into this
    /// folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Runs the study.
///
/// # Errors
/// Exit 2 for a config or a position that is refused, 3 for a disk that fails.
pub(crate) fn run(args: &StudyDeflectionArgs) -> CommandResult {
    let text = ConfigText::read(&args.config)?;
    let Input { beam, line } = read(&text)?;
    let study = beam.run(&args.at).map_err(|e| text.refuse(e))?;
    let line = match args.line {
        true => Some(lines(args, &line, study.max.z_mm).map_err(|e| text.refuse(e))?),
        false => None,
    };
    StudyFolder::fill(StudyFolder::claim(args.out.as_deref())?, |folder| {
        write(folder, &beam, &study, line.as_ref())
    })?;
    if args.json {
        let mut json = serde_json::to_value(&study).map_err(Failure::fail)?;
        if let Some(line) = &line {
            json["line"] = serde_json::to_value(line).map_err(Failure::fail)?;
        }
        say_line!("{}", json_text(&json)?);
    } else {
        say_line!("{:>10}  {:>14}", "z / mm", "µm/N");
        for p in &study.positions {
            say_line!("{:10.2}  {:14.6}", p.z_mm, 1e3 * p.compliance_mm_per_n);
        }
        say_line!("largest at {:.2} mm: {:.6} µm/N", study.max.z_mm, 1e3 * study.max.compliance_mm_per_n);
        if let Some(line) = &line {
            print(line);
        }
    }
    Ok(Outcome::Done)
}

/// A beam, and the shaft whose axis is plotted.
struct Input {
    beam: DeflectionConfig,
    line: LineCase,
}

/// A beam's own config, or the part and the process of a job.
fn read(text: &ConfigText) -> Result<Input, Failure> {
    let table = text.tables()?;
    let of_a_job = |key: &String| !["name", "part", "process"].contains(&key.as_str());
    let has_passes = table
        .get("part")
        .and_then(toml::Value::as_table)
        .is_some_and(|part| part.contains_key("nominal_diameter_mm"));
    let known_to_jobs = ["cutting", "scan", "masters", "camera", "optics", "light", "sensor", "control"];
    let is_job = table.keys().any(|key| of_a_job(key) && known_to_jobs.contains(&key.as_str()));
    if !is_job && !has_passes {
        let beam: DeflectionConfig = text.parse()?;
        let line = LineCase {
            process: beam.process.clone(),
            stock: Stock { diameter_mm: beam.part.stock_diameter_mm, length_mm: beam.part.length_mm },
            form: BaseForm::default(),
            nominal_mm: beam.part.cut_diameter_mm.filter(|d| *d < beam.part.stock_diameter_mm),
            cutting: Job::default().cutting,
            seed: 0,
        };
        return Ok(Input { beam, line });
    }
    let job = config::parse(&text.text, &text.name).map_err(Failure::refused)?;
    let line = LineCase {
        process: job.process.clone(),
        stock: Stock { diameter_mm: job.part.stock_diameter_mm, length_mm: job.part.length_mm },
        form: crate::cell::base_form(&job).map_err(|e| text.refuse(e))?,
        nominal_mm: Some(job.part.target_mm(1)),
        cutting: job.cutting,
        seed: job.seed,
    };
    let steps = steps(&job);
    let beam = DeflectionConfig {
        name: job.name,
        part: BeamPart {
            length_mm: job.part.length_mm,
            stock_diameter_mm: job.part.stock_diameter_mm,
            cut_diameter_mm: None,
            steps,
        },
        process: job.process,
    };
    Ok(Input { beam, line })
}

/// The blank of a stepped shaft: its contour with the allowance of all passes.
fn steps(job: &Job) -> Vec<Step> {
    let contour = job.loop_job().turned_contour();
    let stock_mm = job.part.stock_diameter_mm;
    let step = |p: Piece| Step { from_mm: p.from_mm, to_mm: p.to_mm, diameter_mm: stock_mm + p.relative_mm };
    contour.into_iter().flat_map(|c| c.pieces()).map(step).collect()
}

/// The requested lines.
fn lines(args: &StudyDeflectionArgs, case: &LineCase, softest_mm: f64) -> Result<LineStudy, String> {
    let tool = args.tool.or(Some(softest_mm)).filter(|_| !args.clear);
    if let Some(z) = tool.filter(|z| !(0.0..=case.stock.length_mm).contains(z)) {
        return Err(format!("--tool {z}: must lie between 0 and {} mm", case.stock.length_mm));
    }
    case.run(tool).map_err(|e| e.to_string())
}

fn print(line: &LineStudy) {
    match line.tool_z_mm {
        Some(z) => say_line!(
            "\naxis in the first pass, tool at {z:.2} mm: radial {:.1} N, tangential {:.1} N, feed {:.1} N; the diameter there has grown by {:.2} µm",
            line.force.passive_n,
            line.force.cutting_n,
            line.force.feed_n,
            line.thermal_growth_um
        ),
        None => say_line!(
            "\naxis after the first pass, tool clear; the diameter has grown by {:.2} µm",
            line.thermal_growth_um
        ),
    }
    say_line!("µm along x (up in the image) and y (towards the camera); chuck and bow turn with the part");
    say_line!(
        "{:>8} {:>17} {:>17} {:>17} {:>17} {:>17} {:>17} {:>9}",
        "z / mm",
        "weight",
        "tailstock",
        "force",
        "standing still",
        "chuck",
        "bow",
        "run-out"
    );
    for r in &line.rows {
        let pair = |x: f64, y: f64| format!("{x:8.3} {y:8.3}");
        say_line!(
            "{:8.2} {} {} {} {} {} {} {:9.3}",
            r.z_mm,
            pair(r.weight_x_um, r.weight_y_um),
            pair(r.tailstock_x_um, r.tailstock_y_um),
            pair(r.force_x_um, r.force_y_um),
            pair(r.still_x_um, r.still_y_um),
            pair(r.chuck_x_um, r.chuck_y_um),
            pair(r.bow_x_um, r.bow_y_um),
            r.run_out_um
        );
    }
}

fn axis_chart(line: &LineStudy) -> Chart {
    let along = |f: fn(&LineRow) -> f64| line.nodes.iter().map(|r| (r.z_mm, f(r))).collect::<Vec<_>>();
    let series = vec![
        Series::new("still, x (image)", Mark::Line, 0, along(|r| r.still_x_um)),
        Series::new("still, y (towards the camera)", Mark::Line, 1, along(|r| r.still_y_um)),
        Series::new("weight, x", Mark::Faint, 0, along(|r| r.weight_x_um)),
        Series::new("weight, y", Mark::Faint, 1, along(|r| r.weight_y_um)),
        Series::new("turning: half the run-out", Mark::Dashed, 2, along(|r| 0.5 * r.run_out_um)),
    ];
    Chart {
        x_label: "z from the chuck / mm".to_owned(),
        y_label: "axis from the spindle's axis / µm".to_owned(),
        series,
        ..Chart::default()
    }
}

fn write(
    folder: &StudyFolder,
    beam: &DeflectionConfig,
    study: &DeflectionStudy,
    axis: Option<&LineStudy>,
) -> Result<(), Failure> {
    let shaft = beam.shaft().map_err(Failure::refuse)?;
    let line = (0..=400)
        .map(|i| f64::from(i) * beam.part.length_mm / 400.0)
        .map(|z| (z, 1e3 * shaft.compliance_mm_per_n(z)))
        .collect();
    let asked = study.positions.iter().map(|p| (p.z_mm, 1e3 * p.compliance_mm_per_n)).collect();
    let svg = Chart {
        x_label: "position of the load / mm from the chuck".to_owned(),
        y_label: "radial deflection at the load / (µm/N)".to_owned(),
        series: vec![
            Series::new("", Mark::Line, 0, line),
            Series::new("positions asked for", Mark::Dots, 1, asked),
        ],
        ..Chart::default()
    }
    .to_svg()
    .map_err(Failure::fail)?;
    let mut page = Page::new(format!("Deflection under a travelling load: {}", beam.name));
    page.text("Radial deflection at the tool per newton of radial force; the diameter error is twice that.");
    page.figure(
        &svg,
        &format!("Largest {:.6} µm/N at {:.2} mm.", 1e3 * study.max.compliance_mm_per_n, study.max.z_mm),
    );
    if let Some(line) = axis {
        let axis = axis_chart(line).to_svg().map_err(Failure::fail)?;
        let place = line.tool_z_mm.map_or("clear".to_owned(), |z| format!("at {z:.2} mm"));
        page.heading("The axis in both planes");
        page.figure(&axis, &format!("First pass, tool {place}; single parts stand in axis.csv."));
        folder.write("axis.csv", &csv_text(&line.nodes)?)?;
        folder.write("axis.svg", axis.as_bytes())?;
    }
    folder.write("deflection.csv", &csv_text(&study.positions)?)?;
    folder.write("deflection.svg", svg.as_bytes())?;
    folder.write("report.html", page.finish().as_bytes())
}
