//! Programs: made by `tool compensate` and `nc` from a product, a tool and a machine.

use axum::Json;
use axum::extract::{Extension, Path, Query, State as Extract};
use axum::http::{StatusCode, header};
use axum::response::IntoResponse;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use utoipa::ToSchema;

use super::access::Who;
use super::changed::changed;
use super::documents::{self, Document};
use super::drawn::{Polyline, polylines};
use super::files::{self, JobFolder};
use super::machines::Machine;
use super::off_thread::off_thread;
use super::problem::{Problem, Words};
use super::products::Product;
use super::runs::Page;
use super::state::Shared;
use super::tools::Insert;
use super::workshop;
use crate::store::{EntryKind, Utc};

/// What a program does about the nose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum ProgramWay {
    /// Nothing: the drawing's contour, the register as it is.
    Register,
    /// The register radius that leaves least on this part.
    BestRegister,
    /// The contour, by what is left; the register as it is.
    EditedContour,
    /// The path of the measured nose, without the control's compensation.
    #[default]
    Path,
}

/// Whether the nose's wear is compensated for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum Mode {
    /// The drawing's contour with the register as it is.
    Plain,
    /// By a way.
    Compensated,
}

/// A program to make.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct NewProgram {
    /// Name of the product.
    pub product: String,
    /// Name of the tool.
    pub tool: String,
    /// Name of the machine.
    pub machine: String,
    /// Plain or compensated.
    pub mode: Mode,
    /// How it is compensated for; of a plain program the register.
    #[serde(default)]
    pub way: ProgramWay,
}

/// What became of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum ProgramState {
    /// It waits or is being made.
    Running,
    /// It is there.
    Made,
    /// It was refused.
    Refused,
    /// The server ended before it was made.
    Interrupted,
}

/// A program with what it was made from.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub(super) struct Program {
    /// Its number.
    pub id: String,
    /// When it was asked for, ISO 8601.
    pub utc: String,
    /// What it was made from.
    #[serde(flatten)]
    pub of: NewProgram,
    /// What became of it.
    pub state: ProgramState,
    /// Why it was refused; of one that was made, what it leaves and what was assumed.
    pub words: String,
    /// SHA-256 of its text, the table of its moves, the plain program and the compensation.
    pub nc: Option<String>,
    moves: Option<String>,
    plain: Option<String>,
    compensation: Option<String>,
    /// Lines, from 1, that are not those of the plain program.
    pub changed_lines: Vec<usize>,
    /// The product's outline when it was made, Z and distance from the axis in mm.
    pub outline_mm: Vec<[f64; 2]>,
}

impl Document for Program {
    const KIND: EntryKind = EntryKind::Program;
    const WORD: &'static str = "program";

    fn name(&self) -> &str {
        &self.id
    }
}

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

type Prepared = (Program, JobFolder, Vec<String>);

/// Checks what a program is made from, writes the inputs and the document.
fn prepared(state: &Shared, who: &Who, new: NewProgram) -> Result<Prepared, Problem> {
    let product: Product = documents::get(state, &new.product)?;
    let insert: Insert = documents::get(state, &new.tool)?;
    let machine: Machine = documents::get(state, &new.machine)?;
    let outline_mm = product.contour(state)?.points_mm;
    let nose = insert.nose_document(state)?;
    if nose.is_none() && (product.outline.is_some() || new.mode == Mode::Compensated) {
        let words = format!("the nose of {} was not measured: upload an image of it first", insert.name);
        return Err(Problem::refused(words));
    }
    let folder = JobFolder::new(state)?;
    folder.write("tool.toml", insert.tool.as_bytes())?;
    folder.write("machine.toml", machine.data.as_bytes())?;
    if let Some(nose) = &nose {
        folder.write("nose.json", nose)?;
    }
    let arguments = arguments(state, (&product, &folder), &machine, nose.is_some())?;
    let program = Program {
        id: state.making.begin(),
        utc: Utc::now().to_string(),
        of: new,
        state: ProgramState::Running,
        words: String::new(),
        nc: None,
        moves: None,
        plain: None,
        compensation: None,
        changed_lines: Vec::new(),
        outline_mm,
    };
    documents::add(state, who, &program).inspect_err(|_| state.making.end(&program.id))?;
    Ok((program, folder, arguments))
}

/// The command, without its way and outputs.
fn arguments(
    state: &Shared,
    (product, folder): (&Product, &JobFolder),
    machine: &Machine,
    has_nose: bool,
) -> Result<Vec<String>, Problem> {
    let mut all: Vec<&str> = Vec::new();
    let (stock, from_z, unit);
    if let Some(outline) = &product.outline {
        folder.write("outline.toml", outline.as_bytes())?;
        all.extend(["tool", "compensate", "--part", "outline.toml"]);
    } else {
        let (Some(card), Some(model)) = (&product.card, &product.model) else {
            return Err(Problem::refused(format!("{}: its model was not uploaded yet", product.name)));
        };
        folder.write("part.stl", &files::get(state, model)?)?;
        (stock, from_z, unit) = (card.stock_mm.to_string(), card.from_z_mm.to_string(), card.unit.clone());
        all.extend(["nc", "part.stl", "--unit", &unit, "--stock", &stock, "--from-z", &from_z]);
    }
    all.extend(["--tool", "tool.toml", "--machine", "machine.toml", "--dialect", machine.dialect.as_str()]);
    if has_nose {
        all.extend(["--nose", "nose.json"]);
    }
    Ok(all.into_iter().map(str::to_owned).collect())
}

/// Makes it and stores what became of it.
async fn finish(state: &Shared, who: &Who, (program, folder, arguments): Prepared) {
    let id = program.id.clone();
    let done = match made(state, &program, &folder, &arguments).await {
        Ok(done) => done,
        Err(problem) => Program { state: ProgramState::Refused, words: problem.words, ..program },
    };
    let (state, who) = (state.clone(), who.clone());
    if let Err(problem) = off_thread(move || documents::change(&state, &who, &done)).await {
        tracing::error!("program {id}: {}", problem.words);
    }
}

impl ProgramWay {
    fn word(self) -> &'static str {
        match self {
            Self::Register => "register",
            Self::BestRegister => "best-register",
            Self::EditedContour => "edited-contour",
            Self::Path => "path",
        }
    }
}

/// Outputs of a command in a folder.
struct Outputs {
    text: Vec<u8>,
    moves: Vec<u8>,
    compensation: Option<Vec<u8>>,
    words: String,
}

async fn by_way(folder: &JobFolder, arguments: &[String], way: ProgramWay) -> Result<Outputs, Problem> {
    let mut all: Vec<&str> = arguments.iter().map(String::as_str).collect();
    all.extend(["--way", way.word()]);
    let is_outline = arguments.first().is_some_and(|word| word == "tool");
    let out = format!("out-{}", way.word());
    let [text, moves] = [format!("{out}/program.nc"), format!("{out}/moves.csv")];
    if is_outline {
        all.extend(["--out", &out]);
    } else {
        std::fs::create_dir_all(folder.path().join(&out)).map_err(Problem::failed)?;
        all.extend(["--out", &text, "--moves", &moves, "--verbose"]);
    }
    let ended = workshop::run(folder.path(), &all).await?;
    let compensation = folder.read(&format!("{out}/compensation.json"));
    let none = || {
        let parsed = compensation.as_deref().and_then(|c| serde_json::from_slice::<Value>(c).ok());
        let why = parsed.and_then(|c| c["no_program"].as_str().map(str::to_owned));
        Problem::refused(why.unwrap_or_else(|| "no program was written".to_owned()))
    };
    let (Some(text), Some(moves)) = (folder.read(&text), folder.read(&moves)) else { return Err(none()) };
    Ok(Outputs { text, moves, compensation, words: ended.words })
}

async fn made(
    state: &Shared,
    program: &Program,
    folder: &JobFolder,
    arguments: &[String],
) -> Result<Program, Problem> {
    let places = state.workshop.place().await?;
    let wanted = by_way(folder, arguments, program.of.way).await?;
    let plain = match program.of.mode {
        Mode::Plain => None,
        // what has no plain program is compared with none
        Mode::Compensated => by_way(folder, arguments, ProgramWay::Register).await.ok(),
    };
    drop(places);
    let (state, program) = (state.clone(), program.clone());
    off_thread(move || {
        let text = String::from_utf8_lossy(&wanted.text);
        let changed_lines = plain
            .as_ref()
            .map_or_else(Vec::new, |plain| changed(&String::from_utf8_lossy(&plain.text), &text));
        let put = |bytes: &Option<Vec<u8>>| bytes.as_ref().map(|b| files::put(&state, b)).transpose();
        Ok(Program {
            state: ProgramState::Made,
            nc: Some(files::put(&state, &wanted.text)?),
            moves: Some(files::put(&state, &wanted.moves)?),
            plain: put(&plain.map(|plain| plain.text))?,
            compensation: put(&wanted.compensation)?,
            words: wanted.words,
            changed_lines,
            ..program
        })
    })
    .await
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
