//! What the tests read of a Markdown document.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A document with its path from the crate's root.
pub struct Document {
    pub path: PathBuf,
    pub text: String,
}

/// A fenced block.
pub struct Block {
    pub language: String,
    /// Text of the HTML comment on the line above.
    pub mark: String,
    pub lines: Vec<String>,
}

pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All documents: those of the root and those of the book.
pub fn documents() -> Vec<Document> {
    let mut paths = Vec::new();
    below(root(), false, &mut paths);
    below(&root().join("docs"), true, &mut paths);
    paths.sort();
    let read = |path: PathBuf| Document {
        text: std::fs::read_to_string(&path).unwrap(),
        path: path.strip_prefix(root()).unwrap().to_owned(),
    };
    paths.into_iter().map(read).collect()
}

fn below(folder: &Path, deep: bool, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() && deep {
            below(&path, deep, found);
        } else if path.extension().is_some_and(|e| e == "md") {
            found.push(path);
        }
    }
}

/// The fenced blocks of a text.
pub fn blocks(text: &str) -> Vec<Block> {
    let mut found: Vec<Block> = Vec::new();
    let (mut above, mut is_open) = ("", false);
    for line in text.lines() {
        if let Some(language) = line.trim_start().strip_prefix("```") {
            if !is_open {
                let mark = above.trim().trim_start_matches("<!--").trim_end_matches("-->").trim();
                let mark = if above.trim().starts_with("<!--") { mark } else { "" };
                found.push(Block { language: language.to_owned(), mark: mark.to_owned(), lines: Vec::new() });
            }
            is_open = !is_open;
        } else if let Some(block) = found.last_mut().filter(|_| is_open) {
            block.lines.push(line.to_owned());
        }
        above = line;
    }
    found
}

/// The lines outside of fenced blocks.
pub fn prose(text: &str) -> impl Iterator<Item = &str> {
    let mut is_open = false;
    text.lines().filter(move |line| {
        let is_fence = line.trim_start().starts_with("```");
        is_open ^= is_fence;
        !is_open && !is_fence
    })
}

/// The code in backticks of a text, outside of fenced blocks.
pub fn spans(text: &str) -> Vec<String> {
    // A span may run over the end of a line, never over an empty line.
    let joined =
        prose(text).map(|l| if l.trim().is_empty() { "\n" } else { l }).collect::<Vec<_>>().join(" ");
    joined
        .split('\n')
        .flat_map(|paragraph| paragraph.split('`').skip(1).step_by(2))
        .map(str::to_owned)
        .collect()
}

/// Targets of the links and pictures of a text.
pub fn links(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for line in prose(text) {
        let plain: String = line.split('`').step_by(2).collect();
        for part in plain.split("](").skip(1) {
            found.extend(part.split_once(')').map(|(target, _)| target.to_owned()));
        }
    }
    found
}

/// Anchors of the headings of a text, as GitHub and mdBook make them.
pub fn anchors(text: &str) -> Vec<String> {
    let mut times: BTreeMap<String, usize> = BTreeMap::new();
    let mut found = Vec::new();
    for heading in prose(text).filter(|line| line.starts_with('#')) {
        let heading = heading.trim_start_matches('#').trim().to_lowercase();
        let kept: String =
            heading.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_')).collect();
        let slug = kept.replace(' ', "-");
        let count = times.entry(slug.clone()).or_default();
        found.push(if *count == 0 { slug } else { format!("{slug}-{count}") });
        *count += 1;
    }
    found
}
