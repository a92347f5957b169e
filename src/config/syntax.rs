//! Mistakes in a text that is not TOML. In: the text, the parser's message and its place. Out: the
//! mistake in a user's words, with what to write: decimal commas, units behind numbers, missing
//! quotes, keys set twice.

use std::ops::Range;

use super::mistake::Mistake;
use super::place::line_and_column;

/// The mistake at a place where the parser refuses the text.
pub(super) fn mistake(text: &str, message: &str, at: Range<usize>) -> Mistake {
    let line = line_at(text, at.start);
    let found = if message.starts_with("duplicate key") {
        Some(set_twice(text, &at))
    } else {
        match line.split_once('=') {
            Some((key, value)) => of_value(key.trim(), without_comment(value)),
            None => of_line(line.trim()),
        }
    };
    let key = match line.split_once('=') {
        Some((key, _)) if found.is_some() && !message.starts_with("duplicate key") => key.trim().to_owned(),
        _ => String::new(),
    };
    match found {
        Some((what, remedy)) => Mistake { span: at, key, what, remedy: Some(remedy) },
        None => Mistake { span: at, key, what: message.to_owned(), remedy: None },
    }
}

/// The line that an offset stands in.
fn line_at(text: &str, offset: usize) -> &str {
    let before = text.get(..offset).unwrap_or(text);
    let start = before.rfind('\n').map_or(0, |end| end + 1);
    text[start..].lines().next().unwrap_or_default()
}

fn without_comment(value: &str) -> &str {
    value.split('#').next().unwrap_or_default().trim()
}

/// What is wrong with the value of `key = value`, and what to write.
fn of_value(key: &str, value: &str) -> Option<(String, String)> {
    let first = value.chars().next();
    if first.is_none() {
        return Some((
            "has no value".to_owned(),
            format!("write `{key} = …`, or delete the line for the default"),
        ));
    }
    if value.contains(['“', '”', '„', '‘', '’']) {
        let straight = value.trim_matches(|c| "“”„‘’\"'".contains(c));
        return Some((
            "stands between typographic quotes".to_owned(),
            format!("write straight ones: `{key} = \"{straight}\"`"),
        ));
    }
    if let Some(point) = with_point(value) {
        return Some((
            format!("`{value}` has a decimal comma"),
            format!("write a decimal point: `{key} = {point}`"),
        ));
    }
    if let Some(number) = before_unit(value) {
        return Some((
            format!("`{value}` is a number with its unit"),
            format!("write the number alone, `{key} = {number}`: the unit is part of the key's name"),
        ));
    }
    let lower = value.to_lowercase();
    if ["true", "false"].contains(&lower.as_str()) {
        return Some((
            format!("`{value}` is no value"),
            format!("write it in lower case: `{key} = {lower}`"),
        ));
    }
    let is_bare = first.is_some_and(char::is_alphabetic) && !value.contains(['"', '\'']);
    is_bare.then(|| (format!("`{value}` is a text without quotes"), format!("write `{key} = \"{value}\"`")))
}

/// A number with a decimal comma, written with a point.
fn with_point(value: &str) -> Option<String> {
    let (whole, decimals) = value.split_once(',')?;
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let unsigned = whole.strip_prefix(['+', '-']).unwrap_or(whole);
    (digits(unsigned) && digits(decimals)).then(|| format!("{whole}.{decimals}"))
}

/// The number of a value such as `25 mm`.
pub(super) fn before_unit(value: &str) -> Option<&str> {
    let end = value.find(|c: char| !(c.is_ascii_digit() || "+-._".contains(c)))?;
    let (number, unit) = (&value[..end], value[end..].trim());
    let is_unit = |c: char| c.is_alphabetic() || "°%/·²³^*".contains(c);
    let is_number = number.replace('_', "").parse::<f64>().is_ok();
    (is_number && !unit.is_empty() && unit.chars().all(is_unit)).then_some(number)
}

/// What is wrong with a line without `=`, and what to write.
fn of_line(line: &str) -> Option<(String, String)> {
    if let Some(name) = line.strip_prefix('[').filter(|_| !line.contains(']')) {
        let name = name.trim_start_matches('[');
        return Some(("the bracket is not closed".to_owned(), format!("write `[{name}]`")));
    }
    let (key, value) = line.split_once(':').filter(|(key, _)| !key.contains(char::is_whitespace))?;
    let is_key = !key.is_empty() && key.chars().all(|c| c.is_alphanumeric() || "_.-".contains(c));
    is_key.then(|| ("a colon sets no key".to_owned(), format!("write `{key} = {}`", value.trim())))
}

/// The name in a line's brackets, and whether they are double.
fn header(line: &str) -> Option<(&str, bool)> {
    let line = without_comment(line);
    let name = line.strip_prefix('[')?.strip_suffix(']')?;
    match name.strip_prefix('[').and_then(|inner| inner.strip_suffix(']')) {
        Some(inner) => Some((inner.trim(), true)),
        None => Some((name.trim(), false)),
    }
}

/// What is set twice, and where first.
fn set_twice(text: &str, at: &Range<usize>) -> (String, String) {
    let (line, _) = line_and_column(text, at.start);
    let own = line_at(text, at.start);
    let above: Vec<&str> = text.lines().take(line - 1).collect();
    let first = match header(own) {
        Some((name, _)) => above.iter().position(|l| header(l).is_some_and(|(other, _)| other == name)),
        None => {
            let key = |line: &str| line.split_once('=').map(|(key, _)| key.trim().to_owned());
            let from = above.iter().rposition(|l| header(l).is_some()).map_or(0, |index| index + 1);
            let same = |l: &&str| key(l).is_some() && key(l) == key(own);
            above[from..].iter().position(same).map(|index| from + index)
        }
    };
    let name = header(own).map_or_else(
        || text.get(at.clone()).unwrap_or_default().to_owned(),
        |(name, is_array)| if is_array { format!("[[{name}]]") } else { format!("[{name}]") },
    );
    let place = first.map_or_else(String::new, |index| format!(", first on line {}", index + 1));
    let is_list = first.is_some_and(|index| header(above[index]).is_some_and(|(_, is_array)| is_array));
    let remedy = match header(own) {
        Some((name, _)) if is_list => format!("write `[[{name}]]` in double brackets each time"),
        _ => "keep one of the two".to_owned(),
    };
    (format!("`{name}` is set twice{place}"), remedy)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mistake that a text is refused for.
    fn of(text: &str) -> Mistake {
        let error = toml::from_str::<toml::Table>(text).unwrap_err();
        mistake(text, error.message(), error.span().unwrap_or_default())
    }

    #[test]
    fn every_mistake_has_its_remedy() {
        for (text, what, remedy) in [
            ("[part]\nlength_mm = 25,4\n", "decimal comma", "length_mm = 25.4"),
            ("length_mm = 25 mm # the part\n", "with its unit", "length_mm = 25`"),
            ("length_mm = 25mm\n", "with its unit", "length_mm = 25`"),
            ("format = mono12\n", "without quotes", "format = \"mono12\""),
            ("enabled = True\n", "`True`", "enabled = true"),
            ("name = “shaft”\n", "typographic", "name = \"shaft\""),
            ("length_mm =\n", "no value", "length_mm = …"),
            ("length_mm: 25\n", "colon", "length_mm = 25"),
            ("[part\nlength_mm = 2\n", "not closed", "[part]"),
            ("[a]\nb = 1\nc = 2\nb = 3\n", "first on line 2", "keep one"),
            ("[a]\nb = 1\n[c]\n[a]\nd = 3\n", "first on line 1", "keep one"),
        ] {
            let found = of(text);
            assert!(found.what.contains(what), "{text}: {found:?}");
            assert!(found.remedy.as_deref().unwrap_or_default().contains(remedy), "{text}: {found:?}");
        }
    }

    #[test]
    fn lists_of_numbers_and_words_have_no_unit() {
        assert_eq!(before_unit("25"), None);
        assert_eq!(before_unit("mm"), None);
        assert_eq!(before_unit("25.5 µm"), Some("25.5"));
        assert_eq!(with_point("25,4"), Some("25.4".to_owned()));
        assert_eq!(with_point("1,2,3"), None);
    }
}
