//! A program is made: `tool compensate` or `nc` in a folder of its own, by its way and plain.

use serde_json::Value;

use super::access::Who;
use super::changed::changed;
use super::child::Ended;
use super::documents;
use super::files::{self, JobFolder};
use super::machines::Machine;
use super::off_thread::off_thread;
use super::problem::Problem;
use super::products::Product;
use super::program::{Mode, NewProgram, Program, ProgramState, ProgramWay};
use super::state::Shared;
use super::tools::Insert;
use super::workshop;
use crate::store::Utc;

/// A program with its folder and the command without its way.
pub(super) type Prepared = (Program, JobFolder, Vec<String>);

/// Checks what a program is made from, writes the inputs and the document.
pub(super) fn prepared(state: &Shared, who: &Who, new: NewProgram) -> Result<Prepared, Problem> {
    let product: Product = documents::get(state, &new.product)?;
    let insert: Insert = documents::get(state, &new.tool)?;
    let machine: Machine = documents::get(state, &new.machine)?;
    let outline_mm = product.contour(state)?.points_mm;
    let nose = insert.nose_document(state)?;
    if nose.is_none() && (product.outline.is_some() || new.mode != Mode::Plain) {
        let words = format!("the nose of {} was not measured: upload an image of it first", insert.name);
        return Err(Problem::refused(words));
    }
    let folder = JobFolder::new(state)?;
    folder.write("tool.toml", tool_file(&insert, new.mode)?.as_bytes())?;
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
        warnings: Vec::new(),
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

/// The tool's file. In a batch the offsets are those of the new insert, whose extremes lie at its
/// nominal radius from the centre, unless the file states others (`[setting]`).
fn tool_file(insert: &Insert, mode: Mode) -> Result<String, Problem> {
    if mode != Mode::Batch {
        return Ok(insert.tool.clone());
    }
    let refused = |e: &dyn std::fmt::Display| Problem::refused(format!("tool: {e}"));
    let mut file: toml::Table = insert.tool.parse().map_err(|e: toml::de::Error| refused(&e))?;
    let radius = file.get("nose_radius_mm").cloned().ok_or_else(|| refused(&"has no nose_radius_mm"))?;
    let setting = file.entry("setting").or_insert_with(|| toml::Table::new().into());
    let setting = setting.as_table_mut().ok_or_else(|| refused(&"setting is no table"))?;
    for key in ["x_extent_mm", "z_extent_mm"] {
        setting.entry(key).or_insert_with(|| radius.clone());
    }
    toml::to_string(&file).map_err(Problem::failed)
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
pub(super) async fn finish(state: &Shared, who: &Who, (program, folder, arguments): Prepared) {
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

/// Outputs of a command in a folder.
struct Outputs {
    text: Vec<u8>,
    moves: Vec<u8>,
    compensation: Option<Vec<u8>>,
    ended: Ended,
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
    Ok(Outputs { text, moves, compensation, ended })
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
        Mode::Compensated | Mode::Batch => by_way(folder, arguments, ProgramWay::Register).await.ok(),
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
            words: wanted.ended.words,
            warnings: wanted.ended.warnings,
            changed_lines,
            ..program
        })
    })
    .await
}

#[cfg(test)]
mod tests {
    use super::{Insert, Mode, tool_file};

    /// Extremes of the setting in a tool's file of a mode.
    fn extents(tool: &str, mode: Mode) -> Option<[f64; 2]> {
        let insert = Insert { name: "t".into(), tool: tool.into(), nose: None, readings: Vec::new() };
        let file: toml::Table = tool_file(&insert, mode).unwrap().parse().unwrap();
        let setting = file.get("setting")?;
        Some(["x_extent_mm", "z_extent_mm"].map(|key| setting[key].as_float().unwrap()))
    }

    #[test]
    fn a_batch_keeps_the_offsets_of_the_new_insert() {
        let tool = include_str!("../../configs/tool/tool.toml");
        assert_eq!(extents(tool, Mode::Compensated), None);
        assert_eq!(extents(tool, Mode::Batch), Some([0.4, 0.4]));
        // what the file states stays
        let stated = format!("{tool}\n[setting]\nx_extent_mm = 0.41\n");
        assert_eq!(extents(&stated, Mode::Batch), Some([0.41, 0.4]));
    }
}
