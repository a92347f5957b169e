//! What is served, and to whom.

use std::net::SocketAddr;
use std::path::PathBuf;

use serde::Deserialize;

use super::tls::Tls;

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
            // what a cookie holds as it is (RFC 6265)
            if !token.token.bytes().all(|b| b.is_ascii_graphic() && !b"\",;\\".contains(&b)) {
                return Err(format!(
                    "token of {:?}: letters, digits and signs other than \" , ; \\",
                    token.name
                ));
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
    /// Certificate and key; without them nothing is encrypted.
    pub tls: Option<Tls>,
    /// Names under which other machines reach this one.
    pub names: Vec<String>,
    /// Nothing is started, stopped or changed.
    pub read_only: bool,
}

impl ServeSettings {
    /// Checks that no other machine is served without protection.
    ///
    /// # Errors
    /// An address beyond loopback without TLS, tokens or names.
    pub(crate) fn check(&self) -> Result<(), String> {
        if self.listen.ip().is_loopback() {
            return Ok(());
        }
        let lacks = [
            (
                self.tls.is_none(),
                "a certificate with its key (--tls-cert, --tls-key), so that what is served is encrypted",
            ),
            (self.tokens.is_none(), "named tokens (--tokens)"),
            (self.names.is_empty(), "the name under which it is reached (--name), as in the certificate"),
        ];
        let lacks: Vec<&str> =
            lacks.into_iter().filter(|(is_lacking, _)| *is_lacking).map(|(_, words)| words).collect();
        if lacks.is_empty() {
            return Ok(());
        }
        Err(format!(
            "{} is seen by other machines, which needs {}; or listen on 127.0.0.1 and let an SSH tunnel or a proxy with \
             TLS pass it on",
            self.listen.ip(),
            lacks.join(", and ")
        ))
    }

    /// `http` or `https`.
    pub(crate) fn scheme(&self) -> &'static str {
        if self.tls.is_some() { "https" } else { "http" }
    }

    /// What a browser states as host: the names that this server has, with its port, which is left
    /// out where it is the scheme's own.
    pub(crate) fn hosts(&self) -> Vec<String> {
        let port = self.listen.port();
        let own = [self.listen.ip().to_string(), "localhost".to_owned(), "127.0.0.1".to_owned()];
        let all = own.iter().chain(&self.names).map(|name| match name.parse::<std::net::Ipv6Addr>() {
            Ok(address) => format!("[{address}]"),
            Err(_) => name.clone(),
        });
        let is_own = port == if self.tls.is_some() { 443 } else { 80 };
        all.flat_map(|name| [Some(format!("{name}:{port}")), is_own.then_some(name)]).flatten().collect()
    }
}
