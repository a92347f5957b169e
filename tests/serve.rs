//! `serve` from outside: pages and API over a socket, runs started and shown, who may do what.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

#[path = "serve/bounds.rs"]
mod bounds;
#[path = "serve/browser.rs"]
mod browser;
#[path = "serve/gauge.rs"]
mod gauge;
#[path = "serve/kept.rs"]
mod kept;
#[path = "support/program.rs"]
mod program;
#[path = "support/small_job.rs"]
mod small_job;

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use program::{said, shadowgauge};
use serde_json::{Value, json};
use small_job::TWO_PASSES as SMALL;

/// A server that ends with the test.
struct Server {
    program: Child,
    host: String,
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = (self.program.kill(), self.program.wait());
    }
}

/// Status and body of an answer.
struct Answer {
    status: u16,
    head: String,
    body: String,
}

impl Answer {
    fn json(&self) -> Value {
        serde_json::from_str(&self.body).unwrap_or_else(|e| panic!("{e}: {}", self.body))
    }
}

impl Server {
    fn start(arguments: &[&str]) -> Self {
        let all = [&["serve", "--listen", "127.0.0.1:0"], arguments].concat();
        let mut program =
            Command::new(program::path()).args(all).stdout(Stdio::piped()).spawn().expect("the program runs");
        let mut line = String::new();
        BufReader::new(program.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let host = line.trim().trim_start_matches("http://").trim_end_matches('/').to_owned();
        Self { program, host }
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(&self.host).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        stream
    }

    fn ask(&self, method: &str, path: &str, headers: &str, body: &str) -> Answer {
        let host = if headers.contains("Host:") { String::new() } else { format!("Host: {}\r\n", self.host) };
        let text = format!(
            "{method} {path} HTTP/1.1\r\n{host}{headers}Connection: close\r\nContent-Length: {}\r\n\r\n{body}",
            body.len()
        );
        let mut stream = self.connect();
        // a body that is too long is refused before it is whole
        let _ = stream.write_all(text.as_bytes());
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        let answer = String::from_utf8_lossy(&answer).into_owned();
        let (head, body) = answer.split_once("\r\n\r\n").unwrap_or((&answer, ""));
        let status = head.split_whitespace().nth(1).and_then(|s| s.parse().ok()).unwrap_or(0);
        Answer { status, head: head.to_owned(), body: body.to_owned() }
    }

    fn get(&self, path: &str) -> Answer {
        self.ask("GET", path, "", "")
    }

    fn post(&self, path: &str, body: &Value) -> Answer {
        let headers = "Content-Type: application/json\r\nX-Shadowgauge: 1\r\n";
        self.ask("POST", path, headers, &body.to_string())
    }
}

impl Server {
    /// What a path answers once it fulfils something.
    fn once(&self, path: &str, fulfils: impl Fn(&Value) -> bool) -> Value {
        let until = Instant::now() + Duration::from_secs(180);
        loop {
            let found = self.get(path).json();
            if fulfils(&found) {
                return found;
            }
            assert!(Instant::now() < until, "{found}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// The events of a stream as they come.
    fn events(&self, path: &str) -> impl Iterator<Item = Value> {
        let mut stream = self.connect();
        write!(stream, "GET {path} HTTP/1.1\r\nHost: {}\r\n\r\n", self.host).unwrap();
        let lines = BufReader::new(stream).lines().map_while(Result::ok);
        lines.filter_map(|line| serde_json::from_str(line.strip_prefix("data: ")?).ok())
    }
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
fn a_run_is_started_on_the_page_followed_and_found_in_the_store() {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("store.sqlite");
    let server = Server::start(&["--runs", text(folder.path()), "--store", text(&store)]);
    let started = server.post("/api/runs", &json!({ "run": "first", "config": SMALL }));
    assert_eq!(started.status, 202, "{}", started.body);
    let again = server.post("/api/runs", &json!({ "run": "first", "config": SMALL }));
    assert_eq!(again.status, 409, "{}", again.body);
    let until = Instant::now() + Duration::from_secs(120);
    while server.get("/api/runs/first/report").status != 200 {
        assert!(Instant::now() < until, "{}", server.get("/api/jobs").body);
        std::thread::sleep(Duration::from_millis(100));
    }
    let run = server.get("/api/runs/first").json();
    assert_eq!(run["passes"].as_array().unwrap().len(), 2, "{run}");
    let job = server.get("/api/jobs/first").json();
    assert_eq!((&job["passes"], &job["passes_planned"]), (&json!(2), &json!(2)), "{job}");
    assert_eq!(server.get("/api/jobs/other").status, 404);
    let list = server.get("/api/runs?name=fir").json();
    assert_eq!((&list["total"], &list["runs"][0]["finished"]), (&json!(1), &json!(true)));
    assert_eq!(server.get("/api/runs?name=other").json()["total"], 0);
    // what the page shows of the run and of the store is the same
    let history = server.get("/api/history").json();
    let shown = run["passes"][1]["d_mm"].as_array().unwrap();
    let stored = history["stations"].as_array().unwrap();
    assert_eq!(stored.len(), 2 * shown.len());
    assert!(stored[shown.len()..].iter().zip(shown).all(|(s, d)| s["d_mm"] == *d), "{history}");
    let state = server.get("/api/store").json();
    assert_eq!((&state["findings"], &state["passes"]), (&json!([]), &json!(2)));
}

#[test]
fn every_route_that_is_documented_is_served() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(&["--runs", text(folder.path())]);
    let document = server.get("/api/openapi.json").json();
    let paths = document["paths"].as_object().unwrap();
    assert!(paths.len() >= 8, "{paths:?}");
    for (path, methods) in paths {
        if matches!(path.as_str(), "/api/live" | "/api/events") {
            continue;
        }
        for method in methods.as_object().unwrap().keys() {
            let asked = ["{run}", "{name}", "{id}"]
                .iter()
                .fold(path.clone(), |path, word| path.replace(word, "none"));
            let headers = "Content-Type: application/json\r\nX-Shadowgauge: 1\r\n";
            let answer = server.ask(&method.to_uppercase(), &asked, headers, "{}");
            let is_no_route = answer.body.contains("no such page") || answer.status == 405;
            assert!(!is_no_route, "{method} {path}: {} {}", answer.status, answer.body);
        }
    }
    for page in [
        "/",
        "/base.js",
        "/page.js",
        "/live.js",
        "/picture.js",
        "/programs.js",
        "/runs.js",
        "/form.js",
        "/compare.js",
        "/health.js",
        "/history.js",
        "/setup.js",
        "/gauge.js",
        "/page.css",
        "/uplot.js",
        "/uplot.css",
        "/uplot.txt",
    ] {
        let answer = server.get(page);
        assert_eq!(answer.status, 200, "{page}");
        let head = answer.head.to_lowercase();
        assert!(head.contains("default-src 'none'") && head.contains("nosniff"), "{head}");
        let elsewhere = answer.body.contains("src=\"http") || answer.body.contains("@import");
        assert!(!elsewhere, "{page} loads from elsewhere");
    }
}

#[test]
fn what_comes_from_elsewhere_is_refused_and_what_may_only_read_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(&["--runs", text(folder.path())]);
    // another site's name that points here
    assert_eq!(server.ask("GET", "/api/runs", "Host: gauge.example\r\n", "").status, 421);
    // a form of another site: no header of its own
    let body = json!({ "run": "x", "config": SMALL }).to_string();
    let json_only = "Content-Type: application/json\r\n";
    assert_eq!(server.ask("POST", "/api/runs", json_only, &body).status, 403);
    let foreign = format!("{json_only}X-Shadowgauge: 1\r\nOrigin: http://gauge.example\r\n");
    assert_eq!(server.ask("POST", "/api/runs", &foreign, &body).status, 403);
    let readers = Server::start(&["--runs", text(folder.path()), "--read-only"]);
    assert_eq!(readers.post("/api/runs", &json!({ "run": "x", "config": SMALL })).status, 403);
    assert_eq!(readers.get("/api/runs").status, 200);
    let tokens = folder.path().join("tokens.toml");
    let two = "[[token]]\nname = \"a\"\nrole = \"view\"\ntoken = \"0123456789abcdef\"\n\
               [[token]]\nname = \"b\"\nrole = \"operate\"\ntoken = \"fedcba9876543210\"\n";
    std::fs::write(&tokens, two).unwrap();
    let guarded = Server::start(&["--runs", text(folder.path()), "--tokens", text(&tokens)]);
    assert_eq!(guarded.get("/api/runs").status, 401);
    // the page that asks for the token
    assert_eq!((guarded.get("/").status, guarded.get("/base.js").status), (200, 200));
    let view = "Authorization: Bearer 0123456789abcdef\r\n";
    assert_eq!(guarded.ask("GET", "/api/runs", view, "").status, 200);
    let change = |token: &str| format!("{json_only}X-Shadowgauge: 1\r\nAuthorization: Bearer {token}\r\n");
    assert_eq!(guarded.ask("POST", "/api/runs/x/stop", &change("0123456789abcdef"), "{}").status, 403);
    assert_eq!(guarded.ask("POST", "/api/runs/x/stop", &change("fedcba9876543210"), "{}").status, 409);
    assert!(!folder.path().join("x").exists() && !folder.path().join("x.toml").exists());
}

#[test]
fn configs_that_name_files_and_names_that_are_paths_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(&["--runs", text(folder.path())]);
    let cases = [
        ("../up", SMALL.to_owned(), 422, "letters"),
        ("ok", format!("{SMALL}\n[machine]\nfile = \"/etc/passwd\"\n"), 422, "machine.file"),
        ("ok", SMALL.replace("length_mm", "lenght_mm"), 422, "lenght_mm"),
        ("ok", "no toml at all".to_owned(), 422, ""),
    ];
    for (run, config, status, words) in cases {
        let answer = server.post("/api/runs", &json!({ "run": run, "config": config }));
        assert_eq!(answer.status, status, "{}", answer.body);
        assert!(answer.body.contains(words), "{}", answer.body);
    }
    for path in
        ["/api/runs/..%2f..%2fetc", "/api/runs/%2e%2e", "/api/history?from=yesterday", "/../Cargo.toml"]
    {
        let status = server.get(path).status;
        assert!(matches!(status, 400 | 404 | 422), "{path}: {status}");
    }
    let large = server.post("/api/runs", &json!({ "run": "big", "config": "#".repeat(2 << 20) }));
    assert!(matches!(large.status, 413 | 0), "{}", large.status);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn live_lines_come_as_they_are_measured_and_a_dead_source_reads_invalid() {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("head.toml");
    std::fs::write(&config, SMALL).unwrap();
    let source = format!("sim:{}", text(&config));
    let server = Server::start(&["--source", &source, "--", "--um-per-px", "50"]);
    let frame = server.events("/api/live").find(|v| v["valid"] == true);
    let frame = frame.expect("no frame with a diameter came");
    // what the page reads of a line is in it
    let script = server.get("/live.js").body;
    for key in ["max_diameter_mm", "expanded_u_max_mm", "latency_ms"] {
        assert!(frame[key].is_number() && script.contains(&format!("line.{key}")), "{key}: {frame}");
    }
    let dead = Server::start(&["--source", text(&folder.path().join("absent")), "--", "--um-per-px", "50"]);
    let line = dead.events("/api/events").next().unwrap().to_string();
    assert!(line.contains("\"invalid\"") && line.contains("absent"), "{line}");
}

#[test]
fn a_port_that_is_taken_and_an_address_beyond_this_machine_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(&["--runs", text(folder.path())]);
    let taken = shadowgauge(["serve", "--listen", &server.host]);
    assert_eq!(taken.status.code(), Some(3));
    assert!(said(&taken).contains("another port"), "{}", said(&taken));
    let beyond = shadowgauge(["serve", "--listen", "0.0.0.0:0"]);
    assert_eq!(beyond.status.code(), Some(2));
    assert!(said(&beyond).contains("--tls-cert") && said(&beyond).contains("--tokens"), "{}", said(&beyond));
    let id = server.program.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let mut server = server;
    assert_eq!(server.program.wait().unwrap().code(), Some(0), "Ctrl-C ends with 0");
}

/// Places that a program moves to in feed, Z and X (diameter) in mm.
fn places(program: &str) -> Vec<[f64; 2]> {
    let (mut at, mut all, mut in_feed) = ([None, None], Vec::new(), false);
    for line in program.lines() {
        let code = line.split(['(', ';']).next().unwrap_or_default();
        let mut moves = false;
        for word in code.split_whitespace() {
            let axis = match word {
                "G0" | "G00" => {
                    in_feed = false;
                    continue;
                }
                "G1" | "G01" | "G2" | "G02" | "G3" | "G03" => {
                    in_feed = true;
                    continue;
                }
                _ if word.starts_with('Z') => 0,
                _ if word.starts_with('X') => 1,
                _ => continue,
            };
            if let Ok(value) = word[1..].parse::<f64>() {
                (at[axis], moves) = (Some(value), true);
            }
        }
        if let ([Some(z), Some(x)], true) = (at, moves && in_feed) {
            all.push([z, x]);
        }
    }
    all
}

/// Distance of a place from a polyline; X as a radius, mm.
fn distance_mm(p: [f64; 2], line: &[[f64; 2]]) -> f64 {
    let of = |w: &[[f64; 2]]| {
        let at = |q: [f64; 2]| [q[0], 0.5 * q[1]];
        let ([pz, px], [az, ax], [bz, bx]) = (at(p), at(w[0]), at(w[1]));
        let (dz, dx) = (bz - az, bx - ax);
        let length = (dz * dz + dx * dx).max(f64::MIN_POSITIVE);
        let share = (((pz - az) * dz + (px - ax) * dx) / length).clamp(0.0, 1.0);
        (pz - az - share * dz).hypot(px - ax - share * dx)
    };
    line.windows(2).map(of).fold(f64::INFINITY, f64::min)
}

#[test]
fn a_product_a_tool_and_a_machine_make_the_program_that_is_drawn() {
    let read = |name: &str| std::fs::read_to_string(format!("configs/tool/{name}")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("store.sqlite");
    let server = Server::start(&["--runs", text(folder.path()), "--store", text(&store)]);
    let nose = read("nose.json");
    let product = json!({ "name": "shaft", "outline": read("outline.toml") });
    let tool = json!({ "name": "finishing", "tool": read("tool.toml"), "nose": nose });
    let machine = json!({ "name": "lathe", "dialect": "linuxcnc", "data": read("machine.toml") });
    for (kind, body) in [("products", &product), ("tools", &tool), ("machines", &machine)] {
        let added = server.post(&format!("/api/{kind}"), body);
        assert_eq!(added.status, 201, "{kind}: {}", added.body);
        assert_eq!(server.post(&format!("/api/{kind}"), body).status, 409, "{kind} twice");
        assert_eq!(server.get(&format!("/api/{kind}")).json()[0]["name"], body["name"]);
        let one = format!("/api/{kind}/{}", body["name"].as_str().unwrap());
        assert_eq!(server.get(&one).json()["name"], body["name"], "{one}");
    }
    assert!(server.get("/api/products/shaft/contour").json()["points_mm"].as_array().unwrap().len() > 2);
    let asked = json!({
        "product": "shaft", "tool": "finishing", "machine": "lathe", "mode": "compensated", "way": "path"
    });
    let accepted = server.post("/api/programs", &asked);
    assert_eq!(accepted.status, 202, "{}", accepted.body);
    let id = accepted.json()["id"].as_str().unwrap().to_owned();
    let until = Instant::now() + Duration::from_secs(120);
    let made = loop {
        let found = server.get(&format!("/api/programs/{id}")).json();
        if found["program"]["state"] != "running" {
            break found;
        }
        assert!(Instant::now() < until, "{found}");
        std::thread::sleep(Duration::from_millis(50));
    };
    assert_eq!(made["program"]["state"], "made", "{made}");
    assert!(!made["program"]["changed_lines"].as_array().unwrap().is_empty(), "{made}");
    drawn_as_downloaded_and_kept(&server, &id);
    what_is_missing_is_refused(&server, &read("machine.toml"));
}

fn drawn_as_downloaded_and_kept(server: &Server, id: &str) {
    let program = server.get(&format!("/api/programs/{id}/nc")).body;
    let path = server.get(&format!("/api/programs/{id}/path")).json();
    let lines: Vec<Vec<[f64; 2]>> = path["polylines"]
        .as_array()
        .unwrap()
        .iter()
        .map(|line| serde_json::from_value(line["points_mm"].clone()).unwrap())
        .collect();
    let all = places(&program);
    assert!(all.len() > 10, "{program}");
    for place in all {
        let nearest = lines.iter().map(|line| distance_mm(place, line)).fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-4, "{place:?} lies {nearest} mm beside what is drawn\n{program}");
    }
    // what it was made from may go; the program stays, and the store is whole
    let gone = server.ask("DELETE", "/api/products/shaft", "X-Shadowgauge: 1\r\n", "");
    assert_eq!(gone.status, 204, "{}", gone.body);
    assert_eq!(server.get(&format!("/api/programs/{id}/nc")).body, program);
    assert_eq!(server.get("/api/store").json()["findings"], json!([]));
}

fn what_is_missing_is_refused(server: &Server, machine: &str) {
    // what is missing or names a path is refused in words
    for (method, place, status) in [
        ("GET", "/api/products/none/contour", 404),
        ("GET", "/api/programs/..%2f..%2fetc/nc", 404),
        ("DELETE", "/api/tools/..%2fx", 404),
    ] {
        let answer = server.ask(method, place, "X-Shadowgauge: 1\r\n", "");
        assert!(
            answer.status == status || answer.status == 422,
            "{place}: {} {}",
            answer.status,
            answer.body
        );
    }
    let linuxcnc =
        server.post("/api/machines", &json!({ "name": "of_fanuc", "dialect": "fanuc", "data": machine }));
    assert!(
        linuxcnc.status == 422 && linuxcnc.body.contains("wear_x"),
        "{} {}",
        linuxcnc.status,
        linuxcnc.body
    );
    for (name, data) in [("../x", machine.to_owned()), ("empty", String::new())] {
        let wrong = json!({ "name": name, "dialect": "fanuc", "data": data });
        assert_eq!(server.post("/api/machines", &wrong).status, 422, "{name}");
    }
    let asked = json!({ "product": "none", "tool": "finishing", "machine": "lathe", "mode": "plain" });
    let refused = server.post("/api/programs", &asked);
    assert!(refused.status == 404 && refused.body.contains("none"), "{} {}", refused.status, refused.body);
}
