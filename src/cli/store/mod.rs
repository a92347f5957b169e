//! `shadowgauge store`: what a store of runs and measurements holds, in files and in words.
//!
//! `args` is `--store` of the commands that write one, `leaf` what `run` and `measure` give it.
//! One more of its kind is a variant of [`StoreCommand`].

pub(in crate::cli) mod args;
pub(in crate::cli) mod measured;
pub(in crate::cli) mod of_run;

use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;

use serde_json::json;

use self::args::{failure, who};
use super::failure::{CommandResult, Failure, Outcome};
use crate::files::OutputFile;
use crate::gauge::calibration::Date;
use crate::store::{Store, StoredRow, Utc};

/// What `store` does.
#[derive(Debug, clap::Subcommand)]
pub(crate) enum StoreCommand {
    /// Check the file, the chain of the audit, and every table against it.
    Check(CheckArgs),
    /// Write every row as JSON Lines.
    Export(ExportArgs),
    /// Read an export into a new store.
    Import(ImportArgs),
    /// List the stations of a time.
    List(ListArgs),
    /// Take out passes before a day; the audit stays and says so.
    Prune(PruneArgs),
}

/// Arguments of `store check`.
#[derive(Debug, clap::Args)]
pub(crate) struct CheckArgs {
    /// The store.
    store: PathBuf,
    /// Hash of the newest row at an earlier check: shows that no rows were cut off since.
    #[arg(long, value_name = "HASH")]
    head: Option<String>,
    /// Prints JSON.
    #[arg(long)]
    json: bool,
}

/// Arguments of `store export`.
#[derive(Debug, clap::Args)]
pub(crate) struct ExportArgs {
    /// The store.
    store: PathBuf,
    /// The file; `-` is stdout.
    #[arg(long, value_name = "FILE.jsonl", default_value = "-")]
    out: PathBuf,
}

/// Arguments of `store import`.
#[derive(Debug, clap::Args)]
pub(crate) struct ImportArgs {
    /// The new store.
    store: PathBuf,
    /// The export.
    from: PathBuf,
}

/// Arguments of `store list`.
#[derive(Debug, clap::Args)]
pub(crate) struct ListArgs {
    /// The store.
    store: PathBuf,
    /// First day, in UTC.
    #[arg(long, value_name = "YYYY-MM-DD")]
    from: Option<Date>,
    /// Last day, in UTC.
    #[arg(long, value_name = "YYYY-MM-DD")]
    to: Option<Date>,
    /// Prints a line of JSON a station.
    #[arg(long)]
    json: bool,
}

/// Arguments of `store prune`.
#[derive(Debug, clap::Args)]
pub(crate) struct PruneArgs {
    /// The store.
    store: PathBuf,
    /// Passes stored before this day go, in UTC.
    #[arg(long, value_name = "YYYY-MM-DD")]
    before: Date,
    /// Who does it, for the audit (default: the user's name).
    #[arg(long, value_name = "NAME")]
    by: Option<String>,
}

/// Runs the command.
///
/// # Errors
/// Exit 2 for a file that is no store, 3 for one that cannot be read or written; `check` ends with
/// 1 where something does not fit together.
pub(crate) fn run(command: &StoreCommand) -> CommandResult {
    match command {
        StoreCommand::Check(args) => check(args),
        StoreCommand::Export(args) => export(args),
        StoreCommand::Import(args) => import(args),
        StoreCommand::List(args) => list(args),
        StoreCommand::Prune(args) => prune(args),
    }
}

fn check(args: &CheckArgs) -> CommandResult {
    let store = Store::read(&args.store).map_err(failure)?;
    let checked = store.check(args.head.as_deref()).map_err(failure)?;
    let counts = store.counts().map_err(failure)?;
    if args.json {
        say_line!("{}", json!({ "counts": counts, "checked": checked }));
    } else {
        for finding in &checked.findings {
            say_line!("{}: {}", finding.place, finding.what);
        }
        say_line!(
            "{} runs, {} passes, {} stations, {} rows of audit; newest {}",
            counts.runs,
            counts.passes,
            counts.stations,
            checked.audit_rows,
            checked.head
        );
    }
    Ok(if checked.findings.is_empty() { Outcome::Done } else { Outcome::OutOfTolerance })
}

fn export(args: &ExportArgs) -> CommandResult {
    let mut store = Store::read(&args.store).map_err(failure)?;
    let file = OutputFile::claim(&args.out, [args.store.clone()])?;
    let mut out = file.begin()?;
    store.export(&mut out).map_err(failure)?;
    out.finish()?;
    Ok(Outcome::Done)
}

fn import(args: &ImportArgs) -> CommandResult {
    let unread = |e: std::io::Error| Failure::fail(format!("{}: cannot be read: {e}", args.from.display()));
    let mut lines = BufReader::new(File::open(&args.from).map_err(unread)?);
    let is_new = !args.store.exists();
    let imported = Store::open(&args.store, &who(None))
        .and_then(|mut store| store.import(&mut lines, &args.from).map(|rows| (store, rows)));
    let (store, rows) = imported.map_err(|error| {
        if is_new {
            // nothing half-written: the file was made by this command
            args::remove(&args.store);
        }
        failure(error)
    })?;
    let findings = store.check(None).map_err(failure)?.findings;
    for finding in &findings {
        tracing::warn!("{}: {}", finding.place, finding.what);
    }
    say_line!("{rows} rows read into {}", args.store.display());
    Ok(if findings.is_empty() { Outcome::Done } else { Outcome::OutOfTolerance })
}

fn list(args: &ListArgs) -> CommandResult {
    let store = Store::read(&args.store).map_err(failure)?;
    let from = args.from.map_or(Utc(i64::MIN), Utc::at_beginning_of);
    let to = args.to.map_or(Utc(i64::MAX), |day| Utc::at_beginning_of(day.plus_days(1)));
    if !args.json {
        say_line!(
            "{:24}  {:20} {:>4}  {:>9}  {:>11}  {:>9}",
            "stored",
            "run",
            "pass",
            "z/mm",
            "D/mm",
            "u/µm"
        );
    }
    let show = |row: StoredRow| {
        if args.json {
            say_line!("{}", serde_json::to_string(&row).unwrap_or_default());
        } else {
            say_line!("{}", line(&row));
        }
    };
    store.stations_between(from, to, show).map_err(failure)?;
    Ok(Outcome::Done)
}

fn line(row: &StoredRow) -> String {
    let number =
        |value: Option<f64>, digits: usize| value.map_or("-".to_owned(), |v| format!("{v:.digits$}"));
    let s = &row.station;
    format!(
        "{:24}  {:20} {:>4}  {:>9}  {:>11}  {:>9}  {}",
        row.utc,
        row.name.chars().take(20).collect::<String>(),
        row.pass,
        number(s.z_mm, 3),
        number(s.d_mm, 6),
        number(s.u_mm.map(|u| 1e3 * u), 3),
        s.flag.as_deref().unwrap_or("")
    )
}

fn prune(args: &PruneArgs) -> CommandResult {
    Store::read(&args.store).map_err(failure)?;
    let mut store = Store::open(&args.store, &who(args.by.as_deref())).map_err(failure)?;
    let passes = store.prune(Utc::at_beginning_of(args.before)).map_err(failure)?;
    say_line!("{passes} passes before {} taken out", args.before);
    Ok(Outcome::Done)
}
