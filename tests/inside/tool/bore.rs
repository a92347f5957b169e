//! Programs for bores: what they leave, how they go in and out, and that a block through material
//! is refused.

use glam::DVec2;

use super::parts::*;
use super::program::{difference_um, machine};
use crate::inside::linuxcnc::{canonical, interpret};
use crate::nc::{
    Bore, BoringBar, ContourProgram, Dialect, Direction, NcSettings, NoseRegister, Workpiece, WrittenContour,
};
use crate::nose::{Feed, NoseProfile};
use crate::outline::{Outline, Piece, Side};
use crate::plan::CuttingData;
use crate::tool::{Compensated, Compensator, Setting, Stated, Way};

/// Diameter of the drilled hole, mm.
const HOLE_MM: f64 = 15.0;

/// A bore from Z 20 to 52 in a hole of 15 mm: Ø16, a cone of 14° with a concave R2 before it, Ø20,
/// a convex R1.5 on a face, a concave R1.5 on Ø26; for the other feed mirrored.
fn bore(feed: Feed) -> Outline {
    let corners = [
        corner(20.0, 26.0, 0.0),
        corner(27.0, 26.0, 1.5),
        corner(27.0, 20.0, 1.5),
        corner(34.0, 20.0, 0.0),
        corner(42.0, 16.0, 2.0),
        corner(52.0, 16.0, 0.0),
    ];
    let mut corners = corners.to_vec();
    if feed == Feed::TowardsChuck {
        corners.iter_mut().for_each(|c| c.z_mm = 72.0 - c.z_mm);
        corners.reverse();
    }
    Outline::from_corners(&corners, Side::Internal).unwrap()
}

fn with_bar(bar: BoringBar) -> NcSettings {
    NcSettings { boring_bar: Some(bar), clearance_mm: 1.5, ..machine() }
}

/// A bar whose tip stands far out: it passes the mouth of a wider chamber.
fn slim() -> BoringBar {
    BoringBar { diameter_mm: 4.0, tip_mm: 10.0, reach_mm: 45.0, front_mm: 0.5 }
}

fn feed_of(c: &Compensator<'_>) -> Feed {
    if c.setting.tip.z < 0 { Feed::TowardsChuck } else { Feed::TowardsTailstock }
}

/// Runs `with` on the program of a way.
fn program<T>(
    c: &Compensator<'_>,
    done: &Compensated,
    settings: &NcSettings,
    with: impl Fn(&ContourProgram<'_>) -> T,
) -> T {
    let direction = match feed_of(c) {
        Feed::TowardsChuck => Direction::TowardsChuck,
        Feed::TowardsTailstock => Direction::TowardsTailstock,
    };
    let gauge = c.setting.gauge_point();
    let nose: Vec<DVec2> = c.setting.nose.outline().into_iter().map(|p| p - gauge).collect();
    let pieces: Vec<Piece> = done.programmed.iter().map(|e| e.piece).collect();
    with(&ContourProgram {
        pieces: &pieces,
        register: (done.way != Way::Path)
            .then_some(NoseRegister { radius_mm: done.register_mm, tip: c.setting.tip }),
        nose: &nose,
        piece: &Workpiece { direction, ..Workpiece::new(52.0, 40.0, 40.0) },
        bore: Some(Bore { hole_mm: HOLE_MM, outer_mm: Some(40.0), outline: c.outline }),
        settings,
        cutting: CuttingData { speed_m_per_min: 120.0, feed_mm_per_rev: 0.08 },
        about: "test",
    })
}

fn written(
    c: &Compensator<'_>,
    done: &Compensated,
    d: Dialect,
    s: &NcSettings,
) -> Result<WrittenContour, String> {
    program(c, done, s, |p| p.write(d).map_err(|e| e.to_string()))
}

/// Runs `with` on the bore of a feed with a nose in it.
fn compensated(nose: &NoseProfile, feed: Feed, with: impl Fn(&Compensator<'_>)) {
    let (whole, part, seen) = (shaft(), bore(feed), carried(nose, Side::Internal, feed));
    let tool = tool(Side::Internal, feed, full_tip(Side::Internal, feed));
    let setting = Setting::new(&seen, &tool, &Stated::default()).unwrap();
    let c = Compensator { outline: &part, setting, ..compensator(&whole, nose, 0.4) };
    c.check(&tool).unwrap();
    with(&c);
}

const FEEDS: [Feed; 2] = [Feed::TowardsChuck, Feed::TowardsTailstock];

#[test]
fn programs_of_bores_command_the_path_of_their_way() {
    let settings = with_bar(slim());
    for feed in FEEDS {
        compensated(&papers(), feed, |c| {
            for way in Way::ALL {
                let done = c.carry_out(way).unwrap();
                // the replay from every start position is the same for all of them: once is enough
                let others = [(Dialect::Fanuc, 1.5), (Dialect::Gsk, 1.5), (Dialect::Sinumerik, 1.5)];
                let others = others.into_iter().filter(|_| way == Way::EditedContour);
                for (dialect, most) in [(Dialect::Linuxcnc, 0.1)].into_iter().chain(others) {
                    let written = written(c, &done, dialect, &settings).unwrap();
                    let away = difference_um(c, &done, &written.moves);
                    println!("{feed:?} {} {}: {away:.4} µm", dialect.as_str(), way.as_str());
                    assert!(away < most, "{feed:?} {} {way:?}: {away}\n{}", dialect.as_str(), written.text);
                    // the tool is on the left of a bore that is cut towards the chuck
                    let side = if feed == Feed::TowardsChuck { "G41" } else { "G42" };
                    assert_eq!(written.text.contains(side), way != Way::Path, "{}", written.text);
                }
            }
        });
    }
}

#[test]
fn linuxcnc_drives_the_same_path_in_a_bore() {
    let settings = with_bar(slim());
    for feed in FEEDS {
        compensated(&papers(), feed, |c| {
            for way in Way::ALL {
                let done = c.carry_out(way).unwrap();
                let text = program(c, &done, &settings, |p| p.unproven(Dialect::Linuxcnc)).unwrap();
                let Some((_, printed)) = interpret(&text) else { return };
                let away = difference_um(c, &done, &canonical(&printed));
                println!("rs274, {feed:?} {}: {away:.4} µm", way.as_str());
                assert!(away < 0.1, "{feed:?} {way:?}: {away}\n{printed}\n{text}");
            }
        });
    }
}

#[test]
fn the_tool_goes_in_along_the_axis_and_out_along_z() {
    let settings = with_bar(slim());
    for feed in FEEDS {
        compensated(&papers(), feed, |c| {
            let done = c.carry_out(Way::Path).unwrap();
            let text = written(c, &done, Dialect::Linuxcnc, &settings).unwrap().text;
            // clear diameter: the hole less the clearance
            let last = text.lines().rev().skip_while(|l| *l != "G00 Z120.").collect::<Vec<_>>();
            assert!(text.contains("G00 Z120.\nX200.\n") && last[1].contains("X13.5"), "{text}");
            let (all, others) = text.rsplit_once(last[1]).unwrap();
            let replay = |text: &str| program(c, &done, &settings, |p| p.replay_of(text, Dialect::Linuxcnc));
            assert!(replay(&text).unwrap() > 20);
            // without the way back to the axis the rapid out runs through what stands around the
            // hole
            let refused =
                replay(&format!("{}{others}", all.trim_end_matches("G01 "))).unwrap_err().to_string();
            assert!(refused.contains("in rapid the tool"), "{refused}");
            // X before Z leaves through the wall
            let refused = replay(&text.replace("G00 Z120.\nX200.\n", "G00 X200.\nZ120.\n")).unwrap_err();
            assert!(refused.to_string().contains("in rapid the tool"), "{refused}");
        });
    }
}

#[test]
fn a_bar_that_does_not_fit_is_refused_where_it_touches() {
    let refused = |feed: Feed, settings: &NcSettings| {
        let found = std::cell::RefCell::new(String::new());
        compensated(&papers(), feed, |c| {
            let done = c.carry_out(Way::Path).unwrap();
            *found.borrow_mut() = written(c, &done, Dialect::Linuxcnc, settings).unwrap_err();
        });
        found.into_inner()
    };
    // 8 mm with its axis 6 mm below the tip: in the chamber it reaches to Ø22, the mouth has 16
    let thick = BoringBar { diameter_mm: 8.0, tip_mm: 6.0, reach_mm: 45.0, front_mm: 0.5 };
    let said = refused(Feed::TowardsTailstock, &with_bar(thick));
    assert!(said.contains("in feed the boring bar touches the finished bore at Z"), "{said}");
    // 12 mm meets the opposite wall, on its way in where the cut begins inside
    let wide = BoringBar { diameter_mm: 12.0, ..slim() };
    let said = refused(Feed::TowardsChuck, &with_bar(wide));
    assert!(said.contains("in feed the boring bar touches the finished bore"), "{said}");
    let said = refused(Feed::TowardsTailstock, &with_bar(wide));
    assert!(said.contains("in rapid the tool") && said.contains("hole"), "{said}");
    // 25 mm long, and the bore is 32 mm deep
    let short = BoringBar { reach_mm: 25.0, ..slim() };
    let said = refused(Feed::TowardsChuck, &with_bar(short));
    assert!(said.contains("in feed the boring bar touches the finished bore"), "{said}");
    let said = refused(Feed::TowardsChuck, &machine());
    assert!(said.contains("boring_bar"), "{said}");
    let said = refused(Feed::TowardsChuck, &NcSettings { tailstock: None, ..with_bar(slim()) });
    assert!(said.contains("tailstock = \"none\""), "{said}");
    let said = refused(Feed::TowardsChuck, &NcSettings { clearance_mm: 15.0, ..with_bar(slim()) });
    assert!(said.contains("hole of 15 mm") && said.contains("clearance_mm"), "{said}");
}

#[test]
fn a_blind_bore_is_faced_to_its_axis_and_left_along_z() {
    let (whole, papers) = (shaft(), papers());
    let seen = carried(&papers, Side::Internal, Feed::TowardsChuck);
    let corners = [corner(25.0, 0.0, 0.0), corner(25.0, 16.0, 0.0), corner(45.0, 16.0, 0.0)];
    let part = Outline::from_corners(&corners, Side::Internal).unwrap();
    let tool = tool(Side::Internal, Feed::TowardsChuck, full_tip(Side::Internal, Feed::TowardsChuck));
    let setting = Setting::new(&seen, &tool, &Stated::default()).unwrap();
    let c = Compensator { outline: &part, setting, ..compensator(&whole, &papers, 0.4) };
    let done = c.carry_out(Way::Register).unwrap();
    let bar = BoringBar { diameter_mm: 6.0, tip_mm: 4.0, reach_mm: 45.0, front_mm: 0.0 };
    let text = written(&c, &done, Dialect::Linuxcnc, &with_bar(bar)).unwrap().text;
    assert!(text.contains("X0. Z25.\nG40 G01 X0. Z27.\nX13.5\nG00 Z120.\n"), "{text}");
    // what stands before the tip meets the bottom
    let longer = BoringBar { front_mm: 0.5, ..bar };
    let said = written(&c, &done, Dialect::Linuxcnc, &with_bar(longer)).unwrap_err();
    assert!(said.contains("in feed the boring bar touches the finished bore at Z 0.000 to 25.000"), "{said}");
}
