//! The simulated head as a live source.

use std::time::{Duration, Instant};

use shadowgauge::cell::{HeadPace, SimulatedHead, drawn_scene, scan_request};
use shadowgauge::frame::Frame;
use shadowgauge::job::Job;
use shadowgauge::render::{BackendChoice, Renderer};
use shadowgauge::source::live::{Clock, Event, Live, LiveSource as _, Policy, Producer, Provenance};

use super::conformance::{Factory, SOON, settings};

/// A small shaft of one field, with so many angles.
fn job(angles: u64) -> Job {
    let text = include_str!("../../support/small_render_job.toml");
    let mut job: Job = toml::from_str(text).unwrap();
    job.scan.angles = angles as usize;
    job
}

fn head(angles: u64, pace: HeadPace) -> Box<dyn Producer> {
    Box::new(SimulatedHead::new(job(angles), Renderer::new(BackendChoice::Cpu).unwrap(), pace).unwrap())
}

#[test]
fn the_simulated_head_conforms_and_its_frames_are_those_of_render() {
    let open = |frames: u64| head(frames, HeadPace::Scan);
    let (job, renderer) = (job(super::conformance::FRAMES), Renderer::new(BackendChoice::Cpu).unwrap());
    let (scene, plan) = (drawn_scene(&job).unwrap(), job.loop_job().scan_plan());
    let is_frame = |frame: &Frame, number: u64| {
        let request = scan_request(&job, &plan, number as usize);
        *frame == renderer.render(&scene, &request, None).unwrap()
    };
    Factory { open: &open, is_frame: &is_frame }.conforms();
}

#[test]
fn live_frames_come_scan_after_scan_no_faster_than_the_camera() {
    let period = Duration::from_secs_f64(job(2).camera.period_ms() * 1e-3);
    // frames are rendered ahead from here on
    let begun = Instant::now();
    let mut live = Live::new(head(2, HeadPace::Live), settings(Policy::Block)).unwrap();
    for number in 0..5 {
        let Event::Frame(frame) = live.next_event(SOON) else { panic!("a frame") };
        let meta = &frame.meta;
        assert_eq!(meta.sequence, number);
        assert_eq!(meta.device_t.unwrap().clock, Clock::Simulated);
        let angle = meta.angle_deg.unwrap();
        assert_eq!((angle.value, angle.provenance), (90.0 * (number % 2) as f64, Provenance::Simulated));
    }
    assert!(begun.elapsed() >= 4 * period);
}

/// Resident memory of this process, MiB.
#[cfg(target_os = "linux")]
fn resident_mib() -> f64 {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap();
    let pages: f64 = pages.split_whitespace().nth(1).unwrap().parse().unwrap();
    // pages of 4 KiB: on machines of larger ones the figures are too small by the same factor
    pages / 256.0
}

/// So many frames through the source: those that come, and by how much the memory grew after the
/// first hundredth of them, MiB.
#[cfg(target_os = "linux")]
fn through(frames: u64, policy: Policy) -> (u64, f64) {
    let mut live = Live::new(head(frames, HeadPace::Scan), settings(policy)).unwrap();
    let (mut come, mut next, mut first) = (0, 0, None);
    loop {
        match live.next_event(SOON) {
            Event::Frame(frame) => {
                assert_eq!(frame.meta.sequence, next, "a number is missing, and no gap states it");
                (come, next) = (come + 1, next + 1);
                frame.lease.give_back();
            }
            Event::Gap(gap) => {
                assert_eq!((gap.first, gap.lost + gap.incomplete), (next, 0), "{gap}");
                next += gap.dropped;
            }
            Event::End(None) => break,
            other => panic!("{other:?}"),
        }
        if next * 100 > frames {
            first.get_or_insert_with(resident_mib);
        }
    }
    let counters = live.counters();
    assert_eq!((next, counters.accounted(), counters.delivered), (frames, frames, come), "{counters:?}");
    (come, resident_mib() - first.unwrap())
}

/// With `Block` none is lost, with the others every frame is delivered or counted as dropped.
#[cfg(target_os = "linux")]
fn frames_are_accounted_for_in_flat_memory(frames: u64) {
    for policy in [Policy::Block, Policy::DropOldest, Policy::DropNewest] {
        let (come, grown_mib) = through(frames, policy);
        println!("{policy:?}: {come} of {frames} frames, memory grew by {grown_mib:.2} MiB");
        assert!(policy != Policy::Block || come == frames);
        // other tests run in this process meanwhile; a frame of 64 × 96 bytes that is kept would
        // make 12 MiB of the sample, and 6 GiB of a million
        assert!(frames < 100_000 || grown_mib < 8.0, "{grown_mib} MiB");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn two_thousand_frames_are_accounted_for_by_every_policy() {
    frames_are_accounted_for_in_flat_memory(2_000);
}

#[cfg(target_os = "linux")]
#[ignore = "minutes"]
#[test]
fn a_million_frames_are_accounted_for_by_every_policy() {
    frames_are_accounted_for_in_flat_memory(1_000_000);
}
