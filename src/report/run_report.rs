//! The report of a run: error along z, convergence, a frame with its edges, stated against actual
//! uncertainty.

use super::axis_report::axis_section;
use super::budget_words::{BUDGET_HEADER, budget_rows, budget_words};
use super::error::ReportError;
use super::form_report::form_section;
use super::html::{Page, Tone};
use super::machine_section::machine_section;
use super::plot::{Chart, Mark, Series};
use super::shaft_report::{forces, turn_picture};
use super::{probe_report, sample, section_report};
use crate::cell::frame_of_pass;
use crate::closed_loop::{Sample, part_verdict};
use crate::conformity::part_verdict::PartConformity;
use crate::control::ControllerName;
use crate::gauge::Calibration;
use crate::gauge::budget::{Contribution, Shape, Share, WidthReading};
use crate::gauge::diameter::sections::PartForm;
use crate::job::Job;
use crate::plan::{Contour, Side};
use crate::run_folder::{
    AxisRow, ControlRecord, FormRow, OffsetRow, PartFormRow, PassRow, RunFolder, SectionResults, StationRow,
    TrueAxisRow, profile_of, read_diameters, section_results,
};

/// Inputs of a report.
#[derive(Clone, Copy)]
pub(crate) struct RunView<'a> {
    /// The resolved job.
    pub job: &'a Job,
    /// The run's folder, all passes finished.
    pub folder: &'a RunFolder,
    /// The same run without control, where there is one.
    pub reference: Option<&'a RunFolder>,
    /// Backend frames were rendered with.
    pub backend: &'a str,
    /// Adapter frames were rendered with.
    pub adapter: &'a str,
    /// The frame kept from the last pass.
    pub sample: Option<&'a Sample>,
    /// Form of the part after the last pass, where this process measured it.
    pub form: Option<&'a PartForm>,
}

/// A report and the files that go beside it.
pub(crate) struct RunPage {
    /// The page.
    pub html: String,
    /// Files by their name below the run folder.
    pub files: Vec<(String, Vec<u8>)>,
}

struct Rows {
    passes: Vec<PassRow>,
    stations: Vec<StationRow>,
    /// The same with diameters as they would be on a cylinder of the pass's nominal diameter: of a
    /// stepped shaft less its contour.
    levelled: Vec<StationRow>,
}

impl Rows {
    fn read(folder: &RunFolder, contour: Option<&Contour>) -> Result<Self, ReportError> {
        let stations = folder.stations()?;
        let level = |s: &StationRow| {
            let relative = contour.map_or(0.0, |c| c.relative_mm(s.z_mm, Side::Chuck));
            StationRow {
                d_mm: s.d_mm.map(|d| d - relative),
                true_d_mm: s.true_d_mm.map(|d| d - relative),
                ..s.clone()
            }
        };
        Ok(Self { passes: folder.passes()?, levelled: stations.iter().map(level).collect(), stations })
    }

    /// Whether the part's truth is given: that of a recorded one is not.
    fn has_truth(&self) -> bool {
        self.passes.iter().any(|p| p.true_max_abs_error_mm.is_some())
    }

    fn of_pass(&self, pass: u32) -> impl Iterator<Item = &StationRow> {
        self.levelled.iter().filter(move |s| s.pass == pass)
    }
}

/// What the folder of a run holds, read once.
struct RunRecord {
    rows: Rows,
    /// The run without control.
    reference: Option<Rows>,
    offsets: Vec<OffsetRow>,
    control: ControlRecord,
    sections: Vec<FormRow>,
    parts: Vec<PartFormRow>,
    axis: Vec<AxisRow>,
    true_axis: Vec<TrueAxisRow>,
    /// Contour and results of a stepped shaft.
    stepped: Option<(Contour, SectionResults)>,
    /// `calibration.json`.
    calibration: String,
}

impl RunRecord {
    fn read(view: &RunView<'_>) -> Result<Self, ReportError> {
        let folder = view.folder;
        let (sections, parts) = folder.form()?;
        let order = view.job.loop_job();
        let contour = order.turned_contour();
        let rows = Rows::read(folder, contour.as_ref())?;
        let last = rows.passes.iter().map(|p| p.pass).max().unwrap_or(0);
        let stepped = match &contour {
            Some(_) => section_results(&order, last, &rows.stations, &read_diameters(folder)?),
            None => None,
        };
        Ok(Self {
            rows,
            reference: view.reference.map(|folder| Rows::read(folder, contour.as_ref())).transpose()?,
            stepped: contour.zip(stepped),
            offsets: folder.offsets()?,
            control: folder.control()?,
            sections,
            parts,
            axis: folder.axis()?,
            true_axis: folder.true_axis()?,
            calibration: folder.read_text("calibration.json")?,
        })
    }
}

/// Writes the page of a finished run: folder → record → sections of the page, each a function of
/// what it shows.
///
/// # Errors
/// Where the folder cannot be read or a chart not be drawn.
pub(crate) fn run_report(view: &RunView<'_>) -> Result<RunPage, ReportError> {
    let record = RunRecord::read(view)?;
    let (rows, reference) = (&record.rows, record.reference.as_ref());
    let controller = view.job.control.controller.as_str();
    let mut page =
        Page::new(format!("{}: {} passes, controller {controller}", view.job.name, rows.passes.len()));
    page.text(&origin(view, rows));
    summary(&mut page, view, rows, reference);
    if let Some((contour, results)) = &record.stepped {
        let nominal_mm = view.job.part.target_mm(rows.passes.len() as u32);
        section_report::section_report(&mut page, contour, nominal_mm, results)?;
    }
    let error_svg = error_along_z(&mut page, rows, reference)?;
    corrected_passes(&mut page, view.job, rows)?;
    let convergence_svg = convergence(&mut page, controller, rows, reference)?;
    offsets(&mut page, &record.offsets)?;
    decisions(&mut page, &record.control);
    let mut files = vec![
        ("plots/error_along_z.svg".to_owned(), error_svg.into_bytes()),
        ("plots/convergence.svg".to_owned(), convergence_svg.into_bytes()),
    ];
    if let Some(sample) = view.sample {
        files.extend(sample::figures(&mut page, sample).map_err(ReportError::Draw)?);
    }
    forces(&mut page, &rows.passes);
    files.extend(machine_section(&mut page, view.job, rows.passes.len())?);
    form_section(&mut page, &record.sections, &record.parts, view.form)?;
    files.extend(axis_section(&mut page, &record.axis, &record.true_axis)?);
    files.extend(turn_picture(&mut page, &rows.passes, &rows.levelled, &record.true_axis));
    uncertainty(&mut page, rows)?;
    budget(&mut page, view, &record)?;
    probe_report::budget(&mut page, view.job, &record.calibration, &rows.stations)?;
    calibration(&mut page, &record.calibration)?;
    Ok(RunPage { html: page.finish(), files })
}

/// Where the frames are from, and whether the truth is given.
fn origin(view: &RunView<'_>, rows: &Rows) -> String {
    if !rows.has_truth() {
        return format!(
            "Frames: {} ({}). Errors are measured diameter minus the pass's nominal; the truth of a real part is not given.",
            view.backend, view.adapter
        );
    }
    format!(
        "Seed {}, backend {} ({}). Errors are diameter minus the pass's nominal; \"true\" figures come from the simulation's \
         geometry and are for comparison only: the controller saw measured diameters alone.",
        view.job.seed, view.backend, view.adapter
    )
}

fn um(mm: f64) -> String {
    format!("{:.2}", mm * 1e3)
}

/// Empty where there is none: a column of these is left out.
fn um_or_none(mm: Option<f64>) -> String {
    mm.map_or_else(String::new, um)
}

fn summary(page: &mut Page, view: &RunView<'_>, rows: &Rows, reference: Option<&Rows>) {
    let table: Vec<Vec<String>> = rows
        .passes
        .iter()
        .map(|p| {
            let beside = reference.map_or_else(String::new, |r| {
                let same = r.passes.iter().find(|q| q.pass == p.pass);
                same.and_then(|q| q.true_max_abs_error_mm).map_or("–".to_owned(), um)
            });
            vec![
                p.pass.to_string(),
                format!("{:.4}", p.nominal_mm),
                um(p.max_abs_error_mm),
                um_or_none(p.true_max_abs_error_mm),
                um_or_none(p.worst_measured_minus_true_mm),
                p.rms_error_over_u.map_or_else(String::new, |ratio| format!("{ratio:.2}")),
                beside,
                p.decision.clone(),
            ]
        })
        .collect();
    let header = [
        "pass",
        "nominal / mm",
        "measured max |e| / µm",
        "true max |e| / µm",
        "worst |measured − true| / µm",
        "rms (error/u)",
        "without control: true max |e| / µm",
        "decision",
    ];
    page.heading("Passes").filled_columns(&header, &table);
    let finished = rows.passes.len() == view.job.part.passes();
    let last = profile_of(rows.passes.len() as u32, &rows.stations);
    let verdict = part_verdict(&view.job.loop_job(), &last).filter(|_| finished);
    if let Some(verdict) = verdict {
        let within = view.job.part.tolerance.map_or("the limits of their sections".to_owned(), |t| {
            format!("{} {:+.3}/{:+.3} mm", t.nominal_mm, t.upper_mm, t.lower_mm)
        });
        let text = format!(
            "Finished part: {}. {} of {} stations are proven to lie within {within} (ISO 14253-1, {} %).",
            verdict.words(),
            verdict.conforming,
            verdict.judged(),
            100.0 * view.job.part.conformance_probability
        );
        let tone = match verdict.part() {
            PartConformity::Conforms => Tone::Good,
            PartConformity::NotProven => Tone::Open,
            PartConformity::Violates => Tone::Bad,
        };
        page.verdict(tone, &text);
    }
}

/// Measured error of a pass, one colour per pass.
fn error_series(rows: &Rows, pass: &PassRow, mark: Mark, name: String) -> Series {
    let error_um = |s: &StationRow| s.d_mm.map_or(f64::NAN, |d| (d - pass.nominal_mm) * 1e3);
    let points = rows.of_pass(pass.pass).map(|s| (s.z_mm, error_um(s))).collect();
    Series::new(name, mark, pass.pass as usize - 1, points)
}

fn error_along_z(page: &mut Page, rows: &Rows, reference: Option<&Rows>) -> Result<String, ReportError> {
    page.heading("Error along z");
    let mut series = Vec::new();
    if let Some(reference) = reference {
        for pass in &reference.passes {
            let name = format!("pass {}, no control", pass.pass);
            series.push(error_series(reference, pass, Mark::Faint, name));
        }
    }
    for pass in &rows.passes {
        series.push(error_series(rows, pass, Mark::Line, format!("pass {}", pass.pass)));
    }
    let chart = Chart {
        x_label: "z from the chuck / mm".into(),
        y_label: "measured − nominal / µm".into(),
        series,
        ..Chart::default()
    };
    let beside = if reference.is_some() { "; dotted: the same job without control" } else { "" };
    draw(page, &chart, &format!("Measured diameter error per station and pass{beside}."))
}

/// The passes after the first, where errors are too small for the chart of all.
fn corrected_passes(page: &mut Page, job: &Job, rows: &Rows) -> Result<(), ReportError> {
    let mut corrected: Vec<Series> = rows
        .passes
        .iter()
        .skip(1)
        .flat_map(|p| {
            let true_um = |s: &StationRow| Some((s.z_mm, (s.true_d_mm? - p.nominal_mm) * 1e3));
            let truth: Vec<(f64, f64)> = rows.of_pass(p.pass).filter_map(true_um).collect();
            [
                Series::new(String::new(), Mark::Faint, p.pass as usize - 1, truth),
                error_series(rows, p, Mark::Dots, format!("pass {}", p.pass)),
            ]
        })
        .collect();
    corrected.retain(|series| !series.points.is_empty());
    if corrected.is_empty() {
        return Ok(());
    }
    let controlled = job.control.controller != ControllerName::None;
    let target = job.part.target_mm(job.part.passes() as u32);
    let band =
        job.part.tolerance.filter(|_| controlled).map(|t| {
            ((t.nominal_mm + t.lower_mm - target) * 1e3, (t.nominal_mm + t.upper_mm - target) * 1e3)
        });
    let chart = Chart {
        x_label: "z from the chuck / mm".into(),
        y_label: "error / µm".into(),
        series: corrected,
        band,
        ..Chart::default()
    };
    let shaded =
        if band.is_some() { " Shaded: the finished part's tolerance about the last pass's aim." } else { "" };
    let drawn = if rows.has_truth() { "measured (dots) and true (dotted lines)" } else { "measured" };
    draw(page, &chart, &format!("The passes after the first alone: {drawn}.{shaded}"))?;
    Ok(())
}

fn convergence(
    page: &mut Page,
    controller: &str,
    rows: &Rows,
    reference: Option<&Rows>,
) -> Result<String, ReportError> {
    let line = |rows: &Rows, name: &str, colour: usize| {
        let largest_mm = |p: &PassRow| p.true_max_abs_error_mm.unwrap_or(p.max_abs_error_mm);
        let points = rows.passes.iter().map(|p| (f64::from(p.pass), largest_mm(p) * 1e3)).collect();
        Series::new(name, Mark::LineDots, colour, points)
    };
    let errors = if rows.has_truth() { "true" } else { "measured" };
    let mut series = vec![line(rows, controller, 0)];
    series.extend(reference.map(|r| line(r, "none", 1)));
    let chart = Chart {
        x_label: "pass".into(),
        y_label: format!("{errors} max |error| / µm"),
        series,
        log_y: true,
        x_labels: Some(rows.passes.len()),
        ..Chart::default()
    };
    page.heading("Convergence");
    let both = if reference.is_some() { ", with and without control" } else { "" };
    draw(page, &chart, &format!("Largest {errors} error over all stations after each pass{both}."))
}

fn offsets(page: &mut Page, rows: &[OffsetRow]) -> Result<(), ReportError> {
    let last = rows.iter().map(|r| r.pass).max().unwrap_or(0);
    let series: Vec<Series> = (2..=last)
        .map(|pass| {
            let points =
                rows.iter().filter(|r| r.pass == pass).map(|r| (r.z_mm, r.offset_mm * 1e3)).collect();
            Series::new(format!("pass {pass}"), Mark::Line, pass as usize - 1, points)
        })
        .collect();
    if series.is_empty() {
        return Ok(());
    }
    let chart = Chart {
        x_label: "z from the chuck / mm".into(),
        y_label: "offset / µm of diameter".into(),
        series,
        ..Chart::default()
    };
    page.heading("Offsets in force");
    draw(page, &chart, "What was subtracted from the nominal when commanding the tool.")?;
    Ok(())
}

/// The decision after every pass, with its reason; where offsets were held, the reason.
fn decisions(page: &mut Page, record: &ControlRecord) {
    let rows: Vec<Vec<String>> = record
        .passes
        .iter()
        .map(|p| {
            let scan = p.evidence.origin.as_ref().map_or_else(String::new, |o| {
                let master = o
                    .master_deviation_mm
                    .map_or_else(String::new, |d| format!(", master {:+.2} µm", d * 1e3));
                format!("scan up to frame {} of {}, {}{master}", frame_of_pass(o.scan), o.of.part, o.of.tool)
            });
            let why = [p.alarm.as_ref().map(|a| format!("ALARM: {a}")), p.reason.clone()];
            vec![
                p.pass.to_string(),
                p.decision.clone(),
                why.into_iter().flatten().collect::<Vec<_>>().join("; "),
                scan,
                p.notes.join("; "),
            ]
        })
        .collect();
    page.heading("Control");
    if record.stock.is_some() {
        page.text("The stock was scanned before the first pass.");
    }
    let header = ["after pass", "decision", "reason", "judged by", "remarks"];
    page.filled_columns(&header, &rows);
}

fn uncertainty(page: &mut Page, rows: &Rows) -> Result<(), ReportError> {
    let stated = |s: &StationRow| Some((s.d_mm? - s.true_d_mm?, s.u_random_mm?.hypot(s.u_common_mm?)));
    let mut ratios: Vec<f64> = rows.stations.iter().filter_map(stated).map(|(e, u)| e / u).collect();
    if ratios.is_empty() {
        return Ok(());
    }
    ratios.sort_by(f64::total_cmp);
    let count = ratios.len() as f64;
    let steps = ratios.iter().enumerate().map(|(i, &r)| (r, (i as f64 + 0.5) / count)).collect();
    let normal =
        (-40..=40).map(|i| f64::from(i) / 10.0).map(|x| (x, 0.5 * libm::erfc(-x / std::f64::consts::SQRT_2)));
    let chart = Chart {
        x_label: "(measured − true) / stated standard uncertainty".into(),
        y_label: "share of stations".into(),
        series: vec![
            Series::new("standard normal", Mark::Dashed, 1, normal.collect()),
            Series::new("all stations and passes", Mark::Dots, 0, steps),
        ],
        y_range: Some((0.0, 1.0)),
        ..Chart::default()
    };
    page.heading("Stated against actual uncertainty");
    let rms = (ratios.iter().map(|r| r * r).sum::<f64>() / count).sqrt();
    draw(
        page,
        &chart,
        &format!(
            "Cumulative distribution of error over stated u; rms {rms:.2}. An honest uncertainty lies on the dashed line."
        ),
    )?;
    let last = rows.passes.iter().map(|p| p.pass).max().unwrap_or(0);
    let residual = |f: &dyn Fn(f64, f64) -> f64| -> Vec<(f64, f64)> {
        rows.of_pass(last).map(|s| (s.z_mm, stated(s).map_or(f64::NAN, |(e, u)| f(e, u) * 1e3))).collect()
    };
    let chart = Chart {
        x_label: "z from the chuck / mm".into(),
        y_label: "measured − true / µm".into(),
        series: vec![
            Series::new("± 2u", Mark::Dashed, 1, residual(&|_, u| 2.0 * u)),
            Series::new("", Mark::Dashed, 1, residual(&|_, u| -2.0 * u)),
            Series::new(format!("pass {last}"), Mark::LineDots, 0, residual(&|e, _| e)),
        ],
        ..Chart::default()
    };
    draw(page, &chart, "Residuals of the last pass with the stated expanded uncertainty (k = 2).")?;
    Ok(())
}

/// The budget of a station after the last pass: random part of type A over the angles, common parts
/// by source.
fn budget(page: &mut Page, view: &RunView<'_>, record: &RunRecord) -> Result<(), ReportError> {
    let rows = &record.rows;
    let last = rows.passes.iter().map(|p| p.pass).max().unwrap_or(0);
    let mut random: Vec<f64> = rows.of_pass(last).filter_map(|s| s.u_random_mm).collect();
    let (Some(sample), false) = (view.sample, random.is_empty()) else { return Ok(()) };
    random.sort_by(f64::total_cmp);
    let known: Calibration =
        serde_json::from_str(&record.calibration).map_err(|e| ReportError::Draw(e.to_string()))?;
    let Some(reading) = WidthReading::of_frame(&sample.edges, 0..sample.edges.columns()) else {
        return Ok(());
    };
    let mut budget = reading.budget(&known, &known.conditions());
    budget.contributions.retain(|c| c.share == Share::Common);
    budget.push(Contribution {
        source: "noise, texture and form over the angles".to_owned(),
        input: format!("type A, {} angles, pooled over the stations", view.job.scan.angles),
        shape: Shape::Normal,
        share: Share::Random,
        freedom: None,
        u_mm: random[random.len() / 2],
    });
    let words = budget_words(&budget, budget.factor_or(None));
    page.heading("Uncertainty budget of a station")
        .text(&format!("{words} The random part is the median over the stations."));
    page.table(&BUDGET_HEADER, &budget_rows(&budget));
    Ok(())
}

fn calibration(page: &mut Page, text: &str) -> Result<(), ReportError> {
    let json: serde_json::Value = serde_json::from_str(text).map_err(|e| ReportError::Draw(e.to_string()))?;
    let rows: Vec<Vec<String>> = json
        .as_object()
        .into_iter()
        .flatten()
        .filter(|(_, v)| v.is_number() || v.is_string())
        .map(|(k, v)| vec![k.clone(), v.as_str().map_or_else(|| v.to_string(), str::to_owned)])
        .collect();
    page.heading("Calibration").text(
        "Fitted on the master pins at the start of the run; the whole of it stands in calibration.json.",
    );
    page.table(&["quantity", "value"], &rows);
    Ok(())
}

/// Adds a chart to the page and returns its SVG.
fn draw(page: &mut Page, chart: &Chart, caption: &str) -> Result<String, ReportError> {
    let svg = chart.to_svg().map_err(ReportError::Draw)?;
    page.figure(&svg, caption);
    Ok(svg)
}
