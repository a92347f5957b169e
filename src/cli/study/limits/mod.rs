//! `shadowgauge study limits`: what half and double of every threshold of the instrument change.

mod child;
mod table;

use std::fs::File;
use std::io::{Read as _, Write as _};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use self::child::{Ending, Printed, cpu_s};
use self::table::{CsvRow, Row, Study, print};
use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::{csv_text, say_study};
use crate::cli::terminal::progress;
use crate::gauge::instrument::thresholds;
use crate::gauge::{Limit, replace_limit};
use crate::render::{BackendChoice, Renderer};
use crate::studies::limits::{self, Variant, variants};

/// Time that a process is given: so many times the default's, and at least so much.
const TIMES_DEFAULT: u32 = 10;
const AT_LEAST: Duration = Duration::from_secs(20);
/// Most names that an error lists.
const MOST_NAMES: usize = 12;

/// Arguments of `study limits`.
#[derive(Debug, clap::Args)]
pub(crate) struct StudyLimitsArgs {
    /// Only thresholds whose name (group.field) holds this text.
    #[arg(long, value_name = "PATTERN")]
    only: Option<String>,
    /// Scenes of each kind; half as many of the kinds with masters.
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=1000))]
    scenes: u32,
    /// Only kinds of scenes whose name holds this text.
    #[arg(long, value_name = "PATTERN")]
    kinds: Option<String>,
    /// Seed of the scenes, which are the same for every variant.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Processes at a time; by default as many as there are cores.
    #[arg(long, value_name = "N")]
    jobs: Option<NonZeroUsize>,
    /// Write the figures of every variant into this file.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Measure the scenes that come in through stdin and print a line of JSON: what the study
    /// starts itself with.
    #[arg(long, hide = true)]
    measure: bool,
    /// The threshold replaced, with its value.
    #[arg(long, hide = true, value_name = "NAME=VALUE", requires = "measure")]
    variant: Option<String>,
}

/// Runs the study.
///
/// # Errors
/// Exit 2 for a pattern that fits nothing, 3 for scenes that cannot be made, a process that cannot
/// be started and a file that cannot be written.
pub(crate) fn run(args: &StudyLimitsArgs) -> CommandResult {
    if args.measure {
        return measure(args.variant.as_deref());
    }
    let limits = chosen(args.only.as_deref())?;
    // A file that cannot be written is an error before the work, not after it.
    let file = args.csv.as_deref().map(create).transpose()?;
    let scenes = scenes(args)?;
    let processes = Processes::start(&scenes)?;
    let all: Vec<Variant> = limits.iter().flat_map(variants).collect();
    let rows = processes.rows(&all, jobs(args))?;
    let counts = processes.default.measured.counts();
    let study = Study {
        seed: args.seed,
        scenes: args.scenes as usize,
        default: counts.figures(),
        default_kinds: processes.default.measured,
        zero: limits.iter().filter(|l| variants(l).is_empty()).map(|l| l.name.clone()).collect(),
        variants: rows,
    };
    if let Some(mut file) = file {
        let rows: Vec<CsvRow<'_>> = study.variants.iter().map(CsvRow::from).collect();
        file.write_all(&csv_text(&rows)?).map_err(Failure::fail)?;
    }
    say_study(&study, args.json, print)
}

fn create(path: &Path) -> Result<File, Failure> {
    File::create(path).map_err(|e| Failure::fail(format!("{}: {e}", path.display())))
}

fn jobs(args: &StudyLimitsArgs) -> usize {
    let cores = || std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    args.jobs.map_or_else(cores, NonZeroUsize::get)
}

/// The thresholds whose name holds the pattern.
fn chosen(pattern: Option<&str>) -> Result<Vec<Limit>, Failure> {
    let all = thresholds::every();
    let Some(pattern) = pattern else { return Ok(all) };
    let (chosen, others): (Vec<Limit>, Vec<Limit>) =
        all.into_iter().partition(|limit| limit.name.contains(pattern));
    if chosen.is_empty() {
        let names: Vec<&str> = others.iter().map(|limit| limit.name.as_str()).collect();
        let more = if names.len() > MOST_NAMES { ", …" } else { "" };
        return Err(Failure::refuse(format!(
            "--only {pattern}: no threshold's name holds that; there are {}: {}{more}",
            names.len(),
            names[..names.len().min(MOST_NAMES)].join(", ")
        )));
    }
    Ok(chosen)
}

/// The scenes as bytes.
fn scenes(args: &StudyLimitsArgs) -> Result<Vec<u8>, Failure> {
    let renderer = Renderer::new(BackendChoice::Cpu).map_err(Failure::fail)?;
    let pick = |name: &str| args.kinds.as_ref().is_none_or(|pattern| name.contains(pattern.as_str()));
    let scenes = limits::make(args.scenes as usize, args.seed, &renderer, pick).map_err(Failure::fail)?;
    if scenes.is_empty() {
        let names = limits::kind_names().join(", ");
        let pattern = args.kinds.as_deref().unwrap_or_default();
        return Err(Failure::refuse(format!(
            "--kinds {pattern}: no kind's name holds that; there are {names}"
        )));
    }
    limits::to_bytes(&scenes).map_err(Failure::fail)
}

/// What the study's own processes do: measure what comes in, print one line.
fn measure(variant: Option<&str>) -> CommandResult {
    if let Some(text) = variant {
        let refused = || Failure::refuse(format!("--variant {text}: NAME=VALUE is needed"));
        let (name, value) = text.split_once('=').ok_or_else(refused)?;
        let value: f64 = value.parse().map_err(|_| refused())?;
        replace_limit(name, value).map_err(Failure::refuse)?;
    }
    let mut bytes = Vec::new();
    std::io::stdin().lock().read_to_end(&mut bytes).map_err(Failure::fail)?;
    let scenes = limits::from_bytes(&bytes).map_err(Failure::fail)?;
    let before = cpu_s();
    let measured = limits::measure(&scenes).map_err(Failure::refuse)?;
    let cpu_s = cpu_s().zip(before).map(|(after, before)| after - before);
    say_line!("{}", serde_json::to_string(&Printed { measured, cpu_s }).map_err(Failure::fail)?);
    Ok(Outcome::Done)
}

/// Processes that measure the same scenes.
struct Processes<'a> {
    scenes: &'a [u8],
    default: Printed,
    time_limit: Duration,
}

impl<'a> Processes<'a> {
    /// Measures with every threshold at its default, twice: results that differ by themselves would
    /// be taken for an effect of the thresholds.
    fn start(scenes: &'a [u8]) -> Result<Self, Failure> {
        let began = Instant::now();
        let once = || match child::run(scenes, None, None).map_err(Failure::fail)? {
            Ending::Measured(printed) => Ok(printed),
            Ending::Crashed(words) => Err(Failure::fail(format!("with the defaults: {words}"))),
            Ending::TimedOut => Err(Failure::fail("with the defaults: not ended")),
        };
        let (first, second) = (once()?, once()?);
        let unlike = first.measured.kinds_unlike(&second.measured);
        if !unlike.is_empty() {
            let text = format!("two runs with the defaults differ in {}", unlike.join(", "));
            return Err(Failure::fail(text));
        }
        // The shorter time is the less disturbed one.
        let cpu_s = first.cpu_s.zip(second.cpu_s).map(|(a, b)| a.min(b));
        let time_limit = AT_LEAST.max(began.elapsed() / 2 * TIMES_DEFAULT);
        tracing::info!(?cpu_s, "measured with the defaults");
        Ok(Self { scenes, default: Printed { measured: first.measured, cpu_s }, time_limit })
    }

    /// Measures every variant, `jobs` at a time; rows in the variants' order.
    fn rows(&self, variants: &[Variant], jobs: usize) -> Result<Vec<Row>, Failure> {
        let bar = progress::bar(variants.len() as u64, "measuring", "thresholds");
        let next = AtomicUsize::new(0);
        let work = || -> std::io::Result<Vec<(usize, Row)>> {
            let mut rows = Vec::new();
            loop {
                let index = next.fetch_add(1, Ordering::Relaxed);
                let Some(variant) = variants.get(index) else { return Ok(rows) };
                let ending = child::run(self.scenes, Some(variant), Some(self.time_limit))?;
                rows.push((index, Row::new(variant, ending, &self.default)));
                bar.inc(1);
            }
        };
        let found: Vec<std::io::Result<Vec<(usize, Row)>>> = std::thread::scope(|scope| {
            let workers: Vec<_> = (0..jobs).map(|_| scope.spawn(work)).collect();
            let panicked = |_| Err(std::io::Error::other("a thread that looks after processes panicked"));
            workers.into_iter().map(|worker| worker.join().unwrap_or_else(panicked)).collect()
        });
        bar.finish_and_clear();
        let mut rows = Vec::new();
        for of_worker in found {
            rows.extend(of_worker.map_err(Failure::fail)?);
        }
        rows.sort_by_key(|(index, _)| *index);
        Ok(rows.into_iter().map(|(_, row)| row).collect())
    }
}
