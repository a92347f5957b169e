//! Lines and arcs that are tangent on the drawing stay tangent: in what each way programs, on the
//! path of the tool point, and in the text of each dialect as its replay drives it.

use glam::DVec2;

use super::parts::*;
use super::program::{control, machine};
use crate::nc::replay::{self, Deed};
use crate::nc::{Bore, BoringBar, ContourProgram, Dialect, Direction, NcSettings, NoseRegister, Workpiece};
use crate::nose::Feed;
use crate::outline::{Outline, Piece, Side};
use crate::plan::CuttingData;
use crate::tool::{Compensated, Compensator, Element, Setting, Stated, Way};

/// Largest angle between consecutive elements, rad.
const TANGENT_RAD: f64 = 1e-6;

/// Line, arc, line: cylinder and cone, the arc convex or concave.
fn outline(side: Side, feed: Feed, convex: bool) -> Outline {
    // seen as a shaft that is cut towards the chuck
    let corners = if convex {
        [corner(20.0, 30.0, 0.0), corner(32.0, 30.0, 5.0), corner(44.0, 22.0, 0.0)]
    } else {
        [corner(20.0, 30.0, 0.0), corner(32.0, 22.0, 5.0), corner(44.0, 22.0, 0.0)]
    };
    turned(&corners, (side, feed), 60.0)
}

/// Angles between consecutive elements, rad: by the normals' angles and by the ends' own
/// directions.
fn turns(elements: &[Element]) -> Vec<f64> {
    let ahead = |p: &Piece, a: f64| {
        let along = DVec2::from_angle(a).perp();
        along * (p.at(0.501) - p.at(0.499)).dot(along).signum()
    };
    let between = |w: &[Element]| {
        let (a, b) = (&w[0].piece, &w[1].piece);
        assert!(a.to.distance(b.from) < 1e-9, "{a:?} {b:?}");
        ahead(a, a.to_rad).angle_to(ahead(b, b.from_rad))
    };
    elements.windows(2).map(between).collect()
}

/// Directions at both ends of every block in feed that is part of the contour: chords of an arc
/// turn by equal angles, so that its end lies half a turn of a chord beyond the last one.
fn driven(text: &str, settings: &NcSettings, dialect: Dialect) -> Vec<(DVec2, DVec2, f64)> {
    let events = replay::run(text, &control(settings, dialect)).unwrap();
    let mut blocks: Vec<(usize, Vec<DVec2>)> = Vec::new();
    for event in events {
        let Deed::Move { from, to, rapid: false } = event.deed else { continue };
        let way = DVec2::new(0.5 * (to.x - from.x), to.z - from.z);
        match blocks.last_mut().filter(|b| b.0 == event.block) {
            Some(block) => block.1.push(way),
            None => blocks.push((event.block, vec![way])),
        }
    }
    let ends = |ways: &[DVec2]| {
        let n = ways.len();
        let half = if n > 3 { 0.5 * ways[n / 2 - 1].angle_to(ways[n / 2]) } else { 0.0 };
        let turned = |v: DVec2, by: f64| DVec2::from_angle(by).rotate(v.normalize());
        let length: f64 = ways.iter().map(|w| w.length()).sum();
        (turned(ways[0], -half), turned(ways[n - 1], half), length)
    };
    blocks.iter().map(|b| ends(&b.1)).collect()
}

fn with_program<T>(
    c: &Compensator<'_>,
    (feed, done): (Feed, &Compensated),
    settings: &NcSettings,
    with: impl Fn(&ContourProgram<'_>) -> T,
) -> T {
    let direction = match feed {
        Feed::TowardsChuck => Direction::TowardsChuck,
        Feed::TowardsTailstock => Direction::TowardsTailstock,
    };
    let gauge = c.setting.gauge_point();
    let nose: Vec<DVec2> = c.setting.nose.outline().into_iter().map(|p| p - gauge).collect();
    let pieces: Vec<Piece> = done.programmed.iter().map(|e| e.piece).collect();
    let bore = Bore { hole_mm: 29.0, outer_mm: None, outline: c.outline };
    with(&ContourProgram {
        pieces: &pieces,
        register: (done.way != Way::Path)
            .then_some(NoseRegister { radius_mm: done.register_mm, tip: c.setting.tip }),
        nose: &nose,
        piece: &Workpiece { direction, ..Workpiece::new(44.0, 40.0, 40.0) },
        bore: (c.outline.side == Side::Internal).then_some(bore),
        settings,
        cutting: CuttingData { speed_m_per_min: 120.0, feed_mm_per_rev: 0.08 },
        about: "test",
    })
}

/// Runs `with` on line, arc and line, convex and concave, both sides and feeds: arcs of both
/// senses.
fn each(with: impl Fn(&Compensator<'_>, Feed, &str)) {
    let (whole, papers) = (shaft(), papers());
    for (side, feed) in TURNED {
        for convex in [true, false] {
            let (part, nose) = (outline(side, feed, convex), carried(&papers, side, feed));
            assert_eq!(part.pieces.len(), 3);
            let tool = tool(side, feed, full_tip(side, feed));
            let setting = Setting::new(&nose, &tool, &Stated::default()).unwrap();
            let c = Compensator { outline: &part, setting, ..compensator(&whole, &papers, 0.4) };
            c.check(&tool).unwrap();
            let what = format!("{side:?} {feed:?} {}", if convex { "convex" } else { "concave" });
            with(&c, feed, &what);
        }
    }
}

#[test]
fn every_way_keeps_tangents() {
    let mut worst: f64 = 0.0;
    each(|c, _, what| {
        for way in Way::ALL {
            let done = c.carry_out(way).unwrap();
            for elements in [&done.programmed, &done.path] {
                assert!(elements.len() >= 3, "{what} {way:?}: {}", elements.len());
                for turn in turns(elements) {
                    assert!(turn.abs() < TANGENT_RAD, "{what} {way:?}: {turn:e}");
                }
            }
        }
    });
    // a corner is one: the measure sees it
    let (whole, papers) = (shaft(), papers());
    let done = compensator(&whole, &papers, 0.4).carry_out(Way::Register).unwrap();
    worst = turns(&done.programmed).into_iter().map(f64::abs).fold(worst, f64::max);
    assert!(worst > 0.4, "{worst}");
}

/// In a text ends and radii are rounded, by half an increment δ each (X on the diameter): both ends
/// of an element of the length l move by .56 δ at most, its chord turns by 1.1 δ/l, and a quarter
/// of a circle's ends against the chord by 1.6 δ/l; two elements meet within 6 δ/l.
#[test]
fn every_dialect_drives_tangents_as_far_as_it_resolves_them() {
    let bar = BoringBar { diameter_mm: 4.0, tip_mm: 12.0, reach_mm: 45.0, front_mm: 0.5 };
    let settings = NcSettings { boring_bar: Some(bar), ..machine() };
    let senses = std::cell::RefCell::new(std::collections::BTreeSet::new());
    each(|c, feed, what| {
        for way in Way::ALL {
            let done = c.carry_out(way).unwrap();
            for dialect in [Dialect::Linuxcnc, Dialect::Fanuc, Dialect::Sinumerik] {
                let text = with_program(c, (feed, &done), &settings, |p| p.unproven(dialect)).unwrap();
                for sense in ["G02", "G03"] {
                    let found = text.lines().any(|l| l.starts_with(sense));
                    found.then(|| senses.borrow_mut().insert((dialect.as_str(), sense)));
                }
                let increment = 10f64.powi(-(dialect.x_decimals() as i32));
                let blocks = driven(&text, &settings, dialect);
                // the first two blocks enter, the last leaves
                let cut = &blocks[2..blocks.len() - 1];
                assert!(cut.len() >= 3, "{what} {way:?} {}\n{text}", dialect.as_str());
                for pair in cut.windows(2) {
                    let (turn, least) = (pair[0].1.angle_to(pair[1].0).abs(), pair[0].2.min(pair[1].2));
                    let most = TANGENT_RAD + 6.0 * increment / least;
                    assert!(turn < most, "{what} {way:?} {}: {turn:e}, {most:e}\n{text}", dialect.as_str());
                }
            }
        }
    });
    assert_eq!(senses.into_inner().len(), 6, "G02 and G03 of every dialect");
}
