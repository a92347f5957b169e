//! Files, raw pixels and Y4M as live sources.

use std::io::Write as _;

use shadowgauge::frame::Frame;
use shadowgauge::source::live::{Live, LiveSource as _, Policy, Producer, StoredProducer, taken};
use shadowgauge::source::raw::RawStream;
use shadowgauge::source::{Ahead, FileFrames, Taken, list_images};

use super::conformance::{Factory, Seen, settings};

const THREADS: usize = 2;

fn ahead(frames: impl Iterator<Item = Taken> + Send + 'static) -> Box<dyn Producer> {
    Box::new(StoredProducer::new(Ahead::new(frames, THREADS, None, Ahead::spare(THREADS)).unwrap()))
}

/// Frames of 3 x 2 pixels that have their number as every value.
fn is_frame(frame: &Frame, number: u64) -> bool {
    frame.view().rows() == 2 && frame.view().get(1, 2) == Some(number as f32)
}

fn raw_bytes(frames: u64) -> Vec<u8> {
    (0..frames).flat_map(|number| [number as u8, 0].repeat(6)).collect()
}

#[test]
fn a_folder_conforms() {
    let folder = tempfile::tempdir().unwrap();
    let open = |frames: u64| {
        for number in 0..frames {
            let bytes = [b"P5 3 2 255\n".as_slice(), &[number as u8; 6]].concat();
            std::fs::write(folder.path().join(format!("f{number}.pgm")), bytes).unwrap();
        }
        ahead(FileFrames::new(list_images(folder.path()).unwrap()).undecoded())
    };
    Factory { open: &open, is_frame: &is_frame }.conforms();
}

#[test]
fn raw_pixels_conform() {
    let open = |frames: u64| {
        let input = std::io::Cursor::new(raw_bytes(frames));
        ahead(RawStream::new(input, "stdin".to_owned(), "3x2:mono12".parse().unwrap()))
    };
    Factory { open: &open, is_frame: &is_frame }.conforms();
}

#[test]
fn y4m_conforms() {
    let open = |frames: u64| {
        let mut bytes = b"YUV4MPEG2 W3 H2 F25:1 Ip Cmono\n".to_vec();
        for number in 0..frames {
            bytes.extend(b"FRAME\n");
            bytes.extend([number as u8; 6]);
        }
        ahead(RawStream::y4m(std::io::Cursor::new(bytes), "a.y4m".to_owned()))
    };
    Factory { open: &open, is_frame: &is_frame }.conforms();
}

#[test]
fn an_image_that_is_damaged_is_a_gap_and_a_cut_pipe_ends_with_one() {
    let folder = tempfile::tempdir().unwrap();
    for number in 0..4_u8 {
        let mut file = std::fs::File::create(folder.path().join(format!("f{number}.pgm"))).unwrap();
        file.write_all(if number == 2 { b"P5 3 2 255\n" } else { b"P5 3 2 255\n\x01\x01\x01\x01\x01\x01" })
            .unwrap();
    }
    let producer = ahead(FileFrames::new(list_images(folder.path()).unwrap()).undecoded());
    let mut live = Live::new(producer, settings(Policy::Block)).unwrap();
    let seen = Seen::until_end(&mut live, |_| {});
    assert_eq!((seen.frames.as_slice(), seen.gaps[0].incomplete), (&[0, 1, 3][..], 1));
    assert!(seen.gaps[0].to_string().contains("f2.pgm"), "{}", seen.gaps[0]);
    let cut = raw_bytes(3)[..30].to_vec();
    let stream = RawStream::new(std::io::Cursor::new(cut), "stdin".to_owned(), "3x2:mono16".parse().unwrap());
    let mut live = Live::new(ahead(stream), settings(Policy::Block)).unwrap();
    let seen = Seen::until_end(&mut live, |_| {});
    assert_eq!((seen.frames.len(), live.counters().incomplete), (2, 1));
    assert!(seen.gaps[0].to_string().contains("6 bytes of 12"), "{}", seen.gaps[0]);
}

#[test]
fn a_live_source_that_is_measured_frame_by_frame_states_what_was_lost() {
    use super::scripted::{Scripted, Step};
    use shadowgauge::source::live::IdWidth;
    let steps = vec![Step::Frame(0), Step::Frame(3), Step::Incomplete(4), Step::Away, Step::Frame(0)];
    let live = Live::new(Scripted::boxed(steps, IdWidth::Bits16), settings(Policy::Block)).unwrap();
    let frames = taken(live, "a camera".to_owned(), std::sync::Arc::default());
    let mut ahead = Ahead::new(frames, 1, None, Ahead::spare(1)).unwrap();
    let mut lost = Vec::new();
    while let Some(Ok((arrival, stored))) = ahead.next_frame() {
        assert!(stored.is_ok());
        lost.push((arrival.stem, arrival.lost));
    }
    let right = [("000000", 0), ("000003", 2), ("000005", 1)].map(|(stem, lost)| (stem.to_owned(), lost));
    assert_eq!(lost, right);
}
