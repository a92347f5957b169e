//! Arguments of `nc`.

use std::path::PathBuf;

use super::bar_args::BarArgs;
use crate::cli::run::model::ModelArgs;
use crate::nc::Dialect;

fn dialect(word: &str) -> Result<Dialect, String> {
    word.parse()
}

/// How the correction stands in the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Form {
    /// Knots along z: any shape.
    Knots,
    /// Macro variables of a line: the least-squares paper's program.
    Macro,
    /// The least-squares paper's whole program: it probes the part, fits the line, cuts and probes
    /// again; the offsets of the run are not used.
    Probing,
    /// Touches a reference of known diameter and leaves the probe's correction in macro variables;
    /// of the run only the machine's data are used.
    Qualify,
}

/// Arguments of `nc`.
#[derive(Debug, clap::Args)]
pub(crate) struct NcArgs {
    /// A run folder; with --state the job (TOML); or a model of a part (.stl), which is cut from
    /// the bar.
    pub(super) run: PathBuf,
    /// fanuc, linuxcnc, gsk or sinumerik.
    #[arg(long, value_parser = dialect)]
    pub(super) dialect: Dialect,
    /// The pass to be cut; the last one of the run by default.
    #[arg(long, value_name = "N")]
    pub(super) pass: Option<u32>,
    /// Knots along z, macro variables of a line, a program that measures its own correction with a
    /// touch probe, or the qualification of that probe.
    #[arg(long, value_enum, default_value = "knots")]
    pub(super) form: Form,
    /// A TOML file with the machine's data (how the control reads offsets, tool, what stands around
    /// the part, clearances, re-measurement; docs/nc.md); by default the run's own [nc.machine],
    /// where it was made for this control.
    #[arg(long, value_name = "FILE")]
    pub(super) machine: Option<PathBuf>,
    /// The state of the offsets, as `measure --offsets JOB --state FILE` keeps it: the program cuts
    /// the next part, or the trial cut that comes first.
    #[arg(long, value_name = "FILE.toml")]
    pub(super) state: Option<PathBuf>,
    /// Raises every diameter above the stock: the same moves, nothing is cut. For the first run of
    /// a program.
    #[arg(long)]
    pub(super) air: bool,
    /// Takes the gauge head along the finished part: retract, coolant off, air blast, the spindle
    /// at its measuring speed or held at every angle, a trigger a stop. Nothing is cut; the
    /// machine's data need the table scan. With --dry-run: the stops as a table.
    #[arg(long)]
    pub(super) scan: bool,
    /// Number of the part: with the pass it makes the program run once only.
    #[arg(long, value_name = "N")]
    pub(super) part: Option<u32>,
    /// List old offsets, new offsets and the reason instead of the program.
    #[arg(long)]
    pub(super) dry_run: bool,
    /// Write into this file instead of to stdout.
    #[arg(long, value_name = "FILE")]
    pub(super) out: Option<PathBuf>,
    #[command(flatten)]
    pub(super) model: ModelArgs,
    #[command(flatten)]
    pub(super) bar: BarArgs,
}
