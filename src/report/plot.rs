//! Line and scatter charts as SVG text, in one look for all reports.
//!
//! In: series of points with a name and a [`Mark`]. Out: an `<svg>` that states in words what it
//! shows. The axes are `plotters`' own; grid, series (`marks`) and legend are a path each, with the
//! classes of `colours`, so that a page shows them in its reader's scheme.

use std::fmt::Write as _;
use std::ops::Range;

use plotters::coord::ranged1d::{BoldPoints, ValueFormatter};
use plotters::prelude::*;

use super::colours;
use super::html::escape;
use super::marks::{self, Stroke};

const WIDTH: u32 = 860;
const HEIGHT: u32 = 380;
/// Margin around the axes, px.
const MARGIN: u32 = 12;
const X_LABELS: u32 = 44;
const Y_LABELS: u32 = 72;
/// Most labels on an axis where none is stated.
const MOST_LABELS: usize = 11;
/// Height of a line of the legend, px.
const LEGEND_LINE: u32 = 20;
/// Left end of the legend, at the y axis, px.
const LEGEND_LEFT: i32 = 84;
/// Width of a mark and of the gap behind a name, px.
const LEGEND_MARK: i32 = 28;
const LEGEND_GAP: i32 = 18;
/// Approximate width of a letter, px.
const LETTER: f64 = 7.0;
/// Number of dots of a series above which they are small.
const MANY_DOTS: usize = 150;
/// Colour of [`Chart::band`].
const BAND_COLOUR: usize = 2;

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mark {
    /// A line through the points; where there are several, with some dots of its own shape.
    Line,
    /// A thin, dotted line for context.
    Faint,
    /// A dashed line: a limit or a reference.
    Dashed,
    /// Dots.
    Dots,
    /// A line with dots.
    LineDots,
    /// Upright bars: pairs of their ends.
    Bars,
    /// A pale area between two lines: the points along the one and back along the other.
    Band,
}

/// The outline of a band about points (x, y, half width), in one piece: rows with a gap are left
/// out.
pub(crate) fn band(points: impl Iterator<Item = (f64, f64, f64)> + Clone) -> Vec<(f64, f64)> {
    let usable = points.filter(|p| p.1.is_finite() && p.2.is_finite());
    let mut outline: Vec<(f64, f64)> = usable.clone().map(|(x, y, half)| (x, y + half)).collect();
    let mut back: Vec<(f64, f64)> = usable.map(|(x, y, half)| (x, y - half)).collect();
    back.reverse();
    outline.append(&mut back);
    outline
}

/// The ends of bars about points (x, y, half height).
pub(crate) fn bars(points: impl Iterator<Item = (f64, f64, f64)>) -> Vec<(f64, f64)> {
    let usable = points.filter(|p| p.1.is_finite() && p.2.is_finite());
    usable.flat_map(|(x, y, half)| [(x, y - half), (x, y + half)]).collect()
}

/// One series of a chart. Points that are not finite break a line.
#[derive(Clone, Debug)]
pub(crate) struct Series {
    /// Name in the legend; empty for none.
    pub name: String,
    /// Points (x, y).
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub mark: Mark,
    /// Number of its colour, shape and dash; colours come again after eight.
    pub colour: usize,
}

impl Series {
    /// A series.
    pub(crate) fn new(name: impl Into<String>, mark: Mark, colour: usize, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), points, mark, colour }
    }

    /// The stroke of its line.
    fn stroke(&self) -> Stroke {
        match self.mark {
            Mark::Dashed => Stroke::Dashed,
            Mark::Faint => Stroke::Dotted,
            _ => Stroke::Full,
        }
    }

    /// What it shows, in words.
    fn words(&self) -> String {
        let ys = || self.points.iter().map(|p| p.1).filter(|y| y.is_finite());
        let (low, high) = ys().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), y| (l.min(y), h.max(y)));
        if low > high {
            return format!("{}: no value", self.name);
        }
        format!("{}: {} to {}", self.name, tidy(low), tidy(high))
    }
}

/// An entry of the legend.
struct LegendEntry<'a> {
    series: &'a Series,
    x: i32,
    line: u32,
}

impl LegendEntry<'_> {
    /// Its mark and name; `shaped`: lines have dots of their own shape.
    fn svg(&self, shaped: bool) -> String {
        let (x, y) = (f64::from(self.x), f64::from(HEIGHT + LEGEND_LINE * self.line + 8));
        let Series { mark, colour, .. } = *self.series;
        let mut svg = match mark {
            Mark::Band => {
                marks::area(&[(x, y - 6.0), (x + 22.0, y - 6.0), (x + 22.0, y + 6.0), (x, y + 6.0)], colour)
            }
            Mark::Bars => marks::bars(&[(x + 11.0, y + 6.0), (x + 11.0, y - 6.0)], colour),
            Mark::Dots => String::new(),
            _ => marks::line(&[vec![(x, y), (x + 22.0, y)]], colour, self.series.stroke()),
        };
        if matches!(mark, Mark::Dots | Mark::LineDots) || mark == Mark::Line && shaped {
            svg += &marks::dots(std::iter::once((x + 11.0, y)), colour, false);
        }
        let _ = writeln!(
            svg,
            "<text x=\"{}\" y=\"{}\" font-family=\"sans-serif\" font-size=\"13\" fill=\"{}\">{}</text>",
            self.x + LEGEND_MARK,
            y + 4.5,
            colours::LIGHT.ink,
            escape(&self.series.name)
        );
        svg
    }
}

/// A chart over linear x and linear or logarithmic y.
#[derive(Clone, Debug, Default)]
pub(crate) struct Chart {
    /// Caption above the axes; empty for none.
    pub title: String,
    /// Label of the x axis, with its unit.
    pub x_label: String,
    /// Label of the y axis, with its unit.
    pub y_label: String,
    /// The series, back to front.
    pub series: Vec<Series>,
    /// A shaded band (y from, y to), such as a tolerance.
    pub band: Option<(f64, f64)>,
    /// Whether y is logarithmic (points at or below 0 are left out).
    pub log_y: bool,
    /// Limits of y, beyond which nothing is drawn; from the data where absent.
    pub y_range: Option<(f64, f64)>,
    /// Most labels on the x axis, where fewer than usual are needed (whole numbers).
    pub x_labels: Option<usize>,
    /// Whether a unit has the same length along x and y (both linear), so that circles are round.
    pub equal_axes: bool,
}

impl Chart {
    /// The chart as an `<svg>` element.
    ///
    /// # Errors
    /// Where the drawing fails, as text.
    pub(crate) fn to_svg(&self) -> Result<String, String> {
        let legend = self.legend();
        let height = HEIGHT + LEGEND_LINE * legend.last().map_or(0, |entry| entry.line + 1);
        let mut axes = String::new();
        let grid = {
            let root = SVGBackend::with_string(&mut axes, (WIDTH, HEIGHT)).into_drawing_area();
            let grid = if self.log_y { self.draw_log(&root) } else { self.draw_linear(&root) }?;
            root.present().map_err(|e| e.to_string())?;
            grid
        };
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"chart\" role=\"img\" aria-label=\"{}\" viewBox=\"0 0 {WIDTH} {height}\" \
             width=\"{WIDTH}\" height=\"{height}\">\n<desc>{}</desc>\n<rect class=\"paper\" width=\"{WIDTH}\" height=\"{height}\" fill=\"{}\"/>\n",
            escape(&self.name()),
            escape(&self.words()),
            colours::LIGHT.paper
        );
        svg += &grid.lines();
        svg += &plain(&axes);
        svg += &self.drawn(&grid);
        let shaped = self.is_shaped();
        legend.iter().for_each(|entry| svg += &entry.svg(shaped));
        Ok(svg + "</svg>\n")
    }

    /// Its name for who does not see it.
    fn name(&self) -> String {
        let axes = format!("{} over {}", self.y_label, self.x_label);
        if self.title.is_empty() {
            format!("Chart: {axes}")
        } else {
            format!("Chart: {}: {axes}", self.title)
        }
    }

    /// What it shows, in words.
    fn words(&self) -> String {
        let named = self.series.iter().filter(|s| !s.name.is_empty());
        let mut words: Vec<String> = named.map(Series::words).collect();
        words.extend(self.band.map(|(low, high)| format!("shaded: {} to {}", tidy(low), tidy(high))));
        words.join("; ")
    }

    /// Names below the axes, clear of the curves, from left to right in as many lines as needed.
    fn legend(&self) -> Vec<LegendEntry<'_>> {
        let (mut x, mut line) = (LEGEND_LEFT, 0);
        let mut entries = Vec::new();
        for series in self.series.iter().filter(|s| !s.name.is_empty()) {
            let width = LEGEND_MARK + (LETTER * series.name.chars().count() as f64) as i32;
            if x > LEGEND_LEFT && x + width > WIDTH as i32 - 12 {
                (x, line) = (LEGEND_LEFT, line + 1);
            }
            entries.push(LegendEntry { series, x, line });
            x += width + LEGEND_GAP;
        }
        entries
    }

    /// Whether lines have dots of their own shape: where several of them differ in colour.
    fn is_shaped(&self) -> bool {
        let mut colours: Vec<usize> =
            self.series.iter().filter(|s| s.mark == Mark::Line).map(|s| s.colour).collect();
        colours.sort_unstable();
        colours.dedup();
        colours.len() > 1
    }

    fn draw_linear(&self, root: &Area<'_>) -> Result<Grid, String> {
        let (x, y) = self.ranges(false);
        let mut builder = self.builder(root);
        let mut chart = builder.build_cartesian_2d(x.clone(), y.clone()).map_err(|e| e.to_string())?;
        self.axes(&mut chart)?;
        Ok(self.grid(&chart, (x, y)))
    }

    fn draw_log(&self, root: &Area<'_>) -> Result<Grid, String> {
        let (x, y) = self.ranges(true);
        let mut builder = self.builder(root);
        let scale = y.clone().log_scale();
        let mut chart = builder.build_cartesian_2d(x.clone(), scale).map_err(|e| e.to_string())?;
        self.axes(&mut chart)?;
        Ok(self.grid(&chart, (x, y)))
    }

    fn builder<'a, 'b>(&self, root: &'a Area<'b>) -> ChartBuilder<'a, 'b, SVGBackend<'b>> {
        let mut builder = ChartBuilder::on(root);
        builder.margin(MARGIN).x_label_area_size(X_LABELS).y_label_area_size(Y_LABELS);
        if !self.title.is_empty() {
            builder.caption(&self.title, ("sans-serif", 17));
        }
        builder
    }

    fn most_x_labels(&self) -> usize {
        self.x_labels.unwrap_or(MOST_LABELS)
    }

    fn axes<'a, 'b: 'a, Y>(&self, chart: &mut Axes<'a, 'b, Y>) -> Result<(), String>
    where
        Y: Ranged<ValueType = f64> + ValueFormatter<f64> + 'a,
    {
        chart
            .configure_mesh()
            .disable_mesh()
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .label_style(("sans-serif", 15))
            .axis_desc_style(("sans-serif", 16))
            .x_label_formatter(&|v| tidy(*v))
            .y_label_formatter(&|v| tidy(*v))
            .x_labels(self.most_x_labels())
            .y_labels(MOST_LABELS)
            .draw()
            .map_err(|e| e.to_string())
    }

    /// Where the axes lie and where their labels stand.
    fn grid<'a, 'b: 'a, Y>(&self, chart: &Axes<'a, 'b, Y>, (x, y): (Range<f64>, Range<f64>)) -> Grid
    where
        Y: Ranged<ValueType = f64> + ValueFormatter<f64> + 'a,
    {
        let (left, bottom) = chart.backend_coord(&(x.start, y.start));
        let (right, top) = chart.backend_coord(&(x.end, y.end));
        let coordinates = chart.as_coord_spec();
        let within = |range: &Range<f64>, v: &f64| (range.start..=range.end).contains(v);
        let mut xs = coordinates.x_spec().key_points(BoldPoints(self.most_x_labels()));
        xs.retain(|v| within(&x, v));
        let mut ys = coordinates.y_spec().key_points(BoldPoints(MOST_LABELS));
        ys.retain(|v| within(&y, v));
        Grid {
            left: f64::from(left),
            right: f64::from(right),
            top: f64::from(top),
            bottom: f64::from(bottom),
            x,
            y,
            log_y: self.log_y,
            xs,
            ys,
        }
    }

    /// Band and series, back to front.
    fn drawn(&self, grid: &Grid) -> String {
        let mut svg = String::new();
        if let Some((low, high)) = self.band {
            let (low, high) = (grid.clamped(low), grid.clamped(high));
            let corners = [(grid.x.start, low), (grid.x.end, low), (grid.x.end, high), (grid.x.start, high)];
            svg += &marks::area(&corners.map(|corner| grid.at(corner)), BAND_COLOUR);
        }
        let shaped = self.is_shaped();
        for series in &self.series {
            svg += &self.one(grid, series, shaped);
        }
        svg
    }

    fn one(&self, grid: &Grid, series: &Series, shaped: bool) -> String {
        let usable = |p: &(f64, f64)| p.0.is_finite() && p.1.is_finite() && (!self.log_y || p.1 > 0.0);
        let inside = |p: &&(f64, f64)| usable(p) && grid.holds(p.1);
        let colour = series.colour;
        let at = |points: &[(f64, f64)]| -> Vec<(f64, f64)> {
            points.iter().filter(|p| usable(p)).map(|p| grid.at(*p)).collect()
        };
        match series.mark {
            Mark::Band if series.points.iter().any(usable) => {
                return marks::area(&at(&series.points), colour);
            }
            Mark::Bars if series.points.iter().any(usable) => {
                let ends: Vec<(f64, f64)> = series.points.iter().map(|p| (p.0, grid.clamped(p.1))).collect();
                return marks::bars(&at(&ends), colour);
            }
            Mark::Band | Mark::Bars => return String::new(),
            _ => {}
        }
        let mut svg = String::new();
        let usable_runs = || series.points.split(|p| !usable(p)).filter(|run| !run.is_empty());
        if series.mark != Mark::Dots {
            let runs: Vec<Vec<(f64, f64)>> = usable_runs().flat_map(|run| grid.within(run)).collect();
            if !runs.is_empty() {
                svg += &marks::line(&runs, colour, series.stroke());
            }
        }
        let dots: Vec<(f64, f64)> = series.points.iter().filter(inside).map(|p| grid.at(*p)).collect();
        let small = dots.len() > MANY_DOTS;
        match series.mark {
            _ if dots.is_empty() => {}
            // Several series differ by the shape of their dots, however many these are.
            Mark::Dots | Mark::LineDots => {
                svg += &marks::dots(dots.into_iter(), colour, small && self.series.len() == 1);
            }
            Mark::Line if shaped => {
                let some = marks::places(dots.len(), colour).map(|k| dots[k]);
                svg += &marks::dots(some, colour, false);
            }
            _ => {}
        }
        svg
    }

    fn ranges(&self, log: bool) -> (Range<f64>, Range<f64>) {
        let points = || {
            self.series.iter().flat_map(|s| s.points.iter()).filter(|p| p.0.is_finite() && p.1.is_finite())
        };
        let (x0, x1) = extent(points().map(|p| p.0));
        if let Some((low, high)) = self.y_range {
            return (x0..x1, low..high);
        }
        let ys = points().map(|p| p.1).filter(|&y| !log || y > 0.0);
        let (y0, y1) = extent(ys.chain(self.band.into_iter().flat_map(|(a, b)| [a, b])));
        if log {
            // Whole decades, so that there is at least one label.
            return (x0..x1, 10f64.powf((y0 / 1.2).log10().floor())..10f64.powf((1.2 * y1).log10().ceil()));
        }
        let pad = 0.06 * (y1 - y0);
        if self.equal_axes {
            return equally(x0 - pad..x1 + pad, y0 - pad..y1 + pad);
        }
        (x0..x1, y0 - pad..y1 + pad)
    }
}

/// Where the axes lie in the picture, px, and the values at their labels.
struct Grid {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
    x: Range<f64>,
    y: Range<f64>,
    log_y: bool,
    xs: Vec<f64>,
    ys: Vec<f64>,
}

impl Grid {
    /// A point in px.
    fn at(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let scale = |value: f64| if self.log_y { value.log10() } else { value };
        let share = |value: f64, range: (f64, f64)| (value - range.0) / (range.1 - range.0);
        let along = share(x, (self.x.start, self.x.end));
        let up = share(scale(y), (scale(self.y.start), scale(self.y.end)));
        (self.left + along * (self.right - self.left), self.bottom + up * (self.top - self.bottom))
    }

    /// A value moved to the nearer end of the y axis, where it lies beyond.
    fn clamped(&self, y: f64) -> f64 {
        y.clamp(self.y.start, self.y.end)
    }

    /// Whether a value lies between the ends of the y axis, but for rounding.
    fn holds(&self, y: f64) -> bool {
        let slack = 1e-9 * (self.y.end - self.y.start).abs();
        (self.y.start - slack..=self.y.end + slack).contains(&y)
    }

    /// A line's runs in px, cut where they leave the range of y.
    fn within(&self, run: &[(f64, f64)]) -> Vec<Vec<(f64, f64)>> {
        let mut runs = vec![Vec::new()];
        let mut last: Option<(f64, f64)> = None;
        for &point in run {
            let (was, is) = (last.is_some_and(|p| self.holds(p.1)), self.holds(point.1));
            if let (Some(from), true) = (last, was != is) {
                let border = if from.1.min(point.1) < self.y.start { self.y.start } else { self.y.end };
                let x = from.0 + (point.0 - from.0) * (border - from.1) / (point.1 - from.1);
                if let Some(open) = runs.last_mut() {
                    open.push(self.at((x, border)));
                }
            }
            match runs.last_mut() {
                Some(open) if is => open.push(self.at(point)),
                Some(open) if !open.is_empty() => runs.push(Vec::new()),
                _ => {}
            }
            last = Some(point);
        }
        runs.retain(|run| !run.is_empty());
        runs
    }

    /// Dotted lines at the labels, clear of the axes.
    fn lines(&self) -> String {
        let mut path = String::new();
        let (left, right, top, bottom) = (self.left, self.right, self.top, self.bottom);
        for x in self.xs.iter().map(|x| self.at((*x, self.y.start)).0).filter(|x| *x > left + 2.0) {
            let _ = write!(path, "M{x:.0} {bottom}V{top}");
        }
        for y in self.ys.iter().map(|y| self.at((self.x.start, *y)).1).filter(|y| *y < bottom - 2.0) {
            let _ = write!(path, "M{left} {y:.0}H{right}");
        }
        if path.is_empty() {
            return path;
        }
        format!(
            "<path class=\"rule\" d=\"{path}\" fill=\"none\" stroke=\"{}\" stroke-width=\".8\" stroke-dasharray=\"1 5\"/>\n",
            colours::LIGHT.rule
        )
    }
}

/// What stands inside the `<svg>` of the axes, without attributes that state a default.
fn plain(svg: &str) -> String {
    let from = svg.find('>').map_or(0, |end| end + 1);
    let to = svg.rfind("</svg>").unwrap_or(svg.len());
    svg.get(from..to).unwrap_or_default().replace(" opacity=\"1\"", "")
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;
type Axes<'a, 'b, Y> =
    ChartContext<'a, SVGBackend<'b>, Cartesian2d<plotters::coord::types::RangedCoordf64, Y>>;

/// The ranges, widened about their middles so that a unit has the same number of pixels along both
/// axes.
fn equally(x: Range<f64>, y: Range<f64>) -> (Range<f64>, Range<f64>) {
    let (width, height) = (WIDTH - 2 * MARGIN - Y_LABELS, HEIGHT - 2 * MARGIN - X_LABELS);
    let per_px = ((x.end - x.start) / f64::from(width)).max((y.end - y.start) / f64::from(height));
    let wide = |range: Range<f64>, px: u32| {
        let (middle, half) = (0.5 * (range.start + range.end), 0.5 * per_px * f64::from(px));
        middle - half..middle + half
    };
    (wide(x, width), wide(y, height))
}

fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    match (low.is_finite(), high > low) {
        (false, _) => (0.0, 1.0),
        (true, true) => (low, high),
        (true, false) => (low - 0.5 * low.abs().max(1e-9), high + 0.5 * high.abs().max(1e-9)),
    }
}

/// A number rounded to the digits of an axis label.
fn tidy(value: f64) -> String {
    let size = value.abs();
    if size < 1e-12 {
        // A rounding error about zero.
        return "0".to_owned();
    }
    if !(1e-3..1e5).contains(&size) {
        return format!("{value:.0e}");
    }
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests;
