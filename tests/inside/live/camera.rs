//! A GigE Vision camera as a live source: the published head, in this process, at an address of the
//! loopback interface of its own.

use std::net::{Ipv4Addr, SocketAddrV4};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use shadowgauge::frame::{Buffer, CameraBinding, Frame, FrameMeta, PixelFormat};
use shadowgauge::publish::camera::Faults;
use shadowgauge::publish::head::{FrameMaker, FrameOrder, PassOrder};
use shadowgauge::publish::{Camera as Published, DataSheet, PORT, Sockets, serve};
use shadowgauge::source::camera::{Camera, CameraSettings, WhenGone};
use shadowgauge::source::live::{Event, Gap, Live, LiveSource as _, Policy, Produced, Producer};

use super::conformance::{Factory, SOON, Seen, next_frame, settings};
use crate::inside::publish::gige_client::Client;

/// Frames that are wanted, and those that were taken: a camera runs at its own pace, and the suite
/// sends so many frames as its consumer takes, as a trigger would have it.
#[derive(Debug, Default)]
struct Demand {
    wanted_and_taken: Mutex<[u64; 2]>,
    more: Condvar,
}

impl Demand {
    /// One frame more than were taken.
    fn one(&self) {
        let mut counts = self.wanted_and_taken.lock().unwrap();
        counts[0] = counts[1] + 1;
        self.more.notify_all();
    }

    /// Waits until a frame is wanted, or the head ends.
    fn take(&self, ends: &AtomicBool) {
        let mut counts = self.wanted_and_taken.lock().unwrap();
        while counts[0] == counts[1] && !ends.load(Ordering::Relaxed) {
            counts = self.more.wait_timeout(counts, Duration::from_millis(20)).unwrap().0;
        }
        counts[1] = counts[0];
    }
}

/// Draws frames whose every pixel is their number, when they are wanted.
struct DrawnOnDemand {
    demand: Arc<Demand>,
    ends: Arc<AtomicBool>,
}

impl FrameMaker for DrawnOnDemand {
    fn frame(&mut self, order: &FrameOrder, _reuse: Option<Frame>) -> Result<Frame, String> {
        self.demand.take(&self.ends);
        let (rows, columns) = (order.window.rows as usize, order.window.columns as usize);
        let pixels = Buffer::U16(vec![order.number as u16; rows * columns]);
        Ok(Frame::new(pixels, PixelFormat::Mono12, rows, columns, FrameMeta::default()).unwrap())
    }

    fn cut(&mut self, _order: &PassOrder) -> Result<(), String> {
        Ok(())
    }
}

/// A head that is served until it is dropped.
struct Served {
    ends: Arc<AtomicBool>,
    server: Option<JoinHandle<()>>,
}

impl Served {
    fn at(address: Ipv4Addr, demand: &Arc<Demand>) -> Self {
        let sockets = Sockets::bind(address, 8, PORT).unwrap();
        let ends = Arc::<AtomicBool>::default();
        let mut head = DrawnOnDemand { demand: Arc::clone(demand), ends: Arc::clone(&ends) };
        let stop = Arc::clone(&ends);
        let sheet = DataSheet { address, ..DataSheet::of_tests() };
        let server = std::thread::spawn(move || serve(Published::new(sheet), &sockets, &mut head, &stop));
        Self { ends, server: Some(server) }
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
        self.server.take().unwrap().join().unwrap();
    }
}

/// An address of a test's own, so that tests may run at the same time.
fn own_address(test: u8) -> Ipv4Addr {
    let process = std::process::id();
    Ipv4Addr::new(127, 140 + test, (process >> 8) as u8, (process as u8).clamp(1, 254))
}

/// A series of so many frames: the camera's acquisition goes on for ever.
struct Series {
    camera: Camera,
    demand: Arc<Demand>,
    next: u64,
    frames: u64,
}

impl Series {
    fn open(address: Ipv4Addr, demand: &Arc<Demand>, frames: u64, when_gone: WhenGone) -> Box<dyn Producer> {
        let settings = CameraSettings::unchanged(when_gone);
        let camera = Camera::open(&address.to_string(), settings).unwrap();
        Box::new(Self { camera, demand: Arc::clone(demand), next: 0, frames })
    }
}

impl Producer for Series {
    fn produce(&mut self, spare: Option<Frame>, wait: Duration) -> Produced {
        if self.next >= self.frames {
            return Produced::End(None);
        }
        self.demand.one();
        let produced = self.camera.produce(spare, wait);
        match &produced {
            Produced::Frame(new) => self.next = new.meta.sequence + 1,
            Produced::Incomplete(number, _) => self.next = number + 1,
            _ => {}
        }
        produced
    }

    fn start(&mut self) {
        self.camera.start();
    }

    fn stop(&mut self) {
        self.camera.stop();
    }

    fn camera(&self) -> Option<&CameraBinding> {
        self.camera.camera()
    }
}

#[test]
fn a_camera_conforms() {
    let (address, demand) = (own_address(1), Arc::<Demand>::default());
    let _head = Served::at(address, &demand);
    let open = |frames: u64| Series::open(address, &demand, frames, WhenGone::Ends);
    let is_frame = |frame: &Frame, number: u64| frame.view().get(47, 63) == Some(number as f32);
    let binding = open(1).camera().cloned().unwrap();
    assert_eq!((binding.serial_number.as_str(), binding.pixel_format.as_str()), ("SG-1", "Mono12"));
    assert_eq!((binding.gain_db, binding.black_level, binding.window.columns), (Some(0.0), Some(64.0), 64));
    Factory { open: &open, is_frame: &is_frame }.conforms();
}

#[test]
fn a_camera_that_disappears_and_returns_goes_on_with_the_next_number() {
    let (address, demand) = (own_address(2), Arc::<Demand>::default());
    let head = Served::at(address, &demand);
    let series = Series::open(address, &demand, 16, WhenGone::Returns);
    let mut live = Live::new(series, settings(Policy::Block)).unwrap();
    let first: Vec<u64> = (0..3).map(|_| next_frame(&mut live).0).collect();
    // until four frames wait, and none is on its way
    std::thread::sleep(Duration::from_millis(300));
    drop(head);
    let gone = Instant::now();
    let mut taken = first.len() as u64;
    let why = loop {
        match live.next_event(SOON) {
            // what waited still
            Event::Frame(frame) => taken = frame.meta.sequence + 1,
            Event::Lost(why) => break why,
            other => panic!("{other:?}"),
        }
    };
    assert!(why.contains("answer") && gone.elapsed() < SOON, "{why}");
    let _again = Served::at(address, &demand);
    let seen = Seen::until_end(&mut live, |_| {});
    assert_eq!(seen.frames, (taken..16).collect::<Vec<_>>(), "{seen:?}");
    assert!(seen.gaps.is_empty() && live.counters().disappeared == 1, "{seen:?}");
}

/// Frames that a head sends with a tenth of its packets lost, leader, pixels and trailer each; the
/// head sends packets again, or refuses to.
fn with_lost_packets(address: Ipv4Addr, faults: &Faults) -> Seen {
    let demand = Arc::<Demand>::default();
    let _head = Served::at(address, &demand);
    let mut client = Client::new(SocketAddrV4::new(address, PORT));
    client.take_control(2).unwrap();
    client.set("FaultPacketLoss", faults.lost_per_thousand);
    client.set("FaultSeed", faults.seed);
    client.set("FaultResendRefused", u32::from(faults.refuses_resend));
    client.write_register(0x0A00, 0).unwrap();
    let series = Series::open(address, &demand, SENT, WhenGone::Ends);
    let mut live = Live::new(series, settings(Policy::Block)).unwrap();
    Seen::until_end(&mut live, |_| {})
}

/// Frames of a series with lost packets.
const SENT: u64 = 60;

/// Numbers of the frames that lose these of their leader, pixels and trailer.
fn losing(faults: &Faults, lost: [bool; 3]) -> Vec<u64> {
    // a frame of 6 kB in packets of 64 kB
    let is_so = |number: &u64| [0, 1, 2].map(|packet| faults.loses(number + 1, packet)) == lost;
    (0..SENT).filter(is_so).collect()
}

/// The receiver asks for packets before the last one that came; a lost trailer is not among them,
/// and is asked for by ourselves.
#[test]
fn a_last_packet_that_is_lost_is_asked_for_again() {
    let faults = Faults { lost_per_thousand: 100, seed: 19, ..Faults::default() };
    let [trailers, pixels] = [[false, false, true], [false, true, false]].map(|lost| losing(&faults, lost));
    assert!(trailers.len() >= 3 && pixels.len() >= 2, "{trailers:?}: another seed is needed");
    let seen = with_lost_packets(own_address(3), &faults);
    let came = |numbers: &[u64]| numbers.iter().filter(|number| seen.frames.contains(number)).count();
    // on a machine that is held up for 100 ms a block is closed before
    assert!(2 * came(&trailers) >= trailers.len(), "{trailers:?} {seen:?}");
    assert!(2 * came(&pixels) >= pixels.len(), "{pixels:?} {seen:?}");
    let total: u64 = seen.gaps.iter().map(Gap::count).sum();
    assert!(seen.frames.len() as u64 + total >= SENT, "{seen:?}");
}

/// Where the head does not send it again, the frame is a gap.
#[test]
fn a_frame_whose_last_packet_is_lost_is_a_gap_with_its_reason() {
    let faults = Faults { lost_per_thousand: 100, seed: 19, refuses_resend: true, ..Faults::default() };
    let trailers = losing(&faults, [false, false, true]);
    let seen = with_lost_packets(own_address(4), &faults);
    let missed: Vec<u64> = seen.gaps.iter().flat_map(|gap| gap.first..gap.next).collect();
    for number in &trailers {
        assert!(missed.contains(number), "{number} in {missed:?}");
    }
    let total: u64 = seen.gaps.iter().map(Gap::count).sum();
    assert!(seen.frames.len() as u64 + total >= SENT, "{seen:?}");
    let words: Vec<String> = seen.gaps.iter().map(ToString::to_string).collect();
    assert!(words.iter().any(|gap| gap.contains("its last packet is missing")), "{words:?}");
}
