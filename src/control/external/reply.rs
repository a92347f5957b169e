//! A line from a program: offsets, or the reason to hold.

use serde_json::{Map, Value};

/// Keys of a reply.
const KEYS: [&str; 3] = ["offsets_mm", "hold", "pass"];

/// What a program replied.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Answer {
    /// Offsets of the next pass, mm of diameter, a station each, all finite.
    Offsets(Vec<f64>),
    /// The offsets in force shall hold, and why.
    Hold(String),
}

/// Reads a reply to `pass`.
///
/// # Errors
/// What is wrong with the line, as the end of a sentence that begins with it.
pub(super) fn read(line: &str, pass: u32, stations: usize) -> Result<Answer, String> {
    let value: Value = serde_json::from_str(line).map_err(|e| no_json(line, &e))?;
    let Value::Object(reply) = value else { return Err("is no JSON object".to_owned()) };
    if let Some(key) = reply.keys().find(|key| !KEYS.contains(&key.as_str())) {
        return Err(format!("has a key {key:?}, which is none of {}", KEYS.join(", ")));
    }
    if let Some(of) = reply.get("pass").filter(|of| of.as_u64() != Some(u64::from(pass))) {
        return Err(format!("is for pass {of}"));
    }
    answer(&reply, stations)
}

fn no_json(line: &str, error: &serde_json::Error) -> String {
    let not_finite = ["NaN", "Infinity"].into_iter().find(|word| line.contains(word));
    not_finite.map_or_else(|| format!("is no JSON ({error})"), |word| format!("has an offset that is {word}"))
}

fn answer(reply: &Map<String, Value>, stations: usize) -> Result<Answer, String> {
    match (reply.get("offsets_mm"), reply.get("hold")) {
        (Some(Value::Array(values)), None) => offsets(values, stations).map(Answer::Offsets),
        (Some(_), None) => Err("has offsets_mm that are no array".to_owned()),
        (None, Some(Value::String(reason))) if !reason.trim().is_empty() => Ok(Answer::Hold(reason.clone())),
        (None, Some(_)) => Err("holds without a reason in words".to_owned()),
        (Some(_), Some(_)) => Err("has both offsets_mm and hold".to_owned()),
        (None, None) => Err("has neither offsets_mm nor hold".to_owned()),
    }
}

fn offsets(values: &[Value], stations: usize) -> Result<Vec<f64>, String> {
    if values.len() != stations {
        return Err(format!("has {} offsets for {stations} stations", values.len()));
    }
    let number = |(i, value): (usize, &Value)| {
        let finite = value.as_f64().filter(|offset| offset.is_finite());
        finite.ok_or_else(|| format!("has {value} as offset {}, which is no finite number", i + 1))
    };
    values.iter().enumerate().map(number).collect()
}
