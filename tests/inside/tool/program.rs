//! Programs of all ways against the path they stand for, by the replay and by LinuxCNC's
//! interpreter.

use glam::DVec2;

use super::parts::{compensator, corner, flat_support, nose, papers, papers_support, round};
use crate::inside::linuxcnc::{canonical, interpret};
use crate::nc::replay::{self, Control, Deed, Point};
use crate::nc::{
    ChangePosition, Chuck, ContourProgram, Dialect, Direction, GeometryOffset, NcSettings, NoseRegister,
    Spindle, Tailstock, WearX, Workpiece, WrittenContour,
};
use crate::nose::{Feed, NoseProfile, Numbering, Support, TipDirection, ToolGeometry};
use crate::outline::{Outline, Piece, Side};
use crate::plan::CuttingData;
use crate::tool::{Compensated, Compensator, Setting, Stated, Tool, Way, remainders};

/// A shaft in a chuck: cylinder, shoulder, concave R2, cylinder, 24° cone, convex R5, end face.
fn part() -> Outline {
    let run = 2.0 / 24f64.to_radians().tan();
    let corners = [
        corner(20.0, 32.0, 0.0),
        corner(24.0, 32.0, 0.0),
        corner(24.0, 26.0, 2.0),
        corner(32.0, 26.0, 0.0),
        corner(32.0 + run, 22.0, 0.0),
        corner(45.0, 22.0, 5.0),
        corner(45.0, 6.0, 0.0),
    ];
    Outline::from_corners(&corners, Side::External).unwrap()
}

pub fn machine() -> NcSettings {
    NcSettings {
        tailstock: Some(Tailstock::Absent),
        chuck: Some(Chuck { diameter_mm: 160.0, jaws_to_z_mm: 14.0, jaws_diameter_mm: None }),
        change_position: Some(ChangePosition { x_mm: 200.0, z_mm: 120.0 }),
        wear_x: Some(WearX::Diameter),
        geometry_offset: Some(GeometryOffset::ByTool),
        spindle: Some(Spindle::M03),
        least_z_mm: 15.0,
        ..NcSettings::default()
    }
}

fn written(
    c: &Compensator<'_>,
    done: &Compensated,
    dialect: Dialect,
    settings: &NcSettings,
) -> Result<WrittenContour, String> {
    let direction = if c.setting.tip.z > 0 { Direction::TowardsTailstock } else { Direction::TowardsChuck };
    let gauge = c.setting.gauge_point();
    let outline: Vec<DVec2> = c.setting.nose.outline().into_iter().map(|p| p - gauge).collect();
    let pieces: Vec<Piece> = done.programmed.iter().map(|e| e.piece).collect();
    let program = ContourProgram {
        pieces: &pieces,
        register: (done.way != Way::Path)
            .then_some(NoseRegister { radius_mm: done.register_mm, tip: c.setting.tip }),
        nose: &outline,
        piece: &Workpiece { direction, ..Workpiece::new(45.0, 32.0, 32.0) },
        bore: None,
        settings,
        cutting: CuttingData { speed_m_per_min: 180.0, feed_mm_per_rev: 0.08 },
        about: "test",
    };
    program.write(dialect).map_err(|e| e.to_string())
}

/// Largest difference of what moves of the gauge point leave from what the way's own path leaves,
/// µm.
pub fn difference_um(c: &Compensator<'_>, done: &Compensated, moves: &[(DVec2, DVec2)]) -> f64 {
    let (tool, gauge) = (Tool::new(c.setting.nose), c.setting.gauge_point());
    let moves: Vec<_> = moves.iter().map(|m| (m.0 - gauge, m.1 - gauge)).collect();
    let own = remainders(c.outline, &done.path, &crate::tool::moves_of(&done.path), &tool);
    let other = remainders(c.outline, &done.path, &moves, &tool);
    assert_eq!(own.len(), other.len());
    let pairs = own.iter().zip(&other).filter(|(a, _)| a.reached);
    pairs.map(|(a, b)| 1e3 * (a.left_mm - b.left_mm).abs()).fold(0.0, f64::max)
}

fn noses() -> [NoseProfile; 2] {
    [papers(), nose(0.25, flat_support)]
}

#[test]
fn programs_command_the_path_of_their_way() {
    let (part, settings) = (part(), machine());
    for nose in &noses() {
        let c = compensator(&part, nose, 0.4);
        for way in Way::ALL {
            let done = c.carry_out(way).unwrap();
            // half an increment of Fanuc's X as a radius is .25 µm, of Z .5 µm, of R .5 µm
            for (dialect, most) in
                [(Dialect::Linuxcnc, 0.1), (Dialect::Fanuc, 1.5), (Dialect::Sinumerik, 1.5)]
            {
                let written = written(&c, &done, dialect, &settings).unwrap();
                let away = difference_um(&c, &done, &written.moves);
                println!("{} {}: {away:.4} µm", dialect.as_str(), way.as_str());
                assert!(away < most, "{} {}: {away}\n{}", dialect.as_str(), way.as_str(), written.text);
            }
        }
    }
}

/// The control of a dialect at the change position.
pub fn control(settings: &NcSettings, dialect: Dialect) -> Control<'_> {
    let change = Point { x: 200.0, z: 120.0 };
    Control {
        dialect,
        settings,
        start: change,
        reference: change,
        variables: Vec::new(),
        with_probe: false,
        surface: None,
        tool_page: None,
    }
}

#[test]
fn a_sinumerik_takes_radius_and_tip_of_the_edge_and_arcs_by_their_radius() {
    let (part, settings, nose) = (part(), machine(), round(0.4));
    let c = compensator(&part, &nose, 0.4);
    let done = c.carry_out(Way::Register).unwrap();
    let text = written(&c, &done, Dialect::Sinumerik, &settings).unwrap().text;
    for word in
        ["$TC_DP2[1,1]=3\n", "$TC_DP6[1,1]=0.4\n", "$TC_DP15[1,1]=0\n", "G451 NORM", "G42 X=", " CR=5"]
    {
        assert!(text.contains(word), "{word}: {text}");
    }
    let control = control(&settings, Dialect::Sinumerik);
    let run = |text: &str| replay::run(text, &control);
    let events = run(&text).unwrap();
    // the convex R5 by its centre: from the face at Ø12 its centre lies 5 towards the chuck
    let arc = text.lines().find(|l| l.ends_with(" CR=5")).unwrap();
    let by_centre = text.replace(arc, &arc.replace(" CR=5", " I=0 K=-5"));
    let again = run(&by_centre).unwrap();
    assert_eq!(events.len(), again.len(), "{arc}");
    let fault = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}: {text}");
        run(&text.replacen(from, to, 1)).unwrap_err().1
    };
    assert!(fault(" CR=5", " I=0 K=-4").contains("from its centre"), "{}", fault(" CR=5", " I=0 K=-4"));
    assert!(fault(" CR=5", "").contains("an arc needs"));
    assert!(fault("G451 NORM\n", "").contains("before NORM and G451"));
    assert!(fault("$TC_DP6[1,1]", "$TC_DP6[2,1]").contains("tool 1"));
    assert!(fault("$TC_DP6[1,1]", "$TC_DP7[1,1]").contains("not understood"));
    // written after the call it would act from the next one on
    let late = text.replace("$TC_DP6[1,1]=0.4\n", "").replace("T1 D1\n", "T1 D1\n$TC_DP6[1,1]=0.4\n");
    assert!(run(&late).unwrap_err().1.contains("after its tool was called"));
    // a larger radius goes another way
    let wider = run(&text.replace("$TC_DP6[1,1]=0.4", "$TC_DP6[1,1]=0.5")).unwrap();
    assert_ne!(events, wider);
}

/// The value behind a word of a program's head.
fn stated(text: &str, word: &str) -> f64 {
    let line = text.lines().find(|l| l.starts_with("(TOOL PAGE, SET BY HAND:")).expect("the tool page");
    let from = line.find(word).unwrap_or_else(|| panic!("{word}: {line}")) + word.len();
    let value: String = line[from..].chars().take_while(|c| c.is_ascii_digit() || *c == '.').collect();
    value.parse().unwrap()
}

#[test]
fn a_gsk_takes_radius_and_tip_from_its_tool_page_and_drives_the_blocks_of_a_fanuc() {
    let (part, settings, nose) = (part(), machine(), papers());
    let c = compensator(&part, &nose, 0.4);
    let done = c.carry_out(Way::BestRegister).unwrap();
    let write = |dialect| written(&c, &done, dialect, &settings).unwrap();
    let (gsk, fanuc) = (write(Dialect::Gsk), write(Dialect::Fanuc));
    let text = &gsk.text;
    let away = difference_um(&c, &done, &gsk.moves);
    assert!(away < 1.5, "{away}\n{text}");
    // from the tool call on, tangents and all
    let cut = |text: &str| text[text.find("T0101").unwrap()..].to_owned();
    assert_eq!(cut(text), cut(&fanuc.text));
    for absent in ["G10", "G70", "G71"] {
        assert!(!text.contains(absent), "{absent}: {text}");
    }
    assert!(text.contains("(NOT VERIFIED ON A CONTROL"), "{text}");
    // what the head states, and nothing else, makes the moves
    let tip = TipDirection::of(stated(text, " T ") as u8, Numbering::Fanuc).unwrap();
    let page = NoseRegister { radius_mm: stated(text, " R "), tip };
    assert_eq!(tip, c.setting.tip);
    let run = |text: &str, page: Option<NoseRegister>| {
        replay::run(text, &Control { tool_page: page, ..control(&settings, Dialect::Gsk) })
    };
    let driven = |r: Option<NoseRegister>| {
        let at = |p: Point| DVec2::new(0.5 * p.x, p.z);
        let events = run(text, r).unwrap();
        let feed = |deed: &Deed| match deed {
            Deed::Move { from, to, rapid: false } => Some((at(*from), at(*to))),
            _ => None,
        };
        events.iter().filter_map(|e| feed(&e.deed)).collect::<Vec<_>>()
    };
    assert_eq!(driven(Some(page)), gsk.moves);
    let wider = NoseRegister { radius_mm: page.radius_mm + 0.1, ..page };
    assert_ne!(driven(Some(wider)), gsk.moves);
    let fault = |text: &str, page| run(text, page).unwrap_err().1;
    assert!(fault(text, None).contains("neither written nor stated"), "{}", fault(text, None));
    let wrote = text.replace("T0101", "G10 P10001 R0.4 Q3\nT0101");
    assert!(fault(&wrote, Some(page)).contains("G10 with R is a Fanuc's"));
    // the manual: compensation starts in G00 or G01
    let arc = text.replacen("G42 ", "G42 G02 R50. ", 1);
    assert!(fault(&arc, Some(page)).contains("starts on an arc"), "{}", fault(&arc, Some(page)));
}

#[test]
fn linuxcnc_drives_the_same_path() {
    let (part, settings) = (part(), machine());
    for nose in &noses() {
        let c = compensator(&part, nose, 0.4);
        for way in Way::ALL {
            let done = c.carry_out(way).unwrap();
            let written = written(&c, &done, Dialect::Linuxcnc, &settings).unwrap();
            let Some((_, printed)) = interpret(&written.text) else { return };
            let moves = canonical(&printed);
            assert!(moves.len() > 20, "{printed}\n{}", written.text);
            let away = difference_um(&c, &done, &moves);
            println!("rs274 {}: {away:.4} µm", way.as_str());
            assert!(away < 0.1, "{}: {away}\n{printed}\n{}", way.as_str(), written.text);
        }
    }
}

#[test]
fn blocks_that_a_control_would_stop_at_are_refused() {
    let (part, settings, nose) = (part(), machine(), round(0.4));
    let c = compensator(&part, &nose, 0.4);
    let text = written(&c, &c.carry_out(Way::Register).unwrap(), Dialect::Linuxcnc, &settings).unwrap().text;
    let control = control(&settings, Dialect::Linuxcnc);
    let fault = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}: {text}");
        replay::run(&text.replacen(from, to, 1), &control).unwrap_err().1
    };
    assert!(replay::run(&text, &control).is_ok());
    assert!(fault("G40 G01 X34.", "G01 X34.").contains("a rapid while the nose is compensated"));
    assert!(fault(" R5.", "").contains("an arc needs R"));
    assert!(fault(" R5.", " R3.").contains("no arc of R 3 joins"));
    assert!(fault(" L2", "").contains("need D, the diameter, and L"));
    assert!(fault("D0.8", "D9.").contains("does not fit into the contour"));
    assert!(fault("G42.1 D0.8 L2", "G42").contains("not understood"));
}

#[test]
fn a_left_hand_tool_is_driven_towards_the_tailstock() {
    let tool = ToolGeometry {
        tip: TipDirection { x: -1, z: 1 },
        feed: Feed::TowardsTailstock,
        ..super::parts::geometry()
    };
    let values: Vec<Support> = (-93..=27)
        .map(|k| f64::from(k).to_radians())
        .map(|a| Support { a_rad: a, h_mm: papers_support(-a), u_mm: 5e-5 })
        .collect();
    let nose = NoseProfile::new(&values, None, 0.0).unwrap();
    // cylinder, a cone of 24° that falls towards the tailstock, cylinder, a fillet up to a collar
    let run = 2.0 / 24f64.to_radians().tan();
    let corners = [
        corner(20.0, 30.0, 0.0),
        corner(28.0, 30.0, 0.0),
        corner(28.0 + run, 26.0, 0.0),
        corner(40.0, 26.0, 1.5),
        corner(40.0, 32.0, 0.0),
        corner(45.0, 32.0, 0.0),
    ];
    let part = Outline::from_corners(&corners, Side::External).unwrap();
    let setting = Setting::new(&nose, &tool, &Stated::default()).unwrap();
    let c = Compensator {
        outline: &part,
        setting,
        register_mm: 0.4,
        register_range_mm: (0.001, 9.999),
        increment_mm: 1e-4,
    };
    c.check(&tool).unwrap();
    for way in Way::ALL {
        let done = c.carry_out(way).unwrap();
        let written = written(&c, &done, Dialect::Linuxcnc, &machine()).unwrap();
        assert_eq!(written.text.contains("G41.1 D"), way != Way::Path, "{}", written.text);
        let away = difference_um(&c, &done, &written.moves);
        println!("towards the tailstock, {}: {away:.4} µm", way.as_str());
        assert!(away < 0.1, "{}: {away}\n{}", way.as_str(), written.text);
        let Some((_, printed)) = interpret(&written.text) else { continue };
        let away = difference_um(&c, &done, &canonical(&printed));
        println!("rs274, towards the tailstock, {}: {away:.4} µm", way.as_str());
        assert!(away < 0.1, "{}: {away}\n{printed}\n{}", way.as_str(), written.text);
    }
}
