//! What the store holds: stations by time, documents, and whether anything was altered.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Query, State as Extract};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::off_thread::off_thread;
use super::problem::{Problem, Words};
use super::state::Shared;
use crate::gauge::calibration::Date;
use crate::store::{Store, StoredRow, Utc};

/// Stations of an answer at most: a page that shows more shows nothing.
const MOST_STATIONS: usize = 50_000;

/// A time.
#[derive(Clone, Debug, Deserialize, IntoParams)]
pub(super) struct Days {
    /// First day, YYYY-MM-DD in UTC.
    from: Option<String>,
    /// Last day.
    to: Option<String>,
}

/// Stations of a time.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct History {
    /// By time, along the part; the first 50 000.
    #[schema(value_type = Vec<Object>)]
    stations: Vec<StoredRow>,
    /// Whether there are more.
    more: bool,
}

/// Whether the store is what was written into it.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct StoreState {
    /// Rows of the audit.
    audit_rows: i64,
    /// Hash of the newest row.
    head: String,
    /// What does not fit together.
    findings: Vec<String>,
    /// Runs.
    runs: i64,
    /// Passes.
    passes: i64,
    /// Stations.
    stations: i64,
}

fn store(state: &Shared) -> Result<Store, Problem> {
    let path = state.settings.store.as_ref();
    let path = path.ok_or_else(|| Problem::absent("this server has no store (--store FILE)"))?;
    Store::read(path).map_err(Problem::failed)
}

fn day(text: Option<&String>, name: &str) -> Result<Option<Date>, Problem> {
    let parse = |text: &String| text.parse().map_err(|e| Problem::refused(format!("{name}: {e}")));
    text.filter(|text| !text.is_empty()).map(parse).transpose()
}

/// Stations of a time, by time.
#[utoipa::path(get, path = "/api/history", params(Days), responses((status = 200, body = History), (status = 404, body = Words), (status = 422, body = Words)))]
pub(super) async fn history(
    Extract(state): Extract<Shared>,
    Query(days): Query<Days>,
) -> Result<Json<History>, Problem> {
    off_thread(move || {
        let from = day(days.from.as_ref(), "from")?.map_or(Utc(i64::MIN), Utc::at_beginning_of);
        let to = day(days.to.as_ref(), "to")?.map_or(Utc(i64::MAX), |d| Utc::at_beginning_of(d.plus_days(1)));
        let (mut stations, mut more) = (Vec::new(), false);
        let take = |row| match stations.len() {
            MOST_STATIONS.. => more = true,
            _ => stations.push(row),
        };
        store(&state)?.stations_between(from, to, take).map_err(Problem::failed)?;
        Ok(Json(History { stations, more }))
    })
    .await
}

/// The store, checked.
#[utoipa::path(get, path = "/api/store", responses((status = 200, body = StoreState), (status = 404, body = Words)))]
pub(super) async fn checked(Extract(state): Extract<Shared>) -> Result<Json<StoreState>, Problem> {
    let place = Arc::clone(&state.checking).acquire_owned().await.map_err(Problem::failed)?;
    off_thread(move || {
        // held to the end of the check, also where none waits for the answer any more
        let _place = place;
        let store = store(&state)?;
        let counts = store.counts().map_err(Problem::failed)?;
        let checked = store.check(None).map_err(Problem::failed)?;
        let findings = checked.findings.iter().map(|f| format!("{}: {}", f.place, f.what)).collect();
        let (runs, passes, stations) = (counts.runs, counts.passes, counts.stations);
        let (audit_rows, head) = (checked.audit_rows, checked.head);
        Ok(Json(StoreState { audit_rows, head, findings, runs, passes, stations }))
    })
    .await
}
