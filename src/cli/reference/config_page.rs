//! `config.md`: the tables and keys of the config files, from their JSON Schemas.
//!
//! A table that several files or places share is printed once; the others refer to it.

use std::collections::BTreeMap;

use serde_json::Value;

use super::markdown::{anchor, cell, row};
use crate::config::kinds::FileKind;

const START: &str = "# Config files

<!-- Written by `shadowgauge reference`; do not edit. -->

Every table and key, with its type, default and meaning. Units are part of a key's name. Unknown keys are refused, and
so is a value out of range: the message names the key and what would be right. The same as JSON Schemas, for
editors: `docs/reference/*.schema.json`, printed by `shadowgauge schema NAME`.

In the column *default* stands what holds where the key is left out: a value, *required*, or nothing where the key
is optional or has a table of defaults.
";

/// The page; `ranges` by dotted key of a job.
pub(crate) fn page(files: &[FileKind], ranges: &BTreeMap<String, String>) -> String {
    let mut page = ConfigPage { text: START.to_owned(), ..ConfigPage::default() };
    for file in files {
        page.ranges = if file.name == "job" { ranges.clone() } else { BTreeMap::new() };
        page.file(file);
    }
    page.text
}

/// A table that has its section, or will have it.
struct Section {
    schema: Value,
    heading: String,
}

/// A table that is still to be printed.
struct Pending {
    path: String,
    is_array: bool,
    schema: Value,
}

#[derive(Default)]
struct ConfigPage {
    text: String,
    /// Behind the headings of the file, so that each heading occurs once.
    suffix: String,
    ranges: BTreeMap<String, String>,
    definitions: Value,
    sections: Vec<Section>,
}

/// What a key takes.
enum Kind {
    /// A value: its type in words.
    Value(String),
    /// A table, or an array of tables.
    Table { is_array: bool, schema: Value },
    /// One of several values or tables.
    Choice(Vec<Value>),
}

impl ConfigPage {
    fn file(&mut self, file: &FileKind) {
        let schema = (file.schema)();
        let schema = schema.as_value();
        self.definitions = schema["$defs"].clone();
        self.suffix = if file.name == "job" { String::new() } else { format!(" ({})", file.name) };
        self.text += &format!("\n## {}\n", file.title);
        let mut pending =
            vec![Pending { path: String::new(), is_array: false, schema: without_definitions(schema) }];
        while let Some(table) = pending.pop() {
            let mut below = self.table(&table);
            below.reverse();
            pending.append(&mut below);
        }
    }

    /// Prints the section of a table; returns the tables below it that have none yet.
    fn table(&mut self, table: &Pending) -> Vec<Pending> {
        if !table.path.is_empty() {
            self.text += &format!("\n### {}\n", self.heading(&table.path, table.is_array));
        }
        self.text += &format!("\n{}\n", cell(words(&table.schema)));
        let Some(keys) = table.schema["properties"].as_object().filter(|keys| !keys.is_empty()) else {
            return Vec::new();
        };
        self.text += "\n| key | type | default | meaning |\n|---|---|---|---|\n";
        let mut below = Vec::new();
        for (key, schema) in keys {
            let line = self.key(table, key, schema, &mut below);
            self.text += &line;
        }
        below
    }

    /// The row of a key; tables below it are added to `below`.
    fn key(&mut self, table: &Pending, key: &str, schema: &Value, below: &mut Vec<Pending>) -> String {
        let path = if table.path.is_empty() { key.to_owned() } else { format!("{}.{key}", table.path) };
        let (kind, meaning) = match self.kind(schema) {
            Kind::Value(kind) => (kind, String::new()),
            Kind::Table { is_array, schema } => {
                (self.table_type(&path, is_array, schema, below), String::new())
            }
            Kind::Choice(variants) => ("one of".to_owned(), self.choice(&path, &variants, below)),
        };
        let required = table.schema["required"].as_array().is_some_and(|r| r.iter().any(|k| k == key));
        let default = match &schema["default"] {
            _ if required => "required".to_owned(),
            Value::Null | Value::Object(_) => String::new(),
            Value::Array(items) if items.iter().any(Value::is_object) => String::new(),
            value => format!("`{value}`"),
        };
        let range = self.ranges.get(&path).map(|range| format!("Must be {range}.")).unwrap_or_default();
        let words = cell(&[self.meaning(schema), range].join(" "));
        row(&[format!("`{key}`"), kind, cell(&default), format!("{words} {meaning}").trim().to_owned()])
    }

    /// Words of a key: its own, else its table's.
    fn meaning(&self, schema: &Value) -> String {
        let own = words(schema);
        if own.is_empty() { words(&self.resolved(schema)).to_owned() } else { own.to_owned() }
    }

    /// A type in Markdown that links to the section of its table, which is printed later unless it
    /// has one.
    fn table_type(&mut self, path: &str, is_array: bool, schema: Value, below: &mut Vec<Pending>) -> String {
        let kind = if is_array { "tables" } else { "table" };
        let heading = self.heading(path, is_array);
        if let Some(section) = self.sections.iter().find(|section| section.schema == schema) {
            return format!("{kind}, as [{}](#{})", section.heading, anchor(&section.heading));
        }
        if is_empty(&schema) {
            return format!("{kind} {heading}");
        }
        let link = format!("{kind} [{heading}](#{})", anchor(&heading));
        self.sections.push(Section { schema: schema.clone(), heading });
        below.push(Pending { path: path.to_owned(), is_array, schema });
        link
    }

    /// `[path]`, or `[[path]]` for tables of an array.
    fn heading(&self, path: &str, is_array: bool) -> String {
        let brackets = if is_array { format!("`[[{path}]]`") } else { format!("`[{path}]`") };
        brackets + &self.suffix
    }

    /// The variants of a choice in words; those that are tables are added to `below`.
    fn choice(&mut self, path: &str, variants: &[Value], below: &mut Vec<Pending>) -> String {
        let mut parts = Vec::new();
        for variant in variants {
            let help = cell(words(variant).trim_end_matches('.'));
            let single =
                variant["properties"].as_object().filter(|p| p.len() == 1).and_then(|p| p.iter().next());
            let name = match (&variant["const"], single) {
                (Value::Null, Some((key, schema))) => match self.kind(schema) {
                    Kind::Table { is_array, schema } => {
                        self.table_type(&format!("{path}.{key}"), is_array, schema, below)
                    }
                    _ => format!("`{{ {key} = … }}`"),
                },
                (Value::Null, None) => self.alternative(path, variant, below),
                (value, _) => format!("`{value}`"),
            };
            parts.push(if help.is_empty() { name } else { format!("{name}: {help}") });
        }
        parts.join("; ") + "."
    }

    /// A variant that is neither a word nor a table with one key.
    fn alternative(&mut self, path: &str, variant: &Value, below: &mut Vec<Pending>) -> String {
        match self.kind(variant) {
            Kind::Value(kind) => kind,
            Kind::Table { is_array, schema } => self.table_type(path, is_array, schema, below),
            Kind::Choice(variants) => self.choice(path, &variants, below),
        }
    }

    /// The schema that a reference or an option stands for.
    fn resolved(&self, schema: &Value) -> Value {
        if let Some(name) = schema["$ref"].as_str().and_then(|r| r.strip_prefix("#/$defs/")) {
            return self.definitions[name].clone();
        }
        let is_some = |s: &&Value| s["type"] != "null";
        match schema["anyOf"].as_array().map(|any| any.iter().filter(is_some).collect::<Vec<_>>()) {
            Some(one) if one.len() == 1 => self.resolved(one[0]),
            _ => schema.clone(),
        }
    }

    fn kind(&self, schema: &Value) -> Kind {
        let schema = self.resolved(schema);
        let variants = schema["oneOf"].as_array().or(schema["anyOf"].as_array());
        if let Some(variants) = variants {
            return Kind::Choice(variants.clone());
        }
        if let Some(values) = schema["enum"].as_array() {
            let constant = |value: &Value| serde_json::json!({ "const": value });
            return Kind::Choice(values.iter().map(constant).collect());
        }
        if schema["properties"].is_object() || is_type(&schema, "object") {
            return Kind::Table { is_array: false, schema };
        }
        if !is_type(&schema, "array") {
            return Kind::Value(value_type(&schema));
        }
        match self.kind(&schema["items"]) {
            Kind::Table { is_array: false, schema } => Kind::Table { is_array: true, schema },
            Kind::Value(kind) => Kind::Value(format!("array of {kind}s")),
            _ => Kind::Value("array".to_owned()),
        }
    }
}

/// Whether a table has no keys.
fn is_empty(table: &Value) -> bool {
    table["properties"].as_object().is_none_or(serde_json::Map::is_empty)
}

fn without_definitions(schema: &Value) -> Value {
    let mut root = schema.clone();
    if let Some(table) = root.as_object_mut() {
        ["$defs", "$schema", "title"].iter().for_each(|key| drop(table.remove(*key)));
    }
    root
}

fn words(schema: &Value) -> &str {
    schema["description"].as_str().unwrap_or_default()
}

fn is_type(schema: &Value, name: &str) -> bool {
    match &schema["type"] {
        Value::Array(types) => types.iter().any(|t| t == name),
        one => one == name,
    }
}

fn value_type(schema: &Value) -> String {
    let known =
        [("integer", "whole number"), ("number", "number"), ("boolean", "boolean"), ("string", "text")];
    let word = known.iter().find(|(name, _)| is_type(schema, name)).map_or("value", |(_, word)| word);
    word.to_owned()
}
