//! The direction of imports is itself a test: every path of every source file is parsed (not only `use` lines), and
//! planted violations must be found.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use std::path::{Path, PathBuf};

use proc_macro2::{TokenStream, TokenTree};
use syn::visit::{self, Visit};

/// Rooms by layer; a file imports lower layers and its own room (layer 3: its whole layer).
const VOCABULARY: [&str; 6] = ["frame", "shaft", "profile", "plan", "conformity", "numerics"];
const STAGES: [&str; 9] =
    ["process", "render", "gauge", "probe", "control", "source", "nc", "tool", "machine"];
const COMPOSITION: [&str; 5] = ["truth", "cell", "job", "closed_loop", "studies"];
const SURFACE: [&str; 6] = ["config", "files", "run_folder", "report", "cli", "main"];
/// The instrument must not see what only the simulation knows.
const INSTRUMENT: [&str; 5] = ["gauge", "probe", "control", "nc", "source"];
const FILE_SYSTEM_ROOMS: [&str; 5] = ["source", "files", "run_folder", "config", "cli"];

fn layer(room: &str) -> Option<usize> {
    [&VOCABULARY[..], &STAGES[..], &COMPOSITION[..], &SURFACE[..]]
        .iter()
        .position(|rooms| rooms.contains(&room))
}

fn may_import(from: &str, to: &str) -> bool {
    if from == to || from == "lib" {
        return true;
    }
    let (Some(a), Some(b)) = (layer(from), layer(to)) else { return false };
    if INSTRUMENT.contains(&from) && to == "shaft" {
        return false;
    }
    match a {
        0 => b == 0,
        1 => b == 0,
        2 => b <= 2,
        _ => b <= 3,
    }
}

/// Every path of a file, as segments, `super::` and `self::` resolved against the module's own path.
struct Paths {
    module: Vec<String>,
    found: Vec<Vec<String>>,
}

impl Paths {
    fn push(&mut self, segments: &[String]) {
        let mut module = self.module.clone();
        let mut rest = segments;
        let mut relative = false;
        while let Some(first) = rest.first() {
            match first.as_str() {
                "super" => {
                    module.pop();
                }
                "self" => {}
                _ => break,
            }
            relative = true;
            rest = &rest[1..];
        }
        if relative {
            let mut full = vec!["crate".to_owned()];
            full.extend(module);
            full.extend(rest.iter().cloned());
            self.found.push(full);
        } else {
            self.found.push(segments.to_vec());
        }
    }

    fn use_tree(&mut self, prefix: &[String], tree: &syn::UseTree) {
        let with = |name: String| [prefix, &[name]].concat();
        match tree {
            syn::UseTree::Path(p) => self.use_tree(&with(p.ident.to_string()), &p.tree),
            syn::UseTree::Name(n) => self.push(&with(n.ident.to_string())),
            syn::UseTree::Rename(r) => self.push(&with(r.ident.to_string())),
            syn::UseTree::Glob(_) => self.push(prefix),
            syn::UseTree::Group(g) => g.items.iter().for_each(|t| self.use_tree(prefix, t)),
        }
    }

    /// Paths inside macro calls, which the parser leaves as tokens.
    fn tokens(&mut self, stream: TokenStream) {
        let mut path: Vec<String> = Vec::new();
        let mut colons = 0;
        for token in stream {
            match token {
                TokenTree::Ident(i) => {
                    if colons < 2 && !path.is_empty() {
                        self.push(&std::mem::take(&mut path));
                    }
                    path.push(i.to_string());
                    colons = 0;
                }
                TokenTree::Punct(p) if p.as_char() == ':' => colons += 1,
                TokenTree::Group(g) => {
                    self.push(&std::mem::take(&mut path));
                    self.tokens(g.stream());
                    colons = 0;
                }
                _ => {
                    self.push(&std::mem::take(&mut path));
                    colons = 0;
                }
            }
        }
        self.push(&path);
    }
}

impl<'ast> Visit<'ast> for Paths {
    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        self.use_tree(&[], &item.tree);
    }
    fn visit_path(&mut self, path: &'ast syn::Path) {
        let segments: Vec<String> = path.segments.iter().map(|s| s.ident.to_string()).collect();
        self.push(&segments);
        visit::visit_path(self, path);
    }
    fn visit_macro(&mut self, mac: &'ast syn::Macro) {
        self.tokens(mac.tokens.clone());
        visit::visit_macro(self, mac);
    }
    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        self.module.push(item.ident.to_string());
        visit::visit_item_mod(self, item);
        self.module.pop();
    }
}

/// Module path of `src/render/gpu/mod.rs` -> [render, gpu]; `src/frame.rs` -> [frame]; `src/lib.rs` -> [].
fn module_of(file: &Path) -> Vec<String> {
    let mut parts: Vec<String> =
        file.with_extension("").iter().skip(1).map(|p| p.to_string_lossy().into_owned()).collect();
    if parts.last().is_some_and(|p| p == "mod" || p == "lib") {
        parts.pop();
    }
    parts
}

fn violations(file: &Path, source: &str) -> Vec<String> {
    let parsed = syn::parse_file(source).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let module = module_of(file);
    let room = module.first().cloned().unwrap_or_else(|| "lib".to_owned());
    let mut paths = Paths { module, found: Vec::new() };
    paths.visit_file(&parsed);
    let mut bad = Vec::new();
    if layer(&room).is_none() && room != "lib" {
        bad.push(format!("{}: room '{room}' belongs to no layer", file.display()));
    }
    for path in &paths.found {
        let text = path.join("::");
        let first = path.first().map(String::as_str);
        if matches!(first, Some("crate" | "shadowgauge"))
            && path.len() > 1
            && layer(&path[1]).is_some()
            && !may_import(&room, &path[1])
        {
            bad.push(format!("{}: {room} must not import {text}", file.display()));
        }
        let in_gpu = file.to_string_lossy().contains("src/render/gpu");
        if first == Some("wgpu") && !in_gpu {
            bad.push(format!("{}: wgpu belongs under src/render/gpu*: {text}", file.display()));
        }
        let is_fs =
            path.len() > 1 && path[0] == "std" && path[1] == "fs" || first == Some("fs") && path.len() > 1;
        if is_fs && !FILE_SYSTEM_ROOMS.contains(&room.as_str()) {
            bad.push(format!("{}: std::fs belongs to {FILE_SYSTEM_ROOMS:?}: {text}", file.display()));
        }
    }
    bad
}

fn sources(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, into);
        } else if path.extension().is_some_and(|e| e == "rs") {
            into.push(path);
        }
    }
}

#[test]
fn imports_flow_one_way() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    sources(&root.join("src"), &mut files);
    assert!(files.len() > 10, "only {} source files found", files.len());
    let bad: Vec<String> = files
        .iter()
        .flat_map(|file| {
            violations(file.strip_prefix(root).unwrap(), &std::fs::read_to_string(file).unwrap())
        })
        .collect();
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

#[test]
fn planted_violations_are_found() {
    let planted = [
        ("src/gauge/edges.rs", "use crate::render::Renderer;"),
        ("src/gauge/edges.rs", "fn f() { let x = crate::truth::station(); }"),
        ("src/gauge/edges.rs", "use crate::shaft::Shaft;"),
        ("src/gauge/edges.rs", "use super::super::render::Renderer;"),
        ("src/control/pid.rs", "use crate::{plan::PassPlan, process::Pass};"),
        ("src/control/pid.rs", "fn f() { println!(\"{}\", crate::truth::X); }"),
        ("src/frame.rs", "use crate::gauge::Gauge;"),
        ("src/render/twin.rs", "use wgpu::Device;"),
        ("src/process/beam.rs", "fn f() { std::fs::read(\"x\"); }"),
        ("src/studies/mc.rs", "use crate::config::Config;"),
        ("src/elsewhere/mod.rs", "fn f() {}"),
    ];
    for (file, source) in planted {
        assert!(!violations(Path::new(file), source).is_empty(), "not found: {file}: {source}");
    }
    let allowed = [
        (
            "src/gauge/edges.rs",
            "use crate::frame::FrameView; use super::model::Edge; use crate::gauge::x::Y;",
        ),
        ("src/render/gpu/mod.rs", "use wgpu::Device;"),
        ("src/cli/run.rs", "use crate::report::write; use std::fs;"),
        ("src/truth.rs", "use crate::render::silhouette; use crate::shaft::Shaft;"),
    ];
    for (file, source) in allowed {
        assert_eq!(violations(Path::new(file), source), Vec::<String>::new(), "{file}: {source}");
    }
}

#[test]
fn files_stay_readable() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    sources(&root.join("src"), &mut files);
    let long: Vec<String> = files
        .iter()
        .filter_map(|f| {
            let lines = std::fs::read_to_string(f).unwrap().lines().count();
            (lines > 600).then(|| format!("{}: {lines} lines (one idea a file; 600 at most)", f.display()))
        })
        .collect();
    assert!(long.is_empty(), "{}", long.join("\n"));
}
