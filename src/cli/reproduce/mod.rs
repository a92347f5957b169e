//! `shadowgauge reproduce …`: a paper's figures beside ours.
//!
//! Each paper has a file with its arguments and its run (`paper_000`, `paper_001`, `paper_003`,
//! `paper_004`; `paper_003_page` writes its pages); `tables` prints rows and puts them on a page. A
//! new paper is a file here, a variant of [`Paper`], and its rows in `studies`.

mod paper_000;
mod paper_001;
mod paper_003;
mod paper_003_page;
mod paper_004;
mod tables;

use clap::Subcommand;

use self::paper_000::Reproduce000Args;
use self::paper_001::Reproduce001Args;
use self::paper_003::Reproduce003Args;
use self::paper_004::Reproduce004Args;
use crate::cli::failure::CommandResult;

/// The papers.
#[derive(Debug, Subcommand)]
pub(crate) enum Paper {
    /// Least-squares compensation of a single shaft through macro variables.
    #[command(name = "000")]
    P000(Reproduce000Args),
    /// The lathe as its own measuring machine: 21 errors, their identification, nets.
    #[command(name = "001")]
    P001(Reproduce001Args),
    /// Slender shaft: forces, deflection, choice of cutting data, PID compensation (Xue, Miao,
    /// Xue 2023).
    #[command(name = "003")]
    P003(Reproduce003Args),
    /// Tool wear by vision and compensation of the program (Zhang, Lu, Xia, Zhang, Zhu 2025).
    #[command(name = "004")]
    P004(Reproduce004Args),
}

/// Reproduces a paper.
///
/// # Errors
/// As the paper's command.
pub(crate) fn run(paper: &Paper) -> CommandResult {
    match paper {
        Paper::P000(args) => paper_000::run(args),
        Paper::P001(args) => paper_001::run(args),
        Paper::P003(args) => paper_003::run(args),
        Paper::P004(args) => paper_004::run(args),
    }
}
