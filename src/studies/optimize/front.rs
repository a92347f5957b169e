//! Time against size error: the paper's next step, by solving the problem at many limits of the
//! error.

use super::exact;
use super::problem::{Problem, Solution};

/// Relative gap to which the points of a front are proven.
const GAP: f64 = 1e-3;

/// The non-dominated points of time and size error, from the most exact to the fastest. Empty where
/// even the roughness limit cannot be satisfied. `done` is called after each search.
pub(crate) fn time_against_error(problem: &Problem, points: usize, done: &dyn Fn()) -> Vec<Solution> {
    let at_limit = |size_limit_mm: f64| {
        let found = exact::minimise(&problem.with_size_limit(size_limit_mm), GAP);
        done();
        found.map(|found| found.solution)
    };
    let Some(fastest) = at_limit(f64::MAX) else { return Vec::new() };
    let smallest = problem.size_error_mm(&problem.smallest_error(&problem.limits));
    let ratio = fastest.size_error_mm / smallest;
    let mut front: Vec<Solution> = Vec::new();
    for i in 0..points {
        // The limit at the exact end is widened by the rounding error, because its only point would
        // be excluded otherwise.
        let share = i as f64 / (points - 1).max(1) as f64;
        let limit = smallest * ratio.powf(share) * (1.0 + 1e-9);
        let Some(solution) = at_limit(limit) else { continue };
        if front.last().is_none_or(|last| solution.time_min < last.time_min * (1.0 - 1e-9)) {
            front.push(solution);
        }
    }
    front
}
