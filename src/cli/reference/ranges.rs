//! Ranges of a job's numbers, as its own checks state them: each number of two presets is set to
//! −10⁶ and to 0, and the refusal states the range.

use std::collections::BTreeMap;

use toml::Value;

use crate::config;
use crate::job::Job;

/// Presets whose numbers are set: between them they have every table that a check reads.
const PRESETS: [&str; 2] = [config::SLENDER_SHAFT, include_str!("../../../configs/probe_000.toml")];

/// Values that nearly every range excludes; large ones would ask for millions of stations.
const PROBES: [i64; 2] = [-1_000_000, 0];

/// Ranges by dotted key, without the indices of arrays.
pub(crate) fn of_job() -> BTreeMap<String, String> {
    let presets = PRESETS.iter().filter_map(|text| config::parse(text, "preset").ok());
    let mut ranges = BTreeMap::new();
    for start in presets.filter_map(|job| toml::from_str::<Value>(&config::resolved(&job).ok()?).ok()) {
        let mut places = Vec::new();
        numbers(&start, &[], &mut places);
        for place in places {
            let refused = PROBES.into_iter().find_map(|probe| refusal(&start, &place, probe));
            ranges.extend(refused.map(|range| (place.join("."), range)));
        }
    }
    ranges
}

/// The keys that lead to each number of a value; through arrays to that of the first element.
fn numbers(value: &Value, keys: &[&str], found: &mut Vec<Vec<String>>) {
    match value {
        Value::Table(table) => {
            table.iter().for_each(|(key, below)| numbers(below, &[keys, &[key.as_str()]].concat(), found));
        }
        Value::Array(items) => items.iter().take(1).for_each(|below| numbers(below, keys, found)),
        Value::Integer(_) | Value::Float(_) => found.push(keys.iter().map(|key| (*key).to_owned()).collect()),
        Value::String(_) | Value::Boolean(_) | Value::Datetime(_) => {}
    }
}

/// The number that the keys lead to.
fn number<'a>(value: &'a mut Value, keys: &[String]) -> Option<&'a mut Value> {
    match value {
        Value::Array(items) => number(items.first_mut()?, keys),
        _ => match keys.split_first() {
            Some((key, below)) => number(value.get_mut(key)?, below),
            None => Some(value),
        },
    }
}

/// What a number must be, where the check of the job with `probe` in its place names its key.
fn refusal(start: &Value, keys: &[String], probe: i64) -> Option<String> {
    let mut changed = start.clone();
    *number(&mut changed, keys)? = Value::Integer(probe);
    // By its text, as a config comes: a second reader of every setting is half a minute to compile.
    let text = toml::to_string(&changed).ok()?;
    let refused = toml::from_str::<Job>(&text).ok()?.check().err()?;
    let range = refused.problem.strip_prefix("must be ")?;
    (without_indices(&refused.key) == keys.join(".")).then(|| range.to_owned())
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
        assert!(ranges.contains_key("part.length_mm"), "{ranges:?}");
        assert_eq!(without_indices("a.b[3].c"), "a.b.c");
    }
}
