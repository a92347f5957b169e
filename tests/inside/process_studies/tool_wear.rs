//! Reproduction of the paper on tool wear: every figure against values worked out from the paper by
//! hand, apart from the program.

use std::collections::HashSet;

use crate::studies::reproduce_004::{Inputs, Reproduction, run};
use crate::studies::reproduction::{Row, Verdict};

fn found() -> Reproduction {
    run(&Inputs::default()).unwrap()
}

fn row<'a>(rows: &'a [Row], id: &str) -> &'a Row {
    rows.iter().find(|row| row.id == id).unwrap_or_else(|| panic!("no row {id}"))
}

/// Figure, value by hand and half of its last digit.
const BY_HAND: [(&str, f64, f64); 107] = [
    // 79/48, 241/156, 429/190; (300 − 48)/1.644 854 and so on; acos(.429/.4295)
    ("flank.slight.ratio", 1.645_833, 5e-7),
    ("flank.uniform.ratio", 1.544_872, 5e-7),
    ("flank.non_uniform.ratio", 2.257_895, 5e-7),
    ("flank.slight.u", 0.153_205, 5e-7),
    ("flank.uniform.u", 0.087_546, 5e-7),
    ("flank.non_uniform.u", 0.066_875, 5e-7),
    ("flank.blunt", 0.0, 0.0),
    ("flank.classes", 3.0, 0.0),
    ("flank.direction", 2.764_925, 5e-6),
    ("flank.slight.class", 1.0, 0.0),
    ("flank.uniform.class", 2.0, 0.0),
    ("flank.non_uniform.class", 3.0, 0.0),
    ("flank.slight.blunt", 0.0, 0.0),
    ("flank.uniform.blunt", 0.0, 0.0),
    ("flank.non_uniform.blunt", 0.0, 0.0),
    ("flank.slight.sharp", 1.0, 0.0),
    ("flank.uniform.sharp", 1.0, 0.0),
    ("flank.non_uniform.sharp", 1.0, 0.0),
    ("flank.limit.vb", 0.3, 1e-12),
    ("flank.limit.vb_max", 0.6, 1e-12),
    // 48/2.415; 1/2.415
    ("flank.pixels", 19.875_776, 5e-7),
    ("flank.digit", 0.414_079, 5e-7),
    // 2.4/2.415; 3072 · 2.415; 2048 · 2.415
    ("nose.lens", 0.9938, 5e-5),
    ("nose.field.columns", 7.418_88, 5e-6),
    ("nose.field.rows", 4.945_92, 5e-6),
    // 450 − 500; 25⁴/12; π · .032 · 50; π · .032 · 4500; .008 − .004; .008 − .005
    ("table2.tailstock", -50.0, 1e-9),
    ("table2.shank", 32_552.083, 5e-4),
    ("table2.speed.least", 5.026_55, 5e-6),
    ("table2.speed.most", 452.389_3, 5e-5),
    ("table3.x", 0.004, 1e-12),
    ("table3.z", 0.003, 1e-12),
    ("table2.swing", 200.0, 1e-9),
    // 2.4/2.415; .154 982 6 · 2.415; .005 590 1 · 2.415; .4 − .0135; .3865 − .3743
    ("nose.magnification", 0.9938, 5e-5),
    ("nose.r", 0.374_283, 5e-7),
    ("nose.gap", 0.013_500, 5e-7),
    ("nose.R1", 0.386_500, 5e-7),
    ("nose.d", 0.0122, 5e-9),
    ("nose.d.pixels", 0.012_217, 5e-7),
    ("nose.R0.pixels", 165.631_47, 5e-6),
    ("lsd.rho", 5.2263, 5e-5),
    ("eq10.inside", 1.0, 0.0),
    ("eq10.discarded", 3.0, 0.0),
    ("eq10.corner", 0.8, 1e-12),
    ("insert.range.low", -27.0, 1e-9),
    ("insert.range.high", 93.0, 1e-9),
    // sums .116, .029, .095, .018, .08, .05, .069, .021 over four
    ("part1.before", 0.029_00, 1e-9),
    ("part1.after", 0.007_25, 1e-9),
    ("part2.before", 0.023_75, 1e-9),
    ("part2.after", 0.004_50, 1e-9),
    ("part3.before", 0.020_00, 1e-9),
    ("part3.after", 0.012_50, 1e-9),
    ("part4.before", 0.017_25, 1e-9),
    ("part4.after", 0.005_25, 1e-9),
    ("part1.rate.raw", 75.00, 5e-3),
    ("part2.rate.raw", 81.05, 5e-3),
    ("part3.rate.raw", 37.50, 5e-3),
    ("part4.rate.raw", 69.57, 5e-3),
    ("part1.rate.means", 75.86, 5e-3),
    ("part2.rate.means", 79.17, 5e-3),
    ("part3.rate.means", 35.00, 5e-3),
    ("part4.rate.means", 70.59, 5e-3),
    ("part1.rate", 75.86, 5e-3),
    ("part2.rate", 79.17, 5e-3),
    ("part3.rate", 37.50, 5e-3),
    ("part4.rate", 69.57, 5e-3),
    ("rate.largest", 79.2, 1e-9),
    ("c01.part1.dz", 0.03, 1e-9),
    ("c01.part2.dz", 0.02, 1e-9),
    ("c01.part1.theta", 23.996, 5e-4),
    ("c01.part1.theta.least", 20.40, 5e-3),
    ("c01.part1.theta.most", 29.21, 5e-3),
    ("c01.part2.theta", 37.590, 5e-4),
    ("c01.part2.theta.least", 29.21, 5e-3),
    ("c01.part2.theta.most", 54.42, 5e-3),
    ("c02.part1", 0.0122, 5e-9),
    ("c02.part2", 0.0122, 5e-9),
    ("c03.least", 0.0244, 5e-5),
    // 2d/cos 29.21°: .0244/.872 84
    ("c03.rounding", 0.027_955, 5e-7),
    ("c03.theta", 0.0308, 5e-5),
    ("c04.e", 0.0122, 5e-9),
    ("c04.ratio", 1.230, 5e-4),
    ("c04.dx2", 0.008_627, 5e-7),
    ("c04.dz2", 0.008_627, 5e-7),
    ("c04.dx2.e", 0.010_607, 5e-7),
    ("c05.diameter", 0.032, 1e-9),
    ("c05.gap", 0.0135, 1e-9),
    ("c06.e", 0.007_88, 5e-6),
    ("c06.dz", 0.019_36, 5e-6),
    ("c07.radius", 0.029_45, 5e-6),
    ("c07.edit", -0.414, 5e-4),
    ("c07.left", 0.586, 5e-4),
    ("c08.parts", 2.0, 0.0),
    ("c08.part1", 75.00, 5e-3),
    ("c08.part2", 81.05, 5e-3),
    ("c09.exponent", 2.5, 0.0),
    ("c09.tests", 9.928e16, 5e12),
    ("c09.tests.printed", 524.2, 5e-2),
    ("c10.flank", 2.0, 0.0),
    ("c11.frameworks", 0.0, 0.0),
    ("c12.angle", 60.497, 5e-3),
    // .007 25/.005, .0045/.008, .0125/.01, .005 25/.008
    ("c13.part1", 1.45, 1e-9),
    ("c13.part2", 0.5625, 1e-9),
    ("c13.part3", 1.25, 1e-9),
    ("c13.part4", 0.656_25, 1e-9),
    ("model.bare", 0.165_685, 5e-7),
    // .4(1 − √2) + .3865·√2 − .3743; sectors of 1° round the support by a nanometre
    ("model.R0.45", 0.006_608, 1e-6),
    ("model.R1.45", 0.0122, 1e-6),
];

#[test]
fn every_figure_is_the_one_worked_out_by_hand() {
    let rows = found().rows;
    for (id, by_hand, half_digit) in BY_HAND {
        let ours = row(&rows, id).ours;
        assert!((ours - by_hand).abs() <= half_digit, "{id}: {ours} beside {by_hand}");
    }
    for id in ["eq6.whole", "eq10.distance", "model.single", "model.kept", "model.batch"] {
        assert_eq!(row(&rows, id).verdict, Verdict::Consistent, "{id}");
    }
}

#[test]
fn rows_have_names_numbers_reasons_and_no_miss() {
    let rows = found().rows;
    let ids: HashSet<&str> = rows.iter().map(|row| row.id.as_str()).collect();
    assert_eq!(ids.len(), rows.len(), "an id stands twice");
    for row in &rows {
        assert!(row.ours.is_finite() && !row.reason.is_empty() && !row.quantity.is_empty(), "{row:?}");
        assert!(!row.is_unexplained_miss(), "{row:?}");
    }
    for number in 1..=13 {
        assert!(ids.iter().any(|id| id.starts_with(&format!("c{number:02}."))), "contradiction {number}");
    }
}

/// Every figure that the paper prints of flanks, nose, lathe and workpieces, and the row that it is
/// in, as the paper's figure or as what ours is computed from: a row that is dropped is missed
/// here.
#[test]
fn every_figure_of_the_paper_has_a_row() {
    let rows = found().rows;
    for (figure, id) in FIGURES {
        let row = row(&rows, id);
        assert!(!row.reason.is_empty(), "{figure}: {id}");
        if let Some(paper) = row.paper.filter(|_| figure.parse::<f64>().is_ok()) {
            assert!((paper - figure.parse::<f64>().unwrap()).abs() < 1e-9, "{figure}: {id} has {paper}");
        }
    }
    // the same land twice as wide is blunt by the paper's rule, and no longer sharp by ours
    let mut inputs = Inputs::default();
    inputs.lands[1].vb_mm *= 2.0;
    inputs.lands[2].vb_max_mm *= 2.0;
    let worn = run(&inputs).unwrap().rows;
    for name in ["uniform", "non_uniform"] {
        assert_eq!(row(&worn, &format!("flank.{name}.blunt")).verdict, Verdict::Contradiction, "{name}");
        assert_eq!(row(&worn, &format!("flank.{name}.sharp")).ours, 0.0, "{name}");
    }
}

/// Figures and ids: Table 1, section 2, Tables 2 to 4, section 3.
const FIGURES: [(&str, &str); 75] = [
    ("VB .048, VBmax .079", "flank.slight.ratio"),
    ("VB .156, VBmax .241", "flank.uniform.ratio"),
    ("VB .190, VBmax .429", "flank.non_uniform.ratio"),
    ("slight", "flank.slight.class"),
    ("uniform", "flank.uniform.class"),
    ("not uniform", "flank.non_uniform.class"),
    ("not blunt, slight", "flank.slight.blunt"),
    ("not blunt, uniform", "flank.uniform.blunt"),
    ("not blunt, not uniform", "flank.non_uniform.blunt"),
    ("0.3", "flank.limit.vb"),
    ("0.6", "flank.limit.vb_max"),
    ("none of Table 1 is blunt", "flank.blunt"),
    ("two ways to measure a flank", "c10.flank"),
    ("S 2.415 µm/px", "nose.magnification"),
    ("MVL-HT-1-110, MVL-HT-07-110", "nose.lens"),
    ("MV-CE060-10UC", "nose.field.columns"),
    ("MV-CE060-10UC", "nose.field.rows"),
    ("154.9826 px", "nose.r"),
    ("0.3743", "nose.r"),
    ("5.5901 px", "nose.gap"),
    ("0.0135", "nose.gap"),
    ("0.3865", "nose.R1"),
    ("d .0122", "nose.d"),
    ("q 2, τ 22.5°", "lsd.rho"),
    ("γ 2", "eq7.aligned"),
    ("eq. 6", "eq6.whole"),
    ("exponent 2/5", "c09.exponent"),
    ("one of four solutions", "eq10.inside"),
    ("the others", "eq10.discarded"),
    ("TNMG160404TSBB60: R0 .4", "insert.R0"),
    ("60", "insert.epsilon_r"),
    ("κ_r 93°", "insert.range.high"),
    ("swing 560", "table2.swing"),
    ("cutting Ø360", "table2.x"),
    ("cutting length 500, Z 560", "table2.z"),
    ("bore 65", "table2.bore"),
    ("bar 50, Ø32 of 6061-T6", "table2.bar"),
    ("X 200", "table2.x"),
    ("Ø30", "table2.depth"),
    ("tailstock 450", "table2.tailstock"),
    ("shank 25 × 25", "table2.shank"),
    ("50/min", "table2.speed.least"),
    ("4500/min", "table2.speed.most"),
    ("positioning .008, repeatability .004", "table3.x"),
    ("positioning .008, repeatability .005", "table3.z"),
    ("0.029", "part1.before"),
    ("0.007", "part1.after"),
    ("0.024", "part2.before"),
    ("0.005", "part2.after"),
    ("0.02", "part3.before"),
    ("0.013", "part3.after"),
    ("0.017", "part4.before"),
    ("0.005", "part4.after"),
    ("75.8", "part1.rate"),
    ("79.2", "part2.rate"),
    ("37.5", "part3.rate"),
    ("69.6", "part4.rate"),
    ("79.2", "rate.largest"),
    ("0.03", "c01.part1.dz"),
    ("0.02", "c01.part2.dz"),
    ("dz = d sin θ", "c02.part1"),
    ("dz = d sin θ", "c02.part2"),
    ("part 2 by d", "c03.least"),
    ("0.015", "c04.e"),
    ("0.011", "c04.dx2"),
    ("0.011", "c04.dz2"),
    ("0.016", "c05.gap"),
    ("dx radial", "c05.diameter"),
    ("R1 in the control", "c06.dz"),
    ("radius + e", "c07.radius"),
    ("e·cos 45°, e·sin 45°", "c07.edit"),
    ("rates of rounded means", "c08.parts"),
    ("SpringBoot, ReactJS", "c11.frameworks"),
    ("60", "c12.angle"),
    ("what is left beside Table 3", "c13.part1"),
];

/// What the printed figures alone exclude, and what also needs data that the paper lacks.
#[test]
fn verdicts_follow_from_what_is_printed() {
    let rows = found().rows;
    let of = |verdict: Verdict| -> Vec<&str> {
        rows.iter().filter(|r| r.verdict == verdict).map(|r| r.id.as_str()).collect()
    };
    assert_eq!(
        of(Verdict::Contradiction),
        [
            "c02.part1",
            "c02.part2",
            "c04.e",
            "c04.dx2",
            "c04.dz2",
            "c05.diameter",
            "c07.radius",
            "c07.edit",
            "c08.parts",
            "c08.part1",
            "c08.part2",
            "c09.exponent",
            "c11.frameworks",
        ]
    );
    assert_eq!(
        of(Verdict::Undetermined),
        [
            "c01.part1.dz",
            "c01.part2.dz",
            "c03.theta",
            "c05.gap",
            "c06.dz",
            "c06.dz.R1",
            "c10.flank",
            "c12.angle",
            "model.part1",
            "model.part2",
            "model.part3",
            "model.part4",
        ]
    );
    // figures that agree are not contradicted: a reading, a mean or a rate of another size is
    let mut inputs = Inputs::default();
    inputs.parts[0].before_mm[0] += 0.01;
    inputs.parts[0].rate_percent = 70.0;
    inputs.radius_mm += 2e-4;
    let changed = run(&inputs).unwrap().rows;
    for id in ["part1.before", "part1.rate", "nose.r"] {
        assert_eq!(
            (row(&rows, id).verdict, row(&changed, id).verdict),
            (Verdict::Consistent, Verdict::Contradiction),
            "{id}"
        );
    }
}

#[test]
fn stated_cone_angles_decide_the_rows_that_need_them() {
    let with = |cone_deg: [f64; 2]| run(&Inputs { cone_deg: Some(cone_deg), ..Inputs::default() });
    let fitting = with([24.0, 37.6]).unwrap().rows;
    let others = with([45.0, 15.0]).unwrap().rows;
    for id in ["c01.part1.dz", "c01.part2.dz"] {
        assert_eq!(row(&fitting, id).verdict, Verdict::Consistent, "{id}");
        assert_eq!(row(&others, id).verdict, Verdict::Contradiction, "{id}");
    }
    // d/sin 45° = .0122·√2
    assert!((row(&others, "c01.part1.dz").ours - 0.017_253).abs() < 5e-7);
    // 2d/cos 15°
    assert!((row(&others, "c03.theta").ours - 0.025_261).abs() < 5e-7);
    for angle in [0.0, 90.0, f64::NAN, -24.0] {
        let refused = with([24.0, angle]).unwrap_err().to_string();
        assert!(
            refused.contains("--cone-deg") && refused.contains("part 2") && refused.contains("1 to 89"),
            "{refused}"
        );
    }
}

/// The ways on the paper's nose: limits of a trial, and curves that pass through the two supports
/// that the paper gives.
#[test]
fn the_ways_leave_what_a_trial_in_another_program_left() {
    let found = found();
    let left = |name: &str| row(&found.rows, &format!("model.left.{name}")).ours;
    assert!(
        (left("R0") - 6.6).abs() < 0.05 && (left("R1") - 12.2).abs() < 0.05,
        "{} {}",
        left("R0"),
        left("R1")
    );
    assert!(left("best") < 2.5 && left("edited") < 0.2 && left("path") < 0.03);
    let at = |curve: usize, deg: f64| {
        let points = &found.curves.e[curve].points;
        points.iter().find(|p| (p.0 - deg).abs() < 1e-6).unwrap().1
    };
    for (curve, at_0, at_45) in [(0, 0.0, 6.608), (1, 0.0, 12.2), (3, 13.5, 25.7), (4, 12.2, 12.2)] {
        assert!((at(curve, 0.0) - at_0).abs() < 1e-3 && (at(curve, 90.0) - at_0).abs() < 1e-3, "{curve}");
        assert!((at(curve, 45.0) - at_45).abs() < 1e-3, "{curve} {}", at(curve, 45.0));
    }
    // 29 sin 23.996°, 23.75/2 · cos 37.590°, 20, 17.25/2
    let before: Vec<f64> = found.curves.parts.iter().map(|p| p.before_um).collect();
    for (ours, by_hand) in before.iter().zip([11.793, 9.410, 20.0, 8.625]) {
        assert!((ours - by_hand).abs() < 1e-3, "{before:?}");
    }
}
