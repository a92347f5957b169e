//! `shadowgauge serve`: runs, history and a live source in a browser, until Ctrl-C.

use std::net::SocketAddr;
use std::path::PathBuf;

use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::process::interrupt;
use crate::cli::store::args::failure;
use crate::cli::terminal::output;
use crate::serve::{ServeError, ServeSettings, Server, Tokens};
use crate::store::Store;

/// Arguments of `serve`.
#[derive(Debug, clap::Args)]
pub(crate) struct ServeArgs {
    /// Address and port; port 0 takes a free one. Beyond this machine nothing is served.
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:8020")]
    listen: SocketAddr,
    /// The store that `run --store` and `measure --store` write; runs that are started here write
    /// it, too.
    #[arg(long, value_name = "FILE")]
    store: Option<PathBuf>,
    /// Folder with a run folder a run: listed, compared, and where new ones go.
    #[arg(long, value_name = "DIR")]
    runs: Option<PathBuf>,
    /// Source that is watched, as `watch` takes it.
    #[arg(long, value_name = "SOURCE")]
    source: Option<String>,
    /// Tokens in TOML: [[token]] with name, role (view, operate, set_up) and token. Without them
    /// everybody on this machine may do everything.
    #[arg(long, value_name = "FILE.toml")]
    tokens: Option<PathBuf>,
    /// Nothing is started, stopped or changed.
    #[arg(long)]
    read_only: bool,
    /// What `watch` is called with besides the source, behind `--`: calibration, tolerance, …
    #[arg(last = true, requires = "source", value_name = "ARGUMENTS")]
    watch: Vec<String>,
}

/// Serves until Ctrl-C.
///
/// # Errors
/// Exit 2 for settings that are refused, 3 for a port that is taken.
pub(crate) fn run(args: &ServeArgs) -> CommandResult {
    if let Some(path) = &args.store {
        // made where it is absent, so that the page shows an empty one
        Store::open(path, "serve").map_err(failure)?;
    }
    if let Some(runs) = args.runs.as_ref().filter(|runs| !runs.is_dir()) {
        return Err(Failure::refuse(format!("--runs: {} is no folder", runs.display())));
    }
    let settings = ServeSettings {
        listen: args.listen,
        store: args.store.clone(),
        runs: args.runs.clone(),
        source: args.source.clone().map(|source| (source, args.watch.clone())),
        tokens: args.tokens.as_ref().map(read_tokens).transpose()?,
        read_only: args.read_only,
    };
    let stop = interrupt::requested();
    let server = Server::bind(settings).map_err(of_serve)?;
    say_line!("http://{}/", server.address());
    output::flush();
    server.serve(&stop).map_err(of_serve)?;
    Ok(Outcome::Done)
}

fn read_tokens(path: &PathBuf) -> Result<Tokens, Failure> {
    let named = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
    let text = std::fs::read_to_string(path).map_err(|e| Failure::fail(named(&e)))?;
    let tokens: Tokens = toml::from_str(&text).map_err(|e| Failure::refuse(named(&e)))?;
    tokens.check().map_err(|e| Failure::refuse(named(&e)))?;
    Ok(tokens)
}

fn of_serve(error: ServeError) -> Failure {
    match error {
        ServeError::Refused(_) => Failure::refuse(error),
        ServeError::Bind { .. } | ServeError::System(_) => Failure::fail(error),
    }
}
