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
