//! What the store holds: stations by time, and whether anything was altered.

use std::sync::{Arc, MutexGuard, PoisonError};

use axum::Json;
use axum::extract::{Query, State as Extract};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::off_thread::off_thread;
use super::problem::{Problem, Words};
use super::state::Shared;
use super::store_check::{Checked, FileState, StoreState};
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

/// A store as it is found without reading all of it.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct StoreNow {
    /// Length of the file and its log.
    bytes: u64,
    /// Rows of the audit.
    audit_rows: i64,
    /// Hash of the newest row.
    head: String,
    /// The last check here, while nothing has been written since.
    checked: Option<StoreState>,
    /// When a store was checked here last, ISO 8601.
    checked_utc: Option<String>,
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

/// The store, checked; not again while nothing was written since the last check.
#[utoipa::path(get, path = "/api/store", responses((status = 200, body = StoreState), (status = 404, body = Words)))]
pub(super) async fn checked(Extract(state): Extract<Shared>) -> Result<Json<StoreState>, Problem> {
    let place = Arc::clone(&state.checking).acquire_owned().await.map_err(Problem::failed)?;
    off_thread(move || {
        // held to the end of the check, also where none waits for the answer any more
        let _place = place;
        let (store, of) = open(&state)?;
        let last = last_check(&state).clone().filter(|last| last.of == of);
        if let Some(last) = last {
            return Ok(Json(last.found));
        }
        let counts = store.counts().map_err(Problem::failed)?;
        let checked = store.check(None).map_err(Problem::failed)?;
        let findings = checked.findings.iter().map(|f| format!("{}: {}", f.place, f.what)).collect();
        let (runs, passes, stations) = (counts.runs, counts.passes, counts.stations);
        let (audit_rows, head) = (checked.audit_rows, checked.head);
        let found = StoreState { audit_rows, head, findings, runs, passes, stations };
        *last_check(&state) = Some(Checked { of, utc: Utc::now(), found: found.clone() });
        Ok(Json(found))
    })
    .await
}

/// The store, without a check: its size, its newest row, and what the last check found.
#[utoipa::path(get, path = "/api/store/state", responses((status = 200, body = StoreNow), (status = 404, body = Words)))]
pub(super) async fn state(Extract(state): Extract<Shared>) -> Result<Json<StoreNow>, Problem> {
    off_thread(move || {
        let (store, of) = open(&state)?;
        let (audit_rows, head) = store.newest_row().map_err(Problem::failed)?;
        let last = last_check(&state).clone();
        let checked_utc = last.as_ref().map(|last| last.utc.to_string());
        let checked = last.filter(|last| last.of == of).map(|last| last.found);
        Ok(Json(StoreNow { bytes: of.bytes(), audit_rows, head, checked, checked_utc }))
    })
    .await
}

/// The store and the state of its files before anything of it is read.
fn open(state: &Shared) -> Result<(Store, FileState), Problem> {
    let of = state.settings.store.as_deref().map(FileState::of);
    let store = store(state)?;
    let of = of.ok_or_else(|| Problem::absent("this server has no store (--store FILE)"))?;
    Ok((store, of))
}

fn last_check(state: &Shared) -> MutexGuard<'_, Option<Checked>> {
    state.checked.lock().unwrap_or_else(PoisonError::into_inner)
}
