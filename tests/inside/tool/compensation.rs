//! e(a), sizes and ways: closed forms, the paper's cases, the design's figures, refusals.

use std::f64::consts::FRAC_PI_4;

use glam::DVec2;

use super::parts::*;
use crate::nose::{NoseProfile, Numbering, Support, TipDirection};
use crate::outline::{Outline, Side};
use crate::tool::*;

fn left_of(compensator: &Compensator<'_>, way: Way) -> (Vec<Remainder>, f64) {
    let tool = Tool::new(compensator.setting.nose);
    let (done, left) = measured(compensator, &tool, way).unwrap();
    (left, done.register_mm)
}

fn largest_um(compensator: &Compensator<'_>, way: Way) -> f64 {
    1e3 * largest(&left_of(compensator, way).0).unwrap().left_mm
}

#[test]
fn a_round_nose_leaves_what_the_closed_form_gives() {
    let shaft = shaft();
    let nose = round(0.3743);
    let c = compensator(&shaft, &nose, 0.4);
    for k in -27..=90 {
        let a = f64::from(k).to_radians();
        let e = (0.4 - 0.3743) * (1.0 - a.cos() - a.sin());
        assert!((c.setting.left_mm(a, 0.4) - e).abs() < 1e-12);
        // without compensation the control drives the gauge point along the contour
        let bare = 0.3743 * (a.cos() + a.sin() - 1.0);
        assert!((c.setting.left_mm(a, 0.0) - bare).abs() < 1e-12);
    }
    let sharp = round(0.4);
    let bare = compensator(&shaft, &sharp, 0.4).setting.left_mm(FRAC_PI_4, 0.0);
    assert!((bare - 0.165_685).abs() < 1e-6, "{bare}");
}

#[test]
fn the_paper_s_cases_are_special_ones() {
    let nose = round(0.3743);
    let (r0, r1) = (0.4, 0.3865);
    let set = |h: f64| Stated { x_mm: Some(h), z_mm: Some(h), u_mm: 0.0 };
    let single = Setting::new(&nose, &geometry(), &set(r1)).unwrap();
    let batch = Setting::new(&nose, &geometry(), &set(r0)).unwrap();
    for k in -27..=90 {
        let a = f64::from(k).to_radians();
        assert!((single.left_mm(a, r1) - 0.0122).abs() < 1e-12);
        assert!((batch.left_mm(a, r0) - (r0 - 0.3743)).abs() < 1e-12);
        let kept = (r0 - 0.3743) - (r0 - r1) * (a.cos() + a.sin());
        assert!((single.left_mm(a, r0) - kept).abs() < 1e-12);
    }
    // part 1: dz = d/sin θ = .03 at 23.996°; with .4 kept at 24°: e = .00788, dz = .01936
    assert!((single.left_mm(23.996f64.to_radians(), r1) / 23.996f64.to_radians().sin() - 0.03).abs() < 1e-6);
    let kept = single.left_mm(24f64.to_radians(), r0);
    assert!((kept - 0.007_88).abs() < 5e-6 && (kept / 24f64.to_radians().sin() - 0.019_36).abs() < 1e-5);
}

#[test]
fn every_tip_direction_leaves_the_same_of_the_mirrored_part() {
    let nose = papers();
    for (side, feed) in TURNED {
        let flip = |a: f64| flipped(side, feed, a);
        let seen = carried(&nose, side, feed);
        let tool = tool(side, feed, full_tip(side, feed));
        let (low, high) = tool.range_rad();
        let (from, to) = (flip((-27f64).to_radians()), flip(93f64.to_radians()));
        assert!(
            (low - from.min(to)).abs() < 1e-9 && (high - from.max(to)).abs() < 1e-9,
            "{side:?} {feed:?}: {low} {high}"
        );
        let here = Setting::new(&seen, &tool, &Stated::default()).unwrap();
        let there = Setting::new(&nose, &geometry(), &Stated::default()).unwrap();
        for k in -26..=92 {
            let a = f64::from(k).to_radians();
            let (one, other) = (here.left_mm(flip(a), 0.4), there.left_mm(a, 0.4));
            assert!((one - other).abs() < 1e-8, "{side:?} {feed:?} {k}: {one} {other}");
        }
    }
    // a centre as the gauge point: nothing of R but the circle's own
    let centre = crate::nose::ToolGeometry { tip: TipDirection { x: 0, z: 0 }, ..geometry() };
    let setting = Setting::new(&nose, &centre, &Stated::default()).unwrap();
    assert!((setting.left_mm(FRAC_PI_4, 0.4) - (0.4 - 0.3743)).abs() < 1e-9);
}

#[test]
fn tip_numbers_are_those_of_the_controls() {
    // the corner towards axis and chuck is 3 on a Fanuc with a rear turret and 2 in LinuxCNC
    let corner = TipDirection { x: -1, z: -1 };
    assert_eq!((corner.number(Numbering::Fanuc), corner.number(Numbering::Linuxcnc)), (3, 2));
    for numbering in [Numbering::Fanuc, Numbering::Linuxcnc] {
        for number in 0..9 {
            assert_eq!(TipDirection::of(number, numbering).unwrap().number(numbering), number);
        }
        assert_eq!(TipDirection::of(9, numbering), TipDirection::of(0, numbering));
        assert_eq!(TipDirection::of(10, numbering), None);
    }
}

#[test]
fn uncertainty_follows_from_the_values_that_enter() {
    let values: Vec<Support> =
        (-27..=93).map(|k| Support { a_rad: f64::from(k).to_radians(), h_mm: 0.4, u_mm: 1e-4 }).collect();
    let own = NoseProfile::new(&values, None, 0.0).unwrap();
    let setting = Setting::new(&own, &geometry(), &Stated::default()).unwrap();
    for k in [-20, 24, 45, 70] {
        let a = f64::from(k).to_radians();
        let u = 1e-4 * (1.0 + a.cos().powi(2) + a.sin().powi(2)).sqrt();
        assert!((setting.u_left_mm(a) - u).abs() < 1e-12, "{k}");
    }
    // where X was touched, nothing is left, whatever h
    assert!(setting.u_left_mm(0.0) < 1e-12 && setting.u_left_mm(std::f64::consts::FRAC_PI_2) < 1e-12);
    let exact: Vec<Support> = values.iter().map(|s| Support { u_mm: 0.0, ..*s }).collect();
    let biased = NoseProfile::new(&exact, None, 1e-3).unwrap();
    let setting = Setting::new(&biased, &geometry(), &Stated::default()).unwrap();
    for k in [-20, 24, 45, 70] {
        let a = f64::from(k).to_radians();
        let u = 1e-3 * (a.cos() + a.sin() - 1.0).abs();
        assert!((setting.u_left_mm(a) - u).abs() < 1e-7, "{k}: {} {u}", setting.u_left_mm(a));
    }
}

#[test]
fn ways_leave_what_the_design_states() {
    let shaft = shaft();
    let papers = papers();
    let flat = nose(0.25, flat_support);
    // the register as it is; nose of the paper, flat of .217 mm
    let um = |nose, register, way| largest_um(&compensator(&shaft, nose, register), way);
    assert!((um(&papers, 0.4, Way::Register) - 6.608).abs() < 0.01);
    assert!((um(&papers, 0.3865, Way::Register) - 12.2).abs() < 0.01);
    assert!((um(&flat, 0.4, Way::Register) - 15.0).abs() < 0.1);
    let worn = round(0.38);
    for nose in [&papers, &worn] {
        for way in [Way::EditedContour, Way::Path] {
            let left = um(nose, 0.4, way);
            println!("{}: {left:.4} µm", way.as_str());
            assert!(left.abs() < 0.03, "{left}");
        }
    }
    // a flat w on a concave arc ρ: the trimmed path leaves w²/8ρ
    let left = um(&flat, 0.4, Way::Path);
    println!("flat on a concave arc, trimmed: {left:.4} µm");
    assert!((left - 1e3 * 0.217 * 0.217 / (8.0 * 4.0)).abs() < 0.05, "{left}");
}

#[test]
fn the_best_register_is_the_least_of_all() {
    let shaft = shaft();
    let nose = papers();
    let c = compensator(&shaft, &nose, 0.4);
    let largest = |r: f64| c.angles().iter().map(|a| c.setting.left_mm(*a, r).abs()).fold(0.0, f64::max);
    let best = c.setting.best_radius_mm(&c.angles(), 0.4, (0.001, 4.0));
    let least = (0..8000).map(|k| largest(0.35 + 1.25e-5 * f64::from(k))).fold(f64::INFINITY, f64::min);
    assert!((largest(best) - least).abs() < 6e-6, "{best}: {} {least}", largest(best));
    // on cylinders and faces alone R has no effect: it stays
    let c = c.setting.best_radius_mm(&[0.0, std::f64::consts::FRAC_PI_2], 0.4, (0.001, 4.0));
    assert!((c - 0.4).abs() < 1e-12);
}

#[test]
fn sizes_of_a_round_nose_have_closed_forms() {
    let shaft = shaft();
    let nose = round(0.38);
    let (left, _) = left_of(&compensator(&shaft, &nose, 0.4), Way::Register);
    let (pieces, corners) = changes(&shaft, &left);
    // e = Δ(1 − c − s) is a circle moved by (−Δ, −Δ) and larger by Δ, but for the second order of
    // the movement along the surface, Δ²/2ρ
    let delta = 20.0;
    let mut kinds = Vec::new();
    for p in &pieces {
        kinds.push(p.kind);
        match p.kind {
            Kind::Diameter => assert!(p.diameter_um.unwrap().abs() < 0.01),
            Kind::Face => assert!(p.z_um.unwrap().abs() < 0.01),
            Kind::Cone => {
                let a = 24f64.to_radians();
                let e = delta * (1.0 - a.cos() - a.sin());
                assert!((p.diameter_um.unwrap() - 2.0 * e / a.cos()).abs() < 0.01);
                assert!((p.z_um.unwrap() - e / a.sin()).abs() < 0.01);
            }
            Kind::ConvexArc | Kind::ConcaveArc => {
                let sign = if p.kind == Kind::ConvexArc { 1.0 } else { -1.0 };
                assert!((p.radius_um.unwrap() - sign * delta).abs() < 0.3, "{p:?}");
                let centre = p.centre_um.unwrap();
                assert!((centre[0] + delta).abs() < 0.3 && (centre[1] + delta).abs() < 0.3, "{p:?}");
                assert!(p.form_um.unwrap() < 0.1);
            }
        }
    }
    for kind in [Kind::Diameter, Kind::Face, Kind::Cone, Kind::ConvexArc, Kind::ConcaveArc] {
        assert!(kinds.contains(&kind), "{kind:?}");
    }
    // the cone meets cylinders that keep their size: its corners move along Z alone
    let a = 24f64.to_radians();
    let along = delta * (1.0 - a.cos() - a.sin()) / a.sin();
    let cone: Vec<_> = corners.iter().filter(|c| (c.z_um - along).abs() < 0.05).collect();
    assert!(cone.len() == 2 && cone.iter().all(|c| c.diameter_um.abs() < 0.05), "{corners:?}");
}

#[test]
fn what_the_tool_cannot_do_is_refused_with_its_place() {
    let nose = round(0.4);
    // a groove that falls towards the chuck at 35°, beyond κ_r' = 27°
    let run = 2.0 / 35f64.to_radians().tan();
    let corners = [
        corner(0.0, 30.0, 0.0),
        corner(10.0, 30.0, 0.0),
        corner(10.0 + run, 34.0, 0.0),
        corner(20.0, 34.0, 0.0),
    ];
    let groove = Outline::from_corners(&corners, Side::External).unwrap();
    let error = compensator(&groove, &nose, 0.4).check(&geometry()).unwrap_err().to_string();
    assert!(
        error.contains("Z 10.000") && error.contains("-35.000°") && error.contains("cannot be the tool's"),
        "{error}"
    );

    let corners =
        [corner(0.0, 40.0, 0.0), corner(10.0, 40.0, 0.0), corner(10.0, 30.0, 0.3), corner(20.0, 30.0, 0.0)];
    let fillet = Outline::from_corners(&corners, Side::External).unwrap();
    let c = compensator(&fillet, &nose, 0.4);
    let error = c.carry_out(Way::Register).unwrap_err().to_string();
    assert!(error.contains("gouges") && error.contains("0.3000 mm is smaller than the register"), "{error}");
    // the nose's own path leaves its fillet there and keeps off the part
    let (left, _) = left_of(&c, Way::Path);
    assert!(left.iter().all(|r| r.left_mm > -3e-5));
    let fillet_um = left.iter().map(|r| 1e3 * r.left_mm).fold(0.0, f64::max);
    assert!((fillet_um - 100.0 * (2f64.sqrt() - 1.0)).abs() < 1.0, "{fillet_um}");

    let too_large = Compensator { register_mm: 12.0, ..c };
    assert!(too_large.carry_out(Way::EditedContour).unwrap_err().to_string().contains("0.001 to 9.999"));

    let short: Vec<Support> =
        (0..=60).map(|k| Support { a_rad: f64::from(k).to_radians(), h_mm: 0.4, u_mm: 1e-5 }).collect();
    let short = NoseProfile::new(&short, None, 0.0).unwrap();
    let error = Setting::new(&short, &geometry(), &Stated::default()).unwrap_err().to_string();
    assert!(error.contains("setting.z_extent_mm") && error.contains("60.00°"), "{error}");
}

#[test]
fn a_groove_narrower_than_the_nose_is_left_partly_and_never_cut_into() {
    // shoulder, a bottom of .1 mm, a flank of 20° that falls towards the chuck
    let end = 5.1 + 2.0 / 20f64.to_radians().tan();
    let corners = [
        corner(0.0, 40.0, 0.0),
        corner(5.0, 40.0, 0.0),
        corner(5.0, 36.0, 0.0),
        corner(5.1, 36.0, 0.0),
        corner(end, 40.0, 0.0),
        corner(end + 10.0, 40.0, 0.0),
    ];
    let groove = Outline::from_corners(&corners, Side::External).unwrap();
    let nose = round(0.4);
    let c = compensator(&groove, &nose, 0.4);
    let (left, _) = left_of(&c, Way::Path);
    assert!(left.iter().all(|r| r.left_mm > -3e-5), "{left:?}");
    // the circle between shoulder and flank has its centre .4 from both, and
    // .4/cos 20° + (.4 − .1)·tan 20° above the bottom's line
    let t = 20f64.to_radians();
    let lowest = 0.4 / t.cos() + (0.4 - 0.1) * t.tan() - 0.4;
    let bottom: Vec<&Remainder> = left.iter().filter(|r| r.source == 2).collect();
    let at = bottom.last().unwrap();
    let away = 5.4 - at.at.y;
    let expected = lowest + 0.4 - (0.4f64 * 0.4 - away * away).sqrt();
    assert!((at.left_mm - expected).abs() < 1e-6, "{} {expected}", at.left_mm);
}

#[test]
fn a_bore_is_compensated_like_a_shaft() {
    let (papers, whole) = (papers(), shaft());
    for (side, feed) in TURNED {
        let (part, nose) = (turned(&shaft_corners(), (side, feed), 80.0), carried(&papers, side, feed));
        let tool = tool(side, feed, full_tip(side, feed));
        let setting = Setting::new(&nose, &tool, &Stated::default()).unwrap();
        let c = Compensator { outline: &part, setting, ..compensator(&whole, &papers, 0.4) };
        c.check(&tool).unwrap();
        for way in Way::ALL {
            let (here, register) = left_of(&c, way);
            let (there, wanted) = left_of(&compensator(&whole, &papers, 0.4), way);
            let most = |left: &[Remainder]| 1e3 * largest(left).unwrap().left_mm;
            println!("{side:?} {feed:?} {}: {:.4} µm", way.as_str(), most(&here));
            assert!((most(&here) - most(&there)).abs() < 0.01, "{side:?} {feed:?} {way:?}");
            assert!((register - wanted).abs() < 2e-4, "{register} {wanted}");
            let (mine, its) = (changes(&part, &here).0, changes(&whole, &there).0);
            let of = |pieces: &[PieceChange], kind: Kind| -> Vec<f64> {
                let mut of: Vec<f64> =
                    pieces.iter().filter(|p| p.kind == kind).filter_map(|p| p.diameter_um).collect();
                of.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
                of
            };
            // what is left makes a shaft larger and a bore smaller
            let sign = if side == Side::External { 1.0 } else { -1.0 };
            for kind in [Kind::Diameter, Kind::Cone] {
                for (one, other) in of(&mine, kind).iter().zip(of(&its, kind)) {
                    assert!(
                        (one - sign * other).abs() < 0.02,
                        "{side:?} {feed:?} {way:?} {kind:?}: {one} {other}"
                    );
                }
            }
        }
    }
}

#[test]
fn contact_is_what_a_direction_in_the_image_stands_for() {
    let geometry = geometry();
    let rows: Vec<String> = (-27..=93)
        .map(|k| {
            // the nose points down and left: a surface's normal a is touched in the direction a +
            // 180° turned into the image, +X up and +Z to the right
            let deg = 270.0 - f64::from(k);
            let away = DVec2::new(0.1, 0.05).dot(DVec2::from_angle(f64::from(k).to_radians()));
            format!("{{\"direction_deg\": {deg}, \"h_um\": {}, \"u_um\": 0.1}}", 400.0 + 1e3 * away)
        })
        .collect();
    let text = format!(
        "{{\"images\": [{{\"image\": \"n.png\", \"support\": [{}], \"other\": 1}}]}}",
        rows.join(",")
    );
    let axes = ImageAxes::default();
    let nose = read_nose(&text, None, axes, &geometry).unwrap();
    assert_eq!(nose.image, "n.png");
    for k in [-20, 0, 25, 80] {
        let n = DVec2::from_angle(f64::from(k).to_radians());
        let h = nose.profile.support_mm(f64::from(k).to_radians());
        assert!((h - 0.4 - DVec2::new(0.1, 0.05).dot(n)).abs() < 1e-9, "{k}: {h}");
    }
    let none = read_nose("{\"images\": []}", None, axes, &geometry).unwrap_err().to_string();
    assert!(none.contains("the file has none"), "{none}");
    let broken = read_nose("{\"frames\": []}", None, axes, &geometry).unwrap_err().to_string();
    assert!(broken.contains("missing field `images`"), "{broken}");
}
