//! Machines: control, limits and what stands around the part.

use axum::extract::{Path, State as Extract};
use axum::http::StatusCode;
use axum::{Extension, Json};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::access::Who;
use super::documents::{self, Document};
use super::off_thread::off_thread;
use super::problem::{Problem, Words};
use super::state::Shared;
use crate::nc::{Dialect, NcSettings};
use crate::store::EntryKind;

/// Machines of a list at most.
const LISTED: usize = 1000;

/// A machine.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Machine {
    /// Its name: letters, digits, `-`, `_` and `.`.
    pub name: String,
    /// Its control: `fanuc`, `linuxcnc`, `gsk` or `sinumerik`.
    #[schema(value_type = String)]
    pub dialect: Dialect,
    /// Its data as TOML: chuck, tailstock, change position, travel, … (docs/nc.md).
    pub data: String,
}

/// A machine with what follows from its control.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct MachineShown {
    #[serde(flatten)]
    machine: Machine,
    /// Least increment of X, mm of diameter.
    increment_mm: f64,
}

impl Document for Machine {
    const KIND: EntryKind = EntryKind::Machine;
    const WORD: &'static str = "machine";

    fn name(&self) -> &str {
        &self.name
    }
}

impl Machine {
    fn check(&self) -> Result<(), Problem> {
        if self.data.trim().is_empty() {
            return Err(Problem::refused("data: is empty; chuck, tailstock and change position are needed"));
        }
        let settings: NcSettings =
            toml::from_str(&self.data).map_err(|e| Problem::refused(format!("data: {e}")))?;
        settings.validate().map_err(|e| Problem::refused(format!("data: {e}")))?;
        // now, and not when the first program is made
        settings.check_stated(self.dialect).map_err(|e| Problem::refused(format!("data: {e}")))
    }

    fn shown(self) -> MachineShown {
        let increment_mm = 10f64.powi(-(self.dialect.x_decimals() as i32));
        MachineShown { machine: self, increment_mm }
    }
}

/// All machines, by name.
#[utoipa::path(get, path = "/api/machines", responses((status = 200, body = Vec<MachineShown>), (status = 404, body = Words)))]
pub(super) async fn list(Extract(state): Extract<Shared>) -> Result<Json<Vec<MachineShown>>, Problem> {
    off_thread(move || {
        let (_, all) = documents::list::<Machine>(&state, (0, LISTED))?;
        Ok(Json(all.into_iter().map(Machine::shown).collect()))
    })
    .await
}

/// Adds a machine.
#[utoipa::path(post, path = "/api/machines", request_body = Machine, responses((status = 201), (status = 409, body = Words), (status = 422, body = Words)))]
pub(super) async fn add(
    Extract(state): Extract<Shared>,
    Extension(who): Extension<Who>,
    Json(machine): Json<Machine>,
) -> Result<StatusCode, Problem> {
    off_thread(move || {
        machine.check()?;
        documents::add(&state, &who, &machine).map(|()| StatusCode::CREATED)
    })
    .await
}

/// A machine.
#[utoipa::path(get, path = "/api/machines/{name}", responses((status = 200, body = MachineShown), (status = 404, body = Words)))]
pub(super) async fn show(
    Extract(state): Extract<Shared>,
    Path(name): Path<String>,
) -> Result<Json<MachineShown>, Problem> {
    off_thread(move || Ok(Json(documents::get::<Machine>(&state, &name)?.shown()))).await
}

/// Changes a machine; programs that were made stay as they are.
#[utoipa::path(put, path = "/api/machines/{name}", request_body = Machine, responses((status = 204), (status = 404, body = Words), (status = 422, body = Words)))]
pub(super) async fn change(
    Extract(state): Extract<Shared>,
    Extension(who): Extension<Who>,
    Path(name): Path<String>,
    Json(machine): Json<Machine>,
) -> Result<StatusCode, Problem> {
    off_thread(move || {
        documents::get::<Machine>(&state, &name)?;
        if machine.name != name {
            return Err(Problem::refused(format!("name: {name:?} stays what it is called")));
        }
        machine.check()?;
        documents::change(&state, &who, &machine).map(|()| StatusCode::NO_CONTENT)
    })
    .await
}

/// Takes a machine out.
#[utoipa::path(delete, path = "/api/machines/{name}", responses((status = 204), (status = 404, body = Words)))]
pub(super) async fn remove(
    Extract(state): Extract<Shared>,
    Extension(who): Extension<Who>,
    Path(name): Path<String>,
) -> Result<StatusCode, Problem> {
    off_thread(move || documents::remove::<Machine>(&state, &who, &name).map(|()| StatusCode::NO_CONTENT))
        .await
}
