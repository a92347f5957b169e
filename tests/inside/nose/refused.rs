//! Frames that show no nose that can be measured: each is refused with its place and a remedy.

use glam::DVec2;
use shadowgauge::frame::{Buffer, Frame, FrameMeta, PixelFormat, Pixels};
use shadowgauge::gauge::nose::{ExpectedNose, NoseImageError, NoseSettings, measure_nose};
use shadowgauge::render::insert::{Dirt, InsertSettings, render_insert};
use shadowgauge::render::settings::{Esf, GaussianEsf};

use super::insert;

/// The right-hand tool of [`insert`] at pose 0.
fn tool() -> NoseSettings {
    let expected = ExpectedNose { epsilon_deg: 60.0, normals_deg: [177.0, 297.0], by: "tool's file" };
    NoseSettings { nominal_radius_px: None, um_per_px: 2.415, expected: Some(expected) }
}

fn said(s: &InsertSettings, settings: &NoseSettings) -> String {
    let (frame, _) = render_insert(s, (1, 0), true).unwrap();
    measure_nose(&frame.view(), settings).unwrap_err().to_string()
}

#[test]
fn the_tool_as_its_file_states_it_is_measured() {
    let (frame, _) = render_insert(&insert(0), (1, 0), true).unwrap();
    let found = measure_nose(&frame.view(), &tool()).unwrap();
    assert!((found.angle_deg - 60.0).abs() < 0.01);
}

#[test]
fn no_insert_and_a_covered_field() {
    let mut s = insert(0);
    s.nose.centre_px = [-2000.0, 3000.0];
    let none = said(&s, &NoseSettings::default());
    assert!(none.contains("no insert") && none.contains("backlight"), "{none}");
    s.nose.centre_px = [-4000.0, 6000.0];
    s.nose.direction_deg = 57.0;
    let covered = said(&s, &NoseSettings::default());
    assert!(covered.contains("no insert"), "{covered}");
}

#[test]
fn two_inserts() {
    let mut s = insert(0);
    s.dirt.push(Dirt { centre_px: [60.0, 80.0], radius_um: 150.0 });
    let two = said(&s, &NoseSettings::default());
    assert!(two.contains("two inserts") && two.contains("row") && two.contains("leave one"), "{two}");
}

#[test]
fn a_nose_outside_of_the_field() {
    let mut s = insert(0);
    s.nose.centre_px = [130.0, 470.0];
    let outside = said(&s, &NoseSettings::default());
    assert!(outside.contains("outside of the field") && outside.contains("move the tool"), "{outside}");
}

#[test]
fn focus_lost() {
    let mut s = insert(0);
    s.esf = Esf::Gaussian(GaussianEsf { sigma_px: 4.2 });
    let blurred = said(&s, &NoseSettings::default());
    assert!(blurred.contains("focus lost") && blurred.contains("plane of focus"), "{blurred}");
}

#[test]
fn an_angle_that_cannot_be_the_tools() {
    let mut s = insert(0);
    s.nose.epsilon_deg = 55.0;
    let wrong = said(&s, &tool());
    assert!(wrong.contains("epsilon_r_deg is 60") && wrong.contains("--tool"), "{wrong}");
}

/// A frame whose place (row, column) shows what `from` has at another.
fn moved(frame: &Frame, size: (usize, usize), from: impl Fn(usize, usize) -> (usize, usize)) -> Frame {
    let view = frame.view();
    let Pixels::U16(pixels) = view.pixels() else { panic!("a 12-bit frame") };
    let (rows, columns) = size;
    let at = |k: usize| {
        let (row, column) = from(k / columns, k % columns);
        pixels[row * view.columns() + column]
    };
    let buffer = Buffer::U16((0..rows * columns).map(at).collect());
    Frame::new(buffer, PixelFormat::Mono12, rows, columns, FrameMeta::default()).unwrap()
}

#[test]
fn rotated_and_mirrored_pictures() {
    let (frame, _) = render_insert(&insert(0), (1, 0), true).unwrap();
    let (rows, columns) = (420, 520);
    let across = moved(&frame, (rows, columns), |r, c| (r, columns - 1 - c));
    let down = moved(&frame, (rows, columns), |r, c| (rows - 1 - r, c));
    let turned = moved(&frame, (columns, rows), |r, c| (c, columns - 1 - r));
    for (picture, how) in
        [(across, "mirrored left to right"), (down, "mirrored top to bottom"), (turned, "rotated by 90")]
    {
        let said = measure_nose(&picture.view(), &tool()).unwrap_err().to_string();
        assert!(said.contains(how) && said.contains("plus_x_deg"), "{how}: {said}");
    }
}

#[test]
fn a_bright_insert_on_a_dark_ground() {
    for pose in 0..4 {
        let (frame, truth) = render_insert(&insert(pose), (1, 0), true).unwrap();
        let view = frame.view();
        let Pixels::U16(pixels) = view.pixels() else { panic!("a 12-bit frame") };
        let buffer = Buffer::U16(pixels.iter().map(|v| 4095 - v).collect());
        let turned = Frame::new(buffer, PixelFormat::Mono12, 420, 520, FrameMeta::default()).unwrap();
        for settings in [NoseSettings::default(), tool()] {
            let error = measure_nose(&turned.view(), &settings).unwrap_err();
            let NoseImageError::Swapped { row, column } = error else { panic!("pose {pose}: {error}") };
            let off = (column - truth.centre_px[0]).hypot(row - truth.centre_px[1]);
            assert!(off < 1.2 * truth.nominal_radius_px, "pose {pose}: row {row}, column {column}");
            let said = error.to_string();
            assert!(said.contains("swapped") && said.contains("not inverted"), "{said}");
        }
    }
}

#[test]
fn a_nose_of_another_radius_or_tool_than_stated() {
    let (frame, _) = render_insert(&insert(0), (1, 0), true).unwrap();
    let twice = NoseSettings { nominal_radius_px: Some(165.6), ..tool() };
    let said = measure_nose(&frame.view(), &twice).unwrap_err().to_string();
    assert!(said.contains("radius of about 83 px (0.2") && said.contains("0.400"), "{said}");
    // what else is wrong goes before it: the corner is another one, or lies otherwise
    let other = ExpectedNose { normals_deg: [117.0, 237.0], ..tool().expected.unwrap() };
    let said = measure_nose(&frame.view(), &NoseSettings { expected: Some(other), ..twice });
    assert!(said.unwrap_err().to_string().contains("rotated by 60"));
    let other = ExpectedNose { epsilon_deg: 80.0, ..tool().expected.unwrap() };
    let said = measure_nose(&frame.view(), &NoseSettings { expected: Some(other), ..twice });
    assert!(said.unwrap_err().to_string().contains("epsilon_r_deg is 80"));
}

#[test]
fn a_round_insert() {
    let lit = |k: usize| {
        let r = ((k % 520) as f64 - 260.0).hypot((k / 520) as f64 - 210.0);
        (300.0 + 2700.0 / (1.0 + (-2.0 * (r - 150.0)).exp())) as u16
    };
    let buffer = Buffer::U16((0..420 * 520).map(lit).collect());
    let round = Frame::new(buffer, PixelFormat::Mono12, 420, 520, FrameMeta::default()).unwrap();
    let said = measure_nose(&round.view(), &NoseSettings::default()).unwrap_err().to_string();
    assert!(said.contains("a round insert has no edges"), "{said}");
}

#[test]
fn black_that_is_clipped_and_a_tool_that_moved_are_flagged() {
    let (frame, _) = render_insert(&insert(0), (1, 0), true).unwrap();
    let view = frame.view();
    let Pixels::U16(pixels) = view.pixels() else { panic!("a 12-bit frame") };
    let of = |change: &dyn Fn(usize) -> u16| {
        let buffer = Buffer::U16((0..420 * 520).map(change).collect());
        let frame = Frame::new(buffer, PixelFormat::Mono12, 420, 520, FrameMeta::default()).unwrap();
        measure_nose(&frame.view(), &NoseSettings::default()).unwrap().flags
    };
    assert_eq!(of(&|k| pixels[k]), Vec::<&str>::new());
    // the foot of the edge is cut off
    assert!(of(&|k| pixels[k].saturating_sub(600)).contains(&"edge_profile"));
    // seven pixels along the rows: one edge is blurred by 2.3 px, the other by 1.5
    let moved = |k: usize| {
        let (row, column) = (k / 520, (k % 520).clamp(3, 516));
        ((column - 3..=column + 3).map(|c| u32::from(pixels[row * 520 + c])).sum::<u32>() / 7) as u16
    };
    assert!(of(&moved).contains(&"edge_profile"));
}

/// Every second pixel of an insert twice as large, and its truth in the small picture's pixels.
fn made_smaller(sigma_px: f64) -> (Frame, [f64; 2], f64) {
    let mut s = insert(0);
    (s.camera.columns, s.camera.rows) = (1040, 840);
    s.nose.radius_mm = 0.4;
    s.nose.centre_px = [450.0, 520.0];
    s.esf = Esf::Gaussian(GaussianEsf { sigma_px });
    let (frame, truth) = render_insert(&s, (1, 0), true).unwrap();
    let small = moved(&frame, (420, 520), |row, column| (2 * row, 2 * column));
    (small, truth.centre_px.map(|c| 0.5 * c), 0.5 * truth.nominal_radius_px)
}

#[test]
fn a_picture_made_smaller_is_measured_while_its_blur_shows_and_named_where_it_does_not() {
    let (frame, centre, radius_px) = made_smaller(1.2);
    let settings = NoseSettings { nominal_radius_px: Some(radius_px), ..NoseSettings::default() };
    let found = measure_nose(&frame.view(), &settings).unwrap();
    // a blur of .6 px, with pixels of half its width: within .02 px as of full pictures
    let off = DVec2::new(found.centre.x - centre[0], found.centre.y + centre[1]).length();
    assert!(off < 0.02 && (found.angle_deg - 60.0).abs() < 0.005, "{off} px, {}°", found.angle_deg);
    let (frame, ..) = made_smaller(0.4);
    let said = measure_nose(&frame.view(), &settings).unwrap_err().to_string();
    assert!(said.contains("made smaller") && said.contains("as the camera took it"), "{said}");
}

#[test]
fn an_edge_in_whose_calipers_no_blurred_edge_fits() {
    // a stripe of reflected light along the second edge, 2 to 4 px inside the shadow: the contour
    // of half the light is where it was, and the grey values across it are those of no lens
    let (frame, truth) = render_insert(&insert(0), (1, 0), true).unwrap();
    let view = frame.view();
    let Pixels::U16(pixels) = view.pixels() else { panic!("a 12-bit frame") };
    let n = DVec2::from_angle(truth.edge_normals_deg[1].to_radians());
    let r = truth.nominal_radius_px;
    let lit = |k: usize| {
        let at = DVec2::new((k % 520) as f64 - truth.centre_px[0], truth.centre_px[1] - (k / 520) as f64);
        let (inside, along) = (r - at.dot(n), at.dot(n.perp()));
        let stripe = (2.0..4.0).contains(&inside) && along > 0.2 * r;
        pixels[k] + if stripe { 900 } else { 0 }
    };
    let buffer = Buffer::U16((0..420 * 520).map(lit).collect());
    let striped = Frame::new(buffer, PixelFormat::Mono12, 420, 520, FrameMeta::default()).unwrap();
    let error = measure_nose(&striped.view(), &NoseSettings::default()).unwrap_err();
    let NoseImageError::NoEdgeModel { row, column, refused, calipers } = error else {
        panic!("{error}");
    };
    // more than its share of 0.65, and the place lies on that edge
    assert!(refused as f64 > 0.65 * calipers as f64, "{refused} of {calipers}");
    let at = DVec2::new(column - truth.centre_px[0], truth.centre_px[1] - row);
    assert!((at.dot(n) - r).abs() < 2.0 && at.dot(n.perp()) > 0.0, "row {row} column {column}");
    let said = error.to_string();
    for words in ["no blurred edge fits in", "cutting edge about row", "not made smaller", "reflections"] {
        assert!(said.contains(words), "{words}: {said}");
    }
}
