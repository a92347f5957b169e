//! Models that no lathe turns: each is refused, with its place within 1 mm.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::accuracy::SETTINGS;
use super::body::{Body, Triangles, ascii, binary, outline, papers_part, placed, pose, profile};
use crate::stl::{FaultKind, ReadSettings, Unit, read_part};

/// Vertices a turn.
const N: usize = 48;

fn shaft() -> Body {
    Body::turned(&profile(&outline(&papers_part(1)), 15.0), N)
}

/// A shaft with turns every 2 mm, so that a fault has turns of its own.
fn fine() -> Body {
    let mut points = vec![DVec2::ZERO];
    points.extend((0..=20).map(|k| DVec2::new(15.0, 2.0 * f64::from(k))));
    points.extend((1..=10).map(|k| DVec2::new(15.0 - 0.5 * f64::from(k), 40.0 + 2.0 * f64::from(k))));
    points.push(DVec2::new(0.0, 60.0));
    Body::turned(&points, N)
}

/// A model, what it is refused for, and vertices of the place.
struct Case {
    name: &'static str,
    triangles: Triangles,
    kinds: &'static [FaultKind],
    place: Vec<DVec3>,
}

/// A body of which the vertices that `is_meant` are moved.
fn moved(
    name: &'static str,
    body: &Body,
    is_meant: impl Fn(DVec3) -> bool,
    change: impl Fn(DVec3) -> DVec3,
) -> Case {
    let place: Vec<DVec3> = body.rows.iter().flatten().copied().filter(|v| is_meant(*v)).collect();
    assert!(!place.is_empty(), "{name}");
    let place = place.into_iter().flat_map(|v| [v, change(v)]).collect();
    let body = body.clone().mapped(|v| if is_meant(v) { change(v) } else { v });
    let kinds = &[FaultKind::OffAxis, FaultKind::Scatter, FaultKind::FewVertices, FaultKind::Sagitta];
    Case { name, triangles: body.triangles(), kinds, place }
}

fn radial(v: DVec3) -> f64 {
    v.truncate().length()
}

fn with_radius(v: DVec3, r: f64) -> DVec3 {
    (v.truncate().normalize_or_zero() * r).extend(v.z)
}

fn angle_deg(v: DVec3) -> f64 {
    v.y.atan2(v.x).to_degrees()
}

/// Corners and middles of the edges of a facet.
fn around(t: [DVec3; 3]) -> Vec<DVec3> {
    let middle = |k: usize| 0.5 * (t[k] + t[(k + 1) % 3]);
    t.into_iter().chain((0..3).map(middle)).collect()
}

/// Surfaces that are not turned.
fn off_the_axis() -> Vec<Case> {
    let fine = fine();
    let between = |low: f64, high: f64| move |v: DVec3| (low..high).contains(&v.z);
    let in_section = |v: DVec3| (9.0..21.0).contains(&v.z);
    let deep = |by: f64| move |v: DVec3| with_radius(v, radial(v) - by);
    vec![
        moved("keyway .2", &fine, |v| in_section(v) && angle_deg(v).abs() < 12.0, deep(0.2)),
        moved("keyway .02", &fine, |v| in_section(v) && angle_deg(v).abs() < 12.0, deep(0.02)),
        moved("keyway to the end", &fine, |v| v.z > 40.5 && angle_deg(v).abs() < 12.0, deep(1.0)),
        moved("a key that stands up", &fine, |v| in_section(v) && angle_deg(v).abs() < 12.0, deep(-1.0)),
        moved("eccentric .05", &fine, between(40.5, 61.0), |v| v + DVec3::new(0.05, 0.0, 0.0)),
        moved("eccentric .005", &fine, between(40.5, 61.0), |v| v + DVec3::new(0.0, 0.005, 0.0)),
        moved("eccentric in the middle", &fine, in_section, |v| v + DVec3::new(0.03, 0.04, 0.0)),
        moved("elliptic .02", &fine, in_section, |v| DVec3::new(v.x * 1.001_3, v.y, v.z)),
        moved("three lobes of .01", &fine, in_section, |v| {
            with_radius(v, radial(v) + 0.01 * (3.0 * v.y.atan2(v.x)).cos())
        }),
        moved("flat", &fine, |v| in_section(v) && v.x > 14.0, |v| DVec3::new(14.0, v.y, v.z)),
        moved(
            "flats on both sides",
            &fine,
            |v| in_section(v) && v.x.abs() > 13.5,
            |v| DVec3::new(13.5 * v.x.signum(), v.y, v.z),
        ),
        moved("square journal", &fine, between(40.5, 61.0), |v| {
            let half = 7.0 / v.x.abs().max(v.y.abs()).max(1e-9);
            v * DVec3::new(half, half, 1.0)
        }),
        moved("oblique journal", &fine, between(40.5, 61.0), |v| {
            v + DVec3::new(0.002 * (v.z - 40.0), 0.0, 0.0)
        }),
        moved("oblique end face", &fine, |v| v.z > 59.0, |v| v + DVec3::new(0.0, 0.0, 0.02 * v.x)),
        moved("bent", &fine, between(40.5, 61.0), |v| v + DVec3::new(0.0, 2e-4 * (v.z - 40.0).powi(2), 0.0)),
        moved(
            "dent of one vertex",
            &fine,
            |v| (19.5..20.5).contains(&v.z) && angle_deg(v).abs() < 1.0,
            deep(0.05),
        ),
        moved("helix", &fine, in_section, |v| {
            with_radius(v, radial(v) + 0.1 * (v.y.atan2(v.x) + TAU * v.z / 3.0).cos())
        }),
        moved(
            "wobbling shoulder",
            &shaft(),
            |v| (9.9..10.1).contains(&v.z),
            |v| v + DVec3::new(0.0, 0.0, 0.05 * (2.0 * v.y.atan2(v.x)).sin()),
        ),
    ]
}

/// Meshes that bound no single body.
fn not_closed() -> Vec<Case> {
    let whole = shaft().triangles();
    let case = |name, triangles: Triangles, kind: &'static [FaultKind], place: Vec<DVec3>| Case {
        name,
        triangles,
        kinds: kind,
        place,
    };
    let mut cases = Vec::new();
    let mut hole = whole.clone();
    let lost = hole.remove(101);
    cases.push(case("a facet missing", hole, &[FaultKind::Open], around(lost)));
    let mut body = shaft();
    let rim = body.rows[body.rows.len() - 1].clone();
    body.poles[1] = None;
    cases.push(case("an end face missing", body.triangles(), &[FaultKind::Open], rim));
    let mut inverted = whole.clone();
    inverted[77].swap(0, 1);
    cases.push(case("a facet turned", inverted, &[FaultKind::Orientation], around(whole[77])));
    let mut twice = whole.clone();
    let fin = DVec3::new(30.0, 0.0, 5.0);
    twice.push([whole[60][0], whole[60][1], fin]);
    twice.push([whole[60][1], whole[60][0], fin]);
    cases.push(case(
        "a fin",
        twice,
        &[FaultKind::NonManifold, FaultKind::Open],
        around([whole[60][0], whole[60][1], fin]),
    ));
    let mut crack = whole.clone();
    crack[20][0] += DVec3::new(0.01, 0.0, 0.0);
    cases.push(case("a crack of .01", crack, &[FaultKind::Open], around(whole[20])));
    let ball = || {
        Body::turned(
            &(0..=12)
                .map(|k| {
                    let a = std::f64::consts::PI * f64::from(k) / 12.0;
                    DVec2::new(if k % 12 == 0 { 0.0 } else { 2.0 * a.sin() }, 5.0 - 2.0 * a.cos())
                })
                .collect::<Vec<_>>(),
            24,
        )
    };
    let cavity: Triangles = ball().triangles().into_iter().map(|[a, b, c]| [a, c, b]).collect();
    let place = cavity.iter().flatten().copied().collect();
    cases.push(case("a cavity", [whole.clone(), cavity].concat(), &[FaultKind::SeveralBodies], place));
    let second = placed(&ball().triangles(), (glam::DMat3::IDENTITY, DVec3::new(40.0, 0.0, 0.0)));
    let place = second.iter().flatten().copied().collect();
    cases.push(case("two bodies", [whole, second].concat(), &[FaultKind::SeveralBodies], place));
    cases
}

/// Bodies that are no shaft at all, or too coarse.
fn other_bodies() -> Vec<Case> {
    let points =
        |list: &[(f64, f64)]| -> Vec<DVec2> { list.iter().map(|(r, z)| DVec2::new(*r, *z)).collect() };
    let plain = points(&[(0.0, 0.0), (15.0, 0.0), (15.0, 30.0), (0.0, 30.0)]);
    let all = |body: &Body| body.triangles().into_iter().flat_map(around).collect::<Vec<_>>();
    let of = |name, body: Body, kinds: &'static [FaultKind]| {
        let place = all(&body);
        Case { name, triangles: body.triangles(), kinds, place }
    };
    let loops = points(&[
        (0.0, 0.0),
        (15.0, 0.0),
        (15.0, 20.0),
        (8.0, 10.0),
        (8.0, 26.0),
        (12.0, 12.0),
        (12.0, 30.0),
        (0.0, 30.0),
    ]);
    vec![
        of("hexagonal bar", Body::turned(&plain, 6), &[FaultKind::FewVertices]),
        of("square bar", Body::turned(&plain, 4), &[FaultKind::FewVertices, FaultKind::OffAxis]),
        of("eleven sides", Body::turned(&plain, 11), &[FaultKind::FewVertices]),
        of("fourteen sides of Ø30", Body::turned(&plain, 14), &[FaultKind::Sagitta]),
        of(
            "box",
            Body::turned(&plain, 4).mapped(|v| DVec3::new(0.5 * v.x, v.y, v.z)),
            &[FaultKind::OffAxis, FaultKind::Scatter, FaultKind::FewVertices],
        ),
        of("a profile that crosses itself", Body::turned(&loops, N), &[FaultKind::SelfCrossing]),
    ]
}

#[test]
fn every_fault_is_refused_with_its_place() {
    let cases: Vec<Case> = off_the_axis().into_iter().chain(not_closed()).chain(other_bodies()).collect();
    let mut bad = Vec::new();
    assert!(cases.len() >= 30, "{}", cases.len());
    for case in &cases {
        let (turn, shift) = pose();
        let bytes = binary(&placed(&case.triangles, (turn, shift)));
        match read_part(&bytes, &SETTINGS) {
            Ok(part) => bad.push(format!("{}: read as {:?}", case.name, part.outline.pieces.len())),
            Err(fault) => {
                let at = fault.at.map(|at| turn.transpose() * (at - shift));
                let near =
                    |at: DVec3| case.place.iter().map(|p| p.distance(at)).fold(f64::INFINITY, f64::min);
                let away = at.map_or(f64::INFINITY, near);
                println!("{}: {away:.3} mm, {:?}: {fault}", case.name, fault.kind);
                if away > 1.0 || !case.kinds.contains(&fault.kind) {
                    bad.push(format!(
                        "{}: {away:.3} mm from its place {at:?}, {:?}: {fault}",
                        case.name, fault.kind
                    ));
                }
            }
        }
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

/// A text with decimal commas, as an exporter under another language writes it.
fn commas(text: &[u8]) -> Vec<u8> {
    text.iter().map(|b| if *b == b'.' { b',' } else { *b }).collect()
}

/// A text of which the first coordinate is no number.
fn not_a_number(text: &[u8]) -> Vec<u8> {
    let text = String::from_utf8(text.to_vec()).unwrap();
    let (before, behind) = text.split_once("vertex ").unwrap();
    let (_, behind) = behind.split_once(' ').unwrap();
    format!("{before}vertex NaN {behind}").into_bytes()
}

/// What exporters write besides: names in Latin-1, normals that are no numbers, CRLF, capitals.
#[test]
fn ways_of_exporters_are_taken() {
    let text = String::from_utf8(ascii(&shaft().triangles(), 8)).unwrap();
    let (_, behind) = text.split_once('\n').unwrap();
    let latin = [b"solid W\xfcrfel\n".to_vec(), behind.as_bytes().to_vec()].concat();
    let taken = [
        latin,
        text.replacen("normal 0 0 0", "normal nan -nan(ind) inf", 3).into_bytes(),
        text.replace('\n', "\r\n").into_bytes(),
        text.to_uppercase().into_bytes(),
        format!("\u{feff}\n{text}").into_bytes(),
    ];
    for (i, bytes) in taken.iter().enumerate() {
        read_part(bytes, &SETTINGS).unwrap_or_else(|fault| panic!("{i}: {fault}"));
    }
}

/// Files that hold no model, or one of another size.
#[test]
fn files_and_units_are_refused() {
    let whole = shaft().triangles();
    let (good, text) = (binary(&whole), ascii(&whole, 8));
    let cut_text = text[..text.len() / 2].to_vec();
    let mut number = text.clone();
    let at = number.windows(6).position(|w| w == b"vertex").unwrap();
    number[at + 7..at + 10].copy_from_slice(b"abc");
    let mut infinite = good.clone();
    infinite[96..100].copy_from_slice(&f32::NAN.to_le_bytes());
    let two = [text.clone(), text.clone()].concat();
    let flat: Triangles = vec![[DVec3::ZERO, DVec3::ZERO, DVec3::X]; 3];
    let png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".repeat(20);
    let with = |from: &str, to: &str| String::from_utf8(text.clone()).unwrap().replacen(from, to, 1);
    let vertex = with("vertex ", "vertex nan ");
    let cases: [(&str, Vec<u8>, FaultKind, &str); 16] = [
        ("nothing", Vec::new(), FaultKind::Empty, "empty"),
        ("no facet", binary(&Vec::new()), FaultKind::Empty, "0 facets"),
        ("facets without area", binary(&flat), FaultKind::Empty, "none with an area"),
        ("cut off", good[..good.len() - 1000].to_vec(), FaultKind::File, "cut off"),
        ("ascii cut off", cut_text, FaultKind::File, "cut off"),
        ("a word for a number", number, FaultKind::File, "line 4, `vertex abc"),
        ("not a number", infinite, FaultKind::File, "facet 1"),
        ("another file", b"PK\x03\x04 a drawing".to_vec(), FaultKind::File, "ZIP archive"),
        ("a picture", png, FaultKind::File, "PNG image"),
        ("a letter", b"Dear Sir or Madam,\n".repeat(30), FaultKind::File, "does not begin with `solid`"),
        ("a letter about solids", b"solid work,\n".repeat(30), FaultKind::File, "text of another kind"),
        ("a number more", vertex.into_bytes(), FaultKind::File, "line 4, `vertex nan"),
        ("commas", commas(&text), FaultKind::File, "decimal points"),
        ("not a number in text", not_a_number(&text), FaultKind::File, "line 4, `vertex NaN"),
        ("zeros", vec![0; 500], FaultKind::File, "cut off or no STL"),
        ("two solids", two, FaultKind::SeveralBodies, "2 solids"),
    ];
    for (name, bytes, kind, word) in cases {
        let fault = read_part(&bytes, &SETTINGS).expect_err(name);
        assert!(fault.kind == kind && fault.to_string().contains(word), "{name}: {fault}");
    }
    for (unit, scale) in
        [(Unit::Inch, 1.0), (Unit::Millimetre, 1.0 / 25.4), (Unit::Centimetre, 1.0), (Unit::Millimetre, 0.1)]
    {
        let scaled: Triangles = whole.iter().map(|t| t.map(|p| p * scale)).collect();
        let fault = read_part(&binary(&scaled), &ReadSettings { unit, ..SETTINGS }).unwrap_err();
        assert!(fault.kind == FaultKind::Unit && fault.to_string().contains("--unit"), "{fault}");
    }
    let thick = read_part(&good, &ReadSettings { stock_mm: 39.0, ..SETTINGS }).unwrap_err();
    assert!(thick.kind == FaultKind::Unit && thick.to_string().contains("another bar"), "{thick}");
}
