//! What is served, and to whom.

use std::net::SocketAddr;
use std::path::PathBuf;

use serde::Deserialize;

/// What a person may do; each may do what those before it may.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Role {
    /// Read.
    View,
    /// Start and stop simulated runs.
    Operate,
    /// Change what is stored.
    SetUp,
}

/// A named token.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Token {
    /// Whose it is, for the audit.
    pub name: String,
    /// What it allows.
    pub role: Role,
    /// The secret, 16 characters at least.
    pub token: String,
}

/// The file of tokens: `[[token]]` with name, role (`view`, `operate`, `set_up`) and token.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Tokens {
    /// All of them.
    #[serde(default)]
    pub token: Vec<Token>,
}

/// Shortest secret, characters: 16 of base 64 are 96 bits, beyond any guessing over a network.
const SHORTEST: usize = 16;

impl Tokens {
    /// Checks names and secrets.
    ///
    /// # Errors
    /// None at all, a name twice, a secret that is short.
    pub(crate) fn check(&self) -> Result<(), String> {
        if self.token.is_empty() {
            return Err("has no [[token]] with name, role and token".into());
        }
        for (k, token) in self.token.iter().enumerate() {
            if token.token.len() < SHORTEST {
                return Err(format!("token of {:?}: {SHORTEST} characters at least", token.name));
            }
            if self.token[..k].iter().any(|t| t.name == token.name || t.token == token.token) {
                return Err(format!("{:?} stands there twice", token.name));
            }
        }
        Ok(())
    }
}

/// What is served.
#[derive(Clone, Debug)]
pub(crate) struct ServeSettings {
    /// Address and port.
    pub listen: SocketAddr,
    /// The store.
    pub store: Option<PathBuf>,
    /// Folder with a run folder a run.
    pub runs: Option<PathBuf>,
    /// Source that is watched, and what `watch` is called with besides.
    pub source: Option<(String, Vec<String>)>,
    /// Who may do what; without tokens everybody on this machine may do all.
    pub tokens: Option<Tokens>,
    /// Nothing is started, stopped or changed.
    pub read_only: bool,
}

impl ServeSettings {
    /// Checks that no other machine is served without protection.
    ///
    /// # Errors
    /// An address beyond loopback.
    pub(crate) fn check(&self) -> Result<(), String> {
        if self.listen.ip().is_loopback() {
            return Ok(());
        }
        Err(format!(
            "{} is seen by other machines, and what is served here is not encrypted: listen on 127.0.0.1 and let a \
             proxy with TLS or an SSH tunnel pass it on (with --tokens)",
            self.listen.ip()
        ))
    }
}
