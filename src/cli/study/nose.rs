//! `shadowgauge study nose`: noses of rendered inserts, measured, beside their stated
//! uncertainties.

use std::path::PathBuf;

use super::nose_frames::NoseFrames;
use crate::cli::failure::{CommandResult, Outcome};
use crate::cli::input_output::{ConfigText, StudyFolder, csv_text, json_text};
use crate::cli::terminal::progress;
use crate::render::insert::InsertSettings;
use crate::render::settings::Esf;
use crate::studies::noses::{self, NoseRow};
use crate::studies::worn_noses::{self, ASKED_UM, WornNose, WornRow, WornSettings};

/// The insert that is studied where no config is given: the camera and the tool of paper 004.
const INSERT: &str = "[nose]\nradius_mm = 0.4\n\n[esf.gaussian]\nsigma_px = 1.2\n";

/// Arguments of `study nose`.
#[derive(Debug, clap::Args)]
pub(crate) struct StudyNoseArgs {
    /// A TOML file with insert, optics and camera (`schema insert`); direction, place and wear of
    /// the nose are drawn. By default the insert and the camera of paper 004.
    config: Option<PathBuf>,
    /// Noses: a fifth of each are new, worn round, worn flat, dented, chipped.
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(5..=10_000))]
    noses: u32,
    /// Instead: so many worn noses, and the error of what the control's circle leaves of them,
    /// e(a), over 90 degrees.
    #[arg(long, value_name = "N", conflicts_with = "noses", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    worn: Option<u32>,
    /// Edge-spread functions of the worn noses, in turn: that of the config, or every family.
    #[arg(long, value_enum, default_value_t = Families::Own, requires = "worn")]
    families: Families,
    /// One to three specks at the contour of every second worn nose.
    #[arg(long, requires = "worn")]
    contamination: bool,
    /// Folder for `frames/000000.png`, … (16-bit grey PNG), `truth.json` (a list) and, of worn
    /// noses, `noses.csv`.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Seed of poses, wear and noise.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Edge-spread functions that are studied.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Families {
    /// That of the config.
    Own,
    /// Every family of the renderer, with a blur of about a pixel of 2.4 µm.
    All,
}

/// Runs the study.
///
/// # Errors
/// Exit 1 for a worn nose that is wrong and not flagged, 2 for a config that is refused.
pub(crate) fn run(args: &StudyNoseArgs) -> CommandResult {
    let text = ConfigText::read_or(args.config.as_deref(), "built-in insert", INSERT)?;
    let settings: InsertSettings = text.parse()?;
    settings.check().map_err(|e| text.refuse(e))?;
    let folder = StudyFolder::claim(args.out.as_deref())?;
    match args.worn {
        Some(count) => worn(args, (&text, settings), count, folder),
        None => all_kinds(args, (&text, settings), folder),
    }
}

/// Noses of every kind, beside their stated uncertainties.
fn all_kinds(
    args: &StudyNoseArgs,
    (text, settings): (&ConfigText, InsertSettings),
    folder: Option<StudyFolder>,
) -> CommandResult {
    let bar = progress::bar(u64::from(args.noses), "measuring", "noses");
    let mut frames = NoseFrames::new(folder.as_ref(), settings.camera.um_per_px);
    let rows = noses::run(&settings, args.noses as usize, args.seed, &mut |frame, truth| {
        frames.keep(frame, truth);
        bar.inc(1);
    });
    let rows = rows.map_err(|e| text.refuse(e))?;
    bar.finish_and_clear();
    frames.finish()?;
    StudyFolder::fill(folder, |_| Ok(()))?;
    if args.json {
        say_line!("{}", json_text(&rows)?);
        return Ok(Outcome::Done);
    }
    let camera = settings.camera;
    say_line!(
        "{} x {} px of {} µm; errors: largest (rms of error/u)",
        camera.columns,
        camera.rows,
        camera.um_per_px
    );
    say_line!(
        "{:>6} {:>5} {:>7}  {:>16}  {:>14}  {:>14}  {:>19}  {:>19}  {:>14}",
        "",
        "noses",
        "refused",
        "angle/°",
        "centre/px",
        "mean radius/px",
        "sectors rms/px, 95%",
        "support rms/px, 95%",
        "e rms, most/µm"
    );
    rows.iter().for_each(|row| say_line!("{}", line(row)));
    Ok(Outcome::Done)
}

/// Worn noses, and what of e(a) is wrong without a flag.
fn worn(
    args: &StudyNoseArgs,
    (text, insert): (&ConfigText, InsertSettings),
    count: u32,
    folder: Option<StudyFolder>,
) -> CommandResult {
    let families = match args.families {
        Families::Own => vec![(family_name(&insert.esf), insert.esf.clone())],
        Families::All => worn_noses::families(),
    };
    let (count, seed, contamination) = (count as usize, args.seed, args.contamination);
    let mut frames = NoseFrames::new(folder.as_ref(), insert.camera.um_per_px);
    let bar = progress::bar(count as u64, "measuring", "noses");
    let of = WornSettings { insert, families, count, contamination, seed };
    let done = worn_noses::run(&of, &mut |frame, truth| {
        frames.keep(frame, truth);
        bar.inc(1);
    });
    let (noses, rows) = done.map_err(|e| text.refuse(e))?;
    bar.finish_and_clear();
    frames.finish()?;
    StudyFolder::fill(folder, |folder| folder.write("noses.csv", &csv_text(&noses)?))?;
    if args.json {
        say_line!("{}", json_text(&serde_json::json!({ "rows": rows, "noses": noses }))?);
    } else {
        say_worn(&noses, &rows);
    }
    match noses.iter().any(WornNose::is_wrong) {
        true => Ok(Outcome::OutOfTolerance),
        false => Ok(Outcome::Done),
    }
}

fn family_name(esf: &Esf) -> &'static str {
    match esf {
        Esf::Gaussian(_) => "gaussian",
        Esf::PartiallyCoherent(_) => "partially_coherent",
        Esf::Cylinder(_) => "cylinder",
        Esf::Fresnel(_) => "fresnel",
        Esf::Measured(_) => "measured",
    }
}

fn say_worn(noses: &[WornNose], rows: &[WornRow]) {
    let [rms, worst] = ASKED_UM;
    say_line!("worn noses, e(a) over 90°; asked for: {rms} µm rms, {worst} µm at most, or flagged");
    say_line!(
        "{:>18} {:>5} {:>8} {:>7} {:>7}  {:>14}  {:>14}  {:>15}  {:>15}",
        "",
        "noses",
        "measured",
        "flagged",
        "refused",
        "edge offset/µm",
        "e rms, most/µm",
        "flagged most/µm",
        "wrong, unflagged"
    );
    for r in rows {
        let offset = r.edge_offset_um.map_or_else(|| "-".to_owned(), |b| format!("{b:.3}"));
        say_line!(
            "{:>18} {:>5} {:>8} {:>7} {:>7}  {offset:>14}  {:>6.3}, {:>6.3}  {:>15.3}  {:>15}",
            r.family,
            r.noses,
            r.measured,
            r.flagged,
            r.refused,
            r.rms_um,
            r.worst_um,
            r.flagged_worst_um,
            r.wrong
        );
    }
    for (k, nose) in noses.iter().enumerate().filter(|(_, n)| n.is_wrong()) {
        let (family, wear) = (nose.family, nose.wear);
        let off = nose.worst_um.unwrap_or(0.0);
        say_line!("nose {k} ({family}, {wear}, {} specks): {off:.2} µm off and not flagged", nose.specks);
    }
}

fn line(row: &NoseRow) -> String {
    format!(
        "{:>6} {:>5} {:>7}  {:>9.5} ({:>4.2})  {:>7.4} ({:>4.2})  {:>7.4} ({:>4.2})  {:>11.4}, {:>5.1} %  {:>11.4}, {:>5.1} %  \
         {:>6.3}, {:>6.3}",
        row.wear,
        row.noses,
        row.refused,
        row.angle.largest,
        row.angle.over_u,
        row.centre.largest,
        row.centre.over_u,
        row.mean_radius.largest,
        row.mean_radius.over_u,
        row.sectors.rms_px,
        1e2 * row.sectors.within,
        row.support.rms_px,
        1e2 * row.support.within,
        row.e_um[0],
        row.e_um[1]
    )
}
