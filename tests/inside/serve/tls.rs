//! Beyond this machine: TLS, tokens and a name, or nothing is served.

use std::io::{Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rustls::pki_types::pem::PemObject as _;
use rustls::pki_types::{CertificateDer, ServerName};
use rustls::{ClientConfig, ClientConnection, RootCertStore, Stream};

use crate::serve::{ServeSettings, Server, Tls, Tokens};

/// Of `gauge.test`, signed by itself, for these tests alone.
const CERTIFICATE: &str = "tests/data/tls/certificate.pem";
const KEY: &str = "tests/data/tls/key.pem";

const TOKEN: &str = "Authorization: Bearer 0123456789abcdef\r\n";

fn settings() -> ServeSettings {
    let tokens = "[[token]]\nname = \"a\"\nrole = \"operate\"\ntoken = \"0123456789abcdef\"\n";
    ServeSettings {
        listen: "0.0.0.0:0".parse().unwrap(),
        store: None,
        runs: None,
        source: None,
        tokens: Some(toml::from_str::<Tokens>(tokens).unwrap()),
        tls: Some(Tls::read(Path::new(CERTIFICATE), Path::new(KEY)).unwrap()),
        names: vec!["gauge.test".to_owned()],
        read_only: false,
    }
}

/// A server in a thread of its own; it ends with the test.
struct Served {
    address: SocketAddr,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Served {
    fn start() -> Self {
        let server = Server::bind(settings()).unwrap();
        let address = SocketAddr::from(([127, 0, 0, 1], server.address().port()));
        assert_eq!(server.url(), format!("https://gauge.test:{}/", address.port()));
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let thread = std::thread::spawn(move || server.serve(&stopped).unwrap());
        Self { address, stop, thread: Some(thread) }
    }

    /// An answer's status and text, by a client that trusts the certificate.
    fn ask(&self, request: &str, headers: &str) -> (u16, String) {
        let mut roots = RootCertStore::empty();
        roots.add(CertificateDer::from_pem_file(CERTIFICATE).unwrap()).unwrap();
        let config = ClientConfig::builder_with_provider(Arc::new(rustls::crypto::ring::default_provider()))
            .with_safe_default_protocol_versions()
            .unwrap()
            .with_root_certificates(roots)
            .with_no_client_auth();
        let name = ServerName::try_from("gauge.test").unwrap();
        let mut connection = ClientConnection::new(Arc::new(config), name).unwrap();
        let mut socket = TcpStream::connect(self.address).unwrap();
        socket.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        let mut tls = Stream::new(&mut connection, &mut socket);
        let text = format!("{request} HTTP/1.1\r\n{headers}Connection: close\r\nContent-Length: 0\r\n\r\n");
        tls.write_all(text.as_bytes()).unwrap();
        let mut answer = Vec::new();
        let _ = tls.read_to_end(&mut answer);
        let answer = String::from_utf8_lossy(&answer).into_owned();
        (answer.split_whitespace().nth(1).and_then(|s| s.parse().ok()).unwrap_or(0), answer)
    }

    fn host(&self) -> String {
        format!("Host: gauge.test:{}\r\n", self.address.port())
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

#[test]
fn what_is_served_beyond_this_machine_is_encrypted_and_asks_for_a_token() {
    let served = Served::start();
    let (host, port) = (served.host(), served.address.port());
    assert_eq!(served.ask("GET /api/runs", &format!("{host}{TOKEN}")).0, 200);
    assert_eq!(served.ask("GET /api/runs", &host).0, 401);
    assert_eq!(served.ask("GET /api/runs", &format!("Host: other.test:{port}\r\n{TOKEN}")).0, 421);
    let change =
        |scheme: &str| format!("{host}{TOKEN}X-Shadowgauge: 1\r\nOrigin: {scheme}://gauge.test:{port}\r\n");
    assert_eq!(served.ask("POST /api/runs/x/stop", &change("https")).0, 409);
    assert_eq!(served.ask("POST /api/runs/x/stop", &change("http")).0, 403);
    // who does not encrypt gets nothing of it
    let mut plain = TcpStream::connect(served.address).unwrap();
    plain.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    plain.write_all(format!("GET / HTTP/1.1\r\n{host}{TOKEN}\r\n").as_bytes()).unwrap();
    let mut answer = Vec::new();
    let _ = plain.read_to_end(&mut answer);
    assert!(!answer.starts_with(b"HTTP"), "{}", String::from_utf8_lossy(&answer));
}

#[test]
fn clients_that_shake_no_hands_keep_nobody_waiting() {
    let served = Served::start();
    let idle: Vec<TcpStream> = (0..20).map(|_| TcpStream::connect(served.address).unwrap()).collect();
    let from = Instant::now();
    assert_eq!(served.ask("GET /", &format!("{}{TOKEN}", served.host())).0, 200);
    assert!(from.elapsed() < Duration::from_secs(3), "{:?}", from.elapsed());
    drop(idle);
}

#[test]
fn what_is_missing_beyond_this_machine_is_named() {
    let refused = |settings: ServeSettings| settings.check().unwrap_err();
    assert!(refused(ServeSettings { tls: None, ..settings() }).contains("--tls-cert"));
    assert!(refused(ServeSettings { tokens: None, ..settings() }).contains("--tokens"));
    assert!(refused(ServeSettings { names: Vec::new(), ..settings() }).contains("--name"));
    settings().check().unwrap();
    let read = |certificate, key| Tls::read(Path::new(certificate), Path::new(key)).unwrap_err();
    assert!(read("Makefile", KEY).contains("Makefile"));
    assert!(read(CERTIFICATE, CERTIFICATE).contains("private key"));
    assert!(read("none.pem", KEY).contains("none.pem"));
}
