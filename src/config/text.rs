//! The text of a config file. In: its bytes. Out: its text, without a byte order mark; or what the
//! file is instead (UTF-16, another encoding, JSON, nothing at all), with what to do.

use super::place::line_and_column;

/// Why a file is no config.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct NoConfig {
    /// What the file is.
    pub what: String,
    /// What to do.
    pub remedy: String,
}

impl NoConfig {
    fn new(what: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { what: what.into(), remedy: remedy.into() }
    }
}

/// The text of a file's bytes.
///
/// # Errors
/// What the file is instead of a config.
pub(super) fn of_bytes(bytes: &[u8]) -> Result<String, NoConfig> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    if matches!(bytes, [0xff, 0xfe, ..] | [0xfe, 0xff, ..] | [_, 0, ..] | [0, _, ..]) {
        return Err(NoConfig::new(
            "is UTF-16, where UTF-8 is needed",
            "save it as UTF-8 (in an editor: Save as, encoding UTF-8; `new` writes a file by --out FILE)",
        ));
    }
    let text = std::str::from_utf8(bytes).map_err(|error| no_utf8(bytes, error.valid_up_to()))?;
    if text.trim_start().starts_with('{') {
        return Err(json(text));
    }
    let is_blank = |line: &str| line.trim().is_empty() || line.trim_start().starts_with('#');
    if text.lines().all(is_blank) {
        return Err(NoConfig::new(
            "is empty: it sets no key",
            "`shadowgauge new KIND` writes a start, for instance `shadowgauge new shaft`",
        ));
    }
    Ok(text.to_owned())
}

/// A byte that is no UTF-8.
fn no_utf8(bytes: &[u8], at: usize) -> NoConfig {
    let before = String::from_utf8_lossy(&bytes[..at]);
    if bytes.contains(&0) {
        return NoConfig::new("is no text", "a config in TOML is needed");
    }
    let (line, column) = line_and_column(&before, before.len());
    NoConfig::new(
        format!("line {line}, column {column}: the byte 0x{:02x} is no UTF-8", bytes[at]),
        "save it as UTF-8 (it was probably saved as Windows-1252 or Latin-1)",
    )
}

/// A file in JSON: by its keys, what it is.
fn json(text: &str) -> NoConfig {
    let document: serde_json::Value = serde_json::from_str(text).unwrap_or_default();
    if document.get("scale_mm_per_px").is_some() {
        return NoConfig::new(
            "is a calibration made by `calibrate` (JSON), not a config in TOML",
            "measure frames with it: `shadowgauge measure INPUT --calibration FILE`",
        );
    }
    if document.get("$defs").is_some() || document.get("$schema").is_some() {
        return NoConfig::new(
            "is a JSON Schema, not a config in TOML",
            "name the TOML file that it describes",
        );
    }
    NoConfig::new(
        "is JSON, where a config in TOML is needed",
        "`shadowgauge new KIND` writes a start, for instance `shadowgauge new shaft`",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_config_is_named() {
        let wide: Vec<u8> = "a = 1\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
        let marked = [b"\xff\xfe".to_vec(), wide.clone()].concat();
        for (bytes, word) in [
            (wide.as_slice(), "UTF-16"),
            (&marked, "UTF-16"),
            (b"a = 1\nb = \"\xb5m\"\n", "line 2, column 6"),
            (b"", "empty"),
            (b"\n  # only a comment\n", "empty"),
            (b"{\"scale_mm_per_px\": 0.015}", "calibration"),
            (b"{\"$schema\": \"x\"}", "JSON Schema"),
            (b"{}", "JSON"),
            (b"\x89PNG\r\n\x1a\n\x00", "no text"),
        ] {
            let refused = of_bytes(bytes).unwrap_err();
            assert!(refused.what.contains(word), "{word}: {refused:?}");
        }
    }

    #[test]
    fn a_byte_order_mark_is_left_out() {
        assert_eq!(of_bytes(b"\xef\xbb\xbfa = 1\n"), Ok("a = 1\n".to_owned()));
    }
}
