//! `run` through the wire, from outside: the published head owns process and renderer, the run owns
//! gauge and control. The same seed gives the same diameters as in one process, to the bit, also
//! where packets and triggers are lost; a head that is gone or does not fit is named.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

#[path = "support/gige_client.rs"]
mod gige_client;
#[path = "support/program.rs"]
mod program;
#[path = "support/published.rs"]
mod published;
#[path = "support/small_job.rs"]
mod small_job;

use std::fs::File;
use std::net::{Ipv4Addr, SocketAddrV4};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::record::Field;

use gige_client::Client;
use program::said;
use published::published;
use small_job::TWO_PASSES as JOB;

/// An address of a test's own.
fn own_address(test: u8) -> Ipv4Addr {
    published::own_address(120 + test)
}

/// A job in a folder, with the head that it takes its frames from.
fn written(folder: &Path, name: &str, job: &str, head: Option<Ipv4Addr>) -> PathBuf {
    let source = head.map_or_else(String::new, |address| format!("source = \"gige:{address}\"\n"));
    let path = folder.join(format!("{name}.toml"));
    std::fs::write(&path, format!("{source}{job}")).unwrap();
    path
}

fn run_command(config: &Path, out: &Path) -> Command {
    let mut command = Command::new(program::path());
    command.arg("run").arg(config).arg("--out").arg(out).env("NO_COLOR", "1");
    command.args(["--backend", "cpu", "--no-reference", "--json"]);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn run(config: &Path, out: &Path) -> Output {
    run_command(config, out).output().unwrap()
}

/// The run in one process, without a wire.
fn alone(folder: &Path) -> PathBuf {
    let out = folder.join("alone");
    let output = run(&written(folder, "alone", JOB, None), &out);
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", said(&output));
    out
}

/// Columns of a CSV table by name, row by row.
fn columns(folder: &Path, table: &str, names: &[&str]) -> Vec<Vec<String>> {
    let mut reader = csv::Reader::from_path(folder.join(table)).unwrap();
    let header = reader.headers().unwrap().clone();
    let places: Vec<usize> =
        names.iter().map(|name| header.iter().position(|h| h == *name).unwrap()).collect();
    let row = |r: csv::StringRecord| places.iter().map(|&i| r[i].to_owned()).collect();
    reader.records().map(|r| row(r.unwrap())).collect()
}

/// Diameters of all frames: every column but those of the config's hash and of the head's clock,
/// numbers by their bits.
fn diameters(folder: &Path) -> Vec<Vec<String>> {
    let file = File::open(folder.join("diameters.parquet")).unwrap();
    let reader = SerializedFileReader::new(file).unwrap();
    let shown = |field: &Field| match field {
        Field::Double(value) => format!("{:016x}", value.to_bits()),
        other => other.to_string(),
    };
    let is_same = |name: &str| !["run_id", "t_ns"].contains(&name);
    let rows = reader.get_row_iter(None).unwrap().map(|row| {
        let row = row.unwrap();
        let own = row.get_column_iter().filter(|(name, _)| is_same(name));
        own.map(|(name, field)| format!("{name} {}", shown(field))).collect()
    });
    rows.collect()
}

const MEASURED: [&str; 5] = ["pass", "z_mm", "d_mm", "u_random_mm", "u_common_mm"];
const OFFSETS: [&str; 6] = ["pass", "z_mm", "offset_mm", "asked_mm", "commanded_mm", "status"];

/// Two runs measured the same, to the bit, from the calibration on the masters to the last offset.
fn assert_same(alone: &Path, wired: &Path) {
    let all = diameters(alone);
    // two passes of 20 frames, each of some intervals
    assert!(all.len() > 500 && all[0].len() >= 8, "{} rows, {:?}", all.len(), all[0]);
    for (row, (a, b)) in all.iter().zip(&diameters(wired)).enumerate() {
        assert_eq!(a, b, "row {row} of diameters.parquet");
    }
    assert_eq!(all.len(), diameters(wired).len());
    let calibration = |folder: &Path| -> serde_json::Value {
        serde_json::from_str(&std::fs::read_to_string(folder.join("calibration.json")).unwrap()).unwrap()
    };
    let mut of_wire = calibration(wired);
    let camera = of_wire.as_object_mut().unwrap().remove("camera");
    assert_eq!(camera.expect("a camera")["serial_number"], "SG-5");
    assert_eq!(calibration(alone), of_wire, "the calibration on the masters");
    assert_eq!(columns(alone, "stations.csv", &MEASURED), columns(wired, "stations.csv", &MEASURED));
    assert_eq!(columns(alone, "offsets.csv", &OFFSETS), columns(wired, "offsets.csv", &OFFSETS));
    let pins = |folder: &Path| -> Vec<serde_json::Value> {
        let text = std::fs::read_to_string(folder.join("control.json")).unwrap();
        let record: serde_json::Value = serde_json::from_str(&text).unwrap();
        let passes = record["passes"].as_array().unwrap();
        passes.iter().map(|pass| pass["evidence"]["origin"]["master_deviation_mm"].clone()).collect()
    };
    assert!(pins(alone).iter().all(serde_json::Value::is_f64), "{:?}", pins(alone));
    assert_eq!(pins(alone), pins(wired), "the check pin after every pass");
}

#[test]
fn a_run_through_the_wire_is_the_run_in_one_process_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let alone = alone(folder);
    let address = own_address(1);
    // the same file for both ends
    let config = written(folder, "wired", JOB, Some(address));
    let _head = published(&config, address);
    // the second run finds a head that has cut a part already
    for name in ["first", "second"] {
        let out = folder.join(name);
        let output = run(&config, &out);
        assert!(matches!(output.status.code(), Some(0 | 1)), "{name}: {}", said(&output));
        assert_same(&alone, &out);
        assert!(!out.join("truth.parquet").exists(), "no truth comes through the wire");
        assert_eq!(program::json(&output)["backend"], "head");
    }
    let mut client = Client::new(SocketAddrV4::new(address, 3956));
    let left = ["TriggerMode", "HeadObject", "HeadFrame"].map(|name| client.get(name));
    assert_eq!(left, [0, 0, 0], "what was set is restored at the end");
}

#[test]
fn lost_packets_and_triggers_change_no_diameter() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let alone = alone(folder);
    let address = own_address(2);
    let config = written(folder, "faulty", JOB, Some(address));
    let _head = published(&config, address);
    let mut client = Client::new(SocketAddrV4::new(address, 3956));
    client.take_control(2).unwrap();
    for (fault, every) in [
        ("FaultPacketLoss", 5),
        ("FaultTriggerIgnored", 11),
        ("FaultTriggerDoubled", 7),
        ("FaultDuplicate", 5),
        ("FaultWrongSize", 13),
    ] {
        client.set(fault, every);
    }
    client.write_register(0x0A00, 0).unwrap();
    let out = folder.join("faulty");
    let output = run(&config, &out);
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", said(&output));
    assert!(client.get("TriggersMissed") >= 3, "{} triggers were ignored", client.get("TriggersMissed"));
    assert_same(&alone, &out);
}

/// A head that is gone within the second pass: the first one is kept, and the same command line
/// goes on at a head that is published anew.
#[test]
fn a_head_that_is_gone_leaves_the_finished_passes_and_the_run_is_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let alone = alone(folder);
    let address = own_address(3);
    let config = written(folder, "gone", JOB, Some(address));
    let out = folder.join("gone");
    let head = published(&config, address);
    let mut running = run_command(&config, &out).spawn().unwrap();
    while !out.join("passes.csv").is_file() {
        assert!(running.try_wait().unwrap().is_none(), "the run ended before its first pass");
        std::thread::sleep(Duration::from_millis(2));
    }
    drop(head);
    let output = running.wait_with_output().unwrap();
    let words = said(&output);
    assert!(output.status.code() == Some(3) && words.contains("the head is gone"), "{words}");
    assert_eq!(columns(&out, "passes.csv", &["pass"]), [["1"]]);
    assert!(!out.join("report.html").exists());

    let _again = published(&config, address);
    let output = run(&config, &out);
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", said(&output));
    assert_same(&alone, &out);
}

/// Runs `JOB` at the head of another config: exit code and words; nothing is written where the job
/// is refused.
fn at_head_of(folder: &Path, published_job: &str, address: Ipv4Addr) -> (Option<i32>, String) {
    let _head = published(&written(folder, "published", published_job, None), address);
    let out = folder.join("refused");
    let output = run(&written(folder, "refused", JOB, Some(address)), &out);
    assert!(output.status.code() != Some(2) || !out.exists(), "something was written");
    let _ = std::fs::remove_dir_all(&out);
    (output.status.code(), said(&output))
}

#[test]
fn a_head_of_another_job_is_refused_by_the_key_that_differs() {
    let folder = tempfile::tempdir().unwrap();
    let other = |from: &str, to: &str| {
        assert!(JOB.contains(from), "{from}");
        JOB.replacen(from, to, 1)
    };
    let cases = [
        (other("length_mm = 60.0", "length_mm = 50.0"), "part.station_mm", "the head 10"),
        (other("[11.5, 11.0]", "[11.5, 11.1]"), "part.nominal_diameter_mm", "pass 2 aims at 11 mm"),
        (other("columns = 512", "columns = 256"), "camera.columns", "Width of the head"),
        (format!("{JOB}[motion]\nspindle_rpm = 300.0\n"), "source", "SpindleSpeed"),
        (
            other("[[masters.pins]]\ndiameter_mm = 12.5\nexpanded_u_mm = 0.0001\n", ""),
            "masters.pins",
            "the head has no pin 2",
        ),
    ];
    for (k, (job, key, words)) in (0..).zip(&cases) {
        let (code, found) = at_head_of(folder.path(), job, own_address(10 + k));
        assert!(code == Some(2) && found.contains(key) && found.contains(words), "{key}: {code:?} {found}");
    }
}

#[test]
fn a_head_that_refuses_a_pass_or_is_absent_is_named_with_its_reason() {
    let folder = tempfile::tempdir().unwrap();
    // a scene that is drawn, in a config that is not run
    let job = format!("{JOB}[control]\nplant_gain = 0.0\n");
    let (code, words) = at_head_of(folder.path(), &job, own_address(4));
    assert!(code == Some(3) && words.contains("the head refuses: the config cuts no part"), "{words}");
    assert!(words.contains("control.plant_gain"), "{words}");

    let nowhere = own_address(5);
    let config = written(folder.path(), "nowhere", JOB, Some(nowhere));
    let output = run(&config, &folder.path().join("nowhere"));
    let words = said(&output);
    assert!(output.status.code() == Some(3) && words.contains("no GigE Vision camera answers"), "{words}");
    assert!(!folder.path().join("nowhere").exists());
}
