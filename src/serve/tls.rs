//! TLS (rustls): a certificate with its key, and connections that have shaken hands.

use std::future::pending;
use std::io;
use std::net::SocketAddr;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use axum::serve::Listener;
use rustls::ServerConfig;
use rustls::crypto::ring::default_provider;
use rustls::pki_types::pem::PemObject as _;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Semaphore, mpsc};
use tokio_rustls::TlsAcceptor;
use tokio_rustls::server::TlsStream;

/// Time that a client has to show that it speaks TLS: some round trips of a slow network.
const HANDSHAKE: Duration = Duration::from_secs(5);
/// Clients that shake hands at a time; others wait to be accepted.
const MOST_HANDSHAKES: usize = 64;
/// Pause where the system accepts no connection (no file descriptors left).
const ACCEPTS_AGAIN: Duration = Duration::from_millis(100);

/// A certificate with its key.
#[derive(Clone, Debug)]
pub(crate) struct Tls(Arc<ServerConfig>);

impl Tls {
    /// Reads a chain of certificates, the server's first, and its key, both in PEM.
    ///
    /// # Errors
    /// Files that cannot be read, that hold something else, that do not belong together.
    pub(crate) fn read(certificate: &Path, key: &Path) -> Result<Self, String> {
        let of = |path: &Path, e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
        let chain = CertificateDer::pem_file_iter(certificate).map_err(|e| of(certificate, &e))?;
        let chain: Vec<_> = chain.collect::<Result<_, _>>().map_err(|e| of(certificate, &e))?;
        if chain.is_empty() {
            return Err(of(certificate, &"has no certificate in PEM (-----BEGIN CERTIFICATE-----)"));
        }
        let found = PrivateKeyDer::from_pem_file(key)
            .map_err(|e| of(key, &format!("{e}; a private key in PEM without a password is needed")))?;
        let mut config = ServerConfig::builder_with_provider(Arc::new(default_provider()))
            .with_safe_default_protocol_versions()
            .map_err(|e| e.to_string())?
            .with_no_client_auth()
            .with_single_cert(chain, found)
            .map_err(|e| of(key, &format!("{e} (with {})", certificate.display())))?;
        config.alpn_protocols = vec![b"http/1.1".to_vec()];
        Ok(Self(Arc::new(config)))
    }
}

/// Connections that have shaken hands. A client that is slow to do so keeps no other one waiting.
pub(super) struct TlsListener {
    address: SocketAddr,
    ready: mpsc::Receiver<(TlsStream<TcpStream>, SocketAddr)>,
}

impl TlsListener {
    /// Accepts from now on.
    ///
    /// # Errors
    /// Where the system does not name the listener's address.
    pub(super) fn new(listener: TcpListener, tls: &Tls) -> io::Result<Self> {
        let (give, ready) = mpsc::channel(1);
        let address = listener.local_addr()?;
        tokio::spawn(accept_all(listener, TlsAcceptor::from(Arc::clone(&tls.0)), give));
        Ok(Self { address, ready })
    }
}

impl Listener for TlsListener {
    type Io = TlsStream<TcpStream>;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (Self::Io, Self::Addr) {
        match self.ready.recv().await {
            Some(connection) => connection,
            None => pending().await,
        }
    }

    fn local_addr(&self) -> io::Result<SocketAddr> {
        Ok(self.address)
    }
}

async fn accept_all(
    listener: TcpListener,
    acceptor: TlsAcceptor,
    give: mpsc::Sender<(TlsStream<TcpStream>, SocketAddr)>,
) {
    let places = Arc::new(Semaphore::new(MOST_HANDSHAKES));
    while let Ok(place) = Arc::clone(&places).acquire_owned().await {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            () = give.closed() => return,
        };
        let Ok((stream, address)) = accepted else {
            tokio::time::sleep(ACCEPTS_AGAIN).await;
            continue;
        };
        let (acceptor, give) = (acceptor.clone(), give.clone());
        tokio::spawn(async move {
            if let Ok(Ok(stream)) = tokio::time::timeout(HANDSHAKE, acceptor.accept(stream)).await {
                // the server may have ended meanwhile
                let _ = give.send((stream, address)).await;
            }
            drop(place);
        });
    }
}
