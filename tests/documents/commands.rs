//! Every command of the documents parses; those of `sh` blocks run.

use std::path::Path;
use std::process::Command;

use super::markdown::{Document, blocks, documents, root, spans};

/// A command line of a block with what is to be done with it.
struct Line {
    words: Vec<String>,
    is_run: bool,
}

/// Words of a shell's line, with double quotes, without its comment.
fn words(line: &str) -> Vec<String> {
    let (mut found, mut word, mut is_quoted, mut is_open) = (Vec::new(), String::new(), false, false);
    for c in line.chars() {
        match c {
            '"' => (is_quoted, is_open) = (!is_quoted, true),
            '#' if !is_quoted && !is_open => break,
            c if c.is_whitespace() && !is_quoted => {
                if is_open {
                    found.push(std::mem::take(&mut word));
                }
                is_open = false;
            }
            c => {
                word.push(c);
                is_open = true;
            }
        }
    }
    found.extend(is_open.then_some(word));
    found
}

/// The command lines of a document's `sh` blocks.
fn lines(document: &Document) -> Vec<Line> {
    let shell = blocks(&document.text).into_iter().filter(|block| block.language == "sh");
    let lines = shell.flat_map(|block| {
        let is_run = block.mark.is_empty();
        block.lines.into_iter().map(move |line| Line { words: words(&line), is_run })
    });
    lines.filter(|line| !line.words.is_empty()).collect()
}

/// Why the program refuses the words of a command line.
fn refusal(words: &[String]) -> Option<String> {
    let error = shadowgauge::cli::command().try_get_matches_from(words).err()?;
    let is_help = matches!(error.kind(), clap::error::ErrorKind::DisplayHelp);
    (!is_help).then(|| format!("{}: {error}", words.join(" ")))
}

/// Targets of the Makefile.
fn targets() -> Vec<String> {
    let text = std::fs::read_to_string(root().join("Makefile")).unwrap();
    let phony = text.lines().find_map(|line| line.strip_prefix(".PHONY:")).unwrap();
    phony.split_whitespace().map(str::to_owned).collect()
}

#[test]
fn commands_of_blocks_parse() {
    let targets = targets();
    let mut bad = Vec::new();
    let mut found = 0;
    for line in documents().iter().flat_map(lines) {
        match line.words[0].as_str() {
            "shadowgauge" => bad.extend(refusal(&line.words)),
            "make" if targets.contains(&line.words[1]) => {}
            "cargo" => {}
            _ => bad
                .push(format!("{}: neither the program nor a target of the Makefile", line.words.join(" "))),
        }
        found += 1;
    }
    assert!(found > 40, "only {found} commands found");
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

/// The words of a span that name an option no command has, or a command that there is none of.
fn unknown(span: &str) -> Option<String> {
    let mut words = span.split_whitespace().skip_while(|w| *w == "shadowgauge").peekable();
    let mut command = shadowgauge::cli::command();
    while let Some(name) = words.peek().filter(|_| command.has_subcommands()) {
        let names: Vec<&str> = name.split('|').map(|n| n.trim_matches('\\')).collect();
        let below =
            names.iter().map(|name| command.find_subcommand(name).cloned()).collect::<Option<Vec<_>>>();
        match below {
            Some(commands) => command = commands.into_iter().next()?,
            // `calibrate` takes a file in a command's place
            None if command.get_positionals().next().is_some() => break,
            None if span.starts_with("shadowgauge ") && !name.starts_with('-') => {
                return Some(format!("`{span}`"));
            }
            None => break,
        }
        words.next();
    }
    let is_letter = |c: char| c.is_ascii_lowercase() || c == '-';
    let options = words.filter_map(|word| word.trim_start_matches('[').strip_prefix("--"));
    let mut options = options.map(|o| o.split(|c| !is_letter(c)).next().unwrap_or_default());
    let known = |option: &str| {
        matches!(option, "" | "help" | "version" | "verbose")
            || command.get_arguments().any(|a| a.get_long() == Some(option))
    };
    options.find(|option| !known(option)).map(|option| format!("`{span}`: --{option}"))
}

/// Whether a span is a command of the program: it begins with its name, or with a command's name
/// and has an option.
fn is_command(span: &str) -> bool {
    let first = span.split_whitespace().next().unwrap_or_default();
    first == "shadowgauge"
        || span.contains(" --") && shadowgauge::cli::command().find_subcommand(first).is_some()
}

#[test]
fn commands_of_the_text_are_spelt_as_the_program_has_them() {
    let mut found = 0;
    let mut bad = Vec::new();
    for document in documents() {
        for span in spans(&document.text).iter().filter(|span| is_command(span)) {
            found += 1;
            bad.extend(unknown(span).map(|what| format!("{}: {what}", document.path.display())));
        }
    }
    assert!(found > 50, "only {found} commands found");
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

#[test]
fn planted_commands_are_refused() {
    let refused = |line: &str| refusal(&words(line)).is_some();
    assert!(refused("shadowgauge mesure x") && refused("shadowgauge run x --ot y"));
    assert!(!refused("shadowgauge measure a --tolerance \"25 h6\"  # words"));
    assert!(unknown("shadowgauge study coverage --scens 3").is_some());
    assert!(unknown("shadowgauge study coverag").is_some() && unknown("measure --edge").is_some());
    assert!(unknown("shadowgauge study coverage|parts").is_none() && unknown("render --bench N").is_none());
}

/// Runs the commands of a document in a folder of its own, beside the configs.
fn run(document: &Document) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink(root().join("configs"), folder.path().join("configs")).unwrap();
    let commands = lines(document).into_iter().filter(|line| line.is_run && line.words[0] == "shadowgauge");
    commands.filter_map(|line| failure(folder.path(), &line.words)).collect()
}

/// What went wrong with a command.
fn failure(folder: &Path, words: &[String]) -> Option<String> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_shadowgauge"));
    let output = command.args(&words[1..]).current_dir(folder).env("NO_COLOR", "1").output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    (!output.status.success()).then(|| format!("{}: {}: {stderr}", words.join(" "), output.status))
}

#[test]
fn commands_of_blocks_run() {
    let documents = documents();
    let is_of_the_book = |d: &&Document| d.path.starts_with("docs") || d.path == Path::new("README.md");
    let bad: Vec<String> = documents.iter().filter(is_of_the_book).flat_map(run).collect();
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}
