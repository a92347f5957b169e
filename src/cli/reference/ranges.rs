//! Ranges of a job's numbers, as its own checks state them: each number of two presets is set to
//! −10⁶ and to 0, and the refusal states the range.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::config;
use crate::job::Job;

/// Presets whose numbers are set: between them they have every table that a check reads.
const PRESETS: [&str; 2] = [config::SLENDER_SHAFT, include_str!("../../../configs/probe_000.toml")];

/// Values that nearly every range excludes; large ones would ask for millions of stations.
const PROBES: [i64; 2] = [-1_000_000, 0];

/// Ranges by dotted key, without the indices of arrays.
pub fn of_job() -> BTreeMap<String, String> {
    let presets = PRESETS.iter().filter_map(|text| config::parse(text, "preset").ok());
    let values = presets.filter_map(|job| serde_json::to_value(job).ok());
    let mut ranges = BTreeMap::new();
    for start in values {
        let mut pointers = Vec::new();
        numbers(&start, String::new(), &mut pointers);
        for pointer in pointers {
            let refused = PROBES.into_iter().find_map(|probe| refusal(&start, &pointer, probe));
            ranges.extend(refused.map(|range| (dotted(&pointer), range)));
        }
    }
    ranges
}

/// Pointers to the numbers of a value and to what may be one.
fn numbers(value: &Value, pointer: String, found: &mut Vec<String>) {
    match value {
        Value::Object(table) => {
            table.iter().for_each(|(key, below)| numbers(below, format!("{pointer}/{key}"), found));
        }
        // One element stands for all.
        Value::Array(items) => {
            items.iter().take(1).for_each(|below| numbers(below, format!("{pointer}/0"), found));
        }
        Value::Number(_) | Value::Null => found.push(pointer),
        Value::Bool(_) | Value::String(_) => {}
    }
}

/// What a number must be, where the check of the job with `probe` at `pointer` names that key.
fn refusal(start: &Value, pointer: &str, probe: i64) -> Option<String> {
    let mut changed = start.clone();
    *changed.pointer_mut(pointer)? = probe.into();
    let refused = serde_json::from_value::<Job>(changed).ok()?.check().err()?;
    let range = refused.problem.strip_prefix("must be ")?;
    (without_indices(&refused.key) == dotted(pointer)).then(|| range.to_owned())
}

/// `/masters/pins/0/diameter_mm` as `masters.pins.diameter_mm`.
fn dotted(pointer: &str) -> String {
    let is_key = |part: &&str| !part.is_empty() && part.parse::<usize>().is_err();
    pointer.split('/').filter(is_key).collect::<Vec<_>>().join(".")
}

/// `masters.pins[0].diameter_mm` as `masters.pins.diameter_mm`.
fn without_indices(key: &str) -> String {
    key.split('[').map(|part| part.split_once(']').map_or(part, |(_, rest)| rest)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checks_state_ranges() {
        let ranges = of_job();
        assert!(ranges.len() > 40, "{ranges:?}");
        assert!(ranges["optics.magnification"].contains("above 0"), "{ranges:?}");
        assert_eq!(without_indices("a.b[3].c"), "a.b.c");
    }
}
