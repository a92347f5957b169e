//! The suite before cameras that are not ours: the fakes of Aravis and of PyPI viva-genicam, each a
//! process of its own. What they cannot do is left out: neither has chunks of angles, 64-bit ids or
//! a latch, and Aravis' sends nothing again.
//!
//! Aravis' fake serves 127.0.0.1 alone, where its control port is exclusive: its tests run this
//! test program again in a network of its own (`unshare -rn`).

use std::collections::BTreeMap;
use std::io::{BufRead as _, BufReader};
use std::net::Ipv4Addr;
use std::process::{Child, Command, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use shadowgauge::frame::{CameraBinding, Frame};
use shadowgauge::source::camera::{Camera, CameraSettings, WhenGone};
use shadowgauge::source::live::{Event, Live, LiveSource as _, Policy, Produced, Producer};

use super::conformance::{Factory, SOON, Seen, next_frame, settings};

/// Time after which a trigger without a frame is given again: a hundred times what one takes.
const TRIGGER_LOST: Duration = Duration::from_secs(3);

/// Set in the program that runs in a network of its own.
const IN_OWN_NETWORK: &str = "SHADOWGAUGE_TEST_IN_OWN_NETWORK";

/// Serves the fake camera of PyPI viva-genicam at an address.
const VIVA: &str = "
import sys
from viva_genicam.testing import FakeGigeCamera
fake = FakeGigeCamera(width=320, height=240, fps=25, bind_ip=sys.argv[1])
fake.start()
print('ready', flush=True)
sys.stdin.read()
";

#[derive(Clone, Copy, Debug, PartialEq)]
enum Maker {
    Aravis,
    Viva,
}

/// A fake camera that ends with the test.
struct Fake(Child);

impl Drop for Fake {
    fn drop(&mut self) {
        let _ = (self.0.kill(), self.0.wait());
    }
}

fn python() -> String {
    std::env::var("GENICAM_PYTHON").unwrap_or_else(|_| "python3".to_owned())
}

fn runs(program: &str, arguments: &[&str]) -> bool {
    let mut command = Command::new(program);
    command.args(arguments).stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

/// An address of a test's own on the loopback interface.
fn own_address(test: u8) -> Ipv4Addr {
    let process = std::process::id();
    Ipv4Addr::new(127, 170 + test, (process >> 8) as u8, (process as u8).clamp(1, 254))
}

impl Maker {
    /// Whether its fake is installed; printed where it is not.
    fn is_there(self) -> bool {
        let (is_there, how) = match self {
            Self::Aravis => (
                runs("arv-fake-gv-camera-0.8", &["--help"])
                    && runs("unshare", &["-rn", "ip", "link", "set", "lo", "up"]),
                "arv-fake-gv-camera-0.8 or a network namespace; apt-get install aravis-tools",
            ),
            Self::Viva => (
                runs(&python(), &["-c", "import viva_genicam.testing"]),
                "PyPI viva-genicam; GENICAM_PYTHON names a python that has it",
            ),
        };
        if !is_there {
            println!("SKIPPED (no {how})");
        }
        is_there
    }

    /// Its fake at an address; waits until it serves.
    fn serve(self, address: Ipv4Addr) -> Fake {
        match self {
            Self::Aravis => {
                let mut command = Command::new("arv-fake-gv-camera-0.8");
                command.args(["-i", &address.to_string()]).stdout(Stdio::null()).stderr(Stdio::null());
                Fake(command.spawn().unwrap())
            }
            Self::Viva => {
                let mut command = Command::new(python());
                command.args(["-c", VIVA, &address.to_string()]);
                let mut fake = Fake(command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap());
                let ready = BufReader::new(fake.0.stdout.take().unwrap()).lines().next();
                assert!(ready.is_some_and(|line| line.is_ok_and(|line| line == "ready")));
                fake
            }
        }
    }
}

/// The camera at an address, once it serves.
fn opened(address: Ipv4Addr, when_gone: WhenGone) -> Camera {
    let settings = CameraSettings::unchanged(when_gone);
    let begun = Instant::now();
    loop {
        match Camera::open(&address.to_string(), settings.clone()) {
            Ok(camera) => return camera,
            Err(why) if begun.elapsed() > SOON => panic!("{why}"),
            Err(_) => std::thread::sleep(Duration::from_millis(50)),
        }
    }
}

/// A series of so many frames, a software trigger each, counted from 0 whatever the camera's first
/// id is.
struct Series {
    camera: Camera,
    first: Option<u64>,
    next: u64,
    frames: u64,
    triggered: Option<Instant>,
}

impl Series {
    fn open(address: Ipv4Addr, frames: u64) -> Box<dyn Producer> {
        let mut camera = opened(address, WhenGone::Ends);
        for (name, value) in [("TriggerSelector", "FrameStart"), ("TriggerMode", "On")] {
            camera.set_feature(name, value).unwrap();
        }
        camera.set_feature("TriggerSource", "Software").unwrap();
        Box::new(Self { camera, first: None, next: 0, frames, triggered: None })
    }
}

impl Producer for Series {
    fn produce(&mut self, spare: Option<Frame>, wait: Duration) -> Produced {
        if self.next >= self.frames {
            return Produced::End(None);
        }
        if self.triggered.is_none_or(|at| at.elapsed() > TRIGGER_LOST) {
            self.camera.execute_command("TriggerSoftware").unwrap();
            self.triggered = Some(Instant::now());
        }
        let mut produced = self.camera.produce(spare, wait);
        if let Produced::Frame(new) = &mut produced {
            let first = *self.first.get_or_insert(new.meta.sequence);
            new.meta.sequence -= first;
            (self.next, self.triggered) = (new.meta.sequence + 1, None);
        }
        produced
    }

    fn start(&mut self) {
        self.triggered = None;
        self.camera.start();
    }

    fn stop(&mut self) {
        self.camera.stop();
    }

    fn camera(&self) -> Option<&CameraBinding> {
        self.camera.camera()
    }
}

/// Whether a frame is Aravis' ramp: a grey value more a column, a row and a frame, of 255.
fn is_next_ramp(first: &Mutex<u16>, frame: &Frame, number: u64) -> bool {
    let view = frame.view();
    let at = |row, column| view.get(row, column).map(|grey| grey as u16);
    let Some(corner) = at(0, 0) else { return false };
    let of_first = (corner + 255 - (number % 255) as u16) % 255;
    let mut first = first.lock().unwrap();
    if number == 0 {
        *first = of_first;
    }
    *first == of_first && at(100, 50) == Some((corner + 150) % 255)
}

/// Whether a frame is unlike all those of other numbers.
fn is_another(seen: &Mutex<BTreeMap<u64, Vec<u8>>>, frame: &Frame, number: u64) -> bool {
    let view = frame.view();
    let row = (0..view.columns()).filter_map(|column| view.get(100, column));
    let row: Vec<u8> = row.map(|grey| grey as u8).collect();
    let mut seen = seen.lock().unwrap();
    let is_new = row.len() == 320 && seen.values().all(|other| *other != row);
    seen.insert(number, row);
    is_new
}

/// Order, time-out, stop and restart, exhausted leases and slow consumers.
fn conforms(maker: Maker, address: Ipv4Addr) {
    let _fake = maker.serve(address);
    let (first, seen) = (Mutex::default(), Mutex::default());
    let open = |frames: u64| Series::open(address, frames);
    let is_frame = |frame: &Frame, number: u64| match maker {
        Maker::Aravis => is_next_ramp(&first, frame, number),
        Maker::Viva => is_another(&seen, frame, number),
    };
    Factory { open: &open, is_frame: &is_frame }.conforms();
}

/// Its free run goes on with the next number after it was killed and served again.
fn returns(maker: Maker, address: Ipv4Addr) {
    let fake = maker.serve(address);
    let camera = opened(address, WhenGone::Returns);
    let mut live = Live::new(Box::new(camera), settings(Policy::DropOldest)).unwrap();
    let mut last = (0..3).map(|_| next_number(&mut live)).last().unwrap();
    drop(fake);
    let gone = Instant::now();
    let why = loop {
        match live.next_event(SOON) {
            Event::Frame(frame) => last = frame.meta.sequence,
            Event::Lost(why) => break why,
            Event::Gap(_) => {}
            other => panic!("{other:?}"),
        }
    };
    assert!(why.contains("answer") && gone.elapsed() < SOON, "{why}");
    let _again = maker.serve(address);
    assert_eq!(next_number(&mut live), last + 1);
    assert_eq!(live.counters().disappeared, 1);
}

/// The number of the next frame, whatever a loaded machine left out before it.
fn next_number(live: &mut Live) -> u64 {
    loop {
        match live.next_event(SOON) {
            Event::Frame(frame) => return frame.meta.sequence,
            Event::Gap(_) | Event::Lost(_) => {}
            other => panic!("{other:?}"),
        }
    }
}

/// Runs a test of this file again in a network of its own.
fn in_own_network(test: &str) {
    if !Maker::Aravis.is_there() {
        return;
    }
    let program = std::env::current_exe().unwrap();
    let script = "ip link set lo up && exec \"$0\" --ignored --exact --nocapture \"$1\"";
    let mut command = Command::new("unshare");
    command.args(["-rn", "sh", "-c", script]).arg(program).arg(format!("inside::live::foreign::{test}"));
    let output = command.env(IN_OWN_NETWORK, "1").output().unwrap();
    let said = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    assert!(output.status.success() && said[0].contains("1 passed"), "{said:?}");
}

/// Whether this is the program in a network of its own, in which 127.0.0.1 is free.
fn is_in_own_network() -> bool {
    std::env::var_os(IN_OWN_NETWORK).is_some()
}

#[test]
fn vivas_fake_conforms() {
    if Maker::Viva.is_there() {
        conforms(Maker::Viva, own_address(1));
    }
}

#[test]
fn vivas_fake_disappears_and_returns() {
    if Maker::Viva.is_there() {
        returns(Maker::Viva, own_address(2));
    }
}

#[test]
fn aravis_conforms_and_its_ids_wrap() {
    in_own_network("aravis");
}

#[test]
fn aravis_disappears_and_returns() {
    in_own_network("aravis_away");
}

#[test]
#[ignore = "run by aravis_conforms_and_its_ids_wrap in a network of its own"]
fn aravis() {
    if !is_in_own_network() {
        return;
    }
    conforms(Maker::Aravis, Ipv4Addr::LOCALHOST);
    // its ids begin with 65400, wrap to 1 after 65535
    let _fake = Maker::Aravis.serve(Ipv4Addr::LOCALHOST);
    let first = Mutex::default();
    let mut live = Live::new(Series::open(Ipv4Addr::LOCALHOST, 150), settings(Policy::Block)).unwrap();
    for number in 0..150 {
        let (found, lease) = next_frame(&mut live);
        assert!(found == number && is_next_ramp(&first, &lease.frame, number), "{found} {number}");
        lease.give_back();
    }
    let rest = Seen::until_end(&mut live, |_| {});
    assert!(rest.frames.is_empty() && rest.gaps.is_empty(), "{rest:?}");
}

#[test]
#[ignore = "run by aravis_disappears_and_returns in a network of its own"]
fn aravis_away() {
    if is_in_own_network() {
        returns(Maker::Aravis, Ipv4Addr::LOCALHOST);
    }
}
