//! `publish` from outside the program: frames as `render` draws them, refusals, Ctrl-C, and peers
//! that are not ours: Aravis' tools and EMVA's GenApi, where they are installed.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

#[path = "support/gige_client.rs"]
mod gige_client;
#[path = "support/program.rs"]
mod program;
#[path = "support/published.rs"]
mod published;

use std::io::BufReader;
use std::net::Ipv4Addr;
use std::path::Path;
use std::process::{Command, Output};
use std::time::Duration;

use gige_client::Client;
use published::Published;

const PROGRAM: &str = env!("CARGO_BIN_EXE_shadowgauge");
const CONFIG: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/small_shaft.toml");
const LONG: Duration = Duration::from_secs(30);

/// An address of a test's own.
fn own_address(test: u8) -> Ipv4Addr {
    published::own_address(80 + test)
}

/// Publishes the small shaft.
fn published(test: u8) -> Published {
    published::published(Path::new(CONFIG), own_address(test))
}

fn refusal(config: &Path, address: &str) -> (i32, String) {
    let config = config.to_string_lossy();
    let output = program::shadowgauge(["publish", &config, "--backend", "cpu", "--listen", address]);
    (output.status.code().unwrap(), program::said(&output))
}

/// A frame of the head is the frame that `render` writes: same scene, same noise.
#[test]
fn frames_are_those_of_render_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("frames");
    let rendered = Command::new(PROGRAM)
        .args(["render", CONFIG, "--frames", "3", "--backend", "cpu", "--out"])
        .arg(&out)
        .output()
        .unwrap();
    assert!(rendered.status.success(), "{}", String::from_utf8_lossy(&rendered.stderr));
    let head = published(1);
    assert!(head.words[0].contains(&format!("{}, UDP port 3956", head.address)), "{:?}", head.words);
    assert!(head.words.iter().any(|line| line.contains("SG-5")), "{:?}", head.words);
    assert!(head.words.iter().any(|line| line.ends_with(", 35.71 Hz")), "{:?}", head.words);
    let mut client = head.client();
    client.take_control(2).unwrap();
    client.open_stream(9000);
    client.set("TriggerMode", 1);
    client.set("AcquisitionStart", 1);
    let table = std::fs::read_to_string(out.join("frames.csv")).unwrap();
    for line in table.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |k: usize| cells[k].parse::<f64>().unwrap();
        client.set_float("CarriageZ", number(2));
        client.set_float("SpindleAngle", number(3));
        client.set("TriggerSoftware", 1);
        let frame = client.frame(LONG).unwrap_or_else(|| panic!("no frame for {line}"));
        let file = std::fs::File::open(out.join(format!("frames/{}.png", cells[0]))).unwrap();
        let mut reader = png::Decoder::new(BufReader::new(file)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        // PNG is big-endian, the stream little-endian
        let wanted: Vec<u8> = pixels.chunks_exact(2).flat_map(|grey| [grey[1], grey[0]]).collect();
        assert_eq!((frame.columns, frame.rows, frame.format), (512, 512, 0x0110_0005));
        assert!(frame.payload == wanted, "{line}: other pixels than render's");
    }
}

#[test]
fn exposure_gain_diameter_and_passes_change_the_frames() {
    let head = published(2);
    let mut client = head.client();
    client.take_control(2).unwrap();
    client.open_stream(9000);
    client.set("TriggerMode", 1);
    client.set("PixelFormat", 0x0108_0001);
    client.set("AcquisitionStart", 1);
    let frame = |client: &mut Client| {
        client.set("TriggerSoftware", 1);
        client.frame(LONG).expect("a frame").payload
    };
    let mean = |pixels: &[u8]| pixels.iter().map(|p| f64::from(*p)).sum::<f64>() / pixels.len() as f64;
    let dark = |pixels: &[u8]| pixels.iter().filter(|p| **p < 64).count() as f64 / 512.0;
    let first = frame(&mut client);
    client.set_float("ExposureTime", 25.0);
    assert!(mean(&frame(&mut client)) < 0.6 * mean(&first), "half the exposure");
    client.set_float("Gain", 6.0);
    assert!(mean(&frame(&mut client)) > 0.9 * mean(&first), "twice the gain");
    client.set_float("ExposureTime", 50.0);
    client.set_float("Gain", 0.0);
    client.set_float("ShaftDiameter", 9.0);
    // 30 µm a pixel
    let thinner = dark(&first) - dark(&frame(&mut client));
    assert!((thinner - 2.0 / 0.03).abs() < 2.0, "2 mm less are {thinner} rows");
    client.set("AcquisitionStop", 1);
    client.set("HeadObject", 1);
    client.set("AcquisitionStart", 1);
    let stock = dark(&frame(&mut client));
    client.set("PassCut", 1);
    while client.get("PassState") == 1 {}
    assert_eq!((client.get("PassState"), client.text("HeadMessage", 128)), (2, String::new()));
    let cut = stock - dark(&frame(&mut client));
    assert!((cut - 0.5 / 0.03).abs() < 2.0, "half a millimetre is cut: {cut} rows");
}

#[test]
fn what_cannot_be_published_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let head = published(3);
    let (code, stderr) = refusal(Path::new(CONFIG), &head.address.to_string());
    assert!(code == 3 && stderr.contains("3956 is in use"), "{code} {stderr}");
    // TEST-NET-1 of RFC 5737: no machine has it
    let (code, stderr) = refusal(Path::new(CONFIG), "192.0.2.1");
    assert!(code == 2 && stderr.contains("no address of this machine"), "{code} {stderr}");
    let (code, stderr) = refusal(Path::new(CONFIG), "0.0.0.0");
    assert!(code == 2 && stderr.contains("--listen 0.0.0.0"), "{code} {stderr}");
    let windows = folder.path().join("windows.toml");
    let text = std::fs::read_to_string(CONFIG).unwrap();
    let two = "[camera]\nwindows = { upper_row = 40, lower_row = 400, rows = 64 }\n";
    std::fs::write(&windows, text.replace("[camera]\n", two)).unwrap();
    let (code, stderr) = refusal(&windows, "127.79.0.1");
    assert!(code == 2 && stderr.contains("camera.windows"), "{code} {stderr}");
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_the_head_with_0_and_frees_its_address() {
    let mut head = published(4);
    let mut client = head.client();
    client.take_control(2).unwrap();
    // six packets a frame: a busy receiver's socket buffer holds them
    client.set("Width", 256);
    client.set("Height", 128);
    client.open_stream(9000);
    client.set("AcquisitionStart", 1);
    assert!(client.frame(LONG).is_some());
    let sent = Command::new("kill").args(["-INT", &head.program.id().to_string()]).status().unwrap();
    assert!(sent.success());
    assert_eq!(head.program.wait().unwrap().code(), Some(0));
    drop(published(4));
}

/// Runs a peer; `None`, loudly, where it is not installed.
fn peer(command: &mut Command, name: &str, package: &str) -> Option<Output> {
    match command.output() {
        Ok(output) => Some(output),
        Err(error) => {
            println!("SKIPPED ({name} is not installed: {error}; {package})");
            None
        }
    }
}

/// Aravis reads and writes features and receives frames.
#[test]
fn aravis_reads_features_and_receives_frames() {
    let head = published(5);
    let address = head.address.to_string();
    let mut tool = Command::new("arv-tool-0.8");
    tool.args(["-a", &address, "control", "ShaftDiameter=11.25", "ShaftDiameter", "Width", "PixelFormat"]);
    let Some(output) = peer(&mut tool, "arv-tool-0.8", "apt-get install aravis-tools-cli") else { return };
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{text} {}", String::from_utf8_lossy(&output.stderr));
    for line in ["ShaftDiameter = 11.25 mm", "Width = 512 min:1 max:512", "PixelFormat = Mono12"] {
        assert!(text.contains(line), "{line}: {text}");
    }
    let mut test = Command::new("arv-camera-test-0.8");
    test.args(["--no-packet-socket", "-n", &address, "-i", "60000", "-f", "50", "--duration=3"]);
    // several frames fit into the receiver's buffer; on a machine that is busy with other tests it
    // may still come too late for some
    test.args(["-w", "256", "-h", "128"]);
    test.args(["--features", "ChunkModeActive=true", "--chunks", "EncoderValue"]);
    let Some(output) = peer(&mut test, "arv-camera-test-0.8", "apt-get install aravis-tools") else { return };
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let count = |name: &str| {
        let line = text.lines().find(|line| line.trim_start().starts_with(name));
        let line =
            line.unwrap_or_else(|| panic!("{name}: {text} {}", String::from_utf8_lossy(&output.stderr)));
        line.rsplit('=').next().unwrap().trim().parse::<u32>().unwrap()
    };
    println!("{text}");
    let (completed, failed) = (count("n_completed_buffers"), count("n_failures"));
    assert!(completed > 20 && failed * 10 <= completed, "{text}");
}

/// EMVA's own parser accepts the XML, reads every feature, and its chunk adapter the chunks.
#[test]
fn emvas_genapi_accepts_the_xml_and_reads_the_chunks() {
    let python = std::env::var("GENICAM_PYTHON").unwrap_or_else(|_| "python3".into());
    let has_it = Command::new(&python).args(["-c", "import genicam.genapi"]).output();
    if !has_it.is_ok_and(|output| output.status.success()) {
        println!("SKIPPED (no {python} with PyPI genicam; GENICAM_PYTHON names one)");
        return;
    }
    let head = published(6);
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/support/emva_genapi.py");
    let output = Command::new(&python).arg(script).arg(head.address.to_string()).output().unwrap();
    let (stdout, stderr) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success() && stdout.starts_with("OK"), "{stdout} {stderr}");
    println!("{stdout}");
}
