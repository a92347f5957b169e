//! `shadowgauge study deflection`: compliance of a held shaft over the position of a radial load.

use std::path::PathBuf;

use super::study_files::{ConfigText, StudyFolder, csv_text, json_text};
use super::{CommandResult, Failure, Outcome};
use crate::config;
use crate::report::html::Page;
use crate::report::plot::{Chart, Mark, Series};
use crate::studies::deflection::{BeamPart, DeflectionConfig, DeflectionStudy};

/// Arguments of `study deflection`.
#[derive(Debug, clap::Args)]
pub struct StudyDeflectionArgs {
    /// A beam ([part] and [process], as configs/beam_003.toml) or a whole job.
    config: PathBuf,
    /// Positions of the load, mm from the chuck face; eleven equally spaced ones by default.
    #[arg(long, value_name = "MM", num_args = 1.., value_delimiter = ',', allow_negative_numbers = true)]
    at: Vec<f64>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write deflection.csv, deflection.svg and report.html into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Runs the study.
///
/// # Errors
/// Exit 2 for a config or a position that is refused, 3 for a disk that fails.
pub fn run(args: &StudyDeflectionArgs) -> CommandResult {
    let text = ConfigText::read(&args.config)?;
    let beam = beam(&text)?;
    let study = beam.run(&args.at).map_err(|e| text.refuse(e))?;
    if let Some(out) = &args.out {
        let folder = StudyFolder::claim(out)?;
        write(&folder, &beam, &study)?;
        folder.finish()?;
    }
    if args.json {
        say_line!("{}", json_text(&study)?);
    } else {
        say_line!("{:>10}  {:>14}", "z / mm", "µm/N");
        for p in &study.positions {
            say_line!("{:10.2}  {:14.6}", p.z_mm, 1e3 * p.compliance_mm_per_n);
        }
        say_line!("largest at {:.2} mm: {:.6} µm/N", study.max.z_mm, 1e3 * study.max.compliance_mm_per_n);
    }
    Ok(Outcome::Done)
}

/// A beam's own config, or the part and the process of a job.
fn beam(text: &ConfigText) -> Result<DeflectionConfig, Failure> {
    let table: toml::Table = text.parse()?;
    let of_a_job = |key: &String| !["name", "part", "process"].contains(&key.as_str());
    let has_passes = table
        .get("part")
        .and_then(toml::Value::as_table)
        .is_some_and(|part| part.contains_key("nominal_diameter_mm"));
    let known_to_jobs = ["cutting", "scan", "masters", "camera", "optics", "light", "sensor", "control"];
    let is_job = table.keys().any(|key| of_a_job(key) && known_to_jobs.contains(&key.as_str()));
    if !is_job && !has_passes {
        return text.parse();
    }
    let job = config::parse(&text.text, &text.name).map_err(Failure::refused)?;
    Ok(DeflectionConfig {
        name: job.name,
        part: BeamPart {
            length_mm: job.part.length_mm,
            stock_diameter_mm: job.part.stock_diameter_mm,
            cut_diameter_mm: None,
            steps: Vec::new(),
        },
        process: job.process,
    })
}

fn write(folder: &StudyFolder, beam: &DeflectionConfig, study: &DeflectionStudy) -> Result<(), Failure> {
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
    folder.write("deflection.csv", &csv_text(&study.positions)?)?;
    folder.write("deflection.svg", svg.as_bytes())?;
    folder.write("report.html", page.finish().as_bytes())
}
