//! Mistakes in a text that is TOML and yet not the config: keys that do not exist or are missing,
//! values of another type, two tables where one is possible.
//!
//! In: the text's tables and the file's JSON Schema. Out: the first mistake, with its place and
//! what to write. The schema only words a refusal: what is accepted is decided where the text is
//! read.

use std::borrow::Cow;
use std::ops::Range;

use serde_json::Value;
use toml::Spanned;
use toml::de::{DeInteger, DeTable, DeValue};

use super::kinds::CONFIGS;
use super::mistake::Mistake;
use super::nearest::nearest;
use super::schema::{FileSchema, Kind, sentence, tagged, words};
use super::syntax::before_unit;

/// Most words of a sentence that stands for a name: "Lens", "Camera geometry".
const NAME_WORDS: usize = 4;

/// Most places of a key that are listed.
const MOST_PLACES: usize = 3;

/// How the mistake of a missing key begins.
const MISSING: &str = "missing field";

/// The words and the tables that a key takes one of.
struct Options<'a> {
    words: Vec<&'a str>,
    tables: Vec<(&'a str, &'a Value)>,
}

impl<'a> Options<'a> {
    /// Names of all.
    fn names(&self) -> Vec<&'a str> {
        self.words.iter().copied().chain(self.tables.iter().map(|table| table.0)).collect()
    }
}

/// The first mistake of a text.
pub(super) fn first_mistake(text: &str, root: &Spanned<DeTable<'_>>, schema: &Value) -> Option<Mistake> {
    let mut search = Search { text, schema: FileSchema { root: schema }, found: Vec::new() };
    search.table(schema, root.get_ref(), root.span(), "");
    // A key that is missing may be there under another name: that one is the mistake.
    search.found.into_iter().min_by_key(|mistake| (mistake.what.starts_with(MISSING), mistake.span.start))
}

struct Search<'a> {
    text: &'a str,
    schema: FileSchema<'a>,
    found: Vec<Mistake>,
}

impl<'a> Search<'a> {
    fn say(&mut self, span: Range<usize>, key: &str, what: String, remedy: Option<String>) {
        self.found.push(Mistake { span, key: key.to_owned(), what, remedy });
    }

    fn table(&mut self, schema: &'a Value, table: &DeTable<'_>, at: Range<usize>, path: &str) {
        let keys = schema["properties"].as_object();
        let is_closed = schema["additionalProperties"] == false;
        for (key, value) in table.iter() {
            match keys.and_then(|keys| keys.get(key.get_ref().as_ref())) {
                Some(below) => self.value(below, value, &join(path, key.get_ref())),
                None if is_closed => {
                    let remedy = self.suggestion(schema, key.get_ref(), value.get_ref(), path);
                    let what = format!("unknown field `{}`{}", key.get_ref(), expected(schema));
                    self.say(key.span(), path, what, remedy);
                }
                None => {}
            }
        }
        let required = schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str);
        for key in required.filter(|key| !table.contains_key(*key)) {
            let remedy = self.missing(&schema["properties"][key], key, path);
            self.say(at.clone(), path, format!("{MISSING} `{key}`"), Some(remedy));
        }
    }

    fn value(&mut self, schema: &'a Value, value: &Spanned<DeValue<'_>>, path: &str) {
        let kind = self.schema.kind(schema);
        let wrong = match (&kind, value.get_ref()) {
            (Kind::Table(below), DeValue::Table(table)) => {
                return self.table(below, table, value.span(), path);
            }
            (Kind::List(list), DeValue::Array(items)) => {
                for (index, item) in items.iter().enumerate() {
                    self.value(&list["items"], item, &format!("{path}[{index}]"));
                }
                return;
            }
            (Kind::Choice(variants), _) => return self.choice(variants, value, path),
            (Kind::Number, DeValue::Integer(_) | DeValue::Float(_)) | (Kind::Other, _) => return,
            (Kind::Boolean, DeValue::Boolean(_)) | (Kind::Text, DeValue::String(_)) => return,
            (Kind::Integer(bounds), DeValue::Integer(number)) => out_of_bounds(bounds, number),
            _ => Some(self.other_type(&kind, value, path)),
        };
        if let Some((what, remedy)) = wrong {
            self.say(value.span(), path, what, remedy);
        }
    }

    /// A value of another type than its key takes.
    fn other_type(
        &self,
        kind: &Kind<'a>,
        value: &Spanned<DeValue<'_>>,
        path: &str,
    ) -> (String, Option<String>) {
        let (key, source) = (leaf(path), self.source(value));
        let found = type_name(value.get_ref());
        let write = |value: &str| Some(format!("write `{key} = {value}`"));
        match (kind, value.get_ref()) {
            (Kind::Table(_), DeValue::Array(_)) => (
                format!("is one table, not {found}"),
                Some(format!("write `[{path}]` in single brackets, once")),
            ),
            (Kind::Table(_), _) => {
                (format!("is a table, not {found}"), Some(format!("write `[{path}]` and its keys below it")))
            }
            (Kind::List(list), _) => self.no_list(list, value, path),
            (Kind::Number | Kind::Integer(_), DeValue::String(text)) => number_in_text(key, text),
            (Kind::Number | Kind::Integer(_), DeValue::Array(items)) => {
                let first = items.iter().next().map(|item| self.source(item));
                ("is one number, not a list".to_owned(), first.and_then(write))
            }
            (Kind::Integer(_), DeValue::Float(number)) => {
                let whole = number.as_str().parse::<f64>().ok().filter(|n| n.is_finite());
                (
                    format!("is a whole number, not {source}"),
                    whole.and_then(|n| write(&format!("{:.0}", n.round()))),
                )
            }
            (Kind::Boolean, _) => (
                format!("is true or false, not {found}"),
                Some(format!("write `{key} = true` or `{key} = false`, without quotes")),
            ),
            (Kind::Text, DeValue::Table(_) | DeValue::Array(_)) => (format!("is a text, not {found}"), None),
            (Kind::Text, _) => (format!("is a text, not {found}"), write(&format!("\"{source}\""))),
            _ => (format!("is a number, not {found}"), None),
        }
    }

    fn no_list(&self, list: &'a Value, value: &Spanned<DeValue<'_>>, path: &str) -> (String, Option<String>) {
        let of_tables = matches!(self.schema.kind(&list["items"]), Kind::Table(_));
        if of_tables {
            let remedy = format!("write `[[{path}]]` in double brackets, once for each");
            return ("is a list of tables".to_owned(), Some(remedy));
        }
        let what = format!("is a list, not {}", type_name(value.get_ref()));
        let is_table = value.get_ref().is_table();
        (what, (!is_table).then(|| format!("write `{} = [{}]`", leaf(path), self.source(value))))
    }

    fn choice(&mut self, variants: &[&'a Value], value: &Spanned<DeValue<'_>>, path: &str) {
        let options = Options { words: words(variants), tables: tagged(variants) };
        let covered = variants.iter().filter(|v| v["enum"].is_array() || v["const"].is_string()).count();
        let others = variants.len() > covered + options.tables.len();
        match value.get_ref() {
            DeValue::String(word) if options.words.contains(&word.as_ref()) => {}
            DeValue::String(word) if options.tables.iter().any(|(name, _)| *name == word.as_ref()) => {
                let remedy = format!("write `[{path}.{word}]`, with its keys below it");
                self.say(value.span(), path, format!("`{word}` is a table here"), Some(remedy));
            }
            DeValue::Table(table) if !options.tables.is_empty() => {
                self.one_table(&options, table, value.span(), path);
            }
            DeValue::Table(table) if others => {
                let plain: Vec<&'a Value> =
                    variants.iter().copied().filter(|v| v["properties"].is_object()).collect();
                if let [only] = plain[..] {
                    self.table(only, table, value.span(), path);
                }
            }
            _ if others => {}
            other => self.no_option(&options, other, value.span(), path),
        }
    }

    /// A value that is none of a choice.
    fn no_option(&mut self, options: &Options<'a>, value: &DeValue<'_>, at: Range<usize>, path: &str) {
        let (names, key) = (options.names(), leaf(path));
        if let DeValue::String(word) = value {
            let remedy = nearest(word, &names).map(|near| format!("did you mean `{key} = \"{near}\"`?"));
            let what = format!("unknown variant `{word}`, expected {}", one_of(&names));
            return self.say(at, path, what, remedy);
        }
        let what = format!("is {}, not {}", one_of(&names), type_name(value));
        let example = options.words.first().map(|word| format!("write `{key} = \"{word}\"`, for instance"));
        self.say(at, path, what, example);
    }

    /// The one table of a choice.
    fn one_table(&mut self, options: &Options<'a>, table: &DeTable<'_>, at: Range<usize>, path: &str) {
        let names: Vec<&str> = options.tables.iter().map(|t| t.0).collect();
        let mut keys: Vec<&Spanned<Cow<'_, str>>> = table.keys().collect();
        keys.sort_by_key(|key| key.span().start);
        let (Some(first), Some(last)) = (keys.first(), keys.last()) else {
            let example = names.first().map(|name| format!("write `[{path}.{name}]`, for instance"));
            return self.say(at, path, format!("is empty, expected {}", one_of(&names)), example);
        };
        if keys.len() > 1 {
            let given: Vec<String> = keys.iter().map(|key| format!("`[{path}.{}]`", key.get_ref())).collect();
            let what = format!("{} tables, {}, where one is possible", given.len(), given.join(" and "));
            let remedy = "keep one of them and delete the others".to_owned();
            return self.say(last.span(), path, what, Some(remedy));
        }
        let name: &str = first.get_ref();
        match (options.tables.iter().find(|t| t.0 == name), table.get(name)) {
            (Some((_, below)), Some(value)) => self.value(below, value, &join(path, name)),
            _ if options.words.contains(&name) => {
                let remedy = format!("write `{} = \"{name}\"`", leaf(path));
                self.say(first.span(), path, format!("`{name}` is a word here, no table"), Some(remedy));
            }
            _ => {
                let remedy = nearest(name, &names).map(|near| format!("did you mean `[{path}.{near}]`?"));
                let what = format!("unknown variant `{name}`, expected {}", one_of(&names));
                self.say(first.span(), path, what, remedy);
            }
        }
    }

    /// What a key that does not exist was probably meant to be.
    fn suggestion(&self, schema: &'a Value, key: &str, value: &DeValue<'_>, path: &str) -> Option<String> {
        let keys = schema["properties"].as_object()?;
        let named =
            |name: &str| if value.is_table() { format!("[{}]", join(path, name)) } else { name.to_owned() };
        let names: Vec<&str> = keys.keys().map(String::as_str).collect();
        if let Some(near) = nearest(key, &names) {
            let stem = |name: &str| name.rsplit_once('_').map(|(stem, _)| stem.to_owned());
            let is_of_unit = stem(near).is_some() && stem(near) == stem(key);
            let units = if is_of_unit { " Units are part of the key's name." } else { "" };
            return Some(format!("did you mean `{}`?{units}", named(near)));
        }
        let mut parts = Vec::new();
        let described = keys.iter().find(|(_, below)| is_named(sentence(below), key));
        if let Some((name, _)) = described {
            parts.push(format!("did you mean `{}`", named(name)));
        }
        let places: Vec<String> = self.schema.tables_with(key).into_iter().filter(|at| at != path).collect();
        if !places.is_empty() {
            let shown: Vec<String> = places.iter().take(MOST_PLACES).map(|at| table_name(at)).collect();
            parts.push(format!("`{key}` stands in {}", shown.join(", ")));
        }
        parts.extend(self.of_another_file(key).filter(|_| path.is_empty()));
        (!parts.is_empty()).then(|| parts.join("; "))
    }

    /// The other kind of file that has a table or key at its top.
    fn of_another_file(&self, key: &str) -> Option<String> {
        let own: Option<Vec<&String>> =
            self.schema.root["properties"].as_object().map(|keys| keys.keys().collect());
        CONFIGS.iter().find_map(|kind| {
            let schema = (kind.schema)();
            let keys = schema.as_value()["properties"].as_object()?;
            let is_own = own.as_ref().is_some_and(|own| keys.keys().eq(own.iter().copied()));
            let title = kind.title.strip_prefix("A ").unwrap_or(kind.title);
            (!is_own && keys.contains_key(key)).then(|| format!("`{key}` belongs to another file: {title}"))
        })
    }

    /// What to write for a key that is missing.
    fn missing(&self, schema: &'a Value, key: &str, path: &str) -> String {
        let value = match self.schema.kind(schema) {
            Kind::Choice(variants) => match words(&variants).first() {
                Some(word) => format!("\"{word}\""),
                None => "…".to_owned(),
            },
            Kind::Text => "\"…\"".to_owned(),
            Kind::List(_) => "[…]".to_owned(),
            Kind::Table(_) => return format!("add the table `[{}]`: {}", join(path, key), sentence(schema)),
            _ => "…".to_owned(),
        };
        let place = if path.is_empty() {
            "before the first table".to_owned()
        } else {
            format!("in {}", table_name(path))
        };
        let meaning = sentence(schema).split_whitespace().collect::<Vec<_>>().join(" ");
        format!("add `{key} = {value}` {place}: {meaning}")
    }

    /// A value as it is written.
    fn source(&self, value: &Spanned<DeValue<'_>>) -> &'a str {
        self.text.get(value.span()).unwrap_or("…")
    }
}

fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

/// The last key of a path, without an index.
fn leaf(path: &str) -> &str {
    let last = path.rsplit('.').next().unwrap_or(path);
    last.split('[').next().unwrap_or(last)
}

/// `[part]`, `[[masters.pins]]` for one of a list, or the words for the keys at the top of a file.
fn table_name(path: &str) -> String {
    match path.strip_suffix(']').and_then(|path| path.rsplit_once('[')) {
        _ if path.is_empty() => "the top of the file".to_owned(),
        Some((list, _)) => format!("[[{list}]]"),
        None => format!("[{path}]"),
    }
}

fn one_of(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    if quoted.len() == 1 { quoted.concat() } else { format!("one of {}", quoted.join(", ")) }
}

fn expected(schema: &Value) -> String {
    let names: Vec<&str> =
        schema["properties"].as_object().into_iter().flatten().map(|(k, _)| k.as_str()).collect();
    if names.is_empty() { ", expected no key".to_owned() } else { format!(", expected {}", one_of(&names)) }
}

/// Whether a short sentence names a key's thing: "Lens" names `lens`.
fn is_named(sentence: &str, key: &str) -> bool {
    let words = || sentence.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
    words().count() <= NAME_WORDS && words().any(|word| word.eq_ignore_ascii_case(key))
}

fn type_name(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a text",
        DeValue::Integer(_) | DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(items) if items.iter().any(|item| item.get_ref().is_table()) => "a list of tables",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    }
}

/// A number that is written as a text.
fn number_in_text(key: &str, text: &str) -> (String, Option<String>) {
    let write = |number: &str| Some(format!("write `{key} = {number}`, without quotes"));
    let point = text.trim().replace(',', ".");
    if let Some(number) = before_unit(point.trim()) {
        let remedy = write(number).map(|remedy| remedy + ": the unit is part of the key's name");
        return (format!("is a number, not the text \"{text}\""), remedy);
    }
    let remedy = if point.parse::<f64>().is_ok() { write(&point) } else { None };
    (format!("is a number, not the text \"{text}\""), remedy)
}

/// A whole number outside of what its key can take.
fn out_of_bounds(bounds: &Value, number: &DeInteger<'_>) -> Option<(String, Option<String>)> {
    let text = number.as_str().replace('_', "");
    let value = (number.radix() == 10).then(|| text.parse::<f64>().ok()).flatten()?;
    let least = bounds["minimum"].as_f64().filter(|least| value < *least);
    let most = bounds["maximum"].as_f64().filter(|most| value > *most);
    match (least, most) {
        (Some(least), _) => Some((format!("{text} must be {least} or more"), None)),
        (None, Some(most)) => Some((format!("{text} must be {most} or less"), None)),
        (None, None) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::kinds::find;

    /// The first mistake of a text of a kind of file.
    fn of(kind: &str, text: &str) -> Option<Mistake> {
        let schema = (find(kind).expect("a kind").schema)();
        let root = DeTable::parse(text).expect("TOML");
        first_mistake(text, &root, schema.as_value())
    }

    #[test]
    fn presets_and_starts_have_no_mistake() {
        for (kind, text) in [
            ("job", include_str!("../../configs/slender_shaft.toml")),
            ("job", include_str!("../../configs/probe_000.toml")),
            ("job", include_str!("../../configs/head_line_laser.toml")),
            ("job", include_str!("../cli/new/shaft.toml")),
            ("job", include_str!("../cli/new/stepped.toml")),
            ("job", include_str!("../cli/new/wire.toml")),
            ("calibration", include_str!("../../configs/calibrate.toml")),
            ("calibration", include_str!("../cli/new/calibrate.toml")),
            ("machine", include_str!("../cli/new/machine.toml")),
            ("factor", include_str!("../../configs/factor_003.toml")),
            ("optimize", include_str!("../../configs/optimize_003.toml")),
        ] {
            assert_eq!(of(kind, text), None, "{kind}: {}", text.lines().take(3).collect::<String>());
        }
    }

    #[test]
    fn every_mistake_has_its_key_and_its_remedy() {
        for (kind, text, what, remedy) in [
            ("job", "[optics.esf]\n", "optics.esf: is empty", "[optics.esf.gaussian]"),
            ("job", "[optics]\nesf = \"gaussian\"\n", "`gaussian` is a table here", "[optics.esf.gaussian]"),
            ("job", "[optics.esf.gaussain]\n", "unknown variant `gaussain`", "[optics.esf.gaussian]"),
            ("job", "[gauge.esf]\noptics = true\n", "gauge.esf.optics: is a table", "[gauge.esf.optics]"),
            ("job", "[part]\ntolerance = { upper_um = 1 }\n", "part.tolerance: unknown field", "upper_mm"),
            ("machine", "tailstock = \"non\"\n", "unknown variant `non`", "tailstock = \"none\""),
            ("machine", "tool = 3\nwear = 1\n", "unknown field `wear`", "wear_x"),
            ("machine", "[chuck]\njaws_to_z_mm = 2.0\n", "chuck: missing field `diameter_mm`", "in [chuck]"),
            ("calibration", "optics_id = 3\n", "optics_id: is a text", "optics_id = \"3\""),
        ] {
            let found = of(kind, text).unwrap_or_else(|| panic!("{text}: no mistake"));
            assert!(found.message().contains(what), "{text}: {found:?}");
            assert!(found.remedy.as_deref().unwrap_or_default().contains(remedy), "{text}: {found:?}");
        }
    }
}
