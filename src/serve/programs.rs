//! Programs: made by `tool compensate` and `nc` from a product, a tool and a machine.

use axum::Json;
use axum::extract::{Extension, Path, Query, State as Extract};
use axum::http::{StatusCode, header};
use axum::response::IntoResponse;
use serde::Serialize;
use serde_json::{Value, json};
use utoipa::ToSchema;

use super::access::Who;
use super::documents;
use super::drawn::{Polyline, polylines};
use super::files;
use super::off_thread::off_thread;
use super::problem::{Problem, Words};
use super::program::{Mode, NewProgram, Program, ProgramState, ProgramWay};
use super::program_job::{finish, prepared};
use super::runs::Page;
use super::state::Shared;

/// The number of a program that is being made.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct Accepted {
    id: String,
}

/// What a path looks like.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct ProgramPath {
    /// What is drawn of the programmed point, in order: the moves of the text within 0.02 µm.
    polylines: Vec<Polyline>,
    /// The product's outline, Z and distance from the axis in mm.
    outline_mm: Vec<[f64; 2]>,
}

/// Programs of a list.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct ProgramList {
    total: usize,
    programs: Vec<Program>,
}

fn read(state: &Shared, id: &str) -> Result<Program, Problem> {
    documents::get::<Program>(state, id).map(|program| as_it_is(state, program))
}

/// One that runs by its document, and is not being made, was interrupted.
fn as_it_is(state: &Shared, program: Program) -> Program {
    let is_being_made = state.making.contains(&program.id);
    match program.state {
        ProgramState::Running if !is_being_made => {
            Program { state: ProgramState::Interrupted, words: "the server ended".into(), ..program }
        }
        _ => program,
    }
}

/// Programs in the order in which they were asked for.
#[utoipa::path(get, path = "/api/programs", params(Page), responses((status = 200, body = ProgramList), (status = 404, body = Words)))]
pub(super) async fn list(
    Extract(state): Extract<Shared>,
    Query(page): Query<Page>,
) -> Result<Json<ProgramList>, Problem> {
    off_thread(move || {
        let (total, all) = documents::list::<Program>(&state, page.bounds())?;
        let shown = |program| Program { outline_mm: Vec::new(), ..as_it_is(&state, program) };
        Ok(Json(ProgramList { total, programs: all.into_iter().map(shown).collect() }))
    })
    .await
}

/// Makes a program.
#[utoipa::path(post, path = "/api/programs", request_body = NewProgram, responses((status = 202, body = Accepted), (status = 404, body = Words), (status = 422, body = Words), (status = 503, body = Words)))]
pub(super) async fn make(
    Extract(state): Extract<Shared>,
    Extension(who): Extension<Who>,
    Json(mut new): Json<NewProgram>,
) -> Result<(StatusCode, Json<Accepted>), Problem> {
    if new.mode == Mode::Plain {
        new.way = ProgramWay::Register;
    }
    let queued = state.workshop.queue()?;
    let (kept, by) = (state.clone(), who.clone());
    let (program, folder, arguments) = off_thread(move || prepared(&kept, &by, new)).await?;
    let id = program.id.clone();
    tokio::spawn(async move {
        drop(queued);
        let id = program.id.clone();
        finish(&state, &who, (program, folder, arguments)).await;
        state.making.end(&id);
    });
    Ok((StatusCode::ACCEPTED, Json(Accepted { id })))
}

/// A program, with e(a) and what each way leaves, where it was compensated from an outline.
#[utoipa::path(get, path = "/api/programs/{id}", responses((status = 200, body = Object), (status = 404, body = Words)))]
pub(super) async fn show(
    Extract(state): Extract<Shared>,
    Path(id): Path<String>,
) -> Result<Json<Value>, Problem> {
    off_thread(move || {
        let program = read(&state, &id)?;
        let of = |digest: Option<&String>| digest.map(|d| files::get(&state, d)).transpose();
        let compensation = of(program.compensation.as_ref())?;
        let compensation: Value =
            compensation.map_or(Ok(Value::Null), |c| serde_json::from_slice(&c)).map_err(Problem::failed)?;
        let plain = of(program.plain.as_ref())?.map(|t| String::from_utf8_lossy(&t).into_owned());
        Ok(Json(json!({ "program": program, "compensation": compensation, "plain_text": plain })))
    })
    .await
}

fn part(state: &Shared, id: &str, of: impl Fn(&Program) -> Option<&String>) -> Result<Vec<u8>, Problem> {
    let program = read(state, id)?;
    let digest = of(&program).ok_or_else(|| {
        let (word, why) = (format!("{:?}", program.state).to_lowercase(), &program.words);
        Problem::new(StatusCode::CONFLICT, format!("the program is {word}: {why}"))
    })?;
    files::get(state, digest)
}

/// The program's text.
#[utoipa::path(get, path = "/api/programs/{id}/nc", responses((status = 200, body = String, content_type = "text/plain"), (status = 404, body = Words), (status = 409, body = Words)))]
pub(super) async fn nc(
    Extract(state): Extract<Shared>,
    Path(id): Path<String>,
) -> Result<impl IntoResponse, Problem> {
    documents::check_name(&id)?;
    let name = format!("attachment; filename=\"{id}.nc\"");
    let text = off_thread(move || part(&state, &id, |program| program.nc.as_ref())).await?;
    let media = "text/plain; charset=utf-8".to_owned();
    Ok(([(header::CONTENT_TYPE, media), (header::CONTENT_DISPOSITION, name)], text))
}

/// The path that is drawn: the moves that the text commands, as its replay has them.
#[utoipa::path(get, path = "/api/programs/{id}/path", responses((status = 200, body = ProgramPath), (status = 404, body = Words), (status = 409, body = Words)))]
pub(super) async fn path(
    Extract(state): Extract<Shared>,
    Path(id): Path<String>,
) -> Result<Json<ProgramPath>, Problem> {
    off_thread(move || {
        let moves = part(&state, &id, |program| program.moves.as_ref())?;
        let polylines = polylines(&moves).map_err(Problem::failed)?;
        Ok(Json(ProgramPath { polylines, outline_mm: read(&state, &id)?.outline_mm }))
    })
    .await
}
