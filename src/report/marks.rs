//! Lines, dots, bars and bands of a chart as SVG paths: one element a series, its look by the
//! number of its colour, so that two series differ by dash or shape where their colours do not
//! show.
//!
//! In: points in px. Out: `<path …/>`.

use std::fmt::Write as _;

use super::colours;

/// Shapes of dots: outlines about (0, 0), relative, of a half width of 3 px.
const SHAPES: [&str; 8] = [
    // circle, square, triangle, diamond
    "m-3 0a3 3 0 1 0 6 0a3 3 0 1 0-6 0z",
    "m-2.7-2.7h5.4v5.4h-5.4z",
    "m0-3.6l3.6 6.4h-7.2z",
    "m0-3.9l3.9 3.9l-3.9 3.9l-3.9-3.9z",
    // triangle upside down, plus, cross, hourglass
    "m0 3.6l3.6-6.4h-7.2z",
    "m-1.1-3.6h2.2v2.5h2.5v2.2h-2.5v2.5h-2.2v-2.5h-2.5v-2.2h2.5z",
    "m-3.3-1.8l1.5-1.5l1.8 1.8l1.8-1.8l1.5 1.5l-1.8 1.8l1.8 1.8l-1.5 1.5l-1.8-1.8l-1.8 1.8l-1.5-1.5l1.8-1.8z",
    "m-3.2-3.2h6.4l-6.4 6.4h6.4z",
];

/// Dashes of limits and references.
const DASHES: [&str; 8] = ["6 4", "9 3 2 3", "3 3", "12 4", "6 2 2 2 2 2", "2 5", "8 4", "12 3 4 3"];
/// Dashes of thin lines for context.
const DOTTED: &str = "1.5 3.5";

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stroke {
    /// Two px wide.
    Full,
    /// Dashed: a limit or a reference.
    Dashed,
    /// Thin and dotted: context.
    Dotted,
}

/// Shape of a series: another one from the ninth series on, whose colours come again.
fn shape(colour: usize) -> usize {
    (colour + colour / SHAPES.len()) % SHAPES.len()
}

/// A coordinate to a tenth of a px, in as few characters as it needs.
fn number(value: f64) -> String {
    let text = format!("{value:.1}");
    let text = text.strip_suffix(".0").unwrap_or(&text);
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

fn place((x, y): (f64, f64)) -> String {
    format!("{} {}", number(x), number(y))
}

/// A line through runs of points.
pub(super) fn line(runs: &[Vec<(f64, f64)>], colour: usize, stroke: Stroke) -> String {
    let mut path = String::new();
    for run in runs {
        let mut last = String::new();
        for (index, point) in run.iter().enumerate() {
            let here = place(*point);
            if index > 0 && here == last {
                continue;
            }
            // A line goes on without a letter.
            let _ = write!(path, "{}{here}", if index == 0 { "M" } else { " " });
            last = here;
        }
        // A single point is a dot of the line's width, by its round ends.
        if run.len() == 1 {
            path.push_str("h.1");
        }
    }
    let look = match stroke {
        Stroke::Full => "stroke-width=\"2\"".to_owned(),
        Stroke::Dashed => {
            format!("stroke-width=\"1.5\" stroke-dasharray=\"{}\"", DASHES[colour % DASHES.len()])
        }
        Stroke::Dotted => format!("stroke-width=\"1.2\" stroke-dasharray=\"{DOTTED}\""),
    };
    let (class, hex) = (colour % 8, colours::series(colour));
    format!(
        "<path class=\"s{class}\" d=\"{path}\" fill=\"none\" stroke=\"{hex}\" stroke-linecap=\"round\" {look}/>\n"
    )
}

/// Dots in the shape of a series; small ones are round.
pub(super) fn dots(points: impl Iterator<Item = (f64, f64)>, colour: usize, small: bool) -> String {
    let (class, hex) = (colour % 8, colours::series(colour));
    let mut path = String::new();
    for point in points {
        let outline = if small { "h.1" } else { SHAPES[shape(colour)] };
        let _ = write!(path, "M{}{outline}", place(point));
    }
    if small {
        let look = "stroke-width=\"2.4\" stroke-linecap=\"round\"";
        return format!("<path class=\"s{class}\" d=\"{path}\" fill=\"none\" stroke=\"{hex}\" {look}/>\n");
    }
    format!("<path class=\"f{class}\" d=\"{path}\" fill=\"{hex}\"/>\n")
}

/// Upright bars with a stop at each end: pairs of ends.
pub(super) fn bars(ends: &[(f64, f64)], colour: usize) -> String {
    let mut path = String::new();
    for pair in ends.chunks_exact(2) {
        let (x, low, high) = (pair[0].0, number(pair[0].1), number(pair[1].1));
        let (left, x) = (number(x - 3.0), number(x));
        let _ = write!(path, "M{x} {low}V{high}M{left} {low}h6M{left} {high}h6");
    }
    let (class, hex) = (colour % 8, colours::series(colour));
    format!("<path class=\"s{class}\" d=\"{path}\" fill=\"none\" stroke=\"{hex}\" stroke-width=\"1.2\"/>\n")
}

/// A pale area within an outline that stands out.
pub(super) fn area(outline: &[(f64, f64)], colour: usize) -> String {
    let points: Vec<String> = outline.iter().map(|point| place(*point)).collect();
    let (class, hex) = (colour % 8, colours::series(colour));
    format!(
        "<path class=\"s{class} f{class}\" d=\"M{}z\" fill=\"{hex}\" fill-opacity=\".2\" stroke=\"{hex}\" stroke-width=\".8\"/>\n",
        points.join(" ")
    )
}

/// Places along a line at which its shape is drawn: all of a few points, else about eight that
/// differ from series to series.
pub(super) fn places(count: usize, colour: usize) -> impl Iterator<Item = usize> {
    let step = if count <= 12 { 1 } else { count / 8 };
    let first = if step == 1 { 0 } else { (colour * step / 8) % step };
    (first..count).step_by(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_one_path_broken_at_gaps() {
        let runs = [vec![(1.0, 2.0), (3.04, 4.0), (3.0, 4.0), (5.0, 6.5)], vec![(9.0, 9.0)]];
        let text = line(&runs, 1, Stroke::Full);
        assert!(text.contains("d=\"M1 2 3 4 5 6.5M9 9h.1\""), "{text}");
        assert_eq!(text.matches("<path").count(), 1);
        assert!(line(&runs, 1, Stroke::Dashed).contains("stroke-dasharray"));
    }

    #[test]
    fn neighbouring_series_differ_in_shape_and_dash() {
        let shapes: Vec<&str> = (0..16).map(|k| SHAPES[shape(k)]).collect();
        for k in 0..8 {
            assert_ne!(shapes[k], shapes[k + 8], "{k} comes again in its colour");
        }
        let mut first: Vec<&str> = shapes[..8].to_vec();
        first.sort_unstable();
        first.dedup();
        assert_eq!(first.len(), 8);
        let mut dashes = DASHES.to_vec();
        dashes.sort_unstable();
        dashes.dedup();
        assert_eq!(dashes.len(), 8);
    }

    #[test]
    fn coordinates_are_short() {
        assert_eq!([1.0, 1.25, -0.01, 100.04].map(number), ["1", "1.2", "0", "100"].map(String::from));
        assert!(bars(&[(5.0, 9.0), (5.0, 1.0)], 0).contains("M5 9V1M2 9h6M2 1h6"));
    }

    #[test]
    fn a_long_line_has_about_eight_marks_and_a_short_one_all() {
        assert_eq!(places(5, 3).collect::<Vec<_>>(), [0, 1, 2, 3, 4]);
        let many: Vec<usize> = places(200, 3).collect();
        assert!((7..=9).contains(&many.len()) && many.iter().all(|k| *k < 200), "{many:?}");
        assert_ne!(many, places(200, 4).collect::<Vec<_>>());
        assert_eq!(places(0, 0).count(), 0);
    }
}
