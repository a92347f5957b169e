//! Two windows of a frame measure as the whole of it does, from the source and from its recording.

use std::time::Duration;

use shadowgauge::frame::{Buffer, Frame, FrameMeta, PixelFormat};
use shadowgauge::gauge::{Gauge, GaugeSettings};
use shadowgauge::measurement::{MeasureSettings, Stream};
use shadowgauge::source::live::{
    Event, Live, LiveMeta, LiveSource as _, NewFrame, Policy, Produced, Producer, Remarks, Windowed,
};

use super::conformance::{SOON, settings};

const ROWS: usize = 256;
const COLUMNS: usize = 96;
/// Rows of both edges.
const EDGES: [f64; 2] = [80.2, 176.3];

/// Shadows with soft edges and noise by a hash of pixel and frame.
struct Drawn {
    next: u64,
    frames: u64,
}

fn picture(number: u64) -> Frame {
    let soft = |d: f64| 30.0 + 150.0 / (1.0 + (-2.0 * d).exp());
    let pixel = |k: usize| {
        let row = (k / COLUMNS) as f64;
        let light = if row < 128.0 { soft(EDGES[0] - row) } else { soft(row - EDGES[1]) };
        let key = (number << 32 ^ k as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        light as u8 + ((key ^ key >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 61) as u8
    };
    let buffer = Buffer::U8((0..ROWS * COLUMNS).map(pixel).collect());
    let meta = FrameMeta { frame_id: number, ..FrameMeta::default() };
    Frame::new(buffer, PixelFormat::Mono8, ROWS, COLUMNS, meta).unwrap()
}

impl Producer for Drawn {
    fn produce(&mut self, _spare: Option<Frame>, _wait: Duration) -> Produced {
        if self.next == self.frames {
            return Produced::End(None);
        }
        let meta = LiveMeta { sequence: self.next, ..LiveMeta::default() };
        let frame = picture(self.next);
        self.next += 1;
        Produced::Frame(Box::new(NewFrame { frame, meta, remarks: Remarks::default() }))
    }
}

/// The largest diameters of a source's frames, px, and how it ended.
fn diameters(producer: Box<dyn Producer>) -> (Vec<f64>, Option<String>) {
    let gauge = Gauge::new(GaugeSettings::default()).unwrap();
    let mut stream = Stream::in_pixels(&gauge, MeasureSettings::default()).unwrap();
    let mut live = Live::new(producer, settings(Policy::Block)).unwrap();
    let mut all = Vec::new();
    loop {
        match live.next_event(SOON) {
            Event::Frame(taken) => {
                let frame = &taken.lease.frame;
                let measured = stream.push(&frame.meta, &frame.view()).unwrap();
                all.push(measured.largest.as_ref().unwrap().diameter_px);
                taken.lease.give_back();
            }
            Event::End(why) => return (all, why),
            other => panic!("{other:?}"),
        }
    }
}

fn drawn() -> Box<dyn Producer> {
    Box::new(Drawn { next: 0, frames: 5 })
}

#[test]
fn two_windows_give_the_diameters_of_the_whole_frames() {
    let windowed = || Box::new(Windowed::new(drawn(), "48,144,64".parse().unwrap()));
    let ((whole, _), (cut, end)) = (diameters(drawn()), diameters(windowed()));
    assert_eq!((whole.len(), cut.len(), end), (5, 5, None));
    for (whole, cut) in whole.iter().zip(&cut) {
        // without the 32 rows between the windows it would be 64.1
        assert!((whole - (EDGES[1] - EDGES[0])).abs() < 0.3, "{whole}");
        assert!((whole - cut).abs() < 0.1, "{whole} and {cut}");
    }
    let beyond = Box::new(Windowed::new(drawn(), "48,200,64".parse().unwrap()));
    let why = diameters(beyond).1.unwrap();
    assert!(why.contains("row 264") && why.contains("256 rows"), "{why}");
}

/// A recording has the windows alone, and its replay gives the same diameters to the bit.
#[cfg(feature = "mcap")]
#[test]
fn a_recording_of_windows_gives_the_same_diameters() {
    use shadowgauge::source::mcap::{Replay, Tap};
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("windows.mcap");
    let windowed = Box::new(Windowed::new(drawn(), "48,144,64".parse().unwrap()));
    let (tap, recorded) = Tap::begin(windowed, &path, true).unwrap();
    let (live, _) = diameters(Box::new(tap));
    assert_eq!(recorded.finish().unwrap(), [5, 0]);
    let (again, why) = diameters(Box::new(Replay::open(&path).unwrap()));
    assert_eq!((live.as_slice(), why), (again.as_slice(), None));
    let bytes = std::fs::metadata(&path).unwrap().len() as usize;
    assert!(bytes < 5 * ROWS * COLUMNS * 7 / 10, "{bytes} bytes");
}
