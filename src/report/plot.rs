//! Line and scatter charts as SVG text, in one look for all reports.

use std::ops::Range;

use plotters::coord::ranged1d::ValueFormatter;
use plotters::prelude::*;

/// Colours that colour-blind readers can distinguish (Okabe and Ito; a brown in place of their
/// yellow), in order of use.
pub(crate) const PALETTE: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(60, 60, 60),
    RGBColor(122, 62, 24),
];

const WIDTH: u32 = 860;
const HEIGHT: u32 = 380;
/// Margin around the axes, px.
const MARGIN: u32 = 12;
const X_LABELS: u32 = 42;
const Y_LABELS: u32 = 66;
/// Height of a line of the legend, px.
const LEGEND_LINE: u32 = 20;
/// Left end of the legend, at the y axis, px.
const LEGEND_LEFT: i32 = 78;
/// Width of a mark and of the gap behind a name, px.
const LEGEND_MARK: i32 = 26;
const LEGEND_GAP: i32 = 18;
/// Opacity of a band.
const PALE: f64 = 0.2;
/// Approximate width of a letter, px.
const LETTER: f64 = 7.0;

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mark {
    /// A line through the points.
    Line,
    /// A thin, pale line for context.
    Faint,
    /// A dashed line: a limit or a reference.
    Dashed,
    /// Dots.
    Dots,
    /// A line with dots.
    LineDots,
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

/// One series of a chart. Points that are not finite break a line.
#[derive(Clone, Debug)]
pub(crate) struct Series {
    /// Name in the legend; empty for none.
    pub name: String,
    /// Points (x, y).
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub mark: Mark,
    /// Index into [`PALETTE`], wrapping.
    pub colour: usize,
}

impl Series {
    /// A series.
    pub(crate) fn new(name: impl Into<String>, mark: Mark, colour: usize, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), points, mark, colour }
    }

    /// Its colour and line style.
    fn style(&self) -> (RGBColor, ShapeStyle) {
        let colour = PALETTE[self.colour % PALETTE.len()];
        let style = match self.mark {
            Mark::Faint => colour.mix(0.35).stroke_width(1),
            Mark::Dashed => colour.stroke_width(1),
            _ => colour.stroke_width(2),
        };
        (colour, style)
    }
}

/// An entry of the legend.
struct LegendEntry<'a> {
    series: &'a Series,
    x: i32,
    line: u32,
}

impl LegendEntry<'_> {
    fn draw(&self, area: &Area<'_>) -> Result<(), String> {
        let (colour, style) = self.series.style();
        let y = (LEGEND_LINE * self.line) as i32 + 8;
        let ends = |from: i32, to: i32| PathElement::new([(self.x + from, y), (self.x + to, y)], style);
        if self.series.mark == Mark::Band {
            let shade = Rectangle::new([(self.x, y - 6), (self.x + 20, y + 6)], colour.mix(PALE).filled());
            area.draw(&shade).map_err(|e| e.to_string())?;
        }
        let lines = match self.series.mark {
            Mark::Dots | Mark::Band => Vec::new(),
            Mark::Dashed => vec![ends(0, 5), ends(8, 13), ends(16, 20)],
            _ => vec![ends(0, 20)],
        };
        lines.iter().try_for_each(|line| area.draw(line)).map_err(|e| e.to_string())?;
        if matches!(self.series.mark, Mark::Dots | Mark::LineDots) {
            area.draw(&Circle::new((self.x + 10, y), 3, colour.filled())).map_err(|e| e.to_string())?;
        }
        let font = ("sans-serif", 13).into_font().color(&BLACK.mix(0.85));
        let name = Text::new(self.series.name.clone(), (self.x + LEGEND_MARK, y - 6), font);
        area.draw(&name).map_err(|e| e.to_string())
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
    /// Limits of y; from the data where absent.
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
        let mut svg = String::new();
        let legend = self.legend();
        let lines = legend.last().map_or(0, |entry| entry.line + 1);
        {
            let height = HEIGHT + LEGEND_LINE * lines;
            let root = SVGBackend::with_string(&mut svg, (WIDTH, height)).into_drawing_area();
            let (plot, below) = root.split_vertically(HEIGHT);
            if self.log_y { self.draw_log(&plot) } else { self.draw_linear(&plot) }?;
            legend.iter().try_for_each(|entry| entry.draw(&below))?;
            root.present().map_err(|e| e.to_string())?;
        }
        Ok(svg)
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

    fn draw_linear(&self, root: &Area<'_>) -> Result<(), String> {
        let (x, y) = self.ranges(false);
        let mut builder = self.builder(root);
        let mut chart = builder.build_cartesian_2d(x.clone(), y).map_err(|e| e.to_string())?;
        self.mesh(&mut chart)?;
        self.fill(&mut chart, &x)
    }

    fn draw_log(&self, root: &Area<'_>) -> Result<(), String> {
        let (x, y) = self.ranges(true);
        let mut builder = self.builder(root);
        let mut chart = builder.build_cartesian_2d(x.clone(), y.log_scale()).map_err(|e| e.to_string())?;
        self.mesh(&mut chart)?;
        self.fill(&mut chart, &x)
    }

    fn builder<'a, 'b>(&self, root: &'a Area<'b>) -> ChartBuilder<'a, 'b, SVGBackend<'b>> {
        let mut builder = ChartBuilder::on(root);
        builder.margin(MARGIN).x_label_area_size(X_LABELS).y_label_area_size(Y_LABELS);
        if !self.title.is_empty() {
            builder.caption(&self.title, ("sans-serif", 17));
        }
        builder
    }

    fn mesh<'a, 'b: 'a, Y>(&self, chart: &mut Axes<'a, 'b, Y>) -> Result<(), String>
    where
        Y: Ranged<ValueType = f64> + ValueFormatter<f64> + 'a,
    {
        chart
            .configure_mesh()
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .light_line_style(TRANSPARENT) // not drawn: white ones would be half of all lines
            .bold_line_style(BLACK.mix(0.1))
            .label_style(("sans-serif", 13))
            .axis_desc_style(("sans-serif", 14))
            .x_label_formatter(&|v| tidy(*v))
            .y_label_formatter(&|v| tidy(*v))
            .x_labels(self.x_labels.unwrap_or(11))
            .draw()
            .map_err(|e| e.to_string())
    }

    fn fill<'a, 'b: 'a, Y>(&self, chart: &mut Axes<'a, 'b, Y>, x: &Range<f64>) -> Result<(), String>
    where
        Y: Ranged<ValueType = f64> + ValueFormatter<f64> + 'a,
    {
        if let Some((low, high)) = self.band {
            let shade = Rectangle::new([(x.start, low), (x.end, high)], PALETTE[2].mix(0.15).filled());
            chart.draw_series(std::iter::once(shade)).map_err(|e| e.to_string())?;
        }
        for series in &self.series {
            self.draw_one(chart, series)?;
        }
        Ok(())
    }

    fn draw_one<'a, 'b: 'a, Y>(&self, chart: &mut Axes<'a, 'b, Y>, series: &Series) -> Result<(), String>
    where
        Y: Ranged<ValueType = f64> + ValueFormatter<f64> + 'a,
    {
        let (colour, style) = series.style();
        let usable = |p: &(f64, f64)| p.0.is_finite() && p.1.is_finite() && (!self.log_y || p.1 > 0.0);
        if series.mark == Mark::Band {
            let outline: Vec<(f64, f64)> = series.points.iter().copied().filter(usable).collect();
            let shade = Polygon::new(outline, colour.mix(PALE).filled());
            return chart.draw_series(std::iter::once(shade)).map(drop).map_err(|e| e.to_string());
        }
        if series.mark != Mark::Dots {
            for run in series.points.split(|p| !usable(p)).filter(|run| !run.is_empty()) {
                let points = run.iter().copied();
                let drawn = if series.mark == Mark::Dashed {
                    chart.draw_series(DashedLineSeries::new(points, 6, 4, style))
                } else {
                    chart.draw_series(LineSeries::new(points, style))
                };
                drawn.map_err(|e| e.to_string())?;
            }
        }
        if matches!(series.mark, Mark::Dots | Mark::LineDots) {
            let radius = if series.points.len() > 150 { 1 } else { 3 };
            let dots =
                series.points.iter().filter(|p| usable(p)).map(|&p| Circle::new(p, radius, colour.filled()));
            chart.draw_series(dots).map_err(|e| e.to_string())?;
        }
        Ok(())
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
mod tests {
    use super::*;

    #[test]
    fn a_chart_names_its_axes_and_breaks_lines_at_gaps() {
        let points = vec![(0.0, 1.0), (1.0, 2.0), (2.0, f64::NAN), (3.0, 1.0), (4.0, 3.0)];
        let chart = Chart {
            x_label: "z / mm".into(),
            y_label: "e / µm".into(),
            series: vec![Series::new("measured", Mark::Line, 0, points)],
            ..Chart::default()
        };
        let svg = chart.to_svg().unwrap();
        assert!(svg.contains("z / mm") && svg.contains("e / µm") && svg.contains("measured"));
        assert!(!svg.to_lowercase().contains("stroke=\"#ffffff\""), "invisible lines");
        let log = Chart { log_y: true, ..chart }.to_svg().unwrap();
        assert_ne!(log, svg);
    }

    #[test]
    fn a_band_goes_along_and_back() {
        let rows = [(0.0, 1.0, 0.5), (1.0, f64::NAN, 0.5), (2.0, 3.0, 0.25)];
        let outline = band(rows.into_iter());
        assert_eq!(outline, [(0.0, 1.5), (2.0, 3.25), (2.0, 2.75), (0.0, 0.5)]);
        let svg = Chart { series: vec![Series::new("U", Mark::Band, 0, outline)], ..Chart::default() };
        assert!(svg.to_svg().unwrap().contains("<polygon"));
    }

    #[test]
    fn a_circle_is_round_on_equal_axes() {
        let circle =
            (0..=64).map(|i| f64::from(i) * std::f64::consts::TAU / 64.0).map(|a| (a.cos(), a.sin()));
        let series = vec![Series::new("", Mark::Line, 0, circle.collect())];
        let svg = Chart { series, equal_axes: true, ..Chart::default() }.to_svg().unwrap();
        let points = svg.split("<polyline").last().unwrap().split("points=\"").nth(1).unwrap();
        let points: Vec<(f64, f64)> = points
            .split('"')
            .next()
            .unwrap()
            .split_whitespace()
            .map(|p| p.split_once(',').unwrap())
            .map(|(x, y)| (x.parse().unwrap(), y.parse().unwrap()))
            .collect();
        let size = |values: Vec<f64>| {
            let (low, high) = extent(values.into_iter());
            high - low
        };
        let width = size(points.iter().map(|p| p.0).collect());
        let height = size(points.iter().map(|p| p.1).collect());
        assert!(width > 200.0 && (width - height).abs() <= 2.0, "{width} x {height}");
    }

    #[test]
    fn names_stand_below_the_axes_in_as_many_lines_as_they_need() {
        let series = |k: usize| {
            let name = format!("a name of series number {k}");
            Series::new(name, Mark::Line, k, vec![(0.0, 0.0), (1.0, 1.0)])
        };
        let chart = Chart { series: (0..6).map(series).collect(), ..Chart::default() };
        let legend = chart.legend();
        assert_eq!(legend.last().unwrap().line, 1);
        let right = |e: &LegendEntry<'_>| e.x + LEGEND_MARK + (LETTER * e.series.name.len() as f64) as i32;
        assert!(legend.iter().all(|e| right(e) < WIDTH as i32));
        for pair in legend.windows(2).filter(|w| w[0].line == w[1].line) {
            assert!(right(&pair[0]) < pair[1].x);
        }
        let svg = chart.to_svg().unwrap();
        assert!(svg.contains(&format!("height=\"{}\"", HEIGHT + 2 * LEGEND_LINE)));
        let bare =
            Chart { series: vec![Series::new("", Mark::Line, 0, vec![(0.0, 0.0), (1.0, 1.0)])], ..chart };
        assert!(bare.to_svg().unwrap().contains(&format!("height=\"{HEIGHT}\"")));
    }

    #[test]
    fn tidy_numbers() {
        assert_eq!(
            ["0", "0.5", "-2", "1e-5", "0"],
            [0.0, 0.5, -2.0, 1e-5, -6e-17].map(tidy).map(|s| s.leak() as &str)
        );
    }
}
