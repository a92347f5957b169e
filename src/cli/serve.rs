//! `shadowgauge serve`: runs, history and a live source in a browser, until Ctrl-C.

use std::net::SocketAddr;
use std::path::PathBuf;

use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::process::interrupt;
use crate::cli::store::args::failure;
use crate::cli::terminal::output;
use crate::serve::{ServeError, ServeSettings, Server, Tls, Tokens};
use crate::store::Store;

/// Arguments of `serve`.
#[derive(Debug, clap::Args)]
pub(crate) struct ServeArgs {
    /// Address and port; port 0 takes a free one. An address that other machines see needs
    /// --tls-cert, --tls-key, --tokens and --name.
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
    /// Certificates in PEM, the server's first: what is served is encrypted (TLS 1.2 or 1.3).
    #[arg(long, value_name = "FILE.pem", requires = "tls_key")]
    tls_cert: Option<PathBuf>,
    /// The certificate's private key in PEM, without a password.
    #[arg(long, value_name = "FILE.pem", requires = "tls_cert")]
    tls_key: Option<PathBuf>,
    /// Name or address under which other machines reach this one; again for more. Requests under
    /// another name are refused.
    #[arg(long, value_name = "HOST")]
    name: Vec<String>,
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
        let name = runs.display();
        return Err(Failure::refuse(format!(
            "--runs: {name} is no folder: make it (mkdir {name}), or name the folder that holds the folders of runs"
        )));
    }
    let settings = ServeSettings {
        listen: args.listen,
        store: args.store.clone(),
        runs: args.runs.clone(),
        source: args.source.clone().map(|source| (source, args.watch.clone())),
        tokens: args.tokens.as_ref().map(read_tokens).transpose()?,
        tls: read_tls(args)?,
        names: args.name.clone(),
        read_only: args.read_only,
    };
    let stop = interrupt::requested();
    let server = Server::bind(settings).map_err(of_serve)?;
    say_line!("{}", server.url());
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

fn read_tls(args: &ServeArgs) -> Result<Option<Tls>, Failure> {
    let (Some(certificate), Some(key)) = (&args.tls_cert, &args.tls_key) else { return Ok(None) };
    Tls::read(certificate, key).map(Some).map_err(Failure::fail)
}

fn of_serve(error: ServeError) -> Failure {
    match error {
        ServeError::Refused(_) => Failure::refuse(error),
        ServeError::Bind { .. } | ServeError::System(_) => Failure::fail(error),
    }
}
