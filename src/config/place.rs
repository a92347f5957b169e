//! Places in a TOML text. In: a text with an offset or a dotted key. Out: line and column, where
//! the text sets the key, and whether it does.

use std::ops::Range;

use toml::de::{DeTable, DeValue};

/// Line and column of an offset, both from 1; columns are characters.
pub(super) fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let before = text.get(..offset).unwrap_or(text);
    let line = before.bytes().filter(|&byte| byte == b'\n').count() + 1;
    let start = before.rfind('\n').map_or(0, |end| end + 1);
    (line, before[start..].chars().count() + 1)
}

/// Where a text sets a key.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct KeyPlace {
    /// Place of its value, otherwise of its nearest parent that the text sets.
    pub span: Option<Range<usize>>,
    /// Whether the text sets the key itself.
    pub is_set: bool,
}

/// The place of a dotted key (`a.b[2].c`).
pub(super) fn of_key(text: &str, dotted: &str) -> KeyPlace {
    let mut place = KeyPlace::default();
    let Ok(root) = DeTable::parse(text) else { return place };
    let mut table: Option<&DeTable<'_>> = Some(root.get_ref());
    for part in dotted.split('.') {
        let (name, index) = match part.split_once('[') {
            Some((name, rest)) => (name, rest.trim_end_matches(']').parse::<usize>().ok()),
            None => (part, None),
        };
        place.is_set = false;
        let Some((_, mut value)) = table.and_then(|t| t.get_key_value(name)) else { break };
        if let (Some(i), DeValue::Array(items)) = (index, value.get_ref()) {
            let Some(item) = items.get(i) else { break };
            value = item;
        }
        place = KeyPlace { span: Some(value.span()), is_set: true };
        table = value.get_ref().as_table();
    }
    place
}

/// The first key of a table whose value is `nan`, with its place.
pub(super) fn first_nan(text: &str) -> Option<(String, Range<usize>)> {
    let root = DeTable::parse(text).ok()?;
    nan_in_table(root.get_ref(), "")
}

fn nan_in_table(table: &DeTable<'_>, path: &str) -> Option<(String, Range<usize>)> {
    let mut values = table.iter();
    values.find_map(|(key, value)| {
        let key = key.get_ref();
        let path = if path.is_empty() { key.to_string() } else { format!("{path}.{key}") };
        nan_in_value(value.get_ref(), &path, value.span())
    })
}

fn nan_in_value(value: &DeValue<'_>, path: &str, span: Range<usize>) -> Option<(String, Range<usize>)> {
    match value {
        DeValue::Float(number) if number.as_str().ends_with("nan") => Some((path.to_owned(), span)),
        DeValue::Array(items) => items
            .iter()
            .enumerate()
            .find_map(|(index, item)| nan_in_value(item.get_ref(), &format!("{path}[{index}]"), item.span())),
        DeValue::Table(table) => nan_in_table(table, path),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_columns_count_from_one() {
        assert_eq!(line_and_column("a = 1\nµ = 2\n", 0), (1, 1));
        assert_eq!(line_and_column("a = 1\nµ = 2\n", 11), (2, 5));
        assert_eq!(line_and_column("a", 99), (1, 2));
    }

    #[test]
    fn a_key_is_set_or_its_parent_is_found() {
        let text = "[part]\nlength_mm = 5.0\nnominal_diameter_mm = [3.0]\n";
        let place = of_key(text, "part.nominal_diameter_mm[0]");
        assert!(place.is_set && place.span.is_some_and(|span| &text[span] == "3.0"));
        let parent = of_key(text, "part.stock_diameter_mm");
        assert!(!parent.is_set && parent.span.is_some());
        assert_eq!(of_key(text, "optics.magnification"), KeyPlace::default());
        assert!(!of_key(text, "part.nominal_diameter_mm[1]").is_set);
    }

    #[test]
    fn the_first_nan_is_found_by_its_key() {
        let found = first_nan("a = 1.0\n[b]\nc = [1.0, nan]\n");
        assert_eq!(found.map(|(key, _)| key).as_deref(), Some("b.c[1]"));
        assert_eq!(first_nan("a = inf\n"), None);
    }
}
