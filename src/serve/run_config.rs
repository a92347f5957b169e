//! Configs of simulated runs as a page gives them: checked, as values for its form, and the schema
//! that the form is made from.

use std::path::Path;

use axum::Json;
use schemars::Schema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::off_thread::off_thread;
use super::problem::{Problem, Words};
use crate::config;
use crate::job::Job;

/// Longest config, bytes; the largest of ours has 6 KiB, a contour of a thousand corners 60.
pub(super) const LONGEST_CONFIG: usize = 1 << 20;

/// A config to look at.
#[derive(Clone, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct GivenConfig {
    /// TOML.
    config: String,
}

/// A config as a form shows it.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct ConfigValues {
    /// The values that it states, table by table; what it leaves out has the schema's defaults.
    #[schema(value_type = Object)]
    values: Value,
    /// Why a run of it would be refused.
    refused: Option<String>,
}

/// JSON Schema of a run's config (`schema job`).
#[utoipa::path(get, path = "/api/config", responses((status = 200, body = Object)))]
pub(super) async fn schema() -> Json<Schema> {
    Json(schemars::schema_for!(Job))
}

/// The values of a config, and whether a run of it would be accepted. Nothing is stored.
#[utoipa::path(post, path = "/api/config", request_body = GivenConfig, responses((status = 200, body = ConfigValues), (status = 422, body = Words)))]
pub(super) async fn values(Json(given): Json<GivenConfig>) -> Result<Json<ConfigValues>, Problem> {
    off_thread(move || {
        let table: toml::Table = given.config.parse().map_err(Problem::refused)?;
        let values = serde_json::to_value(&table).map_err(Problem::refused)?;
        let refused = checked(&given.config).err().map(|problem| problem.words);
        Ok(Json(ConfigValues { values, refused }))
    })
    .await
}

/// The job of a config that names no files.
///
/// # Errors
/// 422 for one that names a file or a source, or that is no job.
pub(super) fn checked(text: &str) -> Result<Job, Problem> {
    let table: toml::Table = text.parse().map_err(Problem::refused)?;
    if let Some(key) = named_file(&table, "") {
        return Err(Problem::refused(format!(
            "{key} names a file or a source: a config from a page names none; start it with `shadowgauge run`"
        )));
    }
    // an empty folder that does not exist: nothing is found beside the text
    config::load_text(text, "the config", Path::new("")).map_err(Problem::refused)
}

/// The first key whose value is the name of a file, a source or a program. Their names end so in
/// every table that a job has; `tests/inside/serve` holds this list to the schema of a job.
pub(crate) fn named_file(table: &toml::Table, above: &str) -> Option<String> {
    const ENDS: [&str; 12] = [
        "file",
        "files",
        "source",
        "table",
        "nose",
        "data_sheet",
        "command",
        "path",
        "folder",
        "frames",
        "dark",
        "config",
    ];
    table.iter().find_map(|(key, value)| {
        let here = if above.is_empty() { key.clone() } else { format!("{above}.{key}") };
        let ends = ENDS.iter().any(|end| key == end || key.ends_with(&format!("_{end}")));
        match value {
            toml::Value::String(_) if ends => Some(here),
            toml::Value::Table(inner) => named_file(inner, &here),
            toml::Value::Array(all) if ends && all.iter().any(toml::Value::is_str) => Some(here),
            toml::Value::Array(all) => {
                all.iter().filter_map(toml::Value::as_table).find_map(|t| named_file(t, &here))
            }
            _ => None,
        }
    })
}
