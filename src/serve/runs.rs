//! Runs in a folder: listed, shown, started, stopped.

use std::path::PathBuf;

use axum::Json;
use axum::extract::{Path, Query, State as Extract};
use axum::http::{StatusCode, header};
use axum::response::IntoResponse;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::jobs::JobStatus;
use super::off_thread::off_thread;
use super::problem::{Problem, Words};
use super::state::Shared;
use crate::run_folder::{PassRow, RunFolder, StationRow};

/// Runs a page at most.
const MOST_ON_A_PAGE: usize = 200;
/// Longest config, bytes; the largest of ours has 6 KiB, a contour of a thousand corners 60.
pub(super) const LONGEST_CONFIG: usize = 1 << 20;

/// A part of a long list.
#[derive(Clone, Debug, Deserialize, IntoParams)]
pub(super) struct Page {
    /// Entries before it.
    #[serde(default)]
    offset: usize,
    /// Entries in it, 200 at most.
    #[serde(default = "Page::default_limit")]
    limit: usize,
    /// Only names that contain this.
    #[serde(default)]
    name: String,
}

impl Page {
    fn default_limit() -> usize {
        50
    }

    /// Entries before it, and in it.
    pub(super) fn bounds(&self) -> (usize, usize) {
        (self.offset, self.limit.min(MOST_ON_A_PAGE))
    }
}

/// A run in the list.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct RunSummary {
    /// Name of its folder.
    run: String,
    /// Finished passes.
    passes: usize,
    /// Largest |measured - nominal| after the last of them, mm.
    max_abs_error_mm: Option<f64>,
    /// Whether it has a report: it is finished.
    finished: bool,
}

/// The list.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct RunList {
    /// Runs in all, of this filter.
    total: usize,
    /// Those of this page, by name.
    runs: Vec<RunSummary>,
}

/// A pass of a run.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct RunPass {
    /// Its number, from 1.
    pass: u32,
    /// Its target diameter, mm.
    nominal_mm: f64,
    /// Largest |measured - nominal|, mm.
    max_abs_error_mm: f64,
    /// What was decided after it.
    decision: String,
    /// Stations along the part: z, diameter and standard uncertainty in mm; null in a gap.
    z_mm: Vec<f64>,
    /// Diameters, mm.
    d_mm: Vec<Option<f64>>,
    /// Their standard uncertainty, mm.
    u_mm: Vec<Option<f64>>,
}

/// A run.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct RunDetail {
    /// Name of its folder.
    run: String,
    /// Its passes.
    passes: Vec<RunPass>,
    /// Its resolved config.
    config: String,
    /// Whether it has a report.
    finished: bool,
}

/// A run to start.
#[derive(Clone, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct NewRun {
    /// Name of its folder: letters, digits, `-` and `_`.
    run: String,
    /// Its config as TOML; it names no files.
    config: String,
}

/// The folders of runs, by name.
fn folders(state: &Shared) -> Result<Vec<(String, PathBuf)>, Problem> {
    let Some(root) = &state.settings.runs else { return Ok(Vec::new()) };
    let entries = std::fs::read_dir(root).map_err(|e| Problem::failed(format!("{}: {e}", root.display())))?;
    let mut found: Vec<(String, PathBuf)> = entries
        .filter_map(|entry| {
            let entry = entry.ok()?;
            let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
            let name = entry.file_name().into_string().ok()?;
            (is_folder && RunFolder::is_run(&entry.path())).then(|| (name, entry.path()))
        })
        .collect();
    found.sort();
    Ok(found)
}

/// A run by its name: one of those listed, so that no name is a path.
fn folder(state: &Shared, run: &str) -> Result<PathBuf, Problem> {
    let all = folders(state)?;
    let found = all.into_iter().find(|(name, _)| name == run);
    found.map(|(_, path)| path).ok_or_else(|| Problem::absent(format!("no run {run:?}")))
}

fn is_finished(path: &std::path::Path) -> bool {
    path.join("report.html").is_file()
}

fn summary((run, path): (String, PathBuf)) -> RunSummary {
    // a run whose tables cannot be read is listed; its fault is shown when it is opened
    let passes = RunFolder::open(&path).and_then(|folder| folder.passes()).unwrap_or_default();
    RunSummary {
        run,
        passes: passes.len(),
        max_abs_error_mm: passes.last().map(|pass| pass.max_abs_error_mm),
        finished: is_finished(&path),
    }
}

/// Runs by name.
#[utoipa::path(get, path = "/api/runs", params(Page), responses((status = 200, body = RunList)))]
pub(super) async fn list(
    Extract(state): Extract<Shared>,
    Query(page): Query<Page>,
) -> Result<Json<RunList>, Problem> {
    off_thread(move || {
        let all = folders(&state)?;
        let named: Vec<_> = all.into_iter().filter(|(name, _)| name.contains(&page.name)).collect();
        let total = named.len();
        let limit = page.limit.min(MOST_ON_A_PAGE);
        let runs = named.into_iter().skip(page.offset).take(limit).map(summary).collect();
        Ok(Json(RunList { total, runs }))
    })
    .await
}

fn pass(row: &PassRow, stations: &[StationRow]) -> RunPass {
    let of_pass: Vec<&StationRow> = stations.iter().filter(|s| s.pass == row.pass).collect();
    let u = |s: &&StationRow| s.u_random_mm.zip(s.u_common_mm).map(|(random, common)| random.hypot(common));
    RunPass {
        pass: row.pass,
        nominal_mm: row.nominal_mm,
        max_abs_error_mm: row.max_abs_error_mm,
        decision: row.decision.clone(),
        z_mm: of_pass.iter().map(|s| s.z_mm).collect(),
        d_mm: of_pass.iter().map(|s| s.d_mm).collect(),
        u_mm: of_pass.iter().map(u).collect(),
    }
}

/// A run with its passes.
#[utoipa::path(get, path = "/api/runs/{run}", responses((status = 200, body = RunDetail), (status = 404, body = Words)))]
pub(super) async fn show(
    Extract(state): Extract<Shared>,
    Path(run): Path<String>,
) -> Result<Json<RunDetail>, Problem> {
    off_thread(move || {
        let path = folder(&state, &run)?;
        let open = RunFolder::open(&path).map_err(Problem::failed)?;
        let rows = open.passes().map_err(Problem::failed)?;
        let stations = open.stations().map_err(Problem::failed)?;
        let passes = rows.iter().map(|row| pass(row, &stations)).collect();
        let config = open.config_text().map_err(Problem::failed)?;
        Ok(Json(RunDetail { run, passes, config, finished: is_finished(&path) }))
    })
    .await
}

/// The report of a finished run.
#[utoipa::path(get, path = "/api/runs/{run}/report", responses((status = 200, body = String, content_type = "text/html"), (status = 404, body = Words)))]
pub(super) async fn report(
    Extract(state): Extract<Shared>,
    Path(run): Path<String>,
) -> Result<impl IntoResponse, Problem> {
    let html = off_thread(move || {
        let path = folder(&state, &run)?;
        if !is_finished(&path) {
            return Err(Problem::absent(format!("{run} is not finished: it has no report yet")));
        }
        std::fs::read(path.join("report.html")).map_err(Problem::failed)
    })
    .await?;
    Ok(([(header::CONTENT_TYPE, "text/html; charset=utf-8")], html))
}

/// Runs that were started here.
#[utoipa::path(get, path = "/api/jobs", responses((status = 200, body = Vec<JobStatus>)))]
pub(super) async fn jobs(Extract(state): Extract<Shared>) -> Json<Vec<JobStatus>> {
    Json(state.jobs.status())
}

/// Starts a simulated run of a config.
#[utoipa::path(post, path = "/api/runs", request_body = NewRun, responses((status = 202), (status = 409, body = Words), (status = 422, body = Words)))]
pub(super) async fn start(
    Extract(state): Extract<Shared>,
    Json(new): Json<NewRun>,
) -> Result<StatusCode, Problem> {
    let kept = state.clone();
    let arguments = off_thread(move || prepared(&kept, &new).map(|arguments| (new.run, arguments))).await?;
    started(&state, &arguments.0, &arguments.1)
}

/// Resumes a run that was stopped.
#[utoipa::path(post, path = "/api/runs/{run}/resume", responses((status = 202), (status = 404, body = Words), (status = 409, body = Words)))]
pub(super) async fn resume(
    Extract(state): Extract<Shared>,
    Path(run): Path<String>,
) -> Result<StatusCode, Problem> {
    let path = folder(&state, &run)?;
    if is_finished(&path) {
        return Err(Problem::new(StatusCode::CONFLICT, format!("{run} is finished")));
    }
    let config = config_beside(&state, &run)?;
    if !config.is_file() {
        return Err(Problem::absent(format!("{run} was not started here: its config is not known")));
    }
    started(&state, &run, &arguments(&state, &config, &path))
}

/// Stops a run; its finished passes stay, and it can be resumed.
#[utoipa::path(post, path = "/api/runs/{run}/stop", responses((status = 202), (status = 409, body = Words)))]
pub(super) async fn stop(
    Extract(state): Extract<Shared>,
    Path(run): Path<String>,
) -> Result<StatusCode, Problem> {
    let stopped = state.jobs.stop(&run).map(|()| StatusCode::ACCEPTED);
    stopped.map_err(|why| Problem::new(StatusCode::CONFLICT, why))
}

fn started(state: &Shared, run: &str, arguments: &[String]) -> Result<StatusCode, Problem> {
    let started = state.jobs.start(run, arguments).map(|()| StatusCode::ACCEPTED);
    started.map_err(|why| Problem::new(StatusCode::CONFLICT, why))
}

/// Where the config of a run that was started here is kept.
fn config_beside(state: &Shared, run: &str) -> Result<PathBuf, Problem> {
    let root = state.settings.runs.as_ref();
    let root = root.ok_or_else(|| Problem::refused("this server has no folder of runs (--runs DIR)"))?;
    Ok(root.join(format!("{run}.toml")))
}

fn arguments(state: &Shared, config: &std::path::Path, out: &std::path::Path) -> Vec<String> {
    let text = |path: &std::path::Path| path.to_string_lossy().into_owned();
    let mut all = vec!["run".to_owned(), text(config), "--out".to_owned(), text(out)];
    if let Some(store) = &state.settings.store {
        all.extend(["--store".to_owned(), text(store), "--by".to_owned(), "serve".to_owned()]);
    }
    all
}

/// Checks a new run and writes its config; the arguments that it is started with.
fn prepared(state: &Shared, new: &NewRun) -> Result<Vec<String>, Problem> {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
    if new.run.is_empty() || new.run.len() > 64 || !new.run.chars().all(is_plain) {
        return Err(Problem::refused("run: a name of 1 to 64 letters, digits, - and _"));
    }
    let config = config_beside(state, &new.run)?;
    let out = config.with_extension("");
    if config.exists() || out.exists() {
        return Err(Problem::new(StatusCode::CONFLICT, format!("{} is there already", new.run)));
    }
    let value: toml::Table = new.config.parse().map_err(Problem::refused)?;
    if let Some(key) = named_file(&value, "") {
        return Err(Problem::refused(format!(
            "{key} names a file or a source: a config from a page names none; start it with `shadowgauge run`"
        )));
    }
    // an empty folder that does not exist: nothing is found beside the text
    crate::config::load_text(&new.config, "the config", std::path::Path::new(""))
        .map_err(Problem::refused)?;
    std::fs::write(&config, &new.config)
        .map_err(|e| Problem::failed(format!("{}: cannot be written: {e}", config.display())))?;
    Ok(arguments(state, &config, &out))
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
