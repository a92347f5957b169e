//! The page and the files of `shadowgauge reproduce 003`.

use super::tables;
use crate::cli::failure::Failure;
use crate::cli::input_output::{StudyFolder, csv_text};
use crate::report::html::Page;
use crate::report::plot::{Chart, Mark, Series};
use crate::studies::reproduce_003::{Curve, Curves, Reproduction};
use crate::studies::reproduction::Row;

/// Parts of the paper and the prefixes of their rows' ids.
const PARTS: [(&str, &[&str]); 6] = [
    ("Deflection and size error (eqs 1-3, section 3.3)", &["eq1 ", "eq2 ", "eq3 ", "beam."]),
    ("Forces (Tables 1 and 2)", &["table"]),
    ("Single factors (Figs 7-9)", &["fig7", "fig8", "fig9", "trend."]),
    ("Choice of cutting data (eqs 4-10)", &["eq4", "eq5", "eq6", "eq7", "eq8", "eq9", "eq10", "ga."]),
    (
        "PID (eqs 11-18) and stability",
        &["eq11", "eq12", "eq13", "eq14", "eq15", "eq16-17", "eq18", "stability."],
    ),
    ("Compensation (Fig. 11)", &["fig11."]),
];

/// Writes report.html, rows.csv, curves.csv and the plots.
///
/// # Errors
/// Exit 3 where a plot or the disk fails.
pub(crate) fn write(folder: &StudyFolder, found: &Reproduction) -> Result<(), Failure> {
    let mut page = Page::new("Reproduction: slender shaft, genetic algorithm and PID (Xue, Miao, Xue 2023)");
    page.text(tables::VERDICTS);
    page.text(&tables::summary(&found.rows));
    for figure in figures(found) {
        let svg = figure.chart.to_svg().map_err(Failure::fail)?;
        page.heading(figure.heading);
        page.figure(&svg, &figure.caption);
        folder.write(&format!("{}.svg", figure.file), svg.as_bytes())?;
    }
    tables::tables(&mut page, &found.rows, &PARTS);
    folder.write("curves.csv", &csv_text(&curve_rows(&found.curves))?)?;
    folder.write("rows.csv", &csv_text(&found.rows)?)?;
    folder.write("report.html", page.finish().as_bytes())
}

/// A plot on the page and beside it.
struct Figure {
    heading: &'static str,
    file: &'static str,
    caption: String,
    chart: Chart,
}

/// A chart over the cutting point.
fn z(y_label: &str, series: Vec<Series>) -> Chart {
    Chart {
        x_label: "cutting point z / mm from the chuck".to_owned(),
        y_label: y_label.to_owned(),
        series,
        ..Chart::default()
    }
}

fn figures(found: &Reproduction) -> Vec<Figure> {
    let curves = &found.curves;
    let mut figures = deflection_figures(curves);
    figures.extend(pass_figures(curves));
    figures.push(Figure {
        heading: "Fig. 11 at 250 mm",
        file: "fig11",
        caption: "Error after each pass, the paper's, the error-transfer plant's and the physical plant's."
            .to_owned(),
        chart: fig_11(&found.rows),
    });
    figures.extend(generations(curves));
    figures.push(passes(curves));
    figures
}

/// Figs 7 to 9: errors left by the cutting force.
fn deflection_figures(curves: &Curves) -> Vec<Figure> {
    let error = "size error / µm of diameter";
    vec![
        Figure {
            heading: "Fig. 7: depth of cut",
            file: "fig7_z",
            caption: "Size error over the cutting point with Table 1's forces; dots: printed. Dashed: the line that a load \
                      fixed at node 71 leaves, with the first depth."
                .to_owned(),
            chart: z(error, [over_z(&curves.fig_7), dashed(&curves.fixed_load)].concat()),
        },
        Figure {
            heading: "Fig. 8: cutting speed",
            file: "fig8_z",
            caption: "The same with Table 2's forces; dots: printed.".to_owned(),
            chart: z(error, over_z(&curves.fig_8)),
        },
        Figure {
            heading: "Fig. 9: feed",
            file: "fig9_z",
            caption: "The same with Table 1's law at a depth and speed that are not printed; dots: printed.".to_owned(),
            chart: z(error, over_z(&curves.fig_9)),
        },
    ]
}

/// Fig. 11: errors over the passes.
fn pass_figures(curves: &Curves) -> Vec<Figure> {
    let mut figures = vec![
        Figure {
            heading: "Fig. 11a: four passes without compensation",
            file: "fig11a_z",
            caption: "Error over z on the physical plant, whose force is scaled to the first printed error; dots: printed."
                .to_owned(),
            chart: z("error / µm of diameter", over_z(&curves.fig_11_none)),
        },
        Figure {
            heading: "Fig. 11b: four passes under PID",
            file: "fig11b_z",
            caption: "The same with the paper's gains, offsets accumulated; dots: printed.".to_owned(),
            chart: z("error / µm of diameter", over_z(&curves.fig_11_pid)),
        },
    ];
    if !curves.frames_none.is_empty() {
        figures.push(Figure {
            heading: "Fig. 11 through frames",
            file: "fig11_frames_z",
            caption: "Measured error over z, rendered and measured with Table 1's force: lines without compensation, dashed under PID."
                .to_owned(),
            chart: z(
                "measured error / µm of diameter",
                [over_z(&named("none", &curves.frames_none)), dashed(&named("PID", &curves.frames_pid))].concat(),
            ),
        });
    }
    figures
}

fn named(prefix: &str, curves: &[Curve]) -> Vec<Curve> {
    curves.iter().map(|c| Curve { name: format!("{prefix}, {}", c.name), ..c.clone() }).collect()
}

/// One line per curve, and the paper's printed value in its colour.
fn over_z(curves: &[Curve]) -> Vec<Series> {
    let lines = curves.iter().enumerate().map(|(k, c)| Series::new(&c.name, Mark::Line, k, c.points.clone()));
    let dots =
        curves.iter().enumerate().filter_map(|(k, c)| Some(Series::new("", Mark::Dots, k, vec![c.printed?])));
    lines.chain(dots).collect()
}

fn dashed(curves: &[Curve]) -> Vec<Series> {
    curves.iter().enumerate().map(|(k, c)| Series::new(&c.name, Mark::Dashed, k, c.points.clone())).collect()
}

/// The genetic algorithm's best of every generation, where it satisfies the limits.
fn generations(curves: &Curves) -> Option<Figure> {
    let optimum = curves.optimum_min?;
    let feasible = curves.generations.iter().filter(|g| g.violation == 0.0);
    // Percent above the optimum; a logarithm has no zero.
    let points: Vec<(f64, f64)> =
        feasible.map(|g| (g.generation as f64, (100.0 * (g.time_min / optimum - 1.0)).max(1e-6))).collect();
    let last = points.last()?.1;
    Some(Figure {
        heading: "Genetic algorithm",
        file: "generations",
        caption: format!(
            "Best individual of every generation, time above the proven optimum of {optimum:.4} min (seed 0); {last:.4} % in the end."
        ),
        chart: Chart {
            x_label: "generation".to_owned(),
            y_label: "time above the optimum / %".to_owned(),
            series: vec![Series::new("best of the generation", Mark::Line, 0, points)],
            log_y: true,
            ..Chart::default()
        },
    })
}

/// Time over the number of passes at the printed cutting data.
fn passes(curves: &Curves) -> Figure {
    let of = |value: fn(&crate::studies::optimize::PassTime) -> f64| {
        curves.passes.iter().map(|t| (f64::from(t.passes), value(t))).collect::<Vec<_>>()
    };
    let most = curves.passes.last().map_or(1.0, |t| f64::from(t.passes));
    Figure {
        heading: "Time over the number of passes",
        file: "passes",
        caption: format!(
            "Eq. 5 as printed gives the last of n passes; all n passes with tool changes and auxiliary time add up. Dashed: the printed {} \
             min.",
            curves.printed_min
        ),
        chart: Chart {
            x_label: "passes n".to_owned(),
            y_label: "time / min".to_owned(),
            series: vec![
                Series::new("all passes", Mark::LineDots, 0, of(|t| t.total_min)),
                Series::new("eq. 5 as printed", Mark::LineDots, 1, of(|t| t.equation_5_min)),
                Series::new(
                    "printed",
                    Mark::Dashed,
                    6,
                    vec![(1.0, curves.printed_min), (most, curves.printed_min)],
                ),
            ],
            x_labels: Some(curves.passes.len()),
            ..Chart::default()
        },
    }
}

/// A row of curves.csv.
#[derive(serde::Serialize)]
struct CurveRow<'a> {
    figure: &'static str,
    curve: &'a str,
    z_mm: f64,
    error_um: f64,
    printed_um: Option<f64>,
}

fn curve_rows(curves: &Curves) -> Vec<CurveRow<'_>> {
    let figures = [
        ("7", &curves.fig_7),
        ("7, fixed load", &curves.fixed_load),
        ("8", &curves.fig_8),
        ("9", &curves.fig_9),
        ("11a", &curves.fig_11_none),
        ("11b", &curves.fig_11_pid),
        ("11a, frames", &curves.frames_none),
        ("11b, frames", &curves.frames_pid),
    ];
    let mut rows = Vec::new();
    for (figure, curve) in
        figures.iter().flat_map(|(figure, curves)| curves.iter().map(move |c| (*figure, c)))
    {
        rows.extend(curve.points.iter().map(|&(z_mm, error_um)| CurveRow {
            figure,
            curve: &curve.name,
            z_mm,
            error_um,
            printed_um: curve.printed.filter(|p| p.0 == z_mm).map(|p| p.1),
        }));
    }
    rows
}

fn fig_11(rows: &[Row]) -> Chart {
    let passes = |prefix: &str, value: fn(&Row) -> Option<f64>| -> Vec<(f64, f64)> {
        (1..=4)
            .filter_map(|k| {
                let id = format!("{prefix}.pass{k}");
                let row = rows.iter().find(|row| row.id == id)?;
                Some((f64::from(k), 1e3 * value(row)?))
            })
            .collect()
    };
    let ours: fn(&Row) -> Option<f64> = |row| Some(row.ours);
    let paper: fn(&Row) -> Option<f64> = |row| row.paper;
    let mut series = vec![
        Series::new("paper, no control", Mark::Dots, 1, passes("fig11.uncompensated", paper)),
        Series::new("paper, PID", Mark::Dots, 0, passes("fig11.compensated", paper)),
        Series::new("transfer plant, no control", Mark::Dashed, 1, passes("fig11.uncompensated", ours)),
        Series::new("transfer plant, PID", Mark::Dashed, 0, passes("fig11.compensated", ours)),
        Series::new("physical plant, no control", Mark::LineDots, 4, passes("fig11.physical.none", ours)),
        Series::new("physical plant, PID", Mark::LineDots, 5, passes("fig11.physical.accumulated", ours)),
        Series::new("through frames, no control", Mark::LineDots, 2, passes("fig11.frames.none", ours)),
        Series::new("through frames, PID", Mark::LineDots, 3, passes("fig11.frames.pid", ours)),
    ];
    series.retain(|s| !s.points.is_empty());
    Chart {
        x_label: "pass".to_owned(),
        y_label: "error at 250 mm / µm of diameter".to_owned(),
        series,
        x_labels: Some(4),
        ..Chart::default()
    }
}
