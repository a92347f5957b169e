//! A recording (MCAP) as a live source.

use std::path::{Path, PathBuf};
use std::time::Duration;

use shadowgauge::frame::Frame;
use shadowgauge::source::live::{Event, IdWidth, Live, LiveSource as _, Policy, Produced, Producer, taken};
use shadowgauge::source::mcap::{Replay, Tap};

use super::conformance::{FRAMES, Factory, SOON, Seen, settings};
use super::scripted::{Scripted, Step};

/// A recording of so many frames whose every pixel is their number.
fn recorded(folder: &Path, frames: u64) -> PathBuf {
    let path = folder.join("day.mcap");
    let source = Scripted::boxed((0..frames).map(|n| Step::Frame(n + 1)), IdWidth::GigE16);
    let (mut tap, recorded) = Tap::begin(source, &path, true).unwrap();
    while let Produced::Frame(_) = tap.produce(None, Duration::ZERO) {}
    drop(tap);
    assert_eq!(recorded.finish().unwrap(), [frames, 0]);
    path
}

#[test]
fn a_recording_conforms() {
    let folder = tempfile::tempdir().unwrap();
    let path = recorded(folder.path(), FRAMES);
    let open = |frames: u64| -> Box<dyn Producer> {
        assert_eq!(frames, FRAMES);
        Box::new(Replay::open(&path).unwrap())
    };
    let is_frame = |frame: &Frame, number: u64| frame.view().get(3, 2) == Some(number as f32);
    Factory { open: &open, is_frame: &is_frame }.conforms();
}

/// A recording that breaks off does not return: it ends, with the reason where it has no frame.
#[test]
fn a_recording_that_is_cut_off_ends_and_stays_ended() {
    let folder = tempfile::tempdir().unwrap();
    let path = recorded(folder.path(), FRAMES);
    let bytes = std::fs::read(&path).unwrap();
    let cut = folder.path().join("cut.mcap");
    std::fs::write(&cut, &bytes[..bytes.len() / 2]).unwrap();
    let mut live = Live::new(Box::new(Replay::open(&cut).unwrap()), settings(Policy::Block)).unwrap();
    let seen = Seen::until_end(&mut live, |_| {});
    assert!(seen.frames.len() < FRAMES as usize && seen.gaps.is_empty(), "{seen:?}");
    let why = seen.failure.as_deref().unwrap_or("cut off");
    assert!(why.contains("cut off") && seen.lost.is_empty(), "{why}");
    live.start().unwrap();
    assert!(matches!(live.next_event(SOON), Event::End(None)));
}

#[test]
fn the_error_of_a_recording_names_its_file_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("no.mcap");
    std::fs::write(&path, b"no recording").unwrap();
    let live = Live::new(Box::new(Replay::open(&path).unwrap()), settings(Policy::Block)).unwrap();
    let mut frames = taken(live, path.display().to_string(), std::sync::Arc::default());
    let Some(Err(why)) = frames.next() else { panic!("an error") };
    assert_eq!(why.to_string().matches("no.mcap").count(), 1, "{why}");
}
