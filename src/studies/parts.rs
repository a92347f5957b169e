//! A batch of parts, with and without learning from part to part: two nested loops, from pass to
//! pass within a part and from part to part.
//!
//! The chart shows the finished part's mean deviation from its aim, as an individuals chart (ISO
//! 7870-2): centre x̄, limits x̄ ± 3·R̄/d₂ with the mean moving range R̄ of two and d₂ = 1.128.
//! Capability is Ppk (ISO 22514-2) from the standard deviation over the batch.

use serde::Serialize;

use crate::cell::SimulatedCell;
use crate::closed_loop::{Calibrated, ClosedLoop, LoopError, PassResult};
use crate::control::{OnAlarm, PartEvent};
use crate::job::Job;
use crate::plan::Decision;
use crate::render::Renderer;

/// Expected range of two normal values over their standard deviation: 2/√π.
const D2: f64 = std::f64::consts::FRAC_2_SQRT_PI;

/// The batch.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Batch {
    /// Parts to turn.
    pub parts: u32,
    /// A new insert every so many parts; 0 for never.
    pub insert_every: u32,
    /// Parts (from 1) before which the machine cools down.
    pub cold_at: Vec<u32>,
}

impl Batch {
    /// The event before a part (from 1).
    pub(crate) fn event(&self, part: u32) -> PartEvent {
        if self.cold_at.contains(&part) {
            PartEvent::ColdStart
        } else if part > 1 && self.insert_every > 0 && (part - 1).is_multiple_of(self.insert_every) {
            PartEvent::InsertChanged
        } else {
            PartEvent::Continued
        }
    }
}

/// One pass of one part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct PartPass {
    /// Offsets were learnt from earlier parts.
    pub learning: bool,
    /// Part, from 1.
    pub part: u32,
    /// The event before the part.
    pub event: PartEvent,
    /// Pass, from 1.
    pub pass: u32,
    /// Mean over the stations of measured − aim, mm.
    pub measured_mean_mm: f64,
    /// Largest |measured − aim|, mm.
    pub measured_worst_mm: f64,
    /// Largest |true − aim|, mm.
    pub true_worst_mm: f64,
    /// Why offsets were held after this pass.
    pub held: String,
}

/// Individuals chart of the finished parts' mean deviations.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Individuals {
    /// x̄, mm.
    pub centre_mm: f64,
    /// 3·R̄/d₂, mm.
    pub limit_mm: f64,
    /// Parts (from 1) outside the limits.
    pub outside: Vec<u32>,
    /// Ppk against the part's tolerance, where there is one.
    pub ppk: Option<f64>,
}

/// One way of turning the batch.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct BatchSummary {
    /// Offsets were learnt from earlier parts.
    pub learning: bool,
    /// Mean over parts 2 and later of the largest true error after the first pass, mm.
    pub first_pass_mm: f64,
    /// Mean over all parts of the largest true error after the last pass, mm.
    pub last_pass_mm: f64,
    /// Worst part after the last pass, mm.
    pub last_pass_worst_mm: f64,
    /// The chart.
    pub chart: Individuals,
}

/// The study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct PartsStudy {
    /// The controller of the loop from pass to pass.
    pub controller: String,
    /// The batch.
    pub batch: Batch,
    /// Without and with learning.
    pub summaries: Vec<BatchSummary>,
    /// Every pass.
    pub passes: Vec<PartPass>,
}

/// Turns the batch twice, without and with `[control.parts]`; the blanks, the machine and the noise
/// are the same.
///
/// # Errors
/// Where the job does not fit together, the renderer or the gauge fails.
pub(crate) fn run(
    job: &Job,
    batch: &Batch,
    renderer: &Renderer,
    done: &mut dyn FnMut(bool, u32),
) -> Result<PartsStudy, LoopError> {
    let mut passes = Vec::new();
    let mut summaries = Vec::new();
    let mut calibration = None;
    for learning in [false, true] {
        let mut one = job.clone();
        one.control.parts.enabled = learning;
        one.control.guards.on_alarm = OnAlarm::GoOn;
        let turned = turn(&one, batch, renderer, &mut calibration, &mut |part| done(learning, part))?;
        summaries.push(summary(&one, learning, &turned));
        passes.extend(turned);
    }
    Ok(PartsStudy { controller: job.control.controller.to_string(), batch: batch.clone(), summaries, passes })
}

fn turn(
    job: &Job,
    batch: &Batch,
    renderer: &Renderer,
    calibration: &mut Option<Calibrated>,
    done: &mut dyn FnMut(u32),
) -> Result<Vec<PartPass>, LoopError> {
    let cell = SimulatedCell::new(job, renderer)?;
    let mut turning = ClosedLoop::start(job.checked_loop()?, Box::new(cell), calibration.take())?;
    *calibration = Some(turning.calibration().clone());
    let mut passes = Vec::new();
    for part in 1..=batch.parts {
        let event = batch.event(part);
        if part > 1 {
            turning.next_part(u64::from(part - 1), event)?;
        }
        while turning.next_pass().is_some() {
            let pass = turning.run_pass(&mut |_, _| {})?;
            passes.push(part_pass(job.control.parts.enabled, part, event, &pass));
        }
        done(part);
    }
    Ok(passes)
}

fn part_pass(learning: bool, part: u32, event: PartEvent, pass: &PassResult) -> PartPass {
    let aim = pass.plan.nominal_mm;
    let measured: Vec<f64> =
        pass.profile.stations.iter().filter_map(|s| s.reading.value()).map(|d| d.d_mm - aim).collect();
    let largest = |values: &mut dyn Iterator<Item = f64>| values.map(f64::abs).fold(0.0, f64::max);
    PartPass {
        learning,
        part,
        event,
        pass: pass.plan.pass,
        measured_mean_mm: measured.iter().sum::<f64>() / measured.len() as f64,
        measured_worst_mm: largest(&mut measured.iter().copied()),
        true_worst_mm: largest(&mut pass.truth_mm.iter().flatten().map(|d| d - aim)),
        held: match &pass.decision {
            Some(Decision::Held(reason)) => reason.to_string(),
            _ => String::new(),
        },
    }
}

fn summary(job: &Job, learning: bool, passes: &[PartPass]) -> BatchSummary {
    let last = passes.iter().map(|p| p.pass).max().unwrap_or(0);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let of = |pass: u32, from: u32| -> Vec<f64> {
        let chosen = passes.iter().filter(|p| p.pass == pass && p.part >= from);
        chosen.map(|p| p.true_worst_mm).collect()
    };
    let finished: Vec<f64> = passes.iter().filter(|p| p.pass == last).map(|p| p.measured_mean_mm).collect();
    let aim = job.part.target_mm(last);
    let limits = job
        .part
        .tolerance
        .filter(|_| last as usize == job.part.passes())
        .map(|t| (t.nominal_mm + t.lower_mm - aim, t.nominal_mm + t.upper_mm - aim));
    BatchSummary {
        learning,
        first_pass_mm: mean(&of(1, 2)),
        last_pass_mm: mean(&of(last, 1)),
        last_pass_worst_mm: of(last, 1).into_iter().fold(0.0, f64::max),
        chart: individuals(&finished, limits),
    }
}

/// The individuals chart of values in order, and Ppk against limits.
pub(crate) fn individuals(values_mm: &[f64], limits_mm: Option<(f64, f64)>) -> Individuals {
    let n = values_mm.len() as f64;
    let centre_mm = values_mm.iter().sum::<f64>() / n;
    let ranges = values_mm.windows(2).map(|w| (w[1] - w[0]).abs());
    let limit_mm = 3.0 * ranges.sum::<f64>() / (n - 1.0) / D2;
    let sd = (values_mm.iter().map(|v| (v - centre_mm).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    let outside = (1..).zip(values_mm).filter(|(_, v)| (**v - centre_mm).abs() > limit_mm).map(|(i, _)| i);
    Individuals {
        centre_mm,
        limit_mm,
        outside: outside.collect(),
        // One part, or parts without scatter, have no process capability.
        ppk: limits_mm
            .filter(|_| values_mm.len() > 1 && sd > 0.0)
            .map(|(low, high)| (high - centre_mm).min(centre_mm - low) / (3.0 * sd)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: ranges 1, 3, 2, mean 2; the sample standard deviation of 1, 2, 5, 3 is 1.7078.
    #[test]
    fn an_individuals_chart_by_hand() {
        let chart = individuals(&[1.0, 2.0, 5.0, 3.0], Some((-5.0, 8.0)));
        assert!((chart.centre_mm - 2.75).abs() < 1e-12);
        assert!((chart.limit_mm - 5.317_362).abs() < 1e-5);
        assert!((chart.ppk.unwrap_or(0.0) - 5.25 / (3.0 * 1.707_825)).abs() < 1e-5);
        assert_eq!(chart.outside, Vec::<u32>::new());
        assert_eq!(individuals(&[1.0], Some((-5.0, 8.0))).ppk, None);
        assert_eq!(individuals(&[1.0, 1.0], Some((-5.0, 8.0))).ppk, None);
        let mut steady: Vec<f64> = (0..40).map(|i| f64::from(i % 2)).collect();
        steady[20] = 9.0;
        assert_eq!(individuals(&steady, None).outside, [21]);
    }

    #[test]
    fn events_come_where_the_batch_says() {
        let batch = Batch { parts: 9, insert_every: 4, cold_at: vec![7] };
        let events: Vec<PartEvent> = (1..=9).map(|p| batch.event(p)).collect();
        assert_eq!(
            (events[0], events[4], events[6]),
            (PartEvent::Continued, PartEvent::InsertChanged, PartEvent::ColdStart)
        );
        assert_eq!(events.iter().filter(|e| **e != PartEvent::Continued).count(), 3);
    }
}
