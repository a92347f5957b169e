//! Imports of the source files, from every path in them (not only `use` lines), and the file that
//! each path names.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use proc_macro2::{TokenStream, TokenTree};
use syn::visit::{self, Visit};

/// Every path of a file, as segments, `super::` and `self::` resolved against the module's own
/// path.
struct Paths {
    module: Vec<String>,
    /// Depth of inline modules (`mod tests { … }`).
    inline: usize,
    found: Vec<Vec<String>>,
    /// Names bound by `use` at the top of the file, with their paths; globs under "*".
    bindings: Vec<(String, Vec<String>)>,
    /// Items that the file defines at its top.
    items: BTreeSet<String>,
    macros: BTreeSet<String>,
    macro_calls: BTreeSet<String>,
}

impl Paths {
    /// A path from the crate's root where it is relative; the same path otherwise.
    fn absolute(&self, segments: &[String]) -> Vec<String> {
        let mut module = self.module.clone();
        let mut rest = segments;
        while let Some(first) = rest.first() {
            match first.as_str() {
                "super" => drop(module.pop()),
                "self" => {}
                _ => break,
            }
            rest = &rest[1..];
        }
        if rest.len() == segments.len() {
            return segments.to_vec();
        }
        [&["crate".to_owned()], &module[..], rest].concat()
    }

    fn push(&mut self, segments: &[String]) {
        if !segments.is_empty() {
            self.found.push(self.absolute(segments));
        }
    }

    fn used(&mut self, name: &str, segments: &[String]) {
        match segments {
            [only] if only != "self" && only != "super" => self.push(&["self".to_owned(), only.clone()]),
            _ => self.push(segments),
        }
        if self.inline == 0 {
            self.bindings.push((name.to_owned(), self.absolute(segments)));
        }
    }

    fn use_tree(&mut self, prefix: &[String], tree: &syn::UseTree) {
        let with = |name: String| [prefix, &[name]].concat();
        match tree {
            syn::UseTree::Path(p) => self.use_tree(&with(p.ident.to_string()), &p.tree),
            syn::UseTree::Name(n) if n.ident == "self" => {
                let name = prefix.last().cloned().unwrap_or_default();
                self.used(&name, prefix);
            }
            syn::UseTree::Name(n) => self.used(&n.ident.to_string(), &with(n.ident.to_string())),
            syn::UseTree::Rename(r) if r.ident == "self" => self.used(&r.rename.to_string(), prefix),
            syn::UseTree::Rename(r) => self.used(&r.rename.to_string(), &with(r.ident.to_string())),
            syn::UseTree::Glob(_) => self.used("*", prefix),
            syn::UseTree::Group(g) => g.items.iter().for_each(|t| self.use_tree(prefix, t)),
        }
    }

    /// Paths inside macro calls and attributes, which the parser leaves as tokens.
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
                TokenTree::Punct(p) if p.as_char() == '!' && path.len() == 1 => {
                    self.macro_calls.insert(path.remove(0));
                    colons = 0;
                }
                TokenTree::Group(g) => {
                    // `a::{b, c}`: every path of the group continues the one before it.
                    let before = std::mem::take(&mut path);
                    self.push(&before);
                    let (known, prefix) = (self.found.len(), if colons == 2 { before } else { Vec::new() });
                    self.tokens(g.stream());
                    if !prefix.is_empty() {
                        let inner: Vec<_> = self.found.drain(known..).collect();
                        inner.iter().for_each(|rest| self.push(&[&prefix[..], rest].concat()));
                    }
                    colons = 0;
                }
                other => {
                    self.push(&std::mem::take(&mut path));
                    if let TokenTree::Literal(text) = other {
                        self.text(&text.to_string());
                    }
                    colons = 0;
                }
            }
        }
        self.push(&path);
    }

    /// A path in a string, as in `#[serde(with = "crate::a")]`.
    fn text(&mut self, literal: &str) {
        let path = literal.trim_matches('"');
        if path.starts_with("crate::") || path.starts_with("super::") {
            let segments: Vec<String> = path.split("::").map(str::to_owned).collect();
            self.push(&segments);
        }
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
    /// `pub(super)` imports nothing.
    fn visit_vis_restricted(&mut self, _: &'ast syn::VisRestricted) {}
    fn visit_macro(&mut self, mac: &'ast syn::Macro) {
        if let Some(name) = mac.path.get_ident() {
            self.macro_calls.insert(name.to_string());
        }
        self.tokens(mac.tokens.clone());
        visit::visit_macro(self, mac);
    }
    fn visit_meta_list(&mut self, list: &'ast syn::MetaList) {
        self.tokens(list.tokens.clone());
        visit::visit_meta_list(self, list);
    }
    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        self.module.push(item.ident.to_string());
        self.inline += 1;
        visit::visit_item_mod(self, item);
        self.inline -= 1;
        self.module.pop();
    }
}

fn name_of(item: &syn::Item) -> Option<String> {
    Some(match item {
        syn::Item::Const(i) => i.ident.to_string(),
        syn::Item::Enum(i) => i.ident.to_string(),
        syn::Item::Fn(i) => i.sig.ident.to_string(),
        syn::Item::Mod(i) if i.content.is_some() => i.ident.to_string(),
        syn::Item::Static(i) => i.ident.to_string(),
        syn::Item::Struct(i) => i.ident.to_string(),
        syn::Item::Trait(i) => i.ident.to_string(),
        syn::Item::Type(i) => i.ident.to_string(),
        syn::Item::Union(i) => i.ident.to_string(),
        _ => return None,
    })
}

/// Module path of `src/render/gpu/mod.rs` -> [render, gpu]; `src/frame.rs` -> [frame];
/// `src/lib.rs` -> [].
fn module_of(file: &Path) -> Vec<String> {
    let mut parts: Vec<String> =
        file.with_extension("").iter().skip(1).map(|p| p.to_string_lossy().into_owned()).collect();
    if parts.last().is_some_and(|p| p == "mod" || p == "lib") {
        parts.pop();
    }
    parts
}

/// A source file and its imports.
pub struct Source {
    pub file: PathBuf,
    pub module: Vec<String>,
    /// Every path in it, from the crate's root where it is relative.
    pub paths: Vec<Vec<String>>,
    bindings: Vec<(String, Vec<String>)>,
    items: BTreeSet<String>,
    macros: BTreeSet<String>,
    macro_calls: BTreeSet<String>,
}

impl Source {
    pub fn parse(file: &Path, text: &str) -> Self {
        let parsed = syn::parse_file(text).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        let module = module_of(file);
        let mut paths = Paths {
            module: module.clone(),
            inline: 0,
            found: Vec::new(),
            bindings: Vec::new(),
            items: parsed.items.iter().filter_map(name_of).collect(),
            macros: BTreeSet::new(),
            macro_calls: BTreeSet::new(),
        };
        paths.macros = parsed
            .items
            .iter()
            .filter_map(|item| match item {
                syn::Item::Macro(m) => m.ident.as_ref().map(ToString::to_string),
                _ => None,
            })
            .collect();
        paths.visit_file(&parsed);
        let Paths { found, bindings, items, macros, macro_calls, .. } = paths;
        Self { file: file.to_owned(), module, paths: found, bindings, items, macros, macro_calls }
    }
}

/// The files of a crate, by module path.
pub struct Tree<'a> {
    sources: &'a [Source],
    by_module: BTreeMap<&'a [String], usize>,
}

/// Longest chain of re-exports that is followed.
const CHAIN: usize = 12;

impl<'a> Tree<'a> {
    pub fn new(sources: &'a [Source]) -> Self {
        let by_module = sources.iter().enumerate().map(|(i, s)| (&s.module[..], i)).collect();
        Self { sources, by_module }
    }

    /// The file that defines the item named by `path` in file `from`; `via` receives the files that
    /// re-export it.
    fn resolve(&self, from: usize, path: &[String], via: &mut Vec<usize>) -> Option<usize> {
        if via.len() > CHAIN {
            return None;
        }
        let (mut module, rest) = match path.first()?.as_str() {
            "crate" | "shadowgauge" => (Vec::new(), &path[1..]),
            _ => (self.sources[from].module.clone(), path),
        };
        let is_bare = rest.len() == path.len();
        for (i, segment) in rest.iter().enumerate() {
            let inner = [&module[..], std::slice::from_ref(segment)].concat();
            // A file, or a folder of files.
            let first_inside = self.by_module.range(&inner[..]..).next();
            if first_inside.is_some_and(|(known, _)| known.starts_with(&inner)) {
                module = inner;
                continue;
            }
            let &at = self.by_module.get(&module[..])?;
            return self.in_file(at, segment, &rest[i + 1..], via).or((!is_bare || i > 0).then_some(at));
        }
        self.by_module.get(&module[..]).copied()
    }

    /// As [`Self::resolve`], for a name in file `at`.
    fn in_file(&self, at: usize, name: &str, rest: &[String], via: &mut Vec<usize>) -> Option<usize> {
        let source = &self.sources[at];
        if via.len() > CHAIN {
            return None;
        }
        if source.items.contains(name) || source.macros.contains(name) {
            return Some(at);
        }
        let go = |target: &[String], via: &mut Vec<usize>| {
            // A name bound to itself is an external crate's.
            let is_external = target.first().is_some_and(|first| first == name);
            via.push(at);
            if is_external && !self.by_module.contains_key(&[&source.module[..], &target[..1]].concat()[..]) {
                return None;
            }
            self.resolve(at, target, via)
        };
        if let Some((_, target)) = source.bindings.iter().find(|(bound, _)| bound == name) {
            return go(&[target, rest].concat(), via);
        }
        source.bindings.iter().filter(|(bound, _)| bound == "*").find_map(|(_, target)| {
            let known = via.len();
            via.push(at);
            let file = self.resolve(at, target, via)?;
            let found = (file != at).then(|| self.in_file(file, name, rest, via)).flatten();
            if found.is_none() {
                via.truncate(known);
            }
            found
        })
    }

    /// Which files each file imports, with one path for each. A name that a folder's `mod.rs`
    /// re-exports counts as the file that defines it, but inside that folder also as `mod.rs`,
    /// because files must import their siblings by their own path.
    pub fn imports(&self) -> Vec<BTreeMap<usize, String>> {
        let mut edges = vec![BTreeMap::new(); self.sources.len()];
        for (from, source) in self.sources.iter().enumerate() {
            for path in source.paths.iter().filter(|path| path.len() > 1) {
                let mut via = Vec::new();
                let Some(to) = self.resolve(from, path, &mut via) else { continue };
                let parents = via.into_iter().filter(|&g| {
                    let parent = &self.sources[g].module;
                    parent.len() < source.module.len() && source.module.starts_with(parent)
                });
                for file in parents.chain([to]).filter(|&file| file != from) {
                    edges[from].entry(file).or_insert_with(|| path.join("::"));
                }
            }
            for name in &source.macro_calls {
                let defined = |s: &Source| s.macros.contains(name);
                if let Some(to) = self.sources.iter().position(defined).filter(|_| !defined(source)) {
                    edges[from].entry(to).or_insert_with(|| format!("{name}!"));
                }
            }
        }
        edges
    }

    /// Loops: groups of files each of which imports, directly or through others, every other; as
    /// text, one import per line.
    pub fn loops(&self) -> Vec<Loop> {
        let edges = self.imports();
        let reach: Vec<BTreeSet<usize>> = (0..edges.len())
            .map(|start| {
                let (mut seen, mut open) = (BTreeSet::new(), vec![start]);
                while let Some(at) = open.pop() {
                    open.extend(edges[at].keys().copied().filter(|&to| seen.insert(to)));
                }
                seen
            })
            .collect();
        let mut done = BTreeSet::new();
        let mut loops = Vec::new();
        for (start, reached) in reach.iter().enumerate() {
            if !reached.contains(&start) || !done.insert(start) {
                continue;
            }
            let group: Vec<usize> = reached.iter().copied().filter(|&f| reach[f].contains(&start)).collect();
            done.extend(&group);
            let name = |file: usize| self.sources[file].file.to_string_lossy().into_owned();
            let ties = group.iter().flat_map(|&from| {
                let inside = edges[from].iter().filter(|(to, _)| group.contains(to));
                inside.map(move |(&to, path)| format!("  {} -> {}: {path}", name(from), name(to)))
            });
            loops.push(Loop { ties: ties.collect(), files: group.iter().map(|&file| name(file)).collect() });
        }
        loops
    }
}

/// Files that import each other.
pub struct Loop {
    pub files: Vec<String>,
    pub ties: Vec<String>,
}
