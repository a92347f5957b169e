//! A JSON Schema as the kinds of values that a config takes. In: the schema of a file. Out: what a
//! key takes (a table, a list, a number, one of several words), and where a key stands.

use serde_json::Value;

/// The schema of a file with its definitions.
#[derive(Clone, Copy)]
pub(super) struct FileSchema<'a> {
    /// The file's own table.
    pub root: &'a Value,
}

/// What a key takes.
pub(super) enum Kind<'a> {
    /// A table of keys.
    Table(&'a Value),
    /// A list.
    List(&'a Value),
    /// One of several words or tables.
    Choice(Vec<&'a Value>),
    /// A number.
    Number,
    /// A whole number, with its bounds.
    Integer(&'a Value),
    /// True or false.
    Boolean,
    /// A text.
    Text,
    /// Anything else.
    Other,
}

/// Deepest table that is looked into for a key.
const DEEPEST: usize = 6;

impl<'a> FileSchema<'a> {
    /// The schema that a reference or an option stands for.
    pub(super) fn resolved(&self, schema: &'a Value) -> &'a Value {
        if let Some(name) = schema["$ref"].as_str().and_then(|r| r.strip_prefix("#/$defs/")) {
            return self.resolved(&self.root["$defs"][name]);
        }
        let variants = schema["anyOf"].as_array().map(Vec::as_slice).unwrap_or_default();
        let mut some = variants.iter().filter(|variant| variant["type"] != "null");
        match (some.next(), some.next()) {
            (Some(only), None) => self.resolved(only),
            _ => schema,
        }
    }

    /// What a schema takes.
    pub(super) fn kind(&self, schema: &'a Value) -> Kind<'a> {
        let schema = self.resolved(schema);
        if let Some(variants) = schema["oneOf"].as_array().or(schema["anyOf"].as_array()) {
            let some = variants.iter().filter(|variant| variant["type"] != "null");
            return Kind::Choice(some.map(|variant| self.resolved(variant)).collect());
        }
        if schema["enum"].is_array() || schema["const"].is_string() {
            return Kind::Choice(vec![schema]);
        }
        let is = |name: &str| match &schema["type"] {
            Value::Array(types) => types.iter().any(|t| t == name),
            one => one == name,
        };
        match schema {
            _ if schema["properties"].is_object() || is("object") => Kind::Table(schema),
            _ if is("array") => Kind::List(schema),
            _ if is("number") => Kind::Number,
            _ if is("integer") => Kind::Integer(schema),
            _ if is("boolean") => Kind::Boolean,
            _ if is("string") => Kind::Text,
            _ => Kind::Other,
        }
    }

    /// The tables, by their dotted paths, in which a key of this name stands.
    pub(super) fn tables_with(&self, key: &str) -> Vec<String> {
        let mut found = Vec::new();
        self.look(self.root, "", key, &mut found);
        found.sort_by_key(|path| (path.matches('.').count(), path.len()));
        found.dedup();
        found
    }

    fn look(&self, schema: &'a Value, path: &str, key: &str, found: &mut Vec<String>) {
        if path.matches('.').count() >= DEEPEST {
            return;
        }
        match self.kind(schema) {
            Kind::Table(table) => {
                for (name, below) in table["properties"].as_object().into_iter().flatten() {
                    if name == key {
                        found.push(path.to_owned());
                    }
                    let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
                    self.look(below, &path, key, found);
                }
            }
            Kind::List(list) if list["items"].is_object() => self.look(&list["items"], path, key, found),
            Kind::Choice(variants) => {
                for variant in variants.into_iter().filter(|variant| variant["properties"].is_object()) {
                    self.look(variant, path, key, found);
                }
            }
            _ => {}
        }
    }
}

/// The words of a choice.
pub(super) fn words<'a>(variants: &[&'a Value]) -> Vec<&'a str> {
    let of = |variant: &&'a Value| -> Vec<&'a str> {
        match variant["enum"].as_array() {
            Some(words) => words.iter().filter_map(Value::as_str).collect(),
            None => variant["const"].as_str().into_iter().collect(),
        }
    };
    variants.iter().flat_map(of).collect()
}

/// The tables of a choice that are chosen by their name, each with what it takes.
pub(super) fn tagged<'a>(variants: &[&'a Value]) -> Vec<(&'a str, &'a Value)> {
    let of = |variant: &&'a Value| {
        let properties = variant["properties"].as_object().filter(|keys| keys.len() == 1)?;
        let (name, below) = properties.iter().next()?;
        let is_required = variant["required"].as_array().is_some_and(|keys| keys.iter().any(|k| k == name));
        is_required.then_some((name.as_str(), below))
    };
    variants.iter().filter_map(of).collect()
}

/// The first sentence of a schema's description, without its point.
pub(super) fn sentence(schema: &Value) -> &str {
    let text = schema["description"].as_str().unwrap_or_default();
    text.split_once(". ").map_or(text, |(first, _)| first).trim_end_matches('.')
}
