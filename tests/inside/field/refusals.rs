//! Frames that used to be refused for a wrong reason: uneven light, black margins, stuck lines of
//! the sensor, small discs, thin wires. They are measured within their uncertainty or refused for
//! the right reason.

use std::path::Path;

use serde_json::Value;
use shadowgauge::frame::{Buffer, Frame, FrameMeta, PixelFormat};
use shadowgauge::gauge::ring::{RingSettings, measure_ring};
use shadowgauge::gauge::{FrameEdges, Gauge, GaugeSettings, Polarity, Which};
use shadowgauge::profile::Reason;

use super::gauge_synth::Synth;
use super::support::{collected, measured, shadowgauge};

const DARK: f64 = 15.0;
const LIGHT: f64 = 180.0;

fn synth(rows: usize, columns: usize, sigma: f64) -> Synth {
    Synth {
        rows,
        columns,
        dark: DARK,
        light: LIGHT,
        sigma,
        read: 1.2,
        gain: 0.0,
        black: 0.0,
        format: PixelFormat::Mono8,
    }
}

fn gauge(min_diameter_px: f64) -> Gauge {
    Gauge::new(GaugeSettings { min_diameter_px, ..GaugeSettings::default() }).unwrap()
}

/// Mean width and its standard uncertainty, px.
fn mean_width(edges: &FrameEdges) -> (f64, f64) {
    let all = 0..edges.columns();
    let mean = |line, length| FrameEdges::mean(line, length, all.clone()).unwrap();
    let (top, bottom) =
        (mean(&edges.top, edges.shared_length[0]), mean(&edges.bottom, edges.shared_length[1]));
    (bottom.value_px - top.value_px, top.u_px.hypot(bottom.u_px))
}

/// Edges of a straight, slightly tilted shaft of this width in the middle of `rows` rows.
fn straight(rows: usize, width: f64) -> impl Fn(usize) -> (f64, f64) + Copy {
    move |column| {
        let middle = 0.5 * rows as f64 + 0.31 + 0.006 * column as f64;
        (middle - 0.5 * width, middle + 0.5 * width)
    }
}

type Field = Box<dyn Fn(f64, f64) -> f64>;

/// Light over (row, column), both 0 to 1, as a share of its most.
fn light_fields() -> Vec<(String, Field)> {
    let mut fields: Vec<(String, Field)> = Vec::new();
    for ratio in [2.0_f64, 3.0, 4.0] {
        let fall = 1.0 - 1.0 / ratio;
        fields.push((format!("{ratio}:1 along"), Box::new(move |_, c| 1.0 - fall * c)));
        fields.push((format!("{ratio}:1 along, exponential"), Box::new(move |_, c| ratio.powf(-c))));
        fields.push((format!("{ratio}:1 across"), Box::new(move |r, _| 1.0 - fall * r)));
        fields.push((format!("{ratio}:1 across, exponential"), Box::new(move |r, _| ratio.powf(-r))));
        fields.push((format!("{ratio}:1 diagonal"), Box::new(move |r, c| 1.0 - 0.5 * fall * (r + c))));
        let spot = move |r: f64, c: f64| ratio.powf(-2.0 * ((r - 0.5).powi(2) + (c - 0.5).powi(2)));
        fields.push((format!("spot, corners 1:{ratio}"), Box::new(spot)));
    }
    fields
}

/// Beside another shadow of the same size, with 20 px of light between them: the wide windows of
/// the first guess of the blur reach it.
#[test]
fn a_shadow_close_beside_another_keeps_its_width() {
    let (rows, width, gap) = (160, 30.2, 20.0);
    let synth = synth(rows, 200, 1.1);
    let first = |column: usize| (38.3 + 0.006 * column as f64, 38.3 + width + 0.006 * column as f64);
    let other = |row: usize, column: usize, mean: f64| {
        let top = first(column).1 + gap - row as f64;
        let step = |d: f64| 0.5 * (1.0 + statrs::function::erf::erf(d / 1.1 / std::f64::consts::SQRT_2));
        DARK + (mean - DARK) * (step(top) + step(-top - width))
    };
    for (seed, which) in [Which::Number(1), Which::Largest].into_iter().enumerate() {
        let frame = synth.frame_with(first, other, Some(seed as u64));
        let settings = GaugeSettings { which: Some(which), ..GaugeSettings::default() };
        let edges = Gauge::new(settings).unwrap().edges(&frame.view()).unwrap();
        let (mean, u) = mean_width(&edges);
        // The second shadow is drawn at the pixels' middles: its width is accurate to some
        // hundredths of a pixel only.
        let most = if edges.top[0].row_px < 60.0 { 3.0 * u } else { 0.05 };
        assert!((mean - width).abs() < most, "{which:?}: {mean:.3} u {u:.4}");
    }
}

#[test]
fn shafts_in_uneven_light_keep_their_width() {
    for (seed, (name, field)) in light_fields().into_iter().enumerate() {
        for (rows, columns, width) in [(160, 200, 60.4), (240, 400, 110.7)] {
            let synth = synth(rows, columns, 1.1);
            let light = |row: usize, column: usize, mean: f64| {
                DARK + (mean - DARK) * field(row as f64 / rows as f64, column as f64 / columns as f64)
            };
            let frame = synth.frame_with(straight(rows, width), light, Some(seed as u64));
            let edges = gauge(24.0).edges(&frame.view()).unwrap_or_else(|e| panic!("{name}: {e}"));
            let (mean, u) = mean_width(&edges);
            assert!((mean - width).abs() < 3.5 * u, "{name}, {width} px: {mean} u {u}");
            assert!(u < 0.1, "{name}, {width} px: u {u}");
            assert!(10 * edges.valid() >= 9 * columns, "{name}: {} of {columns} columns", edges.valid());
        }
    }
}

#[test]
fn black_margins_are_no_shadow() {
    let (rows, columns, width) = (200, 260, 50.3);
    let synth = synth(rows, columns, 1.0);
    type Margin = Box<dyn Fn(f64, f64) -> bool>;
    let margins: [(&str, Margin); 4] = [
        ("above and below", Box::new(|r, _| !(0.2..0.8).contains(&r))),
        ("a frame", Box::new(|r, c| !(0.12..0.88).contains(&r) || !(0.12..0.88).contains(&c))),
        ("a round vignette", Box::new(|r, c| (r - 0.5).hypot(1.3 * (c - 0.5)) > 0.5)),
        (
            "an undistorted picture",
            Box::new(|r, c| {
                let (x, y) = (2.0 * c - 1.0, 2.0 * r - 1.0);
                y.abs() > 1.0 - 0.15 * (1.0 - x * x) || x.abs() > 1.0 - 0.15 * (1.0 - y * y)
            }),
        ),
    ];
    for (seed, (name, black)) in margins.into_iter().enumerate() {
        let field = |row: usize, column: usize, mean: f64| {
            if black(row as f64 / rows as f64, column as f64 / columns as f64) { 3.0 } else { mean }
        };
        let frame = synth.frame_with(straight(rows, width), field, Some(seed as u64));
        let edges = gauge(24.0).edges(&frame.view()).unwrap_or_else(|e| panic!("{name}: {e}"));
        let (mean, u) = mean_width(&edges);
        // Columns whose window contains the corner of a margin are not clean; they are few.
        assert!((mean - width).abs() < (5.0 * u).max(0.02), "{name}: {mean} u {u}");
        assert!(2 * edges.valid() > columns, "{name}: {} of {columns} columns", edges.valid());
    }
}

/// The frame with some pixels replaced.
fn altered(frame: Frame, alter: impl Fn(usize, usize, u8) -> u8) -> Frame {
    let columns = frame.view().columns();
    let rows = frame.view().rows();
    let Buffer::U8(pixels) = frame.into_buffer() else { panic!("8 bit") };
    let pixels = pixels.iter().enumerate().map(|(k, v)| alter(k / columns, k % columns, *v)).collect();
    Frame::new(Buffer::U8(pixels), PixelFormat::Mono8, rows, columns, FrameMeta::default()).unwrap()
}

#[test]
fn stuck_columns_cost_their_own_columns_only() {
    let (rows, columns, width) = (160, 300, 60.4);
    for (seed, stuck) in
        [vec![(150, 250)], vec![(40, 0), (41, 0)], vec![(20, 250), (99, 0), (200, 120), (201, 250), (270, 0)]]
            .into_iter()
            .enumerate()
    {
        let frame = synth(rows, columns, 1.0).frame(straight(rows, width), Some(seed as u64));
        let frame = altered(frame, |_, column, value| {
            stuck.iter().find(|(at, _)| *at == column).map_or(value, |(_, level)| *level)
        });
        let edges = gauge(24.0).edges(&frame.view()).unwrap();
        let (mean, u) = mean_width(&edges);
        assert!((mean - width).abs() < 3.5 * u, "{stuck:?}: {mean} u {u}");
        assert!(edges.valid() + 2 * stuck.len() >= columns, "{stuck:?}: {} columns", edges.valid());
    }
}

#[test]
fn stuck_rows_do_not_cut_a_part_and_beside_an_edge_are_named() {
    let (rows, columns, width) = (160, 300, 60.4);
    let level = |_: usize| (0.5 * rows as f64 - 0.5 * width, 0.5 * rows as f64 + 0.5 * width);
    let with_row = |stuck: usize, level_counts: u8| {
        let frame = synth(rows, columns, 1.0).frame(level, Some(7));
        altered(frame, |row, _, value| if row == stuck { level_counts } else { value })
    };
    for stuck in [10, 80, 150] {
        for counts in [0, 120, 250] {
            let edges = gauge(24.0).edges(&with_row(stuck, counts).view()).unwrap();
            let (mean, u) = mean_width(&edges);
            assert!((mean - width).abs() < 3.5 * u, "row {stuck} at {counts}: {mean} u {u}");
        }
    }
    // The edges are at rows 49.8 and 110.2.
    for (stuck, counts) in [(52, 250), (110, 0), (104, 120)] {
        let refused = gauge(24.0).edges(&with_row(stuck, counts).view()).unwrap_err();
        assert!(refused.detail.contains(&format!("row {stuck} stands at {counts} counts")), "{refused}");
    }
}

#[test]
fn wires_from_six_pixels_are_measured() {
    let (rows, columns) = (120, 300);
    for (seed, width) in [6.2, 7.7, 9.4, 12.1, 16.8, 20.4].into_iter().enumerate() {
        for sigma in [0.6, 1.0, 1.6] {
            let frame = synth(rows, columns, sigma).frame(straight(rows, width), Some(seed as u64));
            let edges =
                gauge(4.0).edges(&frame.view()).unwrap_or_else(|e| panic!("{width} px, σ {sigma}: {e}"));
            let (mean, u) = mean_width(&edges);
            assert!((mean - width).abs() < 3.5 * u, "{width} px, σ {sigma}: {mean} u {u}");
            assert!(
                u < 0.05 && edges.valid() > 290,
                "{width} px, σ {sigma}: u {u}, {} columns",
                edges.valid()
            );
        }
    }
}

#[test]
fn a_wire_below_the_least_size_or_too_blurred_is_named_so() {
    let frame = synth(120, 300, 1.0).frame(straight(120, 14.6), Some(1));
    let refused = gauge(24.0).edges(&frame.view()).unwrap_err();
    assert!(refused.detail.contains("24 px") && refused.detail.contains("--min-diameter-px"), "{refused}");
    let frame = synth(120, 300, 2.8).frame(straight(120, 7.0), Some(1));
    let refused = gauge(4.0).edges(&frame.view()).unwrap_err();
    assert!(refused.detail.contains("blurred by"), "{refused}");
}

/// A round shadow whose pixels average 8 x 8 points of the blurred edge of a disc (straight to 1e-3
/// px from 20 px on).
fn disc(diameter: f64, sigma: f64, seed: u64) -> Frame {
    let size = diameter as usize + 50;
    let synth = synth(size, size + 10, sigma);
    let (y, x) = (0.5 * size as f64 + 0.37, 0.5 * size as f64 + 4.81);
    let radius = 0.5 * diameter;
    let field = |row: usize, column: usize, _: f64| {
        let mut sum = 0.0;
        for k in 0..64 {
            let (dy, dx) = ((f64::from(k / 8) + 0.5) / 8.0 - 0.5, (f64::from(k % 8) + 0.5) / 8.0 - 0.5);
            let r = (row as f64 + dy - y).hypot(column as f64 + dx - x);
            // A blurred disc's 50 % contour lies σ²/2R inside it (Laplacian of a curved step).
            let d = r - radius + sigma * sigma / (2.0 * radius);
            sum += 0.5 * (1.0 + statrs::function::erf::erf(d / sigma / std::f64::consts::SQRT_2));
        }
        DARK + (LIGHT - DARK) * sum / 64.0
    };
    synth.frame_with(|_| (0.0, 0.0), field, Some(seed))
}

#[test]
fn discs_from_twenty_pixels_are_round() {
    for (seed, diameter) in [21.3, 26.0, 33.7, 41.2, 50.8, 59.9].into_iter().enumerate() {
        for sigma in [0.7, 1.2] {
            let frame = disc(diameter, sigma, seed as u64);
            let ring = measure_ring(&frame.view(), &RingSettings::default()).unwrap();
            let (found, u) = (ring.outer.diameter_px, ring.outer.u_diameter_px);
            assert!((found - diameter).abs() < 3.5 * u.max(2e-3), "{diameter} px, σ {sigma}: {found} u {u}");
            assert!(ring.inner.is_none());
        }
    }
}

#[test]
fn a_disc_survives_stuck_lines_and_falling_light() {
    let diameter = 80.6;
    let frame = disc(diameter, 1.0, 5);
    let columns = frame.view().columns() as f64;
    let fall = |column: usize, v: u8| {
        (DARK + (f64::from(v) - DARK) * (1.0 - 0.7 * column as f64 / columns)).round() as u8
    };
    let altered = altered(frame, |row, column, v| match (row, column) {
        (70, _) => 250,
        (_, 33) => 0,
        _ => fall(column, v),
    });
    let ring = measure_ring(&altered.view(), &RingSettings::default()).unwrap();
    let (found, u) = (ring.outer.diameter_px, ring.outer.u_diameter_px);
    assert!((found - diameter).abs() < 4.0 * u, "{found} u {u}");
}

#[test]
fn another_view_is_recommended_where_it_shows_a_part() {
    let frame = synth(200, 260, 1.0).frame(straight(200, 70.0), Some(3));
    let upright = gauge(24.0).edges(&frame.view().transposed()).unwrap_err();
    assert!(upright.detail.contains("--vertical"), "{upright}");
    let lit = altered(frame, |_, _, v| 255 - v);
    let bright = gauge(24.0).edges(&lit.view()).unwrap_err();
    assert!(bright.detail.contains("--bright-on-dark"), "{bright}");
    let settings = GaugeSettings { polarity: Polarity::BrightOnDark, ..GaugeSettings::default() };
    assert!(Gauge::new(settings).unwrap().edges(&lit.view()).is_ok());
}

#[test]
fn a_frame_without_a_part_says_what_it_shows() {
    let empty = synth(120, 200, 1.0).frame_with(|_| (50.0, 60.0), |_, _, _| LIGHT, Some(4));
    let refused = gauge(24.0).edges(&empty.view()).unwrap_err();
    assert_eq!(refused.reason, Reason::LowContrast);
    assert!(refused.detail.contains("one level"), "{refused}");
    let fall = synth(120, 200, 1.0).frame_with(
        |_| (50.0, 60.0),
        |row, _, _| DARK + (LIGHT - DARK) * (1.0 - 0.75 * row as f64 / 120.0),
        Some(4),
    );
    let refused = gauge(24.0).edges(&fall.view()).unwrap_err();
    assert!(refused.detail.contains("between light"), "{refused}");
}

fn diameter(document: &Value, key: &str) -> (f64, f64) {
    let frame = &document["frames"][0];
    (
        frame[key].as_f64().unwrap(),
        frame[format!("u_{}", key.replace("max_diameter", "max"))].as_f64().unwrap(),
    )
}

fn within(path: &Path, options: &[&str], right: f64) -> Value {
    let document = measured(path, options);
    let (found, u) = diameter(&document, "max_diameter_px");
    assert!((found - right).abs() < 3.0 * u, "{}: {found} u {u}, right is {right}", path.display());
    document
}

#[test]
fn the_collection_is_measured() {
    if let Some(path) = collected("light/three_to_one_along.png") {
        within(&path, &[], 64.4);
    }
    if let Some(path) = collected("defects/bright_column.png") {
        let document = within(&path, &[], 60.4);
        assert!(document["frames"][0]["valid"].as_u64().unwrap() >= 298);
    }
    if let Some(path) = collected("wire/wire_20_px.png") {
        within(&path, &["--min-diameter-px", "6"], 20.4);
        let refused =
            shadowgauge([Path::new("measure"), path.as_path(), Path::new("--um-per-px"), Path::new("1000")]);
        let text = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(!refused.status.success() && text.contains("--min-diameter-px"), "{text}");
    }
    if let Some(path) = collected("ring/disc_51_px.png") {
        let document = measured(&path, &["--shape", "ring"]);
        let frame = &document["frames"][0];
        let (found, u) =
            (frame["outer_diameter_px"].as_f64().unwrap(), frame["u_outer_diameter_px"].as_f64().unwrap());
        assert!((found - 50.8).abs() < 3.0 * u, "{found} u {u}");
    }
}
