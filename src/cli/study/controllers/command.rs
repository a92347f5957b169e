//! `--with-command`: a program beside the controllers, by its command line.

use std::cell::RefCell;
use std::path::Path;
use std::time::Duration;

use super::process::Process;
use crate::control::external::{Fault, ProgramError};
use crate::control::{Controller, ControllerName};
use crate::job::Job;
use crate::studies::controllers::ControllerProgram;

/// A command line: `CMD` or `NAME=CMD`, words apart by spaces, quotes around a word with spaces. No
/// shell reads it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CommandLine {
    name: String,
    text: String,
    program: String,
    arguments: Vec<String>,
}

impl std::str::FromStr for CommandLine {
    type Err = String;

    fn from_str(given: &str) -> Result<Self, String> {
        let (name, text) = match given.split_once('=') {
            Some((name, rest)) if is_name(name) => (Some(name), rest.trim()),
            _ => (None, given.trim()),
        };
        let mut words = words(text)?.into_iter();
        let Some(program) = words.next().filter(|word| !word.is_empty()) else {
            return Err(
                "names no program; right is CMD or NAME=CMD, as in mine=\"python3 mine.py\"".to_owned()
            );
        };
        let arguments: Vec<String> = words.collect();
        let name = name.map_or_else(|| name_of(&program, &arguments), str::to_owned);
        Ok(Self { name, text: text.to_owned(), program, arguments })
    }
}

/// Whether the text before an equals sign is a name, and no start of a command.
fn is_name(text: &str) -> bool {
    text.starts_with(|c: char| c.is_alphabetic())
        && text.chars().all(|c| c.is_alphanumeric() || "-_".contains(c))
}

/// Words of a command line.
fn words(text: &str) -> Result<Vec<String>, String> {
    let (mut words, mut word, mut quote) = (Vec::new(), None::<String>, None);
    for c in text.chars() {
        match quote {
            Some(end) if c == end => quote = None,
            None if c == '"' || c == '\'' => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            None if c.is_whitespace() => words.extend(word.take()),
            _ => word.get_or_insert_default().push(c),
        }
    }
    if let Some(quote) = quote {
        return Err(format!("has a {quote} without its partner"));
    }
    words.extend(word);
    Ok(words)
}

/// A name for a command: the stem of its first word that is a file (a script after its
/// interpreter), of its first word where none is.
fn name_of(program: &str, arguments: &[String]) -> String {
    let words = || std::iter::once(program).chain(arguments.iter().map(String::as_str));
    let script = words().find(|word| Path::new(word).is_file()).unwrap_or(program);
    Path::new(script)
        .file_stem()
        .map_or_else(|| script.to_owned(), |stem| stem.to_string_lossy().into_owned())
}

/// Refuses two contestants of one name.
///
/// # Errors
/// Names the name and what would be right.
pub(super) fn check_names(commands: &[CommandLine]) -> Result<(), String> {
    for (index, command) in commands.iter().enumerate() {
        let name = &command.name;
        let taken = commands[..index].iter().any(|other| other.name == *name)
            || ControllerName::ALL.iter().any(|own| own.as_str() == name);
        if taken {
            return Err(format!(
                "--with-command {}: the name {name:?} is taken; name it by another one, as in my-{name}={}",
                command.text, command.text
            ));
        }
    }
    Ok(())
}

/// A command whose first process runs, so that one that cannot be started is refused before any
/// frame is rendered.
pub(super) struct StartedCommand {
    line: CommandLine,
    timeout: Duration,
    /// The process of the first shaft.
    first: RefCell<Option<Process>>,
}

impl StartedCommand {
    /// Starts the first process.
    ///
    /// # Errors
    /// Where the program cannot be started.
    pub(super) fn new(line: &CommandLine, timeout: Duration) -> Result<Self, ProgramError> {
        let first = RefCell::new(Some(start(line, timeout)?));
        Ok(Self { line: line.clone(), timeout, first })
    }
}

fn start(line: &CommandLine, timeout: Duration) -> Result<Process, ProgramError> {
    Process::start(&line.program, &line.arguments, timeout).map_err(|cause| ProgramError {
        program: format!("{} ({})", line.name, line.text),
        fault: Fault::NotStarted(cause.to_string()),
    })
}

impl ControllerProgram for StartedCommand {
    fn name(&self) -> &str {
        &self.line.name
    }

    fn command(&self) -> &str {
        &self.line.text
    }

    fn start(&self, job: &Job) -> Result<Box<dyn Controller + Send>, ProgramError> {
        let first = self.first.borrow_mut().take();
        let process = first.map_or_else(|| start(&self.line, self.timeout), Ok)?;
        Ok(job.program_controller(process, self.name(), self.command()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> (String, String, Vec<String>) {
        let line: CommandLine = text.parse().unwrap();
        (line.name, line.program, line.arguments)
    }

    #[test]
    fn a_name_stands_before_an_equals_sign_and_options_keep_theirs() {
        let words = |words: &[&str]| words.iter().map(|w| (*w).to_owned()).collect::<Vec<_>>();
        assert_eq!(read("mine=run --kp=1"), ("mine".into(), "run".into(), words(&["--kp=1"])));
        assert_eq!(read("./run --kp=1"), ("run".into(), "./run".into(), words(&["--kp=1"])));
        assert_eq!(read("a 'b c' \"d\"'e' ''"), ("a".into(), "a".into(), words(&["b c", "de", ""])));
        assert_eq!(read("python3 Cargo.toml").0, "Cargo", "the script names it");
    }

    #[test]
    fn a_line_without_a_program_and_a_taken_name_are_refused() {
        for (text, word) in [("", "no program"), ("mine=", "no program"), ("run 'a", "without its partner")] {
            assert!(text.parse::<CommandLine>().unwrap_err().contains(word), "{text}");
        }
        let lines = |texts: &[&str]| texts.iter().map(|t| t.parse().unwrap()).collect::<Vec<CommandLine>>();
        assert!(check_names(&lines(&["a x", "b=a x"])).is_ok());
        assert!(check_names(&lines(&["a x", "a y"])).unwrap_err().contains("my-a=a y"));
        assert!(check_names(&lines(&["pid=a"])).unwrap_err().contains("\"pid\" is taken"));
    }
}
