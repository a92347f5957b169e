//! Tests of the charts.

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
    assert!(!svg.contains("opacity=\"0") && !svg.contains("points=\"\""), "{svg}");
    let line = svg.split("class=\"s0\" d=\"").nth(1).unwrap().split('"').next().unwrap();
    assert_eq!(line.matches('M').count(), 2, "a gap breaks the line: {line}");
    let log = Chart { log_y: true, ..chart }.to_svg().unwrap();
    assert_ne!(log, svg);
}

#[test]
fn a_band_goes_along_and_back() {
    let rows = [(0.0, 1.0, 0.5), (1.0, f64::NAN, 0.5), (2.0, 3.0, 0.25)];
    let outline = band(rows.into_iter());
    assert_eq!(outline, [(0.0, 1.5), (2.0, 3.25), (2.0, 2.75), (0.0, 0.5)]);
    let svg = Chart { series: vec![Series::new("U", Mark::Band, 0, outline)], ..Chart::default() };
    assert!(svg.to_svg().unwrap().contains("fill-opacity"));
}

#[test]
fn a_circle_is_round_on_equal_axes() {
    let circle = (0..=64).map(|i| f64::from(i) * std::f64::consts::TAU / 64.0).map(|a| (a.cos(), a.sin()));
    let series = vec![Series::new("", Mark::Line, 0, circle.collect())];
    let svg = Chart { series, equal_axes: true, ..Chart::default() }.to_svg().unwrap();
    let path = svg.split("class=\"s0\" d=\"M").nth(1).unwrap().split('"').next().unwrap();
    let numbers: Vec<f64> = path.split_whitespace().map(|n| n.parse().unwrap()).collect();
    let points: Vec<(f64, f64)> = numbers.chunks_exact(2).map(|p| (p[0], p[1])).collect();
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
    let bare = Chart { series: vec![Series::new("", Mark::Line, 0, vec![(0.0, 0.0), (1.0, 1.0)])], ..chart };
    assert!(bare.to_svg().unwrap().contains(&format!("height=\"{HEIGHT}\"")));
}

#[test]
fn a_chart_is_a_picture_with_a_name_and_words() {
    let series = vec![
        Series::new("a<b", Mark::Dots, 0, vec![(0.0, -1.5), (1.0, 2.0)]),
        Series::new("empty", Mark::Line, 1, vec![(0.0, f64::NAN)]),
    ];
    let chart = Chart { x_label: "z / mm".into(), y_label: "e / µm".into(), series, ..Chart::default() };
    let svg = Chart { band: Some((-1.0, 1.0)), ..chart }.to_svg().unwrap();
    assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"));
    assert_eq!((svg.matches("<svg").count(), svg.matches("</svg>").count()), (1, 1));
    assert!(svg.contains("role=\"img\" aria-label=\"Chart: e / µm over z / mm\""), "{svg}");
    assert!(svg.contains("a&lt;b: -1.5 to 2; empty: no value; shaded: -1 to 1"), "{svg}");
}

#[test]
fn lines_differ_by_shape_where_there_are_several() {
    let line = |k: usize| {
        Series::new(format!("{k}"), Mark::Line, k, (0..30).map(|i| (f64::from(i), k as f64)).collect())
    };
    let one = Chart { series: vec![line(0)], ..Chart::default() };
    assert!(!one.is_shaped() && !one.to_svg().unwrap().contains("class=\"f0\""));
    let two = Chart { series: vec![line(0), line(1)], ..Chart::default() };
    let svg = two.to_svg().unwrap();
    assert!(svg.contains("class=\"f0\"") && svg.contains("class=\"f1\""), "{svg}");
}

#[test]
fn a_line_ends_at_the_border_of_a_given_range() {
    let grid = Grid {
        left: 0.0,
        right: 100.0,
        top: 0.0,
        bottom: 100.0,
        x: 0.0..10.0,
        y: 0.0..1.0,
        log_y: false,
        xs: Vec::new(),
        ys: Vec::new(),
    };
    let runs = grid.within(&[(0.0, 0.5), (2.0, 1.5), (4.0, 1.5), (6.0, 0.5)]);
    assert_eq!(runs, [vec![(0.0, 50.0), (10.0, 0.0)], vec![(50.0, 0.0), (60.0, 50.0)]]);
    assert_eq!(grid.at((5.0, 0.25)), (50.0, 75.0));
}

#[test]
fn bars_are_pairs_of_ends() {
    let ends = bars([(1.0, 5.0, 2.0), (2.0, f64::NAN, 1.0)].into_iter());
    assert_eq!(ends, [(1.0, 3.0), (1.0, 7.0)]);
}

#[test]
fn tidy_numbers() {
    assert_eq!(
        ["0", "0.5", "-2", "1e-5", "0"],
        [0.0, 0.5, -2.0, 1e-5, -6e-17].map(tidy).map(|s| s.leak() as &str)
    );
}
