//! The direction of imports is itself a test: every path of every source file is parsed (not only
//! `use` lines), the order of the rooms is checked, no files import each other, and planted
//! violations must be found.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use imports::{Loop, Source, Tree};

#[path = "architecture/constants.rs"]
mod constants;
#[path = "architecture/imports.rs"]
mod imports;
#[path = "architecture/lints.rs"]
mod lints;
#[path = "architecture/structs.rs"]
mod structs;
#[path = "architecture/thresholds.rs"]
mod thresholds;

/// Rooms by layer, bottom to top; a file imports its own room and earlier ones; the stages import
/// only the vocabulary.
const VOCABULARY: [&str; 11] = [
    "numerics",
    "setting",
    "text_table",
    "frame",
    "shaft",
    "profile",
    "plan",
    "position",
    "outline",
    "nose",
    "conformity",
];
const STAGES: [&str; 10] =
    ["process", "render", "gauge", "probe", "control", "source", "nc", "stl", "tool", "machine"];
const COMPOSITION: [&str; 9] = [
    "measurement",
    "truth",
    "identification",
    "job",
    "cell",
    "closed_loop",
    "part_offsets",
    "part_program",
    "studies",
];
const SURFACE: [&str; 9] =
    ["files", "config", "run_folder", "store", "report", "publish", "serve", "cli", "main"];
/// The instrument must not import the simulation or the truth.
const INSTRUMENT: [&str; 5] = ["gauge", "probe", "control", "nc", "source"];
/// The closed loop takes anyone's cell: it must not import the simulator, which is a feature.
const SIMULATOR: [&str; 3] = ["process", "render", "truth"];
const FILE_SYSTEM_ROOMS: [&str; 6] = ["source", "files", "run_folder", "config", "serve", "cli"];

/// The contents of a room, bottom to top: a file imports its own folder and entries listed before
/// it, and nothing inside a room imports the room's `mod.rs`.
const ROOMS: [(&str, &str); 4] = [
    ("publish", "gvcp gvsp head genicam camera server simulated"),
    (
        "gauge",
        "limit form sensor settings edges edge width calibration diameter uncertainty ring nose generatrix flank instrument",
    ),
    (
        "render",
        "error optics motion form silhouette kernel contamination sensor settings gpu scene renderer insert flank",
    ),
    (
        "cli",
        "failure process terminal input_output calibration_plan store schema new completions man optics measure calibrate render watch publish serve doctor run demo \
         nc tool optimize reproduce study reference",
    ),
];

/// Most entries directly in a room; in `cli`, besides one per subcommand.
const MOST_ENTRIES: [(&str, usize); 4] = [("gauge", 16), ("publish", 16), ("render", 16), ("cli", 6)];

fn layers() -> [&'static [&'static str]; 4] {
    [&VOCABULARY, &STAGES, &COMPOSITION, &SURFACE]
}

fn layer(room: &str) -> Option<usize> {
    layers().iter().position(|rooms| rooms.contains(&room))
}

fn may_import(from: &str, to: &str) -> bool {
    if from == to || from == "lib" {
        return true;
    }
    let (Some(a), Some(b)) = (layer(from), layer(to)) else { return false };
    if INSTRUMENT.contains(&from) && to == "shaft" || from == "closed_loop" && SIMULATOR.contains(&to) {
        return false;
    }
    let place = |room| layers().concat().iter().position(|known| *known == room);
    b < a && (a != 1 || b == 0) || b == a && a != 1 && place(to) < place(from)
}

/// Why a path inside a room violates the room's order.
fn against_the_room(source: &Source, path: &[String]) -> Option<String> {
    let room = source.module.first()?;
    let (_, order) = ROOMS.iter().find(|(name, _)| name == room)?;
    let own = source.module.get(1)?;
    let place = |name: &str| order.split_whitespace().position(|known| known == name);
    let from = place(own);
    if from.is_none() {
        return Some(format!("'{own}' has no place in the order of {room}"));
    }
    if path.len() < 2 || path[0] != "crate" || path[1] != *room {
        return None;
    }
    match path.get(2).and_then(|name| Some((name, place(name)?))) {
        None => Some(format!("{} names {room}/mod.rs, not the file it wants", path.join("::"))),
        Some((name, to)) if name != own && Some(to) > from => {
            Some(format!("{own} stands before {name} in {room}: {}", path.join("::")))
        }
        Some(_) => None,
    }
}

fn violations(source: &Source) -> Vec<String> {
    let file = source.file.display();
    let room = source.module.first().map_or("lib", String::as_str);
    let mut bad = Vec::new();
    if layer(room).is_none() && room != "lib" {
        bad.push(format!("{file}: room '{room}' belongs to no layer"));
    }
    for path in &source.paths {
        let text = path.join("::");
        let first = path.first().map(String::as_str);
        if matches!(first, Some("crate" | "shadowgauge"))
            && path.len() > 1
            && layer(&path[1]).is_some()
            && !may_import(room, &path[1])
        {
            bad.push(format!("{file}: {room} must not import {text}"));
        }
        bad.extend(against_the_room(source, path).map(|why| format!("{file}: {why}")));
        if first == Some("wgpu") && !source.file.starts_with("src/render/gpu") {
            bad.push(format!("{file}: wgpu belongs under src/render/gpu: {text}"));
        }
        if first == Some("viva_genicam") && !source.file.starts_with("src/source/camera") {
            bad.push(format!("{file}: viva_genicam belongs under src/source/camera: {text}"));
        }
        let is_fs =
            path.len() > 1 && path[0] == "std" && path[1] == "fs" || first == Some("fs") && path.len() > 1;
        if is_fs && !FILE_SYSTEM_ROOMS.contains(&room) {
            bad.push(format!("{file}: std::fs belongs to {FILE_SYSTEM_ROOMS:?}: {text}"));
        }
    }
    bad.sort();
    bad.dedup();
    bad
}

fn files_below(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files_below(&path, into);
        } else if path.extension().is_some_and(|e| e == "rs") {
            into.push(path);
        }
    }
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every source file with its text, paths from the crate's root.
fn texts() -> Vec<(PathBuf, String)> {
    let mut files = Vec::new();
    files_below(&root().join("src"), &mut files);
    files.sort();
    assert!(files.len() > 10, "only {} source files found", files.len());
    let text = |f: PathBuf| (f.strip_prefix(root()).unwrap().to_owned(), std::fs::read_to_string(f).unwrap());
    files.into_iter().map(text).collect()
}

fn all_sources() -> Vec<Source> {
    texts().iter().map(|(file, text)| Source::parse(file, text)).collect()
}

#[test]
fn imports_flow_one_way() {
    let sources = all_sources();
    let bad: Vec<String> = sources.iter().flat_map(violations).collect();
    let loops = Tree::new(&sources).loops();
    println!("loops of imports between files: {}", loops.len());
    println!("imports that run back up: {}", bad.len());
    let text =
        |found: &Loop| format!("{} files import each other:\n{}", found.files.len(), found.ties.join("\n"));
    let refused: Vec<String> = loops.iter().map(text).collect();
    assert!(bad.is_empty() && refused.is_empty(), "{}\n{}", bad.join("\n"), refused.join("\n"));
}

/// Subcommands of `cli/mod.rs`, as their files are named: `Name(Arguments) => run` in its call of
/// `commands!`.
fn subcommands() -> Vec<String> {
    let text = std::fs::read_to_string(root().join("src/cli/mod.rs")).unwrap();
    let parsed = syn::parse_file(&text).unwrap();
    let list = parsed.items.into_iter().find_map(|item| match item {
        syn::Item::Macro(call) if call.mac.path.is_ident("commands") => Some(call.mac.tokens.to_string()),
        _ => None,
    });
    let list = list.expect("a call of commands!");
    let before_arrow = list.split("=>").filter_map(|command| command.split('(').rev().nth(1));
    before_arrow.filter_map(|name| name.split_whitespace().last()).map(str::to_lowercase).collect()
}

#[test]
fn rooms_stay_small() {
    let commands = subcommands();
    assert!(commands.len() > 10 && commands.iter().any(|name| name == "measure"), "{commands:?}");
    let mut bad = Vec::new();
    for (room, most) in MOST_ENTRIES {
        let folder = root().join("src").join(room);
        let names = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
        let stem = |path: PathBuf| path.file_stem().unwrap().to_string_lossy().into_owned();
        let entries: Vec<String> =
            names.map(stem).filter(|name| room != "cli" || !commands.contains(name)).collect();
        println!("entries directly in src/{room}: {}", entries.len());
        if entries.len() > most {
            bad.push(format!("src/{room}: {} entries, at most {most}: {entries:?}", entries.len()));
        }
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

/// The violations of planted files, which form a crate of their own.
fn findings(files: &[(&str, &str)]) -> Vec<String> {
    let sources: Vec<Source> =
        files.iter().map(|(file, text)| Source::parse(Path::new(file), text)).collect();
    let loops = Tree::new(&sources).loops().into_iter().map(|found| found.ties.join("\n"));
    sources.iter().flat_map(violations).chain(loops).collect()
}

/// A planted file, and the violation that must be found.
const PLANTED: [(&str, &str); 27] = [
    ("src/gauge/edges.rs", "use crate::render::Renderer;"),
    ("src/gauge/edges.rs", "fn f() { let x = crate::truth::station(); }"),
    ("src/gauge/edges.rs", "use crate::shaft::Shaft;"),
    ("src/gauge/edges.rs", "use super::super::render::Renderer;"),
    ("src/gauge/edges.rs", "pub use crate::render::Renderer as Other;"),
    ("src/gauge/edges.rs", "mod inner { use super::super::super::control::Law; }"),
    ("src/gauge/edges.rs", "#[derive(Serialize)] #[serde(with = \"crate::source::depth\")] struct A;"),
    ("src/gauge/edges.rs", "fn f() { vec![crate::{probe::Touch, frame::Frame}]; }"),
    ("src/control/pid.rs", "use crate::{plan::PassPlan, process::Pass};"),
    ("src/control/pid.rs", "fn f() { println!(\"{}\", crate::truth::X); }"),
    ("src/control/pid.rs", "impl crate::gauge::Reads for Pid {}"),
    ("src/frame.rs", "use crate::gauge::Gauge;"),
    ("src/frame.rs", "use crate::plan::ScanPlan;"),
    ("src/render/twin.rs", "use wgpu::Device;"),
    ("src/source/follow.rs", "fn f() { viva_genicam::blocking::discover(wait()); }"),
    ("src/render/kernel/cpu.rs", "use super::super::scene::Scene;"),
    ("src/render/kernel/cpu.rs", "use crate::render::FrameRequest;"),
    ("src/render/optics/lens/mod.rs", "macro_rules! m { () => { $crate::render::gpu::open() } }"),
    ("src/render/other.rs", "fn f() {}\nuse crate::frame::Frame;"),
    ("src/cli/measure/mod.rs", "use crate::cli::study::run;"),
    ("src/closed_loop.rs", "use crate::process::CutSummary;"),
    ("src/closed_loop/scan.rs", "fn f(camera: &crate::render::settings::Camera) {}"),
    ("src/job.rs", "fn f(cell: &dyn crate::cell::TurningCell) {}"),
    ("src/process/beam.rs", "fn f() { std::fs::read(\"x\"); }"),
    ("src/studies/mc.rs", "use crate::config::Config;"),
    ("src/run_folder/mod.rs", "use crate::report::write;"),
    ("src/elsewhere/mod.rs", "fn f() {}"),
];

/// Files that import each other, in every form of an import.
const LOOPS: [&[(&str, &str)]; 8] = [
    // `use` of a sibling
    &[
        ("src/source/a.rs", "use super::b::B; pub struct A;"),
        ("src/source/b.rs", "use super::a::A; pub struct B;"),
    ],
    // a path in a body
    &[
        ("src/source/a.rs", "pub fn f() { crate::source::b::g() }"),
        ("src/source/b.rs", "pub fn g() { super::a::f() }"),
    ],
    // over three files
    &[
        ("src/source/a.rs", "use super::b::B; pub struct A;"),
        ("src/source/b.rs", "use super::c::C; pub struct B;"),
        ("src/source/c.rs", "use super::a::A; pub struct C;"),
    ],
    // through a re-export of the room's mod.rs
    &[
        ("src/source/mod.rs", "mod a; pub use a::A; pub struct B;"),
        ("src/source/a.rs", "use super::B; pub struct A;"),
    ],
    // a sibling by way of mod.rs
    &[
        ("src/source/mod.rs", "mod a; mod b; pub use self::a::A; pub use b::*;"),
        ("src/source/a.rs", "pub struct A;"),
        ("src/source/b.rs", "use super::A; pub struct B;"),
    ],
    // a re-export under another name, from another room's folder
    &[
        ("src/source/ring/mod.rs", "mod r; pub use r::R as Other;"),
        ("src/source/ring/r.rs", "use crate::source::a::A; pub struct R;"),
        ("src/source/a.rs", "use super::ring::Other; pub struct A;"),
    ],
    // in the tokens of a macro call
    &[
        ("src/source/a.rs", "use super::b::B; pub fn f() {}"),
        ("src/source/b.rs", "pub struct B; fn g() { assert!(super::a::f() == 1) }"),
    ],
    // a macro by its bare name
    &[
        ("src/cli/process/mod.rs", "use super::failure::Failure; macro_rules! say { () => {} }"),
        ("src/cli/failure.rs", "pub struct Failure; fn f() { say!() }"),
    ],
];

#[test]
fn planted_violations_are_found() {
    for (file, source) in PLANTED {
        assert!(!findings(&[(file, source)]).is_empty(), "not found: {file}: {source}");
    }
    for files in LOOPS {
        assert!(!findings(files).is_empty(), "not found: {files:?}");
        // Only because of the loop: without its last file there is no violation.
        let first: Vec<_> = files[..files.len() - 1].to_vec();
        assert_eq!(findings(&first), Vec::<String>::new(), "{first:?}");
    }
}

#[test]
fn imports_that_are_allowed_pass() {
    let allowed = [
        (
            "src/gauge/edge/stream.rs",
            "use crate::frame::FrameView; use super::side::Side; use crate::gauge::edges::Edge;",
        ),
        ("src/render/gpu/mod.rs", "use wgpu::Device; use crate::render::kernel::Job; pub(super) fn f() {}"),
        ("src/render/kernel/cpu.rs", "use super::params::Params; mod tests { use super::*; }"),
        ("src/cli/run/mod.rs", "use crate::report::write; use std::fs;"),
        ("src/truth.rs", "use crate::render::silhouette; use crate::shaft::Shaft;"),
        ("src/closed_loop.rs", "use crate::cell::TurningCell; fn f() { scan.next(); }"),
    ];
    for (file, source) in allowed {
        assert_eq!(findings(&[(file, source)]), Vec::<String>::new(), "{file}: {source}");
    }
    let chain = [
        ("src/source/mod.rs", "mod a; mod b; pub use a::A; pub use b::B;"),
        ("src/source/a.rs", "pub struct A;"),
        ("src/source/b.rs", "use super::a::A; pub struct B; mod tests { use super::*; }"),
        ("src/truth.rs", "use crate::source::{A, B};"),
    ];
    assert_eq!(findings(&chain), Vec::<String>::new());
}

#[test]
fn files_stay_readable() {
    let lines: BTreeMap<PathBuf, usize> =
        texts().into_iter().map(|(file, text)| (file, text.lines().count())).collect();
    let long: Vec<String> = lines
        .iter()
        .filter(|(_, lines)| **lines > 600)
        .map(|(f, lines)| format!("{}: {lines} lines (one idea a file; 600 at most)", f.display()))
        .collect();
    assert!(long.is_empty(), "{}", long.join("\n"));
}
