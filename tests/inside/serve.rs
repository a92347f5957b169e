//! What a config from a page may not name.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

mod tls;

use serde_json::Value;

use crate::job::Job;
use crate::serve::named_file;

/// Keys of texts in a job's schema whose description says that they name a file.
fn files(schema: &Value, found: &mut Vec<String>) {
    if let Some(properties) = schema.get("properties").and_then(Value::as_object) {
        for (key, property) in properties {
            let words = property["description"].as_str().unwrap_or_default();
            let is_text = property["type"].to_string().contains("string");
            let says = words.starts_with("File") || words.contains(" file ") && words.contains("folder");
            if is_text && (says || key.ends_with("file") || key.ends_with("sheet")) {
                found.push(key.clone());
            }
        }
    }
    match schema {
        Value::Object(all) => all.values().for_each(|value| files(value, found)),
        Value::Array(all) => all.iter().for_each(|value| files(value, found)),
        _ => {}
    }
}

#[test]
fn every_key_of_a_job_that_names_a_file_is_refused_from_a_page() {
    let schema = serde_json::to_value(schemars::schema_for!(Job)).unwrap();
    let mut found = Vec::new();
    files(&schema, &mut found);
    assert!(found.len() >= 6, "{found:?}");
    for key in found {
        let table: toml::Table = format!("[a.b]\n{key} = \"x\"\n").parse().unwrap();
        assert_eq!(named_file(&table, ""), Some(format!("a.b.{key}")), "{key}");
    }
    let plain: toml::Table = "name = \"x\"\n[control]\ncontroller = \"pid\"\n".parse().unwrap();
    assert_eq!(named_file(&plain, ""), None);
}
