//! `shadowgauge study tool`: the paper's four workpieces cut by a worn nose, before and after every
//! way to compensate.

use std::path::PathBuf;

use crate::cli::failure::{CommandResult, Failure};
use crate::cli::input_output::{ConfigText, StudyFolder, csv_text, say_study};
use crate::cli::terminal::progress;
use crate::cli::tool::overlay::overlay;
use crate::config;
use crate::render::insert::InsertSettings;
use crate::render::{BackendChoice, Renderer};
use crate::report::html::Page;
use crate::report::plot::{Chart, Mark, Series};
use crate::studies::worn_tool::{
    self, Jobs, Noses, OfPaper, Row, Settings, Study, Tried, Workpiece, WornToolError, curves,
};

/// The insert where no config is given: that of paper 004, worn so that its mean radius is the
/// paper's, .3743 mm (worn round by depth t a nose of R has the mean radius R − t/2).
const INSERT: &str = "[camera]\ncolumns = 1600\nrows = 1200\num_per_px = 2.415\n\n[nose]\nradius_mm = 0.4\n\
     centre_px = [700.0, 720.0]\n\n[[wear]]\nround = { depth_um = 51.4 }\n\n[esf.gaussian]\nsigma_px = 1.2\n";
/// The fourth workpiece before its camera, and the first three before theirs.
const WORKPIECE: &str = include_str!("tool_workpiece.toml");
const PROFILES: &str = include_str!("tool_profiles.toml");

/// Arguments of `study tool`.
#[derive(Debug, clap::Args)]
pub(crate) struct StudyToolArgs {
    /// A TOML file with the worn insert, optics and camera (`schema insert`); its direction is made
    /// that of a tool of 93 degrees. By default the insert of paper 004, worn by 51 µm in its
    /// middle.
    config: Option<PathBuf>,
    /// Half angles of the cones of workpieces 1 and 2, degrees, which the paper does not give; by
    /// default those that its compensation needs.
    #[arg(long, value_name = "DEG,DEG", value_parser = two_angles, default_value = "24,37.6")]
    cone_deg: [f64; 2],
    /// Workpieces of each kind and program with the scatter of the paper's lathe.
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pieces: u32,
    /// Seed of noise and scatter.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Where the frames of the workpieces are rendered.
    #[arg(long, value_enum, default_value_t = BackendChoice::Auto)]
    backend: BackendChoice,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write tool.csv, the plots, nose.png and report.html into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

fn two_angles(text: &str) -> Result<[f64; 2], String> {
    let numbers: Vec<Option<f64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers[..] {
        [Some(one), Some(two)] => Ok([one, two]),
        _ => Err("two half angles with a comma between them, of workpieces 1 and 2: 24,37.6".to_owned()),
    }
}

/// Runs the study.
///
/// # Errors
/// Exit 2 for a config or an angle that is refused, 3 for a nose that cannot be measured, a device
/// or a disk that fails.
pub(crate) fn run(args: &StudyToolArgs) -> CommandResult {
    let text = ConfigText::read_or(args.config.as_deref(), "built-in insert", INSERT)?;
    let insert: InsertSettings = text.parse()?;
    let (cone_deg, pieces, seed) = (args.cone_deg, args.pieces, args.seed);
    let settings = Settings { insert, cone_deg, pieces, workpieces: Workpiece::ALL.to_vec(), seed };
    settings.check().map_err(|e| refused(&text, e))?;
    let job = |text, name| config::parse(text, name).map_err(Failure::refused);
    let jobs = Jobs {
        profiles: job(PROFILES, "tool_profiles.toml")?,
        batch: job(WORKPIECE, "tool_workpiece.toml")?,
    };
    let folder = StudyFolder::claim(args.out.as_deref())?;
    let renderer = Renderer::new(args.backend).map_err(Failure::fail)?;
    let bar = progress::bar(worn_tool::programs_in_all() as u64, "cutting", "programs");
    let found = worn_tool::run(&settings, &jobs, &renderer, &|| bar.inc(1));
    bar.finish_and_clear();
    let (study, noses) = found.map_err(|e| refused(&text, e))?;
    StudyFolder::fill(folder, |folder| write(folder, &study, &noses))?;
    say_study(&study, args.json, print)
}

fn refused(text: &ConfigText, error: WornToolError) -> Failure {
    match error {
        WornToolError::Setting(e) if e.key.starts_with("--") => Failure::refuse(e),
        WornToolError::Setting(_) | WornToolError::Render(_) => text.refuse(error),
        _ => Failure::fail(error),
    }
}

const HEADER: [&str; 8] = [
    "workpiece and program",
    "R/mm",
    "error/µm",
    "reduced by",
    "with scatter/µm",
    "reduced by",
    "paper/µm",
    "paper",
];

fn print(study: &Study) {
    say_line!("{}", nose_in_words(study));
    say_line!(
        "{:<26} {:>8} {:>18} {:>10} {:>16} {:>10} {:>8} {:>8}",
        HEADER[0],
        HEADER[1],
        HEADER[2],
        HEADER[3],
        HEADER[4],
        HEADER[5],
        HEADER[6],
        HEADER[7]
    );
    for (workpiece, paper) in Workpiece::ALL.into_iter().zip(&study.paper) {
        say_line!("{}: {}", workpiece.number(), workpiece.size());
        for row in study.rows.iter().filter(|r| r.workpiece == workpiece.number()) {
            let [program, register, error, reduced, scattered, reduced_too, of_paper, rate] =
                cells(row, paper);
            say_line!(
                "{program:<26} {register:>8} {error:>18} {reduced:>10} {scattered:>16} {reduced_too:>10} {of_paper:>8} \
                 {rate:>8}"
            );
        }
    }
}

/// The nose by both modes.
fn nose_in_words(study: &Study) -> String {
    let n = &study.nose;
    let [real, found, u] = n.mean_radius_mm;
    let paper = match (&n.paper, n.paper_set_radius_mm, &n.paper_refused) {
        (Some(p), Some(set), _) => {
            format!(
                "by the paper's way r {:.4} mm, R1 {set:.4} mm (d {:.1} µm)",
                p.radius_mm,
                1e3 * (set - p.radius_mm)
            )
        }
        (_, _, why) => format!("by the paper's way none: {}", why.as_deref().unwrap_or_default()),
    };
    format!(
        "nose: mean radius {real:.5} mm, measured {found:.5} mm (u {:.3} µm), centre off by {:.3} µm, e(a) off by {:.3} µm at \
         most (u {:.3}); {paper}. Slides scatter by {:.2} µm along X and {:.2} µm along Z (standard deviations).",
        1e3 * u,
        n.centre_off_um,
        n.e_off_um,
        n.u_e_um,
        study.slides_um[0],
        study.slides_um[1]
    )
}

fn cells(row: &Row, paper: &OfPaper) -> [String; 8] {
    let number = |v: Option<f64>, digits: usize| v.map_or("-".to_owned(), |v| format!("{v:.digits$}"));
    let percent = |v: Option<f64>| v.map_or("-".to_owned(), |v| format!("{v:.1} %"));
    let error = match (&row.refused, row.u_um) {
        (Some(why), _) => format!("refused: {why}"),
        (None, Some(u)) => format!("{} (u {u:.2})", number(row.error_um, 2)),
        (None, None) => number(row.error_um, 2),
    };
    let (of_paper, rate) = match row.program {
        Tried::RegisterR0 => (format!("{:.1}", paper.before_um), String::new()),
        Tried::PaperEdit => (format!("{:.1}", paper.after_um), format!("{:.1} %", paper.reduction_percent)),
        _ => (String::new(), String::new()),
    };
    [
        format!("  {}", row.program.words()),
        number(row.register_mm, 4),
        error,
        percent(row.reduction_percent),
        number(row.scattered_um, 2),
        percent(row.scattered_reduction_percent),
        of_paper,
        rate,
    ]
}

fn write(folder: &StudyFolder, study: &Study, noses: &Noses) -> Result<(), Failure> {
    let mut page = Page::new("A worn nose, measured in an image: four workpieces before and after");
    page.text(
        "The workpieces of the paper on tool wear by vision (Zhang, Lu, Xia, Zhang, Zhu 2025), cut by the nose of a rendered \
         insert. Programs are made for the nose as measured in its frame, or by the paper's two registers; the true nose cuts. \
         The sizes are measured through frames by the gauge: the diameter of workpiece 4 by its stations, those of the others \
         by the lines and arcs of the silhouette. The paper's columns are the means of its four readings. Every workpiece is cut \
         with the cutting data of the one before compensation.",
    );
    page.text(&nose_in_words(study));
    let picture = overlay(&noses.frame.view(), &noses.measured).map_err(Failure::fail)?;
    folder.write("nose.png", &picture)?;
    page.image(
        &picture,
        "the back-lit insert with its edges, nominal circle and measured contour",
        "The rendered insert. Blue: both edges and the nominal circle; orange: the contour as measured.",
    );
    for (heading, file, caption, chart) in charts(study, noses) {
        let svg = chart.to_svg().map_err(Failure::fail)?;
        page.heading(heading);
        page.figure(&svg, caption);
        folder.write(&format!("{file}.svg"), svg.as_bytes())?;
    }
    for (workpiece, paper) in Workpiece::ALL.into_iter().zip(&study.paper) {
        page.heading(&format!("Workpiece {}: {}", workpiece.number(), workpiece.size()));
        let rows = study.rows.iter().filter(|r| r.workpiece == workpiece.number());
        page.table(&HEADER, &rows.map(|r| cells(r, paper).to_vec()).collect::<Vec<_>>());
    }
    folder.write("tool.csv", &csv_text(&study.rows)?)?;
    folder.write("report.html", page.finish().as_bytes())
}

type Figure = (&'static str, &'static str, &'static str, Chart);

fn charts(study: &Study, noses: &Noses) -> [Figure; 2] {
    let e = curves(noses);
    let line = |name: &str, mark: Mark, colour: usize, points: Vec<(f64, f64)>| {
        Series::new(name, mark, colour, points)
    };
    let left = Chart {
        x_label: "angle a of the surface's normal / °".to_owned(),
        y_label: "left along the normal e / µm".to_owned(),
        series: vec![
            line("true nose, R0", Mark::Line, 0, e.real),
            line("measured nose, R0", Mark::Dashed, 1, e.known),
            line("true nose, the paper's R1", Mark::Line, 2, e.by_set_radius),
        ],
        ..Chart::default()
    };
    let of = |k: usize, program: Tried| {
        let rows = study.rows.iter().filter(|r| r.program == program);
        let shift = 0.08 * (k as f64 - 2.5);
        let point = |r: &Row| Some((r.workpiece as f64 + shift, r.scattered_um?));
        Series::new(program.words(), Mark::Dots, k, rows.filter_map(point).collect())
    };
    let by_paper = |name: &str, colour: usize, value: fn(&OfPaper) -> f64| {
        // a level over each workpiece, none between two
        let level = |(p, k): (&OfPaper, u32)| {
            let (k, v) = (f64::from(k), value(p));
            [(k - 0.35, v), (k + 0.35, v), (k + 0.35, f64::NAN)]
        };
        Series::new(name, Mark::Dashed, colour, study.paper.iter().zip(1..).flat_map(level).collect())
    };
    let mut series: Vec<Series> = Tried::ALL.into_iter().enumerate().map(|(k, p)| of(k, p)).collect();
    series.push(by_paper("paper, before", 6, |p| p.before_um));
    series.push(by_paper("paper, after", 7, |p| p.after_um));
    let errors = Chart {
        x_label: "workpiece".to_owned(),
        y_label: "mean |error| with the lathe's scatter / µm".to_owned(),
        series,
        x_labels: Some(study.paper.len()),
        ..Chart::default()
    };
    [
        (
            "What is left by the angle of the surface",
            "e_of_a",
            "Material left along the normal with the tool set by touching: 0° is a cylinder, 90° a face, between them cones and \
             arcs.",
            left,
        ),
        (
            "Before and after",
            "workpieces",
            "Mean size of the errors with slides that scatter by the paper's repeatability, a mark a program, beside the means of \
             the paper's readings.",
            errors,
        ),
    ]
}
