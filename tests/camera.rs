//! `measure` and `watch` of GigE Vision cameras, from outside: our published head on an address of
//! its own, the fake cameras of Aravis and of viva-genicam where they are installed, and cameras
//! that are refused.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

#[path = "support/gige_client.rs"]
mod gige_client;
#[path = "support/program.rs"]
mod program;
#[path = "support/published.rs"]
mod published;
#[path = "support/small_job.rs"]
mod small_job;
#[path = "support/streamed.rs"]
mod streamed;

use std::io::{BufRead as _, BufReader};
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;

use program::{said, shadowgauge, text};
use published::{Published, published};
use small_job::ONE_PASS as JOB;
use streamed::Running;

const CONFIG: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/small_shaft.toml");

/// An address of a test's own.
fn own_address(test: u8) -> Ipv4Addr {
    published::own_address(100 + test)
}

/// The small shaft at one place and one angle: a free run draws the frames of its scan.
fn still_config(folder: &Path) -> PathBuf {
    let whole = std::fs::read_to_string(CONFIG).unwrap();
    let one = whole.replace("fields = 5", "fields = 1").replace("angles = 8", "angles = 1");
    assert_eq!(one.matches("= 1\n").count(), 2, "{one}");
    let path = folder.join("still.toml");
    // ten frames a second: a loaded machine loses none
    std::fs::write(&path, one.replace("[camera]\n", "[camera]\nframe_period_ms = 100.0\n")).unwrap();
    path
}

#[cfg(unix)]
fn interrupt(running: &Running) {
    let id = running.child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
}

/// The frames of the wire are those of files: the same numbers, the same values to the bit.
#[cfg(unix)]
#[test]
fn the_published_head_measures_as_the_frames_that_render_writes() {
    let folder = tempfile::tempdir().unwrap();
    let config = still_config(folder.path());
    let out = folder.path().join("out");
    let render = ["render", config.to_str().unwrap(), "--frames", "40", "--backend", "cpu", "--out"];
    let output = shadowgauge(render.into_iter().chain([out.to_str().unwrap()]));
    assert!(output.status.success(), "{}", said(&output));
    let frames = out.join("frames");
    let from_files =
        program::json(&shadowgauge(["measure", frames.to_str().unwrap(), "--json", "--um-per-px", "30"]));
    let head = published(&config, own_address(1));
    let running = Running::start(&[&head.source(), "--json", "--um-per-px", "30"]);
    for _ in 0..3 {
        let frame = running.json();
        let number = frame["sequence"].as_u64().unwrap();
        let file = &from_files["frames"][number as usize];
        assert_eq!(frame["frame"], file["frame"], "{frame}");
        for key in ["max_diameter_mm", "mean_diameter_mm", "max_diameter_px", "valid"] {
            assert!(frame[key].is_number() && frame[key] == file[key], "{key}: {frame} {file}");
        }
        assert!(frame["device_t_ns"].is_u64() && frame["host_t_ns"].is_u64(), "{frame}");
    }
    interrupt(&running);
    assert_eq!(running.end().0, Some(0));
}

/// Exposure is set when it is asked for, and the camera has its own back at the end, chunks off.
#[cfg(unix)]
#[test]
fn what_is_set_is_restored_at_the_end() {
    let folder = tempfile::tempdir().unwrap();
    let head = published(&still_config(folder.path()), own_address(2));
    let mut client = head.client();
    assert_eq!((client.float("ExposureTime"), client.get("ChunkModeActive")), (50.0, 0));
    for command in ["watch", "measure"] {
        let running =
            Running::of(command, &[&head.source(), "--json", "--um-per-px", "30", "--exposure-us", "40"]);
        let frame = running.json();
        if command == "watch" {
            let exposure = &frame["exposure_us"];
            assert_eq!((&exposure["value"], &exposure["from"]), (&40.0.into(), &"chunk".into()), "{frame}");
            assert_eq!(&frame["angle_deg"]["from"], "chunk", "{frame}");
            let [exposed, host] = ["exposed_host_t_ns", "host_t_ns"].map(|key| frame[key].as_u64().unwrap());
            assert!(exposed < host && host - exposed < 10_000_000_000, "{frame}");
        }
        assert_eq!((client.float("ExposureTime"), client.get("ChunkModeActive")), (40.0, 1));
        // a second client is refused, the first one loses nothing
        let output = shadowgauge(["measure", &head.source()]);
        assert!(output.status.code() == Some(3) && said(&output).contains("busy"), "{}", said(&output));
        interrupt(&running);
        running.end();
        assert_eq!((client.float("ExposureTime"), client.get("ChunkModeActive")), (50.0, 0), "{command}");
    }
}

/// Window, pacing and packet size are set by their features, and restored.
#[cfg(unix)]
#[test]
fn features_are_set_by_name_and_restored() {
    let folder = tempfile::tempdir().unwrap();
    let head = published(&still_config(folder.path()), own_address(11));
    let mut client = head.client();
    let before = ["Height", "GevSCPD"].map(|name| client.get(name));
    let source = head.source();
    let mut given = vec![source.as_str(), "--json", "--um-per-px", "30"];
    for feature in ["Height=256", "GevSCPD=2000", "GevSCPSPacketSize=1400"] {
        given.extend(["--feature", feature]);
    }
    let running = Running::of("measure", &given);
    running.json();
    assert_eq!(["Height", "GevSCPD", "GevSCPSPacketSize"].map(|name| client.get(name)), [256, 2000, 1400]);
    interrupt(&running);
    running.end();
    assert_eq!(["Height", "GevSCPD"].map(|name| client.get(name)), before);
    for (feature, code, part) in [
        ("Height", 2, "TriggerMode=On"),
        ("GevSCPSPacketSize=small", 3, "a number of bytes"),
        ("NoSuchFeature=1", 3, "NoSuchFeature"),
        ("PixelFormat=RGB8", 3, "PixelFormat"),
    ] {
        let output = shadowgauge(["measure", &source, "--feature", feature]);
        let words = said(&output);
        assert!(output.status.code() == Some(code) && words.contains(part), "{feature}: {words}");
    }
}

/// `measure` ends with the reason and exit code 3 where its camera is gone.
#[test]
fn a_camera_that_is_killed_ends_a_series_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let mut head = published(&still_config(folder.path()), own_address(3));
    let mut command = Command::new(program::path());
    command.args(["measure", &head.source(), "--json"]).env("NO_COLOR", "1");
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let first: Value = serde_json::from_str(&lines.next().unwrap().unwrap()).unwrap();
    assert!(first["max_diameter_px"].is_number(), "{first}");
    head.kill();
    lines.for_each(drop);
    let output = child.wait_with_output().unwrap();
    let words = said(&output);
    assert!(output.status.code() == Some(3) && words.contains("the camera is gone"), "{words}");
}

/// `watch` is invalid while its camera is away, and measures again when it is back.
#[cfg(unix)]
#[test]
fn a_camera_that_returns_is_watched_again() {
    let folder = tempfile::tempdir().unwrap();
    let config = still_config(folder.path());
    let mut head = published(&config, own_address(4));
    let running = Running::of("watch", &[&head.source(), "--json", "--um-per-px", "30"]);
    let frame = |line: &Value| line["sequence"].as_u64();
    let mut last = frame(&running.json()).unwrap();
    head.kill();
    loop {
        let line = running.json();
        last = frame(&line).unwrap_or(last);
        if line["event"] == "invalid" && line["why"].as_str().is_some_and(|why| why.contains("answer")) {
            break;
        }
    }
    let _again = published(&config, head.address);
    let next = std::iter::repeat_with(|| running.json()).find_map(|line| frame(&line)).unwrap();
    assert!(next > last, "numbers go on: {next} after {last}");
    interrupt(&running);
    let (_, rest) = running.end();
    assert!(rest.iter().any(|line| line.contains("\"disappeared\":1")), "{rest:?}");
}

/// A frame of another size is a gap with its reason, never measured.
#[cfg(unix)]
#[test]
fn frames_of_another_size_are_gaps() {
    let folder = tempfile::tempdir().unwrap();
    let head = published(&still_config(folder.path()), own_address(5));
    let mut client = head.client();
    client.take_control(2).unwrap();
    client.set("FaultWrongSize", 2);
    client.write_register(0x0A00, 0).unwrap();
    let running = Running::of("watch", &[&head.source(), "--json"]);
    let lines: Vec<Value> = std::iter::repeat_with(|| running.json()).take(6).collect();
    let gap = lines.iter().find(|line| line["event"] == "gap").expect("a gap");
    let why = gap["why"].as_str().unwrap();
    assert!(why.contains("512 x 511 Mono12 came in place of 512 x 512 Mono12"), "{why}");
    let rows = lines.iter().filter(|line| line["event"].is_null()).map(|line| &line["columns"]);
    assert!(rows.clone().count() >= 2 && rows.into_iter().all(|columns| columns == 512), "{lines:?}");
    interrupt(&running);
    running.end();
}

/// A plan of the job's pins: keys of the whole, and where the frames of each pin are.
fn plan(keys: &str, positions: [&str; 2], tables: &str) -> String {
    let mut text = format!("optics_id = \"head\"\ndate = \"2026-11-22\"\n{keys}\n");
    for (name, diameter_mm, position) in [("small", 10.0, positions[0]), ("large", 12.5, positions[1])] {
        text += &format!(
            "[[masters]]\nname = \"{name}\"\ndiameter_mm = {diameter_mm:?}\nexpanded_u_mm = 0.0001\n\
             positions = [{{ {position} }}]\n"
        );
    }
    text + tables
}

/// The calibration of a plan, as a file and as what is in it.
fn calibrated(folder: &Path, name: &str, plan: &str) -> (String, Value) {
    let [config, out] = ["toml", "json"].map(|kind| folder.join(format!("{name}.{kind}")));
    std::fs::write(&config, plan).unwrap();
    let [config, out] = [config, out].map(|path| path.display().to_string());
    let output = shadowgauge(["calibrate", &config, "--out", &out, "--backend", "cpu"]);
    assert!(output.status.success(), "{name}: {}", said(&output));
    let text = std::fs::read_to_string(&out).unwrap();
    (out, serde_json::from_str(&text).unwrap())
}

/// The published head places its pins and fields itself: the same frames as those that a run
/// records and `calibrate` renders, and the same calibration to the bit, bound to the head.
#[cfg(unix)]
#[test]
fn a_calibration_with_the_head_is_that_of_the_same_frames_in_files() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let path = |name: &str| folder.join(name).display().to_string();
    std::fs::write(path("job.toml"), JOB).unwrap();
    let run = ["run", &path("job.toml"), "--out", &path("run"), "--record", &path("rec")];
    let output = shadowgauge(run.into_iter().chain(["--no-reference", "--backend", "cpu"]));
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", said(&output));
    let head = published(&folder.join("job.toml"), own_address(7));
    let source = format!("source = \"{}\"\nframes_each = 2", head.source());
    let pins = ["frames = \"rec/masters/pin_1\"", "frames = \"rec/masters/pin_2\""];
    let (_, recorded) = calibrated(folder, "recorded", &plan("", pins, ""));
    let (_, mut live) = calibrated(folder, "live", &plan(&source, ["", ""], ""));
    let camera = live.as_object_mut().unwrap().remove("camera").unwrap();
    assert_eq!(live, recorded);
    assert_eq!((&camera["serial_number"], &camera["gain_db"]), (&"SG-5".into(), &0.0.into()), "{camera}");
    assert_eq!(camera["window"]["columns"], 512, "{camera}");
    let flats = "[fields]\nflats = [{ exposure = 0.25 }, { exposure = 0.4 }, { exposure = 0.6 }, { exposure = 1.0 }]\n";
    let simulate = format!("{flats}[simulate]\nconfig = \"job.toml\"\nframes_each = 2\n");
    let (_, rendered) = calibrated(folder, "rendered", &plan("", ["", ""], &simulate));
    let (_, live) = calibrated(folder, "fields", &plan(&source, ["", ""], flats));
    assert!(live["bench"]["sensor"].is_object() && live["bench"]["flat_field"].is_object(), "{live}");
    for key in ["sensor", "flat_field"] {
        assert_eq!(live["bench"][key], rendered["bench"][key], "{key}");
    }
    // what was set is set back
    let mut client = head.client();
    let places = ["HeadObject", "MasterIndex", "TriggerMode"].map(|name| client.get(name));
    assert_eq!((places, client.float("ExposureTime")), ([0, 0, 0], 50.0));
}

/// u of the largest diameter of the first frame, mm.
#[cfg(unix)]
fn largest_u_mm(output: &Output) -> f64 {
    assert!(output.status.success(), "{}", said(output));
    let stdout = text(&output.stdout);
    let first: Value = serde_json::from_str(stdout.lines().next().unwrap()).unwrap();
    first["u_max_mm"].as_f64().unwrap()
}

/// A calibration holds for its camera as it was set, live and recorded; a window inside is allowed.
#[cfg(unix)]
#[test]
fn a_calibration_is_refused_by_another_camera_and_another_setting() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let path = |name: &str| folder.join(name).display().to_string();
    let job = JOB.replace("fields = 5", "fields = 1").replace("angles = 4", "angles = 1");
    std::fs::write(path("job.toml"), job.replace("[camera]\n", "[camera]\nframe_period_ms = 100.0\n"))
        .unwrap();
    let head = published(&folder.join("job.toml"), own_address(8));
    let source = format!("source = \"{}\"\nframes_each = 2", head.source());
    let (own, of_head) = calibrated(folder, "own", &plan(&source, ["", ""], ""));
    let by = |calibration: &str, source: &str, more: &[&str]| {
        let command = ["measure", source, "--as-of", "2026-11-23", "--json", "--calibration", calibration];
        shadowgauge(command.into_iter().chain(more.iter().copied()))
    };
    let output = by(&own, &head.source(), &["--gain-db", "6"]);
    let words = "calibrated with gain 0 dB, camera has 6 dB: set --gain-db 0 or calibrate again";
    assert!(output.status.code() == Some(3) && said(&output).contains(words), "{}", said(&output));
    let mut client = head.client();
    assert_eq!(client.float("Gain"), 0.0, "a camera that is refused has its own back");
    let mut of_other = of_head.clone();
    of_other["camera"]["serial_number"] = "SG-7".into();
    std::fs::write(path("other.json"), of_other.to_string()).unwrap();
    let output = by(&path("other.json"), &head.source(), &[]);
    let words = "serial number SG-7, camera has SG-5";
    assert!(output.status.code() == Some(3) && said(&output).contains(words), "{}", said(&output));

    // a recording states the camera
    let (file, options) = (path("day.mcap"), ["--as-of", "2026-11-23", "--json"]);
    let name = head.source();
    let watch = [&[name.as_str(), "--calibration", &own, "--record", &file][..], &options[..]].concat();
    let running = Running::of("watch", &watch);
    let whole = std::iter::repeat_with(|| running.json()).find(|line| line["event"].is_null()).unwrap();
    interrupt(&running);
    running.end();
    let replay = format!("replay:{file}");
    // the scale's drift by the head's own thermometer, which stands in the recording
    let head_c = client.float("HeadTemperature");
    let drift = ["--scale-ppm-per-k", "1000", "--scale-calibrated-c", &format!("{}", head_c - 10.0)];
    let (without_mm, with_mm) =
        (largest_u_mm(&by(&own, &replay, &[])), largest_u_mm(&by(&own, &replay, &drift)));
    // limits of 1 % of 11.5 mm, of a uniform distribution
    assert!(with_mm > without_mm + 0.05 && with_mm < 0.2, "{without_mm} {with_mm}");
    let output = by(&path("other.json"), &replay, &[]);
    let words = "serial number SG-7, recording has SG-5";
    assert!(output.status.code() == Some(3) && said(&output).contains(words), "{}", said(&output));

    // a window inside the calibrated one has the same diameters, one beyond is refused
    client.take_control(2).unwrap();
    for (name, value) in [("Height", 448), ("OffsetY", 32)] {
        client.set(name, value);
    }
    client.write_register(0x0A00, 0).unwrap();
    let measure = [&[name.as_str(), "--calibration", &own][..], &options[..]].concat();
    let running = Running::start(&measure);
    let inside = running.json();
    interrupt(&running);
    running.end();
    let diameter_mm = |line: &Value| line["mean_diameter_mm"].as_f64().unwrap();
    let (whole_mm, inside_mm) = (diameter_mm(&whole), diameter_mm(&inside));
    // the noise of two frames
    assert!((whole_mm - inside_mm).abs() < 1e-3, "{whole_mm} {inside_mm}");
    let mut smaller = of_head;
    smaller["camera"]["window"]["rows"] = 400.into();
    std::fs::write(path("smaller.json"), smaller.to_string()).unwrap();
    let output = by(&path("smaller.json"), &head.source(), &[]);
    let words = "the window 512 x 400 at OffsetX 0, OffsetY 0, camera has 512 x 448 at OffsetX 0, OffsetY 32";
    assert!(output.status.code() == Some(3) && said(&output).contains(words), "{}", said(&output));
}

#[test]
fn a_plan_of_a_camera_is_refused_by_its_keys() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |keys: &str, position: &str| {
        let [config, out] = ["plan.toml", "out.json"].map(|name| folder.path().join(name));
        std::fs::write(&config, plan(keys, [position, position], "")).unwrap();
        let [config, out] = [config, out].map(|path| path.display().to_string());
        let output = shadowgauge(["calibrate", &config, "--out", &out]);
        (output.status.code(), said(&output))
    };
    for (keys, position, words) in [
        ("source = \"camera 1\"", "", "gige:IP"),
        ("source = \"gige:127.0.0.1\"", "frames = \"a\"", "beside `source`"),
        ("source = \"gige:127.0.0.1\"\nframes_each = 1", "", "2 to 1000"),
        ("frames_each = 4", "frames = \"a\"", "is of a camera"),
    ] {
        let (code, said) = refused(keys, position);
        assert!(code == Some(2) && said.contains(words), "{keys}: {said}");
    }
    let (code, said) = refused(&format!("source = \"gige:{}\"", own_address(9)), "");
    assert!(code == Some(3) && said.contains("no GigE Vision camera answers"), "{said}");
}

#[test]
fn a_camera_that_is_not_there_is_named_with_what_to_look_at() {
    let output = shadowgauge(["measure", &format!("gige:{}", own_address(6))]);
    let words = said(&output);
    assert!(output.status.code() == Some(3) && words.contains("no GigE Vision camera answers"), "{words}");
    let output = shadowgauge(["watch", "gige:no such camera"]);
    let words = said(&output);
    assert!(output.status.code() == Some(3) && words.contains("\"no such camera\""), "{words}");
    // without the feature `camera-usb` it is named, with it the cameras that are plugged in
    let output = shadowgauge(["watch", "usb:40001"]);
    let words = said(&output);
    assert!(matches!(output.status.code(), Some(2 | 3)) && words.contains("usb:40001: "), "{words}");
    assert!(words.contains("camera-usb") || words.contains("serial number"), "{words}");
    let output = shadowgauge(["measure", CONFIG, "--gain-db", "6"]);
    assert!(output.status.code() == Some(2) && said(&output).contains("--gain-db"), "{}", said(&output));
}

/// Runs a script in a network of its own before Aravis' fake camera; `None`, loudly, without it.
fn before_aravis(script: &str) -> Option<(String, String)> {
    let found = |name: &str, arguments: &[&str]| {
        let mut command = Command::new(name);
        command.args(arguments).stdout(Stdio::null()).stderr(Stdio::null());
        command.status().is_ok_and(|status| status.success())
    };
    if !found("arv-fake-gv-camera-0.8", &["--help"]) {
        println!("SKIPPED (arv-fake-gv-camera-0.8 is not installed; apt-get install aravis-tools)");
        return None;
    }
    // its control port is exclusive for each address
    if !found("unshare", &["-rn", "ip", "link", "set", "lo", "up"]) {
        println!("SKIPPED (no network namespace: unshare -rn, or ip, is refused)");
        return None;
    }
    let all = format!(
        "ip link set lo up; arv-fake-gv-camera-0.8 -i 127.0.0.1 >/dev/null 2>&1 & sleep 1; {script}; kill %1"
    );
    let mut command = Command::new("unshare");
    command.args(["-rn", "bash", "-c", &all]).env("NO_COLOR", "1").env("PROGRAM", program::path());
    let output = command.output().unwrap();
    Some((text(&output.stdout), said(&output)))
}

/// `doctor` lists a camera that answers on the loopback interface, in a network of its own.
#[test]
fn doctor_lists_cameras_by_interface() {
    let script = "\"$PROGRAM\" doctor --test-packets --json; \"$PROGRAM\" doctor";
    let Some((stdout, stderr)) = before_aravis(script) else { return };
    let mut documents = serde_json::Deserializer::from_str(&stdout).into_iter::<Value>();
    let findings = documents.next().expect("a document").unwrap();
    let interface = &findings["cameras"]["interfaces"][0];
    assert_eq!((&interface["name"], &interface["addresses"][0]), (&"lo".into(), &"127.0.0.1".into()));
    let camera = &interface["cameras"][0];
    assert_eq!((&camera["serial_number"], &camera["access"]), (&"GV01".into(), &"free".into()), "{findings}");
    assert!(camera["frame_bytes"].as_u64().is_some_and(|bytes| bytes >= 512 * 512), "{camera}");
    assert!(stdout.contains("serial number GV01") && stdout.contains("free"), "{stdout} {stderr}");
}

/// Before a camera that places no pins someone lays them; its ramp shows none.
#[test]
fn an_operator_is_asked_for_each_pin() {
    let folder = tempfile::tempdir().unwrap();
    let [config, out] = ["plan.toml", "out.json"].map(|name| folder.path().join(name));
    let keys = "source = \"gige:127.0.0.1\"\nframes_each = 2";
    std::fs::write(&config, plan(keys, ["height_mm = 1.5", ""], "")).unwrap();
    let calibrate = format!("\"$PROGRAM\" calibrate {} --out {}", config.display(), out.display());
    let script = format!("{calibrate} --yes; {calibrate} </dev/null; yes '' | {calibrate}");
    let Some((stdout, stderr)) = before_aravis(&script) else { return };
    for words in [
        "does not place pins itself",
        "stdin ended before this step was confirmed",
        "small (10 mm): lay it, about 1.5 mm above the middle of the field, then Enter:",
        "small: no frame shows it",
    ] {
        assert!(stderr.contains(words), "{words}: {stdout} {stderr}");
    }
    assert!(!out.exists());
}

/// Its frames are a ramp without an edge: received whole, and refused by the gauge.
#[test]
fn frames_of_aravis_are_received() {
    let script = "\"$PROGRAM\" watch gige:GV01 --json | head -n 8";
    let Some((stdout, stderr)) = before_aravis(script) else { return };
    let lines: Vec<Value> = stdout.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let frames: Vec<&Value> = lines.iter().filter(|line| line["event"].is_null()).collect();
    assert!(!frames.is_empty(), "{stdout} {stderr}");
    assert!(
        frames.iter().all(|frame| frame["columns"] == 512 && frame["device_clock"] == "device"),
        "{stdout}"
    );
    assert!(lines.iter().all(|line| line["event"] != "gap"), "{stdout} {stderr}");
}

#[test]
fn a_pixel_format_that_is_not_read_is_refused_with_those_that_are() {
    let script =
        "arv-tool-0.8 -a 127.0.0.1 control PixelFormat=BayerRG8; \"$PROGRAM\" measure gige:127.0.0.1";
    let Some((stdout, stderr)) = before_aravis(script) else { return };
    if !stdout.contains("PixelFormat = BayerRG8") {
        println!("SKIPPED (arv-tool-0.8 sets no pixel format: {stdout})");
        return;
    }
    assert!(
        stderr.contains("PixelFormat is BayerRG8") && stderr.contains("Mono8 or Mono16"),
        "{stdout} {stderr}"
    );
}

/// Serves the fake camera of PyPI viva-genicam, the first packet of whose fourth frame is not sent.
/// One that sends packets again sends that one, too, where it is asked for.
const VIVA_FAKE: &str = "
import sys
from viva_genicam.testing import FakeGigeCamera
fake = FakeGigeCamera(width=320, height=240, fps=10, bind_ip=sys.argv[1], drop_packets=[(4, 1)], packet_resend=False)
fake.start()
print('ready', flush=True)
sys.stdin.read()
";

/// Its frames are a pattern without a part and have no time of the device: those that are whole
/// come in order with the time of their arrival alone, the other is a gap with its reason.
#[cfg(unix)]
#[test]
fn frames_of_viva_genicams_fake_are_received() {
    let python = std::env::var("GENICAM_PYTHON").unwrap_or_else(|_| "python3".into());
    let mut command = Command::new(&python);
    let has_it = command.args(["-c", "import viva_genicam.testing"]).stderr(Stdio::null()).status();
    if !has_it.is_ok_and(|status| status.success()) {
        println!("SKIPPED (no {python} with PyPI viva-genicam; GENICAM_PYTHON names one)");
        return;
    }
    let address = own_address(10);
    let mut command = Command::new(&python);
    command.args(["-c", VIVA_FAKE, &address.to_string()]).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut program = command.spawn().unwrap();
    let ready = BufReader::new(program.stdout.take().unwrap()).lines().next();
    let fake = Published { program, words: Vec::new(), address };
    assert!(ready.is_some_and(|line| line.is_ok_and(|line| line == "ready")), "the fake does not start");
    let running = Running::of("watch", &[&fake.source(), "--json"]);
    let (mut numbers, mut gap) = (Vec::new(), None);
    while gap.is_none() || numbers.last().is_none_or(|number| *number < 5) {
        let line = running.json();
        if line["event"] == "gap" && line["incomplete"] == 1 {
            gap = line["why"].as_str().map(str::to_owned);
        }
        if line["event"].is_null() {
            assert!(line["columns"] == 320 && line["host_t_ns"].is_u64(), "{line}");
            assert!(line["device_t_ns"].is_null() && line.get("exposed_host_t_ns").is_none(), "{line}");
            numbers.push(line["sequence"].as_u64().unwrap());
        }
        assert!(numbers.last().is_none_or(|number| *number < 20), "no gap: {numbers:?}");
    }
    assert!(numbers.is_sorted_by(|a, b| a < b) && !numbers.contains(&3), "{numbers:?}");
    assert!(gap.as_ref().is_some_and(|why| why.contains("missing")), "{gap:?}");
    interrupt(&running);
    running.end();
}
