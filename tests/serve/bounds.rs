//! What others do to a server: malformed requests, slow clients, many streams, uploads over the
//! limit. It answers, in bounded memory, with the right status.

use std::io::{Read as _, Write as _};
use std::net::TcpStream;

use super::{Server, text};

/// Memory that ten thousand requests may add, MiB: buffers of connections and the allocator's
/// scatter.
const GROWTH_MIB: f64 = 32.0;

/// Resident memory of a process, MiB; none where there is no /proc.
fn resident_mib(server: &Server) -> Option<f64> {
    let status = std::fs::read_to_string(format!("/proc/{}/status", server.program.id())).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(line.trim().trim_end_matches(" kB").parse::<f64>().ok()? / 1024.0)
}

/// Bytes of a request that is none: noise, or a good one with something wrong in it.
fn malformed(k: u32, state: &mut u32) -> Vec<u8> {
    let mut next = || {
        *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*state >> 24) as u8
    };
    match k % 6 {
        0 => (0..40).map(|_| next()).chain(*b"\r\n\r\n").collect(),
        1 => b"GET /api/runs HTTP/1.1\r\nHost: \xff\xfe\r\n\r\n".to_vec(),
        2 => b"POST /api/runs HTTP/1.1\r\nHost: x\r\nContent-Length: 99999999999999999999\r\n\r\n".to_vec(),
        3 => b"PUT /api/products/x/model HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\nzz\r\n"
            .to_vec(),
        4 => format!("GET /{} HTTP/1.1\r\nHost: x\r\n\r\n", "%00".repeat(usize::from(next()))).into_bytes(),
        _ => format!("{} / HTTP/9.9\r\nHost: x\r\n\r\n", "A".repeat(usize::from(next()) + 1)).into_bytes(),
    }
}

#[test]
fn malformed_requests_and_slow_clients_take_nothing_from_others() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(&["--runs", text(folder.path())]);
    let slow: Vec<TcpStream> = (0..50)
        .map(|_| {
            let mut stream = server.connect();
            stream.write_all(b"GET /api/runs HTTP/1.1\r\nHost: ").unwrap();
            stream
        })
        .collect();
    let mut state = 1_u32;
    let mut send = |requests: std::ops::Range<u32>| {
        for k in requests {
            let mut stream = server.connect();
            let _ = stream.write_all(&malformed(k, &mut state));
        }
        assert_eq!(server.get("/api/runs").status, 200);
    };
    send(0..1000);
    let before = resident_mib(&server);
    send(1000..10_000);
    if let (Some(before), Some(after)) = (before, resident_mib(&server)) {
        assert!(after - before < GROWTH_MIB, "{before} MiB after 1000 requests, {after} after 10 000");
    }
    drop(slow);
}

#[test]
fn a_hundred_streams_are_open_and_the_next_one_is_told_so() {
    let server = Server::start(&[]);
    let ask = format!("GET /api/live HTTP/1.1\r\nHost: {}\r\n\r\n", server.host);
    let open = || {
        let mut stream = server.connect();
        stream.write_all(ask.as_bytes()).unwrap();
        let mut head = [0; 12];
        stream.read_exact(&mut head).unwrap();
        (stream, String::from_utf8_lossy(&head[9..]).into_owned())
    };
    let mut streams: Vec<(TcpStream, String)> = (0..100).map(|_| open()).collect();
    assert!(streams.iter().all(|(_, status)| status == "200"));
    assert_eq!(open().1, "503");
    assert_eq!(server.get("/api/runs").status, 200, "pages are answered meanwhile");
    // a page that is closed leaves its place to another one, once the server has noticed
    streams.truncate(90);
    let again = (0..100).any(|_| {
        std::thread::sleep(std::time::Duration::from_millis(50));
        open().1 == "200"
    });
    assert!(again);
}

#[test]
fn uploads_over_their_limit_are_refused_as_too_large() {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("store.sqlite");
    let server = Server::start(&["--store", text(&store)]);
    let changes = "X-Shadowgauge: 1\r\n";
    for (method, path, mib) in [
        ("PUT", "/api/products/x/model", 17),
        ("POST", "/api/tools/x/images?kind=nose&um_per_px=2", 33),
        ("POST", "/api/calibrations", 17),
        ("POST", "/api/calibrations/simulated", 2),
        ("POST", "/api/programs", 2),
    ] {
        // what is stated as too long is refused before it is sent
        let mut stream = server.connect();
        let head = format!(
            "{method} {path} HTTP/1.1\r\nHost: {}\r\nContent-Type: application/json\r\n{changes}Content-Length: {}\r\n\r\n",
            server.host,
            mib << 20
        );
        stream.write_all(head.as_bytes()).unwrap();
        let mut answer = [0; 12];
        stream.read_exact(&mut answer).unwrap();
        assert_eq!(&answer[9..], b"413", "{path}");
        // and what is longer than it states nothing about, once it is too long
        let mut stream = server.connect();
        let head =
            head.lines().filter(|line| !line.starts_with("Content-Length")).collect::<Vec<_>>().join("\r\n");
        stream
            .write_all(format!("{}\r\nTransfer-Encoding: chunked\r\n\r\n", head.trim_end()).as_bytes())
            .unwrap();
        let chunk = format!("100000\r\n{}\r\n", " ".repeat(1 << 20));
        for _ in 0..=mib {
            if stream.write_all(chunk.as_bytes()).is_err() {
                break;
            }
        }
        let _ = stream.write_all(b"0\r\n\r\n");
        // the answer may be lost where the server has closed the connection on what is still sent
        let mut answer = Vec::new();
        let _ = stream.take(12).read_to_end(&mut answer);
        assert!(answer.is_empty() || &answer[9..] == b"413", "{path}: {}", String::from_utf8_lossy(&answer));
    }
    assert_eq!(server.get("/api/products").json(), serde_json::json!([]));
}
