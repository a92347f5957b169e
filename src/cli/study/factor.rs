//! `shadowgauge study factor`: one cutting variable at a time against the size error.

use std::path::{Path, PathBuf};

use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::{ConfigText, StudyFolder, csv_text, json_text};
use crate::process::fit::{PowerFit, fit_power_law, read_forces};
use crate::process::{ForceLaw, PowerLaw};
use crate::report::html::Page;
use crate::report::plot::{Chart, Mark, Series};
use crate::studies::factor::{FactorConfig, FactorSeries, FactorStudy};

const BUILT_IN: &str = include_str!("../../../configs/factor_003.toml");

/// Arguments of `study factor`.
#[derive(Debug, clap::Args)]
pub(crate) struct StudyFactorArgs {
    /// The study, as configs/factor_003.toml, which is taken where none is given.
    config: Option<PathBuf>,
    /// Fit the force law to this table (depth_mm, speed_m_per_min, feed_mm_per_rev, force_n) in
    /// place of the config's.
    #[arg(long, value_name = "CSV")]
    forces: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write factor.csv, plots and report.html into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// The study with its force law, where that was fitted.
#[derive(serde::Serialize)]
struct Output<'a> {
    fitted: Option<&'a PowerFit>,
    #[serde(flatten)]
    study: &'a FactorStudy,
}

/// Runs the study.
///
/// # Errors
/// Exit 2 for a config that is refused, 3 for a table or a disk that fails.
pub(crate) fn run(args: &StudyFactorArgs) -> CommandResult {
    let text = ConfigText::read_or(args.config.as_deref(), "configs/factor_003.toml", BUILT_IN)?;
    let mut config: FactorConfig = text.parse()?;
    let fitted = args.forces.as_deref().map(|path| fit(path, &config)).transpose()?;
    if let Some(fit) = &fitted {
        config.process.force = ForceLaw::Power(fit.law);
    }
    let study = config.run().map_err(|e| text.refuse(e))?;
    StudyFolder::fill(StudyFolder::claim(args.out.as_deref())?, |folder| write(folder, &study))?;
    if args.json {
        say_line!("{}", json_text(&Output { fitted: fitted.as_ref(), study: &study })?);
    } else {
        if let Some(fit) = &fitted {
            say!("{}", constants("force law", &fit.estimates, fit.confidence));
        }
        study.series.iter().for_each(|series| say!("{}", in_words(series, config.confidence)));
    }
    Ok(Outcome::Done)
}

fn fit(path: &Path, config: &FactorConfig) -> Result<PowerFit, Failure> {
    let name = path.display();
    let file =
        std::fs::File::open(path).map_err(|e| Failure::fail(format!("{name}: cannot be read: {e}")))?;
    let points = read_forces(file).map_err(|e| Failure::fail(format!("{name}: {e}")))?;
    let given = if let ForceLaw::Power(law) = &config.process.force { *law } else { PowerLaw::default() };
    fit_power_law(&points, &given, config.confidence).map_err(|e| Failure::fail(format!("{name}: {e}")))
}

fn constants(name: &str, estimates: &[crate::process::fit::Estimate], confidence: f64) -> String {
    let mut text = format!("{name}: F = C·a_p^x·f^y·v^z, intervals of {} %\n", 100.0 * confidence);
    for e in estimates {
        text += &match e.interval {
            Some([low, high]) => format!("  {:<16} {:12.5}  [{low:.5}, {high:.5}]\n", e.name, e.value),
            None => format!("  {:<16} {:12.5}  given: the table does not vary it\n", e.name, e.value),
        };
    }
    text
}

fn in_words(series: &FactorSeries, confidence: f64) -> String {
    let mut text = format!("{}\n", series.name);
    text += "     value     force/N   largest/µm    middle/µm  reference/µm   deviation\n";
    for r in &series.rows {
        let optional =
            |v: Option<f64>, digits: usize| v.map_or(String::from("-"), |v| format!("{v:.digits$}"));
        text += &format!(
            "{:10.3}  {:10.3}   {:10.3}   {:10.3}    {:>10}  {:>8} %\n",
            r.value,
            r.force_n,
            r.max_error_um,
            r.middle_error_um,
            optional(r.reference_error_um, 2),
            optional(r.deviation.map(|d| 100.0 * d), 2)
        );
        r.notes.iter().for_each(|note| text += &format!("            {note}\n"));
    }
    text += &format!("  error ~ value^{:.4}\n", series.elasticity);
    if let Some(fit) = &series.fit {
        text += &constants("  own forces", fit, confidence);
    }
    text
}

/// A row of factor.csv.
#[derive(serde::Serialize)]
struct CsvRow<'a> {
    series: &'a str,
    value: f64,
    force_n: f64,
    max_error_um: f64,
    middle_error_um: f64,
    reference_error_um: Option<f64>,
}

fn write(folder: &StudyFolder, study: &FactorStudy) -> Result<(), Failure> {
    let mut page = Page::new(format!("Single factors: {}", study.name));
    page.text(&format!(
        "Largest size error {:.6} µm of diameter per newton of radial force, at {:.1} mm from the chuck.",
        study.error_per_force_um_per_n, study.z_of_max_mm
    ));
    let mut rows = Vec::new();
    for (index, series) in study.series.iter().enumerate() {
        page.heading(&series.name);
        let of_value = format!(
            "Largest size error against the {}; error ~ value^{:.3}.",
            series.factor.label(),
            series.elasticity
        );
        let of_z =
            format!("Size error over the position of the tool, a line for each {}.", series.factor.label());
        for (kind, chart, caption) in [("z", over_z(series), of_z), ("factor", over_factor(series), of_value)]
        {
            let svg = chart.to_svg().map_err(Failure::fail)?;
            page.figure(&svg, &caption);
            folder.write(&format!("series_{}_{kind}.svg", index + 1), svg.as_bytes())?;
        }
        let cells = |r: &crate::studies::factor::FactorRow| {
            vec![
                format!("{:.3}", r.value),
                format!("{:.2}", r.force_n),
                format!("{:.2}", r.max_error_um),
                r.reference_error_um.map_or("-".to_owned(), |v| format!("{v:.1}")),
                r.deviation.map_or("-".to_owned(), |v| format!("{:+.1} %", 100.0 * v)),
            ]
        };
        let table: Vec<Vec<String>> = series.rows.iter().map(cells).collect();
        page.table(
            &[series.factor.label(), "force / N", "largest error / µm", "reference / µm", "deviation"],
            &table,
        );
        rows.extend(series.rows.iter().map(|r| CsvRow {
            series: &series.name,
            value: r.value,
            force_n: r.force_n,
            max_error_um: r.max_error_um,
            middle_error_um: r.middle_error_um,
            reference_error_um: r.reference_error_um,
        }));
    }
    folder.write("factor.csv", &csv_text(&rows)?)?;
    folder.write("report.html", page.finish().as_bytes())
}

/// Range of y from zero to well above the largest error, so that the legend covers no curve.
fn headroom(series: &FactorSeries) -> Option<(f64, f64)> {
    let largest = series
        .rows
        .iter()
        .map(|r| r.max_error_um.max(r.reference_error_um.unwrap_or(0.0)))
        .fold(0.0, f64::max);
    Some((0.0, 1.35 * largest))
}

/// Error over the position of the tool, one line per value (Figs 7 to 9).
fn over_z(series: &FactorSeries) -> Chart {
    let line = |(i, curve): (usize, &Vec<(f64, f64)>)| {
        Series::new(format!("{}", series.rows[i].value), Mark::Line, i, curve.clone())
    };
    Chart {
        x_label: "position of the tool / mm from the chuck".to_owned(),
        y_label: "size error / µm of diameter".to_owned(),
        series: series.curves.iter().enumerate().map(line).collect(),
        y_range: headroom(series),
        ..Chart::default()
    }
}

/// Largest error over the factor, with the reference.
fn over_factor(series: &FactorSeries) -> Chart {
    let ours = series.rows.iter().map(|r| (r.value, r.max_error_um)).collect();
    let reference = series.rows.iter().filter_map(|r| r.reference_error_um.map(|e| (r.value, e))).collect();
    Chart {
        x_label: series.factor.label().to_owned(),
        y_label: "largest size error / µm of diameter".to_owned(),
        series: vec![
            Series::new("ours", Mark::LineDots, 0, ours),
            Series::new("reference", Mark::Dots, 1, reference),
        ],
        y_range: headroom(series),
        ..Chart::default()
    }
}
