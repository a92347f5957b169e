//! The errors of a machine: the working space as it is, the budget, heads side by side.

use super::html::Page;
use super::plot::{Chart, Mark, Series};
use crate::studies::machine::{
    Alias, BudgetRow, FormRow, MachineStudy, MapPoint, Reading, ReadingPoint, Sensitivity, SeparationRow,
};

/// Lines of the distorted raster along each axis.
const LINES: usize = 11;
/// Lines drawn of a component over the other axis.
const SECTIONS: usize = 4;
/// Size of the largest drawn displacement, as a share of the working space.
const LARGEST_SHARE: f64 = 0.06;

/// The page and the charts beside it by their names.
pub(crate) struct MachinePage {
    /// The page.
    pub html: String,
    /// Charts.
    pub charts: Vec<(&'static str, String)>,
}

/// The page of a study.
///
/// # Errors
/// Where a chart cannot be drawn.
pub(crate) fn machine_page(study: &MachineStudy) -> Result<MachinePage, String> {
    let mut charts = Vec::new();
    let mut page = Page::new(title(study));
    page.text(&format!(
        "Kinematic chain {}. Errors are those of the tool relative to the part: X radial, Z along the spindle from the chuck, Y completes. \
         What each error is called and means follows ISO 230-1.",
        study.chain
    ));
    space(&mut page, &mut charts, study)?;
    budget(&mut page, study);
    heads(&mut page, &mut charts, study)?;
    form(&mut page, study);
    separation(&mut page, study);
    warm_up(&mut page, &mut charts, study)?;
    Ok(MachinePage { html: page.finish(), charts })
}

fn title(study: &MachineStudy) -> String {
    if study.name.is_empty() {
        "A machine's errors".to_owned()
    } else {
        format!("A machine's errors: {}", study.name)
    }
}

fn space(
    page: &mut Page,
    charts: &mut Vec<(&'static str, String)>,
    study: &MachineStudy,
) -> Result<(), String> {
    page.heading("Working space");
    let (chart, times) = raster(study);
    let svg = chart.to_svg()?;
    page.figure(
        &svg,
        &format!("The working space as the tool reaches it: displacements, their mean taken out, drawn {times:.0} times as large; dotted: as commanded."),
    );
    charts.push(("space.svg", svg));
    let map = &study.map;
    let row = |name: &str, e: &crate::studies::machine::Extent| {
        vec![
            name.to_owned(),
            format!("{:.3}", e.min_um),
            format!("{:.3}", e.max_um),
            format!("{:.3}", e.range_um),
            format!("{:.4}", e.not_separable_um),
        ]
    };
    let header =
        ["error along", "lowest / µm", "highest / µm", "peak to valley / µm", "rms beside f(x) + g(z) / µm"];
    page.table(&header, &[row("X", &map.e_x), row("Y", &map.e_y), row("Z", &map.e_z)]);
    page.text(&format!(
        "{} by {} points by the exact chain; its first order is off by {:.4} nm at most. The last column is what no sum of a function of x and a \
         function of z can hold: a compensation in two tables, one an axis, leaves at least that.",
        map.x_points, map.z_points, map.first_order_off_nm
    ));
    for (name, svg, caption) in [
        (
            "e_x.svg",
            along_z(study, "e_x / µm", |p| p.e_x_um),
            "Error along X over z, at positions of X: half of what a cylinder's diameter shows.",
        ),
        (
            "e_z.svg",
            along_x(study, "e_z / µm", |p| p.e_z_um),
            "Error along Z over x, at positions of Z: what a face shows.",
        ),
        (
            "e_y.svg",
            along_z(study, "e_y / µm", |p| p.e_y_um),
            "Error along Y over z, at positions of X: harmless to a tool at centre height, not to a lens that is not telecentric.",
        ),
    ] {
        let svg = svg.to_svg()?;
        page.figure(&svg, caption);
        charts.push((name, svg));
    }
    Ok(())
}

/// Some of `count` indices, both ends included.
fn some(count: usize, wanted: usize) -> Vec<usize> {
    let wanted = wanted.min(count).max(2);
    (0..wanted).map(|k| k * (count - 1) / (wanted - 1)).collect()
}

/// The working space as a raster, and the magnification of the displacements.
fn raster(study: &MachineStudy) -> (Chart, f64) {
    let points = &study.points;
    let (rows, columns) = (study.map.x_points, study.map.z_points);
    let (first, last) = (&points[0], &points[points.len() - 1]);
    let size = (last.x_mm - first.x_mm).min(last.z_mm - first.z_mm);
    let mean = |of: fn(&MapPoint) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
    let (mean_x, mean_z) = (mean(|p| p.e_x_um), mean(|p| p.e_z_um));
    let off = |p: &MapPoint| (p.e_x_um - mean_x, p.e_z_um - mean_z);
    let largest = points.iter().map(|p| off(p).0.hypot(off(p).1)).fold(1e-9, f64::max);
    let times = round_down(1e3 * LARGEST_SHARE * size / largest);
    let at = |p: &MapPoint, times: f64| (p.z_mm + 1e-3 * times * off(p).1, p.x_mm + 1e-3 * times * off(p).0);
    let mut series = Vec::new();
    for (name, mark, times) in [("commanded", Mark::Faint, 0.0), ("reached", Mark::Line, times)] {
        let along_z = some(rows, LINES)
            .into_iter()
            .map(|i| (0..columns).map(|j| at(&points[i * columns + j], times)).collect::<Vec<_>>());
        let along_x = some(columns, LINES)
            .into_iter()
            .map(|j| (0..rows).map(|i| at(&points[i * columns + j], times)).collect::<Vec<_>>());
        // One series a state, its lines parted by points that are no numbers.
        let gap = (f64::NAN, f64::NAN);
        let all = along_z.chain(along_x).flat_map(|line| line.into_iter().chain([gap])).collect();
        series.push(Series::new(name, mark, usize::from(mark == Mark::Line), all));
    }
    let chart = Chart {
        x_label: "Z / mm".to_owned(),
        y_label: "X / mm".to_owned(),
        series,
        equal_axes: true,
        ..Chart::default()
    };
    (chart, times)
}

/// The next lower 1, 2 or 5 times a power of ten.
fn round_down(value: f64) -> f64 {
    let decade = 10_f64.powf(value.log10().floor());
    let steps = [5.0, 2.0, 1.0].map(|step| step * decade);
    steps.into_iter().find(|step| *step <= value).unwrap_or(decade)
}

fn along_z(study: &MachineStudy, label: &str, of: fn(&MapPoint) -> f64) -> Chart {
    let columns = study.map.z_points;
    let line = |(k, i): (usize, usize)| {
        let row = &study.points[i * columns..(i + 1) * columns];
        let name = format!("X = {:.1} mm", row[0].x_mm);
        Series::new(name, Mark::Line, k, row.iter().map(|p| (p.z_mm, of(p))).collect())
    };
    sections("Z / mm", label, some(study.map.x_points, SECTIONS).into_iter().enumerate().map(line).collect())
}

fn along_x(study: &MachineStudy, label: &str, of: fn(&MapPoint) -> f64) -> Chart {
    let columns = study.map.z_points;
    let line = |(k, j): (usize, usize)| {
        let column: Vec<&MapPoint> = study.points.iter().skip(j).step_by(columns).collect();
        let name = format!("Z = {:.1} mm", column[0].z_mm);
        Series::new(name, Mark::Line, k, column.iter().map(|p| (p.x_mm, of(p))).collect())
    };
    sections("X / mm", label, some(columns, SECTIONS).into_iter().enumerate().map(line).collect())
}

fn sections(x_label: &str, y_label: &str, series: Vec<Series>) -> Chart {
    Chart { x_label: x_label.to_owned(), y_label: y_label.to_owned(), series, ..Chart::default() }
}

fn budget(page: &mut Page, study: &MachineStudy) {
    let budget = &study.budget;
    page.heading("Budget");
    page.text(
        "Each error alone over the working space, peak to valley. Its size is its own peak to valley over its axis (of an orientation its value); the \
         diameter is that of the part. Errors of the spindle over a turn, the others at the spindle's angle of the config. Signs are in the map.",
    );
    let cell = |v: f64| format!("{v:.3}");
    let row = |r: &BudgetRow| {
        let numbers = [r.size, r.drift].map(|v| format!("{} {}", cell(v), r.unit));
        let effects = [r.e_x_um, r.e_y_um, r.e_z_um, r.cut_um].map(cell);
        [r.error.clone(), r.meaning.clone()].into_iter().chain(numbers).chain(effects).collect::<Vec<_>>()
    };
    let mut rows: Vec<Vec<String>> = budget.rows.iter().map(row).collect();
    let sums = [
        ("together", budget.together),
        ("root sum square", budget.root_sum_square),
        ("worst case", budget.worst),
    ];
    rows.extend(sums.map(|(name, sum)| {
        let effects = [sum.e_x_um, sum.e_y_um, sum.e_z_um].map(cell);
        let blank = || vec![String::new(); 2];
        std::iter::once(name.to_owned())
            .chain([String::new()])
            .chain(blank())
            .chain(effects)
            .chain([String::new()])
            .collect()
    }));
    let header = [
        "error",
        "meaning",
        "size",
        "drift",
        "along X / µm",
        "along Y / µm",
        "along Z / µm",
        "diameter / µm",
    ];
    page.table(&header, &rows);
}

fn heads(
    page: &mut Page,
    charts: &mut Vec<(&'static str, String)>,
    study: &MachineStudy,
) -> Result<(), String> {
    let compared = &study.heads;
    page.heading("Tool, probe and heads side by side");
    page.text(
        "What one error alone, of the size stated, does to a diameter (nm): to the one that is cut, to the reading of a probe at the tool's levers, \
         to the reading of heads that see both edges, and to the midline between those. A head that sees both edges does not see the error along X \
         that spoils the part; the error along Y, which the part hardly feels, moves an image that is not telecentric.",
    );
    let names = compared.heads.iter().map(String::as_str);
    let header: Vec<&str> =
        ["error", "size", "cut", "probe"].into_iter().chain(names).chain(["midline"]).collect();
    page.table(&header, &compared.sensitivities.iter().map(sensitivity_row).collect::<Vec<_>>());
    let series = |own: bool| {
        let mut series =
            vec![Series::new("cut", Mark::Line, 0, curve(compared.readings.first(), |p| p.cut_um))];
        for (k, reading) in compared.readings.iter().enumerate() {
            let of: fn(&ReadingPoint) -> f64 = if own { |p| p.own_um } else { |p| p.indicated_um };
            series.push(Series::new(reading.name.clone(), Mark::Line, k + 1, curve(Some(reading), of)));
        }
        series
    };
    let indicated = sections("Z / mm", "deviation of the diameter / µm", series(false)).to_svg()?;
    page.heading("The part that this machine turned, read on the machine");
    page.figure(
        &indicated,
        "Deviation of the diameter as it was cut and as it is indicated. A probe that travels as the tool did finds its own cut straight; on the opposite \
         side it doubles the deviation; a head that sees both edges indicates what was cut.",
    );
    charts.push(("readings.svg", indicated));
    page.table(
        &[
            "read by",
            "cut, peak to valley / µm",
            "indicated, peak to valley / µm",
            "rms of the machine's errors in the reading / µm",
        ],
        &compared.readings.iter().map(reading_row).collect::<Vec<_>>(),
    );
    midlines(page, charts, &compared.readings)
}

fn midlines(
    page: &mut Page,
    charts: &mut Vec<(&'static str, String)>,
    readings: &[Reading],
) -> Result<(), String> {
    let with = readings.iter().find(|reading| reading.points.iter().any(|p| p.midline_um.is_some()));
    let Some(reading) = with else { return Ok(()) };
    let line = reading.points.iter().filter_map(|p| Some((p.z_mm, p.midline_um?))).collect();
    let svg = sections("Z / mm", "midline / µm", vec![Series::new("", Mark::Line, 0, line)]).to_svg()?;
    page.figure(
        &svg,
        "Midline of both edges against the axis of rotation: the displacement of the head along X with its sign reversed. Averaged over half turns it \
         shows the carriage's straightness and the orientation of the spindle, without an artefact; sag of the part stays in it.",
    );
    charts.push(("midline.svg", svg));
    Ok(())
}

fn curve(reading: Option<&Reading>, of: fn(&ReadingPoint) -> f64) -> Vec<(f64, f64)> {
    reading.into_iter().flat_map(|r| r.points.iter().map(|p| (p.z_mm, of(p)))).collect()
}

fn sensitivity_row(s: &Sensitivity) -> Vec<String> {
    let cell = |v: f64| {
        if v.abs() < 5e-5 {
            "0".to_owned()
        } else if v.abs() < 10.0 {
            format!("{v:.4}")
        } else {
            format!("{v:.1}")
        }
    };
    let fixed = [s.error.clone(), s.size.to_owned(), cell(s.cut_nm), cell(s.probe_nm)];
    let heads = s.heads_nm.iter().map(|v| cell(*v));
    fixed.into_iter().chain(heads).chain([cell(s.midline_nm)]).collect()
}

fn reading_row(r: &Reading) -> Vec<String> {
    let cell = |v: f64| format!("{v:.3}");
    vec![r.name.clone(), cell(r.cut_range_um), cell(r.indicated_range_um), format!("{:.4}", r.rms_off_um)]
}

fn form(page: &mut Page, study: &MachineStudy) {
    page.heading("Form of the part");
    page.text(
        "As it is turned on this machine, with the spindle's error motion, and as a probe on its X slide indicates it. Least-squares and minimum-zone \
         features after ISO 12780, 12180 and 12781.",
    );
    let cell = |v: f64| format!("{v:.4}");
    let row = |r: &FormRow| {
        vec![
            r.form.to_owned(),
            r.points.to_string(),
            cell(r.least_squares_um),
            cell(r.minimum_zone_um),
            cell(r.probe_um),
            r.opposite_um.map_or_else(|| "not reached".to_owned(), cell),
        ]
    };
    let header = [
        "form",
        "points",
        "least squares / µm",
        "minimum zone / µm",
        "probe, tool's side / µm",
        "opposite side / µm",
    ];
    page.table(&header, &study.form.iter().map(row).collect::<Vec<_>>());
    page.heading("What the spiral shows of a face");
    page.text(
        "Lobes that grow with the radius to ±0.05 µm at the rim. With m points a turn, n lobes read as the nearest |n − j·m|; beside a multiple of m they \
         read as a tilt and vanish; with half of m or a multiple of it, that depends on their phase (the least is shown).",
    );
    let row =
        |a: &Alias| vec![a.order.to_string(), a.reads_as.to_string(), cell(a.true_um), cell(a.shown_um)];
    page.table(
        &["lobes", "read as", "flatness / µm", "shown / µm"],
        &study.aliases.iter().map(row).collect::<Vec<_>>(),
    );
}

fn separation(page: &mut Page, study: &MachineStudy) {
    if study.separation.is_empty() {
        return;
    }
    page.heading("Separating the spindle from the form");
    page.text(
        "What each method (ISO 230-7) would leave of this spindle's motion, with the part that it turned as the artefact and without noise: reversal leaves nothing, \
         steps the orders that are multiples of their number, a head that sees both edges nothing of the motion and of the form its odd part.",
    );
    let row = |r: &SeparationRow| {
        let offs = [r.motion_off_um, r.form_off_um].map(|v| format!("{v:.4}"));
        let [motion, form] = offs;
        vec![r.method.clone(), r.turns.to_string(), motion, form, format!("{:.2}", r.noise)]
    };
    page.table(
        &[
            "method",
            "turns",
            "motion off, rms / µm",
            "form off, rms / µm",
            "noise of the motion over the probe's",
        ],
        &study.separation.iter().map(row).collect::<Vec<_>>(),
    );
}

fn warm_up(
    page: &mut Page,
    charts: &mut Vec<(&'static str, String)>,
    study: &MachineStudy,
) -> Result<(), String> {
    if study.warm_up.is_empty() {
        return Ok(());
    }
    let line = |of: fn(&crate::studies::machine::WarmUpPoint) -> f64| {
        study.warm_up.iter().map(|p| (p.minutes, of(p))).collect::<Vec<_>>()
    };
    let series = vec![
        Series::new("diameter cut", Mark::Line, 0, line(|p| p.cut_um)),
        Series::new("tool along Z", Mark::Line, 1, line(|p| p.e_z_um)),
    ];
    let svg = sections("time since the cold start / min", "µm", series).to_svg()?;
    page.heading("Warming up");
    page.figure(&svg, "In the middle of the part, at the temperature of the config (ISO 230-3: offsets that approach their warm value exponentially).");
    charts.push(("warm_up.svg", svg));
    Ok(())
}
