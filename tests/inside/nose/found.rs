//! What is measured on rendered noses, beside what is true of them.

use shadowgauge::gauge::nose::{BaselineNose, NoseSettings, Reference, measure_nose, wear};
use shadowgauge::render::insert::{InsertSettings, Wear, render_insert};
use shadowgauge::render::settings::{Esf, GaussianEsf};

use super::{at, insert, measured};

/// Kinds of wear in turn: none, round, flat, dented.
fn worn(pose: usize) -> InsertSettings {
    let mut s = insert(pose);
    let direction_deg = s.nose.direction_deg + 10.0;
    match pose % 4 {
        0 => {}
        1 => s.wear.push(Wear::Round { depth_um: 12.0 }),
        2 => s.wear.push(Wear::Flat { direction_deg, depth_um: 5.0 }),
        _ => s.wear.push(Wear::Dent { direction_deg, width_deg: 40.0, depth_um: 4.0 }),
    }
    s
}

#[test]
fn angle_centre_radius_and_sectors_are_within_their_uncertainty() {
    let (mut squares, mut n, mut inside, mut sectors) = ([0.0; 3], 0.0, 0, 0);
    for pose in 0..12 {
        let (found, truth) = measured(&worn(pose), 100 + pose as u64, true);
        let m = found.unwrap();
        let centre = [m.centre.x - truth.centre_px[0], -m.centre.y - truth.centre_px[1]];
        let off = [
            (m.angle_deg - truth.angle_deg) / m.u_angle_deg,
            centre[0].hypot(centre[1]) / (2f64.sqrt() * m.u_centre_px),
            (m.mean_radius_px - truth.mean_radius_px) / m.u_mean_radius_px,
        ];
        squares.iter_mut().zip(off).for_each(|(s, o)| *s += o * o);
        n += 1.0;
        assert!(m.u_angle_deg < 0.01 && m.u_centre_px < 0.03 && m.u_mean_radius_px < 0.03, "{m:?}");
        for s in &m.sectors {
            let error = (s.radius_px - at(&truth.radii, s.direction_deg)).abs();
            assert!(error < 0.2, "pose {pose}, {}°: {error}", s.direction_deg);
            inside += usize::from(error < 1.96 * s.u_px);
            sectors += 1;
        }
    }
    for square in squares {
        // mean squares of twelve standard deviates; the centre's u is that of its worst axis
        assert!((square / n).sqrt() < 1.75, "{squares:?}");
    }
    let share = inside as f64 / sectors as f64;
    // 1440 sectors: 95 % ± 0.6 %, correlated within a pose
    assert!((0.925..=0.975).contains(&share), "{share} of the sectors within 1.96 u");
}

#[test]
fn support_gives_what_a_control_leaves_to_a_tenth_of_a_micrometre() {
    let (mut square, mut n, mut worst) = (0.0, 0.0, 0.0_f64);
    for pose in 0..8 {
        let s = worn(pose);
        let (found, truth) = measured(&s, pose as u64, true);
        let m = found.unwrap();
        // e between two touches 90° apart does not depend on the tool point: errors of h less those
        // of the touches, as e weighs them
        let off: Vec<(f64, f64)> = m
            .support
            .iter()
            .map(|v| (v.direction_deg.to_radians(), v.h_px - at(&truth.support, v.direction_deg)))
            .collect();
        let (first, last) = (off.len() / 8, off.len() - 1 - off.len() / 8);
        let whole = off[last].0 - off[first].0;
        for v in &off[first..=last] {
            let (a, b) = ((off[last].0 - v.0).sin() / whole.sin(), (v.0 - off[first].0).sin() / whole.sin());
            let e_um = s.camera.um_per_px * (v.1 - a * off[first].1 - b * off[last].1);
            square += e_um * e_um;
            n += 1.0;
            worst = worst.max(e_um.abs());
        }
    }
    let rms = f64::sqrt(square / n);
    assert!(rms < 0.1 && worst < 0.5, "rms {rms} µm, worst {worst} µm");
}

#[test]
fn without_a_radius_a_new_nose_states_its_own_and_a_worn_one_that_of_iso_1832() {
    let (found, truth) = measured(&insert(1), 5, false);
    let m = found.unwrap();
    assert_eq!(m.reference, Reference::Fitted);
    assert!((m.nominal_radius_px - truth.nominal_radius_px).abs() < 0.05, "{}", m.nominal_radius_px);
    let mut s = insert(1);
    s.wear.push(Wear::Flat { direction_deg: s.nose.direction_deg, depth_um: 10.0 });
    let (found, truth) = measured(&s, 5, false);
    let m = found.unwrap();
    assert_eq!(m.reference, Reference::Iso1832);
    assert!((m.nominal_radius_px - truth.nominal_radius_px).abs() < 1e-9);
    assert!(m.flags.contains(&"worn") && m.flags.contains(&"radius_of_iso_1832"), "{:?}", m.flags);
}

#[test]
fn a_baseline_shows_what_is_missing() {
    let (found, truth) = measured(&insert(2), 1, false);
    let new = BaselineNose::from(&found.unwrap());
    let mut s = insert(2);
    s.wear.push(Wear::Round { depth_um: 12.0 });
    let (frame, worn) = render_insert(&s, (2, 0), true).unwrap();
    let known = NoseSettings {
        nominal_radius_px: Some(new.nominal_radius_px),
        um_per_px: s.camera.um_per_px,
        expected: None,
    };
    let m = measure_nose(&frame.view(), &known).unwrap();
    let lost = wear(&m, &new).unwrap();
    let right = truth.mean_radius_px - worn.mean_radius_px;
    assert!((lost.mean_px - right).abs() < 0.03, "{} {right}", lost.mean_px);
    assert!((lost.largest_px - 12.0 / 2.415).abs() < 0.1, "{}", lost.largest_px);
}

#[test]
fn wear_that_ends_in_a_step_at_an_edge_is_flagged_and_its_hull_begins_at_the_edge() {
    // the paper's scale: sectors of 2.9 px
    let mut s = InsertSettings::default();
    (s.camera.columns, s.camera.rows) = (900, 800);
    s.nose.direction_deg = 237.0;
    s.nose.centre_px = [370.0, 525.0];
    s.wear.push(Wear::Round { depth_um: 46.0 });
    // the first edge's normal points to 177°: the dent is cut off there, 5 px deep
    s.wear.push(Wear::Dent { direction_deg: 180.0, width_deg: 40.0, depth_um: 13.0 });
    let (found, truth) = measured(&s, 3, true);
    let m = found.unwrap();
    assert!(m.flags.contains(&"nose_end_worn"), "{:?}", m.flags);
    // the hull turns about the edge's first place: R·cos of the angle from its normal; half of the
    // step would be 2.7 px less
    for v in &m.support[1..4] {
        let right = truth.nominal_radius_px * (v.direction_deg - 177.0).to_radians().cos();
        assert!((v.h_px - right).abs() < 0.4, "{}°: {} {right}", v.direction_deg, v.h_px);
        assert!((at(&truth.support, v.direction_deg) - right).abs() < 5e-3, "{}°", v.direction_deg);
    }
    for depth_um in [23.0, 46.0] {
        let mut s = insert(0);
        s.wear.push(Wear::Round { depth_um });
        let (found, _) = measured(&s, 3, true);
        assert!(!found.unwrap().flags.contains(&"nose_end_worn"), "{depth_um}");
    }
}

#[test]
fn another_insert_is_no_baseline() {
    let (found, _) = measured(&insert(2), 1, false);
    let new = BaselineNose::from(&found.unwrap());
    let mut s = insert(2);
    s.nose.epsilon_deg = 60.3;
    let (found, _) = measured(&s, 1, true);
    let said = wear(&found.unwrap(), &new).unwrap_err().to_string();
    assert!(said.contains("another insert") && said.contains("60.3"), "{said}");
    let (found, _) = measured(&insert(3), 1, true);
    let said = wear(&found.unwrap(), &new).unwrap_err().to_string();
    assert!(said.contains("rotated by 67.3") && said.contains("baseline"), "{said}");
}

#[test]
fn chips_and_adhering_material_are_flagged() {
    type Kind = (fn(f64) -> Wear, &'static str);
    let kinds: [Kind; 2] = [
        (|direction_deg| Wear::Chip { direction_deg, width_deg: 15.0, depth_um: 12.0 }, "chipped"),
        (
            |direction_deg| Wear::BuiltUpEdge { direction_deg, width_deg: 20.0, height_um: 12.0 },
            "built_up_edge",
        ),
    ];
    for (kind, flag) in kinds {
        let mut s = insert(0);
        s.wear.push(kind(s.nose.direction_deg));
        let (found, _) = measured(&s, 4, true);
        let m = found.unwrap();
        assert!(m.flags.contains(&flag), "{flag}: {:?}", m.flags);
    }
    let (found, _) = measured(&insert(0), 4, true);
    assert_eq!(found.unwrap().flags, Vec::<&str>::new());
}

#[test]
fn the_blur_is_found_and_moves_nothing() {
    for sigma_px in [0.8, 1.6, 2.4] {
        let mut s = insert(1);
        s.esf = Esf::Gaussian(GaussianEsf { sigma_px });
        let (found, truth) = measured(&s, 8, true);
        let m = found.unwrap();
        assert!((m.sigma_px - sigma_px).abs() < 0.02, "{}", m.sigma_px);
        assert!(
            (m.mean_radius_px - truth.mean_radius_px).abs() < 4.0 * m.u_mean_radius_px,
            "{sigma_px}: {m:?}"
        );
    }
}

#[test]
fn corners_of_35_to_120_degrees_and_noses_of_a_twentieth_of_a_millimetre_are_measured() {
    for (epsilon_deg, radius_mm) in
        [(35.0, 0.2), (55.0, 0.2), (80.0, 0.2), (90.0, 0.2), (120.0, 0.2), (60.0, 0.1), (60.0, 0.05)]
    {
        let mut s = insert(0);
        (s.nose.epsilon_deg, s.nose.radius_mm) = (epsilon_deg, radius_mm);
        let (found, truth) = measured(&s, 7, true);
        let m = found.unwrap_or_else(|e| panic!("{epsilon_deg}°, {radius_mm} mm: {e}"));
        assert_eq!(m.flags, Vec::<&str>::new(), "{epsilon_deg}°, {radius_mm} mm");
        let off = (m.centre.x - truth.centre_px[0]).hypot(m.centre.y + truth.centre_px[1]);
        assert!(off < 4.0 * m.u_centre_px, "{epsilon_deg}°: {off} {}", m.u_centre_px);
        let off = (m.mean_radius_px - truth.mean_radius_px).abs();
        assert!(off < 4.0 * m.u_mean_radius_px, "{radius_mm} mm: {off} {}", m.u_mean_radius_px);
        // sectors hold pixels enough: of small noses they are wider than a degree
        let sectors =
            (180.0 - epsilon_deg).min((180.0 - epsilon_deg).to_radians() * 800.0 * radius_mm / 2.415);
        assert!((m.sectors.len() as f64 - sectors).abs() < 1.5, "{}", m.sectors.len());
    }
}
