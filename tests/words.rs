//! Comments of the sources describe the computation: words that treat code as a person, or that
//! metrology has another term for, are refused. Doc comments that reach users (the schema's and the
//! command line's) are excluded: those texts are part of the interface.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use std::path::{Path, PathBuf};

/// Refused words, each with the term to use.
const REFUSED: [(&str, &str); 54] = [
    ("matter", "contamination"),
    ("soil", "contamination"),
    ("soils", "contaminates"),
    ("soiled", "contaminated"),
    ("soiling", "contamination"),
    ("dirt", "contamination"),
    ("dirty", "contaminated"),
    ("hill", "local bump"),
    ("hills", "local bumps"),
    ("bulge", "protrusion"),
    ("bulges", "protrudes"),
    ("dent", "recess"),
    ("dents", "recesses"),
    ("wander", "centreline waviness"),
    ("wanders", "centreline waviness"),
    ("wandering", "centreline waviness"),
    ("teach", "accumulate"),
    ("teaches", "accumulate"),
    ("taught", "accumulated"),
    ("lesson", "samples, residuals"),
    ("told", "given, estimated"),
    ("tell", "determine, separate"),
    ("tells", "determines, separates"),
    ("know", "what is given"),
    ("knows", "what is given"),
    ("believe", "measure, accept"),
    ("believes", "measures, accepts"),
    ("believed", "measured, accepted"),
    ("believable", "plausible"),
    ("vouch", "confirm"),
    ("vouches", "confirms"),
    ("say", "state, imply"),
    ("says", "states, implies"),
    ("said", "stated"),
    ("foot", "base"),
    ("feast", "-"),
    ("heal", "interpolate"),
    ("heals", "interpolates"),
    ("price", "penalty"),
    ("cheap", "small cost"),
    ("cheaper", "less cost"),
    ("cheapest", "least cost"),
    ("dearer", "more cost"),
    ("misfit", "systematic residual, reduced χ²"),
    ("misfits", "systematic residuals"),
    ("vague", "uncertain"),
    ("veil", "stray light, film"),
    ("descent", "extent"),
    ("nobody", "none"),
    ("yardstick", "reference"),
    ("swallowed", "part of"),
    ("seriously", "the limit"),
    ("lucky", "biased"),
    ("bench", "optical setup"),
];

/// Lines that may contain such a word: the end of the file's path and a part of the line.
const ALLOWED: [(&str, &str); 0] = [];

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// Text of a line that is a comment.
fn comment(line: &str) -> Option<&str> {
    let text = line.trim_start().strip_prefix("//")?;
    Some(text.trim_start_matches(['/', '!']))
}

/// Doc comments of items with a derived schema or command line, by line.
fn for_users(lines: &[&str]) -> Vec<bool> {
    let mut marked = vec![false; lines.len()];
    let doc = |line: &str| line.trim_start().starts_with("///");
    let mut from = 0;
    while let Some(derive) = (from..lines.len()).find(|k| lines[*k].trim_start().starts_with("#[derive(")) {
        let end = (derive..lines.len()).find(|k| lines[*k].contains(")]")).unwrap_or(lines.len() - 1);
        from = end + 1;
        let derived = lines[derive..=end].concat();
        let names = ["JsonSchema", "Args", "Parser", "Subcommand", "ValueEnum"];
        if !derived.split(|c: char| !c.is_alphanumeric()).any(|word| names.contains(&word)) {
            continue;
        }
        let above =
            (0..derive).rev().take_while(|k| doc(lines[*k]) || lines[*k].trim_start().starts_with("#["));
        above.filter(|k| doc(lines[*k])).for_each(|k| marked[k] = true);
        let (mut depth, mut opened) = (0_i64, false);
        while from < lines.len() {
            let line = lines[from].trim();
            marked[from] = doc(line);
            if !line.starts_with("//") {
                depth += line.matches('{').count() as i64 - line.matches('}').count() as i64;
                opened |= line.contains('{');
            }
            from += 1;
            if !line.starts_with("//") && (opened && depth <= 0 || !opened && line.ends_with(';')) {
                break;
            }
        }
    }
    marked
}

/// The refused words of a comment, outside of code in backticks.
fn refused(text: &str) -> Vec<(&'static str, &'static str)> {
    let prose: String = text.split('`').step_by(2).collect::<Vec<_>>().join(" ").to_lowercase();
    let words: Vec<&str> = prose.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == '-')).collect();
    REFUSED.into_iter().filter(|(word, _)| words.contains(word)).collect()
}

/// Refused words of a source, as "path:line: word (term): text".
fn violations(path: &str, source: &str) -> Vec<String> {
    let lines: Vec<&str> = source.lines().collect();
    let users = for_users(&lines);
    let mut found = Vec::new();
    for (k, line) in lines.iter().enumerate().filter(|(k, _)| !users[*k]) {
        let allowed = ALLOWED.iter().any(|(end, part)| path.ends_with(end) && line.contains(part));
        for (word, term) in comment(line).filter(|_| !allowed).map(refused).unwrap_or_default() {
            found.push(format!("{path}:{}: '{word}' ({term}): {}", k + 1, line.trim()));
        }
    }
    found
}

#[test]
fn comments_name_quantities_and_do_not_act() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut paths = Vec::new();
    sources(&root.join("src"), &mut paths);
    assert!(paths.len() > 300, "{} sources", paths.len());
    let mut found = Vec::new();
    for path in paths {
        let name = path.strip_prefix(root).unwrap().display().to_string();
        found.extend(violations(&name, &std::fs::read_to_string(&path).unwrap()));
    }
    assert!(found.is_empty(), "{}\n{} refused words in comments", found.join("\n"), found.len());
}

/// Widest comment line, characters; lines of code may be wider (rustfmt.toml).
const COLUMNS: usize = 100;

/// Whether a comment can be broken: a table's row and a single word (an address) cannot.
fn is_breakable(text: &str) -> bool {
    let text = text.trim();
    !text.starts_with('|') && text.contains(char::is_whitespace)
}

/// Comment lines of a source wider than [`COLUMNS`], as "path:line: width: text".
fn too_wide(path: &str, source: &str) -> Vec<String> {
    let wide = source
        .lines()
        .enumerate()
        .filter(|(_, line)| line.chars().count() > COLUMNS && comment(line).is_some_and(is_breakable));
    wide.map(|(k, line)| format!("{path}:{}: {}: {}", k + 1, line.chars().count(), line.trim())).collect()
}

#[test]
fn comments_wrap() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut paths = Vec::new();
    ["src", "tests", "benches"].iter().for_each(|folder| sources(&root.join(folder), &mut paths));
    let mut found = Vec::new();
    for path in paths {
        let name = path.strip_prefix(root).unwrap().display().to_string();
        found.extend(too_wide(&name, &std::fs::read_to_string(&path).unwrap()));
    }
    assert!(found.is_empty(), "{}\n{} comment lines above {COLUMNS} columns", found.join("\n"), found.len());
}

#[test]
fn planted_wide_comments_are_found() {
    let found = |line: &str| too_wide("src/x.rs", line).len();
    let word = "µ".repeat(COLUMNS);
    assert_eq!(found(&format!("    // a {}", &word[..2 * (COLUMNS - 8)])), 1);
    assert_eq!(found(&format!("    // a {}", &word[..2 * (COLUMNS - 9)])), 0);
    assert_eq!(found(&format!("/// {}", "a ".repeat(48))), 0);
    assert_eq!(found(&format!("//! https://{word}")) + found(&format!("/// | {word} | b |")), 0);
    assert_eq!(found(&format!("let a = \"{word}\"; // b c")), 0);
}

#[test]
fn planted_words_are_found_and_users_texts_are_left_alone() {
    let found = |source: &str| violations("src/x.rs", source).len();
    assert_eq!(
        found("//! What a side says.\n/// A hill of Dirt.\nfn f() {\n    // It knows `misfit`.\n}\n"),
        4
    );
    assert_eq!(found("/// The key `misfit` and the cobalt-blue sky.\nlet url = \"https://say.it\";\n"), 0);
    let item = "/// What soils the view.\n#[derive(Clone, JsonSchema)]\n#[serde(default)]\npub struct A {\n    \
                /// Dirt.\n    pub a: f64,\n}\n/// Dirt.\nfn f() {}\n";
    assert_eq!(found(item), 1);
}
