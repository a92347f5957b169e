//! No dead links, a short README, a complete table of contents.

use std::path::Path;

use super::markdown::{anchors, documents, links, root, spans};

/// Most lines of README.md: what fits on three screens.
const README_LINES: usize = 120;

/// Why a link of the document at `path` (from the root) is dead.
fn dead(path: &Path, text: &str, link: &str) -> Option<String> {
    if link.starts_with("http://") || link.starts_with("https://") {
        return None;
    }
    let (file, anchor) = link.split_once('#').map_or((link, None), |(file, anchor)| (file, Some(anchor)));
    let target = root().join(path.parent().unwrap_or(Path::new(""))).join(file);
    if !file.is_empty() && !target.exists() {
        return Some(format!("{}: {link}: no such file", path.display()));
    }
    let other =
        if file.is_empty() { text.to_owned() } else { std::fs::read_to_string(target).unwrap_or_default() };
    let is_there = anchor.is_none_or(|anchor| anchors(&other).iter().any(|known| known == anchor));
    (!is_there).then(|| format!("{}: {link}: no such heading", path.display()))
}

#[test]
fn no_link_is_dead() {
    let mut found = 0;
    let mut bad = Vec::new();
    for document in documents() {
        for link in links(&document.text) {
            found += 1;
            bad.extend(dead(&document.path, &document.text, &link));
        }
    }
    assert!(found > 50, "only {found} links found");
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

#[test]
fn planted_dead_links_are_found() {
    let text = "# A `b`\n[x](README.md) [y](#a-b) [z](#c) ![p](docs/none.svg)\n```\n[q](gone.md)\n```\n`[r](gone.md)`\n";
    let links = links(text);
    assert_eq!(links, ["README.md", "#a-b", "#c", "docs/none.svg"]);
    let dead = links.iter().filter_map(|link| dead(Path::new("X.md"), text, link)).count();
    assert_eq!(dead, 2);
}

/// Folders whose files the documents name by their path.
const FOLDERS: [&str; 7] = ["src/", "tests/", "configs/", "scripts/", "benches/", "docs/", "shaders/"];

#[test]
fn files_named_in_code_exist() {
    let mut bad = Vec::new();
    // The changelog names what was, too.
    for document in documents().iter().filter(|d| d.path != Path::new("CHANGELOG.md")) {
        for span in spans(&document.text) {
            let name = span.split(' ').next().unwrap_or_default();
            let is_path = FOLDERS.iter().any(|folder| name.starts_with(folder)) && !name.contains('*');
            if is_path && !root().join(name).exists() {
                bad.push(format!("{}: `{name}`", document.path.display()));
            }
        }
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

#[test]
fn readme_is_short() {
    let text = std::fs::read_to_string(root().join("README.md")).unwrap();
    assert!(text.lines().count() <= README_LINES, "{} lines", text.lines().count());
}

#[test]
fn the_contents_list_every_page() {
    let summary = std::fs::read_to_string(root().join("docs/SUMMARY.md")).unwrap();
    let listed = links(&summary);
    for document in documents() {
        let Ok(page) = document.path.strip_prefix("docs") else { continue };
        let page = page.to_str().unwrap();
        assert!(page == "SUMMARY.md" || listed.iter().any(|l| l == page), "{page} is not in docs/SUMMARY.md");
    }
}
