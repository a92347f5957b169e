//! Simulated runs that a page starts, follows, stops and resumes.

use std::path::{Path as File, PathBuf};

use axum::extract::{Path, State as Extract};
use axum::http::StatusCode;
use axum::{Extension, Json};
use serde::Deserialize;
use utoipa::ToSchema;

use super::access::Who;
use super::jobs::{JobStatus, Planned};
use super::off_thread::off_thread;
use super::problem::{Problem, Words};
use super::run_config::checked;
use super::runs::{folder, is_finished};
use super::state::Shared;
use crate::run_folder::RunFolder;

/// A run to start.
#[derive(Clone, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct NewRun {
    /// Name of its folder: letters, digits, `-` and `_`.
    run: String,
    /// Its config as TOML; it names no files.
    config: String,
}

/// Runs that were started here.
#[utoipa::path(get, path = "/api/jobs", responses((status = 200, body = Vec<JobStatus>)))]
pub(super) async fn jobs(Extract(state): Extract<Shared>) -> Result<Json<Vec<JobStatus>>, Problem> {
    off_thread(move || Ok(Json(all(&state)?))).await
}

/// A run that was started here.
#[utoipa::path(get, path = "/api/jobs/{run}", responses((status = 200, body = JobStatus), (status = 404, body = Words)))]
pub(super) async fn job(
    Extract(state): Extract<Shared>,
    Path(run): Path<String>,
) -> Result<Json<JobStatus>, Problem> {
    off_thread(move || {
        let found = all(&state)?.into_iter().find(|job| job.run == run);
        found.map(Json).ok_or_else(|| Problem::absent(format!("no run {run:?} was started here")))
    })
    .await
}

/// All of them with the passes that each has finished.
fn all(state: &Shared) -> Result<Vec<JobStatus>, Problem> {
    let mut jobs = state.jobs.status();
    for job in &mut jobs {
        // one that has no folder yet has no pass
        let passes = folder(state, &job.run).ok().and_then(|path| RunFolder::open(&path).ok()?.passes().ok());
        job.passes = passes.map_or(0, |passes| passes.len());
    }
    Ok(jobs)
}

/// Starts a simulated run of a config.
#[utoipa::path(post, path = "/api/runs", request_body = NewRun, responses((status = 202), (status = 409, body = Words), (status = 422, body = Words)))]
pub(super) async fn start(
    Extract(state): Extract<Shared>,
    Extension(who): Extension<Who>,
    Json(new): Json<NewRun>,
) -> Result<StatusCode, Problem> {
    off_thread(move || {
        let planned = prepared(&state, &who, &new)?;
        started(&state, &new.run, &planned)
    })
    .await
}

/// Resumes a run that was stopped.
#[utoipa::path(post, path = "/api/runs/{run}/resume", responses((status = 202), (status = 404, body = Words), (status = 409, body = Words)))]
pub(super) async fn resume(
    Extract(state): Extract<Shared>,
    Extension(who): Extension<Who>,
    Path(run): Path<String>,
) -> Result<StatusCode, Problem> {
    off_thread(move || {
        let path = folder(&state, &run)?;
        if is_finished(&path) {
            return Err(Problem::new(StatusCode::CONFLICT, format!("{run} is finished")));
        }
        let config = config_beside(&state, &run)?;
        if !config.is_file() {
            return Err(Problem::absent(format!("{run} was not started here: its config is not known")));
        }
        let passes = checked(&std::fs::read_to_string(&config).map_err(Problem::failed)?)?
            .part
            .nominal_diameter_mm
            .len();
        let arguments = arguments(&state, &who, (&config, &path));
        started(&state, &run, &Planned { arguments, passes })
    })
    .await
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

fn started(state: &Shared, run: &str, planned: &Planned) -> Result<StatusCode, Problem> {
    let started = state.jobs.start(run, planned).map(|()| StatusCode::ACCEPTED);
    started.map_err(|why| Problem::new(StatusCode::CONFLICT, why))
}

/// Where the config of a run that was started here is kept.
fn config_beside(state: &Shared, run: &str) -> Result<PathBuf, Problem> {
    let root = state.settings.runs.as_ref();
    let root = root.ok_or_else(|| Problem::refused("this server has no folder of runs (--runs DIR)"))?;
    Ok(root.join(format!("{run}.toml")))
}

fn arguments(state: &Shared, who: &Who, (config, out): (&File, &File)) -> Vec<String> {
    let text = |path: &File| path.to_string_lossy().into_owned();
    let mut all = vec!["run".to_owned(), text(config), "--out".to_owned(), text(out)];
    if let Some(store) = &state.settings.store {
        all.extend(["--store".to_owned(), text(store), format!("--by={}", who.0)]);
    }
    all
}

/// Checks a new run and writes its config; what it is started with.
fn prepared(state: &Shared, who: &Who, new: &NewRun) -> Result<Planned, Problem> {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
    if new.run.is_empty() || new.run.len() > 64 || !new.run.chars().all(is_plain) {
        return Err(Problem::refused("run: a name of 1 to 64 letters, digits, - and _"));
    }
    let config = config_beside(state, &new.run)?;
    let out = config.with_extension("");
    if config.exists() || out.exists() {
        return Err(Problem::new(StatusCode::CONFLICT, format!("{} is there already", new.run)));
    }
    let passes = checked(&new.config)?.part.nominal_diameter_mm.len();
    std::fs::write(&config, &new.config).map_err(|error| {
        // nothing half-written is left
        let _ = std::fs::remove_file(&config);
        Problem::unwritten(&config, &error)
    })?;
    Ok(Planned { arguments: arguments(state, who, (&config, &out)), passes })
}
