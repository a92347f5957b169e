//! `shadowgauge study head`: what heads will measure a part to, from their configs alone.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::{ConfigText, StudyFolder, csv_text, json_text};
use crate::cli::optics::{head_failure, load_head};
use crate::cli::terminal::progress;
use crate::files::OutputFile;
use crate::gauge::calibration::{Date, GivenConditions};
use crate::render::{BackendChoice, Renderer};
use crate::report::head_page;
use crate::report::head_rows::{EXPOSURE_HEADER, exposure_rows, head_sections};
use crate::studies::head::{
    ExposureLimits, HeadConfig, HeadFigures, HeadSettings, HeadSetup, HeadStudy, frames_in_all, study,
};

/// Arguments of `study head`.
#[derive(Debug, clap::Args)]
pub(crate) struct StudyHeadArgs {
    /// Jobs' configs with [camera] and [optics], one a head.
    #[arg(required = true, value_name = "CONFIG.toml")]
    configs: Vec<PathBuf>,
    /// Diameter of the part, mm; the configs' own without it, where they agree.
    #[arg(long, value_name = "D", value_parser = above_zero)]
    diameter_mm: Option<f64>,
    /// Speed of the spindle in use, rev/min, 0 for a part at rest; the configs' own without it.
    #[arg(long, value_name = "N", value_parser = not_negative)]
    rpm: Option<f64>,
    /// Offset of the part's axis from that of rotation, mm: half of its total run-out; the configs'
    /// own without it, or 0.01.
    #[arg(long, value_name = "E", value_parser = not_negative)]
    eccentricity_mm: Option<f64>,
    /// Conditions of the part, as `measure --conditions` reads them; without it the config's.
    #[arg(long, value_name = "FILE.toml")]
    conditions: Option<PathBuf>,
    /// Undulations per revolution that an exposure must resolve; 15 is the coarsest filter of
    /// roundness.
    #[arg(long, value_name = "N", default_value_t = 15.0, value_parser = above_zero)]
    upr: f64,
    /// Share of their amplitude that an exposure may lose.
    #[arg(long, value_name = "SHARE", default_value_t = 0.01, value_parser = share)]
    amplitude_loss: f64,
    /// Blur by run-out that an exposure may have, as a share of the standard uncertainty: 0.3 of
    /// it, added, makes it larger by 4 %.
    #[arg(long, value_name = "SHARE", default_value_t = 0.3, value_parser = above_zero)]
    blur_share: f64,
    /// By how much a diameter may move in the depth of field, µm; a quarter of U without it.
    #[arg(long, value_name = "L", value_parser = above_zero)]
    depth_limit_um: Option<f64>,
    /// Frames of the part that are rendered and measured beside the prediction.
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(2..=10_000))]
    frames: u32,
    /// Seed of their noise.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Where frames are rendered.
    #[arg(long, value_enum, default_value_t = BackendChoice::Cpu)]
    backend: BackendChoice,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write the figures to this CSV file, a row a head.
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
    /// Write the page to this HTML file.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Write heads.json, heads.csv and report.html into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

fn number(text: &str, is_right: impl Fn(f64) -> bool, right: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && is_right(value) => Ok(value),
        _ => Err(format!("{right} is needed")),
    }
}

fn above_zero(text: &str) -> Result<f64, String> {
    number(text, |v| v > 0.0, "a number above 0")
}

fn not_negative(text: &str) -> Result<f64, String> {
    number(text, |v| v >= 0.0, "a number of 0 or more")
}

fn share(text: &str) -> Result<f64, String> {
    number(text, |v| v > 0.0 && v < 1.0, "a share above 0 and below 1, for instance 0.01")
}

/// Runs the study.
///
/// # Errors
/// Exit 2 for configs that are refused or do not suit the part, 3 for frames and disks that fail.
pub(crate) fn run(args: &StudyHeadArgs) -> CommandResult {
    let configs = load(&args.configs)?;
    let settings = settings(args, &configs)?;
    let setups = configs.iter().map(|c| HeadSetup::new(c, &settings).map_err(|e| head_failure(&c.file, &e)));
    let setups = setups.collect::<Result<Vec<_>, _>>()?;
    let claim = |path: &Option<PathBuf>| {
        path.as_deref().map(|path| OutputFile::claim(path, args.configs.clone())).transpose()
    };
    let (csv_file, page_file) = (claim(&args.csv)?, claim(&args.report)?);
    let folder = StudyFolder::claim(args.out.as_deref())?;
    let renderer = Renderer::new(args.backend).map_err(Failure::fail)?;
    let bar = progress::bar(frames_in_all(&setups, &settings), "drawing and measuring", "frames");
    let found = study(&setups, &settings, &renderer, &|frames| bar.inc(frames));
    bar.finish_and_clear();
    let found = found.map_err(|(file, error)| head_failure(&file, &error))?;
    let csv = csv_text(&found.heads.iter().map(HeadRow::of).collect::<Vec<_>>())?;
    let page = head_page(&found).map_err(Failure::fail)?;
    csv_file.map_or(Ok(()), |file| file.write(&csv))?;
    page_file.map_or(Ok(()), |file| file.write(page.as_bytes()))?;
    StudyFolder::fill(folder, |folder| {
        folder.write("heads.json", json_text(&found)?.as_bytes())?;
        folder.write("heads.csv", &csv)?;
        folder.write("report.html", page.as_bytes())
    })?;
    if args.json {
        say_line!("{}", json_text(&found)?);
    } else {
        say!("{}", in_words(&found));
    }
    Ok(Outcome::Done)
}

/// The heads' configs, each once and under a name of its own.
fn load(paths: &[PathBuf]) -> Result<Vec<HeadConfig>, Failure> {
    let mut all: Vec<HeadConfig> = Vec::new();
    for path in paths {
        let head = load_head(path)?;
        if let Some(before) = all.iter().find(|known| known.job == head.job) {
            return Err(Failure::refuse(format!(
                "{}: is the same head as {}: name each head once",
                head.file, before.file
            )));
        }
        all.push(head);
    }
    let names: Vec<String> = all.iter().map(|head| head.name.clone()).collect();
    for (head, path) in all.iter_mut().zip(paths) {
        if names.iter().filter(|name| **name == head.name).count() > 1 {
            head.name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        }
    }
    Ok(all)
}

fn settings(args: &StudyHeadArgs, configs: &[HeadConfig]) -> Result<HeadSettings, Failure> {
    let diameters: Vec<f64> = configs.iter().map(HeadConfig::diameter_mm).collect();
    if args.diameter_mm.is_none() && diameters.iter().any(|d| (d - diameters[0]).abs() > 1e-9 * d) {
        let list: Vec<String> =
            configs.iter().zip(&diameters).map(|(c, d)| format!("{d} mm in {}", c.file)).collect();
        return Err(Failure::refuse(format!(
            "the configs have parts of different diameters ({}): --diameter-mm states the one to compare the heads at",
            list.join(", ")
        )));
    }
    Ok(HeadSettings {
        diameter_mm: args.diameter_mm,
        rpm: args.rpm,
        eccentricity_mm: args.eccentricity_mm,
        conditions: args.conditions.as_deref().map(conditions).transpose()?,
        depth_limit_um: args.depth_limit_um,
        exposure: ExposureLimits {
            undulations_upr: args.upr,
            amplitude_loss: args.amplitude_loss,
            share_of_u: args.blur_share,
        },
        frames: args.frames as usize,
        seed: args.seed,
        date: Date::of(SystemTime::now()),
    })
}

fn conditions(path: &Path) -> Result<GivenConditions, Failure> {
    let text = ConfigText::read(path)?;
    let given: GivenConditions = text.parse()?;
    let known = crate::gauge::calibration::Conditions::default();
    given.over(&known).validate().map_err(|e| text.refuse_at(e))?;
    Ok(given)
}

/// A row of heads.csv.
#[derive(serde::Serialize)]
struct HeadRow {
    head: String,
    config: String,
    diameter_mm: f64,
    um_per_px: f64,
    numerical_aperture: Option<f64>,
    blur_px: f64,
    snr: f64,
    bound_um: f64,
    column_um: f64,
    frame_um: f64,
    station_um: f64,
    turn_um: f64,
    bound_in_use_um: f64,
    measured_column_um: Option<f64>,
    measured_over_bound: Option<f64>,
    own_error_um: Option<f64>,
    gaussian_error_um: Option<f64>,
    depth_limit_um: f64,
    depth_mm: f64,
    blur_doubles_mm: Option<f64>,
    smallest_mm: f64,
    smallest_wire_mm: Option<f64>,
    largest_mm: f64,
    at_rest_u_random_um: f64,
    at_rest_u_common_um: f64,
    at_rest_expanded_u_um: f64,
    rpm: f64,
    exposure_us: f64,
    path_um: f64,
    motion_u_um: f64,
    in_use_expanded_u_um: Option<f64>,
    limited_by: Option<String>,
    refused: Option<String>,
}

impl HeadRow {
    fn of(h: &HeadFigures) -> Self {
        let own = h.frames.as_ref().map(|f| &f.own);
        let gaussian = h.frames.as_ref().map(|f| f.gaussian.as_ref().unwrap_or(&f.own));
        Self {
            head: h.name.clone(),
            config: h.config.clone(),
            diameter_mm: h.diameter_mm,
            um_per_px: h.optics.um_per_px,
            numerical_aperture: h.optics.numerical_aperture,
            blur_px: h.optics.blur_px,
            snr: h.optics.snr,
            bound_um: h.repeatability.bound_um,
            column_um: h.repeatability.column_um,
            frame_um: h.repeatability.frame_um,
            station_um: h.repeatability.station_um,
            turn_um: h.repeatability.turn_um,
            bound_in_use_um: h.repeatability_in_use.bound_um,
            measured_column_um: own.and_then(|m| m.column_sd_um),
            measured_over_bound: h.frames.as_ref().and_then(|f| f.column_ratio),
            own_error_um: own.and_then(|m| m.mean_um),
            gaussian_error_um: gaussian.and_then(|m| m.mean_um),
            depth_limit_um: h.depth.limit_um,
            depth_mm: h.depth.depth_mm,
            blur_doubles_mm: h.depth.blur_doubles_mm,
            smallest_mm: h.range.smallest_mm,
            smallest_wire_mm: h.range.smallest_wire_mm,
            largest_mm: h.range.largest_mm,
            at_rest_u_random_um: h.at_rest.u_random_um,
            at_rest_u_common_um: h.at_rest.u_common_um,
            at_rest_expanded_u_um: h.at_rest.expanded_u_um,
            rpm: h.motion.rpm,
            exposure_us: h.optics.exposure_us,
            path_um: h.motion.path_um,
            motion_u_um: h.motion.u_um,
            in_use_expanded_u_um: h.in_use.as_ref().map(|b| b.expanded_u_um),
            limited_by: h.limit.as_ref().map(|l| l.source.clone()),
            refused: h.motion.refused.clone(),
        }
    }
}

/// Width of a head's column on the terminal: what names of heads usually take.
const CELL: usize = 28;

/// Columns padded to the widest cell of each.
fn padded(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let widest = |column: usize| {
        rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(widest).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}"));
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned() + "\n"
    };
    rows.iter().map(line).collect()
}

fn in_words(study: &HeadStudy) -> String {
    let heads = &study.heads;
    let names = std::iter::once(String::new()).chain(heads.iter().map(|h| h.name.clone()));
    let mut rows: Vec<Vec<String>> = vec![names.collect()];
    for section in head_sections(heads) {
        rows.push(vec![String::new()]);
        rows.push(vec![section.title.to_owned()]);
        rows.extend(section.rows);
    }
    // What would halve a row is a sentence: it stands by itself below the table.
    let mut sentences = Vec::new();
    for row in &mut rows {
        for (k, cell) in row.iter_mut().enumerate().skip(1) {
            if cell.chars().count() > CELL {
                let sentence = std::mem::replace(cell, format!("[{}]", sentences.len() + 1));
                sentences.push(format!("[{}] {}: {sentence}", sentences.len() + 1, heads[k - 1].name));
            }
        }
    }
    let mut text = padded(&rows);
    text += "\nExposure against speed (* what limits it)\n";
    let header = EXPOSURE_HEADER.map(str::to_owned).to_vec();
    text += &padded(&std::iter::once(header).chain(exposure_rows(heads)).collect::<Vec<_>>());
    text.push('\n');
    sentences.iter().for_each(|sentence| text += &format!("{sentence}\n"));
    for head in heads {
        head.notes.iter().for_each(|note| text += &format!("{}: {note}\n", head.name));
    }
    text + &format!("\n{}\n", study.verdict.words)
}
