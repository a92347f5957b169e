//! `study limits` from outside: its rows, its files, and patterns that fit nothing.

use crate::inside::uncertainty::program::{json, said, shadowgauge, text};

/// One threshold, in few scenes of one kind.
const SMALL: [&str; 9] = [
    "study",
    "limits",
    "--only",
    "grey_ends.beyond",
    "--kinds",
    "clipped, half",
    "--scenes",
    "2",
    "--seed=5",
];

/// The lines of stdout without the CPU time, which is that of a run.
fn lines(arguments: &[&str]) -> Vec<String> {
    let output = shadowgauge(arguments);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let without_cpu = |line: &str| match line.rsplit_once(' ') {
        Some((start, end)) if line.contains("half") || line.contains("double") => {
            assert!(
                end == "-" || end == "same" || end.parse::<f64>().is_ok() || line.ends_with(':'),
                "{line}"
            );
            start.trim_end().to_owned()
        }
        _ => line.to_owned(),
    };
    text(&output.stdout).lines().map(without_cpu).collect()
}

#[test]
fn a_threshold_is_halved_and_doubled_on_the_same_scenes() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("limits.csv");
    let mut arguments = SMALL.to_vec();
    arguments.extend(["--csv", file.to_str().unwrap()]);
    let first = lines(&arguments);
    assert!(first[0].starts_with("default, 2 scenes of each of 1 kinds, seed 5"), "{first:?}");
    assert!(first.iter().any(|line| line.trim_start().starts_with("grey_ends.beyond")), "{first:?}");
    let csv = std::fs::read_to_string(&file).unwrap();
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0][..5], ["threshold", "default", "variant", "value", "status"]);
    assert_eq!(rows.len(), 3, "{csv}");
    for (row, (way, times)) in rows[1..].iter().zip([("half", 0.5), ("double", 2.0)]) {
        assert_eq!((row[0], row[2]), ("grey_ends.beyond", way));
        let number = |text: &str| text.parse::<f64>().unwrap();
        assert_eq!(number(row[3]), times * number(row[1]));
        assert!(["changed", "same"].contains(&row[4]), "{csv}");
    }
    assert_eq!(first, lines(&arguments), "the same seed");
}

#[test]
fn the_document_holds_what_the_table_does() {
    let mut arguments = SMALL.to_vec();
    arguments.push("--json");
    let found = json(&shadowgauge(arguments));
    assert_eq!((&found["seed"], &found["scenes"]), (&5.into(), &2.into()));
    assert_eq!(found["variants"].as_array().unwrap().len(), 2);
    assert_eq!(found["default_kinds"]["kinds"][0]["kind"], "clipped, half");
    assert_eq!(found["default_kinds"]["kinds"][0]["clean"], 8);
}

#[test]
fn a_pattern_that_fits_nothing_is_refused_with_the_names() {
    let output = shadowgauge(["study", "limits", "--only", "no_such"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).contains("no_such") && said(&output).contains("flat_field."), "{}", said(&output));
    let output = shadowgauge(["study", "limits", "--kinds", "no such"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).contains("plain") && said(&output).contains("wire"), "{}", said(&output));
}

/// A process that cannot do what it is asked ends by itself and is named, not lost.
#[test]
fn what_a_process_is_started_with_is_checked() {
    let output = shadowgauge(["study", "limits", "--measure", "--variant", "nonsense"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).contains("NAME=VALUE"), "{}", said(&output));
}
