//! The *Gauge* page's data: window and drift of a source, calibrations, the store's last check; and
//! configs of runs as a form has them.

use std::time::{SystemTime, UNIX_EPOCH};

use serde_json::{Value, json};

use super::small_job::{ONE_PASS, TWO_PASSES};
use super::{Server, text};

#[test]
fn window_and_drift_of_a_source_are_shown_and_a_source_without_a_zero_has_no_drift() {
    let folder = tempfile::tempdir().unwrap();
    let (config, zeros) = (folder.path().join("head.toml"), folder.path().join("zero.csv"));
    std::fs::write(&config, ONE_PASS).unwrap();
    let now_ns = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos();
    std::fs::write(&zeros, format!("t_ns\n{}\n", now_ns - 3_600_000_000_000)).unwrap();
    let source = format!("sim:{}", text(&config));
    let zeroed = ["--zero", text(&zeros), "--zero-interval-s", "7200", "--zero-um-per-h", "1.2"];
    let server = Server::start(&[&["--source", &source, "--", "--um-per-px", "50"][..], &zeroed].concat());
    let found = server.once("/api/gauge", |found| found["window"].is_object() && found["drift"].is_object());
    // limits of ± 1.2 µm after an hour: 1.2/√3 µm (a rectangular distribution, GUM 4.3.7)
    let u_um = found["drift"]["u_drift_um"].as_f64().unwrap();
    assert!((0.69..0.72).contains(&u_um), "{found}");
    assert!((3600.0..3700.0).contains(&found["drift"]["since_zero_s"].as_f64().unwrap()), "{found}");
    // the simulated head's light is even, and no flat field is calibrated
    let darkest = found["window"]["darkest_percent"].as_f64().unwrap();
    assert!((-2.0..0.5).contains(&darkest) && found["window"]["of_flat"] == false, "{found}");
    assert!(found["is_now"] == true && !found["minutes"].as_array().unwrap().is_empty(), "{found}");
    drop(server);
    let plain = Server::start(&["--source", &source, "--", "--um-per-px", "50"]);
    let found = plain.once("/api/gauge", |found| found["window"].is_object());
    assert!(found["drift"].is_null(), "{found}");
    let none = Server::start(&[]).get("/api/gauge").json();
    assert!(none["is_now"] == false && none["window"].is_null() && none["minutes"] == json!([]), "{none}");
}

#[test]
fn what_is_no_calibration_is_refused_in_words_and_stores_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("store.sqlite");
    let server = Server::start(&["--store", text(&store)]);
    let plan = std::fs::read_to_string("configs/small_calibration.toml").unwrap();
    let made = server.post("/api/calibrations/simulated", &json!({ "config": plan }));
    assert_eq!(made.status, 201, "{}", made.body);
    let listed = server.get("/api/calibrations").json();
    assert!(listed.as_array().unwrap().len() == 1 && listed[0]["unreadable"].is_null(), "{listed}");
    let head = "Content-Type: application/json\r\nX-Shadowgauge: 1\r\n";
    let noise: String = (0..2000_u32).map(|k| char::from((k * 7919 % 251) as u8)).collect();
    let newer = "{\"version\": 999}";
    for (what, body) in
        [("noise", noise.as_str()), ("a setup", plan.as_str()), ("newer", newer), ("none", "")]
    {
        let answer = server.ask("POST", "/api/calibrations", head, body);
        assert_eq!(answer.status, 422, "{what}: {}", answer.body);
        assert!(answer.body.contains("calibrate --out"), "{what}: {}", answer.body);
    }
    let refused = server.ask("POST", "/api/calibrations", head, newer);
    assert!(refused.body.contains("version"), "{}", refused.body);
    let after = server.get("/api/calibrations").json();
    assert_eq!(after.as_array().unwrap().len(), 1, "{after}");
}

#[test]
fn a_store_is_checked_once_until_it_is_written_again() {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("store.sqlite");
    let server = Server::start(&["--store", text(&store)]);
    let machine = std::fs::read_to_string("configs/tool/machine.toml").unwrap();
    let add = |name: &str| {
        let body = json!({ "name": name, "dialect": "linuxcnc", "data": machine });
        assert_eq!(server.post("/api/machines", &body).status, 201);
    };
    add("one");
    let before = server.get("/api/store/state").json();
    assert!(before["checked"].is_null() && before["audit_rows"] == 1, "{before}");
    let found = server.get("/api/store").json();
    assert_eq!(found["findings"], json!([]));
    let known = server.get("/api/store/state").json();
    assert_eq!((&known["checked"], &known["head"]), (&found, &found["head"]));
    add("two");
    let written = server.get("/api/store/state").json();
    assert!(written["checked"].is_null() && written["checked_utc"].is_string(), "{written}");
    assert_eq!(server.get("/api/store").json()["audit_rows"], 2);
}

#[test]
fn a_config_has_values_for_its_form_and_why_it_would_be_refused() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(&["--runs", text(folder.path())]);
    let schema = server.get("/api/config").json();
    let part = schema["properties"]["part"]["$ref"].as_str().unwrap().trim_start_matches("#/$defs/");
    assert!(schema["$defs"][part]["properties"]["stock_diameter_mm"].is_object(), "{part}");
    let look = |config: &str| server.post("/api/config", &json!({ "config": config }));
    let good = look(TWO_PASSES).json();
    assert_eq!((&good["refused"], &good["values"]["seed"]), (&Value::Null, &json!(5)));
    assert_eq!(good["values"]["part"]["nominal_diameter_mm"], json!([11.5, 11.0]));
    let wrong = look(&TWO_PASSES.replace("length_mm", "lenght_mm")).json();
    assert!(wrong["refused"].as_str().unwrap().contains("lenght_mm"), "{wrong}");
    let named = look("[machine]\nfile = \"/etc/passwd\"\n").json();
    assert!(named["refused"].as_str().unwrap().contains("machine.file"), "{named}");
    assert_eq!(look("no toml at all").status, 422);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is stored");
}

#[test]
fn two_servers_on_one_store_lose_nothing_of_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("store.sqlite");
    let servers = [0, 1].map(|_| Server::start(&["--store", text(&store)]));
    let machine = std::fs::read_to_string("configs/tool/machine.toml").unwrap();
    std::thread::scope(|scope| {
        for (k, server) in servers.iter().enumerate() {
            let machine = &machine;
            scope.spawn(move || {
                for j in 0..5 {
                    let name = format!("m{k}{j}");
                    let body = json!({ "name": name, "dialect": "linuxcnc", "data": machine });
                    let answer = server.post("/api/machines", &body);
                    assert_eq!(answer.status, 201, "{name}: {}", answer.body);
                }
            });
        }
    });
    for server in &servers {
        assert_eq!(server.get("/api/machines").json().as_array().unwrap().len(), 10);
        let found = server.get("/api/store").json();
        assert_eq!((&found["findings"], &found["audit_rows"]), (&json!([]), &json!(10)), "{found}");
    }
    let refused = said_of_a_foreign_store(&folder.path().join("foreign.sqlite"));
    assert!(refused.contains("is no store"), "{refused}");
}

/// What `serve` says of a store that is a file of another program.
fn said_of_a_foreign_store(path: &std::path::Path) -> String {
    std::fs::write(path, "a text of another program").unwrap();
    let refused = super::shadowgauge(["serve", "--listen", "127.0.0.1:0", "--store", text(path)]);
    assert_eq!(refused.status.code(), Some(2));
    super::said(&refused)
}
