//! Reproduction of the slender-shaft paper: limits of every group of rows, and the dependence of
//! ours on the inputs.

use std::collections::HashSet;

use shadowgauge::studies::optimize::OptimizeConfig;
use shadowgauge::studies::reproduce_003::{Inputs, KNOWN_MISSES, Reproduction, run};
use shadowgauge::studies::reproduction::{Basis, Row, Verdict};

use crate::inside::process_studies::program::shadowgauge;

pub const INPUTS: &str = include_str!("../../../configs/reproduce_003.toml");
pub const PROBLEM: &str = include_str!("../../../configs/optimize_003.toml");

fn problem() -> OptimizeConfig {
    toml::from_str(PROBLEM).unwrap()
}

fn found_of(inputs: &str) -> Reproduction {
    run(&toml::from_str::<Inputs>(inputs).unwrap(), &problem(), None, &|| {}).unwrap()
}

fn rows_of(inputs: &str) -> Vec<Row> {
    found_of(inputs).rows
}

fn row<'a>(rows: &'a [Row], id: &str) -> &'a Row {
    rows.iter().find(|row| row.id == id).unwrap_or_else(|| panic!("no row {id}"))
}

#[test]
fn every_row_has_a_name_a_number_and_a_reason() {
    let rows = rows_of(INPUTS);
    let ids: HashSet<&str> = rows.iter().map(|row| row.id.as_str()).collect();
    assert_eq!(ids.len(), rows.len(), "an id stands twice");
    for row in &rows {
        assert!(row.ours.is_finite() && !row.reason.is_empty(), "{row:?}");
        assert_eq!(row.difference, row.paper.map(|p| row.ours - p), "{row:?}");
    }
    for equation in 1..=18 {
        let covered = ids.iter().any(|id| {
            id.starts_with(&format!("eq{equation}."))
                || *id == format!("eq{equation}")
                || (*id == "eq16-17" && (16..=17).contains(&equation))
        });
        assert!(covered || equation == 13, "equation {equation} has no row");
    }
    for table in ["table1", "table2"] {
        for number in 1..=8 {
            row(&rows, &format!("{table}.row{number}"));
        }
    }
}

/// The verdict of a row recomputed from its other fields alone.
pub fn verdict_again(row: &Row) -> &'static str {
    if row.missing.is_some() {
        return "undetermined";
    }
    let (Some(from), Some(to)) = (row.accepted_from, row.accepted_to) else { return "not_in_paper" };
    match (row.basis, (from..=to).contains(&row.ours)) {
        (Basis::Prediction, true) => "reproduced",
        (_, true) => "consistent",
        (Basis::Printed, false) => "contradiction",
        (_, false) => "not_reproduced",
    }
}

#[test]
fn every_verdict_follows_from_figure_ours_and_range() {
    let rows = rows_of(INPUTS);
    for row in &rows {
        let word = serde_json::to_value(row.verdict).unwrap();
        assert_eq!(word, verdict_again(row), "{row:?}");
        assert!(!row.is_unexplained_miss(), "{row:?}");
        // Figure and range are consistent.
        if let (Some(paper), Some(from), Some(to)) = (row.paper, row.accepted_from, row.accepted_to) {
            assert!(from <= paper && paper <= to, "{row:?}");
        }
    }
    // All six occur, and every known miss is one.
    for verdict in Verdict::ALL {
        assert!(rows.iter().any(|row| row.verdict == verdict), "{verdict:?}");
    }
    for miss in KNOWN_MISSES {
        assert_eq!(row(&rows, miss.id).verdict, Verdict::NotReproduced, "{miss:?}");
    }
}

/// Every reason of a known miss, against the rows that it names.
#[test]
fn known_misses_miss_for_the_reasons_given() {
    let rows = rows_of(INPUTS);
    let of = |id: &str| row(&rows, id);
    // Every row that a reason names in brackets is there.
    for miss in KNOWN_MISSES {
        assert!(miss.reason.contains('('), "{miss:?}");
        for named in miss.reason.split('(').skip(1).filter_map(|part| part.split(')').next()) {
            let exists = rows.iter().any(|row| row.id == named || row.id.starts_with(&format!("{named}.")));
            assert!(exists, "{} names {named}", miss.id);
        }
    }
    // Fig. 7's errors are those of the largest over z, which lies beyond 500 mm; a load fixed at
    // node 71 does not reach them anywhere.
    assert_eq!(of("fig7.compliance").verdict, Verdict::Reproduced);
    assert!(of("fig7.maximum").ours > 550.0);
    let most = of("fig7.node71.most").ours;
    assert!(most > of("fig7.node71").ours && most < of("fig7.node71").accepted_from.unwrap(), "{most}");
    // Table 1 over the handbook, and over Table 2.
    let table_1 = of("table1.handbook");
    assert!((table_1.paper.unwrap() / table_1.ours - 9.4).abs() < 0.1, "{table_1:?}");
    assert_eq!(of("table2.handbook").verdict, Verdict::Reproduced);
    let against = of("table2.against_table1");
    assert!((against.ours / against.paper.unwrap() - 9.14).abs() < 0.01, "{against:?}");
    // Fig. 8: its errors fall faster than its forces, in every row.
    for number in [3, 5, 7] {
        let linear = of(&format!("fig8.linear.row{number}"));
        assert!(linear.ours > linear.paper.unwrap(), "{linear:?}");
        assert_eq!(linear.verdict, Verdict::Contradiction);
    }
    // Growth: no length and no supports produce it, and copied errors level off.
    let (growth, most) = (of("fig11.physical.growth"), of("fig11.physical.growth.most"));
    assert!(most.ours >= growth.ours && most.ours < growth.accepted_from.unwrap(), "{most:?}");
    let none = |k: usize| of(&format!("fig11.physical.none.pass{k}")).ours;
    assert!(none(2) - none(1) > none(3) - none(2) && none(3) - none(2) > none(4) - none(3));
    // Offsets that replace each other: the gain is too large for them, and every other pass is
    // worse than the one before.
    assert!(of("fig11.physical.gain").ours > of("stability.absolute").ours);
    let absolute = |k: usize| of(&format!("fig11.physical.absolute.pass{k}")).ours;
    assert!(absolute(2) < absolute(1) && absolute(3) > 2.0 * absolute(2) && absolute(4) < absolute(3));
}

/// No verdict is hard-coded: outside the module that computes them their names do not occur.
#[test]
fn no_verdict_is_a_literal() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut folders = vec![root.join("src/studies"), root.join("src/cli")];
    let mut files = 0;
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()) {
            if entry.is_dir() {
                folders.push(entry);
            } else if !entry.ends_with("reproduction.rs") {
                let text = std::fs::read_to_string(&entry).unwrap();
                for name in [
                    "Reproduced",
                    "Consistent",
                    "Contradiction",
                    "Undetermined",
                    "NotReproduced",
                    "NotInPaper",
                ] {
                    assert!(!text.contains(&format!("Verdict::{name}")), "{}", entry.display());
                }
                files += 1;
            }
        }
    }
    assert!(files > 50, "{files}");
}

#[test]
fn the_figures_are_reproduced_within_their_limits() {
    let rows = rows_of(INPUTS);
    for number in [1, 3, 5, 7] {
        let seven = row(&rows, &format!("fig7.row{number}"));
        assert_eq!(seven.verdict, Verdict::Reproduced, "{seven:?}");
        let eight = row(&rows, &format!("fig8.row{number}"));
        let expected = if number == 7 { Verdict::NotReproduced } else { Verdict::Reproduced };
        assert_eq!(eight.verdict, expected, "{eight:?}");
    }
    // Known mismatch of 17 %: the paper's Fig. 8 is inconsistent with its own Table 2 under a
    // static model.
    let known = row(&rows, "fig8.row7");
    assert!((known.ours / known.paper.unwrap() - 1.17).abs() < 0.01, "{known:?}");
    assert!(known.known_miss.as_ref().is_some_and(|why| why.contains("fig8.linear")));
    let linear = row(&rows, "fig8.linear.row7");
    assert!((linear.ours - 3.7 * 7.95 / 11.09).abs() < 1e-12);
    assert_eq!(linear.verdict, Verdict::Contradiction);
    assert_eq!(row(&rows, "fig7.linear.row7").verdict, Verdict::Consistent);
    for feed in ["0.05", "0.15", "0.25", "0.35"] {
        assert_eq!(row(&rows, &format!("fig9.f{feed}")).verdict, Verdict::Consistent);
    }
    for number in [1, 2, 3, 5, 6, 7, 8] {
        assert_eq!(row(&rows, &format!("table1.row{number}")).verdict, Verdict::Consistent);
    }
    assert!((row(&rows, "table1.row4").ours - 0.22).abs() < 0.001);
    assert_eq!(row(&rows, "table1.row4").verdict, Verdict::Contradiction);
    assert!((row(&rows, "table2.row8").ours - 7.73).abs() < 0.05);
    assert!((row(&rows, "beam.E").ours / 2.1e11 - 1.0).abs() < 0.02);
    // Both tables against the handbook's force with the tool's angles: C = 1950 N times .50 (lead
    // 90°) times .85 (rake 15°) times .66·(.4/.5)^(ln(.82/.66)/ln 2) (nose .4 mm).
    let handbook = 1950.0 * 0.5 * 0.85 * 0.66 * 0.8_f64.powf((0.82_f64 / 0.66).ln() / 2.0_f64.ln());
    let force = |a: f64, v: f64| handbook * a.powf(0.901) * 0.1_f64.powf(0.6) * v.powf(-0.3);
    let two = row(&rows, "table2.handbook");
    assert!(
        (two.ours / force(0.2, 30.0) - 1.0).abs() < 1e-9 && two.verdict == Verdict::Reproduced,
        "{two:?}"
    );
    assert!((row(&rows, "table1.handbook").ours / force(0.1, 40.0) - 1.0).abs() < 1e-9);
}

#[test]
fn trends_and_the_fixed_load() {
    let found = found_of(INPUTS);
    for name in ["depth", "feed", "speed"] {
        assert_eq!(row(&found.rows, &format!("trend.{name}")).verdict, Verdict::Reproduced);
    }
    assert!((row(&found.rows, "trend.feed.elasticity").ours - 0.6).abs() < 1e-9);
    // A force that grows with the speed has the wrong trend.
    let wrong = rows_of(&INPUTS.replacen("force_n = 7.24", "force_n = 30.0", 1).replacen("7.73", "30.0", 1));
    assert_eq!(row(&wrong, "trend.speed").verdict, Verdict::NotReproduced);

    // Clamped at 0, supported at L, load at a: w(z) = [z²(3a - z)/6 - R z²(3L - z)/6]/EI for z < a,
    // R = a²(3L - a)/2L³, without shear.
    let fixed = &found.curves.fixed_load[0];
    let (length, a, inertia) =
        (1000.0_f64, 1000.0 * 70.0 / 99.0, std::f64::consts::PI * 50.0_f64.powi(4) / 64.0);
    let reaction = a * a * (3.0 * length - a) / (2.0 * length.powi(3));
    let z: f64 = 500.0;
    let bending = z * z * ((3.0 * a - z) - reaction * (3.0 * length - z)) / 6.0 / (2.1e5 * inertia);
    let ours = row(&found.rows, "fig7.node71").ours;
    // Shear adds about (d/L)² of the deflection.
    assert!((ours / (2e3 * bending) - 1.0).abs() < 0.02 && ours > 2e3 * bending, "{ours} {}", 2e3 * bending);
    let at = fixed.points.iter().min_by(|a, b| (a.0 - z).abs().total_cmp(&(b.0 - z).abs())).unwrap();
    assert!((at.1 / 49.84 / ours - 1.0).abs() < 0.01);
}

#[test]
fn curves_over_z_carry_the_printed_figures() {
    let found = found_of(INPUTS);
    let curves = &found.curves;
    for (figure, curves) in [("fig7", &curves.fig_7), ("fig8", &curves.fig_8)] {
        for (curve, number) in curves.iter().zip([1, 3, 5, 7]) {
            let largest = curve.points.iter().map(|p| p.1).fold(0.0, f64::max);
            let row = row(&found.rows, &format!("{figure}.row{number}"));
            assert!((largest / row.ours - 1.0).abs() < 1e-4, "{figure} {number}");
            assert_eq!(curve.printed, Some((500.0, row.paper.unwrap())));
        }
    }
    assert_eq!((curves.fig_9.len(), curves.fig_11_none.len(), curves.fig_11_pid.len()), (4, 4, 4));
    // Every pass without control stays large in the middle; the first error is the paper's, by
    // identification.
    assert_eq!(row(&found.rows, "fig11.shape.none").ours, 4.0);
    let first = &curves.fig_11_none[0];
    let at = first.points.iter().find(|p| p.0 == 250.0).unwrap();
    assert!((at.1 - 108.0).abs() < 1e-3 && first.printed == Some((250.0, 108.0)), "{at:?}");
    // The genetic algorithm never gets worse from one generation to the next.
    let generations = &curves.generations;
    assert_eq!((generations.len(), generations[0].evaluations), (250, 40));
    assert!(generations.windows(2).all(|w| w[1].violation < w[0].violation
        || (w[1].violation == w[0].violation && w[1].time_min <= w[0].time_min)));
    let end = generations.last().unwrap();
    assert!(end.violation == 0.0 && end.time_min >= curves.optimum_min.unwrap() * (1.0 - 1e-9));
    // π·1000·(40 - .5k)/(1000·.1·80), k = 1, 2, with .5 min once and tool wear of 1e-4.
    let two = std::f64::consts::PI * (39.5 + 39.0) / 8.0 + 0.5;
    assert!((curves.passes[1].total_min / two - 1.0).abs() < 1e-4, "{:?}", curves.passes[1]);
}

#[test]
fn figure_11_on_the_error_transfer_plant() {
    let rows = rows_of(INPUTS);
    let of = |name: &str, k: usize| row(&rows, &format!("fig11.{name}.pass{k}")).ours;
    // The recurrence by hand, apart from the controller's code.
    let (kp, ki, kd, alpha, gain) = (1.2, 0.05, 0.05, 1.3566, 0.704);
    let mut errors = vec![0.108];
    let mut sum = 0.0;
    for k in 0..8 {
        let e = errors[k];
        sum += e;
        let u = if k == 0 { kp * e } else { kp * e + ki * sum + kd * (e - errors[k - 1]) };
        errors.push(alpha * e - gain * u);
    }
    for k in 1..=4 {
        assert!((of("compensated", k) - errors[k - 1]).abs() <= 1e-12);
        assert!((of("uncompensated", k) - 0.108 * f64::powi(alpha, k as i32 - 1)).abs() <= 1e-12);
    }
    assert!(of("compensated", 4) <= 0.007);
    assert_eq!(row(&rows, "fig11.monotone").ours, 1.0);
    assert!((row(&rows, "fig11.pass9").ours + 0.0115).abs() < 2e-4, "{:?}", row(&rows, "fig11.pass9"));
    for (id, limit) in [
        ("stability.transfer.low", 0.2971),
        ("stability.transfer.high", 1.7786),
        ("stability.absolute", 0.7547),
        ("stability.accumulated", 1.5094),
    ] {
        assert!((row(&rows, id).ours - limit).abs() <= 1e-3, "{:?}", row(&rows, id));
    }
}

#[test]
fn the_physical_plant_grows_without_control_and_settles_with_it() {
    let rows = rows_of(INPUTS);
    let growth = row(&rows, "fig11.physical.growth");
    assert!(growth.ours > 1.1 && growth.ours < 1.6, "{growth:?}");
    let first = row(&rows, "fig11.physical.none.pass1");
    assert!((first.ours - 0.108).abs() < 1e-6, "{first:?}");
    assert_eq!(growth.verdict, Verdict::NotReproduced);
    let (absolute, accumulated) =
        (row(&rows, "fig11.physical.absolute.worst"), row(&rows, "fig11.physical.accumulated.worst"));
    assert!(accumulated.ours < 0.4 && accumulated.verdict == Verdict::Reproduced, "{accumulated:?}");
    assert!(absolute.ours > 2.0 * accumulated.ours, "{absolute:?}");
    assert!(row(&rows, "eq18.restored").ours > 0.05);
}

#[test]
fn the_optimum_and_the_genetic_algorithm() {
    let rows = rows_of(INPUTS);
    assert!((row(&rows, "eq10.t").ours - 15.7616).abs() < 2e-3);
    assert!(row(&rows, "ga.median").ours <= 0.05 && row(&rows, "ga.worst").ours <= 0.2);
    assert!((row(&rows, "eq5").ours - 15.512).abs() < 1e-3);
    // Without tool change, auxiliary time and number of passes nothing contradicts the printed 24
    // min.
    assert_eq!(row(&rows, "eq4").verdict, Verdict::Undetermined);
    let given = "seeds = 20\ntool_change_min = 1.0\nauxiliary_min = 0.5\npasses = 1";
    let given = rows_of(&INPUTS.replacen("seeds = 20", given, 1));
    assert_eq!(row(&given, "eq4").verdict, Verdict::NotReproduced);
    // Without the force law of equation 6 neither its size error nor dependent rows are judged;
    // with Table 2's they are.
    for id in ["eq6", "eq9", "eq10.ap"] {
        assert_eq!(row(&rows, id).verdict, Verdict::Undetermined, "{id}");
    }
    let with_law = rows_of(&INPUTS.replacen("seeds = 20", "seeds = 2\nforce_coefficient_n = 521.2", 1));
    assert_eq!(row(&with_law, "eq9").verdict, Verdict::Reproduced);
    assert_eq!(row(&with_law, "eq10.ap").verdict, Verdict::NotReproduced);
    assert!(row(&rows, "eq10.table1").reason.contains("infeasible"));
    // The depth of the optimum lies outside Table 2's own range, and the note states that.
    let study = shadowgauge::studies::optimize::Problem::new(&problem()).unwrap();
    let notes = study.notes(&shadowgauge::studies::optimize::Point {
        speed_m_per_min: 80.0,
        feed_mm_per_rev: 0.1,
        depth_mm: 0.33792,
    });
    assert!(notes.len() == 1 && notes[0].contains("depth"), "{notes:?}");
}

#[test]
fn ours_follows_the_inputs() {
    let plain = rows_of(INPUTS);
    let changed = |from: &str, to: &str| {
        assert!(INPUTS.contains(from), "{from}");
        rows_of(&INPUTS.replacen(from, to, 1))
    };
    let moved = |rows: &[Row], id: &str| (row(rows, id).ours / row(&plain, id).ours - 1.0).abs() > 1e-4;
    let stiffer = changed("youngs_modulus_n_per_mm2 = 2.1e5", "youngs_modulus_n_per_mm2 = 2.0e5");
    assert!(moved(&stiffer, "fig7.row1") && moved(&stiffer, "fig8.row1") && moved(&stiffer, "fig9.f0.05"));
    let heavier = changed("force_n = 165.74", "force_n = 185.74");
    assert!(moved(&heavier, "table1.exponent") && moved(&heavier, "fig9.f0.35"));
    let hotter = changed("kp = 1.2", "kp = 1.0");
    assert!(moved(&hotter, "fig11.compensated.pass2") && moved(&hotter, "stability.absolute"));
    assert!(moved(&hotter, "fig11.physical.accumulated.pass3"));
    let slower = changed("depth_mm = 0.25", "depth_mm = 0.3");
    assert!(moved(&slower, "eq5") && moved(&slower, "eq6"));
    // A changed figure of the paper that ours cannot meet is no longer reproduced.
    let off = changed("error_um = 15.4", "error_um = 18.0");
    assert_eq!(row(&off, "fig7.row1").verdict, Verdict::NotReproduced);
    assert!(row(&off, "fig7.row1").is_unexplained_miss());
    let mut shorter = problem();
    shorter.part.length_mm = 800.0;
    let rows = run(&toml::from_str(INPUTS).unwrap(), &shorter, None, &|| {}).unwrap().rows;
    assert!(moved(&rows, "eq10.t"));
}

#[test]
fn from_outside_the_binary() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("report");
    let output = shadowgauge(["reproduce", "003", "--no-frames", "--json", "--out", out.to_str().unwrap()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let rows: Vec<serde_json::Value> = serde_json::from_slice(&output.stdout).unwrap();
    assert!(rows.len() > 80, "{}", rows.len());
    for key in [
        "id",
        "quantity",
        "unit",
        "paper",
        "ours",
        "difference",
        "verdict",
        "reason",
        "basis",
        "accepted_from",
        "accepted_to",
        "missing",
        "known_miss",
    ] {
        assert!(rows[0].get(key).is_some(), "{key}");
    }
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.matches("<svg").count() >= 8, "{}", page.matches("<svg").count());
    for file in ["fig7_z", "fig8_z", "fig9_z", "fig11a_z", "fig11b_z", "fig11", "generations", "passes"] {
        assert!(out.join(format!("{file}.svg")).exists(), "{file}");
    }
    // A figure that is missed for no known reason: exit 1.
    let missed = folder.path().join("missed.toml");
    std::fs::write(&missed, INPUTS.replacen("error_um = 15.4", "error_um = 18.0", 1)).unwrap();
    let output = shadowgauge(["reproduce", "003", "--no-frames", "--inputs", missed.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
    let bad = folder.path().join("bad.toml");
    std::fs::write(&bad, INPUTS.replacen("force_n = 49.84", "force_n = -1.0", 1)).unwrap();
    let output = shadowgauge(["reproduce", "003", "--no-frames", "--inputs", bad.to_str().unwrap()]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("table_1[0].force_n"), "{text}");
}

/// The least-squares paper's experiment: both groups are turned, rendered and measured.
#[test]
fn two_groups_through_frames() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("report");
    let output =
        shadowgauge(["reproduce", "000", "--backend", "cpu", "--json", "--out", out.to_str().unwrap()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let rows: Vec<serde_json::Value> = serde_json::from_slice(&output.stdout).unwrap();
    let find = |id: &str| rows.iter().find(|row| row["id"] == id).unwrap_or_else(|| panic!("no row {id}"));
    let ours = |id: &str| find(id)["ours"].as_f64().unwrap();
    // The compensated group meets the target; the other retains the line's mean of about 49 µm.
    assert!((ours("experiment.frames.compensated") - 23.2).abs() < 0.004);
    assert!((ours("experiment.frames.contrast") - 23.2488).abs() < 0.004);
    assert!(ours("experiment.frames.reading") < 0.002);
    assert_eq!(find("experiment.frames.change")["verdict"], "consistent");
    // The paper's means lie 0.19 mm above the target for a reason that it does not state.
    assert_eq!(find("experiment.frames.contrast")["verdict"], "undetermined");
    assert!(out.join("fig2.svg").exists() && out.join("fig2_x.svg").exists());
    assert!(std::fs::read_to_string(out.join("report.html")).unwrap().matches("<svg").count() == 2);
}
