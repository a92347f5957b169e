//! Constants of ours changed by 10 %: no contradiction of the paper may depend on one, and a figure
//! that leaves its range is a miss.

use std::collections::{HashMap, HashSet};

use shadowgauge::studies::reproduce_003::run;
use shadowgauge::studies::reproduction::{Row, Verdict};
use shadowgauge::studies::{reproduce_000, reproduction};

use super::reproduce::{INPUTS, PROBLEM, verdict_again};

/// Tables of configs/reproduce_003.toml and of configs/optimize_003.toml whose numbers are the
/// paper's. Every other number is ours.
const PRINTED: [&str; 23] = [
    "inputs.beam.length_mm",
    "inputs.beam.diameter_mm",
    "inputs.beam.youngs_modulus_printed_n_per_mm2",
    "inputs.beam.poisson_ratio",
    "inputs.beam.position_mm",
    "inputs.beam.nodes",
    "inputs.beam.loaded_node",
    "inputs.table_1[].depth_mm",
    "inputs.table_1[].force_n",
    "inputs.table_2[].speed_m_per_min",
    "inputs.table_2[].force_n",
    "inputs.figures.fig_7",
    "inputs.figures.fig_8",
    "inputs.figures.fig_9[]",
    "inputs.optimum",
    "inputs.pid.kp",
    "inputs.pid.ki",
    "inputs.pid.kd",
    "inputs.pid.uncompensated_mm",
    "inputs.pid.compensated_mm",
    "inputs.pid.position_mm",
    "inputs.plant.final_diameter_mm",
    // Section 3.3 and equation 7; n = 1 is a count.
    "problem.part",
];
const PRINTED_PROBLEM: [&str; 5] = [
    "problem.limits",
    "problem.quality",
    "problem.process.tool",
    // Rigid, as printed.
    "problem.process.support",
    // The range of Table 2.
    "problem.process.force.power.fitted",
];
/// Settings that choose a computation or a comparison, not constants of a model.
const SETTINGS: [&str; 4] =
    ["problem.front_points", "problem.genetic.seed", "problem.reference", "problem.genetic.evaluations"];

/// Paths of all numbers of a document, array indices as `[i]`.
fn numbers(path: &str, value: &toml::Value, found: &mut Vec<String>) {
    match value {
        toml::Value::Table(table) => {
            table.iter().for_each(|(key, value)| numbers(&format!("{path}.{key}"), value, found));
        }
        toml::Value::Array(values) => {
            values.iter().enumerate().for_each(|(i, value)| numbers(&format!("{path}[{i}]"), value, found));
        }
        toml::Value::Float(_) | toml::Value::Integer(_) => found.push(path.to_owned()),
        _ => {}
    }
}

/// A path without its indices.
fn plain(path: &str) -> String {
    let mut text = String::new();
    let mut inside = false;
    for c in path.chars() {
        inside = if c == '[' { true } else { inside && c != ']' };
        if !inside || c == '[' {
            text.push(c);
        }
    }
    text
}

fn scale(value: &mut toml::Value, path: &str, factor: f64) {
    let mut at = value;
    for step in path.split('.').skip(1) {
        let (key, rest) = step.split_once('[').unwrap_or((step, ""));
        at = at.get_mut(key).unwrap();
        for index in rest.split(['[', ']']).filter(|text| !text.is_empty()) {
            at = at.get_mut(index.parse::<usize>().unwrap()).unwrap();
        }
    }
    *at = match at {
        toml::Value::Float(v) => toml::Value::Float(*v * factor),
        toml::Value::Integer(v) => toml::Value::Integer((*v as f64 * factor).round() as i64),
        _ => panic!("{path} is no number"),
    };
}

/// The inputs with few evaluations of the genetic algorithm, which this test runs often.
fn quick() -> (toml::Value, toml::Value) {
    let inputs = INPUTS.replacen("seeds = 20", "seeds = 3", 1);
    let problem = PROBLEM.replacen("evaluations = 10000", "evaluations = 6000", 1);
    (toml::from_str(&inputs).unwrap(), toml::from_str(&problem).unwrap())
}

fn rows(inputs: &toml::Value, problem: &toml::Value) -> Vec<Row> {
    run(&inputs.clone().try_into().unwrap(), &problem.clone().try_into().unwrap(), None, &|| {}).unwrap().rows
}

#[test]
fn no_contradiction_hangs_on_a_constant_of_ours() {
    let (inputs, problem) = quick();
    let mut all = Vec::new();
    numbers("inputs", &inputs, &mut all);
    numbers("problem", &problem, &mut all);
    let printed: Vec<&str> = PRINTED.iter().chain(&PRINTED_PROBLEM).chain(&SETTINGS).copied().collect();
    // "inputs.optimum.seeds" is a setting below a table of the paper's.
    let theirs = |path: &str| {
        let path = plain(path);
        printed
            .iter()
            .any(|p| path == *p || path.strip_prefix(p).is_some_and(|rest| rest.starts_with(['.', '['])))
    };
    let ours: Vec<&String> = all.iter().filter(|path| !theirs(path)).collect();
    assert!(ours.len() >= 25, "{ours:?}");
    for table in &printed {
        assert!(all.iter().any(|path| plain(path).starts_with(table)), "{table} names nothing");
    }
    let before = rows(&inputs, &problem);
    let contradicted = |rows: &[Row]| -> HashMap<String, f64> {
        let odd = rows.iter().filter(|row| row.verdict == Verdict::Contradiction);
        odd.map(|row| (row.id.clone(), row.ours)).collect()
    };
    let expected = contradicted(&before);
    let mut missed = HashSet::new();
    for path in ours {
        let mut moved = 0;
        for factor in [0.9, 1.1] {
            let (mut inputs, mut problem) = (inputs.clone(), problem.clone());
            scale(if path.starts_with("inputs") { &mut inputs } else { &mut problem }, path, factor);
            let after = rows(&inputs, &problem);
            // The same contradictions, each by the same figure to the last bit.
            assert_eq!(contradicted(&after), expected, "{path} x {factor}");
            for row in &after {
                let was = before.iter().find(|other| other.id == row.id);
                let outside =
                    row.accepted_from.zip(row.accepted_to).is_some_and(|(a, b)| !(a..=b).contains(&row.ours));
                moved += usize::from(was.is_none_or(|was| was.ours.to_bits() != row.ours.to_bits()));
                assert_eq!(serde_json::to_value(row.verdict).unwrap(), verdict_again(row), "{path}: {row:?}");
                let judged = row.missing.is_none() && !expected.contains_key(&row.id);
                if outside && judged {
                    assert_eq!(row.verdict, Verdict::NotReproduced, "{path} x {factor}: {row:?}");
                    if was.is_some_and(|was| was.verdict != Verdict::NotReproduced) {
                        missed.insert(path.clone());
                    }
                }
            }
        }
        assert!(moved > 0, "{path} moves nothing");
    }
    // The test can fail: a change by 10 % of the constants that figures depend on directly does
    // move them out of their range.
    for path in [
        "inputs.beam.youngs_modulus_n_per_mm2",
        "inputs.handbook.feed_exponent",
        "inputs.pid.transfer_alpha",
        "inputs.table_1[3].meant_depth_mm",
        "inputs.figures.fig_9_depth_mm",
    ] {
        assert!(missed.contains(path), "{path}: {missed:?}");
    }
}

#[test]
fn no_contradiction_of_paper_000_hangs_on_a_constant_of_ours() {
    let plain = reproduce_000::Inputs::default();
    let before = reproduce_000::run(&plain).unwrap();
    let contradicted = |rows: &[reproduction::Row]| -> Vec<(String, u64)> {
        let odd = rows.iter().filter(|row| row.verdict == Verdict::Contradiction);
        odd.map(|row| (row.id.clone(), row.ours.to_bits())).collect()
    };
    assert_eq!(contradicted(&before).len(), 2);
    // Ours: the unit and the six reconstructed errors.
    for constant in 0..7 {
        for factor in [0.9, 1.1] {
            let mut inputs = plain.clone();
            match constant {
                0 => inputs.unit_mm *= factor,
                i => inputs.error[i - 1] *= factor,
            }
            let after = reproduce_000::run(&inputs).unwrap();
            assert_eq!(contradicted(&after), contradicted(&before), "{constant} x {factor}");
            for row in &after {
                assert_eq!(serde_json::to_value(row.verdict).unwrap(), verdict_again(row), "{row:?}");
            }
            if constant > 0 {
                let moved = after.iter().find(|row| row.id == "eq5.b" || row.id == "eq6.a").unwrap();
                assert_eq!(moved.verdict, Verdict::NotReproduced, "{constant} x {factor}");
            } else if factor > 1.0 {
                let change = after.iter().find(|row| row.id == "experiment.change").unwrap();
                assert_eq!(change.verdict, Verdict::NotReproduced);
            }
        }
    }
}

/// The constants of the experiment through frames (length, depth, scatter) act through the parts
/// alone: for any parts no row becomes a contradiction, and a change of the means out of its range
/// is a miss.
#[test]
fn no_contradiction_hangs_on_the_simulated_experiment() {
    let inputs = reproduce_000::Inputs::default();
    let part = |compensated: bool, mean_mm: f64| reproduce_000::experiment::Part {
        compensated,
        measured_mm: (1..=6).map(|i| (f64::from(i) / 6.0, mean_mm + 1e-3 * f64::from(i))).collect(),
        worst_reading_mm: 1e-3,
    };
    let printed = inputs.uncompensated_mm - inputs.compensated_mm;
    for factor in [0.5, 0.7, 0.9, 1.0, 1.1, 1.3, 2.0] {
        let parts = [part(true, 23.2), part(false, 23.2 + factor * printed)];
        for row in reproduce_000::experiment::rows(&inputs, &parts) {
            assert_ne!(row.verdict, Verdict::Contradiction, "{factor} {row:?}");
            assert_eq!(serde_json::to_value(row.verdict).unwrap(), verdict_again(&row), "{row:?}");
            if row.id == "experiment.frames.change" {
                let near = (factor - 1.0).abs() < 0.2;
                let expected = if near { Verdict::Consistent } else { Verdict::NotReproduced };
                assert_eq!(row.verdict, expected, "{factor} {row:?}");
            }
        }
    }
}

/// With Fig. 2's data the 52.5 % is judged.
#[test]
fn the_reduction_of_paper_000_needs_the_data_of_its_figure_2() {
    let verdict = |limit_error_mm: Option<[f64; 2]>| {
        let inputs = reproduce_000::Inputs { limit_error_mm, ..reproduce_000::Inputs::default() };
        let rows = reproduce_000::run(&inputs).unwrap();
        rows.iter().find(|row| row.id == "experiment.reduction").unwrap().verdict
    };
    assert_eq!(verdict(None), Verdict::Undetermined);
    assert_eq!(verdict(Some([0.040, 0.019])), Verdict::Consistent);
    assert_eq!(verdict(Some([0.040, 0.030])), Verdict::Contradiction);
}
