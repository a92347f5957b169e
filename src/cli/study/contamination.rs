//! `shadowgauge study contamination`: how often contamination causes wrong stations, and how many
//! stations its rejection loses.

use std::path::PathBuf;

use super::shard::ShardArgs;
use crate::cli::failure::{CommandResult, Failure};
use crate::cli::input_output::{StudyFolder, say_study};
use crate::cli::terminal::progress;
use crate::report::html::Page;
use crate::report::plot::{Chart, Mark, Series};
use crate::studies::contamination::{ContaminationStudy, CurvePoint, KindResult, StudyError};
use crate::studies::contamination_plan::ContaminationPlan;
use crate::studies::dirty_frames::Contaminant;
use crate::studies::sharding::{SceneStudy, outcomes};

/// Arguments of `study contamination`.
#[derive(Debug, clap::Args)]
pub(crate) struct StudyContaminationArgs {
    /// Frames of each of the eight kinds of contamination.
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    frames: u32,
    /// Clean frames.
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    clean: u32,
    /// Seed of the first frame.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write report.html into this folder.
    #[arg(long, value_name = "DIR", conflicts_with = "shard")]
    out: Option<PathBuf>,
    #[command(flatten)]
    sharding: ShardArgs,
}

/// Runs the study, or one of its shards.
///
/// # Errors
/// Exit 2 for an output folder that holds anything, 3 for a disk that fails.
pub(crate) fn run(args: &StudyContaminationArgs) -> CommandResult {
    let plan =
        ContaminationPlan { frames: args.frames as usize, clean: args.clean as usize, seed: args.seed };
    if let Some(shard) = args.sharding.run(&plan) {
        return shard;
    }
    let folder = StudyFolder::claim(args.out.as_deref())?;
    let bar = progress::bar(plan.scenes(), "drawing and measuring", "frames");
    let failed = |e| match e {
        StudyError::Gauge(e) => Failure::refuse(e),
        e => Failure::fail(e),
    };
    let pair = plan.bench().map_err(failed)?;
    let found = outcomes(&plan, &pair, 0..plan.scenes(), &|| bar.inc(1)).map_err(failed)?;
    bar.finish_and_clear();
    let study = plan.result(&found);
    StudyFolder::fill(folder, |folder| folder.write("report.html", page(&study)?.as_bytes()))?;
    say(&study, args.json)
}

/// Prints the study.
///
/// # Errors
/// Figures that JSON cannot represent.
pub(super) fn say(study: &ContaminationStudy, json: bool) -> CommandResult {
    say_study(study, json, print)
}

fn name(contaminant: Contaminant) -> &'static str {
    match contaminant {
        Contaminant::WindowDroplets => "droplets on the window",
        Contaminant::AirDroplets => "droplets in flight",
        Contaminant::Chips => "chips in flight",
        Contaminant::Mist => "mist",
        Contaminant::Dirt => "specks on the window",
        Contaminant::Scratches => "scratches",
        Contaminant::Films => "short films on the shaft",
        Contaminant::All => "a little of everything",
    }
}

fn cells(k: &KindResult) -> Vec<String> {
    vec![
        name(k.contaminant).to_owned(),
        k.frames.to_string(),
        k.harmful.to_string(),
        k.mishandled.to_string(),
        k.misled.to_string(),
        kept(k.kept),
        format!("{:.2}", k.worst_um),
    ]
}

const HEADER: [&str; 7] =
    ["contamination", "frames", "harmful", "mishandled", "misled (any frame)", "stations kept", "worst / µm"];

fn verdict(study: &ContaminationStudy) -> String {
    format!(
        "{} of {} harmful frames mishandled; {} of {} clean frames lost a station (at most {:.1} % of the columns refused)",
        study.mishandled(),
        study.harmful(),
        study.clean_lost,
        study.clean_frames,
        100.0 * study.clean_worst_share
    )
}

/// Share of stations kept; none where contamination harmed no frame.
fn kept(share: Option<f64>) -> String {
    share.map_or("-".to_owned(), |s| format!("{s:.3}"))
}

fn print(study: &ContaminationStudy) {
    say_line!(
        "{:<26} {:>7} {:>8} {:>11} {:>7} {:>14} {:>11}",
        "contamination",
        "frames",
        "harmful",
        "mishandled",
        "misled",
        "stations kept",
        "worst / µm"
    );
    for k in &study.kinds {
        say_line!(
            "{:<26} {:>7} {:>8} {:>11} {:>7} {:>14} {:>11.2}",
            name(k.contaminant),
            k.frames,
            k.harmful,
            k.mishandled,
            k.misled,
            kept(k.kept),
            k.worst_um
        );
    }
    say_line!("{}", verdict(study));
    for k in study.kinds.iter().filter(|k| k.mishandled > 0) {
        say_line!("mishandled, {}: seeds {:?}", name(k.contaminant), k.mishandled_seeds);
    }
    print_curve("film of half length 0.6 mm over its height / µm", &study.by_height);
    print_curve("film 8 µm high over its half length / mm", &study.by_length);
}

fn print_curve(title: &str, points: &[CurvePoint]) {
    say_line!("{title}: noticed, rms error of a station with and without refusing / µm");
    for p in points {
        say_line!("  {:>6.1} {:>7.2} {:>8.3} {:>8.3}", p.size, p.noticed, p.rms_um, p.rms_off_um);
    }
}

fn page(study: &ContaminationStudy) -> Result<String, Failure> {
    let mut page = Page::new("Contamination before the shaft and on it");
    page.text(
        "Harmful: with nothing refused some station of 0.96 mm lies more than 5 µm from the same frame without the contamination. Mishandled: a \
         station then is neither a gap nor within 1 µm + U (k = 2) of the clean one. Frames of 512 × 1024 pixels, 15 µm, 8 bit.",
    );
    page.text(&verdict(study));
    page.table(&HEADER, &study.kinds.iter().map(cells).collect::<Vec<_>>());
    for (title, label, points) in [
        ("Small effects", "height of a film of half length 0.6 mm / µm", &study.by_height),
        ("Long films", "half length of a film 8 µm high / mm", &study.by_length),
    ] {
        page.heading(title);
        let series = |pick: fn(&CurvePoint) -> f64| points.iter().map(|p| (p.size, pick(p))).collect();
        let svg = Chart {
            x_label: label.to_owned(),
            y_label: "rms error of a station / µm".to_owned(),
            series: vec![
                Series::new("nothing refused", Mark::LineDots, 1, series(|p| p.rms_off_um)),
                Series::new("as the gauge is", Mark::LineDots, 0, series(|p| p.rms_um)),
            ],
            ..Chart::default()
        }
        .to_svg()
        .map_err(Failure::fail)?;
        page.figure(
            &svg,
            "A film as long as the field is a bend of the axis to one frame: only other angles tell it.",
        );
    }
    Ok(page.finish())
}
