//! `commands.md`: every command with its arguments and options, from clap's definitions.

use clap::{Arg, Command};

use super::examples;
use super::markdown::{cell, row};

const START: &str = "# Commands

<!-- Written by `shadowgauge reference`; do not edit. -->

Every command with its arguments, options and examples, as `--help` shows them. `-v` and `-vv` before or after a command
print more on stderr, `--version` the version.
";

/// The page.
pub(crate) fn page(program: &Command) -> String {
    let mut text = START.to_owned();
    for command in program.get_subcommands().filter(|c| !c.is_hide_set()) {
        section(command, program.get_name(), &mut text);
    }
    text
}

/// A command and the commands below it.
fn section(command: &Command, above: &str, text: &mut String) {
    let name = format!("{above} {}", command.get_name());
    let about = command.get_about().map(ToString::to_string).unwrap_or_default();
    *text += &format!("\n## `{name}`\n\n{}.\n", about.trim_end_matches('.'));
    let mut arguments = command.get_arguments().filter(|a| !a.is_hide_set()).peekable();
    if arguments.peek().is_some() {
        *text += "\n| | default | meaning |\n|---|---|---|\n";
    }
    arguments.for_each(|argument| *text += &argument_row(argument));
    let examples = examples::of(command);
    if !examples.is_empty() {
        *text += &format!("\n```text\n{}\n```\n", examples.join("\n"));
    }
    for below in command.get_subcommands().filter(|c| !c.is_hide_set()) {
        section(below, &name, text);
    }
}

fn argument_row(argument: &Arg) -> String {
    let defaults = argument.get_default_values().iter().map(|v| v.to_string_lossy());
    let default = match defaults.collect::<Vec<_>>().join(" ") {
        _ if argument.is_required_set() => "required".to_owned(),
        given if given.is_empty() || !argument.get_action().takes_values() => String::new(),
        given => format!("`{given}`"),
    };
    row(&[cell(&format!("`{}`", name(argument))), default, meaning(argument)])
}

/// `--out <DIR>`, `-v`, `<CONFIG>`.
fn name(argument: &Arg) -> String {
    let takes = argument.get_action().takes_values();
    let names = argument.get_value_names().filter(|_| takes).unwrap_or_default();
    let values = names.iter().map(|name| format!("<{name}>")).collect::<Vec<_>>().join(" ");
    match (argument.get_long(), argument.get_short()) {
        (Some(long), _) => format!("--{long} {values}").trim_end().to_owned(),
        (None, Some(short)) => format!("-{short} {values}").trim_end().to_owned(),
        (None, None) => values,
    }
}

fn meaning(argument: &Arg) -> String {
    let help = argument.get_long_help().or(argument.get_help()).map(ToString::to_string).unwrap_or_default();
    let values = argument.get_possible_values();
    let values = values.iter().filter(|v| !v.is_hide_set()).map(|value| match value.get_help() {
        Some(help) => format!("`{}`: {help}", value.get_name()),
        None => format!("`{}`", value.get_name()),
    });
    let values = values.collect::<Vec<_>>().join("; ");
    let takes_words = !values.is_empty() && argument.get_action().takes_values();
    cell(&if takes_words { format!("{help}. {values}") } else { help })
}
