//! Reads a user's TOML file, points errors at the key, hashes the config.
//!
//! In: a file, or its text. Out: a checked job or another config, or the first mistake with its
//! place and what to write instead. `text` is what a file is at all, `syntax` words what is not
//! TOML, `shape` (by `schema`, `nearest`) what is TOML and not the config, `place` finds keys;
//! `kinds` lists the files that a user writes; `machine_tables` reads the tables that a
//! machine's errors name.

pub(crate) mod kinds;
pub(crate) mod machine_tables;
mod mistake;
mod nearest;
mod place;
mod schema;
mod shape;
mod syntax;
mod text;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use miette::{Diagnostic, NamedSource, SourceSpan};
use schemars::{JsonSchema, Schema, schema_for};
use serde::de::DeserializeOwned;
use thiserror::Error;
use toml::de::DeTable;

use crate::identification::{IdentifiedMachine, MachineIdentity, head_geometry};
use crate::job::{Job, RunMachine};
use crate::machine::{Conditions, MachineSettings};
use crate::render::form::read_contour;
use crate::render::optics::lens_file::LensFile;
use crate::render::settings::{EmvaResults, Esf, SensorFile};
use crate::setting::SettingError;
use crate::source::sha256_hex;
use crate::studies::machine::MachineStudyConfig;
use machine_tables::read_error_tables;
use mistake::Mistake;

/// The preset of the main job, built into the binary; the same file as
/// `configs/slender_shaft.toml`.
pub(crate) const SLENDER_SHAFT: &str = include_str!("../configs/slender_shaft.toml");

/// Why a config is refused.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum ConfigError {
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
        file: Box<str>,
        /// Dotted key.
        key: Box<str>,
        /// What is wrong, and the valid values.
        problem: Box<str>,
        /// The text, to point into.
        #[source_code]
        source_text: Arc<NamedSource<String>>,
        /// What to do, where the file does not set the key.
        #[help]
        help: Option<String>,
        /// The place, where the file sets the key.
        #[label("here")]
        span: Option<SourceSpan>,
    },
    /// The file is no config at all.
    #[error("{file}: {what}")]
    NoConfig {
        /// The file's name.
        file: String,
        /// What it is.
        what: String,
        /// What to do.
        #[help]
        help: String,
    },
}

/// Reads the text of a config file.
///
/// # Errors
/// A file that cannot be read, or that is no config: not UTF-8, empty, JSON.
pub(crate) fn read_text(path: &Path) -> Result<String, ConfigError> {
    let bytes = std::fs::read(path).map_err(|cause| ConfigError::Read { path: path.to_owned(), cause })?;
    text::of_bytes(&bytes).map_err(|refused| ConfigError::NoConfig {
        file: path.display().to_string(),
        what: refused.what,
        help: refused.remedy,
    })
}

/// Reads and checks a config file.
///
/// # Errors
/// The first error, with the file, the key and the valid values.
pub fn load(path: &Path) -> Result<Job, ConfigError> {
    load_checked(path, |job, _| job.check())
}

/// Reads a config file of which only the part, its scan and the optical setup are used: its shaft
/// is drawn, not turned. Passes, masters, controller and process need not fit.
///
/// # Errors
/// As [`load`].
pub fn load_scene(path: &Path) -> Result<Job, ConfigError> {
    load_checked(path, |job, text| {
        let is_set = |key: &str| place::of_key(text, key).is_set;
        if is_set("part.stock_diameter_mm") && !is_set("part.nominal_diameter_mm") {
            job.part.check_drawn_from_stock()?;
        }
        job.check_scene()
    })
}

fn load_checked(
    path: &Path,
    check: impl Fn(&Job, &str) -> Result<(), SettingError>,
) -> Result<Job, ConfigError> {
    let text = read_text(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    checked(&text, (&path.display().to_string(), folder), check)
}

/// A job from a text that the program has made, its files beside it in `folder`; `file` is its name
/// in errors.
///
/// # Errors
/// As [`load`].
pub fn load_text(text: &str, file: &str, folder: &Path) -> Result<Job, ConfigError> {
    checked(text, (file, folder), |job, _| job.check())
}

fn checked(
    text: &str,
    (file, folder): (&str, &Path),
    check: impl Fn(&Job, &str) -> Result<(), SettingError>,
) -> Result<Job, ConfigError> {
    let mut job: Job = parse_numbers(text, file)?;
    read_named_files(&mut job, folder)
        .and_then(|()| read_data_sheet(&mut job, text, folder))
        .and_then(|()| fill_tool(&mut job, text))
        .and_then(|()| check(&job, text))
        .map_err(|e| value_error(text, file, e))?;
    Ok(job)
}

/// Reads the text of a job in which every number is one.
fn parse_numbers(text: &str, file: &str) -> Result<Job, ConfigError> {
    let job = parse_as(text, file)?;
    match place::first_nan(text) {
        Some((key, _)) => Err(value_error(text, file, SettingError::at(key, "nan is no number: give one"))),
        None => Ok(job),
    }
}

/// Reads the files that a config names, beside it; their contents replace their names.
fn read_named_files(job: &mut Job, folder: &Path) -> Result<(), SettingError> {
    let open = |key: &str, name: &str| {
        let path = folder.join(name);
        std::fs::File::open(&path)
            .map_err(|e| SettingError::at(key, format!("{}: cannot be read: {e}", path.display())))
    };
    read_measured_edge(&mut job.optics.esf, folder)?;
    read_lens(job, folder)?;
    read_tool(job, folder)?;
    read_machine(job, folder)?;
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

/// Reads the lens that a config names, beside it; distortion and telecentricity replace the name.
fn read_lens(job: &mut Job, folder: &Path) -> Result<(), SettingError> {
    const KEY: &str = "optics.lens_file";
    let Some(name) = job.optics.lens_file.take() else { return Ok(()) };
    let path = folder.join(&name);
    let named = |e: &dyn std::fmt::Display| SettingError::at(KEY, format!("{}: {e}", path.display()));
    let text = std::fs::read_to_string(&path).map_err(|e| named(&format_args!("cannot be read: {e}")))?;
    let lens: LensFile =
        parse_as(&text, &path.display().to_string()).map_err(|e| SettingError::at(KEY, e.to_string()))?;
    let um_per_px = 1e3 * job.setup_settings().nominal_pixel_mm();
    let size = (job.camera.rows, job.camera.columns);
    lens.put_into(&mut job.optics, size, um_per_px)
}

/// Reads the results of EMVA 1288 that `[sensor]` names, beside the config; they stand under the
/// keys that the text sets itself.
fn read_data_sheet(job: &mut Job, text: &str, folder: &Path) -> Result<(), SettingError> {
    const KEY: &str = "sensor.data_sheet";
    #[derive(serde::Deserialize)]
    struct WithSensor {
        sensor: SensorFile,
    }
    let Some(name) = job.sensor.data_sheet.take() else { return Ok(()) };
    let path = folder.join(&name);
    let named = |e: &dyn std::fmt::Display| SettingError::at(KEY, format!("{}: {e}", path.display()));
    let sheet = std::fs::read_to_string(&path).map_err(|e| named(&format_args!("cannot be read: {e}")))?;
    let results = EmvaResults::read(&sheet).map_err(|e| named(&e.without_key()))?;
    let own: WithSensor = toml::from_str(text).map_err(|e| named(&e))?;
    job.sensor = results.below(own.sensor);
    Ok(())
}

/// Reads the files of `[tool]`, beside the config that names them; their contents replace the
/// names.
fn read_tool(job: &mut Job, folder: &Path) -> Result<(), SettingError> {
    let Some(tool) = &mut job.tool else { return Ok(()) };
    let read = |key: &str, name: &str| {
        let path = folder.join(name);
        std::fs::read_to_string(&path)
            .map_err(|e| SettingError::at(key, format!("{}: cannot be read: {e}", path.display())))
    };
    if let Some(name) = tool.file.take() {
        if tool.stated.is_some() {
            return Err(SettingError::at("tool.file", "stands beside tool.stated; give one of them"));
        }
        let text = read("tool.file", &name)?;
        let path = folder.join(&name).display().to_string();
        let found = parse_as(&text, &path).map_err(|e| SettingError::at("tool.file", e.to_string()))?;
        tool.stated = Some(found);
    }
    if let Some(name) = tool.nose.clone() {
        if !tool.support.is_empty() {
            return Err(SettingError::at("tool.nose", "stands beside tool.support; give one of them"));
        }
        let text = read("tool.nose", &name)?;
        tool.take_nose(&text)?;
    }
    Ok(())
}

/// Reads the files of `[machine]`, beside the config that names them, with the tables beside those
/// files; their contents replace the names.
fn read_machine(job: &mut Job, folder: &Path) -> Result<(), SettingError> {
    let Some(machine) = &mut job.machine else { return Ok(()) };
    for (own, stated) in [("stated", &mut machine.stated), ("table_stated", &mut machine.table_stated)] {
        let Some(stated) = stated else { continue };
        let key = |key: String| key.replacen("machine.", &format!("machine.{own}."), 1);
        read_error_tables(stated, folder).map_err(|e| SettingError { key: key(e.key), ..e })?;
    }
    let twice = |key: &str| SettingError::at(key, format!("stands beside {key}; give one of them"));
    if let Some(name) = machine.file.clone() {
        if machine.stated.is_some() {
            return Err(SettingError { key: "machine.file".to_owned(), ..twice("machine.stated") });
        }
        let found = read_machine_file("machine.file", &folder.join(name))?;
        machine.take(found.machine, &found.conditions);
        machine.name = machine.name.take().or(Some(found.name).filter(|name| !name.is_empty()));
    }
    if let Some(name) = machine.table.take() {
        if machine.table_stated.is_some() {
            return Err(SettingError { key: "machine.table".to_owned(), ..twice("machine.table_stated") });
        }
        let table = read_table(machine, &folder.join(name))?;
        machine.table_stated = Some(table);
    }
    Ok(())
}

/// The machine of a control's table: `machine.json` of `calibrate machine`, or a file like that of
/// the machine itself.
fn read_table(own: &mut RunMachine, path: &Path) -> Result<MachineSettings, SettingError> {
    const KEY: &str = "machine.table";
    let shown = path.display().to_string();
    let text = std::fs::read_to_string(path)
        .map_err(|e| SettingError::at(KEY, format!("{shown}: cannot be read: {e}")))?;
    if path.extension().is_none_or(|extension| extension != "json") {
        return Ok(read_machine_file(KEY, path)?.machine);
    }
    let refuse = |why: String| SettingError::at(KEY, format!("{shown}: {why}"));
    let found = IdentifiedMachine::read(&text).map_err(refuse)?;
    let identity = MachineIdentity { machine: own.name.clone(), head: own.head.clone() };
    if let Some(machine) = &own.stated {
        found.fits(&identity, machine).map_err(refuse)?;
    }
    let geometry = head_geometry::of_identified(&found).map_err(|e| refuse(e.to_string()))?;
    own.take_identified(&geometry, found.temperature_c, head_geometry::unread(&found));
    Ok(found.machine)
}

/// A machine's file, read.
pub(crate) struct MachineFile {
    /// Name of the machine.
    pub name: String,
    /// The machine with its errors.
    pub machine: MachineSettings,
    /// The state that it states.
    pub conditions: Conditions,
}

/// A machine and its state from a file that `key` names.
///
/// # Errors
/// A file that cannot be read or is no machine's, values that cannot be right.
pub(crate) fn read_machine_file(key: &str, path: &Path) -> Result<MachineFile, SettingError> {
    let shown = path.display().to_string();
    let text = std::fs::read_to_string(path)
        .map_err(|e| SettingError::at(key, format!("{shown}: cannot be read: {e}")))?;
    let found = parse_as(&text, &shown).map_err(|e| SettingError::at(key, e.to_string()))?;
    let MachineStudyConfig { name, mut machine, conditions, .. } = found;
    read_error_tables(&mut machine, path.parent().unwrap_or(Path::new("")))
        .and_then(|()| conditions.validate())
        .and_then(|()| machine.motion().map(drop))
        .map_err(|e| SettingError::at(key, format!("{shown}: {e}")))?;
    Ok(MachineFile { name, machine, conditions })
}

/// Fills `[process.tool]` from the tool's file where the text leaves its keys out.
fn fill_tool(job: &mut Job, text: &str) -> Result<(), SettingError> {
    let Some(tool) = &job.tool else { return Ok(()) };
    tool.fill(&mut job.process.tool, |key| place::of_key(text, key).is_set)
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
    let mut job = parse_numbers(text, file)?;
    let filled = fill_tool(&mut job, text).and_then(|()| job.check());
    filled.map_err(|e| value_error(text, file, e))?;
    Ok(job)
}

/// Reads the text of another kind of config (a study's) without checking its values; `file` names
/// it in errors.
///
/// # Errors
/// Text that is not TOML, an unknown key, a wrong type.
pub(crate) fn parse_as<T: DeserializeOwned + JsonSchema>(text: &str, file: &str) -> Result<T, ConfigError> {
    toml::from_str(text).map_err(|e| parse_error(text, file, &e, Some(&schema_for!(T))))
}

/// As [`parse_as`], for what has no schema: whatever tables a text has.
///
/// # Errors
/// Text that is not TOML, a wrong type.
pub(crate) fn parse_loose<T: DeserializeOwned>(text: &str, file: &str) -> Result<T, ConfigError> {
    toml::from_str(text).map_err(|e| parse_error(text, file, &e, None))
}

/// Turns the error of a later check (an override on the command line, the coverage of a scan) into
/// a config error.
pub(crate) fn value_error(text: &str, file: &str, error: SettingError) -> ConfigError {
    let place = place::of_key(text, &error.key);
    let help = if place.is_set { None } else { kept_default(&error.key, error.found.as_deref()) };
    let at = place.span.as_ref().filter(|_| place.is_set);
    let at = at.map(|span| place::line_and_column(text, span.start));
    ConfigError::Value {
        file: at.map_or_else(|| file.to_owned(), |(line, column)| format!("{file}:{line}:{column}")).into(),
        help,
        span: place.span.map(SourceSpan::from),
        problem: error.without_key().into(),
        key: error.key.into(),
        source_text: Arc::new(NamedSource::new(file, text.to_owned())),
    }
}

/// SHA-256 of the resolved config: two runs with the same hash (and binary) give the same bytes on
/// the CPU path.
///
/// # Errors
/// Never for a parsed job; for others, values that TOML cannot represent.
pub(crate) fn hash(job: &Job) -> Result<String, toml::ser::Error> {
    Ok(sha256_hex(&resolved(job)?))
}

/// The config with every default written out.
///
/// # Errors
/// As [`hash`].
pub(crate) fn resolved(job: &Job) -> Result<String, toml::ser::Error> {
    toml::to_string(job)
}

fn parse_error(text: &str, file: &str, error: &toml::de::Error, schema: Option<&Schema>) -> ConfigError {
    let at = error.span().unwrap_or_default();
    let found = match (DeTable::parse(text), schema) {
        (Err(_), _) => Some(syntax::mistake(text, error.message(), at.clone())),
        (Ok(root), Some(schema)) => shape::first_mistake(text, &root, schema.as_value()),
        (Ok(_), None) => None,
    };
    let mistake = found.unwrap_or_else(|| Mistake {
        span: at,
        key: String::new(),
        what: error.message().to_owned(),
        remedy: None,
    });
    let (line, column) = place::line_and_column(text, mistake.span.start);
    ConfigError::Parse {
        file: format!("{file}:{line}:{column}"),
        message: mistake.message(),
        help: mistake.remedy,
        source_text: Arc::new(NamedSource::new(file, text.to_owned())),
        span: Some(SourceSpan::from(mistake.span)),
    }
}

/// That a key which is refused is not in the file, but left at its default; `found` is the value
/// that is refused.
fn kept_default(key: &str, found: Option<&str>) -> Option<String> {
    let defaults = toml::from_str::<toml::Value>(&resolved(&Job::default()).ok()?).ok()?;
    let mut value = &defaults;
    for part in key.split('.') {
        let (name, index) = part.split_once('[').map_or((part, None), |(name, rest)| (name, Some(rest)));
        value = value.get(name)?;
        if let Some(index) = index {
            value = value.get(index.trim_end_matches(']').parse::<usize>().ok()?)?;
        }
    }
    let shown = value.to_string();
    let is_number = |text: &str| text.parse::<f64>().ok();
    let same = found.is_none_or(|found| {
        found == shown.trim_matches('"') || is_number(found).is_some_and(|n| is_number(&shown) == Some(n))
    });
    (!value.is_table() && same)
        .then(|| format!("the file leaves {key} at its default {shown}, which does not fit the rest: set it"))
}
