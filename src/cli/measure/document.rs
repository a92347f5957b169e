//! The documents of `measure --json`, written as the frames come: one document of input that is
//! finished, a line a frame of a stream.

use serde_json::{Map, Value, json};

use crate::source::Arrival;

/// `{"frames":[…]}` with the keys beside it in alphabetical order: those before `frames` are known
/// before the first frame.
#[derive(Debug, Default)]
pub(super) struct Whole {
    /// Keys before `frames`.
    head: Map<String, Value>,
    has_begun: bool,
    has_ended: bool,
}

impl Whole {
    /// A document with these keys before `frames`.
    pub(super) fn new(head: Map<String, Value>) -> Self {
        Self { head, ..Self::default() }
    }

    /// One more frame.
    pub(super) fn frame(&mut self, frame: &Value) {
        if self.has_begun {
            say!(",{frame}");
        } else {
            say!("{}{frame}", opening(&self.head));
        }
        self.has_begun = true;
    }

    /// Ends it with the keys of the series after `frames`.
    pub(super) fn end(&mut self, series: &Map<String, Value>) {
        if self.has_begun {
            say_line!("{}", closing(&self.head, series));
        }
        self.has_ended = true;
    }
}

/// Whatever ends the command: a document that has begun is closed.
impl Drop for Whole {
    fn drop(&mut self) {
        if !self.has_ended {
            self.end(&Map::new());
        }
    }
}

/// What stands before the first frame.
fn opening(head: &Map<String, Value>) -> String {
    let members: String = head.iter().map(|(key, value)| format!("{}:{value},", json!(key))).collect();
    format!("{{{members}\"frames\":[")
}

/// What stands after the last frame.
fn closing(head: &Map<String, Value>, series: &Map<String, Value>) -> String {
    let after = series.iter().filter(|(key, _)| !head.contains_key(*key));
    let members: String = after.map(|(key, value)| format!(",{}:{value}", json!(key))).collect();
    format!("]{members}}}")
}

/// A line a frame: its keys, and when and as which one it came.
#[derive(Debug, Default)]
pub(super) struct Lines {
    sequence: u64,
}

impl Lines {
    /// One more frame.
    pub(super) fn frame(&mut self, frame: Value, arrival: &Arrival) {
        // Numbers that were lost are left out.
        self.sequence += arrival.lost;
        say_line!("{}", line(frame, arrival, self.sequence));
        self.sequence += 1;
    }
}

/// The line of a frame. Files and images on a pipe do not show whether frames were lost before
/// them; a frame that is not whole is never measured: it counts as lost before the next one.
pub(crate) fn line(mut frame: Value, arrival: &Arrival, sequence: u64) -> Value {
    if let Value::Object(keys) = &mut frame {
        keys.insert("sequence".to_owned(), sequence.into());
        keys.insert("device_t_ns".to_owned(), json!(arrival.device_t_ns));
        keys.insert("host_t_ns".to_owned(), json!(arrival.host_t_ns));
        keys.insert("lost".to_owned(), arrival.lost.into());
        keys.insert("incomplete".to_owned(), false.into());
    }
    frame
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(value: Value) -> Map<String, Value> {
        match value {
            Value::Object(map) => map,
            other => panic!("{other}"),
        }
    }

    #[test]
    fn pieces_are_the_document() {
        let series = json!({ "conditions": { "b": 1, "a": [2.5] }, "statistics": { "x": null }, "warnings": ["\"w\""] });
        for (head, series) in [
            (json!({ "bench": { "ms": 0.1 }, "conditions": series["conditions"] }), series),
            (json!({}), json!({})),
        ] {
            let (head, series) = (map(head), map(series));
            let frames = [json!({ "frame": "a\"b", "flags": {} }), json!({ "frame": "c" })];
            let mut whole = series.clone();
            whole.extend(head.clone());
            whole.insert("frames".to_owned(), json!(frames));
            let text = format!("{}{},{}{}", opening(&head), frames[0], frames[1], closing(&head, &series));
            assert_eq!(text, Value::Object(whole).to_string());
        }
    }

    #[test]
    fn a_line_has_the_frames_keys_and_its_own() {
        let arrival = Arrival { device_t_ns: Some(5), host_t_ns: Some(7), ..Arrival::default() };
        let found = line(json!({ "frame": "a" }), &arrival, 3).to_string();
        let right = r#"{"device_t_ns":5,"frame":"a","host_t_ns":7,"incomplete":false,"lost":0,"sequence":3}"#;
        assert_eq!(found, right);
    }
}
