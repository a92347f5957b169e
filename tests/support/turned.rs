//! A job turned by the closed loop in the simulated cell, all its passes.

use shadowgauge::cell::SimulatedCell;
use shadowgauge::closed_loop::{ClosedLoop, PassResult};
use shadowgauge::job::Job;
use shadowgauge::render::{BackendChoice, Renderer};

/// All passes of a job, rendered on the CPU.
pub fn turn(job: &Job) -> Vec<PassResult> {
    let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
    let cell = SimulatedCell::new(job, &renderer).unwrap();
    let mut turning = ClosedLoop::start(job.checked_loop().unwrap(), Box::new(cell), None).unwrap();
    let mut passes = Vec::new();
    while turning.next_pass().is_some() {
        passes.push(turning.run_pass(&mut |_, _| {}).unwrap());
    }
    passes
}
