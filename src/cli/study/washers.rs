//! `shadowgauge study washers`: images of rings of calibrated size, the gauge beside a simple
//! method.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::{StudyFolder, json_text};
use crate::cli::terminal::progress;
use crate::report::washers_page;
use crate::source::{FileFrames, list_images};
use crate::studies::washers::{MethodFigures, Pair, Part, SIDES, WashersError, WashersStudy, washers};

/// Arguments of `study washers`.
#[derive(Debug, clap::Args)]
pub(crate) struct StudyWashersArgs {
    /// Folder with pictures named by the part's number and cmm.csv (columns part,
    /// outer_diameter_mm, inner_diameter_mm).
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write report.html and a picture of every part that departs into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Runs the study; exit 1 where a bootstrap shows the gauge to be worse than the simple method.
///
/// # Errors
/// Exit 2 for an output folder that holds anything or too few parts, 3 for files that cannot be
/// read and parts that cannot be measured.
pub(crate) fn run(args: &StudyWashersArgs) -> CommandResult {
    let folder = StudyFolder::claim(args.out.as_deref())?;
    let parts = read(&args.folder)?;
    let bar = progress::bar(parts.len() as u64, "measuring", "rings");
    let study = washers(&parts, &|| bar.inc(1)).map_err(|e| match e {
        WashersError::TooFew(_) => Failure::refuse(e),
        e => Failure::fail(e),
    })?;
    bar.finish_and_clear();
    StudyFolder::fill(folder, |folder| {
        let (page, pictures) = washers_page(&study, &parts).map_err(Failure::fail)?;
        folder.write("report.html", page.as_bytes())?;
        pictures.iter().try_for_each(|(name, svg)| folder.write(name, svg.as_bytes()))
    })?;
    let misses = study.misses();
    if args.json {
        say_line!("{}", json_text(&serde_json::json!({ "washers": study, "misses": misses }))?);
    } else {
        print(&study);
        for miss in &misses {
            say_line!("MISSED  {miss}");
        }
    }
    Ok(if misses.is_empty() { Outcome::Done } else { Outcome::OutOfTolerance })
}

/// Images with the coordinate measuring machine's values, in the order of their names; an image
/// without values, or values without an image, is reported and left out.
fn read(folder: &Path) -> Result<Vec<Part>, Failure> {
    let mut machine = machine_values(&folder.join("cmm.csv"))?;
    let mut parts = Vec::new();
    for path in list_images(folder).map_err(Failure::fail)? {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let number = path.file_stem().and_then(|s| s.to_str()).and_then(|s| s.parse::<u32>().ok());
        let Some(machine_mm) = number.and_then(|n| machine.remove(&n)) else {
            tracing::warn!("{name}: no values in cmm.csv; left out");
            continue;
        };
        let Some(stored) = FileFrames::new(vec![path]).next_stored() else { continue };
        parts.push(Part { name, frame: stored.map_err(Failure::fail)?.frame, machine_mm });
    }
    let mut without: Vec<u32> = machine.into_keys().collect();
    without.sort_unstable();
    if !without.is_empty() {
        tracing::warn!("cmm.csv: parts {without:?} have no picture; left out");
    }
    Ok(parts)
}

fn machine_values(path: &Path) -> Result<HashMap<u32, Pair>, Failure> {
    let named = |e: &dyn std::fmt::Display| Failure::fail(format!("{}: {e}", path.display()));
    let mut reader = csv::Reader::from_path(path).map_err(|e| named(&e))?;
    let header = reader.headers().map_err(|e| named(&e))?.clone();
    let at = |column: &str| {
        header.iter().position(|h| h == column).ok_or_else(|| named(&format!("there is no column {column}")))
    };
    let columns = [at("part")?, at("outer_diameter_mm")?, at("inner_diameter_mm")?];
    let mut values = HashMap::new();
    for record in reader.records() {
        let record = record.map_err(|e| named(&e))?;
        let number = |k: usize| match record.get(columns[k]).unwrap_or("").parse::<f64>() {
            Ok(v) if v.is_finite() && v > 0.0 => Ok(v),
            _ => Err(named(&format!("a number above 0 is needed in every cell, not {record:?}"))),
        };
        values.insert(number(0)? as u32, [number(1)?, number(2)?]);
    }
    Ok(values)
}

fn print(study: &WashersStudy) {
    say_line!(
        "leave-one-out over {} parts, one scale and one edge offset for outer and inner",
        study.names.len()
    );
    say_line!(
        "{:<50} {:>9} {:>7} {:>9} {:>7} {:>10} {:>9}",
        "method, residuals in um",
        "outer sd",
        "robust",
        "inner sd",
        "robust",
        "um/px",
        "offset px"
    );
    let row = |m: &MethodFigures| {
        say_line!(
            "{:<50} {:>9.2} {:>7.2} {:>9.2} {:>7.2} {:>10.4} {:>+9.3}",
            m.name,
            m.sd_um[0],
            m.robust_sd_um[0],
            m.sd_um[1],
            m.robust_sd_um[1],
            m.um_per_px,
            m.edge_offset_px
        );
    };
    [&study.ours, &study.level_crossing, &study.optical].into_iter().chain(&study.balls).for_each(row);
    print_comparisons(study);
    say_line!(
        "\n{:<12} {:>12} {:>9} {:>12} {:>9}   machine - method, um",
        "picture",
        "outer: ours",
        "level",
        "inner: ours",
        "level"
    );
    for (k, name) in study.names.iter().enumerate() {
        let (a, b) = (study.ours.residual_um[k], study.level_crossing.residual_um[k]);
        say_line!("{name:<12} {:>+12.1} {:>+9.1} {:>+12.1} {:>+9.1}", a[0], b[0], a[1], b[1]);
    }
    for o in &study.outliers {
        say_line!(
            "outlier: {}, {} {:+.1} um (level crossing {:+.1})",
            o.name,
            SIDES[o.side],
            o.residual_um[0],
            o.residual_um[1]
        );
    }
}

fn print_comparisons(study: &WashersStudy) {
    say_line!(
        "\nsplit by number (every second part), scale and offset from one half, residuals of the other; um"
    );
    say_line!("{:<20} {:>8} {:>10} {:>20}", "figure", "ours", "level", "difference");
    for c in &study.comparisons {
        let what = format!("{} {}", SIDES[c.side], c.figure);
        let interval = format!("{:+.2} to {:+.2}", c.difference_um[0], c.difference_um[1]);
        say_line!("{what:<20} {:>8.2} {:>10.2} {interval:>20}  {}", c.ours_um, c.plain_um, c.verdict.word());
    }
}
