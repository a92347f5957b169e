//! Runs in a folder: listed, shown, their reports.

use std::path::PathBuf;

use axum::Json;
use axum::extract::{Path, Query, State as Extract};
use axum::http::header;
use axum::response::IntoResponse;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::off_thread::off_thread;
use super::problem::{Problem, Words};
use super::state::Shared;
use crate::run_folder::{PassRow, RunFolder, StationRow};

/// Runs a page at most.
const MOST_ON_A_PAGE: usize = 200;

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
pub(super) fn folder(state: &Shared, run: &str) -> Result<PathBuf, Problem> {
    let all = folders(state)?;
    let found = all.into_iter().find(|(name, _)| name == run);
    found.map(|(_, path)| path).ok_or_else(|| Problem::absent(format!("no run {run:?}")))
}

pub(super) fn is_finished(path: &std::path::Path) -> bool {
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
