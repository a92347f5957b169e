//! Reads a user's TOML file, points errors at the key, hashes the config, publishes the JSON
//! Schema.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use miette::{Diagnostic, NamedSource, SourceSpan};
use sha2::{Digest, Sha256};
use thiserror::Error;

use crate::job::Job;
use crate::render::form::read_contour;
use crate::render::settings::Esf;
use crate::setting::SettingError;

/// The preset of the main job, built into the binary; the same file as
/// `configs/slender_shaft.toml`.
pub(crate) const SLENDER_SHAFT: &str = include_str!("../configs/slender_shaft.toml");

/// Why a config is refused.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub(crate) enum ConfigError {
    /// The file cannot be read.
    #[error("{}: cannot be read: {cause}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The underlying cause.
        #[source]
        cause: std::io::Error,
    },
    /// The text is not TOML, has an unknown key, or a value of the wrong type.
    #[error("{file}: {message}")]
    Parse {
        /// The file's name.
        file: String,
        /// What is wrong.
        message: String,
        /// A suggestion, where one can be derived.
        #[help]
        help: Option<String>,
        /// The text, to point into.
        #[source_code]
        source_text: Arc<NamedSource<String>>,
        /// The place.
        #[label("here")]
        span: Option<SourceSpan>,
    },
    /// A value has the right type but is out of range.
    #[error("{file}: {key}: {problem}")]
    Value {
        /// The file's name.
        file: String,
        /// Dotted key.
        key: String,
        /// What is wrong, and the valid values.
        problem: String,
        /// The text, to point into.
        #[source_code]
        source_text: Arc<NamedSource<String>>,
        /// The place, where the file sets the key.
        #[label("here")]
        span: Option<SourceSpan>,
    },
}

/// Reads and checks a config file.
///
/// # Errors
/// The first error, with the file, the key and the valid values.
pub(crate) fn load(path: &Path) -> Result<Job, ConfigError> {
    let text =
        std::fs::read_to_string(path).map_err(|cause| ConfigError::Read { path: path.to_owned(), cause })?;
    let file = path.display().to_string();
    let mut job: Job = parse_as(&text, &file)?;
    read_named_files(&mut job, path.parent().unwrap_or(Path::new("")))
        .map_err(|e| value_error(&text, &file, e))?;
    job.check().map_err(|e| value_error(&text, &file, e))?;
    Ok(job)
}

/// Reads the files that a config names, beside it; their contents replace their names.
fn read_named_files(job: &mut Job, folder: &Path) -> Result<(), SettingError> {
    let open = |key: &str, name: &str| {
        let path = folder.join(name);
        std::fs::File::open(&path)
            .map_err(|e| SettingError::at(key, format!("{}: cannot be read: {e}", path.display())))
    };
    read_measured_edge(&mut job.optics.esf, folder)?;
    if let Some(name) = job.shaft.contour_file.take() {
        if !job.shaft.contour.is_empty() {
            return Err(SettingError::at(
                "shaft.contour_file",
                "stands beside shaft.contour; give one of them",
            ));
        }
        let file = open("shaft.contour_file", &name)?;
        job.shaft.contour = read_contour(file).map_err(crate::job::from_render)?;
    }
    Ok(())
}

/// Reads the file of a measured edge, beside the config that names it; its samples replace the
/// name.
///
/// # Errors
/// A file that cannot be read or does not contain an edge.
pub(crate) fn read_measured_edge(esf: &mut Esf, folder: &Path) -> Result<(), SettingError> {
    const KEY: &str = "optics.esf.measured.file";
    let Esf::Measured(measured) = esf else { return Ok(()) };
    let Some(name) = measured.file.clone() else { return Ok(()) };
    let path = folder.join(&name);
    let file = std::fs::File::open(&path)
        .map_err(|e| SettingError::at(KEY, format!("{}: cannot be read: {e}", path.display())))?;
    measured.fill(file).map_err(crate::job::from_render)
}

/// Reads and checks the text of a config; `file` names it in errors.
///
/// # Errors
/// As [`load`].
pub(crate) fn parse(text: &str, file: &str) -> Result<Job, ConfigError> {
    let job: Job = parse_as(text, file)?;
    job.check().map_err(|e| value_error(text, file, e))?;
    Ok(job)
}

/// Reads the text of another kind of config (a study's) without checking its values; `file` names
/// it in errors.
///
/// # Errors
/// Text that is not TOML, an unknown key, a wrong type.
pub(crate) fn parse_as<T: serde::de::DeserializeOwned>(text: &str, file: &str) -> Result<T, ConfigError> {
    toml::from_str(text).map_err(|e| parse_error(text, file, &e))
}

/// Turns the error of a later check (an override on the command line, the coverage of a scan) into
/// a config error.
pub(crate) fn value_error(text: &str, file: &str, error: SettingError) -> ConfigError {
    ConfigError::Value {
        file: file.to_owned(),
        span: key_span(text, &error.key),
        problem: error.without_key(),
        key: error.key,
        source_text: Arc::new(NamedSource::new(file, text.to_owned())),
    }
}

/// SHA-256 of the resolved config: two runs with the same hash (and binary) give the same bytes on
/// the CPU path.
///
/// # Errors
/// Never for a parsed job; for others, values that TOML cannot represent.
pub(crate) fn hash(job: &Job) -> Result<String, toml::ser::Error> {
    let digest = Sha256::digest(resolved(job)?.as_bytes());
    Ok(digest.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// The config with every default written out.
///
/// # Errors
/// As [`hash`].
pub(crate) fn resolved(job: &Job) -> Result<String, toml::ser::Error> {
    toml::to_string(job)
}

/// JSON Schema of a config file.
pub(crate) fn json_schema() -> String {
    serde_json::to_string_pretty(&schemars::schema_for!(Job)).unwrap_or_default()
}

fn parse_error(text: &str, file: &str, error: &toml::de::Error) -> ConfigError {
    let message = error.message().to_owned();
    ConfigError::Parse {
        file: match error.span() {
            Some(span) => format!("{file}:{}", line_of(text, span.start)),
            None => file.to_owned(),
        },
        help: unit_help(&message),
        message,
        source_text: Arc::new(NamedSource::new(file, text.to_owned())),
        span: error.span().map(SourceSpan::from),
    }
}

fn line_of(text: &str, offset: usize) -> usize {
    text.bytes().take(offset).filter(|&b| b == b'\n').count() + 1
}

/// For "unknown field `length_cm`, expected one of `length_mm`, …": the key that differs only in
/// the unit.
fn unit_help(message: &str) -> Option<String> {
    let mut quoted = message.split('`').skip(1).step_by(2);
    let unknown = quoted.next().filter(|_| message.starts_with("unknown field"))?;
    let stem = unknown.rsplit_once('_').map_or(unknown, |(stem, _)| stem);
    let expected: Vec<&str> = quoted.collect();
    let near = expected.iter().find(|e| e.starts_with(stem)).copied().or_else(|| {
        expected
            .iter()
            .copied()
            .min_by_key(|e| edit_distance(e, unknown))
            .filter(|e| edit_distance(e, unknown) <= 3)
    })?;
    Some(format!("did you mean `{near}`? Units are part of the key's name."))
}

fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, cb) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

/// Where the file sets a dotted key (`a.b[2].c`), otherwise its nearest parent that the file sets,
/// otherwise nothing.
fn key_span(text: &str, dotted: &str) -> Option<SourceSpan> {
    use toml::de::{DeTable, DeValue};
    let root = DeTable::parse(text).ok()?;
    let mut span = None;
    let mut table: Option<&DeTable<'_>> = Some(root.get_ref());
    for part in dotted.split('.') {
        let (name, index) = match part.split_once('[') {
            Some((name, rest)) => (name, rest.trim_end_matches(']').parse::<usize>().ok()),
            None => (part, None),
        };
        let Some((_, mut value)) = table.and_then(|t| t.get_key_value(name)) else { break };
        if let (Some(i), DeValue::Array(items)) = (index, value.get_ref()) {
            let Some(item) = items.get(i) else { break };
            value = item;
        }
        span = Some(SourceSpan::from(value.span()));
        table = match value.get_ref() {
            DeValue::Table(t) => Some(t),
            _ => None,
        };
    }
    span
}
